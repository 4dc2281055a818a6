"""When kernels count as not compiled yet."""

import shutil
import subprocess
import sys
from pathlib import Path

import solver
from pipeline.cli.warmup import compile_beside, is_cold
from solver.kernels.compile import kernel_store, module_digest

SOLVER = Path(solver.__file__).parent
CODE = "from pipeline.cli.warmup import is_cold; print(is_cold())"


def _said_elsewhere(folder) -> bool:
    done = subprocess.run([sys.executable, "-c", CODE], cwd=folder, capture_output=True, text=True, check=True)
    return {"True\n": True, "False\n": False}[done.stdout]


def test_a_cache_is_cold_until_it_holds_kernels(tmp_path, monkeypatch):
    assert not is_cold()
    kept = kernel_store().folder
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert is_cold()
    # The solver is imported here: there is nothing left to do beside.
    assert compile_beside() is None
    for entry in kept.glob(f"arclength-{module_digest(SOLVER / 'continuation/arclength.py')}-*"):
        shutil.copy(entry, tmp_path / "bevelmap")
    assert not is_cold()


def test_kernels_of_other_sources_do_not_count(tmp_path):
    """A copy elsewhere shares them, until something that they depend on is edited."""
    for name in ("solver", "pipeline"):
        shutil.copytree(SOLVER.parent / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    assert not _said_elsewhere(tmp_path)
    with (tmp_path / "solver/continuation/correctors.py").open("a") as file:
        file.write("\n_NEW = 1\n")
    assert _said_elsewhere(tmp_path)
