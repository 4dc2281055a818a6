"""How kernels are compiled and cached, and what importing the solver brings with it."""

import subprocess
import sys

import numpy as np
from numba import types

from solver.kernels import compile as compiled
from solver.kernels.compile import ARRAY, kernel


def test_kernels_divide_as_numpy_does():
    @kernel(types.void(ARRAY, ARRAY))
    def divide(over, under):
        for i in range(over.shape[0]):
            over[i] /= under[i]

    values = np.array([1.0, -1.0, 0.0, 3.0])
    divide(values, np.array([0.0, 0.0, 0.0, 2.0]))
    np.testing.assert_array_equal(values, [np.inf, -np.inf, np.nan, 1.5])


def test_the_cache_of_a_module_belongs_to_its_sources(tmp_path, monkeypatch):
    monkeypatch.setattr(compiled, "_ROOT", tmp_path)
    texts = {
        "user.py": "from solver.used import f\nfrom solver.part import other\n",
        "used.py": "from solver.deep.inner import g\n",
        "deep/__init__.py": "",
        "deep/inner.py": "x = 1\n",
        "part/__init__.py": "",
        "part/other.py": "x = 1\n",
        "stranger.py": "x = 1\n",
    }

    def digest(**changes):
        for name, text in {**texts, **changes}.items():
            (tmp_path / name).parent.mkdir(exist_ok=True)
            (tmp_path / name).write_text(text)
        compiled.module_digest.cache_clear()
        return compiled.module_digest(tmp_path / "user.py")

    assert digest() == digest() == digest(**{"stranger.py": "x = 2\n"})
    for name in set(texts) - {"stranger.py", "deep/__init__.py"}:
        assert digest(**{name: texts[name] + "y = 2\n"}) != digest()
    compiled.module_digest.cache_clear()


def test_the_cache_goes_where_numba_is_told(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert compiled.KernelStore().folder == tmp_path / "bevelmap"
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert compiled.KernelStore().folder == tmp_path / "xdg/bevelmap"


def test_the_solver_is_numerics_alone():
    code = "import sys, solver; print(sorted({name.split('.')[0] for name in sys.modules}))"
    modules = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    for foreign in ("pipeline", "hydra", "omegaconf", "dask", "distributed", "zarr", "xarray", "matplotlib", "rich"):
        assert f"'{foreign}'" not in modules
