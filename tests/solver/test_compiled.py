"""How kernels are compiled and cached, and what importing the solver brings with it."""

import subprocess
import sys

import numpy as np
from numba import types

from solver import compiled
from solver.compiled import ARRAY, kernel


def test_kernels_divide_as_numpy_does():
    @kernel(types.void(ARRAY, ARRAY))
    def divide(over, under):
        for i in range(over.shape[0]):
            over[i] /= under[i]

    values = np.array([1.0, -1.0, 0.0, 3.0])
    divide(values, np.array([0.0, 0.0, 0.0, 2.0]))
    np.testing.assert_array_equal(values, [np.inf, -np.inf, np.nan, 1.5])


def test_the_cache_belongs_to_the_sources(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    folder = compiled.cache_folder()
    assert folder.startswith(str(tmp_path)) and folder.endswith(compiled._source_digest())
    package = tmp_path / "copy"
    package.mkdir()
    monkeypatch.setattr(compiled, "__file__", str(package / "compiled.py"))
    digests = set()
    for name, text in (("a.py", "x = 1"), ("a.py", "x = 2"), ("sub/b.py", "x = 2"), ("notes.txt", "x")):
        (package / name).parent.mkdir(exist_ok=True)
        (package / name).write_text(text)
        digests.add(compiled._source_digest())
    assert len(digests) == 3


def test_the_solver_is_numerics_alone():
    code = "import sys, solver; print(sorted({name.split('.')[0] for name in sys.modules}))"
    modules = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    for foreign in ("pipeline", "hydra", "omegaconf", "dask", "distributed", "zarr", "xarray", "matplotlib", "rich"):
        assert f"'{foreign}'" not in modules
