"""Edges where labels change between cells, and pieces of branches between events."""

import itertools

import numpy as np

from pipeline.figures.edges import curves_along, label_edges
from pipeline.plane.segments import segments_of_row
from solver import Event

# Edges


def test_edges_are_label_changes():
    rng = np.random.default_rng(1)
    code = rng.integers(0, 5, (13, 17))
    n = np.array([0, 1, 1, 2, 2])[code]
    expected = {"fold": 0, "grazing": 0}
    for row, column in np.ndindex(code.shape):
        for other in ((row + 1, column), (row, column + 1)):
            if (
                other[0] < 13
                and other[1] < 17
                and code[row, column]
                and code[other]
                and code[row, column] != code[other]
            ):
                expected["fold" if n[row, column] != n[other] else "grazing"] += 1
    fold, grazing = label_edges(code, n)
    assert (len(fold), len(grazing)) == (expected["fold"], expected["grazing"])
    for segments in (fold, grazing):
        assert np.all(np.abs(segments[:, 0] - segments[:, 1]).sum(axis=1) == 1)
        assert len(np.unique(segments, axis=0)) == len(segments)


def test_edges_lie_between_the_cells():
    fold, grazing = label_edges(np.array([[1, 1, 2], [1, 3, 3]]), np.array([[1, 1, 1], [1, 2, 2]]))
    assert {tuple(map(tuple, s)) for s in grazing.tolist()} == {((0, 2), (1, 2))}
    assert {tuple(map(tuple, s)) for s in fold.tolist()} == {((1, 1), (1, 2)), ((1, 2), (1, 3)), ((1, 1), (2, 1))}


def test_curves_cover_every_edge_once():
    rng = np.random.default_rng(2)
    code = 1 + rng.integers(0, 3, (11, 19))
    segments, _ = label_edges(code, code)
    covered = []
    for curve in curves_along(segments):
        for one, other in itertools.pairwise(curve):
            steps = np.abs(other - one)
            assert steps.min() == 0
            stretch = np.linspace(one, other, steps.max() + 1).astype(int).tolist()
            covered += [sorted(pair) for pair in itertools.pairwise(stretch)]
    assert sorted(covered) == sorted(sorted(segment) for segment in segments.tolist())


def test_a_closed_curve_and_a_straight_one():
    code = np.ones((3, 3), dtype=int)
    code[1, 1] = 2
    (curve,) = curves_along(label_edges(code, code)[0])
    assert len(curve) == 5 and tuple(curve[0]) == tuple(curve[-1])
    (curve,) = curves_along(label_edges(np.array([[1, 2]] * 4), np.array([[1, 2]] * 4))[0])
    assert sorted(curve.tolist()) == [[0, 1], [4, 1]]
    assert curves_along(np.empty((0, 2, 2), dtype=int)) == []


# Pieces


def row(**arrays):
    size = len(arrays["event"])
    usual = {
        "mean": np.zeros(size),
        "amplitude": np.ones(size),
        "branch": np.zeros(size, int),
        "impact": np.ones(size, int),
    }
    return {name: np.asarray(array) for name, array in {**usual, **arrays}.items()}


def test_pieces_share_event_points_and_ignore_their_state():
    fold, drive = int(Event.FOLD), int(Event.MIN_AT_DRIVE)
    points = row(
        position=[0.0, 1.0, 2.0, 1.5, 1.0, 3.0, 4.0],
        stable=[1, 1, 0, 0, 0, 1, 1],
        event=[0, drive, fold, 0, 0, 0, 0],
        branch=[0, 0, 0, 0, 0, 1, 1],
        impact=[0, 0, 1, 1, 1, 2, 2],
        mean=[2.0, 2.0, 1.0, 1.0, 1.0, 0.0, 0.0],
    )
    pieces = segments_of_row(points, -np.ones(7), np.ones(7))
    assert [(p.start, p.stop, p.low, p.high, p.stable, p.impact) for p in pieces] == [
        (0, 2, 0.0, 1.0, True, 0),
        # Between two events: stability from before the fold, impact state from half-way.
        (1, 3, 1.0, 2.0, True, 1),
        (2, 5, 1.0, 2.0, False, 1),
        (5, 7, 3.0, 4.0, True, 2),
    ]
    assert segments_of_row({name: array[:0] for name, array in points.items()}, np.empty(0), np.empty(0)) == []


def test_pieces_between_two_folds():
    points = row(position=[0.0, 2.0, 1.0, 3.0], stable=[1, 0, 0, 1], event=[0, Event.FOLD, Event.FOLD, 0])
    assert [piece.stable for piece in segments_of_row(points, -np.ones(4), np.ones(4))] == [True, False, True]
