"""Attractors on cases where they are known, and their continuation along rows and across them."""

import dataclasses
from collections import Counter

import numpy as np
import pytest

from solver import ImpactState, ParameterError, gear_system, sweep_row
from solver.contact.impact import impact_of_range
from solver.model.contact_system import ContactSystem
from solver.timedomain import (
    AttractorKind,
    AttractorSearch,
    SeenFrom,
    continue_attractors,
    find_attractors,
    measure,
    settle,
    shoot,
)
from solver.timedomain.quantities import motion_quantities
from tests.conftest import antiphase, consistent, published
from tests.solver.timedomain.systems import mathieu, oscillator

COS_20 = 0.93969262
ONE, TWO, FOUR = AttractorKind.PERIOD_1, AttractorKind.PERIOD_2, AttractorKind.PERIOD_4
TORUS, CHAOS = AttractorKind.QUASI_PERIODIC, AttractorKind.CHAOTIC

SPUR = consistent(
    translation_coupling=0.0,
    rotation_coupling=1.0,
    xi_mesh=0.05,
    alpha_phase=np.pi,
    alpha_harmonics=((0.1, np.pi), (0.05, np.pi)),
    f_e=0.01,
    f_e_harmonics=((0.004, 0.0), (0.002, 0.0)),
    f_pm=0.1,
)
DOUBLED = consistent(rotation_coupling=COS_20, variation_translation=0.0)

#: x'' + 0.04 x' + 0.25 x + 0.75 f(x) = 1.2 + sin Omega t, gaps 4.
LARGE_GAP = ContactSystem([[1.0]], [[0.04]], [[0.25]], [1.0], [0.75], 4.0, 4.0, load=[[1.2], [-1j]])


def at(system, omega, starts=40, **settings):
    """What random starts find at one place: kinds, and the row."""
    row = find_attractors(system, "omega", [omega], search=AttractorSearch(starts=starts, **settings))
    assert not row.overflow[0] and not row.failures[0] and row.starts[0] == row.hits[0].sum() == starts
    return [AttractorKind(int(kind)) for kind in row.kind[0] if kind], row


@pytest.mark.parametrize(
    "omega, kinds", [(0.58, {ONE, TORUS}), (0.60, {ONE, TORUS}), (0.62, {TORUS}), (1.2265, {ONE, TWO})]
)
def test_upper_branches_of_the_published_pair(omega, kinds):
    """Direct integration and shooting of two other programs (docs/physics.md, section 8)."""
    found, row = at(published(), omega, 100)
    assert set(found) == kinds and len(found) == len(kinds)
    if ONE in kinds:
        assert row.impact[0, found.index(ONE)] == ImpactState.PERMANENT
    for kind in kinds - {ONE}:
        assert row.impact[0, found.index(kind)] == ImpactState.SINGLE_SIDED
    if omega in (0.58, 0.60):
        assert 0.8 < row.hits[0, found.index(ONE)] / 100 < 1.0
    if omega == 1.2265:
        state = row.state[0, found.index(TWO)]
        half = measure(gear_system(published()), omega, state, 2, divisor=2).harmonics[1]
        assert abs(half) == pytest.approx(0.418, abs=5e-4)


@pytest.mark.parametrize(
    "f_e, omega, kinds, lowest, highest",
    [
        (0.1949152542, 1.3622641509, [ONE, FOUR], [1.0159, 0.5608], [2.2727, 3.1351]),
        (0.4661016949, 0.7367924528, [TWO, ONE], [-0.4646, 0.3865], [2.9243, 2.9044]),
    ],
)
def test_motions_that_coexist_with_a_right_label(f_e, omega, kinds, lowest, highest):
    """Found by two integrators (docs/physics.md, section 9); the last 1T motion by this one alone."""
    found, row = at(published(f_e=f_e), omega, 200)
    assert sorted(found) == sorted(kinds)
    for kind, low, high in zip(kinds, lowest, highest, strict=True):
        slot = found.index(kind)
        assert (row.lowest[0, slot], row.highest[0, slot]) == pytest.approx((low, high), abs=2e-4)
        orbit = shoot(gear_system(published(f_e=f_e)), omega, row.state[0, slot], int(kind))
        assert orbit.stable and orbit.minimal_period == kind
        rate = row.lyapunov[0, slot] * 2.0 * np.pi / omega * int(kind)
        assert rate == pytest.approx(np.log(orbit.largest_multiplier), abs=1e-6)


