"""README.md: its Python runs as printed, and what it names exists."""

import doctest
import importlib
import re
import shlex
from pathlib import Path

import pytest

from pipeline.analysis import boundaries
from pipeline.config.compose import compose, expand
from pipeline.plan.planning import plan
from tests.pipeline.planes import small_plan, small_store

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
SNIPPETS = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
COMMANDS = re.findall(r"^    (?:\.venv/bin/)?python -m pipeline (.*?)(?:  +#.*)?$", README, flags=re.MULTILINE)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a stored plane where the README's snippets look for it."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "outputs/store").mkdir(parents=True)
    planned = small_plan("plane=omega_fe", columns=101, rows=11)
    boundaries.trace(small_store(folder / "outputs/store/omega_fe.zarr", planned), planned)
    return folder


def test_there_is_something_to_check():
    assert len(SNIPPETS) == 7 and len(COMMANDS) >= 7


@pytest.mark.parametrize(
    "snippet", SNIPPETS, ids=["open", "store", "boundaries", "solver", "thresholds", "statements", "order"]
)
def test_snippets_run(snippet, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    exec(compile(snippet, "README.md", "exec"), {})
    said = capsys.readouterr().out
    assert any(text in said for text in ("1/0", "2/0-1", "fold", "2/0-2 from", "agrees"))


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_compose(command):
    words = [word for word in shlex.split(command) if word != "-m"]
    if words == ["--help"]:
        return
    for combination in expand(words):
        settings = compose(combination)
        if "sweep" in settings.config.stages:
            plan(settings)


def test_own_plane_file_composes(tmp_path):
    (body,) = re.findall(r"with `--config-dir mine plane=omega_kappa`:\n\n(.*?)\n\n", README, flags=re.DOTALL)
    (tmp_path / "plane").mkdir()
    (tmp_path / "plane/omega_kappa.yaml").write_text("\n".join(line[4:] for line in body.splitlines()) + "\n")
    assert plan(compose(["plane=omega_kappa"], str(tmp_path))).parameter.name == "kappa"


def test_two_commands_are_what_ci_runs():
    assert "make test" in (ROOT / ".ci/run").read_text()
    makefile = (ROOT / "Makefile").read_text()
    assert "python -m pipeline plane=omega_fe" in makefile and "python -m pytest" in makefile
    assert all(f"    make {target} " in README and f"\n{target}:" in makefile for target in ("map", "test"))
    assert "`make bench`" in README and "\nbench:" in makefile


@pytest.mark.parametrize(
    "module", ["pipeline.run.workforce", "pipeline.cli.completion", "pipeline.store.listing", "pipeline.api"]
)
def test_doctests_of_the_pipeline(module):
    results = doctest.testmod(importlib.import_module(module))
    assert results.attempted > 0 and results.failed == 0
