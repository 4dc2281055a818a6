"""Free vibration at order H against closed forms and the first-order backbone."""

import numpy as np
import pytest

from solver import ContactSystem, backbone, free_vibration, gear_system
from tests.conftest import published

#: x'' + x + 10 max(x - 1, 0) = 0.
STOP = ContactSystem([[1.0]], [[0.0]], [[1.0]], [1.0], [10.0], 1.0)


def test_a_mass_against_a_stop():
    """The time on either side of the flank follows from x and x', of frequencies 1 and sqrt(11)."""
    highest = np.array([1.05, 1.2, 1.6])
    # In contact x = x_0 + c cos(w t) about 10/11; it leaves the flank with the speed that the spring then has.
    w, rest = np.sqrt(11.0), 10.0 / 11.0
    inside = np.arccos((1.0 - rest) / (highest - rest)) / w
    speed = w * np.sqrt((highest - rest) ** 2 - (1.0 - rest) ** 2)
    outside = np.pi - np.arctan2(speed, 1.0)
    found = free_vibration(STOP, highest, order=63)
    np.testing.assert_allclose(found.omega, np.pi / (inside + outside), rtol=0, atol=2e-6)


@pytest.mark.parametrize("mode", [0, 1])
def test_first_order_of_a_gear_pair_is_its_backbone(mode):
    """As far as the first order of two balances is the same: contact is lost by little or not at all."""
    model = published()
    curve = backbone(model, [0.2, 0.5])
    found = free_vibration(model, curve.amplitude + curve.mean, order=9, mode=mode)
    np.testing.assert_allclose(found.omega, (curve.lower, curve.upper)[mode], rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.motions[:, 1], curve.amplitude, rtol=0, atol=1e-12)


def test_the_mean_load_is_carried_and_higher_orders_settle():
    model = published()
    orders = [free_vibration(model, [2.5, 3.0], order=order, mode=0).omega for order in (9, 21, 41)]
    assert np.max(np.abs(orders[2] - orders[1])) < 0.2 * np.max(np.abs(orders[1] - orders[0])) < 1e-2


def test_in_units_of_one_gear_as_a_system():
    model = published()
    np.testing.assert_array_equal(
        free_vibration(model, [2.5], order=5).omega, free_vibration(gear_system(model), [2.5], order=5).omega
    )
