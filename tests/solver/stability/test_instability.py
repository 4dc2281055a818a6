"""Kinds of instability, and the assessment of rows against the figures of docs/physics.md."""

import numpy as np
import pytest

from solver import ParameterError
from solver.harmonic.galerkin import Galerkin
from solver.model.contact_system import gear_system
from solver.stability import Instability, assess, classify, motion_multipliers, multipliers
from tests.conftest import antiphase, consistent, published
from tests.solver.stability.orbits import first_order, galerkin_motion, matched, oscillator
from tests.solver.stability.rows import branch

SIDE = consistent(rotation_coupling=0.93969262, variation_translation=0.0)
TOP = 1.01


@pytest.mark.parametrize(
    "found, static, kind",
    [
        ([0.99, -0.5], 1, Instability.NONE),
        ([0.99, -0.5], 0, Instability.CONTRADICTORY),
        ([TOP, -0.5], 0, Instability.FOLD),
        ([TOP, -0.5], 1, Instability.CONTRADICTORY),
        # Beyond -1 counts whatever else holds, a pair outside next; neither asks for static stability.
        ([-TOP, 1.2], 1, Instability.PERIOD_DOUBLING),
        ([-TOP, 1.2], 0, Instability.PERIOD_DOUBLING),
        ([-TOP, 0.8 + 0.7j, 0.8 - 0.7j], 1, Instability.PERIOD_DOUBLING),
        ([-TOP, 1.0], 1, Instability.PERIOD_DOUBLING),
        ([0.8 + 0.7j, 0.8 - 0.7j], 0, Instability.NEIMARK_SACKER),
        ([0.8 + 0.7j, 0.8 - 0.7j, 1.2, -1.0], 1, Instability.NEIMARK_SACKER),
        # On the circle nothing is decided.
        ([1.0 + 1e-7, 0.2], 1, Instability.UNDECIDED),
        ([-1.0 + 1e-7, 0.2], 1, Instability.UNDECIDED),
        ([1j, -1j, 1.2], 1, Instability.UNDECIDED),
        ([np.nan, -1.2], 1, Instability.UNDECIDED),
        ([np.inf, 0.2], 0, Instability.UNDECIDED),
    ],
)
def test_classification(found, static, kind):
    assert Instability(classify([found], [static])[0]) is kind


def test_without_static_stability_nothing_contradicts():
    kinds = [Instability(kind).name for kind in classify([[0.5, 0.1], [1.2, 0.1]])]
    assert kinds == ["NONE", "FOLD"]


def test_every_kind_has_its_sentence():
    assert len({kind.sentence for kind in Instability}) == len(Instability) == 6


@pytest.mark.parametrize("omega, index, static, modulus", [(0.58, 1, 0, 0.952), (0.62, 2, 1, 1.137)])
def test_contradictory_motions_of_the_published_pair(omega, index, static, modulus):
    """Upper motions of the mesh-frequency resonance: the multiplier and det J disagree about +1."""
    motions, stable = first_order(published(), omega)
    found = assess(published(), "omega", np.full(3, omega), motions, static=stable)
    assert stable[index] == static and found.kind[index] == Instability.CONTRADICTORY
    assert abs(found.modulus[index] - modulus) < 5e-4
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
    points = branch(model, balance, low=1.89, high=1.92)[1].points
    found = assess(model, "omega", points[:, -1], points[:, :-1], balance=balance)
    above = points[:, -1] > 1.905
    assert np.all(found.kind[above] == Instability.NEIMARK_SACKER)
    assert np.all(found.kind[points[:, -1] < 1.903] == Instability.NONE)
    order = np.argsort(points[:, -1])
    crossing = np.interp(0.0, -found.margin[order], points[order, -1])
    assert abs(crossing - 1.904) < 5e-4


def test_doubled_motions_are_stable_where_the_single_one_is_not():
    """The 2T motion of docs/physics.md, section 8, half-order amplitude 0.7888."""
    balance = Galerkin(8, 2)
    start = balance.lifted(first_order(SIDE, 1.2)[0][0])
    start[1] = 0.8
    motion = galerkin_motion(SIDE, balance, 1.2, start)
    assert abs(np.hypot(motion[1], motion[2]) - 0.7888) < 2e-3
    found = assess(SIDE, "omega", [1.2], motion[None], balance=balance)
    assert found.kind[0] == Instability.NONE
    once = galerkin_motion(SIDE, Galerkin(8), 1.2, first_order(SIDE, 1.2)[0][0])[None]
    twice = np.zeros((1, balance.unknowns))
    twice[0, [0, *[slot for k in range(1, 9) for slot in (4 * k - 1, 4 * k)]]] = once
    single = multipliers(SIDE, "omega", [1.2], once)
    double = multipliers(SIDE, "omega", [1.2], twice, period=2)
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


@pytest.mark.parametrize("axis, values", [("gap", [0.2, 0.9]), ("alpha", [0.1, 0.3]), ("excitation", [1.0, 2.0])])
def test_axes_of_other_systems(axis, values):
    harmonics = [[0.25, 0.3], [0.1, 0.0]]
    motion, omega = np.array([0.5, 0.9, 0.4]), 0.8
    system = oscillator(0.1, 0.05, 0.9, 0.9, harmonics, gap=0.4, back=np.inf)
    found = multipliers(system, axis, values, np.tile(motion, (2, 1)), omega=omega)
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
        np.testing.assert_allclose(found[i], motion_multipliers(changed, omega, motion), rtol=1e-12)


def test_what_motions_share_does_not_change_them():
    """Motions that never switch contact are computed once where they can be; alone each gives the same, bitwise."""
    model, omega = published(), 0.9
    values = np.linspace(0.1, 0.4, 7)
    motions = np.concatenate([first_order(model.replace(f_e=f_e), omega)[0][:1] for f_e in values])
    motions[3] = 0.1, 0.2, 0.0
    together = assess(model, "f_e", values, motions, omega=omega)
    for i, value in enumerate(values):
        alone = assess(model, "f_e", [value], motions[i : i + 1], omega=omega)
        assert alone.kind[0] == together.kind[i] and alone.modulus[0] == together.modulus[i]
        np.testing.assert_array_equal(alone.tests[0], together.tests[i])


def test_frequencies_of_one_motion_may_repeat():
    motion = first_order(published(), 0.9)[0]
    found = assess(published(), "omega", [0.9, 0.9, 0.9], np.repeat(motion, 3, axis=0))
    assert len(set(found.modulus)) == 1 and found.kind[0] == Instability.NONE


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
        assess(gear_system(published()), "b", [1.0], motions[:1], omega=1.0)
