"""Configuration: what is composed, and what a mistake looks like."""

import os
import re
import subprocess
import sys
from pathlib import Path

import hydra
import pytest
from omegaconf import OmegaConf

from pipeline.__main__ import main
from pipeline.config.compose import compose, conf_folder, expand
from pipeline.config.default_name import is_name
from pipeline.config.schema import Configuration
from pipeline.errors import ConfigurationError
from pipeline.plan.numerics import model_at
from pipeline.plan.planning import plan, warnings
from pipeline.run.helpers import Helpers
from tests.conftest import MODELS

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("gear", sorted(MODELS))
def test_gears_are_the_reference_sets(gear):
    result = plan(compose([f"gear={gear}", "plane=omega_b"]))
    assert model_at(result, 0.3, 1.0) == MODELS[gear](b=0.3)


@pytest.mark.parametrize(
    ("name", "parameter", "low", "high"),
    [
        ("omega_b", "b", 0.02, 1.5),
        ("omega_alpha", "alpha", 0.0, 0.8),
        ("omega_fe", "f_e", 0.0, 0.5),
        ("omega_fpm", "f_pm", 0.3, 1.2),
    ],
)
def test_planes(name, parameter, low, high):
    result = plan(compose([f"plane={name}"]))
    assert (result.sweep.name, result.sweep.low, result.sweep.high, result.sweep.num) == ("omega", 0.05, 2.0, 400)
    assert (result.parameter.name, result.parameter.low, result.parameter.high) == (parameter, low, high)
    assert result.parameter.num == 200
    draft = plan(compose([f"plane={name}", "quality=draft"]))
    assert (draft.sweep.num, draft.parameter.num) == (160, 60)


@pytest.mark.parametrize(
    ("overrides", "name"),
    [
        (["plane=omega_b"], "omega_b"),
        (["plane=omega_b", "gear=consistent"], "omega_b-consistent"),
        (["plane=omega_b", "quality=draft"], "omega_b-draft"),
        (["plane=omega_b", "gear=antiphase", "quality=draft"], "omega_b-antiphase-draft"),
        (["plane=omega_b", "gear=antiphase", "store.name=mine"], "mine"),
        (["gear.b=0.5"], "omega_fe-b=0.5"),
        (["gear.b=0.50"], "omega_fe-b=0.5"),
        (["++gear.b=5e-1"], "omega_fe-b=0.5"),
        (["gear.b=1"], "omega_fe"),
        (["gear.kappa=0.4", "gear.b=0.5"], "omega_fe-b=0.5-kappa=0.4"),
        (
            ["gear=consistent", "gear.variation.rotation=0.5", "quality=draft"],
            "omega_fe-consistent-draft-variation.rotation=0.5",
        ),
        (["plane=b_fe", "plane.omega=0.7"], "b_fe-omega=0.7"),
        (["plane.parameter.max=0.4", "plane.parameter.num=9", "figures.dpi=90"], "omega_fe-parameter.max=0.4"),
        (["solver=hb", "solver.order=3", "solver.certify_columns=9"], "omega_fe-order3-certify_columns=9"),
    ],
)
def test_store_names(overrides, name):
    assert compose(overrides).store_name == name


_AWKWARD = [
    ["gear=miter", "gear.physical.torque='90 N*m'"],
    ["gear=miter", "gear.physical.torque='90 N m'"],
    ["gear.kappa=[0.5,0.4]"],
    ["gear.alpha_harmonics=[[0.1,0.2]]"],
    ["gear.alpha_harmonics=[[0.1,0.2],[0.1,0.3]]"],
    ["gear.alpha_harmonics=[" + ",".join(["[0.01,0.2]"] * 40) + "]"],
    ["gear.alpha_harmonics=[" + ",".join(["[0.01,0.2]"] * 41) + "]"],
    ["plane.parameter2={name:b,min:0.1,max:0.5,num:3}"],
    [f"gear.{key}=0.3" for key in ("b", "alpha", "f_pm", "f_pv", "kappa", "xi_mesh", "xi_translation", "xi_support")],
]


def test_default_names_are_names_on_every_system_and_differ():
    names = [compose(overrides).store_name for overrides in _AWKWARD]
    assert len({name.lower() for name in names}) == len(names)
    assert all(len(name) <= 80 and is_name(name) for name in names)
    assert names == [compose(overrides).store_name for overrides in _AWKWARD]