@pytest.mark.parametrize("omega, kinds", [(1.1, {ONE, TWO}), (1.2, {TWO}), (1.23, {TWO}), (1.25, {ONE})])
def test_principal_parametric_resonance(omega, kinds):
    found, row = at(DOUBLED, omega)
    assert set(found) == kinds
    if omega == 1.2:
        measured = measure(gear_system(DOUBLED), omega, row.state[0, 0], 2, divisor=2)
        assert abs(measured.harmonics[1]) == pytest.approx(0.7888, abs=1e-4)
        assert row.amplitude[0, 0] == pytest.approx(0.106, abs=5e-4)


def test_teeth_of_the_spur_pair_part_where_first_order_says_they_do_not():
    (kind,), row = at(SPUR, 0.5)
    assert kind is ONE and row.impact[0, 0] == ImpactState.SINGLE_SIDED
    assert row.mean[0, 0] == pytest.approx(1.09286, abs=1e-5)
    assert row.amplitude[0, 0] == pytest.approx(0.03002, abs=1e-5)
    assert (row.lowest[0, 0], row.highest[0, 0]) == pytest.approx((0.95104, 1.24239), abs=6e-6)


def test_two_motions_of_the_spur_pair_and_their_basins():
    found, row = at(SPUR, 1.8)
    assert sorted(found) == [ONE, TWO]
    for kind, ends in ((ONE, (1.06818, 1.11706)), (TWO, (0.90521, 1.28247))):
        slot = found.index(kind)
        assert (row.lowest[0, slot], row.highest[0, slot]) == pytest.approx(ends, abs=1e-5)
    model = SPUR.replace(f_pm=0.1061538)
    found, row = at(model, 1.8056604)
    two = found.index(TWO)
    assert (row.lowest[0, two], row.highest[0, two]) == pytest.approx((0.9021, 1.2978), abs=1e-4)
    rng = np.random.default_rng(0)
    states = np.column_stack([rng.uniform(0.5, 2.0, 2000), rng.uniform(-1.0, 1.0, 2000)])
    _, slots = settle(model, 1.8056604, states, known=row)
    # About 46 %; the standard error is 1.1 %.
    assert np.mean(slots == two) == pytest.approx(0.46, abs=0.035)


def test_supports_that_the_contact_does_not_reach_take_nothing_from_a_basin():
    shares = []
    for supports in ({}, dict(xi_support=0.2, k_support=0.3)):
        found, row = at(SPUR.replace(**supports), 1.8, 1000)
        assert row.state.shape[2] == 2
        shares.append(row.hits[0, found.index(TWO)])
    assert shares[0] == shares[1] and 0.4 < shares[0] / 1000 < 0.6


@pytest.mark.parametrize("omega, kind", [(1.2, ONE), (1.4, TWO), (1.6, TWO), (1.8, TWO), (1.95, TWO), (2.1, ONE)])
def test_a_large_gap_doubles_the_period(omega, kind):
    found, _ = at(LARGE_GAP, omega)
    assert found == [kind]


def test_two_motions_beside_a_large_gap():
    found, row = at(LARGE_GAP, 0.85, 100)
    assert found == [ONE, ONE]
    assert sorted(row.amplitude[0, :2]) == pytest.approx([4.088844, 16.551485], abs=1e-6)
    np.testing.assert_allclose(np.exp(row.lyapunov[0, :2] * 2.0 * np.pi / 0.85), 0.862569, atol=1e-6)


def test_torus_and_chaos_of_the_antiphase_pair():
    model = antiphase(rotation_coupling=COS_20)
    found, row = at(model, 1.93, 100)
    assert TORUS in found and CHAOS in found
    torus, chaos = found.index(TORUS), found.index(CHAOS)
    # It surrounds the orbit that lost its stability.
    assert row.mean[0, torus] == pytest.approx(1.4558, abs=5e-3)
    assert row.amplitude[0, torus] == pytest.approx(0.6075, abs=1e-2)
    assert abs(row.lyapunov[0, torus]) < 1e-3
    assert row.impact[0, chaos] == ImpactState.DOUBLE_SIDED
    assert row.lyapunov[0, chaos] == pytest.approx(0.0233, abs=0.008)
    assert row.lyapunov[0, chaos] > 4.0 * row.lyapunov_error[0, chaos]


