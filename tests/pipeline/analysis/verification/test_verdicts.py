"""Verdicts where the answer is known, of maps of any order, and where an integration fails."""

import numpy as np
import xarray as xr

from pipeline.analysis import verification
from pipeline.analysis.verification import Credibility, Verdict
from pipeline.analysis.verification.running import orders_of
from pipeline.analysis.verification.starts import read_starts
from pipeline.analysis.verification.tasks import check_rows, follow_starts
from pipeline.analysis.verification.verdicts import settling_of
from tests.pipeline.analysis.verification.verified import RUN, settings, silent
from tests.pipeline.planes import small_plan, small_store


def test_what_the_time_domain_is_known_to_say():
    """The upper solutions of the published gear at 0.60 and 0.62 are false, the lower one at 0.60 is not."""
    plan = small_plan("plane.sweep.min=0.6", "plane.sweep.max=0.62", "plane.parameter.min=0.2", columns=2, rows=2)
    assert plan.parameter.values[0] == 0.2
    from solver import all_solutions
    from tests.conftest import published

    verdicts = {}
    for column, omega in enumerate((0.6, 0.62)):
        found = all_solutions(published(), omega)
        for i in np.flatnonzero(found.stable == 1):
            start = verification.running.Start(
                0,
                column,
                int(i),
                float(found.mean[i]),
                float(found.amplitude[i]),
                0 if found.mean[i] - found.amplitude[i] > 1.0 else 1,
                (found.mean[i], found.cos[i], found.sin[i]),
            )
            (seen,) = follow_starts(plan, (start,), 3000, 0.05)
            verdicts[omega, found.amplitude[i] < 0.8] = seen
    assert verdicts[0.6, True].verdict is Verdict.CONFIRMED
    assert verdicts[0.6, False].verdict is Verdict.OTHER_MOTION and verdicts[0.6, False].amplitude < 0.8
    assert verdicts[0.62, False].verdict is verdicts[0.62, True].verdict is Verdict.NOT_PERIOD_1
    assert all(seen.periods_used <= 3000 for seen in verdicts.values())


def test_never_more_periods_than_allowed():
    for periods in (300, 301, 1000, 3000, 50_000):
        settling = settling_of(periods)
        window = settling.lyapunov_periods + settling.lyapunov_periods // 10 + settling.block
        assert settling.max_periods + window == periods


def test_without_contact_loss_everything_is_confirmed(tmp_path):
    plan = small_plan("plane.sweep.min=1.6", "plane.parameter.max=0.05", columns=5, rows=2)
    path = small_store(tmp_path / "linear.zarr", plan)
    summary = verification.verify(path, plan, settings(), RUN, silent)
    group = xr.open_zarr(path, group="verification").load()
    assert summary.verdicts[Verdict.CONFIRMED] == group.sizes["sample"] == 10 and not summary.failures
    assert np.all(group.credibility == Credibility.CONFIRMED) and np.all(np.abs(group.amplitude_error) < 1e-3)
    assert np.all(group.largest_multiplier < 1.0) and np.all(group.lyapunov < 0.0)


def test_orders_for_maps_of_higher_order():
    assert orders_of(small_plan(), 5) == (5, 10) and orders_of(small_plan(), 1) == (1, 2)
    assert orders_of(small_plan("solver=hb", "solver.order=3"), 5) == (6, 12)
    assert orders_of(small_plan("solver=hb", "solver.order=31"), 5) == (32, 64)
    assert orders_of(small_plan("solver=hb", "solver.order=32"), 5) == ()


def test_a_map_of_order_three(tmp_path):
    plan = small_plan("solver=hb", "solver.order=3", "plane.sweep.min=0.7", "plane.sweep.max=1.0", columns=5, rows=2)
    path = small_store(tmp_path / "hb.zarr", plan)
    starts = read_starts(path, plan, np.array([1, 1]), np.array([0, 4]))
    assert all(len(start.coefficients) == 7 for start in starts) and starts[-1].column == 4
    verification.verify(path, plan, settings(samples=6, beside=0), RUN, silent)
    group = xr.open_zarr(path, group="verification").load()
    assert group.attrs["orders"] == [6, 12]
    fine = group.verdict == Verdict.CONFIRMED
    assert fine.any() and np.all(np.abs(group.amplitude_error[fine]) < 5e-3)


def test_what_fails_is_recorded(tmp_path, monkeypatch):
    plan = small_plan("plane.sweep.min=1.6", "plane.parameter.max=0.05", columns=4, rows=3)
    path = small_store(tmp_path / "plane.zarr", plan)

    def broken(*arguments, **options):
        raise ArithmeticError("the step is lost")

    def lost_worker(function, tasks):
        for number, (task, result) in enumerate(RUN(function, tasks)):
            yield task, OSError("the worker\nis gone") if function is check_rows and number == 0 else result

    monkeypatch.setattr("solver.timedomain.settle", broken)
    summary = verification.verify(path, plan, settings(samples=5, beside=0), lost_worker, silent)
    group = xr.open_zarr(path, group="verification").load()
    assert np.all(group.verdict == Verdict.FAILED)
    assert set(group.message.values) == {"ArithmeticError: the step is lost"}
    assert group.row_message[0] == "OSError: the worker is gone" and np.all(group.row_message[1:] == "")
    assert np.all(group.credibility[0] == Credibility.UNCHECKED)
    assert np.all(group.credibility[1:] == Credibility.CONFIRMED)
    assert len(summary.failures) == 6 and "could not be integrated: ArithmeticError" in summary.failures[-1]
