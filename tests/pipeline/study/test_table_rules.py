"""Rules behind the tables: peaks, edges, bands, verbal classes and verdicts, on made-up bands and at thresholds."""

import dataclasses
import doctest

import numpy as np
import pytest

import pipeline.plane.resonances
import pipeline.study.numerals
from pipeline.plan.axes import Axis
from pipeline.plan.numerics import model_at, seeds_of
from pipeline.plane.labels import TRAITS, contact_lost, double_sided, intervals, jumping, labels_with, share_of
from pipeline.plane.peaks import Peak, resonance_peak, solved
from pipeline.plane.resonances import resonances_of
from pipeline.plane.segments import BranchSegment
from pipeline.plane.stored import StoredPlane
from pipeline.study.agreement import AGREES, DIFFERS, NOT_COMPARED, THRESHOLD_AGREES
from pipeline.study.tables import claims, classes
from pipeline.study.tables.article import ARTICLE_TABLES, Band, band_range, band_rows
from pipeline.study.tables.bands import BandAtResonance
from pipeline.study.tables.claims import READINGS, Claim, Entry, Verdict, judge
from pipeline.study.tables.classes import (
    ASPECTS,
    IMPACT_SHARE,
    NEAR_LINEAR,
    PROMINENT_JUMP,
    SETTLED,
    impact_class,
    jump_class,
    resonance_class,
    settled,
    severest,
)
from pipeline.study.tables.edges import Edge, band_edges, edges, nearest_edge
from pipeline.study.tables.lacking import Lacking, lacking_in
from pipeline.study.tables.rows import RowPeak
from solver import Event, enumerate_row, sweep_row
from solver.regions import bands as parts
from tests.conftest import published
from tests.pipeline.analysis.margins import made_attractors
from tests.pipeline.planes import small_plan, small_store, traced_store

BESIDE = 1e-6


@pytest.mark.parametrize("module", [pipeline.study.numerals, pipeline.plane.resonances, claims, classes])
def test_the_examples_run(module):
    found = doctest.testmod(module)
    assert found.failed == 0 and found.attempted > 0


# Peaks ---------------------------------------------------------------------------------------------------------------


def one_branch(omega, amplitude, event=None):
    event = np.zeros(omega.size, int) if event is None else event
    return {"position": omega, "amplitude": amplitude, "branch": np.zeros(omega.size, int), "event": event}


def test_what_counts_as_a_peak():
    omega = np.linspace(0.0, 2.0, 41)

    def peak(height, low=0.0, high=2.5):
        return resonance_peak(one_branch(omega, height), [BranchSegment(0, omega.size, 0.0, 2.0, True, 0)], low, high)

    bell = np.exp(-(((omega - 1.03) / 0.2) ** 2))
    found = peak(bell)
    assert found.omega == pytest.approx(1.03, abs=2e-3) and found.amplitude == pytest.approx(1.0, abs=2e-3)
    assert not found.fold
    assert peak(np.linspace(0.0, 1.0, 41)) is None, "the end of the range is no peak"
    assert peak(1.0 + 0.2 * bell) is None, "it never falls to half its power"
    assert peak(1.0 - omega / 2.0 + 0.3 * np.exp(-(((omega - 0.6) / 0.05) ** 2))) is None, "a shoulder"
    assert peak(bell, 3.0, 4.0) is None, "a part that the branch does not reach"
    assert resonance_peak(one_branch(omega, bell), [BranchSegment(0, 41, 0.0, 2.0, False, 0)], 0.0, 2.5) is None, (
        "unstable"
    )


