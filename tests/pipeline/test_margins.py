"""Design answers against brute force: labels enumerated on dense grids, boundaries bisected, rectangles tried out."""

import csv
import dataclasses
import doctest

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pipeline.margins.worst
from pipeline import boundaries, figures, store
from pipeline.__main__ import main
from pipeline.boundaries.arcs import Arcs
from pipeline.config import compose
from pipeline.errors import ConfigurationError, StoreError
from pipeline.margins import Design, answer, design_of, write_sheets
from pipeline.margins.box import largest_box
from pipeline.margins.curves import Boundaries, boundaries_of
from pipeline.margins.distances import further_axis
from pipeline.margins.lines import divided
from pipeline.margins.options import nominal_value
from pipeline.margins.sheets import lines, markdown, tidy
from pipeline.margins.worst import labels_within, severity
from pipeline.sweep import model_at
from solver import Event, domain_code, domain_label, enumerate_row, impact_state
from tests.pipeline.planes import small_plan, small_store

PLANES = ("omega_fe", "omega_b")


def traced_store(path, *overrides, columns=80, rows=12):
    plan = small_plan(*overrides, columns=columns, rows=rows)
    small_store(path, plan)
    boundaries.trace(path, plan)
    return path, plan


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    folder = tmp_path_factory.mktemp("margins")
    return {name: traced_store(folder / f"{name}.zarr", f"plane={name}") for name in PLANES}


def enumerated(plan, axis, values, x, p, **changes):
    """Labels along one parameter through (x, p), from nothing but the solver's enumeration."""
    at = {plan.sweep.name: x, plan.parameter.name: p, **changes}
    omega = at.pop("omega", plan.omega)
    at.pop(axis, None)
    model = model_at(plan, p, x).replace(**at)
    found = enumerate_row(model, axis, values, omega=None if axis == "omega" else omega)
    b = np.asarray(values) if axis == "b" else np.full(len(values), model.b)
    states = impact_state(found.mean - found.amplitude, found.mean + found.amplitude, b[:, None]).astype(int)
    stable = found.stable == 1
    masks = np.bitwise_or.reduce(np.where(stable, 1 << states.clip(0), 0), axis=1)
    return [domain_label(int(code)) for code in domain_code(stable.sum(axis=1), masks)]


def bisected(plan, axis, low, high, x, p):
    """Where the label changes between two values that have different ones."""
    (before,) = enumerated(plan, axis, [low], x, p)
    for _ in range(45):
        middle = 0.5 * (low + high)
        same = enumerated(plan, axis, [middle], x, p) == [before]
        low, high = (middle, high) if same else (low, middle)
    return 0.5 * (low + high)


def first_change(plan, axis, value, limit, x, p, steps=1500):
    """The nearest change of label from a value towards a limit, by walking and bisecting; None if there is none."""
    grid = np.linspace(value, limit, steps)
    labels = enumerated(plan, axis, grid, x, p)
    for i in range(1, steps):
        if labels[i] != labels[0]:
            return bisected(plan, axis, grid[i - 1], grid[i], x, p)
    return None


def ask(stored, *where, **more):
    path, plan = stored
    return answer(path, plan, Design(*where, **more))


@pytest.mark.parametrize(("name", "p", "ends"), [("omega_fe", 0.2, (0.5, 0.8)), ("omega_b", 0.5, (0.52, 0.78))])
def test_labels_of_a_range(stores, name, p, ends):
    _, plan = stores[name]
    found = ask(stores[name], 0.7, p, *ends)
    parts = found.row.within(*ends)
    grid = np.linspace(*ends, 3001)
    labels = enumerated(plan, "omega", grid, 0.7, p)
    changes = [i for i in range(1, grid.size) if labels[i] != labels[i - 1]]
    assert [domain_label(one.code) for one in parts] == [labels[0], *(labels[i] for i in changes)]
    expected = [bisected(plan, "omega", grid[i - 1], grid[i], 0.7, p) for i in changes]
    np.testing.assert_allclose([one.high for one in parts[:-1]], expected, atol=1e-7)
    assert (parts[0].low, parts[-1].high) == ends and len(parts) >= 5
    assert found.label == enumerated(plan, "omega", [0.7], 0.7, p)[0]


