"""A row followed up and down: its hysteresis against true saddle-nodes and the search for attractors; its spectra."""

import functools

import numpy as np
import pytest

from pipeline.analysis.attractors.queries import hysteresis
from pipeline.analysis.diagram.following import DIRECTIONS, Followed, follow
from pipeline.analysis.diagram.options import Way, spectrum_of, way_of
from pipeline.analysis.diagram.sheets import rms_along
from pipeline.analysis.diagram.spectra import spectra_of
from pipeline.config.compose import compose
from pipeline.plan.numerics import point_of
from pipeline.plane.row_curves import curves_at
from pipeline.plane.stored import read_stored
from solver import gear_system
from solver.timedomain import AttractorKind, measure, trajectory
from tests.pipeline.planes import small_plan, small_store

#: Saddle-nodes of the published pair at f_e = 0.2, by shooting (tests/solver/timedomain/test_slow_run.py, where two are
#: bisected, and the others likewise): ends of the hysteresis of each resonance.
UPPER, LOWER = {0: 1.2194472, 1: 1.2301969}, {0: 0.5259298, 1: 0.6173089}


def plan_between(low: float, high: float, *further: str):
    return small_plan(f"plane.sweep.min={low}", f"plane.sweep.max={high}", *further, columns=31, rows=3)


@functools.cache
def followed(low: float = 1.2, high: float = 1.26) -> Followed:
    plan = plan_between(low, high)
    way = way_of("diagram", compose(["diagram.value=0.2", "diagram.columns=31"]).config.diagram, plan)
    return follow(plan, way)


@pytest.mark.costly
@pytest.mark.parametrize("low, high, ends", [(1.2, 1.26, UPPER), (0.5, 0.65, LOWER)])
def test_hysteresis_ends_at_saddle_nodes(low, high, ends):
    found, step = followed(low, high).hysteresis, (high - low) / 30
    for side, place in ends.items():
        # To half of a small step, sixteen of which are one.
        assert np.min(np.abs(found[:, side] - place)) <= step / 32 + 1e-6


@pytest.mark.costly
def test_hysteresis_is_that_of_the_attractors(tmp_path):
    """Where the two runs differ, the search in every cell, which knows nothing of runs, tells hysteresis as well."""
    from pipeline.__main__ import main
    from pipeline.analysis.attractors.dataset import read_attractors

    overrides = ["plane.sweep.min=1.2", "plane.sweep.max=1.26", "plane.sweep.num=31", "plane.parameter.num=6"]
    words = [*overrides, "stages=[sweep,attractors]", "attractors.rows=[0.2]", "cluster=none", "store.name=narrow"]
    assert main([*words, f"output.root={tmp_path}"]) == 0
    attractors = read_attractors(tmp_path / "store/narrow.zarr")
    told = hysteresis(attractors).values[0]
    (ends,) = followed().hysteresis
    within = (attractors.omega.values > ends[0]) & (attractors.omega.values < ends[1])
    np.testing.assert_array_equal(told, within)


def test_what_is_stored_and_what_is_asked_for():
    plan = plan_between(0.05, 2.0)
    config = compose(["diagram.value=0.2"]).config.diagram
    assert len(way_of("diagram", config, plan).columns) == 400
    wide = small_plan(columns=500, rows=3)
    np.testing.assert_array_equal(way_of("diagram", config, wide).columns, wide.sweep.values)
    few = compose(["diagram.value=0.2", "diagram.columns=7"]).config.diagram
    np.testing.assert_allclose(way_of("diagram", few, wide).columns, np.linspace(0.05, 2.0, 7))


def test_runs_over_another_parameter_than_the_frequency():
    """b over f_e at a fixed frequency: without backlash no motion leaves contact, whatever the direction."""
    plan = small_plan("plane=b_fe", columns=11, rows=3)
    found = follow(plan, Way(0.2, tuple(plan.sweep.values), 2300))
    assert [run.values[0] < run.values[-1] for run in found.runs.values()] == [True, False]
    assert found.runs["up"].impact[0] == found.runs["down"].impact[-1] == 0


def asked(*words: str, plan):
    return spectrum_of(compose(["spectrum.value=0.2", *words]).config.spectrum, plan)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_spectra_of_periodic_motions_are_their_fourier_series(direction):
    found = followed()
    options = asked(f"spectrum.direction={direction}", "spectrum.orders=4", plan=found.plan)
    spectra, run = spectra_of(found, options), found.runs[direction]
    assert np.all(np.diff(spectra.values) > 0.0) and spectra.orders[-1] == 4.0
    ascending = slice(None) if direction == "up" else slice(None, None, -1)
    kinds = run.kind[ascending]
    np.testing.assert_array_equal(spectra.kind, kinds)
    doubled = kinds == AttractorKind.PERIOD_2
    assert doubled.any() or direction == "up"
    for i in np.flatnonzero(kinds <= AttractorKind.PERIOD_2).tolist():
        model, omega = point_of(found.plan, 0.2, spectra.values[i])
        motion = measure(gear_system(model), omega, run.state[ascending][i], 2, divisor=2, order=8)
        for order, amplitude in zip(spectra.orders, spectra.amplitudes[i], strict=True):
            exact = abs(motion.harmonics[round(2 * order)]) if (2 * order) % 1 == 0 else 0.0
            assert amplitude == pytest.approx(exact, abs=2e-5)
        half = spectra.amplitudes[i, spectra.orders == 0.5]
        assert (half > 0.1) == (kinds[i] == AttractorKind.PERIOD_2)


def test_spectra_of_a_torus_have_all_of_its_power():
    found = followed()
    options = asked("spectrum.of=force", "spectrum.orders=30", plan=found.plan)
    spectra, run = spectra_of(found, options), found.runs["up"]
    (torus,) = np.nonzero(run.kind == AttractorKind.QUASI_PERIODIC)
    assert torus.size
    for i in torus[:3].tolist():
        model, omega = point_of(found.plan, 0.2, spectra.values[i])
        motion = trajectory(model, omega, run.state[i], 192, 64)
        # A Hann window has 3/2 times the power of a line of amplitude 1 within it.
        power = 0.5 * np.sum(spectra.amplitudes[i] ** 2) / 1.5
        assert power == pytest.approx(np.var(motion.force), rel=0.05)
        assert spectra.mean[i] == pytest.approx(motion.force.mean(), rel=0.02)


def test_rms_of_the_branches_is_that_of_their_harmonics(tmp_path):
    plan = small_plan()
    plane = read_stored(small_store(tmp_path / "omega_fe.zarr", plan))
    curves = curves_at(plane, 0.2)
    np.testing.assert_allclose(rms_along(curves), curves.points["amplitude"] / np.sqrt(2.0), rtol=1e-12)
