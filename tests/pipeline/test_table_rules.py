"""Rules behind the tables: intervals, peaks, edges, bands and verbal classes, on made-up rows and at thresholds."""


import numpy as np
import pytest

from pipeline.plan import Axis
from pipeline.tables.article import ARTICLE_TABLES, Band, band_rows
from pipeline.tables.classes import (
    IMPACT_SHARE,
    NEAR_LINEAR,
    PROMINENT_JUMP,
    SETTLED,
    impact_class,
    jump_class,
    percent,
    resonance_class,
    stability_class,
    worst_impact,
)
from pipeline.tables.edges import Edge, band_edges, edges, nearest_edge
from pipeline.tables.peaks import resonance_peak
from pipeline.tables.pieces import Branches, Piece, multivalued_intervals, row_pieces
from solver import EndReason, Event

PLANES = {article.plane: article for article in ARTICLE_TABLES}
NAMES = [f"table{number}.{suffix}" for number in (1, 2, 3) for suffix in ("csv", "md", "tex")]


def straight(low, high, stable=True, heights=(1.0, 1.0), folds=(False, False)):
    return Piece(np.linspace(low, high, 2), np.array(heights), np.array([0.0, 1.0]), stable, folds)


@pytest.mark.parametrize(
    ("pieces", "expected"),
    [
        ([], ()),
        ([straight(0.0, 2.0)], ()),
        ([straight(0.0, 1.0), straight(1.0, 2.0)], ()),
        ([straight(0.0, 1.5), straight(1.5, 1.0, False), straight(1.0, 2.0)], ((1.0, 1.5),)),
        # Five solutions inside three are one interval; two hysteresis loops side by side are two.
        ([straight(0, 1.5), straight(1.5, 1, False), straight(1, 1.4), straight(1.4, 1.2, False), straight(1.2, 2)],
         ((1.0, 1.5),)),
        ([straight(0, 1.5), straight(1.5, 1, False), straight(1, 1.8), straight(1.8, 1.7, False), straight(1.7, 2)],
         ((1.0, 1.5), (1.7, 1.8))),
        # An isola above one branch, and one that touches another interval.
        ([straight(0.0, 2.0), straight(0.5, 0.8), straight(0.8, 0.5, False)], ((0.5, 0.8),)),
        ([straight(0.0, 2.0), straight(0.5, 0.8), straight(0.8, 1.1)], ((0.5, 1.1),)),
    ],
)  # fmt: skip
def test_intervals(pieces, expected):
    assert multivalued_intervals(pieces) == expected


def test_a_closed_curve_is_opened_at_a_fold():
    angle = np.linspace(0.3, 0.3 + 2.0 * np.pi, 33)
    omega, amplitude = 1.0 + 0.1 * np.cos(angle), 2.0 + np.sin(angle)
    event, stable = np.zeros(33, int), np.where(np.sin(angle) > 0.0, 1, 0)
    for fold in (np.argmax(omega), np.argmin(omega)):
        event[fold], stable[fold] = Event.FOLD, 0
    end = np.full((1, 2), int(EndReason.CLOSED))
    branches = Branches(omega, amplitude, np.arange(33.0), stable, np.zeros(33, int), event, end)
    pieces = row_pieces(branches)
    assert [piece.stable for piece in pieces] in ([True, False], [False, True])
    assert all(np.all(np.diff(piece.arclength) > 0.0) and piece.folds == (True, True) for piece in pieces)
    assert all(abs(np.sum(np.sign(np.diff(piece.omega)))) == piece.omega.size - 1 for piece in pieces)
    assert multivalued_intervals(pieces) == ((omega.min(), omega.max()),)


def test_what_counts_as_a_peak():
    omega = np.linspace(0.0, 2.0, 41)

    def peak(height):
        return resonance_peak([Piece(omega, height, omega, True, (False, False))], omega, height, 0.0, 2.5)

    bell = np.exp(-(((omega - 1.03) / 0.2) ** 2))
    found = peak(bell)
    assert found.omega == pytest.approx(1.03, abs=2e-3) and found.amplitude == pytest.approx(1.0, abs=2e-3)
    inside = np.flatnonzero(bell >= 0.5)
    assert (found.start, found.stop) == (inside[0], inside[-1] + 1)
    assert peak(np.linspace(0.0, 1.0, 41)) is None, "the end of the range is no peak"
    assert peak(1.0 + 0.2 * bell) is None, "it never falls to half its power"
    assert peak(1.0 - omega / 2.0 + 0.3 * np.exp(-(((omega - 0.6) / 0.05) ** 2))) is None, "a shoulder"
    assert resonance_peak([], omega, bell, 3.0, 4.0) is None, "a part that the grid does not reach"
    # The stable upper piece ends at a fold: that is where it is highest.
    folded = [straight(1.0, 1.5, heights=(2.0, 0.5), folds=(True, False))]
    assert resonance_peak(folded, omega, np.where(omega < 1.0, 0.2, 2.4 - omega), 0.0, 2.5).omega == 1.0