@pytest.mark.parametrize("name", ["con", "NUL", "com1.x", "mine.", ".mine", "a b", "a/b", "a:b", "µ", "", "a" * 121])
def test_names_that_some_system_refuses(name):
    assert not is_name(name)


def test_everything_a_plan_does_not_need_leaves_its_digest_alone():
    digest = plan(compose([])).fingerprint
    for override in ("cluster=none", "output.root=x", "figures.dpi=50", "stages=[sweep]", "store.name=y"):
        assert plan(compose([override])).fingerprint == digest
    for override in ("gear.b=0.9", "plane.sweep.num=401", "solver.corrector=broyden", "store.max_points=4096"):
        assert plan(compose([override])).fingerprint != digest


def test_any_scalar_may_be_an_axis():
    result = plan(
        compose(
            [
                "plane.sweep.name=f_e",
                "plane.sweep.min=0",
                "plane.sweep.max=0.5",
                "plane.omega=0.6",
                "plane.parameter.name=kappa",
                "plane.parameter.min=0.1",
                "plane.parameter.max=1",
            ]
        )
    )
    assert model_at(result, 0.3, 0.4) == MODELS["published"](kappa=0.3, f_e=0.4)
    assert result.omega == 0.6


def test_nested_axis_names():
    axis = ["plane.parameter.min=0", "plane.parameter.max=1"]
    for name in ("variation.rotation", "variation_rotation", "gear.variation.rotation"):
        assert plan(compose([f"plane.parameter.name={name}", *axis])).parameter.name == "variation_rotation"


def test_own_files(tmp_path):
    (tmp_path / "gear").mkdir()
    (tmp_path / "plane").mkdir()
    (tmp_path / "gear" / "mine.yaml").write_text("defaults:\n  - published\n  - _self_\nb: 0.7\n")
    (tmp_path / "plane" / "omega_kappa.yaml").write_text(
        "defaults:\n  - omega_fe\n  - _self_\nparameter: {name: kappa, min: 0.2, max: 0.8, num: 7}\n"
    )
    settings = compose(["gear=mine", "plane=omega_kappa"], str(tmp_path))
    result = plan(settings)
    assert result.parameter.name == "kappa" and result.gear["b"] == 0.7 and result.parameter.num == 7
    assert settings.store_name == "omega_kappa-mine"
    (tmp_path / "gear" / "wrong.yaml").write_text("defaults:\n  - published\n  - _self_\nbb: 0.7\n")
    with pytest.raises(ConfigurationError, match=r"gear\.bb is not a key"):
        compose(["gear=wrong"], str(tmp_path))
    (tmp_path / "gear" / "wrong.yaml").write_text("# @package _global_\nhydra: {run: {dir: x}}\n")
    with pytest.raises(ConfigurationError, match="hydra is not a key"):
        compose(["gear=wrong"], str(tmp_path))


def test_expand():
    assert expand(["a=1,2", "b=[1,2]", "c=x"]) == [["a=1", "b=[1,2]", "c=x"], ["a=2", "b=[1,2]", "c=x"]]
    assert expand(["gear.b=range(0.1,0.5,0.1)"]) == [[f"gear.b={b}"] for b in ("0.1", "0.2", "0.3", "0.4")]
    assert expand(["gear=choice(miter,published)"]) == [["gear=miter"], ["gear=published"]]
    assert expand(["plane=glob(omega_f*)"]) == [["plane=omega_fe"], ["plane=omega_fpm"]]


def test_glob_knows_the_files_of_a_users_own_folder(tmp_path):
    (tmp_path / "plane").mkdir()
    (tmp_path / "plane" / "omega_mine.yaml").write_text("defaults: [omega_fe, _self_]\n")
    assert ["plane=omega_mine"] in expand(["plane=glob(*_mine)"], str(tmp_path))


def _notes(*overrides: str) -> list[str]:
    settings = compose(overrides)
    return warnings(plan(settings), settings)


