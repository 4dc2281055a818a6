"""The stages: what they write, the same every time; what they refuse, with nothing written; what is drawn."""

import csv
import re
import shutil

import numpy as np
import pytest

import pipeline
from pipeline.__main__ import main
from pipeline.errors import ConfigurationError
from solver.timedomain import AttractorKind
from tests.made_once import made_once
from tests.pipeline.planes import small_plan, small_store

SIZES = ("plane.sweep.num=20", "plane.parameter.num=3")
QUICK = {
    stage: [
        f"stages=[{stage}]",
        f"{stage}.value=0.2",
        f"{stage}.columns=30",
        f"{stage}.max_periods=1600",
        "figures.dpi=30",
    ]
    for stage in ("diagram", "spectrum")
}


def stored(name, *overrides):
    """A folder with a small store, as the command makes it."""

    def make(folder):
        plan = small_plan(*SIZES, *overrides)
        (folder / "store").mkdir()
        small_store(folder / f"store/{name}.zarr", plan, plan.blocks)

    return made_once(f"diagram-{name}", make)


@pytest.fixture
def copy(tmp_path):
    shutil.copytree(stored("omega_fe", "plane=omega_fe") / "store", tmp_path / "store")
    return tmp_path


def run(folder, *words):
    return main([*words, f"output.root={folder}", "cluster=none"])


