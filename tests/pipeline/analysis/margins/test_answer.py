"""Design answers against brute force: labels enumerated on dense grids, boundaries bisected, rectangles tried out."""

import csv
import shlex

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.__main__ import main
from pipeline.analysis.margins import Design, answer, design_of
from pipeline.analysis.margins.distances import further_axis
from pipeline.analysis.margins.options import nominal_value
from pipeline.analysis.margins.sheets import tidy
from pipeline.analysis.margins.worst import severity
from pipeline.config.compose import compose
from pipeline.errors import ConfigurationError, StoreError
from pipeline.plan.numerics import model_at
from solver import Event, domain_code, domain_label, enumerate_row, impact_state
from tests.pipeline.planes import small_plan, small_store, traced_store

PLANES = ("omega_fe", "omega_b")


def traced(path, *overrides, columns=60, rows=16):
    plan = small_plan(*overrides, columns=columns, rows=rows)
    return traced_store(path, plan), plan


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    folder = tmp_path_factory.mktemp("margins")
    return {name: traced(folder / f"{name}.zarr", f"plane={name}") for name in PLANES}


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
    """Folds of docs/physics.md, section 7, seen from the middle of the multivalued stretch."""
    down, up, *_ = ask(stores["omega_b"], 0.6, 1.2, 0.6, 0.6).margins
    assert down.kind is Event.FOLD and down.place == pytest.approx(0.559374, abs=2e-6)
    assert (up.kind, domain_label(up.beyond)) == (Event.MIN_AT_DRIVE, "2/1")
    shaft = ask(stores["omega_b"], 1.0, 1.2, 1.0, 1.0).margins[1]
    assert shaft.kind is Event.FOLD and shaft.place == pytest.approx(1.223810, abs=2e-6)


@pytest.mark.parametrize(
    ("name", "x", "p", "low", "high", "q"),
    [
        ("omega_fe", 1.3, 0.05, 1.2, 1.4, "f_e"),
        ("omega_fe", 0.8, 0.1, 0.78, 0.95, "alpha"),
        ("omega_b", 0.6, 1.2, 0.575, 0.62, "b"),
    ],
)
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
    """Area of the largest rectangle whose grid points all are 1/0, around the range."""
    across = np.unique(np.append(np.linspace(plan.sweep.low, plan.sweep.high, columns), [low, x, high]))
    levels = np.unique(np.append(np.linspace(plan.parameter.low, plan.parameter.high, rows), p))
    contact = np.array([[label == "1/0" for label in enumerated(plan, "omega", across, x, level)] for level in levels])
    middle, first, last = (int(np.searchsorted(*pair)) for pair in ((levels, p), (across, low), (across, high)))
    left, right = np.zeros(levels.size), np.zeros(levels.size)
    for i, row in enumerate(contact):
        bad = np.flatnonzero(~row)
        before, after = bad[bad < first], bad[bad > last]
        left[i] = across[before[-1] + 1] if before.size else across[0]
        right[i] = across[after[0] - 1] if after.size else across[-1]
    good = contact[:, first : last + 1].all(axis=1)
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
    """All of it is 1/0."""
    inside = 1e-6 + (1.0 - 2e-6) * np.linspace(0.0, 1.0, places)
    across = box.x[0] + (box.x[1] - box.x[0]) * inside
    for p in box.p[0] + (box.p[1] - box.p[0]) * inside:
        assert set(enumerated(plan, "omega", across, across[0], p)) == {"1/0"}


@pytest.mark.parametrize(
    ("name", "x", "p", "low", "high"),
    [
        pytest.param("omega_fe", 0.9, 0.3, 0.9, 0.9, marks=pytest.mark.slow),
        ("omega_fe", 1.6, 0.1, 1.5, 1.7),
        pytest.param("omega_fe", 1.7, 0.3, 1.7, 1.7, marks=pytest.mark.slow),
        ("omega_b", 0.5, 0.6, 0.45, 0.55),
    ],
)
def test_the_largest_box(stores, name, x, p, low, high):
    _, plan = stores[name]
    box = ask(stores[name], x, p, low, high).box
    assert box.x[0] <= low <= high <= box.x[1] and box.p[0] <= p <= box.p[1]
    assert box.area >= grid_box(plan, x, p, low, high) and box.area <= 1.0
    check_box(plan, box)
    # Every side ends at the plane's border or touches another label.
    across, levels = np.linspace(*box.x, 4001), np.linspace(*box.p, 801)
    for at, border in zip(box.p, (plan.parameter.low, plan.parameter.high), strict=True):
        out = at + 1e-4 * np.sign(border - at)
        assert at == border or set(enumerated(plan, "omega", across, x, out)) != {"1/0"}
    for at, border in zip(box.x, (plan.sweep.low, plan.sweep.high), strict=True):
        out = at + 1e-4 * np.sign(border - at)
        assert at == border or set(enumerated(plan, plan.parameter.name, levels, out, p)) != {"1/0"}