def test_notes():
    assert any("unphysical" in line for line in _notes("gear.alpha=1.2"))
    # The published gear is as it is: said where it is changed, and not on every run.
    assert _notes() == []
    axis = ["plane.parameter.name=kappa", "plane.parameter.min=0.1", "plane.parameter.max=1"]
    for changed in (["gear.kappa=0.4"], ["gear.xi_mesh=0.1"], axis):
        assert any("one mesh force" in line for line in _notes(*changed)), changed
    assert any("one mesh force" in line for line in _notes("gear=consistent", "gear.xi_translation=0.02"))
    assert _notes("gear=consistent", "gear.xi_translation=0.025") == []


# What the user typed, and what the one line must say.
MISTAKES = [
    ("gear.bb=1", "gear.bb is not a key"),
    ("gear.alhpa=1", "did you mean gear.alpha?"),
    ("+gear.c=1", "gear.c is not a key"),
    ("foo=1", "foo is not a key"),
    ("gear.b=abc", "gear.b: Value 'abc'"),
    ("gear.b=[1,2]", "gear.b: Value '[1, 2]'"),
    ("gear.b=-1", "gear.b = -1.0 is not allowed: it must be a finite number at least 0"),
    ("gear.b=inf", "gear.b = inf"),
    ("gear.b=nan", "gear.b = nan"),
    ("gear.kappa=0", "gear.kappa = 0 "),
    ("gear.kappa=[1,2,3]", "gear.kappa = [1, 2, 3] is not allowed: it must be one number or a list of 2"),
    ("gear.kappa=[0.5,-1]", "gear.kappa[1] = -1"),
    ("gear.kappa=much", "gear.kappa = 'much'"),
    ("gear.xi_mesh=-0.1", "gear.xi_mesh = -0.1"),
    ("gear.xi_support=-0.1", "gear.xi_support = -0.1"),
    ("gear.xi_translation=[0.1,-0.1]", "gear.xi_translation[1] = -0.1"),
    ("gear.k_support=[1,1,1]", "gear.k_support = [1, 1, 1] is not allowed: it must be one number or a list of 6"),
    ("gear.pressure_angle=90", "gear.pressure_angle = 90.0"),
    ("gear.rotation_coupling=wide", "gear.rotation_coupling = 'wide'"),
    ("gear.rotation_coupling=0", "gear.rotation_coupling = 0"),
    ("gear.alpha_harmonics=[[1,2,3]]", "gear.alpha_harmonics = [[1, 2, 3]]"),
    ("gear.variation.rotation=x", "gear.variation.rotation: Value 'x'"),
    ("gear.f_e=0.3", "gear.f_e is not allowed here: f_e is an axis"),
    ("gear.b", "gear.b cannot be read as KEY=VALUE"),
    ("gear.b=[1", "gear.b=[1 cannot be read"),
    ("=5", "=5 is not allowed"),
    ("~gear.b", "gear.b has no value"),
    ("gear=unknown", "gear/unknown"),
    ("plane=unknown", "plane/unknown"),
    ("solver=unknown", "solver/unknown"),
    ("plane.sweep.num=1", "plane.sweep.num = 1"),
    ("plane.sweep.num=2.5", "plane.sweep.num: Value '2.5'"),
    ("plane.sweep.min=0", "plane.sweep.min = 0.0"),
    (
        "plane.sweep.min=3",
        "plane.sweep.max = 2.0 is not allowed: it must be a finite number above plane.sweep.min = 3.0",
    ),
    ("plane.sweep.max=nan", "plane.sweep.max = nan"),
    ("plane.parameter.max=inf", "plane.parameter.max = inf"),
    ("plane.parameter.name=mass", "plane.parameter.name = 'mass' is not allowed: it must be one of omega, b,"),
    ("plane.parameter.name=omega", "the sweep axis has that name already"),
    ("plane.parameter.name=alpha_harmonics", "plane.parameter.name = 'alpha_harmonics'"),
    ("plane.omega=1", "plane.omega = 1.0 is not allowed: omega is an axis"),
    ("plane.sweep.name=b", "plane.omega = None is not allowed: it must be a finite number above 0"),
    ("plane.max_cells=10", "plane.max_cells = 10"),
    ("plane.sweep.num=100000000", "plane.max_cells = 1e+08"),
    ("plane=omega_b plane.parameter.min=-1", "plane.parameter.min = -1.0"),
    ("plane=omega_fe,omega_b", "several values need -m"),
    ("solver.corrector=secant", "solver.corrector = 'secant' is not allowed: it must be one of newton, broyden"),
    ("solver.tolerance=1", "solver.tolerance = 1.0"),
    ("solver.amplitude_max=0", "solver.amplitude_max = 0.0"),
    ("cluster=cloud", "cluster/cloud"),
    ("cluster.kind=cloud", "cluster.kind = 'cloud'"),
    ("cluster.workers=0", "cluster.workers = 0"),
    ("cluster=scheduler", "cluster.address = None"),
    ("store.name=../x", "store.name = '../x'"),
    ("store.name=a/b", "store.name = 'a/b'"),
    ("store.name=''", "store.name = ''"),
    ("store.max_points=1", "store.max_points = 1"),
    ("store.root=/dev/null/x", "store.root = '/dev/null/x'"),
    ("stages=sweep", "stages is not allowed: it must be a list"),
    ("stages=[dance]", "stages = 'dance'"),
    ("stages=[]", "stages = []"),
    ("stages=[figures]", "python -m pipeline plane=omega_fe makes it"),
    ("figures.curves=0.1", "figures.curves is not allowed: it must be a list"),
    ("figures.curves=[7]", "figures.curves = 7"),
    ("figures.formats=[gif]", "figures.formats = 'gif'"),
    ("hydra.run.dir=x", "Hydra's own settings are fixed"),
    ("gear=null", "gear=null is not allowed"),
    ("gear=[miter]", "gear=[miter] is not allowed"),
    ("gear={a:1}", "gear={a:1} is not allowed"),
    ("gear=5", "gear=5 is not allowed: it must be the name"),
    ("gear=miter.yaml", "gear=miter.yaml is not allowed: it must be the name"),
    ("gear.b=???", "gear.b has no value"),
    ("store.name=\u2603", "stands in quotes"),
    ("gear=spur", "alpha_phase, excitation with this gear"),
    ("solver=hb solver.order=65", "solver.order = 65 is not allowed: it must be from 1 to 64"),
    ("-m gear.b=0.5,0.50", "asks for one plane twice"),
    ("~gear", "gear has no value"),
    ("output=null", "output = null is not allowed"),
    ("-m gear.b=interval(0,1)", "range(0,1,0.1)"),
    ("-m gear.b=range(0,1e12)", "gear.b=range(0,1e12) is not allowed"),
    ("-m gear.b=shuffle(range(0,1e12))", "is not allowed"),
    ("-m gear.b=glob(*)", "gear.b=glob(*) is not allowed"),
    ("-m plane=glob(nothing*)", "plane=glob(nothing*) is not allowed"),
    ("-m plane.sweep.num=50,60", "store.name='omega_fe-${plane.sweep.num}'"),
    (f"gear.b={'9' * 10_000}", "gear.b=999"),
    (f"gear.b={'9' * 101}", "at most 100 digits"),
    (f"gear.kappa={'[' * 1000}{']' * 1000}", "nested deeper"),
    ("gear.b=${gear.b}", "gear.b"),
    ("--cfg=hydra", "--cfg job"),
    ("--cfg=what", "--cfg=what"),
    ("--package gear", "--cfg job"),
    ("--cfg job --package gear.nothing", "--package gear.nothing is not allowed: the configuration has no such"),
    ("--cfg job --package ..", "Error resolving key"),
    ("--cfg job --package figures.formats.png", "'png'"),
    ("--info=what", "--info=what"),
    ("--config-path=x", "--config-dir"),
    ("-cn mine", "--config-dir"),
    ("--hydra-help", "--help"),
    ("--experimental-rerun=x", "overrides.txt"),
    ("--what", "--what is not an option"),
    ("--config-dir=nowhere", "--config-dir = 'nowhere'"),
    ("cluster=scheduler cluster.address=tcp://127.0.0.1:9 cluster.timeout=0.5", "none answered there within 0.5 s"),
    ("cluster=scheduler cluster.address=nonsense://x cluster.timeout=0.5", "cluster.address = 'nonsense://x'"),
    ("cluster=scheduler cluster.address=foo", "cluster.address = 'foo' is not allowed"),
    ("cluster=scheduler cluster.address=ucx://127.0.0.1:9", "cluster.address = 'ucx://127.0.0.1:9' is not allowed"),
    ("cluster=scheduler cluster.address=tcp://127.0.0.1", "cluster.address = 'tcp://127.0.0.1' is not allowed"),
    ("cluster=scheduler cluster.address=tcp://h:99999", "cluster.address = 'tcp://h:99999' is not allowed"),
    ("cluster=scheduler cluster.address=tls://127.0.0.1:9", "cluster.security.ca_file = None"),
    ("cluster=scheduler cluster.scheduler_file=/etc/passwd", "cluster.scheduler_file = '/etc/passwd'"),
    ("cluster=scheduler cluster.scheduler_file=/dev/zero", "cluster.scheduler_file = '/dev/zero'"),
    ("cluster=scheduler", "cluster.address = None"),
    ("cluster.memory=1MB", "cluster.memory = '1MB' is not allowed"),
    ("cluster.memory=much", "cluster.memory = 'much' is not allowed"),
    ("cluster.memory=nan", "cluster.memory = 'nan' is not allowed"),
    ("cluster.workers=1024", "cluster.workers = 1024 is not allowed here"),
]


