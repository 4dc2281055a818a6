"""Regions of equal label: thresholds, shares and neighbours against rows and enumeration."""

import dataclasses
import functools

import numpy as np
import pytest

from solver import Event, ParameterError, domain_code, domain_label, enumerate_row, impact_state, sweep_row
from solver.boundaries import boundary_curves, row_events
from solver.regions.bands import band, lines
from solver.regions.regions import RegionError, regions
from tests.conftest import consistent, published

OMEGA = (0.05, 2.0)
GRID = np.linspace(*OMEGA, 60)
RANGES = {"b": (0.02, 1.5), "alpha": (0.0, 0.8), "f_e": (0.0, 0.5), "f_pm": (0.3, 1.2)}
MESH, SHAFT = (0.05, 0.9), (0.9, 2.0)
WINDOWS = {"mesh": MESH, "shaft": SHAFT}
ROWS = 41
each_plane = pytest.mark.parametrize("axis", list(RANGES))


@functools.cache
def row(axis, value):
    return sweep_row(published(**{axis: value}), "omega", GRID)


@functools.cache
def curves_of(axis):
    values = np.linspace(*RANGES[axis], ROWS).tolist()
    starts = [event for value in values for event in row_events(row(axis, value).curves, value)]
    return boundary_curves(published(), "omega", axis, OMEGA, RANGES[axis], starts)


@functools.cache
def regions_of(axis):
    return regions(published(), "omega", axis, OMEGA, RANGES[axis], curves_of(axis))


def labels_at(model, x):
    """Labels at places of a row, proven; "" where undecided."""
    found = enumerate_row(model, "omega", x)
    states = impact_state(found.mean - found.amplitude, found.mean + found.amplitude, model.b).astype(int)
    bits = np.bitwise_or.reduce(np.where(found.stable == 1, 1 << states.clip(0), 0), axis=1)
    codes = np.where(found.proof == 1, domain_code(np.sum(found.stable == 1, axis=1), bits), 0)
    return [domain_label(code) for code in codes]


def row_segments(axis, value, window=OMEGA):
    """Edges and labels along a row: its own folds and grazings, and the solutions enumerated between."""
    events = [point[3] for _, point in row_events(row(axis, value).curves, value)]
    edges = np.array([window[0], *sorted(x for x in events if window[0] < x < window[1]), window[1]])
    labels = labels_at(published(**{axis: value}), 0.5 * (edges[1:] + edges[:-1]))
    ends, names = [edges[0]], []
    for right, label in zip(edges[1:], labels, strict=True):
        if names and label == names[-1]:
            ends[-1] = right
        elif right - ends[-1] > 1e-11:
            names.append(label)
            ends.append(right)
    return np.array(ends), names


# Thresholds ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("axis", "label", "window", "place", "value", "digits"),
    [
        ("b", "2/0-2", "mesh", -1, 1.011, 5e-4),
        ("b", "1/2", "mesh", -1, 0.62, 1e-2),
        ("b", "2/0-1", "mesh", 0, 0.62, 1e-2),
        ("b", "1/2", "shaft", -1, 0.18, 5e-3),
        ("f_e", "1/1", "shaft", 0, 0.140, 5e-4),
        ("f_e", "2/0-2", "mesh", 0, 0.198, 5e-4),
        ("f_e", "2/1-2", "mesh", 0, 0.321, 5e-4),
        ("f_e", "2/2", "mesh", 0, 0.370, 5e-4),
        ("alpha", "2/1", "shaft", 1, 0.278, 5e-4),
        ("alpha", "1/1", "shaft", 1, 0.388, 5e-4),
        ("f_pm", "2/1", "shaft", -1, 0.5855, 5e-5),
        ("f_pm", "1/1", "shaft", -1, 0.714, 5e-4),
    ],
)
def test_thresholds_of_the_published_gear(axis, label, window, place, value, digits):
    """docs/physics.md, section 7."""
    found = np.ravel(regions_of(axis).thresholds(label, WINDOWS[window]))
    assert found[place] == pytest.approx(value, abs=digits)


def row_width(axis, value, label, window):
    """Largest width of a label in a row; 0 where it does not occur."""
    ends, names = row_segments(axis, value, window)
    return max((width for width, name in zip(np.diff(ends), names, strict=True) if name == label), default=0.0)