@pytest.mark.costly
@pytest.mark.parametrize(
    ("name", "where", "tolerance", "further"),
    [
        pytest.param("omega_fe", (0.72, 0.1, 0.6, 0.8), 0.03, {"b": 0.2, "alpha": 0.05}, marks=pytest.mark.slow),
        pytest.param("omega_b", (0.61, 0.8, 0.56, 0.66), 0.15, {}, marks=pytest.mark.slow),
        ("omega_fe", (0.75, 0.1, 0.7, 0.8), 0.02, {"b": 0.2}),
        ("omega_b", (0.61, 0.6, 0.61, 0.61), 0.2, {"f_pm": 0.1}),
        pytest.param("omega_b", (0.61, 0.6, 0.57, 0.65), 0.0, {"f_pm": 0.1}, marks=pytest.mark.slow),
    ],
)
def test_labels_within_tolerances(stores, name, where, tolerance, further):
    """Every label of a dense grid, and no other; with every end of further tolerances."""
    _, plan = stores[name]
    x, p, low, high = where
    found = ask(stores[name], *where, tolerance, further)
    assert len(found.corners) == (1 if not further else 1 + 2 ** len(further))
    assert bool(further) == any("nothing is proven" in note for note in found.notes)
    across = np.linspace(low, high, 1 if low == high else 400 if tolerance else 8000)
    for corner in found.corners:
        seen = set()
        rows = 1 if tolerance == 0.0 else 600 if low == high else 60 if len(further) == 1 else 150
        for level in np.linspace(p - tolerance, p + tolerance, rows):
            changes = {plan.parameter.name: level, **corner.values}
            seen |= set(enumerated(plan, "omega", across, x, p, **changes))
        assert set(corner.labels) == seen, corner.values
        assert list(corner.labels) == sorted(seen, key=lambda label: (severity(label), label), reverse=True)
    assert {tuple(corner.values) for corner in found.corners[1:]} <= {tuple(further)}


@pytest.mark.slow
def test_answers_do_not_depend_on_the_raster(stores, tmp_path):
    fine = traced(tmp_path / "fine.zarr", "plane=omega_b", columns=160, rows=9)
    design = (0.85, 0.6, 0.8, 0.95, 0.1, {"alpha": 0.05})
    for one, other in zip(
        *(csv.reader(tidy(ask(made, *design)).splitlines()) for made in (stores["omega_b"], fine)), strict=True
    ):
        for a, b in zip(one, other, strict=True):
            try:
                assert float(a) == pytest.approx(float(b), abs=1e-6)
            except ValueError:
                assert a == b


@pytest.mark.slow
@settings(max_examples=3)
@given(st.floats(0.45, 1.9), st.floats(0.01, 0.45))
def test_any_point(stores, x, p):
    _, plan = stores["omega_fe"]
    found = ask(stores["omega_fe"], x, p, x, x)
    assert [found.label] == enumerated(plan, "omega", [x], x, p) and found.corners[0].labels == (found.label,)
    for margin in found.margins:
        value = nominal_value(plan, x, p, margin.name)
        end = margin.limit if margin.place is None else margin.place
        between = value + (end - value) * np.linspace(1e-4, 1.0 - 1e-4, 201)
        assert set(enumerated(plan, margin.name, between, x, p)) == {found.label}
    assert (found.box is None) == (found.label != "1/0")
    if found.box is not None:
        check_box(plan, found.box, 9)


