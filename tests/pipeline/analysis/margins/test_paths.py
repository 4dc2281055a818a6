"""Margins of gears in physical units, and over rows that move several numbers: temperature and mesh damping."""

import csv
import io

import numpy as np
import pytest

from pipeline.__main__ import main
from pipeline.analysis.margins import Design, answer, design_of
from pipeline.analysis.margins.options import nominal_value, replaced
from pipeline.analysis.margins.sheets import lines, markdown, tidy
from pipeline.config.compose import compose
from pipeline.errors import ConfigurationError
from pipeline.plan.numerics import model_at, point_of
from pipeline.plan.scales import scales_of
from solver import all_solutions, domain_code, domain_label, impact_state
from tests.pipeline.planes import small_plan, traced_store

WINDOW = ("gear=miter", "plane.sweep.min=0.9", "plane.sweep.max=1.2")
PLANES = {
    "omega_temperature": ("plane.parameter.min=-10", "plane.parameter.max=28"),
    "omega_xi": ("plane.parameter.min=0.02", "plane.parameter.max=0.15"),
}


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    folder, made = tmp_path_factory.mktemp("paths"), {}
    for name, ends in PLANES.items():
        plan = small_plan(f"plane={name}", *WINDOW, *ends, columns=40, rows=9)
        made[name] = traced_store(folder / f"{name}.zarr", plan), plan
    return made


def label(model, omega):
    """From enumeration at one point alone."""
    found = all_solutions(model, omega)
    states = impact_state(found.mean - found.amplitude, found.mean + found.amplitude, model.b).astype(int)
    stable = found.stable == 1
    return domain_label(int(domain_code(stable.sum(), np.bitwise_or.reduce(1 << states[stable], initial=0))))


def changes(plan, x, p, limit, steps=400):
    """Where the label first changes on the way from p to a limit in the row parameter, walking; None without one."""
    walk = np.linspace(p, limit, steps)
    labels = [label(*point_of(plan, float(row), x)) for row in walk]
    place = next((i for i in range(1, steps) if labels[i] != labels[0]), None)
    return None if place is None else (walk[place - 1], walk[place], labels[place])


@pytest.mark.parametrize(("name", "x", "p"), [("omega_temperature", 1.0, 4.0), ("omega_xi", 1.1, 0.07)])
def test_distances_along_a_path(stores, name, x, p):
    path, plan = stores[name]
    found = answer(path, plan, Design(x, p, x, x))
    assert found.label == label(*point_of(plan, p, x))
    met = 0
    for margin in (one for one in found.margins if one.name == plan.parameter.name):
        expected = changes(plan, x, p, margin.limit)
        assert (margin.place is None) == (expected is None)
        if expected is not None:
            met += 1
            low, high = sorted(expected[:2])
            assert low - 1e-9 <= margin.place <= high + 1e-9 and domain_label(margin.beyond) == expected[2]
    assert met


@pytest.mark.costly
@pytest.mark.parametrize(
    ("name", "design"),
    [
        ("omega_temperature", Design(1.0, 4.0, 0.99, 1.01, 2.0, {"b": 0.04})),
        pytest.param("omega_temperature", Design(1.0, 4.0, 1.0, 1.0, 6.0, {"b": 0.04}), marks=pytest.mark.slow),
        ("omega_xi", Design(1.1, 0.07, 1.09, 1.11, 0.02, {"f_e": 0.01})),
    ],
)
def test_labels_within_tolerances(stores, name, design):
    """Every label on a grid over range, rows and the ends of a parameter that is no axis, and no other."""
    path, plan = stores[name]
    found = answer(path, plan, design)
    assert len(found.corners) == 3
    for corner in found.corners:
        changed = replaced(plan, corner.values, design.x, design.p)
        for key, value in corner.values.items():
            # What was asked for is what the gear has in the row of the point.
            assert getattr(model_at(changed, design.p, design.x), key) == pytest.approx(value, rel=1e-12)
        rows = np.linspace(design.p - design.tolerance, design.p + design.tolerance, 41)
        columns = np.linspace(design.low, design.high, 1 if design.low == design.high else 21)
        seen = {label(*point_of(changed, float(row), float(x))) for row in rows for x in columns}
        assert set(corner.labels) == seen


def test_a_further_parameter_is_looked_at_in_the_row_of_the_point(stores):
    """Backlash at 4 K: the hot gear's own, changed there; it matters once both flanks are struck."""
    path, plan = stores["omega_temperature"]
    found = answer(path, plan, Design(1.1, 4.0, 1.09, 1.11, 0.0, {"b": 0.0}))
    value = nominal_value(plan, 1.1, 4.0, "b")
    hot = model_at(plan, 4.0, 1.1)
    assert value == hot.b != 1.0
    point = [one for one in found.margins if one.name == "b" and not one.of_range]
    assert any(one.place is not None for one in point)
    for margin in point:
        end = margin.limit if margin.place is None else margin.place
        step = 1e-5 * np.sign(end - value)
        between = {label(hot.replace(b=float(b)), 1.1) for b in np.linspace(value, end - step, 60)}
        assert between == {found.label}
        if margin.place is not None:
            assert label(hot.replace(b=end + step), 1.1) == domain_label(margin.beyond) != found.label
    ranged = [one for one in found.margins if one.name == "b" and one.of_range and one.place is not None]
    assert ranged and all(1.09 <= one.at <= 1.11 for one in ranged)