@pytest.mark.usefixtures("no_helpers")
@pytest.mark.parametrize(("typed", "said"), MISTAKES, ids=[typed for typed, _ in MISTAKES])
def test_a_mistake_is_one_line_status_2_and_nothing_written(typed, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(typed.split(" ")) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("error: ") and said in lines[0]
    assert list(tmp_path.iterdir()) == []


def test_spaces_around_the_equals_sign_are_refused(capsys):
    assert main(["gear.b = 0.5"]) == 2
    assert "gear.b = 0.5 cannot be read as KEY=VALUE: spaces" in capsys.readouterr().err


def test_helpers_that_load_while_a_mistake_is_found_are_ended(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    began = []
    monkeypatch.setattr("pipeline.run.helpers.Helpers", lambda _: began.append(Helpers(["json"])) or began[0])
    assert main(["gear.b=-1"]) == 2
    with pytest.raises(RuntimeError, match="shutdown"):
        began[0].begin(pow, [(2, 3)])
    assert len(capsys.readouterr().err.splitlines()) == 1 and list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("no_helpers")
def test_a_folder_that_cannot_be_written_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("mine")
    assert main(["output.root=file"]) == 2
    assert main(["store.root=file/store"]) == 2
    assert capsys.readouterr().err.count("must be a folder that can be written") == 2
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_a_disk_too_small_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    sizes = ["plane.sweep.num=1000000", "plane.parameter.num=100000", "plane.max_cells=1e12"]
    assert main(sizes) == 2
    assert "do not fit into" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_help_and_cfg(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["--help"]) == 0
    assert "usage: python -m pipeline" in capsys.readouterr().out
    assert main(["--cfg", "gear.b=0.25"]) == 0
    assert "b: 0.25" in capsys.readouterr().out
    for words in (["--cfg", "job"], ["--cfg=job"], ["-c", "job"], ["--cfg", "job", "--resolve"], ["--info", "config"]):
        assert main([*words, "gear.b=0.25"]) == 0
        assert "b: 0.25" in capsys.readouterr().out, words
    assert main(["--cfg", "job", "--package", "gear.variation"]) == 0
    assert capsys.readouterr().out == "translation: 1.0\nrotation: 0.0\n"
    assert main(["--cfg", "job", "--package", "gear.physical"]) == 0
    assert capsys.readouterr().out == "null\n"
    assert main(["-m", "--cfg", "job", "-p", "gear.b", "gear.b=0.5,0.6"]) == 0
    assert capsys.readouterr().out == "0.5\n0.6\n"
    for words in (["--info"], ["-i", "searchpath"]):
        assert main([*words, "gear.b=0.25"]) == 0
        assert "omega_fe-b=0.25.zarr" in (said := capsys.readouterr().out) and str(conf_folder()) in said
    assert main(["--version"]) == 0
    assert re.fullmatch(r"bevelmap .+\n", capsys.readouterr().out)
    assert main(["--complete"]) == 0
    assert list(tmp_path.iterdir()) == []


def _show(folder: Path, *command: str, path: Path | None = None) -> str:
    environment = {**os.environ, **({"PYTHONPATH": str(path)} if path else {})}
    result = subprocess.run(
        [sys.executable, *command], cwd=folder, capture_output=True, text=True, env=environment, check=True
    )
    return result.stdout


@pytest.mark.costly
def test_conf_is_found_from_a_wheel_the_repository_and_beside_a_foreign_pipeline(tmp_path):
    assert conf_folder() == ROOT / "conf"
    subprocess.run(
        [
            sys.executable,
            "-m",
            "pip",
            "wheel",
            "--quiet",
            "--no-deps",
            "--no-build-isolation",
            "--disable-pip-version-check",
            "--wheel-dir",
            tmp_path,
            _source_copy(tmp_path),
        ],
        check=True,
        capture_output=True,
    )
    (wheel,) = tmp_path.glob("bevelmap-*.whl")
    installed, empty = tmp_path / "site", tmp_path / "empty"
    subprocess.run([sys.executable, "-m", "zipfile", "-e", wheel, installed], check=True)
    assert _files_in(installed) == _files_to_ship()
    empty.mkdir()
    (empty / "conf").mkdir()
    where = "import pipeline.config.compose as c; print(c.conf_folder())"
    assert _show(empty, "-P", "-c", where, path=installed).strip() == str(installed / "pipeline" / "conf")
    assert "b: 1.0" in _show(empty, "-P", "-m", "pipeline", "--cfg", path=installed)
    assert "b: 1.0" in _show(ROOT, "-m", "pipeline", "--cfg")
    # A file of that name in the current folder hides the package from plain -m, not from -P and the script `bevelmap`.
    (empty / "pipeline.py").write_text("print('not this one')\n")
    assert "b: 1.0" in _show(empty, "-P", "-m", "pipeline", "--cfg", path=installed)


def _files_in(installed: Path) -> set[str]:
    """What a wheel brings, without its own description."""
    names = {file.relative_to(installed).as_posix() for file in installed.rglob("*") if file.is_file()}
    return {name for name in names if ".dist-info/" not in name}


def _files_to_ship() -> set[str]:
    """Every file of both packages, and conf/ where installed programs look for it."""
    files = [file for top in ("solver", "pipeline", "conf") for file in (ROOT / top).rglob("*") if file.is_file()]
    names = {file.relative_to(ROOT).as_posix() for file in files if file.parent.name != "__pycache__"}
    return {f"pipeline/{name}" if name.startswith("conf/") else name for name in names}


def _source_copy(folder: Path) -> Path:
    """The sources without build leftovers, so that building leaves none behind."""
    import shutil

    copy = folder / "source"
    shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".*", "outputs", "build", "*.egg-info", "__pycache__"))
    return copy


