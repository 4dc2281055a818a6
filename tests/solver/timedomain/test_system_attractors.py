"""Attractors of systems that are no gear pair: where they are published, and along axes of such systems."""

import numpy as np
import pytest

from solver import ImpactState
from solver.timedomain import AttractorKind, find_attractors
from tests.cases.stop import STOP
from tests.solver.rows.test_system_rows import ROTOR


def test_hit_and_miss_of_a_stop():
    """Between its folds a motion that hits the stop coexists with one that does not."""
    row = find_attractors(STOP, "omega", [1.2])
    assert {ImpactState.SINGLE_SIDED, ImpactState.FREE} == {ImpactState(int(state)) for state in row.impact[0, :2]}
    # Without contact the motion is linear.
    free = int(np.flatnonzero(row.impact[0] == ImpactState.FREE)[0])
    assert row.highest[0, free] == pytest.approx(0.1 / abs(1.0 - 1.44 + 0.036j), abs=1e-6)


@pytest.mark.parametrize(
    ("axis", "value"),
    [
        ("gap", 0.4),
        ("gap_scale", 0.4),
        ("mean_load", 1.5),
        ("contact_damping", 0.05),
        ("damping", 2.0),
        ("stiffness", 1.3),
    ],
)
def test_an_axis_leads_to_the_system_that_it_names(axis, value):
    along = find_attractors(ROTOR, axis, [value], omega=0.8)
    single = find_attractors(ROTOR.at(axis, value), "omega", [0.8])
    kept = np.flatnonzero(single.kind[0])
    np.testing.assert_array_equal(along.kind, single.kind)
    for name in ("lowest", "highest", "rms", "force", "contact_loss"):
        mine, theirs = (np.sort(getattr(row, name)[0][kept]) for row in (along, single))
        periodic = np.all(single.kind[0][kept] <= AttractorKind.PERIOD_8)
        np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-6 if periodic else 0.2)