@each_plane
@pytest.mark.parametrize("window", list(WINDOWS))
def test_thresholds_against_rows(axis, window):
    """Rows beyond a threshold do not have the label; its widths in rows before it fall to 0 there, to 1e-6.

    They fall with the distance d to the power 1/2 (extrema), 1 (intersections), 3/2 (cusps) or 2 (a grazing that leaves
    a fold). Rows 1e-6 from the threshold would not do: of some regions they see 1e-12, and isolas they may miss.
    """
    step, window = 1e-5, WINDOWS[window]
    checked = 0
    for label in regions_of(axis).within(window).labels:
        for ends in regions_of(axis).thresholds(label, window):
            for value, inwards in zip(ends, (step, -step), strict=True):
                if value in RANGES[axis]:
                    continue
                checked += 1
                assert row_width(axis, value - 0.1 * inwards, label, window) == 0.0, (label, value)
                near, far = (row_width(axis, value + d * inwards, label, window) for d in (1, 2))
                power = np.log2(far / near)
                assert power == pytest.approx(round(2.0 * power) / 2.0, abs=0.02)
                near, far = (width ** (2.0 / round(2.0 * power)) for width in (near, far))
                assert (2.0 * near - far) / (far - near) * step == pytest.approx(0.0, abs=1e-6), (label, value)
    assert checked > 0


# Shares --------------------------------------------------------------------------------------------------------------


@each_plane
def test_shares_add_up(axis):
    whole = regions_of(axis)
    assert sum(whole.shares.values()) == pytest.approx(1.0, abs=1e-12)
    assert set(whole.shares) == set(whole.labels) and min(whole.shares.values()) > 0.0
    assert whole.error < 1e-8
    for label in whole.labels:
        assert sum(found.share for found in whole.occurrences(label)) == pytest.approx(whole.shares[label], abs=1e-14)
    assert whole.occurrences("7/0") == ()


@each_plane
def test_shares_are_those_of_the_parts(axis):
    """Four windows are divided and integrated otherwise, but add up to the same areas to 1e-8."""
    whole, (low, high) = regions_of(axis), RANGES[axis]
    total = dict.fromkeys(whole.labels, 0.0)
    middle, cut = low + (high - low) / np.pi, 0.05 + 1.95 / np.e
    for x_window in ((OMEGA[0], cut), (cut, OMEGA[1])):
        for p_window in ((low, middle), (middle, high)):
            weight = np.ptp(x_window) / np.ptp(OMEGA) * np.ptp(p_window) / (high - low)
            for label, share in whole.within(x_window, p_window).shares.items():
                total[label] += share * weight
    for label, share in whole.shares.items():
        assert total[label] == pytest.approx(share, abs=1e-8)


@pytest.mark.parametrize("axis", ["b", "alpha"])
def test_shares_against_enumeration(axis):
    """Every solution at 40 000 places, evenly spread, the columns shifted from row to row."""
    rows, columns, (low, high) = 100, 400, RANGES[axis]
    counts = dict.fromkeys(regions_of(axis).labels, 0)
    for i in range(rows):
        shift = (i * (5**0.5 - 1.0) / 2.0) % 1.0
        x = OMEGA[0] + np.ptp(OMEGA) * (np.arange(columns) + shift) / columns
        for label in labels_at(published(**{axis: low + (high - low) * (i + 0.5) / rows}), x):
            counts[label] += 1
    for label, share in regions_of(axis).shares.items():
        assert counts[label] / (rows * columns) == pytest.approx(share, abs=3e-4)


def test_branches_that_leave_through_the_ceiling():
    """Beyond alpha = 0.6 the consistent gear has branches of infinite amplitude; what lies above 100 does not count."""
    values, bounds = np.linspace(0.6, 0.72, 13), (0.6, 0.72)
    starts = [
        event
        for v in values
        for event in row_events(sweep_row(consistent(alpha=float(v)), "omega", GRID).curves, float(v))
    ]
    curves = boundary_curves(consistent(), "omega", "alpha", OMEGA, bounds, starts)
    whole = regions(consistent(), "omega", "alpha", OMEGA, bounds, curves)
    added = whole.curves[len(curves) :]
    assert len(added) == 2
    for curve in added:
        np.testing.assert_allclose(curve.amplitude, 100.0, rtol=1e-12)
        for point in curve.points[::9]:
            found = enumerate_row(consistent(alpha=point[4]), "omega", [point[3]], amplitude_max=200.0)
            assert np.nanmin(np.abs(found.amplitude[0] - 100.0)) < 1e-6
    assert "2/1-2" in whole.neighbours("1/1") and Event.NONE in whole.neighbours("1/1")["2/1-2"]
    rows, columns = 60, 400
    counts = dict.fromkeys(whole.labels, 0)
    for i in range(rows):
        shift = (i * (5**0.5 - 1.0) / 2.0) % 1.0
        x = OMEGA[0] + np.ptp(OMEGA) * (np.arange(columns) + shift) / columns
        for label in labels_at(consistent(alpha=bounds[0] + np.ptp(bounds) * (i + 0.5) / rows), x):
            counts[label] += 1
    for label, share in whole.shares.items():
        assert counts[label] / (rows * columns) == pytest.approx(share, abs=5e-4)