def test_a_peak_on_a_fold():
    # Rising and stable to the fold at 1.5, back unstable to the fold at 1.2, falling and stable from there.
    omega = np.concatenate([np.linspace(0.5, 1.5, 21), np.linspace(1.5, 1.2, 11)[1:], np.linspace(1.2, 2.5, 21)[1:]])
    falling = np.concatenate([np.linspace(2.0, 1.0, 11)[1:], np.linspace(1.0, 0.1, 21)[1:]])
    amplitude = np.concatenate([np.linspace(0.1, 2.0, 21), falling])
    event = np.zeros(omega.size, int)
    event[[20, 30]] = Event.FOLD
    segments = [
        BranchSegment(0, 21, 0.5, 1.5, True, 0),
        BranchSegment(20, 31, 1.2, 1.5, False, 0),
        BranchSegment(30, omega.size, 1.2, 2.5, True, 0),
    ]
    found = resonance_peak(one_branch(omega, amplitude, event), segments, 0.0, 3.0)
    assert found == Peak(1.5, 2.0, True) and solved(published(), found) is found


def test_a_peak_is_solved_for():
    """From whatever nearby start the same peak, at which the amplitude is largest."""
    model = published(f_pm=0.75)
    omega = np.linspace(1.2, 1.35, 301)
    grid = enumerate_row(model, "omega", omega)
    assert np.all(grid.n_solutions == 1)
    top = int(np.argmax(grid.amplitude[:, 0]))
    starts = [Peak(float(omega[i]), float(grid.amplitude[i, 0]), False) for i in (top - 3, top, top + 3)]
    found = [solved(model, start) for start in starts]
    assert [peak.omega for peak in found] == pytest.approx([found[1].omega] * 3, abs=1e-7)
    beside = enumerate_row(model, "omega", found[1].omega + np.array([-1e-4, 0.0, 1e-4]))
    assert beside.amplitude[1, 0] == pytest.approx(found[1].amplitude, abs=1e-10)
    assert np.all(beside.amplitude[[0, 2], 0] < found[1].amplitude)


# Edges, bands, labels ------------------------------------------------------------------------------------------------


def test_edges_of_a_band():
    found = edges([(0.0, 0.5, 0.1), (2.0, 3.5, 0.1), (4.5, 5.0, 0.1)], 0.0, 5.0)
    assert found == (Edge(False, 0.5), Edge(True, 2.0), Edge(False, 3.5), Edge(True, 4.5)), "borders are no edges"
    assert band_edges(found, 0.0, 3.0) == (Edge(False, 0.5), Edge(True, 2.0))
    assert band_edges(found, 4.0, 4.2) == (Edge(False, 3.5, "below"), Edge(True, 4.5, "above"))
    assert nearest_edge(found, True, 4.0, 4.2) == Edge(True, 4.5) and nearest_edge([], True, 0.0, 1.0) is None
    assert nearest_edge(found, False, 0.0, 4.0) == Edge(False, 0.5), "the first inside"
    assert band_edges((), 0.0, 1.0) == () and edges([], 0.0, 1.0) == ()


@pytest.mark.parametrize(
    ("band", "axis", "rows", "covered"),
    [
        (Band("1", 1.0, 1.0, ()), Axis("b", 0.0, 2.0, 5), [2], (1.0, 1.0)),
        (Band("1", 1.1, 1.1, ()), Axis("b", 0.0, 2.0, 5), [2], (1.1, 1.1)),
        (Band("1", 1.0, 1.0, ()), Axis("b", 0.0, 0.9, 5), [], None),
        (Band("0.2-0.6", 0.2, 0.6, ()), Axis("b", 0.0, 1.0, 11), [2, 3, 4, 5, 6], (0.2, 0.6)),
        (Band("> 0.5", 0.5, np.inf, (), above=True), Axis("b", 0.0, 1.0, 5), [3, 4], (0.5, 1.0)),
        (Band("0.2-0.6", 0.2, 0.6, ()), Axis("b", 0.0, 1.0, 2), [], (0.2, 0.6)),
        (Band("0.2-0.6", 0.2, 0.6, ()), Axis("b", 0.6, 1.0, 2), [0], None),
    ],
)
def test_rows_and_range_of_a_band(band, axis, rows, covered):
    assert band_rows(band, axis).tolist() == rows and band_range(band, axis) == covered


