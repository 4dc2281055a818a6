"""Which kernels stages call, so that they are compiled before anything waits for them or counts their time."""

import functools
from collections.abc import Iterable

from solver.kernels.warm import kernels_of, warm

__all__ = ["NEEDED", "kernels_for", "ready_for_attractors", "ready_for_rows"]

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
        "solver.harmonic.galerkin.residual_and_jacobian",
        "solver.stability.bifurcations._bifurcations",
        "solver.continuation.arclength.trace",
        "solver.stability.assessment._assess",
        "solver.continuation.on_curve._crossings",
        "solver.harmonic.quantities.fill_quantities",
        "solver.harmonic.galerkin._linear_degree",
        "solver.harmonic.galerkin.test_functions",
        "solver.harmonic.galerkin._extremes",
        "solver.harmonic.contact_extrema.contacts",
        "solver.continuation.correctors._newton",
        "solver.continuation.correctors.correct_all",
    ),
}

_ATTRACTORS = (
    "solver.timedomain.cell_search.seek",
    "solver.timedomain.cell_search.recall",
    "solver.timedomain.quantities.gauge_at",
    "solver.timedomain.row_systems",
)

#: A row followed up and down.
_RUNS = (
    "solver.timedomain.cell_search.seek",
    "solver.timedomain.cell_search.pursue",
    "solver.timedomain.quantities.gauge_at",
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
    "solver.flow.zone_flows._tabulated",
)

#: By stage and balance, those that take longest first.
NEEDED = {
    "sweep": _ROWS,
    "boundaries": {
        "describing_function": (
            "solver.boundaries.first_order._bifurcation_balance",
            "solver.boundaries.first_order._fold_balance",
            "solver.boundaries.first_order._grazing_balance",
            "solver.boundaries.first_order._test_functions",
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
    "spectrum": dict.fromkeys(_ROWS, (*_RUNS, "solver.timedomain.trajectory", "solver.flow.zone_flows._tabulated")),
    "debug": _ROWS,
}
#: Whatever is asked of a place: its row, its motions, and boundaries of margins.
NEEDED["explore"] = {
    balance: tuple(
        dict.fromkeys(name for stage in ("sweep", "motion", "boundaries") for name in NEEDED[stage][balance])
    )
    for balance in _ROWS
}


def kernels_for(stages: Iterable[str], balance: str) -> list[str]:
    """Names of what stages need, in the order to compile them in."""
    return list(dict.fromkeys(name for stage in stages for name in NEEDED.get(stage, {}).get(balance, ())))


@functools.cache
def ready_for_rows(balance: str) -> None:
    """Compile or load what rows need, once in this process: a row's time is its own."""
    warm(kernels_of(kernels_for(["sweep"], balance)))


@functools.cache
def ready_for_attractors() -> None:
    """Compile or load what attractors need, once in this process."""
    warm(kernels_of(_ATTRACTORS))
