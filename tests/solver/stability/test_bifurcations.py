"""Period doublings and Neimark-Sackers on branches, against dense eigenproblems and time integration."""

import numpy as np
import pytest

from solver import Continuation, EndReason, Event, Model, sweep_row
from solver.continuation.on_curve import curve_crossings
from solver.harmonic.describing_function import DescribingFunction
from solver.harmonic.galerkin import Galerkin
from solver.stability.bifurcations import BranchSwitchError, critical_frequencies, doubled, with_bifurcations
from solver.stability.instability import Instability
from tests.conftest import antiphase, consistent, published
from tests.solver.stability.floquet_reference import hill_exponents, multipliers
from tests.solver.stability.rows import branch
from tests.solver.strategies import random_model

COUPLING = 0.93969262
#: The first has a period doubling in permanent contact (docs/physics.md, section 8), the second a Neimark-Sacker.
PARAMETRIC = consistent(rotation_coupling=COUPLING, variation_translation=0.0)
ANTIPHASE = antiphase(rotation_coupling=COUPLING)
BALANCES = [DescribingFunction(), Galerkin(1), Galerkin(5)]


def located(model, balance):
    problem, curve = branch(model, balance)
    return problem, curve, with_bifurcations(balance, problem, curve, Continuation())


def at(curve, event):
    return curve.points[curve.event == event]


def gap(values, target):
    return np.min(np.abs(values - target))


@pytest.mark.parametrize("balance", BALANCES, ids=repr)
@pytest.mark.parametrize("model", [PARAMETRIC, ANTIPHASE, published()], ids=["parametric", "antiphase", "published"])
def test_located_points_are_exponents_of_the_dense_hill_problem(model, balance):
    problem, _, found = located(model, balance)
    truncated, H = isinstance(balance, DescribingFunction), balance.harmonics
    half = np.arange(-H, H)
    for y in at(found, Event.PERIOD_DOUBLING):
        exponents = hill_exponents(model, y[-1], y[:-1], half, truncated)
        assert gap(exponents, 0.5j * y[-1]) < 1e-7
    for y in at(found, Event.NEIMARK_SACKER):
        shares = critical_frequencies(balance, problem, y)
        assert shares.size == 1
        window = half if shares[0] > 0.25 else np.arange(-H, H + 1)
        assert gap(hill_exponents(model, y[-1], y[:-1], window, truncated), 1j * shares[0] * y[-1]) < 1e-7


@pytest.mark.parametrize("balance", BALANCES, ids=repr)
def test_a_branch_between_its_bifurcations_keeps_its_number_of_unstable_exponents(balance):
    """Nothing is missed: the dense problem's count changes exactly where a fold or a located point lies."""
    model = published()
    problem, _, found = located(model, balance)
    truncated, H = isinstance(balance, DescribingFunction), balance.harmonics
    changing = np.isin(found.event, (Event.FOLD, Event.PERIOD_DOUBLING, Event.NEIMARK_SACKER))
    whole, half = np.arange(-H, H + 1), np.arange(-H, H)
    counts = []
    for y in found.points[::3]:
        omega = y[-1]
        near = [s for s in hill_exponents(model, omega, y[:-1], whole, truncated) if abs(s.imag) <= 0.25 * omega]
        far = [
            s for s in hill_exponents(model, omega, y[:-1], half, truncated) if 0.25 * omega < s.imag <= 0.75 * omega
        ]
        counts.append(sum(s.real > 0.0 for s in near) + sum(s.real > 0.0 for s in far))
    passed = np.cumsum(changing)[::3]
    for i in range(1, len(counts)):
        if passed[i] == passed[i - 1] and not changing[3 * i] and not changing[3 * i - 3]:
            assert counts[i] == counts[i - 1]


def test_multipliers_by_integration():
    """At order 15 the multiplier is -1 at period doublings and a pair lies on the unit circle at the Neimark-Sacker."""
    balance = Galerkin(15)
    _, _, found = located(PARAMETRIC, balance)
    doublings = at(found, Event.PERIOD_DOUBLING)
    np.testing.assert_allclose(np.sort(doublings[:, -1]), [1.17547, 1.246548], atol=2e-6)
    for y in doublings:
        assert gap(multipliers(PARAMETRIC, y[-1], y[:-1]), -1.0) < 1e-6
    problem, _, found = located(ANTIPHASE, balance)
    (y,) = at(found, Event.NEIMARK_SACKER)
    assert y[-1] == pytest.approx(1.904, abs=5e-4)
    (share,) = critical_frequencies(balance, problem, y)
    assert gap(multipliers(ANTIPHASE, y[-1], y[:-1]), np.exp(2j * np.pi * share)) < 1e-3
    model = published()
    _, _, found = located(model, balance)
    upper = [y for y in at(found, Event.PERIOD_DOUBLING) if y[-1] > 1.0]
    assert len(upper) == 2
    for y in upper:
        assert gap(multipliers(model, y[-1], y[:-1]), -1.0) < 2e-2


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


