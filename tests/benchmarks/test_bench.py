"""The benchmarks: baselines that solve the problem they are timed at, and results of the promised form."""

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.baselines import fsolve_sweep, residual, runge_kutta_sweep, there_and_back
from benchmarks.commands import measure_commands
from benchmarks.measurement import FULL, QUICK, TINY, Baselines, Measurement, timed
from benchmarks.numerics import measure_numerics
from benchmarks.report import PAGE, SCHEMA, document, fill, table, write
from solver import sweep_row, uncondensed_balance
from solver.timedomain import settle
from tests.conftest import MODELS

NUMERICS = {"kernel": "us", "enumeration": "us", "row": "ms", "row_order_5": "ms"}
COMMANDS = {"plane_draft": "s", "resume": "s", "start_warm": "s", "boundaries": "s", "figure": "s", "cell": "B/cell"}


def test_the_balance_of_fsolve_is_the_uncondensed_one(gear):
    _, model = gear
    model = model.replace(alpha_phase=0.7, f_pv=0.3)
    balance, random = residual(model), np.random.default_rng(5)
    for _ in range(20):
        unknowns, omega = 2.0 * random.normal(size=21), random.uniform(0.1, 2.0)
        expected, _ = uncondensed_balance(model, omega, unknowns)
        np.testing.assert_allclose(balance(unknowns, omega), expected, rtol=1e-12, atol=1e-12)


def test_fsolve_finds_motions_that_exist():
    model, grid = MODELS["published"](), np.linspace(0.65, 1.15, 11)
    amplitudes, solved = fsolve_sweep(model, grid)
    row = sweep_row(model, "omega", grid)
    known = np.concatenate([row.amplitude, row.amplitude[::-1]])
    # A grid as coarse as this one loses a point now and then.
    found = np.isfinite(amplitudes)
    assert there_and_back(grid).size == 22 and solved == found.sum() >= 20
    assert np.max(np.nanmin(np.abs(known[found] - amplitudes[found, None]), axis=1)) < 1e-8


@pytest.mark.costly
def test_runge_kutta_settles_where_the_integrator_does():
    model = MODELS["consistent"]()
    grid = np.array([0.9, 1.9])
    found = runge_kutta_sweep(model, grid)
    # Taylor integration with located contact switches, from a closed mesh at rest: (u, lambda) and their rates.
    for omega, amplitude in zip(there_and_back(grid), found, strict=True):
        attractors, slots = settle(model, omega, [[0.0, model.b + 1.0, 0.0, 0.0]])
        assert amplitude == pytest.approx(attractors.amplitude[0, slots[0]], rel=2e-3)


def check_document(found: dict, names: dict) -> None:
    """What a reader of the JSON may rely on."""
    assert set(found) == {"schema", "made", "quick", "seconds", "machine", "versions", "measurements"}
    assert found["schema"] == SCHEMA == 1 and found["seconds"] >= 0.0
    assert {"processor", "cores", "system", "load"} == set(found["machine"]) and "numba" in found["versions"]
    assert {one["name"]: one["unit"] for one in found["measurements"]} == names
    for one in found["measurements"]:
        assert 0.0 < one["lowest"] <= one["median"] <= one["highest"] and one["repeats"] >= 1
        assert set(one["baselines"]) == ({"uncompressed"} if one["name"] == "cell" else {"fsolve", "runge_kutta"})
        for baseline in one["baselines"].values():
            assert baseline["ratio"] == pytest.approx(baseline["value"] / one["median"])


@pytest.mark.costly
def test_the_numerics_of_a_tiny_run_as_json_and_table(tmp_path):
    measurements, baselines = measure_numerics(TINY)
    assert baselines.fsolve > 0.0 and baselines.runge_kutta > 0.0
    found = document(measurements, True, 1.0)
    write(found, tmp_path / "deep/bench.json")
    assert json.loads((tmp_path / "deep/bench.json").read_text()) == found
    check_document(found, NUMERICS)
    lines = table(found).splitlines()
    assert all(f"| {name}: " in "\n".join(lines) for name in NUMERICS)
    assert {line.count("|") for line in lines[:6]} == {6}


def test_the_page_is_filled_and_filled_again(tmp_path):
    page = tmp_path / "speed.md"
    page.write_text(PAGE.read_text(encoding="utf-8"), encoding="utf-8")
    begin, end = page.read_text(encoding="utf-8").split("## Large planes")
    for seconds in (1.0, 2.0):
        found = document([Measurement("new", "is measured", "s", (seconds,), {"fsolve": 30.0})], False, 1.0)
        fill(found, page)
        text = page.read_text(encoding="utf-8")
        assert table(found) in text and text.count("| what | measured |") == 1
        assert text.startswith(begin.partition("| what | measured |")[0].rstrip()) and text.endswith(end)


@pytest.mark.slow
def test_a_whole_tiny_run(tmp_path):
    baselines = Baselines(1e-3, 1e-2)
    check_document(document(measure_commands(tmp_path, TINY, baselines), True, 1.0), COMMANDS)


def test_numbers_of_a_measurement():
    plain = Measurement("n", "w", "s", (3.0, 1.0, 8.0), {"fsolve": 30.0}).plain
    assert (plain["median"], plain["lowest"], plain["highest"], plain["repeats"]) == (3.0, 1.0, 8.0, 3)
    assert plain["baselines"] == {"fsolve": {"value": 30.0, "ratio": 10.0}}
    assert Baselines(1.0, 2.0).of(10, 3) == {"fsolve": 60.0, "runge_kutta": 120.0}
    calls = []
    assert len(timed(lambda: calls.append(1), 4)) == 4 and len(calls) == 5


def test_the_page_names_every_figure():
    page = (Path(__file__).parents[2] / "benchmarks/README.md").read_text()
    for name in {**NUMERICS, **COMMANDS, **FULL.planes, **QUICK.planes, "start_cold": "s"}:
        assert f"`{name}`" in page
    assert "\nbench:" in (Path(__file__).parents[2] / "Makefile").read_text()
