"""Period doublings and Neimark-Sackers on branches, against time integration and the raster."""

import dataclasses

import numpy as np
import pytest

from solver import Continuation, EndReason, Event, Model, ProvenSeeds, sweep_row
from solver.harmonic.describing_function import DescribingFunction
from solver.harmonic.galerkin import Galerkin
from solver.model.packing import packed
from solver.model.parameters import F_PM, kind_start
from solver.stability import Instability, motion_multipliers
from solver.stability.bifurcations import locate_bifurcations, with_bifurcations
from tests.conftest import antiphase, consistent, published
from tests.solver.stability.floquet_reference import multipliers
from tests.solver.stability.rows import branch

COUPLING = 0.93969262
#: The first has a period doubling in permanent contact (docs/physics.md, section 8), the second a Neimark-Sacker.
PARAMETRIC = consistent(rotation_coupling=COUPLING, variation_translation=0.0)
ANTIPHASE = antiphase(rotation_coupling=COUPLING)
KINDS = (Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER)
BALANCES = [DescribingFunction(), Galerkin(1), Galerkin(5)]


def located(model, balance):
    problem, curve = branch(model, balance)
    return problem, curve, with_bifurcations(balance, problem, curve, Continuation())


def at(curve, event):
    return curve.points[curve.event == event]


def gap(values, target):
    return np.min(np.abs(values - target))


def test_multipliers_by_integration():
    """At order 15 the multiplier is -1 at period doublings and a pair lies on the unit circle at the Neimark-Sacker."""
    balance = Galerkin(15)
    _, _, found = located(PARAMETRIC, balance)
    doublings = at(found, Event.PERIOD_DOUBLING)
    np.testing.assert_allclose(np.sort(doublings[:, -1]), [1.17547, 1.246548], atol=2e-6)
    for y in doublings:
        assert gap(multipliers(PARAMETRIC, y[-1], y[:-1]), -1.0) < 1e-6
    _, _, found = located(ANTIPHASE, balance)
    (y,) = at(found, Event.NEIMARK_SACKER)
    assert y[-1] == pytest.approx(1.904, abs=5e-4)
    pair = multipliers(ANTIPHASE, y[-1], y[:-1])
    assert gap(np.abs(pair[np.abs(pair.imag) > 0.1]), 1.0) < 1e-6


@pytest.mark.parametrize("balance", BALANCES, ids=repr)
def test_located_points_have_a_multiplier_on_the_circle_by_an_independent_integration(balance):
    model = published()
    _, _, found = located(model, balance)
    doublings, tori = at(found, Event.PERIOD_DOUBLING), at(found, Event.NEIMARK_SACKER)
    assert len(doublings) + len(tori) > 0
    for y in doublings:
        assert gap(multipliers(model, y[-1], y[:-1]), -1.0) < 1e-5
    for y in tori:
        values = multipliers(model, y[-1], y[:-1])
        assert gap(np.abs(values[np.abs(values.imag) > 1e-4]), 1.0) < 1e-5


@pytest.mark.parametrize("balance", BALANCES, ids=repr)
def test_nothing_else_of_the_branch_changes(balance):
    _, curve, found = located(published(), balance)
    new = np.isin(found.event, (Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER))
    assert np.any(new)
    before = ~np.isin(curve.event, (Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER))
    for name in ("points", "tangents", "arclength", "stable", "event"):
        np.testing.assert_array_equal(getattr(found, name)[~new], getattr(curve, name)[before])
    assert found.ends == curve.ends
    assert np.all(np.diff(found.arclength) > 0.0)
    np.testing.assert_allclose(np.linalg.norm(found.tangents, axis=1), 1.0, rtol=1e-12)
    inside = np.flatnonzero(new)
    for i in inside:
        # p stays monotone, and the tangent points along the branch.
        before, here, after = found.points[i - 1 : i + 2, -1]
        assert (here - before) * (after - here) > 0.0
        assert found.tangents[i] @ found.tangents[i - 1] > 0.5
        neighbours = [j for j in (i - 1, i + 1) if found.event[j] != Event.FOLD]
        assert found.stable[i] in found.stable[neighbours]


def test_locating_twice_changes_nothing():
    problem, _, found = located(published(), Galerkin(1))
    again = with_bifurcations(Galerkin(1), problem, found, Continuation())
    for name in ("points", "tangents", "arclength", "stable", "event"):
        np.testing.assert_array_equal(getattr(again, name), getattr(found, name))


def test_points_are_located_to_rounding():
    """A branch traced with other steps has its bifurcations at the same places."""
    for balance in BALANCES:
        problem, curve = branch(published(), balance)
        other = Continuation(largest_step=0.05, largest_angle=0.1)
        _, fine = branch(published(), balance, other)
        first, second = (with_bifurcations(balance, problem, c, other) for c in (curve, fine))
        for event in (Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER):
            ours, theirs = at(first, event), at(second, event)
            assert ours.shape == theirs.shape
            np.testing.assert_allclose(
                ours[np.argsort(ours[:, -1])], theirs[np.argsort(theirs[:, -1])], rtol=0, atol=1e-9
            )


