"""When kernels count as not compiled yet."""

import shutil
import subprocess
import sys
from pathlib import Path

import solver
from pipeline.warmup import compile_beside, is_cold
from solver.kernels.compile import cache_folder

SOLVER = Path(solver.__file__).parent


def test_a_cache_is_cold_until_it_holds_kernels(tmp_path, monkeypatch):
    assert not is_cold()
    kept = Path(cache_folder(SOLVER / "continuation" / "arclength.py"))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert is_cold()
    # The solver is imported here: there is nothing left to do beside.
    assert compile_beside() is None
    shutil.copytree(kept, tmp_path / "bevelmap" / kept.name)
    assert not is_cold()


def test_another_checkouts_kernels_do_not_count(tmp_path):
    """The same sources at another place: numba would compile them again."""
    for name in ("solver", "pipeline"):
        shutil.copytree(SOLVER.parent / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    code = "from pipeline.warmup import is_cold; print(is_cold())"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True"
