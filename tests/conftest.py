"""Parameter sets and reference digits that many tests use."""

from __future__ import annotations

import contextlib
import gc
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

# Tests run side by side; the threads of a small matrix product would wait for each other, at full speed.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
import pytest
import yaml
from hypothesis import settings

from tests.made_once import share
from tests.object_server import object_server  # noqa: F401

# The same examples in every run: a test that fails once fails again, and no folder of examples is left behind.
settings.register_profile("bevelmap", derandomize=True, deadline=None, max_examples=60, database=None)
settings.load_profile("bevelmap")

# Tests hold many objects for long: to look for garbage as often as Python does by default takes a tenth of the time.
gc.set_threshold(20_000, 20, 20)

# What pytest makes of the tests' sources is kept, whatever is set around it: it takes longer than all imports.
sys.dont_write_bytecode = False

if TYPE_CHECKING:
    from solver import Model

REFERENCE = Path(__file__).parent / "reference"


def published(**changes) -> Model:
    """The default parameter set, written out here so that conf/ is checked against it."""
    from solver import Model

    values = dict(
        b=1.0,
        alpha=0.2,
        f_e=0.2,
        f_pm=0.5,
        kappa=0.5,
        xi_mesh=0.05,
        xi_translation=0.0125,
        xi_support=0.01,
        k_support=1.0,
        pitch_cone_angle=45.0,
        pressure_angle=20.0,
        translation_coupling=0.3173,
        rotation_coupling=0.7719,
        variation_translation=1.0,
        variation_rotation=0.0,
    )
    return Model(**{**values, **changes})


def consistent(**changes) -> Model:
    """One mesh force for all rows, geometric couplings."""
    values = dict(translation_coupling="geometric", rotation_coupling="geometric", variation_rotation=1.0)
    return published(**{**values, **changes})


def antiphase(**changes) -> Model:
    """As consistent, with the stiffness in antiphase."""
    return consistent(**{"alpha_phase": np.pi, **changes})


MODELS = {"published": published, "consistent": consistent, "antiphase": antiphase}


def slow_but(ordinary, cases):
    """Cases for `parametrize`, of which only some are in the ordinary suite."""
    return [case if case in ordinary else pytest.param(*case, marks=pytest.mark.slow) for case in cases]


def pytest_collection_finish(session):
    """What has been collected stays until the end: it need not be searched for garbage time and again."""
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def _shared(tmp_path_factory):
    """Where `made_once` keeps what it makes."""
    base = tmp_path_factory.getbasetemp()
    # Below pytest-xdist every process has a folder of its own in a common one.
    folder = (base.parent if base.name.startswith("popen-") else base) / "shared"
    folder.mkdir(exist_ok=True)
    share(folder)


@pytest.fixture
def no_helpers(monkeypatch):
    """Runs of the command without the processes that load beside them, and are ended as soon as a mistake is found."""
    monkeypatch.setattr("pipeline.run.early.early_helpers", lambda _: contextlib.nullcontext())


@pytest.fixture(params=sorted(MODELS))
def gear(request):
    """Name and model of each of the three parameter sets."""
    return request.param, MODELS[request.param]()


@pytest.fixture(scope="session")
def reference() -> dict:
    """Reference digits."""
    return yaml.safe_load((REFERENCE / "published.yaml").read_text())["gears"]
