"""Every line of the table by which a label is judged, and labels that are shifted."""

import numpy as np
import pytest

from pipeline.analysis.attractors.credibility import Cells, Credibility, judge, reach
from solver import domain_code
from solver.timedomain import AttractorKind as Kind

_ROOM, _MOTIONS = 8, 4


def cell(motions=(), found=(), leads=None, *, label=None, period=1, **flags):
    """One cell: motions (mean, amplitude, impact) that its label counts, attractors (kind, mean, amplitude, impact)."""
    states = 0
    for *_, impact in motions:
        states |= 1 << impact
    code = int(domain_code(len(motions), states)) if label is None else label
    stable = np.zeros((1, 1, _MOTIONS), bool)
    stable[..., : len(motions)] = True
    mean, amplitude = np.full((2, 1, 1, _MOTIONS), np.nan)
    impact, to = np.full((2, 1, 1, _MOTIONS), -1)
    for s, one in enumerate(motions):
        mean[0, 0, s], amplitude[0, 0, s], impact[0, 0, s] = one
    for s, slot in enumerate(range(len(motions)) if leads is None else leads):
        to[0, 0, s] = slot
    kind, seen = np.zeros((1, 1, _ROOM), int), np.full((1, 1, _ROOM), -1)
    means, amplitudes = np.full((2, 1, 1, _ROOM), np.nan)
    for a, one in enumerate(found):
        kind[0, 0, a], means[0, 0, a], amplitudes[0, 0, a], seen[0, 0, a] = one
    flag = {name: np.array([[flags.get(name, False)]]) for name in ("unresolved", "overflow", "failed")}
    return Cells(
        np.array([[code]]),
        stable,
        mean,
        amplitude,
        impact,
        to,
        kind,
        seen,
        means,
        amplitudes,
        np.array([[2.0]]),
        flag["unresolved"],
        flag["overflow"],
        flag["failed"],
        period,
    )


LOW, HIGH = (1.6, 0.4, 0), (1.2, 1.8, 1)
ONE, OTHER = (Kind.PERIOD_1, 1.61, 0.41, 0), (Kind.PERIOD_1, 1.21, 1.79, 1)
TWO = (Kind.PERIOD_2, 1.3, 0.8, 1)
LOST = (Kind.UNSETTLED, np.nan, np.nan, -1)
GROWS = (Kind.UNBOUNDED, np.nan, np.nan, -1)