@each_plane
def test_rows_have_the_labels_of_their_slab(axis):
    rng = np.random.default_rng(11)
    whole = regions_of(axis)
    for value in rng.uniform(*RANGES[axis], 8):
        (part,) = [p for p in whole.slabs if p.slab.low < value < p.slab.high]
        ends, names = row_segments(axis, float(value))
        assert tuple(names) == part.labels
        edges = [
            OMEGA[arc[1]] if arc[0] < 0 else whole.curves[arc[0]].crossings([value])[1][arc[1], 3]
            for arc in part.slab.arcs
        ]
        np.testing.assert_allclose(edges, ends, rtol=0, atol=1e-9)


# Neighbours ----------------------------------------------------------------------------------------------------------


@each_plane
def test_neighbours(axis):
    """A fold changes the number of stable solutions by one, a grazing their states alone; both see each other."""
    whole = regions_of(axis)
    for label in whole.labels:
        for other, kinds in whole.neighbours(label).items():
            assert whole.neighbours(other)[label] == kinds
    for frontier in whole.adjacency:
        (n, states), (m, others) = (text.split("/") for text in frontier.labels)
        assert frontier.length > 0.0
        if frontier.kind is Event.FOLD:
            assert int(m) - int(n) == 1
            assert set(states.split("-")) <= set(others.split("-"))
        else:
            assert n == m
            assert set(states.split("-")) ^ set(others.split("-")) <= {*"01"} | {*"12"}
    assert {label for frontier in whole.adjacency for label in frontier.labels} == set(whole.labels)
    assert whole.neighbours("1/0")["1/1"] == (Event.MIN_AT_DRIVE,)
    assert whole.neighbours("1/0")["2/0-1"] == (Event.FOLD,)


# Odd planes ----------------------------------------------------------------------------------------------------------


def test_one_label_everywhere():
    whole = regions(published(), "omega", "b", (1.5, 1.6), (1.0, 1.2), ())
    assert whole.labels == ("1/0",) and whole.shares["1/0"] == pytest.approx(1.0, abs=1e-14) and whole.adjacency == ()
    assert whole.thresholds("1/0") == ((1.0, 1.2),)
    assert whole.error < 1e-13


def test_tiny_window():
    """Where three labels meet, 1e-5 wide: as whole shares as in the large, and the same threshold."""
    whole = regions_of("alpha")
    value = whole.thresholds("2/0-1", SHAFT)[0][1]
    ends, names = row_segments("alpha", value - 1e-7, SHAFT)
    x = ends[names.index("2/0-1")]
    corner = whole.within((x - 5e-6, x + 5e-6), (value - 5e-6, value + 5e-6))
    assert len(corner.labels) >= 3
    assert sum(corner.shares.values()) == pytest.approx(1.0, abs=1e-12)
    for label in corner.labels:
        for end in np.ravel(corner.thresholds(label)):
            assert value - 5e-6 <= end <= value + 5e-6
    rows, columns = 60, 60
    counts = dict.fromkeys(corner.labels, 0)
    for p in value + 1e-5 * ((np.arange(rows) + 0.5) / rows - 0.5):
        for label in labels_at(published(alpha=p), x + 1e-5 * ((np.arange(columns) + 0.5) / columns - 0.5)):
            counts[label] += 1
    for label, share in corner.shares.items():
        assert counts[label] / (rows * columns) == pytest.approx(share, abs=0.02)


def test_any_two_parameters_span_a_plane():
    """Backlash over frequency: rows along another axis, the frequency from row to row.

    As long as the teeth part on one side only, backlash does not matter, and the boundaries run along rows.
    """
    frequencies, grid = np.linspace(0.55, 0.65, 21), np.linspace(0.02, 1.5, 40)
    starts = [
        event
        for f in frequencies
        for event in row_events(sweep_row(published(), "b", grid, omega=float(f)).curves, float(f))
    ]
    curves = boundary_curves(published(), "b", "omega", (0.02, 1.5), (0.55, 0.65), starts)
    turned = regions(published(), "b", "omega", (0.02, 1.5), (0.55, 0.65), curves)
    straight = regions_of("b").within((0.55, 0.65))
    assert turned.labels == straight.labels
    for label in turned.labels:
        assert turned.shares[label] == pytest.approx(straight.shares[label], abs=1e-8)


# What is not guessed -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [Event.FOLD, Event.MIN_AT_DRIVE])
def test_a_missing_boundary_is_noticed(kind):
    curves = [curve for curve in curves_of("f_pm") if curve.kind is not kind]
    with pytest.raises(RegionError, match="no boundary parts different labels: .* of \\(omega, f_pm\\)"):
        regions(published(), "omega", "f_pm", OMEGA, RANGES["f_pm"], curves)


