"""How kernels are compiled: when, for what, and what importing the solver brings with it."""

import json
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import solver
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, RESIDUAL_AND_JACOBIAN, kernel
from solver.kernels.linear import dot, eliminate_rows

ROOT = Path(__file__).parents[3]


def said(code: str, **environment):
    """What a new process prints, read as JSON."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    code = f"import importlib, json, pkgutil, sys\n{code}"
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_importing_the_solver_loads_neither_kernels_nor_numba():
    loaded = said("import solver; print(json.dumps(sorted(sys.modules)))")
    assert not {"numba", "numpy", "scipy"} & set(loaded) and [n for n in loaded if n.startswith("solver.")] == []
    everything_but_what_compiles = """
import solver
for module in pkgutil.walk_packages(solver.__path__, 'solver.'):
    if module.name not in {f'solver.kernels.{name}' for name in ('backend', 'lowering', 'plain_code')}:
        importlib.import_module(module.name)
print(json.dumps(sorted({name.split('.')[0] for name in sys.modules})))
"""
    loaded = said(everything_but_what_compiles)
    foreign = {"pipeline", "hydra", "omegaconf", "dask", "distributed", "zarr", "xarray", "matplotlib", "rich"}
    assert "numpy" in loaded and not {"numba", "llvmlite", *foreign} & set(loaded)


def test_values_are_used_without_numba():
    code = """
from solver import EndReason, Event, ImpactState, Model, domain_label
from tests.conftest import published
model = published(alpha=0.1)
print(json.dumps([domain_label(0), EndReason(1).name, model.alpha, 'numba' in sys.modules]))
"""
    assert said(code)[1:] == ["RANGE_LEFT", 0.1, False]


def test_public_names_are_found_where_they_are_defined():
    names = said(
        "from solver import *; import solver; print(json.dumps([n for n in solver.__all__ if n in globals()]))"
    )
    assert names == solver.__all__ and set(names) <= set(dir(solver)) and len(names) > 40
    for name in names:
        value = getattr(solver, name)
        if callable(value):
            assert value.__module__.startswith("solver.") and pickle.loads(pickle.dumps(value)) is value
    with pytest.raises(AttributeError, match="no_such_name"):
        solver.no_such_name  # noqa: B018
    with pytest.raises(ImportError):
        from solver import no_such_name  # noqa: F401


def test_kernels_divide_as_numpy_does():
    @kernel(types.void(ARRAY, ARRAY))
    def divide(over, under):
        for i in range(over.shape[0]):
            over[i] /= under[i]

    values = np.array([1.0, -1.0, 0.0, 3.0])
    divide(values, np.array([0.0, 0.0, 0.0, 2.0]))
    np.testing.assert_array_equal(values, [np.inf, -np.inf, np.nan, 1.5])


@kernel(types.float64(types.float64, types.float64), inner=True)
def _weighted(x, weight):
    return weight * x


@kernel(types.float64(types.float64))
def _many_literals(x):
    return _weighted(x, 1) + _weighted(x, 2) + _weighted(2, x) + _weighted(3, 4)


def test_literals_do_not_multiply_compilations():
    from solver.kernels import backend

    assert _many_literals(5.0) == 5.0 + 10.0 + 10.0 + 12.0
    assert len(backend._kernel_type(_weighted).get_call_signatures()[0]) == 1
    assert len(backend._kernel_type(_weighted)._lowered) == 1


def test_a_kernel_takes_what_it_declares_and_nothing_else():
    assert dot(np.array([1.0, 2.0]), np.array([3.0, 4.0])) == 11.0
    for wrong in (np.array([1, 2]), np.array([1.0, 2.0])[::-1], np.ones((2, 2)), 1.0):
        with pytest.raises(TypeError, match="No matching definition"):
            dot(wrong, np.array([3.0, 4.0]))

    @kernel(types.float64(types.complex128))
    def wrongly_declared(z):
        return _weighted(z, 1.0)

    with pytest.raises(Exception, match="_weighted"):
        wrongly_declared(1j)


def test_one_kernel_for_real_and_complex_numbers():
    for kind in (float, complex):
        matrix = np.array([[2.0, 1.0], [1.0, 3.0]], kind)
        rights = np.array([[3.0, 5.0]], kind)
        determinant = eliminate_rows(matrix.copy(), rights)
        assert determinant == 5.0 and isinstance(determinant, kind)
        np.testing.assert_allclose(matrix @ rights[0], [3.0, 5.0])


@kernel(types.void(ARRAY, ARRAY, ARRAY, ARRAY, MATRIX))
def _squares(theta, direction, y, residual, jacobian):
    for i in range(residual.shape[0]):
        residual[i] = theta[0] * y[i] * y[i]


@kernel(types.void(RESIDUAL_AND_JACOBIAN, ARRAY, ARRAY, MATRIX))
def _by_pointer(balance, y, residual, jacobian):
    balance(y, y, y, residual, jacobian)


@kernel(types.void(ARRAY, ARRAY, MATRIX))
def _by_name(y, residual, jacobian):
    _squares(y, y, y, residual, jacobian)


def test_kernels_are_called_by_name_and_handed_in():
    y, jacobian = np.array([2.0, 3.0]), np.empty((2, 3))
    for call in (lambda found: _by_pointer(_squares, y, found, jacobian), lambda found: _by_name(y, found, jacobian)):
        found = np.zeros(2)
        call(found)
        np.testing.assert_array_equal(found, [8.0, 18.0])
    assert pickle.loads(pickle.dumps(_squares)) is _squares and _squares.__name__ == "_squares"


def _multiplier(factor):
    @kernel(types.float64(types.float64), inner=True)
    def inside(x):
        return factor * x + x / factor if x > 0.0 else factor

    @kernel(types.float64(types.float64))
    def multiply(x):
        return inside(x) + inside(-x)

    return multiply


def test_kernels_of_one_name_are_kept_apart():
    """Fresh ones and ones from the cache, in any order: each finds what it was made with."""
    for factor in (2.0, 4.0, 2.0, 8.0, 4.0):
        multiply = _multiplier(factor)
        assert multiply(4.0) == 4.0 * factor + 4.0 / factor + factor


def test_without_the_compiler_kernels_are_plain_functions():
    code = """
import numpy as np
from tests.solver.kernels.test_compile import _by_name, _by_pointer, _many_literals, _squares
found, jacobian = np.zeros((2, 2)), np.empty((2, 3))
_by_name(np.array([2.0, 3.0]), found[0], jacobian)
_by_pointer(_squares, np.array([2.0, 3.0]), found[1], jacobian)
from solver.kernels.compile import Kernel
print(json.dumps([found.tolist(), _many_literals(5.0), type(_squares.callable).__name__]))
"""
    found, number, kind = said(code, NUMBA_DISABLE_JIT="1")
    assert found == [[8.0, 18.0]] * 2 and number == 37.0 and kind == "function"


@pytest.mark.costly
def test_solutions_without_the_compiler_are_the_same():
    code = """
from tests.conftest import published
from solver import all_solutions
found = all_solutions(published(), 0.6)
print(json.dumps([found.mean.tolist(), found.amplitude.tolist()]))
"""
    found = said(code)
    assert said(code, NUMBA_DISABLE_JIT="1") == found and len(found[0]) > 0