CASES = {
    "all are there": (cell([LOW], [ONE]), Credibility.CONFIRMED),
    "two are there, in another order": (cell([LOW, HIGH], [OTHER, ONE], [1, 0]), Credibility.CONFIRMED),
    "there, though it leads elsewhere": (cell([LOW, HIGH], [ONE, OTHER], [0, 0]), Credibility.CONFIRMED),
    "no label": (cell([], [ONE], label=0), Credibility.UNCHECKED),
    "the row failed": (cell([LOW], [ONE], failed=True), Credibility.UNCHECKED),
    "2T beside it": (cell([LOW], [ONE, TWO]), Credibility.MORE_MOTIONS_EXIST),
    "1T beside it": (cell([LOW], [ONE, OTHER]), Credibility.MORE_MOTIONS_EXIST),
    "unbounded motions beside it": (cell([LOW], [ONE, GROWS]), Credibility.MORE_MOTIONS_EXIST),
    "more than there is room for": (cell([LOW], [ONE], overflow=True), Credibility.MORE_MOTIONS_EXIST),
    "more, and a start that did not settle": (cell([LOW], [ONE, TWO, LOST]), Credibility.MORE_MOTIONS_EXIST),
    "a start that did not settle": (cell([LOW], [ONE, LOST]), Credibility.UNCHECKED),
    "a start that could not be integrated": (cell([LOW], [ONE], unresolved=True), Credibility.UNCHECKED),
    "a motion that did not settle": (cell([LOW], [LOST], [0]), Credibility.UNCHECKED),
    "a motion of which nothing is known": (cell([LOW], [TWO], [-1]), Credibility.UNCHECKED),
    "it leads to 2T": (cell([LOW], [TWO]), Credibility.NOT_A_PERIOD_1_MOTION),
    "it leads to a torus": (cell([LOW], [(Kind.QUASI_PERIODIC, 1.6, 0.4, 0)]), Credibility.NOT_A_PERIOD_1_MOTION),
    "it leads to a long period": (cell([LOW], [(Kind.PERIOD_LONGER, 1.6, 0.4, 0)]), Credibility.NOT_A_PERIOD_1_MOTION),
    "it leads to chaos": (cell([LOW], [(Kind.CHAOTIC, 1.6, 0.4, 0)]), Credibility.NOT_A_PERIOD_1_MOTION),
    "it grows": (cell([LOW], [GROWS]), Credibility.NOT_A_PERIOD_1_MOTION),
    "one of two leads to 2T": (cell([LOW, HIGH], [ONE, TWO]), Credibility.NOT_A_PERIOD_1_MOTION),
    "one is lost, another not settled": (cell([LOW, HIGH], [TWO, LOST]), Credibility.NOT_A_PERIOD_1_MOTION),
    "two lead to one": (cell([LOW, HIGH], [ONE], [0, 0]), Credibility.WRONG_COUNT),
    "far off, and it leads there": (cell([LOW], [(Kind.PERIOD_1, 1.6, 0.6, 0)]), Credibility.CONFIRMED),
    "far off, and it leads to what another has": (
        cell([LOW, HIGH], [ONE, (Kind.PERIOD_1, 1.2, 1.5, 1)], [0, 0]),
        Credibility.CONFIRMED,
    ),
    "far off, and nothing is known": (cell([LOW], [(Kind.PERIOD_1, 1.6, 0.6, 0)], [-1]), Credibility.CONFIRMED),
    "far off, it leads to 2T": (cell([LOW], [TWO, (Kind.PERIOD_1, 1.6, 0.6, 0)], [0]), Credibility.MORE_MOTIONS_EXIST),
    "in another state, it leads to 2T": (
        cell([LOW], [TWO, (Kind.PERIOD_1, 1.6, 0.4, 1)], [0]),
        Credibility.NOT_A_PERIOD_1_MOTION,
    ),
    "another state is left, it leads to what another has": (
        cell([LOW, HIGH], [ONE, (Kind.PERIOD_1, 1.2, 1.5, 2)], [0, 0]),
        Credibility.WRONG_IMPACT_STATE,
    ),
    "far off, in another state": (cell([LOW], [(Kind.PERIOD_1, 1.6, 0.6, 1)]), Credibility.WRONG_IMPACT_STATE),
    "two motions alike are not one attractor": (cell([LOW, LOW], [ONE], [0, 0]), Credibility.WRONG_COUNT),
    "none counted, one there": (cell([], [ONE]), Credibility.WRONG_COUNT),
    "none counted, 2T there": (cell([], [TWO]), Credibility.MORE_MOTIONS_EXIST),
    "none counted, nothing found": (cell([], []), Credibility.UNCHECKED),
    "in another impact state": (cell([LOW], [(Kind.PERIOD_1, 1.6, 0.4, 1)]), Credibility.WRONG_IMPACT_STATE),
    "in another state, another not settled": (
        cell([LOW, HIGH], [(Kind.PERIOD_1, 1.6, 0.4, 1), LOST]),
        Credibility.WRONG_IMPACT_STATE,
    ),
    "2T of a map of two periods": (cell([(1.3, 0.8, 1)], [TWO], period=2), Credibility.CONFIRMED),
    "1T of a map of two periods": (cell([LOW], [ONE], period=2), Credibility.CONFIRMED),
    "3T of a map of two periods": (
        cell([LOW], [(Kind.PERIOD_3, 1.6, 0.4, 0)], period=2),
        Credibility.NOT_A_PERIOD_1_MOTION,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_every_line_of_the_table(name):
    cells, expected = CASES[name]
    assert Credibility(judge(cells, 0.05, (0, 0))[0].item()) is expected


def test_every_class_but_shifted_is_among_the_cases():
    assert {kind for _, kind in CASES.values()} == set(Credibility) - {Credibility.SHIFTED}


def row_of(*cells):
    """Cells beside each other."""
    names = [name for name in vars(cells[0]) if name != "period"]
    return Cells(*(np.concatenate([getattr(one, name) for one in cells], axis=1) for name in names))


def test_a_boundary_that_lies_elsewhere_is_shifted_and_nothing_farther_away():
    right_one, right_two = cell([LOW], [ONE]), cell([LOW, HIGH], [ONE, OTHER])
    too_early = cell([LOW, HIGH], [ONE], [0, 0])  # the map says two already
    cells = row_of(right_one, right_one, too_early, too_early, too_early, right_two, right_two)
    shifted, wrong, fine = Credibility.SHIFTED, Credibility.WRONG_COUNT, Credibility.CONFIRMED
    assert judge(cells, 0.05, (0, 1))[0][0].tolist() == [fine, fine, wrong, wrong, wrong, fine, fine]
    assert judge(cells, 0.05, (0, 2))[0][0].tolist() == [fine, fine, wrong, shifted, wrong, fine, fine]
    assert judge(cells, 0.05, (0, 3))[0][0].tolist() == [fine, fine, shifted, shifted, shifted, fine, fine]
    # Along the rows it is the same.
    turned = Cells(*(np.swapaxes(value, 0, 1) for name, value in vars(cells).items() if name != "period"))
    assert judge(turned, 0.05, (2, 0))[0][:, 0].tolist() == [fine, fine, wrong, shifted, wrong, fine, fine]
    # Both labels must change sides: where the map's never becomes true, nothing is shifted.
    assert judge(row_of(right_one, too_early, too_early), 0.05, (0, 3))[0][0].tolist() == [fine, wrong, wrong]


def test_what_is_no_label_is_never_shifted():
    two = cell([LOW], [TWO])
    cells = row_of(cell([LOW], [ONE]), two, cell([LOW, HIGH], [ONE, OTHER]))
    assert judge(cells, 0.05, (0, 3))[0][0, 1] == Credibility.NOT_A_PERIOD_1_MOTION


def test_how_far_a_label_may_be_shifted():
    rows, columns = np.linspace(0.0, 0.5, 201), np.linspace(0.05, 2.0, 401)
    assert reach(rows, columns, (0.5, 1.95), 0.02) == (4, 8)
    assert reach(rows[::2], columns[::4], (0.5, 1.95), 0.02) == (2, 2)
    assert reach(rows[:1], columns, (0.5, 1.95), 0.0) == (0, 0)


def test_how_far_motions_are_off():
    far = cell([LOW, HIGH], [ONE, (Kind.PERIOD_1, 1.3, 1.5, 1)])
    off = judge(far, 0.05, (0, 0))[1].item()
    assert off == pytest.approx(0.3 / 2.0)
    assert judge(cell([LOW], [ONE]), 0.05, (0, 0))[1].item() == pytest.approx(0.01 / 2.0)
    for cells in (cell([LOW], [TWO]), cell([], [ONE], label=0), cell([], [])):
        assert np.isnan(judge(cells, 0.05, (0, 0))[1].item())
