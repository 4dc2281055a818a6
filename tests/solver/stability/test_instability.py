"""Kinds of instability, where the methods disagree, and rows against the figures of docs/physics.md, section 8."""

import numpy as np
import pytest

from solver import ParameterError, sweep_row
from solver.harmonic.galerkin import Galerkin
from solver.model.contact_system import gear_system
from solver.stability import (
    Instability,
    Truncation,
    assess,
    assessment,
    both_multipliers,
    classify,
    combine,
    motion_multipliers,
    multipliers,
    system_row,
    truncation_of,
)
from tests.conftest import antiphase, consistent, published
from tests.solver.stability.orbits import first_order, galerkin_motion, matched, oscillator
from tests.solver.stability.test_hill import curve

SIDE = consistent(rotation_coupling=0.93969262, variation_translation=0.0)


@pytest.fixture(autouse=True)
def forget():
    """Every test starts with nothing remembered."""
    assessment.forget()


@pytest.mark.parametrize(
    "largest, kind",
    [
        ([0.99, -0.5], Instability.NONE),
        ([1.01, -0.5], Instability.FOLD),
        ([-1.01, 1.005], Instability.PERIOD_DOUBLING),
        ([0.8 + 0.7j, 0.8 - 0.7j], Instability.NEIMARK_SACKER),
        ([1.0 + 1e-7, 0.2], Instability.DISPUTED),
        ([-1.0 + 1e-7, 0.2], Instability.DISPUTED),
        ([np.inf, 0.2], Instability.FOLD),
        ([np.nan, 0.2], Instability.DISPUTED),
    ],
)
def test_classification(largest, kind):
    found, modulus = classify([largest])
    assert found[0] == kind
    np.testing.assert_allclose(modulus, np.max(np.abs(largest)))


def test_every_kind_has_its_sentence():
    assert len({kind.sentence for kind in Instability}) == len(Instability) == 5


def test_what_two_methods_say_together():
    stable, fold, doubling = [0.5, 0.1], [1.2, 0.1], [-1.2, 0.1]
    hill, floquet = [stable, fold, stable, fold, doubling, stable], [stable, fold, fold, stable, doubling, stable]
    found = combine(hill, floquet, static=[1, 0, 1, 0, 1, 0])
    names = [Instability(kind).name for kind in found.kind]
    assert names == ["NONE", "FOLD", "DISPUTED", "DISPUTED", "PERIOD_DOUBLING", "DISPUTED"]
    np.testing.assert_array_equal(found.modulus, found.floquet_modulus)
    np.testing.assert_allclose(found.margin, 1.0 - np.max(np.abs(floquet), axis=1))
    assert combine(hill, floquet).kind[-1] == Instability.NONE


def test_disputed_motions_of_the_published_pair():
    """docs/physics.md, section 6."""
    for omega, which, modulus in [(0.58, 1, 0.952), (0.62, 2, 1.137)]:
        motions, static = first_order(published(), omega)
        found = assess(published(), "omega", np.full(3, omega), motions, static=static)
        assert found.kind[which] == Instability.DISPUTED
        assert abs(found.modulus[which] - modulus) < 5e-4
        # Hill's matrix, truncated like the balance, sides with its folds.
        assert (found.hill_kind[which] == Instability.NONE) == (static[which] == 1)
        assert found.kind[0] == Instability.NONE


def test_period_doubling_that_one_harmonic_calls_stable():
    """docs/physics.md, section 8: one solution, statically stable, with the multiplier -1.047."""
    motions, static = first_order(SIDE, 1.2)
    assert len(motions) == 1 and static[0] == 1
    found = assess(SIDE, "omega", [1.2], motions, static=static)
    assert found.kind[0] == Instability.PERIOD_DOUBLING
    multiplier = motion_multipliers(SIDE, 1.2, motions[0])
    assert abs(multiplier[np.argmax(np.abs(multiplier))] + 1.047) < 5e-4


def test_neimark_sacker_of_the_antiphase_pair():
    """docs/physics.md, section 8: a complex pair passes through the unit circle at Omega = 1.904."""
    model, balance = antiphase(rotation_coupling=0.93969262), Galerkin(15)
    points = curve(model, balance, 1.92, 1.89).points
    found = assess(model, "omega", points[:, -1], points[:, :-1], balance=balance)
    above = points[:, -1] > 1.905
    assert np.all(found.kind[above] == Instability.NEIMARK_SACKER)
    assert np.all(found.kind[points[:, -1] < 1.903] == Instability.NONE)
    order = np.argsort(points[:, -1])
    crossing = np.interp(0.0, -found.margin[order], points[order, -1])
    assert abs(crossing - 1.904) < 5e-4
    np.testing.assert_allclose(found.hill_modulus, found.floquet_modulus, rtol=0, atol=1e-4)


def test_doubled_motions_are_stable_where_the_single_one_is_not():
    """The 2T motion of docs/physics.md, section 8, half-order amplitude 0.7888: stable by both methods."""
    balance = Galerkin(8, 2)
    start = balance.lifted(first_order(SIDE, 1.2)[0][0])
    start[1] = 0.8
    motion = galerkin_motion(SIDE, balance, 1.2, start)
    assert abs(np.hypot(motion[1], motion[2]) - 0.7888) < 2e-3
    found = assess(SIDE, "omega", [1.2], motion[None], balance=balance)
    assert found.kind[0] == Instability.NONE and abs(found.hill_modulus[0] - found.modulus[0]) < 1e-2
    once = galerkin_motion(SIDE, Galerkin(8), 1.2, first_order(SIDE, 1.2)[0][0])[None]
    twice = np.zeros((1, balance.unknowns))
    twice[0, [0, *[slot for k in range(1, 9) for slot in (4 * k - 1, 4 * k)]]] = once
    row = system_row(SIDE, "omega", [1.2])
    single, double = multipliers(row, once), multipliers(row, twice, 2)
    assert matched(double[0], single[0] ** 2) < 1e-10
    # Over two periods period doubling looks like a fold, which is where the doubled balance branches off.
    assert assess(SIDE, "omega", [1.2], once, balance=Galerkin(8)).kind[0] == Instability.PERIOD_DOUBLING
    assert assess(SIDE, "omega", [1.2], twice, balance=balance).kind[0] == Instability.FOLD


