"""The spur pair: mesh stiffness and clearance together."""

import numpy as np

from solver import ContactSystem, Galerkin, solve
from solver.timedomain import AttractorKind, find_attractors, isolated_branches, shoot
from tests.cases.case import Case, Comparison, Number
from tests.cases.curves import SUBHARMONIC, folds, galerkin_row

__all__ = ["CASE", "SPUR"]

#: The spur pair of docs/physics.md, section 9.
SPUR = ContactSystem(
    [[1.0]],
    [[0.1]],
    [[0.0]],
    [1.0],
    [1.0],
    1.0,
    1.0,
    [1.0],
    ((-0.2, 0.0), (-0.1, 0.0), (-0.05, 0.0)),
    [[0.1]],
    [[0.0], [0.01], [0.004], [0.002]],
)
#: Factors on the load of the plane, and its frequencies.
_LOADS, _FREQUENCIES = np.linspace(0.4, 3.0, 27), np.linspace(0.3, 2.3, 81)


def _motion() -> list[float]:
    balance = Galerkin(25)
    motion = solve(SPUR, [1.1, 0.03, 0.0], 0.5, balance=balance).motion
    return [motion[0], *np.hypot(motion[1:7:2], motion[2:7:2]), *map(float, balance.extremes(motion))]


def _two_motions() -> list[float]:
    row = find_attractors(SPUR, "omega", [1.8])
    assert sorted(row.kind[0][row.kind[0] > 0]) == [AttractorKind.PERIOD_1, AttractorKind.PERIOD_2]
    once, twice = (int(np.flatnonzero(row.kind[0] == kind)[0]) for kind in (1, 2))
    orbit = shoot(SPUR, 1.8, row.state[0, twice], 2, order=2)
    harmonics = np.abs(orbit.harmonics)
    return [harmonics[1], harmonics[2], orbit.lowest, orbit.highest, row.lowest[0, once], row.highest[0, once]]


def _plane(loads) -> list[np.ndarray]:
    """Kinds of attractors (X, A) over the frequency, for every load."""
    return [find_attractors(SPUR.at("mean_load", load), "omega", _FREQUENCIES).kind for load in loads]


def _outside_of_branches() -> list[int]:
    """Cells of the plane with motions of two periods that lie outside the branches of two periods of their row."""
    outside, loads = 0, _LOADS[::4]
    for load, kinds in zip(loads, _plane(loads), strict=True):
        row = galerkin_row(SPUR.at("mean_load", load), 0.3, 2.3, 9, 12)
        branches = [b.curve.points[:, -1] for b in isolated_branches(row, _FREQUENCIES[::4]).branches if b.period == 2]
        inside = [(omega.min() <= _FREQUENCIES) & (omega.max() >= _FREQUENCIES) for omega in branches]
        covered = np.logical_or.reduce(inside, axis=0, initial=False)
        outside += int(np.count_nonzero(np.any(kinds == AttractorKind.PERIOD_2, axis=1) & ~covered))
    return [outside]


def _draw(axes) -> None:
    shades = np.ones((_LOADS.size, _FREQUENCIES.size, 3))
    for i, kinds in enumerate(_plane(_LOADS)):
        several = np.count_nonzero(kinds, axis=1) > 1
        subharmonic = np.any((kinds >= AttractorKind.PERIOD_2) & (kinds <= AttractorKind.CHAOTIC), axis=1)
        shades[i, several & ~subharmonic] = 0.82
        shades[i, subharmonic] = (0.62, 0.73, 0.87)
        shades[i, subharmonic & ~np.any(kinds == AttractorKind.PERIOD_1, axis=1)] = (0.25, 0.4, 0.63)
    step_x, step_y = np.diff(_FREQUENCIES)[0], np.diff(_LOADS)[0]
    extent = (
        _FREQUENCIES[0] - step_x / 2,
        _FREQUENCIES[-1] + step_x / 2,
        _LOADS[0] - step_y / 2,
        _LOADS[-1] + step_y / 2,
    )
    axes.imshow(shades, origin="lower", aspect="auto", extent=extent, interpolation="nearest")
    for load in _LOADS[::2]:
        row = galerkin_row(SPUR.at("mean_load", load), 0.3, 2.3, 9, 12)
        ends = folds(*row.curves)
        axes.plot(ends, np.full(len(ends), load), "k.", markersize=4)
        for branch in isolated_branches(row, _FREQUENCIES[::4]).branches:
            ends = folds(branch.curve)
            axes.plot(ends, np.full(len(ends), load), ".", color=SUBHARMONIC, markersize=4)
    axes.set(xlabel="Ω", ylabel="load, as a factor of 0.1")


CASE = Case(
    title="A spur pair: mesh stiffness and clearance",
    source="A. Kahraman, R. Singh, Interactions between time-varying mesh stiffness and clearance non-linearities in a"
    " geared system, Journal of Sound and Vibration 146 (1991) 135–156, for the model.",
    equations=r"$$x'' + 0.1\,x' + \Bigl[1 - \sum_l a_l\cos l\Omega t\Bigr] f(x) = 0.1 + \sum_l e_l\,(l\Omega)^2"
    r"\cos l\Omega t,$$ gap 1, $a = (0.2, 0.1, 0.05)$, $e = (0.01, 0.004, 0.002)$.",
    comparisons=(
        Comparison(
            "Harmonic balance of order 25 to 63 ([physics,"
            " section 9](physics.md#9-what-coexists-with-the-motions-of-a-map)).",
            "Harmonic balance of order 25.",
            tuple(Number(r"fold $\Omega$", value, 2e-6) for value in (0.437007, 0.455324, 0.598153, 0.835838)),
            lambda: folds(*galerkin_row(SPUR, 0.3, 1.2, 25, 12).curves),
        ),
        Comparison(
            "Two integrators, the motion at 0.5.",
            "Harmonic balance of order 25 from a rough guess.",
            tuple(
                Number(what, value, 2e-5 if "x" in what else 1e-5)
                for what, value in (
                    ("mean", 1.09286),
                    ("first harmonic", 0.03002),
                    ("second harmonic", 0.12401),
                    ("third harmonic", 0.00442),
                    ("lowest $x$", 0.95104),
                    ("highest $x$", 1.24239),
                )
            ),
            _motion,
        ),
        Comparison(
            "Two integrators, the two motions at 1.8.",
            "Attractors from rest and from random states, and shooting.",
            tuple(
                Number(what, value, 1e-5)
                for what, value in (
                    ("two periods: half order", 0.18730),
                    ("two periods: first order", 0.02828),
                    ("two periods: lowest $x$", 0.90521),
                    ("two periods: highest $x$", 1.28247),
                    ("one period: lowest $x$", 1.06818),
                    ("one period: highest $x$", 1.11706),
                )
            ),
            _two_motions,
        ),
        Comparison(
            "In the plane of frequency and load motions of two periods lie on branches of two periods.",
            "Attractors of seven rows of the plane, and the branches found from every fourth cell of them.",
            (Number("cells outside of all branches", 0, 0),),
            _outside_of_branches,
        ),
    ),
    draw=_draw,
    caption="Frequency and load. White: one motion; grey: several of the forcing period; light blue: motions of several"
    " periods beside it; dark blue: these alone. Dots are folds at order 9: black of one period, blue of several.",
)