_TYPED = [
    (),
    ("gear.b=0.5", "stages=[list]"),
    ("plane=omega_b", "solver=hb", "solver.order=3", "cluster=none"),
    ("gear=miter", "gear.physical.torque='80 N*m'", "plane=omega_temperature"),
    ("plane.parameter2={name:b,min:0.1,max:1,num:3}", "++store.name=x", "figures.curves=[0.1,${gear.b}]"),
    ("output.root=${oc.env:HOME}", "quality=draft", "plane.sweep.num=${quality.parameter}"),
]


@pytest.mark.parametrize("overrides", _TYPED)
def test_values_are_given_as_hydra_gives_them(overrides):
    """Files are chosen first and remembered, and then values are given; Hydra does both at once."""
    with hydra.initialize_config_dir(version_base="1.3", config_dir=str(conf_folder())):
        at_once = hydra.compose("config", overrides)
    at_once = OmegaConf.merge(OmegaConf.structured(Configuration), at_once)
    OmegaConf.resolve(at_once)
    for _ in range(2):
        assert OmegaConf.structured(compose(overrides).config) == at_once


def test_a_file_that_has_changed_is_read_again(tmp_path):
    file = tmp_path / "gear" / "mine.yaml"
    file.parent.mkdir()
    for b in (0.25, 0.5):
        file.write_text(f"defaults: [published, _self_]\nb: {b}\n")
        words = ["gear=mine", "plane=omega_fe"]
        assert compose(words, str(tmp_path)).config.gear.b == b
        # The default name tells what differs from the file.
        assert compose([*words, "gear.b=0.25"], str(tmp_path)).store_name == f"omega_fe-mine{'-b=0.25' * (b != 0.25)}"
