"""Which kernels stages call, so that they are compiled before anything waits for them or counts their time."""

import functools
from collections.abc import Iterable

from pipeline.plan.kinds import BEVEL
from solver.kernels.warm import kernels_of, warm

__all__ = [
    "NEEDED",
    "kernels_for",
    "kernels_for_isolated",
    "ready_for_attractors",
    "ready_for_isolated",
    "ready_for_rows",
]

_ROWS = {
    "describing_function": (
        "solver.enumeration.certificates.enumerate_points",
        "solver.enumeration.coefficients.enclose_gear",
        "solver.stability.bifurcations._bifurcations",
        "solver.continuation.arclength.trace",
        "solver.stability.assessment._assess",
        "solver.continuation.on_curve._crossings",
        "solver.harmonic.quantities.fill_quantities",
        "solver.harmonic.describing_function.residual_and_jacobian",
        "solver.harmonic.describing_function.test_functions",
        "solver.continuation.setup.no_contacts",
        "solver.continuation.correctors._newton",
        "solver.continuation.correctors.correct_all",
    ),
    "galerkin": (
        "solver.enumeration.certificates.enumerate_points",
        "solver.enumeration.coefficients.enclose_gear",
        "solver.harmonic.galerkin_rows.residual_and_jacobian",
        "solver.stability.bifurcations._bifurcations",
        "solver.continuation.arclength.trace",
        "solver.stability.assessment._assess",
        "solver.continuation.on_curve._crossings",
        "solver.harmonic.quantities.fill_quantities",
        "solver.harmonic.galerkin._linear_degree",
        "solver.harmonic.galerkin_rows.test_functions",
        "solver.harmonic.galerkin._extremes",
        "solver.harmonic.contact_extrema.contacts",
        "solver.continuation.correctors._newton",
        "solver.continuation.correctors.correct_all",
    ),
}

_ATTRACTORS = (
    "solver.timedomain.cell_search.seek",
    "solver.timedomain.cell_search.recall",
    "solver.timedomain.gauge.gauge_at",
    "solver.timedomain.row_systems",
)

#: Branches from attractors: rows of order H, and the harmonics of motions.
_ISOLATED = (*_ROWS["galerkin"], "solver.timedomain.poincare._measure")

#: A row followed up and down.
_RUNS = (
    "solver.timedomain.cell_search.seek",
    "solver.timedomain.cell_search.pursue",
    "solver.timedomain.gauge.gauge_at",
    "solver.timedomain.row_systems",
)

#: A single place: what motions and quantities are read with. Of first order its solutions are enumerated, of higher
#: orders its row is solved; shooting tells apart supports of gears that differ.
_MOTION = (
    *_ATTRACTORS,
    "solver.timedomain.quantities._quantities",
    "solver.timedomain.trajectory",
    "solver.timedomain.poincare._advance",
    "solver.timedomain.poincare._measure",
    "solver.timedomain.shooting",
    "solver.harmonic.quantities",
    "solver.flow.tabulation._tabulated",
)

#: By stage and balance, those that take longest first.
NEEDED = {
    "sweep": _ROWS,
    "boundaries": {
        "describing_function": (
            "solver.boundaries.first_order.gear_rows",
            "solver.boundaries.first_order.gear_tests",
            "solver.boundaries.incidence._distances",
        ),
        "galerkin": ("solver.boundaries.harmonic_rows.harmonic_rows", "solver.boundaries.incidence._distances"),
    },
    "attractors": dict.fromkeys(_ROWS, _ATTRACTORS),
    "motion": {
        "describing_function": (
            "solver.enumeration.certificates.enumerate_point",
            "solver.enumeration.certificates.workspace",
            "solver.enumeration.coefficients.enclose_gear",
            "solver.stability.assessment._assess",
            *_MOTION,
        ),
        "galerkin": (*_ROWS["galerkin"], *_MOTION),
    },
    "diagram": {balance: (*_RUNS, *rows) for balance, rows in _ROWS.items()},
    "spectrum": dict.fromkeys(_ROWS, (*_RUNS, "solver.timedomain.trajectory", "solver.flow.tabulation._tabulated")),
    "debug": _ROWS,
}
#: Whatever is asked of a place: its row, its motions, and boundaries of margins.
NEEDED["explore"] = {
    balance: tuple(
        dict.fromkeys(name for stage in ("sweep", "motion", "boundaries") for name in NEEDED[stage][balance])
    )
    for balance in _ROWS
}


#: What is called in place of a bevel pair's kernel where another system is solved.
_OF_SYSTEMS = {
    "solver.enumeration.coefficients.enclose_gear": "solver.enumeration.system_coefficients.enclose_system",
    "solver.harmonic.quantities.fill_quantities": "solver.harmonic.quantities.fill_system_quantities",
    "solver.harmonic.describing_function.residual_and_jacobian": (
        "solver.harmonic.describing_function.system_residual_and_jacobian"
    ),
    "solver.harmonic.describing_function.test_functions": "solver.harmonic.describing_function.system_test_functions",
    "solver.boundaries.first_order.gear_rows": "solver.boundaries.first_order.system_rows",
    "solver.boundaries.first_order.gear_tests": "solver.boundaries.first_order.system_tests",
}


def kernels_for(stages: Iterable[str], balance: str, kind: str = BEVEL.name) -> list[str]:
    """Names of what stages need for a kind of system, in the order to compile them in."""
    return _of_kind((name for stage in stages for name in NEEDED.get(stage, {}).get(balance, ())), kind)


def kernels_for_isolated(kind: str = BEVEL.name) -> list[str]:
    """The same of what the stage attractors needs besides, where branches are asked for."""
    return _of_kind(_ISOLATED, kind)


def _of_kind(names: Iterable[str], kind: str) -> list[str]:
    names = list(dict.fromkeys(names))
    if kind == BEVEL.name:
        return names
    # A stop may be so stiff that contacts are looked for along its branches.
    contacts = ["solver.harmonic.contact_extrema.contacts"] if "solver.continuation.arclength.trace" in names else []
    return list(dict.fromkeys([*(_OF_SYSTEMS.get(name, name) for name in names), *contacts]))


@functools.cache
def ready_for_rows(balance: str, kind: str = BEVEL.name) -> None:
    """Compile or load what rows need, once in this process: a row's time is its own."""
    warm(kernels_of(kernels_for(["sweep"], balance, kind)))


@functools.cache
def ready_for_attractors() -> None:
    """Compile or load what attractors need, once in this process."""
    warm(kernels_of(_ATTRACTORS))


@functools.cache
def ready_for_isolated(kind: str = BEVEL.name) -> None:
    """Compile or load what branches from attractors need, once in this process."""
    warm(kernels_of(kernels_for_isolated(kind)))