def test_edges_of_a_band():
    values = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    found = edges(values, [False, True, None, False, False, True])
    assert [(edge.appears, edge.low, edge.high) for edge in found] == [(True, 0, 1), (False, 1, 3), (True, 4, 5)]
    assert [edge.place for edge in band_edges(found, 0.0, 3.0)] == ["inside", "inside"]
    assert [(edge.value, edge.place) for edge in band_edges(found, 3.0, 4.0)] == [(2.0, "below"), (4.5, "above")]
    assert [(edge.value, edge.place) for edge in band_edges(found, 2.0, 2.0)] == [(2.0, "below"), (4.5, "above")]
    assert nearest_edge(found, True, 3.0, 4.0) == Edge(True, 4.0, 5.0) and nearest_edge([], True, 0.0, 1.0) is None
    assert edges(values, [True] * 6) == () and band_edges((), 0.0, 1.0) == ()


@pytest.mark.parametrize(
    ("band", "axis", "expected"),
    [
        (Band("1", 1.0, 1.0, ()), Axis("b", 0.0, 2.0, 5), [2]),
        (Band("1", 1.0, 1.0, ()), Axis("b", 0.0, 0.9, 5), []),
        (Band("0.2-0.6", 0.2, 0.6, ()), Axis("b", 0.0, 1.0, 11), [2, 3, 4, 5, 6]),
        (Band("> 0.5", 0.5, np.inf, (), above=True), Axis("b", 0.0, 1.0, 5), [3, 4]),
        (Band("0.2-0.6", 0.2, 0.6, ()), Axis("b", 0.0, 1.0, 2), []),
    ],
)
def test_rows_of_a_band(band, axis, expected):
    assert band_rows(band, axis).tolist() == expected


BESIDE = 1e-6


@pytest.mark.parametrize(
    ("widths", "expected"),
    [
        ([0.0, 0.0], "none"),
        ([PROMINENT_JUMP - BESIDE], "narrow"),
        ([PROMINENT_JUMP], "prominent"),
        ([0.010, 0.0110], "narrow, steady"),
        ([0.010, 0.0112], "narrow, increasing"),
        ([0.10, 0.08], "prominent, decreasing"),
        ([0.0, 0.0, 0.1, 0.1], "prominent in 2 of 4 rows, increasing"),
    ],
)
def test_jump_class(widths, expected):
    assert jump_class(widths) == expected


@pytest.mark.parametrize(
    ("ranks", "share", "expected"),
    [
        ([], np.nan, "no region"),
        ([0, 0], 1.0, "none"),
        ([3], 0.001, "double-sided (<1 %)"),
        ([2, 2, 0], 0.4, "single-sided to none (single-sided in 40 %)"),
        ([0, 3, 0], 0.1, "none, up to double-sided (double-sided in 10 %)"),
        ([1, 1], 1.0, "out of contact (100 %)"),
    ],
)
def test_impact_class(ranks, share, expected):
    assert impact_class(ranks, share) == expected


def test_impact_states_count_from_their_share_on():
    cells = round(1.0 / IMPACT_SHARE)
    assert worst_impact([cells, 0, 1, 0, 0, 0], cells) == 3 and worst_impact([cells, 0, 1, 0, 0, 0], cells + 1) == 0
    assert worst_impact([0, 0, 0, 0, 5, 0], 5) == 2 and worst_impact([0] * 6, 0) == 0


@pytest.mark.parametrize(
    ("shifts", "linear", "expected"),
    [
        ([], [], "no peak"),
        ([-NEAR_LINEAR], [False], "near linear"),
        ([-NEAR_LINEAR - BESIDE], [False], "softening"),
        ([NEAR_LINEAR + BESIDE], [False], "hardening"),
        ([-0.1], [True], "linear"),
        ([-0.1, 0.1], [False, False], "softening to hardening"),
        ([-0.1, 0.0, -0.1], [False, False, False], "softening, near linear between"),
    ],
)
def test_resonance_class(shifts, linear, expected):
    assert resonance_class(shifts, linear) == expected


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((0, 0, 0, [0.0], []), "no region"),
        ((10, 0, 0, [0.0], [0.1]), "stable"),
        ((10, 0, 0, [0.001], [0.1]), "conditional (within less than a cell)"),
        ((10, 5, 0, [0.1], [0.1]), "conditional (50 %)"),
        ((10, 5, 1, [0.1], [0.1]), "unstable (50 %)"),
        ((10, 0, 0, [0.0, 0.0], [0.1, 0.1 + SETTLED - BESIDE]), "stable, settled"),
        ((10, 0, 0, [0.0, 0.0], [0.1, 0.1 + SETTLED + BESIDE]), "stable, moving"),
        ((10, 1, 0, [0.1, 0.1 + SETTLED + BESIDE], [0.1, 0.1]), "conditional (10 %), moving"),
        ((10, 0, 0, [0.0, 0.0], [0.1]), "stable, moving"),
    ],
)
def test_stability_class(arguments, expected):
    assert stability_class(*arguments) == expected


def test_percent_never_hides_what_is_there():
    assert [percent(share) for share in (0.0, 0.001, 0.0051, 0.5, 1.0)] == ["0 %", "<1 %", "1 %", "50 %", "100 %"]