def test_traits_of_labels():
    labels = ("0/-", "1/0", "1/1", "1/0m", "1/f", "2/0-1", "2/0-2", "3/0-1-2")
    assert labels_with(labels, jumping) == ("2/0-1", "2/0-2", "3/0-1-2")
    assert labels_with(labels, contact_lost) == ("1/1", "1/f", "2/0-1", "2/0-2", "3/0-1-2")
    assert labels_with(labels, double_sided) == ("2/0-2", "3/0-1-2")
    assert share_of({"1/0": 0.5, "2/0-1": 0.2, "2/0-2": 0.3}, jumping) == pytest.approx(0.5)
    line = parts.Line(1.0, ("2/0-1", "1/0", "2/0-1", "2/1", "1/0"), np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0]))
    assert intervals(line, jumping) == ((0.0, 1.0), (2.0, 4.0)) and intervals(line, double_sided) == ()


# Classes -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("widths", "height", "expected"),
    [
        ([0.0, 0.0], 0.0, "no jump"),
        ([PROMINENT_JUMP - BESIDE], 1.0, "narrow"),
        ([PROMINENT_JUMP], 1.0, "prominent"),
        ([0.010, 0.0110], 1.0, "narrow, steady"),
        ([0.010, 0.0112], 1.0, "narrow, increasing"),
        ([0.10, 0.08], 1.0, "prominent, decreasing"),
        ([0.0, 0.0, 0.1, 0.1], 0.4, "prominent in 40 % of the band, increasing"),
    ],
)
def test_jump_class(widths, height, expected):
    assert jump_class(widths, height) == expected


@pytest.mark.parametrize(
    ("ranks", "share", "expected"),
    [
        ([0, 0], 1.0, "no impact"),
        ([3], 0.0001, "double-sided (<0.1 %)"),
        ([2, 2, 0], 0.4, "single-sided to no impact (single-sided in 40 %)"),
        ([0, 3, 0], 0.1, "no impact, up to double-sided (double-sided in 10 %)"),
        ([1, 1], 1.0, "out of contact (100 %)"),
    ],
)
def test_impact_class(ranks, share, expected):
    assert impact_class(ranks, share) == expected


def test_impact_states_count_from_their_share_on():
    assert severest({"1/0": 1.0 - IMPACT_SHARE, "1/2": IMPACT_SHARE}) == 3
    assert severest({"1/0": 1.0, "1/2": IMPACT_SHARE - 1e-9}) == 0
    # A state is counted over all labels that hold it.
    assert severest({"1/0": 0.9, "1/2": 0.6 * IMPACT_SHARE, "2/0-2": 0.6 * IMPACT_SHARE}) == 3
    assert severest({"1/1m": 1.0}) == severest({"1/1": 1.0}) == 2 and severest({"1/f": 1.0}) == 1 and severest({}) == 0


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
    ("widths", "shifts", "expected"),
    [
        ([0.0, 0.0], [0.1, 0.1 + SETTLED - BESIDE], True),
        ([0.0, 0.0], [0.1, 0.1 + SETTLED + BESIDE], False),
        ([0.1, 0.1 + SETTLED + BESIDE], [0.1, 0.1], False),
        ([0.0, 0.0], [0.1, np.nan], False),
        ([0.0, 0.0], [], False),
    ],
)
def test_settled(widths, shifts, expected):
    assert settled(widths, shifts) == expected


# Verdicts ------------------------------------------------------------------------------------------------------------

MESH, SHAFT = resonances_of(0.5, 2.0)