def test_the_doubled_branch_of_parametric_resonance():
    """docs/physics.md, section 8: 2T for Omega = 1.05-1.24, at 1.2 of half-order amplitude 0.7888 and first 0.106."""
    balance = Galerkin(5)
    problem, _, found = located(PARAMETRIC, balance)
    start = max(at(found, Event.PERIOD_DOUBLING), key=lambda y: y[-1])
    wide, doubled_problem, y = doubled(balance, problem, start)
    assert (wide.order, wide.period) == (5, 2)
    assert np.hypot(*y[1:3]) > 0.01 and abs(y[-1] - start[-1]) < 1e-3
    curve = Continuation().trace_both_ways(doubled_problem, y, 0.3, 2.0)
    assert curve.points[:, -1].min() == pytest.approx(1.046, abs=1e-3)
    assert curve.points[:, -1].max() == pytest.approx(start[-1], abs=1e-6)
    _, motions, _ = curve_crossings(doubled_problem, curve, np.array([1.2]), Continuation())
    (motion,) = motions
    assert np.hypot(*motion[1:3]) == pytest.approx(0.7888, abs=5e-4)
    assert np.hypot(*motion[3:5]) == pytest.approx(0.106, abs=1e-3)


def test_switching_fails_with_a_reason_where_there_is_nothing_to_switch_to():
    balance = Galerkin(3)
    problem, curve = branch(published(), balance)
    with pytest.raises(BranchSwitchError, match="no motion of twice the period"):
        doubled(balance, problem, curve.points[0], amplitude=30.0)


def test_a_branch_of_one_point_is_left_alone():
    balance = Galerkin(1)
    problem, curve = branch(published(), balance)
    short = Continuation(max_points=2).trace(problem, curve.points[0], 0.3, 2.0, -1)
    assert with_bifurcations(balance, problem, short, Continuation()).ends[1] is EndReason.ITERATION_LIMIT


@pytest.mark.parametrize("phase", [2.236387990691039, 2.981850654254719, 3.514323985371633])
def test_an_exponent_close_to_the_axis_is_seen_on_its_side(phase):
    """At a point of the branch just behind the crossing the determinant loops around 0 in a tenth of a node's distance.

    The dense eigenproblem at the columns, which knows nothing of the loop, calls the motion unstable up to the
    crossing.
    """
    model = Model(
        b=1.0,
        alpha=5.0 / 27.0,
        f_e=0.2,
        f_pm=0.19902860269972236,
        kappa=(0.5323735471386268, 0.2293301433827931),
        xi_mesh=0.06,
        xi_translation=(0.03194241282831761, 0.013759808602967586),
        xi_support=(*3 * (0.016820720007360623,), *3 * (0.01449169723711069,)),
        k_support=(
            0.563358250940346,
            0.4225186882052595,
            0.563358250940346,
            0.30334675050634013,
            0.2123427253544381,
            0.30334675050634013,
        ),
        pitch_cone_angle=18.43494882292201,
        pressure_angle=20.0,
        translation_coupling="geometric",
        rotation_coupling="geometric",
        variation_translation=1.0,
        variation_rotation=1.0,
        alpha_phase=phase,
        alpha_harmonics=((2.5 / 63.0, np.pi / 6.0),),
        f_e_harmonics=((0.05, np.pi / 2.0),),
    )
    row = sweep_row(model, "omega", np.linspace(0.05, 2.0, 160))
    (curve,) = row.curves
    crossings = at(curve, Event.NEIMARK_SACKER)[:, -1]
    (crossing,) = crossings[np.abs(crossings - 1.8) < 0.1]
    behind = np.searchsorted(row.grid, crossing)
    assert row.instability[behind - 1, 0] == Instability.NEIMARK_SACKER != row.instability[behind, 0]


def test_an_exponent_that_bends_on_its_way_across_the_axis_is_located():
    """Between two points of this branch it moves by less than it leaves the straight line between its ends."""
    balance, model = DescribingFunction(), random_model(206020430, f_pm=0.99964, b=1.99922)
    row = sweep_row(model, "omega", np.linspace(0.05, 2.0, 14))
    (y,) = [y for curve in row.curves for y in at(curve, Event.NEIMARK_SACKER) if abs(y[-1] - 0.65) < 0.01]
    shares = critical_frequencies(balance, balance.problem(model, "omega", 0.05, 2.0), y)
    assert np.min(np.abs(shares - 0.125)) < 1e-3
    assert gap(hill_exponents(model, y[-1], y[:-1], np.arange(-1, 2), True), 1j * shares[0] * y[-1]) < 1e-7