def test_parametric_resonance_is_unbounded():
    found, row = at(mathieu(1.0, 0.2), 2.0, 5)
    assert found == [AttractorKind.UNBOUNDED] and np.isnan(row.mean[0, 0]) and row.impact[0, 0] == -1


def test_slow_convergence_is_certain_where_the_system_is_linear():
    # Damping 1e-5: 1e4 periods to lose half the deviation.
    omega = 0.7
    row, slots = settle(oscillator(1e-5), omega, [[0.5 + 1.0 / (1.0 - omega**2) + 0.2, 0.0]])
    assert slots.tolist() == [0] and row.kind[0, 0] == ONE
    assert row.lyapunov[0, 0] == pytest.approx(-1e-5, rel=1e-6)
    assert row.amplitude[0, 0] == pytest.approx(1.0 / (1.0 - omega**2), abs=1e-7)


def test_a_motion_locked_to_a_long_period_is_no_torus():
    """18T beside the resonance of half the mesh frequency: every eighteenth section is the same."""
    found, row = at(published(f_e=0.2262857), 0.7195, 8)
    assert found == [AttractorKind.PERIOD_LONGER] and row.lyapunov[0, 0] < 0.0
    orbit = measure(gear_system(published(f_e=0.2262857)), 0.7195, row.state[0, 0], 18)
    np.testing.assert_allclose(orbit.state, row.state[0, 0], rtol=0, atol=2e-5)


def test_impact_states_with_two_different_gaps_or_one():
    cases = np.array([(1.1, 2.0), (-2.9, 1.1), (-3.1, 1.1), (-2.9, 0.9), (-3.1, 0.9), (-4.0, -3.1), (np.nan, 1.0)]).T
    assert impact_of_range(*cases, -3.0, 1.0).tolist() == [0, 1, 2, 3, 4, 5, -1]
    assert impact_of_range(*cases, -np.inf, 1.0).tolist() == [0, 1, 1, 3, 3, 3, -1]


COLUMNS = np.linspace(1.30, 1.42, 41)


@pytest.fixture(scope="module")
def row():
    """Published pair, f_e = 0.195: 1T from above, 4T and a torus beside it, 2T below."""
    model = published(f_e=0.1949152542)
    found = sweep_row(model, "omega", COLUMNS)
    cosine, sine = found.amplitude * np.cos(found.phase), found.amplitude * np.sin(found.phase)
    motions = np.where((found.stable == 1)[..., None], np.stack([found.mean, cosine, sine], axis=-1), np.nan)
    return model, motions, find_attractors(model, "omega", COLUMNS, motions=motions, search=AttractorSearch(starts=2))


def test_an_attractor_is_followed_over_its_whole_domain(row):
    """Two random starts a cell miss some; with its neighbours' attractors every cell has what 60 starts find."""
    model, _, found = row
    kinds = [Counter(found.kind[i][found.kind[i] > 0].tolist()) for i in range(COLUMNS.size)]
    for i in range(0, COLUMNS.size, 4):
        many, _ = at(model, COLUMNS[i], 60)
        missing = Counter(map(int, many)) - kinds[i]
        assert not missing, (COLUMNS[i], missing, kinds[i])
    brought = (found.seen & (SeenFrom.REST | SeenFrom.MOTION | SeenFrom.RANDOM)) == 0
    assert np.any(brought & (found.kind > 0))


def test_links_lead_to_attractors_and_runs_follow_them(row):
    _, _, found = row
    for links, step in ((found.upwards, 1), (found.downwards, -1)):
        for i, slot in np.argwhere(links >= 0):
            assert found.kind[i + step, links[i, slot]] > 0
    assert np.all(found.upwards[-1] == -1) and np.all(found.downwards[0] == -1)
    settled = (found.kind > 0) & (found.kind <= CHAOS)
    for bit, links, order in (
        (SeenFrom.UPWARDS, found.upwards, range(COLUMNS.size)),
        (SeenFrom.DOWNWARDS, found.downwards, range(COLUMNS.size - 1, -1, -1)),
    ):
        reached = set(np.flatnonzero(settled[order[0]]).tolist())
        for before, i in zip([None, *order], order, strict=False):
            if before is not None:
                reached = {int(links[before, slot]) for slot in reached} - {-1}
            assert reached == set(np.flatnonzero(found.seen[i] & bit).tolist())
    # 4T is born in a fold and dies in one: no run along the row meets it.
    runs = int(SeenFrom.UPWARDS | SeenFrom.DOWNWARDS)
    assert np.any(found.kind == FOUR) and not np.any(found.seen[found.kind == FOUR] & runs)