def test_a_branch_of_one_point_is_left_alone():
    balance = Galerkin(1)
    problem, curve = branch(published(), balance)
    short = Continuation(max_points=2).trace(problem, curve.points[0], 0.3, 2.0, -1)
    assert with_bifurcations(balance, problem, short, Continuation()).ends[1] is EndReason.ITERATION_LIMIT


def between_events(row):
    """For every cell that surely lies on a branch: whether it is unstable by -1 or a pair, and how often the branch has
    changed that before, in the order of the branch."""
    for curve in row.curves:
        here, counts = [], []
        for i in range(len(curve.points) - 1):
            low, high = sorted(curve.points[i : i + 2, -1])
            for column in np.flatnonzero((row.grid > low) & (row.grid < high)):
                share = (row.grid[column] - curve.points[i, -1]) / (curve.points[i + 1, -1] - curve.points[i, -1])
                place = curve.points[i, :-1] + share * (curve.points[i + 1, :-1] - curve.points[i, :-1])
                gaps = np.nan_to_num(np.max(np.abs(row.motions[column] - place), axis=1), nan=np.inf)
                nearest = int(np.argmin(gaps))
                if gaps[nearest] < 0.02 and np.sum(gaps < 0.2) == 1:
                    here.append(row.instability[column, nearest])
                    counts.append(int(np.sum(curve.event[: i + 1] == Event.PERIOD_DOUBLING)))
        yield np.array(here), np.array(counts), curve


GEARS = [
    (published(), "omega", None),
    (published(f_e=0.4), "omega", None),
    (antiphase(), "omega", None),
    (antiphase(f_e=0.4, alpha=0.4), "omega", None),
    (ANTIPHASE, "omega", None),
    (PARAMETRIC, "omega", None),
    (published(), "f_e", 0.62),
    (antiphase(), "f_e", 1.5),
    (antiphase(), "alpha", 0.55),
    (published(), "b", 0.6),
]


@pytest.mark.parametrize("model, axis, omega", GEARS)
def test_cells_agree_with_their_branch(model, axis, omega):
    """Between two located period doublings every cell is one, or none is; coarse and fine rasters alike."""
    low, high = {"omega": (0.3, 2.0), "f_e": (0.01, 0.6), "alpha": (0.0, 0.5), "b": (0.05, 1.5)}[axis]
    for columns in (61, 301):
        row = sweep_row(model, axis, np.linspace(low, high, columns), omega=omega, seeds=ProvenSeeds(columns=25))
        assert row.notes == ()
        for kinds, passed, curve in between_events(row):
            known = kinds != Instability.UNDECIDED
            doubled = kinds == Instability.PERIOD_DOUBLING
            for count in np.unique(passed):
                inside = doubled[(passed == count) & known]
                assert np.all(inside == inside[0]) if inside.size else True, (count, curve.points[:, -1])


def test_what_the_raster_knows_is_found_between_points_of_the_branch():
    """A narrow tongue of parametric resonance between two points of a coarse branch: only cells show it."""
    model = consistent(rotation_coupling=COUPLING, variation_translation=0.0, alpha=0.12)
    grid = np.linspace(1.1, 1.35, 400)
    fine = sweep_row(model, "omega", grid)
    tongue = np.sort(np.concatenate([at(curve, Event.PERIOD_DOUBLING)[:, -1] for curve in fine.curves]))
    assert tongue.size == 2 and tongue[1] - tongue[0] < 0.1
    wide = Continuation(parameter_step=1.0, largest_step=5.0, first_step=5.0, largest_angle=3.0)
    coarse = sweep_row(model, "omega", grid, continuation=wide)
    found = np.sort(np.concatenate([at(curve, Event.PERIOD_DOUBLING)[:, -1] for curve in coarse.curves]))
    np.testing.assert_allclose(found, tongue, rtol=0, atol=1e-9)