def test_values_with_units():
    plan = small_plan("gear=miter", *WINDOW[1:])
    scales = scales_of(plan)
    words = [
        "margins.point=[16000 rpm,12 um]",
        "margins.range=[15000 rpm,5.6 kHz]",
        "margins.tolerances={f_e: 2 um, b: 8 um, f_pm: 60 N*m, omega: 10 rpm}",
    ]
    design = design_of(compose(words).config.margins, plan)
    assert design.x * scales["omega"].shown == pytest.approx(16000.0, rel=1e-12)
    assert design.p == pytest.approx(12 / 50) and design.tolerance == pytest.approx(2 / 50)
    assert design.low * scales["omega"].shown == pytest.approx(15000.0, rel=1e-12)
    assert design.high * scales["mesh_frequency"].shown == pytest.approx(5600.0, rel=1e-12)
    assert design.further["b"] == pytest.approx(8 / 50)
    assert design.further["f_pm"] * scales["f_pm"].shown == pytest.approx(60.0, rel=1e-12)


HOT = ["plane=omega_temperature", "gear=miter", "margins.point=[16000 rpm,4 K]"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["gear=miter", "margins.point=[1500 um,12 um]"], "margins.point = '1500 um' .* unit of pinion speed"),
        (["gear=miter", "margins.point=[1,12 K]"], "margins.point = '12 K' .* unit of length"),
        (["gear=miter", "margins.point=[1,0.1]", "margins.tolerances={kappa: 1 um}"], "kappa = '1 um' .* no unit"),
        (
            ["gear=miter", "margins.point=[1,0.1]", "margins.tolerances={b: -1 um}"],
            "tolerances.b = '-1 um' .* at least 0",
        ),
        (["margins.point=[1500 rpm,0.1]"], "margins.point = '1500 rpm' .* must be a number"),
        ([*HOT, "margins.tolerances={temperature: 40 K}"], "tolerances.temperature = 40.0 .* stays within -10 ... 30"),
        (
            [*HOT, "margins.tolerances={xi_mesh: 0.01}"],
            "tolerances.xi_mesh = 0.01 .* left out: xi_mesh varies with temp",
        ),
        ([*HOT, "margins.tolerances={pressure_angle: 1}"], "pressure_angle = 1 .* left out"),
        ([*HOT, "margins.tolerances={b: 60 um}"], "tolerances.b = '60 um' .* stays a finite number at least 0"),
        (
            [*HOT, "margins.tolerances={b: 47.5 um, temperature: 13 K}"],
            "tolerances.b = '47.5 um' .* so small that b = .* leaves temperature = below .* K, where the backlash",
        ),
        (
            ["plane=omega_xi", "gear=miter", "margins.point=[1,0.05]", "margins.tolerances={xi_translation: 0.01}"],
            "xi_translation = 0.01 .* left out: xi_translation varies with mesh_damping",
        ),
    ],
)
def test_what_is_not_allowed(words, said):
    settings = compose(words)
    axes = [word for word in words if not word.startswith("margins")]
    with pytest.raises(ConfigurationError, match=said) as error:
        design_of(settings.config.margins, small_plan(*axes))
    assert "\n" not in str(error.value)


def test_answers_in_both_units(stores):
    """CSV columns, Markdown and lines; a parameter without a unit of the gear's has no second value."""
    path, plan = stores["omega_temperature"]
    found = answer(path, plan, Design(1.0, 4.0, 0.99, 1.01, 2.0, {"b": 0.04}))
    rpm = scales_of(plan)["omega"].shown
    seen = 0
    for record in csv.DictReader(io.StringIO(tidy(found))):
        unit = {"omega": "rpm", "b": "µm"}.get(record["parameter"], "")
        assert record["physical_unit"] == unit
        size = {"rpm": rpm, "µm": 50.0}.get(unit)
        for key in ("value", "low", "high", "distance"):
            if size is None or record[key] == "":
                assert record[f"physical_{key}"] == ""
            else:
                seen += 1
                assert float(record[f"physical_{key}"]) == pytest.approx(float(record[key]) * size, rel=1e-8)
    assert seen > 8
    for text in (markdown(found, "plane"), "\n".join(lines(found))):
        assert f"omega = 1 ({rpm:.5g} rpm), temperature = 4 K" in text and " µm)" in text


@pytest.mark.costly
def test_the_figure_follows_the_units(stores, tmp_path, capsys):
    path, _ = stores["omega_xi"]
    words = [
        f"store.root={path.parent}",
        "store.name=omega_xi",
        "plane=omega_xi",
        *PLANES["omega_xi"],
        *WINDOW,
        "stages=[margins]",
        "margins.point=[1.1,0.07]",
        "margins.range=[1.09,1.11]",
        "figures.formats=[png]",
        "figures.dpi=50",
        "figures.units=physical",
        f"output.root={tmp_path}",
    ]
    assert main(words) == 0
    assert "rpm)" in capsys.readouterr().out
    from pipeline.figures.margins import draw_margins
    from pipeline.plane.stored import read_stored

    found = answer(*stores["omega_xi"], Design(1.1, 0.07, 1.09, 1.11))
    figure = draw_margins(read_stored(path, physical=True), found)
    named = {child.get_xlabel() + child.get_ylabel() for axes in figure.axes for child in axes.child_axes}
    assert {"pinion speed (rpm)", "mesh damping (N·s/m)"} <= named
