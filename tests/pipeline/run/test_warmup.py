"""The first run: what is compiled before rows are due, and that it is what the run needs."""

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.__main__ import main
from pipeline.run import warmup
from pipeline.run.kernels import NEEDED, kernels_for, ready_for_rows
from pipeline.run.progress import Reporter
from pipeline.run.warmup import warm_up
from pipeline.stages import STAGES
from solver.kernels.warm import kernels_of
from tests.pipeline.planes import small_plan, small_store

ROOT = Path(__file__).parents[3]
BALANCES = ("describing_function", "galerkin")


def test_what_stages_need_exists():
    assert set(NEEDED) <= {entry.name for entry in STAGES}
    for balance in BALANCES:
        names = kernels_for(NEEDED, balance)
        assert len(names) == len(set(names)) and all(kernels_of([name]) for name in names)
    assert kernels_for(["list", "check"], "galerkin") == [] and kernels_for([], "describing_function") == []


def test_what_is_kept_is_not_spoken_of():
    ready_for_rows("describing_function")
    said = io.StringIO()
    warm_up(kernels_for(["sweep"], "describing_function"), Reporter(said))
    assert said.getvalue() == ""


#: A run in this process: kernels that were compiled before rows were due, all that were, and those that were used.
RUN = """
import contextlib, gc, json, sys
from pipeline.__main__ import main
from pipeline.run import warmup
from solver.kernels import backend
from solver.kernels.compile import Kernel

compiled, original = [], backend._compiled
backend._compiled = lambda kernel, *others: compiled.append(kernel) or original(kernel, *others)
called, call = set(), Kernel.__call__
Kernel.__call__ = lambda kernel, *arguments: called.add(kernel) or call(kernel, *arguments)
pointed, address = set(), Kernel.__wrapper_address__
Kernel.__wrapper_address__ = lambda kernel: pointed.add(kernel) or address(kernel)
before, warm_up = [], warmup.warm_up

def noted(*arguments):
    warm_up(*arguments)
    before.extend(k for k in gc.get_objects() if isinstance(k, Kernel) and "callable" in vars(k))

warmup.warm_up = noted
with contextlib.redirect_stdout(sys.stderr):
    status = main(sys.argv[1:])
names = lambda kernels: sorted(f"{kernel.__module__}.{kernel.__name__}" for kernel in kernels)
print(json.dumps([status, names(before), names(compiled), names(called | pointed)]))
"""


RUNS = [
    ["solver=first_order", "stages=[sweep,boundaries]"],
    ["solver=hb", "solver.order=3", "stages=[sweep]", "plane.parameter.num=3"],
]


#: A system that is no bevel pair has kernels of its own.
SPUR = ["gear=spur", "plane=omega_load"]


def ran(folder, options, **environment):
    """A small run in a process of its own: status, names of kernels as in `RUN`, and what it said."""
    plane = [] if "gear=spur" in options else ["plane=omega_fe"]
    arguments = [*plane, "plane.sweep.num=40", "plane.parameter.num=8", "cluster=none", *options]
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    command = [sys.executable, "-c", RUN, *arguments]
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=3000)
    assert done.returncode == 0, done.stderr
    return *json.loads(done.stdout), done.stderr


@pytest.mark.costly
@pytest.mark.parametrize(("options", "balance"), list(zip(RUNS, BALANCES, strict=True)))
def test_what_a_run_calls_is_listed(tmp_path, options, balance):
    """With kernels that are kept, so that it is seen without compiling."""
    status, _, _, used, _ = ran(tmp_path, options)
    listed = kernels_of(kernels_for(["sweep", "boundaries"], balance))
    missed = set(used) - {f"{kernel.__module__}.{kernel.__name__}" for kernel in listed}
    assert status == 0 and used and not missed, f"needed, but not listed: {missed}"


@pytest.mark.costly
@pytest.mark.parametrize(("options", "balance"), list(zip(RUNS, BALANCES, strict=True)))
def test_what_a_run_of_another_system_calls_is_listed(tmp_path, options, balance):
    small = ["plane.sweep.num=30", "plane.parameter.num=3", "plane.sweep.min=0.5"]
    status, _, _, used, _ = ran(tmp_path, [*options, *SPUR, *small])
    listed = kernels_of(kernels_for(["sweep", "boundaries"], balance, "spur"))
    missed = set(used) - {f"{kernel.__module__}.{kernel.__name__}" for kernel in listed}
    assert status == 0 and used and not missed, f"needed, but not listed: {missed}"


@pytest.mark.costly
@pytest.mark.parametrize(("options", "balance"), list(zip(RUNS, BALANCES, strict=True)))
def test_what_a_place_calls_is_listed(tmp_path, options, balance):
    """The stage motion solves the balance and integrates at one place."""
    balanced = [word for word in options if not word.startswith("stages")]
    path = tmp_path / "outputs/store/plane.zarr"
    path.parent.mkdir(parents=True)
    small_store(path, small_plan("plane=omega_fe", *balanced, columns=20, rows=3))
    sizes = ["plane.sweep.num=20", "plane.parameter.num=3", "store.name=plane"]
    motion = ["stages=[motion]", "motion.at=[.6,.2]", "figures.formats=[png]", "figures.dpi=30"]
    status, _, _, used, _ = ran(tmp_path, [*balanced, *sizes, *motion])
    missed = set(used) - {f"{k.__module__}.{k.__name__}" for k in kernels_of(kernels_for(["motion"], balance))}
    assert status == 0 and used and not missed, f"needed, but not listed: {missed}"


@pytest.mark.slow
@pytest.mark.parametrize("options", RUNS)
def test_a_first_run_compiles_what_it_needs_and_nothing_else(tmp_path, options):
    """Before rows are due, and what is not needed not at all."""
    status, before, compiled, used, said = ran(tmp_path, options, NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    assert status == 0 and "compiling" in said
    assert set(used) <= set(before), f"needed, but not compiled ahead: {set(used) - set(before)}"
    assert set(compiled) <= set(before)
    # What the module of a kernel brings with it, such as the other corrector.
    assert len(set(before) - set(used)) <= 3, f"compiled, but not needed: {set(before) - set(used)}"


def test_everything_is_compiled_ahead(monkeypatch, capsys):
    """`python -m pipeline warmup` asks for all kernels of the solver, and for nothing with them."""
    asked = []
    monkeypatch.setattr(warmup, "warm_up", lambda names, reporter: asked.extend(names))
    assert main(["warmup"]) == 0 and "ready" in capsys.readouterr().out
    kernels = kernels_of(asked)
    assert {k for name in kernels_for(NEEDED, "galerkin") for k in kernels_of([name])} <= set(kernels)
    assert any(kernel.__module__.startswith("solver.timedomain") for kernel in kernels)
    assert main(["warmup", "gear.b=0.5"]) == 2