@pytest.mark.parametrize(
    ("name", "x", "p", "further"),
    [
        ("omega_fe", 0.8, 0.2, {"alpha": 0.0, "b": 0.0, "f_pm": 0.0, "xi_mesh": 0.0}),
        ("omega_b", 1.25, 0.6, {"alpha": 0.02, "f_e": 0.0, "alpha_phase": 0.0}),
        ("omega_b", 0.62, 0.7, {"kappa": 0.0}),
    ],
)
def test_distances_of_a_point(stores, name, x, p, further):
    _, plan = stores[name]
    design = Design(x, p, x, x, 0.0, further)
    found = answer(*stores[name], design)
    axes = [plan.sweep, plan.parameter, *(further_axis(plan, design, q) for q in further)]
    assert [(one.name, one.upward) for one in found.margins] == [(a.name, up) for a in axes for up in (False, True)]
    near = 0
    for margin in found.margins:
        value = nominal_value(plan, x, p, margin.name)
        expected = first_change(plan, margin.name, value, margin.limit, x, p)
        if expected is None:
            assert margin.place is None and margin.distance is None
        else:
            near += 1
            assert margin.place == pytest.approx(expected, abs=1e-6)
            assert margin.distance == pytest.approx(abs(expected - value), abs=1e-6)
            step = 1e-5 if margin.upward else -1e-5
            assert [domain_label(margin.beyond)] == enumerated(plan, margin.name, [margin.place + step], x, p)
    assert near >= 3


def test_distances_name_their_boundaries(stores):
    """Folds of PHYSICS, section 7, seen from the middle of the multivalued stretch."""
    down, up, *_ = ask(stores["omega_b"], 0.6, 1.2, 0.6, 0.6).margins
    assert down.kind is Event.FOLD and down.place == pytest.approx(0.559374, abs=2e-6)
    assert (up.kind, domain_label(up.beyond)) == (Event.MIN_AT_DRIVE, "2/1")
    shaft = ask(stores["omega_b"], 1.0, 1.2, 1.0, 1.0).margins[1]
    assert shaft.kind is Event.FOLD and shaft.place == pytest.approx(1.223810, abs=2e-6)


@pytest.mark.parametrize(
    ("name", "x", "p", "low", "high", "q"),
    [("omega_fe", 1.3, 0.05, 1.2, 1.4, "f_e"), ("omega_fe", 0.8, 0.1, 0.78, 0.95, "alpha"),
     ("omega_b", 0.5, 1.2, 0.4, 0.55, "b")],
)  # fmt: skip
def test_distances_over_a_range(stores, name, x, p, low, high, q):
    _, plan = stores[name]
    further = {} if q == plan.parameter.name else {q: 0.0}
    found = answer(*stores[name], Design(x, p, low, high, 0.0, further))
    seen = 0
    for margin in (one for one in found.margins if one.of_range and one.name == q):
        value = nominal_value(plan, x, p, q)
        places = [first_change(plan, q, value, margin.limit, at, p, 120) for at in np.linspace(low, high, 31)]
        distances = [abs(place - value) for place in places if place is not None]
        if margin.place is None:
            assert not distances
            continue
        seen += 1
        assert margin.distance <= min(distances) + 1e-7
        there = first_change(plan, q, value, margin.place + 1e-4 * np.sign(margin.place - value), margin.at, p, 400)
        assert low <= margin.at <= high and there == pytest.approx(margin.place, abs=1e-6)
    assert seen


def test_a_range_that_boundaries_cross_leaves_no_distance(stores):
    found = ask(stores["omega_fe"], 0.8, 0.1, 0.7, 0.9)
    assert [one.distance for one in found.margins if one.of_range] == [0.0] * 4
    assert found.box is not None and "cross" in found.notes[0]
    assert found.box.x[0] > 0.7 and found.box.x[0] <= 0.8


def grid_box(plan, x, p, low, high, columns=240, rows=160):
    """Area of the largest rectangle whose grid points all are safe, around the range."""
    across = np.unique(np.append(np.linspace(plan.sweep.low, plan.sweep.high, columns), [low, x, high]))
    levels = np.unique(np.append(np.linspace(plan.parameter.low, plan.parameter.high, rows), p))
    safe = np.array([[label == "1/0" for label in enumerated(plan, "omega", across, x, level)] for level in levels])
    middle, first, last = (int(np.searchsorted(*pair)) for pair in ((levels, p), (across, low), (across, high)))
    left, right = np.zeros(levels.size), np.zeros(levels.size)
    for i, row in enumerate(safe):
        bad = np.flatnonzero(~row)
        before, after = bad[bad < first], bad[bad > last]
        left[i] = across[before[-1] + 1] if before.size else across[0]
        right[i] = across[after[0] - 1] if after.size else across[-1]
    good = safe[:, first : last + 1].all(axis=1)
    best = 0.0
    for bottom in range(middle, -1, -1):
        if not good[bottom]:
            break
        for top in range(middle, levels.size):
            if not good[top]:
                break
            part = slice(bottom, top + 1)
            best = max(best, (right[part].min() - left[part].max()) * (levels[top] - levels[bottom]))
    return best / ((plan.sweep.high - plan.sweep.low) * (plan.parameter.high - plan.parameter.low))