def test_a_boundary_that_ends_early_is_noticed():
    start = np.array([1.5, 0.5, 0.2, 0.9, 0.4])
    curves = boundary_curves(published(), "omega", "alpha", OMEGA, RANGES["alpha"], [(Event.FOLD, start)])
    with pytest.raises(RegionError, match="a FOLD boundary ends early"):
        regions(published(), "omega", "alpha", OMEGA, RANGES["alpha"], curves)


def test_windows_lie_in_the_plane():
    for window in ((0.0, 1.0), (1.0, 1.0), (1.0, 3.0)):
        with pytest.raises(ParameterError) as caught:
            regions_of("f_pm").thresholds("1/0", window)
        assert caught.value.name == "x_window"


def test_the_same_twice():
    again = regions(published(), "omega", "f_pm", OMEGA, RANGES["f_pm"], curves_of("f_pm")[::-1])
    assert again.shares == pytest.approx(regions_of("f_pm").shares, abs=1e-15)
    assert dataclasses.asdict(again.occurrences("2/0-2")[0]) == pytest.approx(
        dataclasses.asdict(regions_of("f_pm").occurrences("2/0-2")[0])
    )


# Bands and lines -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("axis", "value"), [("b", 0.1), ("b", 0.6), ("f_pm", 0.57), ("f_pm", 1.0)])
def test_a_line_is_the_row(axis, value):
    (found,) = lines(regions_of(axis), [value])
    ends, names = row_segments(axis, value)
    assert list(found.labels) == names and found.ends == pytest.approx(ends, abs=1e-8)
    assert sum(found.lengths.values()) == pytest.approx(OMEGA[1] - OMEGA[0], abs=1e-12)
    assert set(found.lengths) == set(names)


@pytest.mark.parametrize("window", [None, "mesh", "shaft"])
def test_bands_add_up(window):
    whole = regions_of("f_pm") if window is None else regions_of("f_pm").within(WINDOWS[window])
    low, high = RANGES["f_pm"]
    assert band(whole, low, high).shares == pytest.approx(whole.shares, abs=1e-9)
    cuts = [low, 0.5, 0.5855, 1.0, high]
    parts = [(band(whole, a, b), b - a) for a, b in zip(cuts[:-1], cuts[1:], strict=True)]
    for label in whole.labels:
        share = sum(part.shares.get(label, 0.0) * height for part, height in parts) / (high - low)
        assert share == pytest.approx(whole.shares[label], abs=1e-8), label
    assert all(sum(part.shares.values()) == pytest.approx(1.0, abs=1e-12) for part, _ in parts)
    assert all(part.error < 1e-7 for part, _ in parts)


def test_a_band_is_the_plane_cut_there():
    whole = regions_of("f_pm")
    cut = whole.within(SHAFT, (0.5, 0.57))
    assert band(whole.within(SHAFT), 0.5, 0.57).shares == pytest.approx(cut.shares, abs=1e-8)


def test_a_band_shrinks_to_a_line():
    part = regions_of("b").within(MESH)
    single, thin = band(part, 0.1, 0.1), band(part, 0.1 - 5e-6, 0.1 + 5e-6)
    assert single.shares == pytest.approx(thin.shares, abs=1e-6) and single.error == 0.0
    (found,) = lines(part, [0.1])
    for label, length in found.lengths.items():
        assert single.shares[label] == pytest.approx(length / (MESH[1] - MESH[0]), abs=1e-12)


def test_rows_on_the_border_of_a_slab():
    part = regions_of("f_pm")
    borders = [slab.slab.low for slab in part.slabs] + [RANGES["f_pm"][1]]
    for value, found in zip(borders, lines(part, borders), strict=True):
        assert found.value == value and np.all(np.diff(found.ends) >= 0.0)


def test_ranges_of_several_labels():
    part = regions_of("f_pm").within(SHAFT)
    several = [label for label in part.labels if not label.startswith("1")]
    ((low, high, share),) = part.ranges(several)
    each = [found for label in several for found in part.occurrences(label)]
    assert (low, high) == (min(found.appears for found in each), max(found.disappears for found in each))
    assert share == pytest.approx(sum(found.share for found in each), abs=1e-12)
    assert high == pytest.approx(0.5855, abs=5e-5)
    assert part.ranges(()) == ()


def test_bands_not_allowed():
    whole = regions_of("f_pm")
    for low, high, name in ((0.2, 0.5, "low"), (0.5, 1.3, "high"), (0.6, 0.5, "low")):
        with pytest.raises(ParameterError, match=name):
            band(whole, low, high)
    with pytest.raises(ParameterError, match="p"):
        lines(whole, [1.3])
