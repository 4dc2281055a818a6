"""A row is what it is alone: what was computed before, in which order and in which process, changes no bit of it."""

import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from solver import DescribingFunction, LinearSeeds, ProvenSeeds, sweep_row
from solver.harmonic.galerkin import Galerkin
from solver.rows.seeds import LiftedSeeds
from tests.conftest import antiphase, consistent, published

#: Rows that differ from one another in gear, axis, balance, seeds and numbers of columns and coordinates.
ROWS = {
    "published": (published(), "omega", None, None, 61),
    "finer": (published(f_e=0.35), "omega", None, ProvenSeeds(columns=25), 117),
    "uncoupled": (consistent(translation_coupling=0.0), "omega", None, None, 33),
    "unlike supports": (published(k_support=[0.5, 0.8, 1.0, 1.2, 1.5, 2.0]), "omega", None, None, 33),
    "over f_e": (antiphase(), "f_e", None, LinearSeeds(), 40),
    "over b": (published(), "b", DescribingFunction(), None, 40),
    "order 5": (antiphase(f_e=0.3), "omega", Galerkin(5), LiftedSeeds(41), 61),
    "two periods": (consistent(f_e=0.4), "omega", Galerkin(2, 2), LiftedSeeds(21), 25),
}
RANGES = {"omega": (0.3, 1.9), "f_e": (0.05, 0.5), "b": (0.1, 1.2)}


def digest(name: str) -> str:
    """Of everything that a row holds."""
    model, axis, balance, seeds, columns = ROWS[name]
    omega = None if axis == "omega" else 0.62
    row = sweep_row(model, axis, np.linspace(*RANGES[axis], columns), omega=omega, balance=balance, seeds=seeds)
    parts = [row.motions, row.stable, row.impact, row.instability, row.multiplier, row.open, row.certified]
    for curve in row.curves:
        parts += [curve.points, curve.tangents, curve.arclength, curve.stable, curve.event]
    text = repr((row.notes, [curve.ends for curve in row.curves]))
    return hashlib.sha256(b"".join([*(part.tobytes() for part in parts), text.encode()])).hexdigest()


def test_the_order_of_rows_changes_nothing():
    ahead = {name: digest(name) for name in ROWS}
    assert len(set(ahead.values())) == len(ROWS)
    assert {name: digest(name) for name in reversed(ROWS)} == ahead
    for name in ROWS:
        assert digest(name) == ahead[name] == digest(name)


@pytest.mark.costly
@pytest.mark.parametrize("name", ["finer", "order 5"])
def test_a_row_of_a_new_process_is_the_same(name):
    for other in ROWS:
        digest(other)
    code = f"from tests.solver.rows.test_row_independence import digest; print(digest({name!r}))"
    root = Path(__file__).parents[3]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert digest(name) == done.stdout.strip()