@pytest.mark.parametrize(
    ("given_", "message"),
    [
        ([], "margins.point = None is not allowed: it must be [omega, f_e] within omega = 0.05 ... 2, f_e = 0 ... 0.5"),
        (["point=[0.6,0.9]"], "margins.point = [0.6, 0.9] is not allowed: it must be [omega, f_e] within omega = 0.05"),
        (["point={omega: 0.6}"], "margins.point = {'omega': 0.6} is not allowed: it must be [omega, f_e] within"),
        (["range=[0.7,0.8]"], "margins.range = [0.7, 0.8] is not allowed: it must be null or [omega low, omega high]"),
        (["range=[0.01,0.8]"], "margins.range = [0.01, 0.8] is not allowed"),
        (["tolerances={c: 0.1}"], "margins.tolerances.c is not allowed: it must be one of omega, b"),
        (["tolerances={f_e: -0.1}"], "margins.tolerances.f_e = -0.1 is not allowed: it must be a number, at least 0"),
        (["tolerances={f_e: 0.4}"], "margins.tolerances.f_e = 0.4 is not allowed: it must be so small that f_e = 0.2"),
        (["tolerances={b: 1.5}"], "margins.tolerances.b = 1.5 is not allowed: it must be so small that b = 1 +- it"),
        (["tolerances={alpha: x}"], "margins.tolerances.alpha = 'x' is not allowed: it must be a number"),
        (["tolerances=[1]"], "margins.tolerances = [1] is not allowed: it must be numbers by name"),
    ],
)
def test_what_is_not_allowed(stores, given_, message):
    point = ["margins.point=[0.6,0.2]"] if given_ and not given_[0].startswith("point") else []
    settings = compose([*point, *(f"margins.{one}" for one in given_)])
    with pytest.raises(ConfigurationError) as error:
        design_of(settings.config.margins, stores["omega_fe"][1])
    assert str(error.value).startswith(message) and "\n" not in str(error.value)


def test_designs_as_users_write_them(stores):
    words = ["margins.point={f_e: 0.2, omega: 0.6}", "margins.tolerances={omega: 0.01, f_e: 0.02, b: 0.1}"]
    read = design_of(compose(words).config.margins, stores["omega_fe"][1])
    assert read == Design(0.6, 0.2, 0.59, 0.61, 0.02, {"b": 0.1}, 3.0)


@pytest.mark.costly
def test_the_stage(stores, tmp_path, capsys):
    """Files, the same bytes again, the figure's own, and nothing written where the input is not allowed."""
    path, _ = stores["omega_fe"]
    words = [
        "plane=omega_fe",
        f"store.root={path.parent}",
        "store.name=omega_fe",
        "stages=[margins]",
        "figures.dpi=30",
        "figures.formats=[png]",
        "margins.point=[0.9,0.1]",
        "margins.range=[0.8,1.0]",
        "margins.tolerances={f_e: 0.02}",
    ]
    out = tmp_path / "out"

    def made():
        return {str(file.relative_to(out)): file.read_bytes() for file in out.rglob("*") if file.is_file()}

    assert main([*words, f"output.root={out}"]) == 0
    first = made()
    assert main([*words, f"output.root={out}"]) == 0
    said = capsys.readouterr().out
    assert (
        "label at omega = 0.9, f_e = 0.1: 1/0" in said and "worst label within the tolerances, first order: 1/0" in said
    )
    assert first.keys() == {"margins/omega_fe.md", "margins/omega_fe.csv", "figures/omega_fe/margins.png"}
    assert made() == first
    # How to verify it: the command as it was typed, with another stage.
    (how,) = {line.partition("run ")[2] for line in said.splitlines() if "not integrated: run" in line}
    assert shlex.split(how)[:3] == ["python", "-m", "pipeline"]
    assert set(shlex.split(how)[3:]) == {*words, f"output.root={out}", "stages=[attractors]"} - {"stages=[margins]"}
    assert main([*words, "margins.point=[3,0.1]", f"output.root={tmp_path / 'none'}"]) == 2
    assert not (tmp_path / "none").exists() and capsys.readouterr().err.count("\n") == 1


@pytest.mark.costly
def test_the_figure(stores):
    from pipeline.figures.margins import draw_margins
    from pipeline.plane.stored import read_stored

    plane = read_stored(stores["omega_fe"][0])
    wide = draw_margins(plane, ask(stores["omega_fe"], 0.9, 0.1, 0.8, 1.0, 0.02))
    texts = {text.get_text() for axes in wide.axes for text in axes.texts}
    assert {"design point", "range and tolerance", "nearest boundary", "largest box of 1/0"} <= texts
    assert {"labels: first order,", "not verified"} <= texts
    small = draw_margins(plane, ask(stores["omega_fe"], 0.6, 0.2, 0.57, 0.66))
    assert len(small.axes) == len(wide.axes) + 1
    texts = {text.get_text() for axes in small.axes for text in axes.texts}
    assert "operating range" in texts and "largest box of 1/0" not in texts


def test_without_boundaries(tmp_path):
    plan = small_plan(columns=5, rows=2)
    with pytest.raises(StoreError, match="has no boundaries"):
        answer(small_store(tmp_path / "bare.zarr", plan), plan, Design(0.6, 0.2, 0.6, 0.6))
