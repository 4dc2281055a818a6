"""What is imported is declared, with a lower bound, and pinned for those who want what was tested."""

import ast
import re
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def plain(name: str) -> str:
    """A distribution's name as registries compare it."""
    return re.sub(r"[-_.]+", "-", name).lower()


EXPLORER = ROOT / "pipeline/explorer"
#: What submits jobs.
JOBS = [ROOT / "pipeline/run/jobqueue.py"]


def imported(files) -> set[str]:
    """Distributions that modules import, anywhere in them."""
    names = set()
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names.add(node.module.partition(".")[0])
    names -= {*sys.stdlib_module_names, "solver", "pipeline"}
    known = packages_distributions()
    return {plain(known[name][0]) for name in names}


def declared(extra: str | None = None) -> dict[str, str]:
    """Distribution -> lowest version."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    words = project["dependencies"] if extra is None else project["optional-dependencies"][extra]
    return {plain(name): low for name, low in (word.split(">=") for word in words)}


@pytest.mark.costly
def test_every_import_is_declared_and_nothing_else():
    files = [*ROOT.glob("solver/**/*.py"), *ROOT.glob("pipeline/**/*.py")]
    needed = imported(file for file in files if EXPLORER not in file.parents and file not in JOBS)
    needed -= set(declared("objects"))
    # The key of a run is made with it by dask, which has it as an extra.
    assert needed | {"cryptography"} == set(declared())


def test_what_pages_need_is_imported_by_the_explorer_alone_and_is_an_extra():
    extra = imported(EXPLORER.glob("**/*.py")) - set(declared())
    assert "bokeh" in extra and extra <= set(declared("explore"))


def test_what_jobs_need_is_imported_where_they_are_submitted_alone_and_is_an_extra():
    assert imported(JOBS) - set(declared()) == set(declared("slurm")) == {"dask-jobqueue"}


def test_every_declared_distribution_is_pinned_at_its_lower_bound_or_above():
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").split()
    pinned = {plain(name): version for name, version in (line.split("==") for line in lines)}
    extras = {name: low for extra in ("explore", "objects", "slurm") for name, low in declared(extra).items()}
    for name, low in {**declared(), **extras}.items():
        assert [int(part) for part in re.findall(r"\d+", pinned[name])] >= [int(part) for part in low.split(".")], name
