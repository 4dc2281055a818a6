"""The planes that ship: each composes, and where two of them meet in a point they hold the same motions."""

import numpy as np
import pytest

from pipeline.config import compose, conf_folder
from pipeline.plan import plan
from pipeline.sweep import balance_of, continuation_of, point_of, row_of, seeds_of
from solver import all_solutions

PLANES = sorted(path.stem for path in (conf_folder() / "plane").glob("*.yaml"))


def row_at(planned, value):
    return row_of(planned, value, balance_of(planned.solver), continuation_of(planned.solver), seeds_of(planned.solver))


def test_the_planes_are_these():
    assert set(PLANES) >= {"b_fe", "omega_alpha", "omega_b", "omega_fe", "omega_fpm", "omega_phase", "omega_xi",
                           "omega_xi_support"}  # fmt: skip


@pytest.mark.parametrize("name", ["omega_xi", "omega_xi_support", "omega_phase"])
def test_new_planes_hold_the_default_row(name):
    """At the published value of their parameter, rows of every plane over frequency are the same row."""
    size = "plane.sweep.num=61"
    planned, usual = plan(compose([f"plane={name}", size])), plan(compose(["plane=omega_fe", size]))
    value = {"omega_xi": 0.05, "omega_xi_support": 0.01, "omega_phase": 0.0}[name]
    assert planned.parameter.low <= value <= planned.parameter.high
    row, expected = row_at(planned, value), row_at(usual, 0.2)
    np.testing.assert_array_equal(row.domain, expected.domain)
    np.testing.assert_allclose(row.amplitude, expected.amplitude, rtol=1e-9)


def test_b_fe_meets_omega_b():
    """A plane without the frequency on an axis: its cells agree with enumeration, and with the plane omega x b."""
    planned = plan(compose(["plane=b_fe", "plane.sweep.num=26"]))
    over_frequency = plan(compose(["plane=omega_b", "plane.sweep.min=0.6", "plane.sweep.max=0.7", "plane.sweep.num=2"]))
    assert planned.omega == 0.6
    for b in (0.1, 0.7, 1.0):
        row = row_at(planned, b)
        for column in (0, 10, 25):
            model, omega = point_of(planned, b, planned.sweep.values[column])
            found = all_solutions(model, omega)
            assert row.n_solutions[column] == len(found.amplitude)
            np.testing.assert_allclose(row.amplitude[column, : len(found.amplitude)], np.sort(found.amplitude), rtol=1e-7)
        first = row_at(over_frequency, b)
        np.testing.assert_allclose(
            row.amplitude[10, : row.n_solutions[10]], first.amplitude[0, : first.n_solutions[0]], rtol=1e-7
        )