def test_runs_up_and_down_between_two_folds_meet_different_motions():
    columns = np.linspace(1.2, 1.45, 26)
    found = find_attractors(antiphase(), "omega", columns, search=AttractorSearch(starts=1))
    runs = found.seen & int(SeenFrom.UPWARDS | SeenFrom.DOWNWARDS)
    parted = np.any(runs == SeenFrom.UPWARDS, axis=1) & np.any(runs == SeenFrom.DOWNWARDS, axis=1)
    assert np.any(parted) and not parted[0] and not parted[-1]
    for i in np.flatnonzero(parted):
        up, down = (found.amplitude[i][runs[i] == bit].max() for bit in (SeenFrom.UPWARDS, SeenFrom.DOWNWARDS))
        assert up != pytest.approx(down, abs=0.05)


def test_a_row_is_the_same_every_time_and_a_stored_one_goes_on(row):
    model, motions, found = row
    search = AttractorSearch(starts=2)
    again = find_attractors(model, "omega", COLUMNS, motions=motions, search=search)
    nothing = np.empty(0, np.int64), np.empty(0, np.int64), np.empty((0, 4))
    kept = continue_attractors(model, "omega", COLUMNS, found, *nothing, round=1, search=search)
    for field in dataclasses.fields(found):
        for other in (again, kept):
            one, two = getattr(found, field.name), getattr(other, field.name)
            if other is kept and field.name.startswith("lyapunov"):
                np.testing.assert_allclose(one, two, rtol=1e-14)
            else:
                np.testing.assert_array_equal(one, two, err_msg=field.name)


def test_what_a_neighbouring_row_has_is_followed_in_this_one(row):
    """One attractor of a row near by is enough for all cells that have it."""
    _, _, other = row
    model = published(f_e=0.1955)
    search = AttractorSearch(starts=0)
    alone = find_attractors(model, "omega", COLUMNS, search=search)
    columns, slots = np.nonzero(other.kind == FOUR)
    before = np.count_nonzero(alone.kind == FOUR)
    middle = len(columns) // 2
    brought = columns[middle : middle + 1], np.array([FOUR]), other.state[columns, slots][middle : middle + 1]
    found = continue_attractors(model, "omega", COLUMNS, alone, *brought, round=1, search=search)
    assert np.count_nonzero(found.kind == FOUR) >= max(before, len(columns) - 2)
    old = alone.kind > 0
    assert np.array_equal(found.kind[old], alone.kind[old]) and np.array_equal(found.state[old], alone.state[old])
    assert np.all(found.round[(found.kind > 0) & ~old] == 1)
    gained = found.gains(1)
    assert len(gained[0]) == np.count_nonzero((found.round == 1) & (found.kind <= CHAOS))


def test_motions_of_a_map_lead_to_attractors(row):
    model, motions, found = row
    there = np.isfinite(motions[..., 0])
    assert there.any() and np.all(found.motion[~there] == -1)
    for i, s in np.argwhere(found.motion >= 0):
        assert found.kind[i, found.motion[i, s]] > 0
        assert found.seen[i, found.motion[i, s]] & SeenFrom.MOTION


def test_another_number_of_coordinates_is_no_obstacle():
    """Supports of one kind merge; from two kinds lambda and its speed are brought there."""
    model = published(xi_support=(0.01, 0.02, 0.01, 0.01, 0.02, 0.01))
    row = find_attractors(model, "omega", [0.9], search=AttractorSearch(starts=2))
    merged = published(xi_support=0.02)
    states = row.state[0, :1]
    found = find_attractors(merged, "omega", [0.9], search=AttractorSearch(starts=0))
    gone_on = continue_attractors(merged, "omega", [0.9], found, [0], row.kind[0, :1], states, round=1)
    assert gone_on.kind[0, 0] == ONE and np.count_nonzero(gone_on.kind) == 1