def made_up(labels_by_line, widths, shares, shifts=(0.0, 0.0), found=None, resonance=MESH, lacking=0.0, born=""):
    """A band whose lines show a jump of given width, then one label for the rest."""
    made = []
    for value, (label, width) in enumerate(zip(labels_by_line, widths, strict=True)):
        ends = np.array([0.0, width * resonance.natural, 1.0])
        made.append(parts.Line(float(value), ("2/0-1" if width else label, label), ends))
    peaks = tuple(
        RowPeak(float(i), resonance.natural, Peak(resonance.natural * (1.0 + shift), 1.0, False), False)
        for i, shift in enumerate(shifts)
    )
    region = parts.Band(0.0, 1.0, shares, 0.0)
    none = dict.fromkeys(TRAITS, ())
    return BandAtResonance(
        resonance,
        region,
        tuple(made),
        float(any(widths)),
        none | (found or {}),
        peaks,
        (False,) * len(peaks),
        Lacking(lacking, "dynamic stability"),
        born,
        0,
    )


def verdict(rule, here, before=None, value=None, where=("mesh",)):
    entry = Entry("made up", (Claim(rule, where, value),))
    return judge(entry, {"mesh": here}, {} if before is None else {"mesh": before})


QUIET = made_up(("1/0", "1/0"), (0.0, 0.0), {"1/0": 1.0})
WILD = made_up(("1/2", "1/1"), (0.02, 0.08), {"1/2": 0.3, "1/1": 0.7}, (-0.05, 0.05))


@pytest.mark.parametrize(
    ("rule", "holds", "fails"),
    [
        ("jump prominent", WILD, QUIET),
        ("jump not prominent", QUIET, WILD),
        ("jump grows", WILD, QUIET),
        ("jump settled", QUIET, WILD),
        ("double-sided", WILD, QUIET),
        ("double- to single-sided", WILD, QUIET),
        ("single-sided to none", made_up(("1/1", "1/0"), (0.0, 0.0), {"1/0": 1.0}), WILD),
        ("softening", made_up(("1/0", "1/0"), (0.0, 0.0), {"1/0": 1.0}, (-0.1, -0.05)), WILD),
        ("below natural", made_up(("1/0", "1/0"), (0.0, 0.0), {"1/0": 1.0}, (-0.001, -0.001)), WILD),
        ("softening to hardening", WILD, QUIET),
        ("peak settled", QUIET, WILD),
        ("somewhere none stable", made_up(("1/0", "1/0"), (0.0, 0.0), {"1/0": 1.0}, lacking=0.1), WILD),
        ("everywhere one stable", WILD, made_up(("1/0", "1/0"), (0.0, 0.0), {"1/0": 1.0}, lacking=0.1)),
    ],
)
def test_claims_hold_and_fail(rule, holds, fails):
    assert verdict(rule, holds).kind == AGREES
    found = verdict(rule, fails)
    assert found.kind == DIFFERS and found.reason.endswith("(mesh)")


def test_claims_against_the_band_before():
    for rule in ("jump smaller", "double-sided less"):
        assert verdict(rule, QUIET, WILD).kind == AGREES and verdict(rule, WILD, QUIET).kind == DIFFERS
        assert verdict(rule, QUIET) == Verdict(NOT_COMPARED, "the band before not measured")
    isola = dataclasses.replace(WILD, born="isola born at b = 0.5")
    assert verdict("jump smaller", isola, QUIET).reason == "isola born at b = 0.5, which sweeps miss (mesh)"


def test_stability_without_a_row_is_not_compared():
    unknown = made_up(("1/0", "1/0"), (0.0, 0.0), {"1/0": 1.0}, lacking=np.nan)
    assert verdict("everywhere one stable", unknown).kind == NOT_COMPARED


@pytest.mark.parametrize("what", sorted(TRAITS))
def test_thresholds_are_compared_with_the_articles(what):
    def ends_at(*values):
        return made_up(("1/0", "1/0"), (0, 0), {"1/0": 1.0}, found={what: tuple(Edge(False, v) for v in values)})

    within, beyond = (0.25 * (1.0 + THRESHOLD_AGREES + d) for d in (-BESIDE, 2 * BESIDE))
    assert verdict(f"{what} ends", ends_at(within), value=0.25).kind == AGREES
    assert verdict(f"{what} ends", ends_at(beyond, 0.9), value=0.25).kind == DIFFERS
    assert verdict(f"{what} ends", ends_at(0.278), value=0.25) == Verdict(
        DIFFERS, f"{what} ends at 0.278, article 0.25 (+11 %) (mesh)"
    )
    assert "−10 %" in verdict(f"{what} ends", ends_at(0.225), value=0.25).reason
    assert "does not end in this plane" in verdict(f"{what} ends", QUIET, value=0.25).reason