def test_a_bifurcation_next_to_a_grid_value_is_located_on_the_branch():
    """It lies between a cell and the place that the cubic gives it on the branch: alpha from one such row."""
    model = antiphase(alpha=0.48930966756846683)
    row = sweep_row(model, "omega", np.linspace(0.3, 2.0, 400))
    doublings = np.concatenate([at(curve, Event.PERIOD_DOUBLING) for curve in row.curves])
    near = doublings[np.abs(doublings[:, -1] - 0.525815) < 1e-5]
    assert len(near) == 1 and row.notes == ()
    np.testing.assert_allclose(near[0], [0.59888418, -1.69801358, 1.01203479, 0.52581533], rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    "model, event",
    [
        (published(f_e=0.21637660669359293), Event.NEIMARK_SACKER),
        (published(xi_mesh=0.02952820237797956), Event.PERIOD_DOUBLING),
        (antiphase(b=0.3098673557843914), Event.PERIOD_DOUBLING),
        (antiphase(f_pm=0.6807589805344487), Event.PERIOD_DOUBLING),
    ],
)
def test_two_between_neighbouring_cells_are_seen(model, event):
    """A multiplier that passes and comes back between two of 400 columns, where those of 4000 show it."""
    found = []
    for columns in (400, 4000):
        row = sweep_row(model, "omega", np.linspace(0.3, 2.0, columns))
        found.append(np.concatenate([at(curve, event) for curve in row.curves]))
    coarse, fine = (points[np.lexsort(points.T)] for points in found)
    column = np.searchsorted(np.linspace(0.3, 2.0, 400), np.sort(fine[:, -1]))
    assert np.any(column[1:] == column[:-1])
    np.testing.assert_allclose(coarse, fine, rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    ("model", "grid"),
    [
        # A pair passes the circle, meets on the real axis, and one of the two passes +1, within one step.
        (published(b=0.8157788944723618), np.linspace(0.05, 2.0, 400)),
        # A multiplier passes -1 and comes back where det(M + I) falls steeply and rises again.
        (antiphase(b=0.3169120095394401), np.linspace(0.3, 2.0, 150)),
        # Rounding brackets the same event twice.
        (published(xi_mesh=0.0423210988549282), np.linspace(0.3, 2.0, 150)),
        (published(xi_support=0.004379435600792549), np.linspace(0.3, 2.0, 150)),
    ],
)
def test_bifurcations_do_not_depend_on_the_steps_of_the_branch(model, grid):
    found = []
    for continuation in (Continuation(), Continuation(largest_step=0.02, largest_angle=0.03)):
        row = sweep_row(model, "omega", grid, continuation=continuation)
        found.append([np.concatenate([at(curve, event) for curve in row.curves]) for event in KINDS])
    for coarse, fine in zip(*found, strict=True):
        assert len(coarse) == len(fine)
        coarse, fine = (points[np.lexsort(points.T)] for points in (coarse, fine))
        np.testing.assert_allclose(coarse, fine, rtol=0, atol=1e-8)


@pytest.mark.parametrize("make", [published, antiphase])
def test_all_bifurcations_of_many_rows_are_located(make):
    """Rows with several hundred cells, any of which may lie next to one."""
    draw, counts = np.random.default_rng(4), dict.fromkeys(KINDS, 0)
    for _ in range(25):
        model = make(alpha=draw.uniform(0.05, 0.5), f_e=draw.uniform(0.1, 0.5))
        row = sweep_row(model, "omega", np.linspace(0.3, 2.0, 400))
        assert row.notes == ()
        for curve in row.curves:
            for kind in counts:
                for y in at(curve, kind):
                    values = motion_multipliers(model, y[-1], y[:-1])
                    if kind is Event.PERIOD_DOUBLING:
                        assert gap(values, -1.0) < 1e-9
                    else:
                        assert gap(np.abs(values[values.imag != 0.0]), 1.0) < 1e-9
                    counts[kind] += 1
    assert counts[Event.PERIOD_DOUBLING] > 25 and counts[Event.NEIMARK_SACKER] > 25


def test_an_undamped_gear_passes_nothing_and_ends():
    """Without damping multipliers lie on the circle; the row must not hang, nor find what rounding makes."""
    model = Model(
        b=0.9283, alpha=0.0, alpha_harmonics=((0.1225, 1.9314),), f_e=0.01224, f_e_phase=1.5032, f_pm=0.23192,
        kappa=(0.43063, 0.43063), xi_mesh=0.0, xi_translation=(0.0, 0.0),
        xi_support=(0.0415, 0.0095, 0.0284, 0.0792, 0.0661, 0.0420), k_support=(0.437, 7.30, 0.177, 9.16, 5.27, 3.54),
        pitch_cone_angle=5.91, pressure_angle=35.2, translation_coupling=0.0, rotation_coupling="geometric",
        variation_translation=1.0, variation_rotation=0.0,
    )  # fmt: skip
    row = sweep_row(model, "omega", np.linspace(0.05, 2.5, 33))
    kinds = row.instability[row.stable >= 0]
    assert np.all((kinds == Instability.UNDECIDED) | (kinds == Instability.FOLD) | (kinds == Instability.CONTRADICTORY))
    assert not any(np.any(curve.event == Event.NEIMARK_SACKER) for curve in row.curves)
    assert row.notes == ()


def test_what_cannot_be_located_is_a_note():
    """A corrector that refuses everything: what is bracketed is left out and said."""
    balance = Galerkin(1)
    problem, curve = branch(published(), balance)
    parameters = packed(published(), "omega", None, 1, 1)
    assert np.any(locate_bifurcations(parameters, problem, curve, Continuation())[0].event >= Event.PERIOD_DOUBLING)
    theta = problem.parameters.copy()
    theta[kind_start(theta) + F_PM] = np.nan
    spoiled = dataclasses.replace(problem, parameters=theta)
    found, notes = locate_bifurcations(parameters, spoiled, curve, Continuation())
    assert not np.any(found.event >= Event.PERIOD_DOUBLING)
    assert len(notes) == 1 and "cannot be located" in notes[0]
