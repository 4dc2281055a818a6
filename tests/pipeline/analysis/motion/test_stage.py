"""The stage: what it writes, the same every time; what it refuses, with nothing written."""

import shutil

import numpy as np
import pytest

import pipeline
from pipeline.__main__ import main
from pipeline.errors import ConfigurationError
from pipeline.run.sheets import number_text
from tests.made_once import made_once
from tests.pipeline.planes import small_plan, small_store

SIZES = ("plane.sweep.num=20", "plane.parameter.num=3")


def stored(name, *overrides):
    """A folder with a small store, as the command makes it."""

    def make(folder):
        plan = small_plan(*SIZES, *overrides)
        (folder / "store").mkdir()
        small_store(folder / f"store/{name}.zarr", plan, plan.blocks)

    return made_once(f"motion-{name}", make)


@pytest.fixture(scope="module")
def published():
    return stored("omega_fe", "plane=omega_fe")


@pytest.fixture
def copy(published, tmp_path):
    shutil.copytree(published / "store", tmp_path / "store")
    return tmp_path


def run(folder, *words):
    return main([*words, "figures.dpi=30", f"output.root={folder}", "cluster=none"])


def files(folder):
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.costly
def test_a_place_is_drawn_and_told_the_same_every_time(copy, capsys):
    words = ["stages=[motion]", "motion.at=[0.64,0.3]", "attractors.starts=6", "figures.formats=[png,pdf,svg]"]
    before = files(copy)
    assert run(copy, *words) == 0
    said = capsys.readouterr().out
    name = "omega=0.64-f_e=0.3"
    made = {f"motion/omega_fe/{name}{end}" for end in (".png", ".pdf", ".svg", ".md", ".csv", "-curves.csv")}
    first = files(copy)
    assert set(first) - set(before) == made and all(first[path] == text for path, text in before.items())
    assert "chaotic/2" in said and "6 of 6 random starts" in said and "period doubling" in said
    assert all(path.rpartition("/")[2] in said for path in made)
    # By name it is the same place.
    assert run(copy, *words[:1], "motion.at={f_e: 0.3, omega: 0.64}", *words[2:]) == 0
    assert files(copy) == first


@pytest.mark.costly
def test_many_motions_take_several_pages(copy, monkeypatch):
    from pipeline.figures import motion

    words = ["stages=[motion]", "motion.at=[0.6,0.2]", "attractors.starts=20", "figures.formats=[png]"]
    monkeypatch.setattr(motion, "PER_PAGE", 2)
    assert run(copy, *words) == 0
    name = copy / "motion/omega_fe/omega=0.6-f_e=0.2"
    assert name.with_name(f"{name.name}-2.png").exists() and not name.with_name(f"{name.name}-3.png").exists()
    # What there are no cards for any more goes.
    monkeypatch.setattr(motion, "PER_PAGE", 4)
    assert run(copy, *words) == 0
    assert name.with_name(f"{name.name}.png").exists() and not name.with_name(f"{name.name}-2.png").exists()


REFUSED = [
    ([], "motion.at = None"),
    (["motion.at=0.6"], "motion.at = 0.6"),
    (["motion.at=[0.6]"], "motion.at = [0.6]"),
    (["motion.at=[0.6,0.2,0.1]"], "motion.at = [0.6, 0.2, 0.1]"),
    (["motion.at=[0.6,9]"], "f_e = 0 ... 0.5"),
    (["motion.at=[5,0.2]"], "omega = 0.05 ... 2"),
    (["motion.at=[0.6,nan]"], "motion.at"),
    (["motion.at=[0.6,true]"], "motion.at"),
    (["motion.at=[0.6,'0.2 um']"], "motion.at = '0.2 um'"),
    (["motion.at={omega: 0.6}"], "motion.at"),
    (["motion.at={omega: 0.6, b: 0.2}"], "motion.at"),
    (["motion.at=[0.6,0.2]", "motion.to=[1,1]"], "motion.to"),
    (["motion.at=[0.6,0.2]", "attractors.starts=-1"], "attractors.starts"),
    (["motion.at=[0.6,0.2]", "attractors.box=[[1,0],[0,1]]"], "attractors.box"),
    (["motion.at=[0.6,0.2]", "figures.units=physical"], "figures.units"),
    (["motion.at=[0.6,0.2]", "figures.formats=[gif]"], "figures.formats"),
    (["motion.at=[0.6,0.2]", "gear.b=0.5", "store.name=omega_fe"], "gear.b"),
    (["motion.at=[0.6,0.2]", "store.name=nowhere"], "nowhere"),
]


@pytest.mark.parametrize(("words", "named"), REFUSED)
def test_what_is_not_allowed_is_one_line_and_nothing_is_written(copy, capsys, words, named):
    before = files(copy)
    assert run(copy, "stages=[motion]", *words) == 2
    said = capsys.readouterr()
    assert said.err.count("\n") == 1 and named in said.err
    assert files(copy) == before


def test_of_a_volume_there_is_none(tmp_path, capsys):
    folder = stored("omega_b_fe", "plane=omega_b_fe", "plane.parameter2.num=2")
    shutil.copytree(folder / "store", tmp_path / "store")
    before = files(tmp_path)
    assert run(tmp_path, "plane=omega_b_fe", "plane.parameter2.num=2", "stages=[motion]", "motion.at=[.6,.2]") == 2
    said = capsys.readouterr()
    assert said.err.count("\n") == 1 and "volume" in said.err and "plane.layer" in said.err
    assert files(tmp_path) == before


@pytest.mark.costly
def test_a_gear_in_physical_units_is_drawn_in_them(tmp_path, capsys):
    folder = stored("omega_fe-miter", "plane=omega_fe", "gear=miter")
    shutil.copytree(folder / "store", tmp_path / "store")
    words = ["gear=miter", "stages=[motion]", "motion.at=['1.2 kHz', '10 um']", "attractors.starts=2"]
    assert run(tmp_path, *words, "figures.units=physical", "figures.formats=[svg]") == 0
    said = capsys.readouterr().out
    assert "rpm" in said and "10 um" not in said and "µm" in said
    (name,) = [path.name for path in (tmp_path / "motion/omega_fe-miter").glob("*.svg")]
    assert name.startswith("omega=0.") and name.endswith("-f_e=0.2.svg")


def test_an_opened_plane_draws_it(published):
    plane = pipeline.open_plane(published / "store/omega_fe.zarr")
    one = plane.plot.motion(omega=0.64, f_e=0.3, attractors={"starts": 2})
    assert one.get_size_inches()[0] == pytest.approx(7.2) and len(one.axes) == 8
    with pytest.raises(ConfigurationError, match="attractors"):
        plane.plot.motion(omega=0.64, f_e=0.3, attractors={"starts": 2, "no_such": 1})


def test_numbers_read_as_people_write_them():
    assert [number_text(value) for value in (0.0, 14432.0, 999999.0, 0.12345, -3.0)] == [
        "0",
        "14400",
        "1000000",
        "0.123",
        "−3",
    ]
    assert np.all([float(number_text(10.0**k).replace("−", "-")) == 10.0**k for k in range(-12, 13)])
