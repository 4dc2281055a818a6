"""Motions at places where they are known, and what is drawn of them against an integration by SciPy."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pipeline.analysis.attractors.places import search_place
from pipeline.analysis.motion.curves import APERIODIC, HIGHEST_ORDER, own_period
from pipeline.config.compose import compose
from pipeline.plan.numerics import balance_of, continuation_of, point_of, row_of, seeds_of
from solver import ImpactState, solve
from solver.contact.quantities import Slot
from solver.harmonic.steady import SolveStatus
from solver.stability import Instability
from solver.timedomain import AttractorKind as Kind
from tests.pipeline.analysis.motion.places import MITER, PUBLISHED, SPUR, found_at, plan_of

CHAOS = (0.64, 0.3, *PUBLISHED)
TORUS = (0.6, 0.2, *PUBLISHED)
DOUBLE = (0.7367924528, 0.4661016949, *PUBLISHED)
FOURFOLD = (1.3622641509, 0.1949152542, *PUBLISHED)
PAIR = (1.8, 0.1, *SPUR, "solver=hb", "solver.order=8")


def by_label(found):
    return {motion.label: motion for motion in found.attractors}


def extremes(motion):
    return motion.quantities.lowest, motion.quantities.highest


def test_the_spur_pair_has_2t_beside_1t():
    found = found_at(*PAIR)
    motions = by_label(found)
    assert set(motions) == {"1T/0", "2T/1"} and found.others == ()
    single, double = motions["1T/0"], motions["2T/1"]
    assert extremes(double) == pytest.approx((0.90521, 1.28247), abs=1e-5)
    assert extremes(single) == pytest.approx((1.06818, 1.11706), abs=1e-5)
    lines = dict(zip(double.curves.orders.tolist(), double.curves.amplitudes.tolist(), strict=True))
    assert (lines[0.5], lines[1.0]) == pytest.approx((0.18730, 0.02828), abs=2e-5)
    assert min(lines) == 0.5 and max(lines) == HIGHEST_ORDER and min(single.curves.orders) == 1.0
    assert single.of_map.number == 1 and double.of_map is None
    assert single.hits + double.hits == found.starts == 20 and min(single.hits, double.hits) > 4
    assert [motion.name for motion in found.attractors] == ["A", "B"]


def test_further_attractors_that_the_map_does_not_count():
    found = by_label(found_at(*DOUBLE))
    assert extremes(found["2T/1"]) == pytest.approx((-0.4646, 2.9243), abs=2e-4)
    assert found["1T/1"].of_map is not None and found["2T/1"].of_map is None
    found = by_label(found_at(*FOURFOLD))
    assert set(found) == {"1T/0", "4T/1"}
    assert extremes(found["1T/0"]) == pytest.approx((1.0159, 2.2727), abs=1e-4)
    assert extremes(found["4T/1"]) == pytest.approx((0.5608, 3.1351), abs=1e-4)
    assert len(found["4T/1"].curves.points) == 4 and len(found["1T/0"].curves.points) == 1


def test_at_0_62_there_is_an_aperiodic_motion_alone():
    """Every motion of the first-order map there is false; docs/physics.md, section 8."""
    found = found_at(0.62, 0.2, *PUBLISHED)
    (motion,) = found.attractors
    assert motion.kind in (Kind.QUASI_PERIODIC, Kind.CHAOTIC) and motion.hits == found.starts
    assert motion.of_map is None and math.isnan(motion.multiplier)
    assert [one.label for one in found.others] == ["1T/0", "1T/1", "1T/1"]
    assert [one.stable for one in found.others] == [True, False, True]
    assert [one.leads for one in found.others] == ["A", None, "A"]


def test_at_0_64_the_map_is_wrong_about_its_only_motion():
    found = found_at(*CHAOS)
    (motion,), (of_map,) = found.attractors, found.others
    assert motion.label == "chaotic/2" and motion.lyapunov > 5.0 * motion.lyapunov_error > 0.0
    assert of_map.stable and of_map.instability is Instability.PERIOD_DOUBLING and of_map.multiplier > 1.0
    assert of_map.leads == "A"


def test_a_motion_of_the_map_is_in_the_card_of_the_attractor_that_it_is():
    found = found_at(*TORUS)
    first, second = found.attractors
    assert first.label == "1T/0" and second.kind is Kind.QUASI_PERIODIC and second.of_map is None
    assert [first.of_map.number, *(one.number for one in found.others)] == [1, 2, 3]
    # The map's largest motion is stable for the balance; integration from it falls to the lower branch.
    assert found.others[1].stable and found.others[1].leads == "A"
    assert not found.others[0].stable and found.others[0].leads is None


def test_motions_of_the_map_are_solutions_of_the_balance():
    found = found_at(*PAIR)
    of_map = found.attractors[0].of_map or found.attractors[1].of_map
    displacement = of_map.curves.displacement
    near = solve(found.model, np.append(_harmonics(displacement, 1), np.zeros(14)), found.omega)
    assert near.status is SolveStatus.CONVERGED
    np.testing.assert_allclose(_harmonics(displacement, 8), near.motion, atol=1e-8)
    # It starts where a mesh period does.
    assert of_map.curves.points[0] == pytest.approx([displacement[0], of_map.curves.speed[0]], abs=1e-15)


def _harmonics(values, order):
    lines = np.fft.rfft(values)[: order + 1] * 2.0 / values.size
    return np.concatenate([[0.5 * lines[0].real], np.stack([lines[1:].real, -lines[1:].imag], axis=1).ravel()])


@pytest.mark.parametrize("label", ["1T/0", "2T/1"])
def test_the_curves_are_those_of_scipy(label):
    """docs/physics.md, section 9, in its own words: one equation of lambda."""
    curves = by_label(found_at(*PAIR))[label].curves
    omega, times = 1.8, curves.periods * 2.0 * np.pi / 1.8

    def stiffness(time):
        return 1.0 - sum(a * np.cos(l * omega * time) for l, a in ((1, 0.2), (2, 0.1), (3, 0.05)))

    def force(value):
        return np.where(value > 1.0, value - 1.0, np.where(value < -1.0, value + 1.0, 0.0))

    def field(time, state):
        load = 0.1 + sum(
            a * (l * omega) ** 2 * np.cos(l * omega * time) for l, a in ((1, 0.01), (2, 0.004), (3, 0.002))
        )
        return [state[1], load - 0.1 * state[1] - stiffness(time) * force(state[0])]

    start = [curves.displacement[0], curves.speed[0]]
    found = solve_ivp(
        field, (0.0, times[-1]), start, method="DOP853", rtol=1e-11, atol=1e-12, t_eval=times, max_step=0.02
    )
    np.testing.assert_allclose(curves.displacement, found.y[0], atol=2e-8)
    np.testing.assert_allclose(curves.speed, found.y[1], atol=2e-8)
    np.testing.assert_allclose(curves.force, stiffness(times) * force(found.y[0]), atol=2e-8)


@pytest.mark.parametrize("place", [CHAOS, TORUS, DOUBLE, FOURFOLD, PAIR])
def test_spectra_have_the_energy_of_the_motions(place):
    """Parseval: exact of lines; a Hann window spreads a line over three bins, 3/2 of its energy."""
    found = found_at(*place)
    for motion in found.attractors:
        energy = np.sum(motion.curves.amplitudes**2) / 2.0
        if motion.curves.repeats:
            assert math.sqrt(energy) == pytest.approx(motion.quantities.rms, rel=2e-5)
        else:
            assert math.sqrt(energy / 1.5) == pytest.approx(motion.quantities.rms, rel=0.05)
        if motion.of_map is not None:
            rms = math.sqrt(np.sum(motion.of_map.curves.amplitudes**2) / 2.0)
            assert rms == pytest.approx(motion.of_map.quantities.rms, rel=1e-9)


@pytest.mark.parametrize("place", [CHAOS, TORUS, DOUBLE, FOURFOLD, (0.9, 0.2, *MITER)])
def test_the_curves_have_the_quantities_of_the_motions(place):
    found = found_at(*place)
    assert found.attractors
    for motion in (*found.attractors, *found.others, *(a.of_map for a in found.attractors if a.of_map)):
        curves, told = motion.curves, motion.quantities
        # Over 48 of 128 periods a motion that does not repeat is not everywhere.
        room = 0.02 if curves.repeats is None else 5e-4
        assert told.lowest - 1e-9 <= curves.displacement.min() <= told.lowest + (told.highest - told.lowest) * room
        assert told.highest - (told.highest - told.lowest) * room <= curves.displacement.max() <= told.highest + 1e-9
        largest = curves.force.max() / found.static_force
        assert told.dynamic_factor * (1.0 - room) <= largest <= told.dynamic_factor * (1.0 + 1e-9)
        free = np.mean(np.abs(curves.displacement) <= found.model.b)
        assert free == pytest.approx(told.contact_loss, abs=0.02 if curves.repeats is None else 0.005)


def test_paths_are_smooth_and_poincare_points_lie_on_them():
    for place in (CHAOS, TORUS, DOUBLE):
        found = found_at(*place)
        of_map = (*found.others, *(motion.of_map for motion in found.attractors if motion.of_map))
        for motion in (*found.attractors, *of_map):
            curves = motion.curves
            step = 2.0 * np.pi / found.omega * (curves.periods[1] - curves.periods[0])
            slope = (curves.displacement[2:] - curves.displacement[:-2]) / (2.0 * step)
            np.testing.assert_allclose(slope, curves.speed[1:-1], atol=5e-3)
            if curves.repeats is None:
                assert len(curves.points) >= 1000
                low, high = motion.quantities.lowest, motion.quantities.highest
                inside = (curves.points[:, 0] > low - 0.05) & (curves.points[:, 0] < high + 0.05)
                assert np.all(inside) and np.ptp(curves.points[:, 1]) > 0.5
            else:
                path = np.stack([curves.displacement, curves.speed], axis=1)
                assert all(np.min(np.linalg.norm(path - point, axis=1)) < 1e-12 for point in curves.points)


def test_poincare_points_of_a_torus_are_on_a_line():
    """Boxes of a grid that hold points: four times as many on a grid four times as fine."""
    points = next(m for m in found_at(*TORUS).attractors if m.kind is Kind.QUASI_PERIODIC).curves.points
    unit = (points - points.min(axis=0)) / np.ptp(points, axis=0)
    filled = [len(np.unique(np.minimum(unit * size, size - 1).astype(int), axis=0)) for size in (16, 64)]
    assert math.log(filled[1] / filled[0]) / math.log(4.0) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize("place", [CHAOS, TORUS, PAIR])
def test_numbers_of_attractors_are_those_of_the_search(place):
    """The search and `motion_quantities` read the same motion."""
    found, overrides = found_at(*place), place[2:]
    plan = plan_of(*overrides)
    model, omega = point_of(plan, place[1], place[0])
    options = compose(["attractors.starts=20", *overrides]).config.attractors
    row = search_place(model, omega, np.empty((1, 0, 3)), 1, options)
    for motion in found.attractors:
        slots = np.flatnonzero(row.kind[0] == motion.kind)
        apart = [abs(float(row.rms[0, slot]) - motion.quantities.rms) for slot in slots]
        assert min(apart) < (0.05 if motion.curves.repeats is None else 1e-6)


def test_order_5_has_the_motions_of_the_stored_row():
    overrides = (*PUBLISHED, "solver=hb")
    plan = plan_of(*overrides)
    x = float(plan.sweep.values[7])
    found, settings = found_at(x, 0.25, *overrides), plan.solver
    row = row_of(plan, 0.25, balance_of(settings), continuation_of(settings), seeds_of(settings))
    of_map = sorted(
        (*found.others, *(a.of_map for a in found.attractors if a.of_map)), key=lambda motion: motion.number
    )
    assert len(of_map) == row.n_solutions[7] >= 1
    for motion, unknowns in zip(of_map, row.motions[7], strict=False):
        np.testing.assert_allclose(_harmonics(motion.curves.displacement, 5), unknowns, atol=1e-6)
        assert motion.label == f"1T/{ImpactState(int(row.impact[7, motion.number - 1])).symbol}"


def test_a_balance_of_two_periods_tells_what_repeats_after_one():
    found = found_at(*TORUS, "solver=hb", "solver.order=3", "solver.period=2")
    of_map = (*found.others, *(motion.of_map for motion in found.attractors if motion.of_map))
    single = found_at(*TORUS, "solver=hb", "solver.order=3")
    expected = (*single.others, *(motion.of_map for motion in single.attractors if motion.of_map))
    assert len(of_map) >= len(expected) > 1
    for motion in expected:
        (same,) = [one for one in of_map if one.label == motion.label and one.number == motion.number]
        assert same.curves.repeats == 1 and same.multiplier == pytest.approx(motion.multiplier, rel=1e-6)
        np.testing.assert_allclose(same.curves.displacement, motion.curves.displacement, atol=1e-6)


def test_own_periods():
    two = np.array([1.0, 0.2, 0.0, 0.3, 0.1, 0.0, 0.0, 0.05, 0.0])
    assert own_period(two, 2)[1] == 2 and own_period(two, 1)[1] == 1
    two[1] = 1e-12
    motion, repeats = own_period(two, 2)
    assert repeats == 1 and motion.tolist() == [1.0, 0.3, 0.1, 0.05, 0.0]
    # Of six periods with harmonics 4 and 6 there are three.
    six = np.zeros(15)
    six[[0, 7, 11]] = 1.0, 0.2, 0.1
    motion, repeats = own_period(six, 6)
    assert repeats == 3 and motion.tolist() == [1.0, 0.0, 0.0, 0.2, 0.0, 0.1, 0.0]
    assert own_period(np.array([1.0, 0.0, 0.0]), 4)[1] == 1


def test_the_same_place_gives_the_same_numbers():
    found_at.cache_clear()
    one = found_at(*CHAOS)
    found_at.cache_clear()
    other = found_at(*CHAOS)
    for first, second in zip(one.attractors, other.attractors, strict=True):
        assert first.quantities == second.quantities and first.hits == second.hits
        np.testing.assert_array_equal(first.curves.displacement, second.curves.displacement)


def test_without_random_starts_shares_are_not_told():
    found = found_at(*TORUS, "attractors.starts=0")
    assert found.starts == 0 and found.attractors and all(motion.hits == 0 for motion in found.attractors)


def test_random_starts_may_be_drawn_in_a_box():
    """All from next to the torus, of which the whole box has a tenth."""
    torus = next(m for m in found_at(*TORUS).attractors if m.kind is Kind.QUASI_PERIODIC).curves.points
    (x, y), near = torus.mean(axis=0), 0.02
    box = f"[[{x - near},{x + near}],[{y - near},{y + near}]]"
    found = found_at(*TORUS, f"attractors.box={box}")
    assert found.starts == 20 and sum(motion.hits for motion in found.attractors) == 20


def test_every_quantity_is_told():
    for motion in found_at(*CHAOS).attractors:
        assert all(math.isfinite(getattr(motion.quantities, slot.name.lower())) for slot in Slot)
    assert APERIODIC >= 64
