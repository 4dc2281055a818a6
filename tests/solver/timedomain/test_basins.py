"""Shares of random starts."""

import numpy as np
import pytest

from solver import ParameterError
from solver.model.contact_system import gear_system
from solver.timedomain import AttractorKind, Settling, basin_box, basin_shares, wilson_interval
from tests.conftest import published
from tests.solver.timedomain.systems import mathieu, oscillator


def test_wilson_interval():
    # 81 of 263: R. G. Newcombe, Statistics in Medicine 17 (1998) 857-872, table I, method 3.
    low, high = wilson_interval(81, 263)
    assert (round(low, 4), round(high, 4)) == (0.2553, 0.3662)
    assert [round(value, 4) for value in wilson_interval(0, 20)] == [0.0, 0.1611]
    assert [round(value, 4) for value in wilson_interval(1, 29)] == [0.0061, 0.1718]
    assert wilson_interval(7, 7)[1] == 1.0
    with pytest.raises(ParameterError, match="count"):
        wilson_interval(3, 2)


def test_upper_resonance_of_the_published_pair():
    # docs/physics.md, section 8: three quarters of the starts on 2T, the others on the lower 1T.
    shares = basin_shares(gear_system(published()), 1.2265, 24, seed=1)
    assert [share.attractor.kind for share in shares] == [AttractorKind.PERIOD_2, AttractorKind.PERIOD_1]
    assert sum(share.count for share in shares) == 24
    assert shares[0].low < 0.8 < shares[0].high and shares[1].attractor.impact == 0
    assert shares[1].attractor.mean == pytest.approx(1.6477523, abs=1e-6)
    again = basin_shares(gear_system(published()), 1.2265, 24, seed=1)
    assert [share.count for share in again] == [share.count for share in shares]


@pytest.mark.parametrize("omega", [0.58, 0.60, 0.62])
def test_lower_resonance_of_the_published_pair(omega):
    settling = Settling(max_periods=600, lyapunov_periods=800, tolerance=1e-9)
    shares = basin_shares(gear_system(published()), omega, 12, seed=2, settling=settling)
    kinds = {share.attractor.kind: share.count for share in shares}
    if omega == 0.62:
        assert kinds == {AttractorKind.QUASI_PERIODIC: 12}
    else:
        assert kinds[AttractorKind.PERIOD_1] >= 9
        assert set(kinds) <= {AttractorKind.PERIOD_1, AttractorKind.QUASI_PERIODIC}


@pytest.mark.parametrize("omega, amplitudes", [(0.57, [0.2830220, 1.0112066]), (0.63, [0.7624413])])
def test_outside_the_torus_the_upper_branch_is_a_period_1_attractor(omega, amplitudes):
    # Beyond the Neimark-Sacker points at 0.57415 and 0.62304 of the true orbit; at 0.63 it is the only attractor.
    shares = basin_shares(gear_system(published()), omega, 16, seed=3)
    assert {share.attractor.kind for share in shares} == {AttractorKind.PERIOD_1}
    assert sorted(share.attractor.amplitude for share in shares) == pytest.approx(amplitudes, abs=1e-6)
    assert max(share.attractor.impact for share in shares) == 1


def test_one_attractor_and_none():
    (only,) = basin_shares(oscillator(0.1), 0.7, 5, seed=0)
    assert only.share == 1.0 and only.high == 1.0
    (away,) = basin_shares(mathieu(1.0, 0.3), 2.0, 5, seed=0)
    assert away.attractor.kind is AttractorKind.UNBOUNDED


def test_box():
    system = gear_system(published())
    box = basin_box(system, 0.6)
    assert box.shape == (4,) and np.all(box[:2] > 3.0) and np.all(box > 0.0)
    (only,) = basin_shares(system, 0.6, 2, seed=0, box=np.zeros(4))
    assert only.count == 2
    for wrong in (np.ones(3), [[1.0] * 4, [0.0] * 4], [np.inf] * 4):
        with pytest.raises(ParameterError, match="^box ="):
            basin_shares(system, 0.6, 2, seed=0, box=wrong)
    with pytest.raises(ParameterError, match="^count ="):
        basin_shares(system, 0.6, 0, seed=0)