def test_a_claim_holds_at_one_of_its_resonances():
    bands = {"mesh": QUIET, "shaft": dataclasses.replace(WILD, resonance=SHAFT)}
    one = Entry("", (Claim("double-sided"),))
    assert judge(one, bands, {}) == Verdict(AGREES, "double-sided in 30 % (shaft)")
    both = Entry("", (Claim("double-sided", ("mesh",)), Claim("double-sided", ("shaft",))))
    # What differs is said, and nothing else.
    assert judge(both, bands, {}) == Verdict(DIFFERS, "no impact (mesh)")
    assert judge(one, {"mesh": QUIET}, {}) == Verdict(NOT_COMPARED, "shaft not measured")
    for here in (bands, {}):
        assert judge(Entry("", unclear="too vague"), here, {}) == Verdict(NOT_COMPARED, "too vague")


@pytest.mark.costly
def test_stability_is_by_integration_where_there_is_one_else_by_curves_else_by_cells(tmp_path):
    """At the shaft resonance, b from 0.98 on, a tenth of the region has no stable motion of one period."""
    plan = small_plan("plane=omega_b", "plane.parameter.min=0.98", "plane.parameter.max=1.5", columns=160, rows=5)
    x, p = (0.9373, 2.0), (0.98, 1.5)
    traced = traced_store(tmp_path / "traced.zarr", plan)
    bare = small_store(tmp_path / "bare.zarr", plan)
    exact, counted = (lacking_in(StoredPlane(path, plan), x, p) for path in (traced, bare))
    assert exact.source == counted.source == "dynamic stability"
    # From a row of 2,000 motions: backlash does not matter here.
    fine = sweep_row(model_at(plan, 1.2, 1.0), "omega", np.linspace(*x, 2000), seeds=seeds_of(plan.solver))
    expected = np.mean(~np.any((fine.stable == 1) & (fine.instability == 0), axis=1))
    assert exact.share == pytest.approx(expected, abs=2e-3) and expected > 0.1
    assert counted.share == pytest.approx(exact.share, abs=0.01)
    single = lacking_in(StoredPlane(traced, plan), x, (1.2, 1.2))
    assert single.share == pytest.approx(exact.share, abs=2e-3)
    made_attractors.put_attractors(traced, plan, {})
    assert lacking_in(StoredPlane(traced, plan), x, p) == Lacking(0.0, "integration")
    columns = np.flatnonzero((plan.sweep.values >= x[0]) & (plan.sweep.values <= x[1]))
    cells = {(2, columns[3]): [made_attractors.LOUD], (1, columns[0]): [made_attractors.QUIET, made_attractors.LOUD]}
    made_attractors.put_attractors(traced, plan, cells)
    assert lacking_in(StoredPlane(traced, plan), x, p).share == 1.0 / (5 * columns.size)
    # Of a part of its cells nothing is told about the whole.
    made_attractors.put_attractors(traced, plan, {}, columns=columns[:-1])
    assert lacking_in(StoredPlane(traced, plan), x, p) == exact


def test_every_entry_of_the_article_has_a_meaning_or_a_reason():
    for article in ARTICLE_TABLES:
        for band in article.bands:
            assert len(band.entries) == len(article.columns)
            for entry in band.entries:
                assert entry.claims or entry.unclear
                for claim in entry.claims:
                    assert claim.rule in READINGS and claim.resonances
                    assert (claim.value is not None) == claim.rule.endswith("ends")
        assert all(aspect in ASPECTS for column in article.columns for aspect in column.aspects)