def files(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def table(path) -> list[dict]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.costly
def test_a_diagram_is_drawn_and_told_the_same_every_time(copy, capsys):
    words = [*QUICK["diagram"], "figures.formats=[png,pdf,svg]"]
    before = files(copy)
    assert run(copy, *words) == 0
    said = capsys.readouterr().out
    ends = (".png", ".pdf", ".svg", ".csv", "-points.csv", "-branches.csv")
    made = {f"diagram/omega_fe/f_e=0.2{end}" for end in ends}
    first = files(copy)
    assert set(first) - set(before) == made and all(first[path] == text for path, text in before.items())
    assert all(path.rpartition("/")[2] in said for path in made)
    # The true saddle-node, by shooting, to half of a small step, sixteen of which are one.
    jumps = [float(place) for place in re.findall(r"downwards: jump at omega = ([0-9.]+)", said)]
    assert min(abs(place - 0.5259298) for place in jumps) <= 0.5 * 1.95 / 29 / 16 and "upwards" in said
    assert run(copy, *words) == 0
    assert files(copy) == first


@pytest.mark.costly
def test_the_tables_have_every_step_and_point(copy):
    assert run(copy, *QUICK["diagram"], "figures.formats=[png]") == 0
    folder = copy / "diagram/omega_fe"
    steps, points = table(folder / "f_e=0.2.csv"), table(folder / "f_e=0.2-points.csv")
    assert [one["direction"] for one in steps] == ["up"] * 30 + ["down"] * 30
    omega = np.array([float(one["omega"]) for one in steps])
    np.testing.assert_allclose(omega[:30], np.linspace(0.05, 2.0, 30), rtol=1e-9)
    np.testing.assert_array_equal(omega[30:], omega[29::-1])
    kinds = {kind.label.replace("_", "-"): int(kind) for kind in AttractorKind if kind.periodic}
    for one in steps:
        here = [p for p in points if (p["direction"], p["omega"]) == (one["direction"], one["omega"])]
        assert len(here) == kinds.get(one["kind"], 128) or one["kind"] == "nT"
        low, high = float(one["lowest"]), float(one["highest"])
        assert all(low - 1e-9 <= float(p["displacement"]) <= high + 1e-9 for p in here)
        assert float(one["peak_to_peak"]) == pytest.approx(high - low, rel=1e-8, abs=2e-9)
    branches = table(folder / "f_e=0.2-branches.csv")
    assert {one["stable"] for one in branches} == {"0", "1"}
    # Up to the first resonance the map's one motion is what is met.
    x, rms = (np.array([float(one[name]) for one in branches if one["branch"] == "0"]) for name in ("omega", "rms"))
    low = [one for one in steps[:8] if float(one["omega"]) < 0.4]
    for one in low:
        assert float(one["rms"]) == pytest.approx(np.interp(float(one["omega"]), x, rms), rel=0.1)


@pytest.mark.costly
@pytest.mark.parametrize("further", [[], ["spectrum.of=force", "spectrum.axis=order", "spectrum.direction=down"]])
def test_a_spectrum_is_drawn_and_told_the_same_every_time(copy, capsys, further):
    words = [*QUICK["spectrum"], *further, "spectrum.periods=4", "spectrum.orders=3", "figures.formats=[png,svg]"]
    before = files(copy)
    assert run(copy, *words) == 0
    said = capsys.readouterr().out
    name = "f_e=0.2-force-down" if further else "f_e=0.2-displacement-up"
    made = {f"spectrum/omega_fe/{name}{end}" for end in (".png", ".svg", ".csv")}
    first = files(copy)
    assert set(first) - set(before) == made
    assert all(path.rpartition("/")[2] in said for path in made) and "largest amplitude" in said
    lines = table(copy / f"spectrum/omega_fe/{name}.csv")
    assert len(lines) == 30 * 13
    for one in lines[1::13]:
        assert float(one["order"]) == 0.25
        assert float(one["frequency"]) == pytest.approx(0.25 * float(one["omega"]), rel=1e-8)
    assert run(copy, *words) == 0
    assert files(copy) == first


REFUSED = [
    ("diagram", ["value=null"], "diagram.value = None"),
    ("diagram", ["value=9"], "f_e within 0 ... 0.5"),
    ("diagram", ["value=-0.01"], "diagram.value"),
    ("diagram", ["value=nan"], "diagram.value"),
    ("diagram", ["value=true"], "diagram.value"),
    ("diagram", ["value=[0.2]"], "diagram.value = [0.2]"),
    ("diagram", ["value={f_e: 0.2}"], "diagram.value"),
    ("diagram", ["value='3 um'"], "diagram.value = '3 um'"),
    ("diagram", ["columns=1"], "diagram.columns = 1"),
    ("diagram", ["columns=2.5"], "diagram.columns"),
    ("diagram", ["max_periods=10"], "diagram.max_periods"),
    ("diagram", ["direction=up"], "diagram.direction"),
    ("spectrum", ["value=null"], "spectrum.value = None"),
    ("spectrum", ["direction=sideways"], "spectrum.direction"),
    ("spectrum", ["of=speed"], "spectrum.of"),
    ("spectrum", ["axis=speed"], "spectrum.axis"),
    ("spectrum", ["orders=0"], "spectrum.orders"),
    ("spectrum", ["orders=nan"], "spectrum.orders"),
    ("spectrum", ["periods=0"], "spectrum.periods"),
]


@pytest.mark.parametrize(("stage", "words", "named"), REFUSED)
def test_what_is_not_allowed_is_one_line_and_nothing_is_written(copy, capsys, stage, words, named):
    before = files(copy)
    assert run(copy, *QUICK[stage], *(f"{stage}.{word}" for word in words)) == 2
    said = capsys.readouterr()
    assert said.err.count("\n") == 1 and named in said.err
    assert files(copy) == before


@pytest.mark.parametrize("stage", ["diagram", "spectrum"])
@pytest.mark.parametrize("words", [["figures.units=physical"], ["gear.b=0.5", "store.name=omega_fe"]])
def test_what_other_settings_refuse(copy, capsys, stage, words):
    assert run(copy, *QUICK[stage], *words) == 2
    said = capsys.readouterr()
    assert said.err.count("\n") == 1 and words[0].partition("=")[0] in said.err


@pytest.mark.costly
@pytest.mark.parametrize("stage", ["diagram", "spectrum"])
def test_of_a_volume_there_is_none(tmp_path, capsys, stage):
    volume = ("plane=omega_b_fe", "plane.parameter2.num=2")
    shutil.copytree(stored("omega_b_fe", *volume) / "store", tmp_path / "store")
    before = files(tmp_path)
    assert run(tmp_path, *volume, *QUICK[stage]) == 2
    said = capsys.readouterr()
    assert said.err.count("\n") == 1 and "volume" in said.err and "plane.layer" in said.err
    assert files(tmp_path) == before


@pytest.mark.costly
@pytest.mark.parametrize("stage", ["diagram", "spectrum"])
def test_a_gear_in_physical_units_is_drawn_in_them(tmp_path, capsys, stage):
    shutil.copytree(stored("omega_b-miter", "plane=omega_b", "gear=miter") / "store", tmp_path / "store")
    words = ["plane=omega_b", "gear=miter", *QUICK[stage], f"{stage}.value='30 um'", "figures.units=physical"]
    assert run(tmp_path, *words, "figures.formats=[svg]") == 0
    assert "rpm" in capsys.readouterr().out
    (sheet,) = (tmp_path / stage / "omega_b-miter").glob("b=*[0-9p].csv")
    lines = table(sheet)
    columns = ("omega (rpm)", "lowest (µm)", "support_force (N)", "jump (rpm)")
    if stage == "spectrum":
        columns = ("omega (rpm)", "frequency (Hz)", "amplitude (µm)")
    assert set(columns) <= set(lines[0])
    ratios = [float(one["omega (rpm)"]) / float(one["omega"]) for one in lines]
    np.testing.assert_allclose(ratios, ratios[0], rtol=1e-8)


@pytest.mark.costly
def test_an_opened_plane_draws_them(copy):
    plane = pipeline.open_plane(copy / "store/omega_fe.zarr")
    diagram = plane.plot.diagram(f_e=0.3, columns=12, max_periods=800)
    # Two strips and three panels.
    assert len(diagram.axes) == 5 and diagram.get_size_inches()[0] == pytest.approx(7.2)
    limits = {axes.get_xlim() for axes in diagram.axes}
    assert len(limits) == 1
    spectrum = plane.plot.spectrum(f_e=0.3, columns=12, max_periods=800, periods=4, direction="down")
    # The panel, its strip and its colours.
    assert len(spectrum.axes) == 3
    with pytest.raises(ConfigurationError, match="b"):
        plane.plot.diagram(b=0.3)
    with pytest.raises(ConfigurationError, match="f_e"):
        plane.plot.spectrum()