def test_full_room_is_told():
    row = find_attractors(DOUBLED, "omega", [1.1], search=AttractorSearch(starts=40, room=2))
    assert row.overflow[0] and np.count_nonzero(row.kind) == 2


def test_a_motion_that_cannot_be_integrated_is_counted_and_is_no_attractor():
    runaway = ContactSystem([[1.0]], [[-200.0]], [[0.0]], [1.0], [1.0], 0.0, 0.0, load=[[0.1]])
    row = find_attractors(runaway, "omega", [0.5], search=AttractorSearch(starts=3))
    bounded = (row.kind > 0) & (row.kind <= CHAOS)
    assert not np.any(bounded)
    assert row.failures[0] + row.hits[0].sum() >= 3


@pytest.mark.parametrize(
    "name, value",
    [
        ("starts", -1),
        ("transient", 5),
        ("watched", 100),
        ("floor", 0.0),
        ("near", np.nan),
        ("tolerance", -1.0),
        ("ceiling", np.inf),
        ("room", 1),
    ],
)
def test_settings_are_checked(name, value):
    with pytest.raises(ParameterError, match=f"^{name} ="):
        AttractorSearch(**{name: value})


@pytest.mark.parametrize(
    "name, arguments",
    [
        ("values", dict(values=[1.0, 0.9])),
        ("values", dict(values=[])),
        ("motions", dict(motions=np.zeros((2, 1, 3)))),
        ("period", dict(period=9)),
        ("keys", dict(keys=[1, 2, 3])),
        ("axis", dict(axis="speed")),
    ],
)
def test_arguments_are_checked(name, arguments):
    given = {"system": published(), "axis": "omega", "values": [0.9], **arguments}
    with pytest.raises(ParameterError, match=f"^{name} ="):
        find_attractors(**given)


def test_settling_checks_what_it_is_given():
    row = find_attractors(published(), "omega", [0.9, 1.0], search=AttractorSearch(starts=0))
    with pytest.raises(ParameterError, match="^known ="):
        settle(published(), 0.9, [[0.0] * 4], known=row)
    with pytest.raises(ParameterError, match="^states ="):
        settle(published(), 0.9, [[0.0] * 3])


@pytest.mark.parametrize("omega, f_e", [(0.6, 0.2), (1.2265, 0.2), (0.7367924528, 0.4661016949)])
def test_quantities_are_those_of_the_motion_over_its_own_period(omega, f_e):
    model = published(f_e=f_e)
    _, row = at(model, omega, 60)
    errors = ("error_lowest", "error_highest", "error_rms", "error_peak_to_peak")
    for slot in np.flatnonzero((row.kind[0] > 0) & (row.kind[0] <= 8)):
        wanted, _ = motion_quantities(model, omega, row.state[0, slot], int(row.kind[0, slot]))
        for name in ("lowest", "highest", "mean", "rms", "peak_to_peak", *errors):
            assert getattr(row, name)[0, slot] == pytest.approx(getattr(wanted, name), abs=1e-8)
        for name in ("contact_loss", "impact_velocity", "support_force"):
            assert getattr(row, name)[0, slot] == pytest.approx(getattr(wanted, name), abs=1e-7)
        assert row.force[0, slot] == pytest.approx(wanted.dynamic_factor, abs=1e-8)
    columns = find_attractors(model, "f_e", [f_e], omega=omega, search=AttractorSearch(starts=0))
    assert columns.force[0, 0] == pytest.approx(row.force[0, list(row.state[0, :, 0]).index(columns.state[0, 0, 0])])


def test_the_force_of_a_contact_system_is_read_as_well():
    """lambda'' + 0.1 lambda' + f(lambda) = 0.3 + 0.01 cos Omega t never parts: the force is lambda - 1."""
    system = ContactSystem([[1.0]], [[0.1]], [[0.0]], [1.0], [1.0], 1.0, 1.0, load=[[0.3], [0.01]])
    found, row = at(system, 0.5, 3)
    amplitude = 0.01 / abs(0.75 + 0.05j)
    assert found == [ONE] and row.force[0, 0] == pytest.approx(1.0 + amplitude / 0.3, abs=1e-8)
    assert row.rms[0, 0] == pytest.approx(amplitude / np.sqrt(2.0), abs=1e-9) and row.contact_loss[0, 0] == 0.0
