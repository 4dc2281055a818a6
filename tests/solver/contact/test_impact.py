"""Impact states partition all motions; codes of n/I labels are unique and do not depend on any order."""

import itertools

import numpy as np
import pytest
from hypothesis import given

from solver import ImpactState, ParameterError, domain_code, domain_label, domain_labels, impact_state
from solver.contact.impact import _STATES
from tests.solver.strategies import numbers

LETTERS = {"0", "1", "2", "f", "1m", "0m"}


@given(numbers(-3.0, 3.0), numbers(0.0, 4.0), numbers(0.0, 2.0))
def test_every_motion_has_exactly_one_state_and_it_says_what_happens(lowest, extent, b):
    highest = lowest + extent
    state = ImpactState(int(impact_state(lowest, highest, b)))
    drive, back = highest > b, lowest < -b
    apart = lowest <= b and highest >= -b
    expected = {
        (True, False, False): ImpactState.PERMANENT,
        (True, False, True): ImpactState.SINGLE_SIDED,
        (True, True, True): ImpactState.DOUBLE_SIDED,
        (False, False, True): ImpactState.FREE,
        (False, True, True): ImpactState.MIRRORED_SINGLE_SIDED,
        (False, True, False): ImpactState.MIRRORED_PERMANENT,
    }
    assert state is expected[drive, back, apart]


@pytest.mark.parametrize(
    "lowest, highest, state",
    [
        (1.1, 2.0, "PERMANENT"),
        (1.0, 2.0, "SINGLE_SIDED"),
        (0.0, 2.0, "SINGLE_SIDED"),
        (-1.0, 2.0, "SINGLE_SIDED"),
        (-1.1, 2.0, "DOUBLE_SIDED"),
        (-1.0, 1.0, "FREE"),
        (0.0, 0.0, "FREE"),
        (1.0, 1.0, "FREE"),
        (-1.0, -1.0, "FREE"),
        (-2.0, 1.0, "MIRRORED_SINGLE_SIDED"),
        (-2.0, -1.0, "MIRRORED_SINGLE_SIDED"),
        (-2.0, -1.1, "MIRRORED_PERMANENT"),
        (1.1, 1.1, "PERMANENT"),
        (-1.1, -1.1, "MIRRORED_PERMANENT"),
    ],
)
def test_borders_belong_to_one_side(lowest, highest, state):
    """docs/physics.md, section 5: I = 1 for -b <= lambda_min <= b < lambda_max; permanent contact is strict."""
    assert ImpactState(int(impact_state(lowest, highest, 1.0))).name == state


def test_the_article_s_overlap_goes_to_double_sided():
    # As printed, 1 would hold here too; 2 wins.
    assert impact_state(-1.5, 2.0, 1.0) == 2


@given(numbers(-3.0, 3.0), numbers(0.01, 4.0), numbers(0.01, 2.0))
def test_mirrored_motions_have_mirrored_states(lowest, extent, b):
    highest = lowest + extent
    mirror = {0: 5, 1: 4, 2: 2, 3: 3, 4: 1, 5: 0}
    if min(abs(abs(lowest) - b), abs(abs(highest) - b)) > 1e-9:
        assert impact_state(-highest, -lowest, b) == mirror[int(impact_state(lowest, highest, b))]


def test_arrays_broadcast_and_nan_is_nothing():
    codes = impact_state(np.array([[1.5, 0.0], [np.nan, -2.0]]), np.array([2.0, 2.0]), np.array([[1.0], [1.5]]))
    assert codes.dtype == np.int8
    np.testing.assert_array_equal(codes, [[0, 1], [-1, 2]])
    assert impact_state(0.0, np.nan, 1.0) == -1


def test_no_gap_has_no_free_motion():
    codes = impact_state([0.1, 0.0, -1.0, -1.0, -2.0], [1.0, 1.0, 1.0, 0.0, -1.0], 0.0)
    np.testing.assert_array_equal(codes, [0, 1, 2, 4, 5])


def test_symbols_and_sentences_are_one_per_state():
    assert {state.symbol for state in ImpactState} == LETTERS
    assert len({state.sentence for state in ImpactState}) == len(ImpactState) == 6
    assert [state.symbol for state in (ImpactState.PERMANENT, ImpactState.SINGLE_SIDED, ImpactState.DOUBLE_SIDED)] == [
        "0",
        "1",
        "2",
    ]


def test_codes_are_unique_for_every_n_and_set_of_states():
    codes = {}
    for n in range(9):
        for size in range(len(ImpactState) + 1):
            for states in itertools.combinations(ImpactState, size):
                code = int(domain_code(n, sum(1 << s for s in states)))
                assert 0 < code < 2**16
                codes[code] = n, states
    assert len(codes) == 9 * 2**6 == 9 * 2**_STATES
    labels = set()
    for code, (n, states) in codes.items():
        if len(states) > n or bool(states) != bool(n):
            # No set of n motions has these states.
            with pytest.raises(ParameterError, match="code"):
                domain_label(code)
            codes[code] = None
        else:
            labels.add(domain_label(code))
    assert len(labels) == sum(known is not None for known in codes.values()) > 100


@pytest.mark.parametrize(
    "n, states, label",
    [
        (1, {0}, "1/0"),
        (2, {0, 1}, "2/0-1"),
        (2, {1, 2}, "2/1-2"),
        (2, {2}, "2/2"),
        (3, {0, 1, 2}, "3/0-1-2"),
        (0, set(), "0/-"),
        (1, {3}, "1/f"),
        (2, {4, 5}, "2/1m-0m"),
        (1, {5}, "1/0m"),
    ],
)
def test_labels(n, states, label):
    for order in itertools.permutations(states):
        mask = 0
        for state in order:
            mask |= 1 << state
        assert domain_label(domain_code(n, mask)) == label
    assert domain_label(0) == ""


def test_all_labels_of_up_to_some_number():
    labels = domain_labels(3)
    assert list(labels) == sorted(labels) and len(set(labels.values())) == len(labels)
    assert labels[int(domain_code(0, 0))] == "0/-"
    assert {"1/0", "1/1", "1/2", "2/0-1", "2/1-2", "2/2", "3/0-1-2"} <= set(labels.values())
    # More states than solutions, or solutions without a state, do not exist.
    assert not {"1/0-1", "2/0-1-2", "1/-", "0/0"} & set(labels.values())
    # Besides 0/-: 6 sets of one state, 15 of two and 20 of three out of six.
    assert len(labels) == 1 + 6 + (6 + 15) + (6 + 15 + 20)
    for code, label in labels.items():
        assert domain_label(code) == label
        # CF's flag_meanings are words: no blanks may be inside.
        assert " " not in label


def test_codes_of_arrays():
    codes = domain_code(np.array([1, 2]), np.array([1, 3]))
    assert codes.dtype == np.uint16
    assert [domain_label(code) for code in codes] == ["1/0", "2/0-1"]