@pytest.mark.parametrize(
    "axis, values",
    [
        ("b", [0.5, 1.0, 1.3]),
        ("f_e", [0.1, 0.2, 0.3]),
        ("alpha", [0.0, 0.2, 0.4]),
        ("k_support", [0.8, 1.0, 1.3]),
        ("rotation_coupling", [0.6, 0.7719, 0.9]),
        ("f_pm", [0.3, 0.5, 0.9]),
    ],
)
def test_axes_other_than_frequency(axis, values):
    model, omega = published(), 0.61
    chosen, motions = [], []
    for value in values:
        found, _ = first_order(model.replace(**{axis: value}), omega)
        chosen += [value] * len(found)
        motions.append(found)
    motions = np.concatenate(motions)
    along = assess(model, axis, chosen, motions, omega=omega)
    for i, value in enumerate(chosen):
        alone = assess(model.replace(**{axis: value}), "omega", [omega], motions[i : i + 1])
        assert along.kind[i] == alone.kind[0]
        np.testing.assert_allclose(along.modulus[i], alone.modulus[0], rtol=1e-12)
        np.testing.assert_allclose(along.hill_modulus[i], alone.hill_modulus[0], rtol=1e-9)


@pytest.mark.parametrize("axis, values", [("gap", [0.2, 0.9]), ("alpha", [0.1, 0.3]), ("excitation", [1.0, 2.0])])
def test_axes_of_other_systems(axis, values):
    harmonics = [[0.25, 0.3], [0.1, 0.0]]
    motion, omega = np.array([0.5, 0.9, 0.4]), 0.8
    system = oscillator(0.1, 0.05, 0.9, 0.9, harmonics, gap=0.4, back=np.inf)
    found = multipliers(system_row(system, axis, values, omega), np.tile(motion, (2, 1)))
    for i, value in enumerate(values):
        changed = oscillator(
            0.1,
            0.05,
            0.9,
            0.9,
            [[value, 0.3], harmonics[1]] if axis == "alpha" else harmonics,
            gap=value if axis == "gap" else 0.4,
            back=np.inf,
        )
        np.testing.assert_array_equal(found[i], motion_multipliers(changed, omega, motion))


def test_linear_motions_are_remembered_exactly():
    model = published()
    row = sweep_row(model, "omega", np.linspace(0.05, 2.0, 40))
    present = row.stable >= 0
    omega, motions = np.repeat(row.grid, present.sum(axis=1)), np.stack([row.mean, row.cos, row.sin], axis=2)[present]
    first = assess(model, "omega", omega, motions)
    remembered = len(assessment._linear)
    assert 0 < remembered <= len(omega)
    # The load does not enter; the stiffness does, and so does the order.
    other = assess(model.replace(f_e=0.3), "omega", omega, motions)
    assert len(assessment._linear) == remembered
    again = assess(model, "omega", omega, motions)
    for field in ("kind", "modulus", "hill_modulus"):
        np.testing.assert_array_equal(getattr(first, field), getattr(again, field))
    linear = system_row(model, "omega", omega)
    fresh = both_multipliers(linear, motions, Truncation())[1]
    np.testing.assert_array_equal(fresh, multipliers(linear, motions))
    assert other.kind.shape == first.kind.shape
    assess(model.replace(alpha=0.3), "omega", omega, motions)
    assert len(assessment._linear) == 2 * remembered


def test_frequencies_of_one_motion_may_repeat():
    motion = first_order(published(), 0.9)[0]
    found = assess(published(), "omega", [0.9, 0.9, 0.9], np.repeat(motion, 3, axis=0))
    assert len(set(found.modulus)) == len(set(found.hill_modulus)) == 1 and found.kind[0] == Instability.NONE


def test_no_motions():
    assert assess(published(), "omega", [], np.empty((0, 3))).kind.shape == (0,)


def test_what_is_refused():
    motions = np.ones((2, 3))
    for arguments, options, name in [
        (("speed", [1.0, 1.1], motions), {}, "axis"),
        (("omega", [1.0, -1.1], motions), {}, "omega"),
        (("b", [1.0, 1.1], motions), {}, "omega"),
        (("b", [1.0, 1.1], motions), {"omega": 0.0}, "omega"),
        (("k_support", [-1.0, 1.1], motions), {"omega": 1.0}, "k_support"),
        (("omega", [1.0, np.nan], motions), {}, "values"),
        (("omega", [1.0, 1.1], motions[:1]), {}, "motions"),
        (("omega", [1.0, 1.1], motions * np.nan), {}, "motions"),
        (("omega", [1.0, 1.1], motions), {"balance": Galerkin(2)}, "motions"),
    ]:
        with pytest.raises(ParameterError, match=name):
            assess(published(), *arguments, **options)
    with pytest.raises(ParameterError, match="axis"):
        system_row(gear_system(published()), "b", [1.0], 1.0)
    assert truncation_of(Galerkin(3, 2)) == Truncation(6, 2, truncated=False)