def check_box(plan, box, places=25):
    """All of it is safe."""
    inside = 1e-6 + (1.0 - 2e-6) * np.linspace(0.0, 1.0, places)
    across = box.x[0] + (box.x[1] - box.x[0]) * inside
    for p in box.p[0] + (box.p[1] - box.p[0]) * inside:
        assert set(enumerated(plan, "omega", across, across[0], p)) == {"1/0"}


@pytest.mark.parametrize(
    ("name", "x", "p", "low", "high"),
    [("omega_fe", 0.9, 0.3, 0.9, 0.9), ("omega_fe", 1.6, 0.1, 1.5, 1.7), ("omega_fe", 1.7, 0.3, 1.7, 1.7),
     ("omega_b", 0.5, 0.6, 0.45, 0.55)],
)  # fmt: skip
def test_the_largest_safe_box(stores, name, x, p, low, high):
    _, plan = stores[name]
    box = ask(stores[name], x, p, low, high).box
    assert box.x[0] <= low <= high <= box.x[1] and box.p[0] <= p <= box.p[1]
    assert box.area >= grid_box(plan, x, p, low, high) and box.area <= 1.0
    check_box(plan, box)
    # Every side ends at the plane's border or touches something unsafe.
    across, levels = np.linspace(*box.x, 4001), np.linspace(*box.p, 801)
    for at, border in zip(box.p, (plan.parameter.low, plan.parameter.high), strict=True):
        out = at + 1e-4 * np.sign(border - at)
        assert at == border or set(enumerated(plan, "omega", across, x, out)) != {"1/0"}
    for at, border in zip(box.x, (plan.sweep.low, plan.sweep.high), strict=True):
        out = at + 1e-4 * np.sign(border - at)
        assert at == border or set(enumerated(plan, plan.parameter.name, levels, out, p)) != {"1/0"}


unit = st.floats(0.0, 1.0).map(lambda value: round(value, 3))


@settings(max_examples=25)
@given(st.lists(st.tuples(unit, unit, unit, unit), min_size=1, max_size=6))
def test_boxes_between_straight_boundaries(ends):
    """The plane and boundaries made up: no boundary inside, and none larger among the rectangles of a grid."""
    segments = np.array([end for end in ends if np.hypot(end[0] - end[2], end[1] - end[3]) > 0.01]).reshape(-1, 4)
    t = np.linspace(0.0, 1.0, 2001)[:, None, None]
    points = ((1.0 - t) * segments[None, :, :2] + t * segments[None, :, 2:]).reshape(-1, 2)
    if len(segments) == 0 or np.min(np.max(np.abs(points - 0.5), axis=1)) < 0.01:
        return
    made = small_plan("plane.sweep.min=1", "plane.sweep.max=2")
    made = dataclasses.replace(
        made, sweep=dataclasses.replace(made.sweep, low=0.0, high=1.0),
        parameter=dataclasses.replace(made.parameter, low=0.0, high=1.0),
    )  # fmt: skip
    start, end = (np.pad(part, ((0, 0), (3, 0))) for part in (segments[:, :2], segments[:, 2:]))
    arcs = Arcs(start, end, end - start, end - start)
    box = largest_box(Boundaries(arcs, np.ones(len(segments), int)), made, Design(0.5, 0.5, 0.5, 0.5))
    (left, right), (low, high) = box.x, box.p
    inner = (points > [left + 1e-7, low + 1e-7]) & (points < [right - 1e-7, high - 1e-7])
    assert not np.any(inner.all(axis=1))
    assert box.area == pytest.approx((right - left) * (high - low), rel=1e-12)
    grid = np.linspace(0.0, 0.5, 51)
    for down in grid:
        rows = points[(points[:, 1] > 0.5 - down) & (points[:, 1] <= 0.5)]
        for up in grid:
            part = np.concatenate([rows, points[(points[:, 1] > 0.5) & (points[:, 1] < 0.5 + up)]])
            if np.any(part[:, 0] == 0.5):
                continue
            width = np.min(part[part[:, 0] > 0.5, 0], initial=1.0) - np.max(part[part[:, 0] < 0.5, 0], initial=0.0)
            # Between two points of a segment there is up to 1/2000 of it, to either side.
            assert width * (down + up) <= box.area + 2e-3
