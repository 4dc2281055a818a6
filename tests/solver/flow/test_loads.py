"""The load at one axis value, as kernels make it, against the system that Python makes of the model there."""

import numpy as np
import pytest

from solver import gear_system
from solver.flow.switched_system import loaded_system
from solver.model.contact_system import ContactSystem, reduced
from solver.timedomain.row_systems import row_systems
from tests.conftest import MODELS, published

RICH = dict(
    f_e_harmonics=((0.05, 0.3), (0.02, -1.0)),
    f_pv=0.07,
    alpha_phase=0.7,
    alpha_harmonics=((0.1, 0.4),),
    xi_support=(0.01, 0.02, 0.01, 0.01, 0.03, 0.01),
)
TWO = ContactSystem(
    np.array([[2.0, 0.3], [0.3, 1.0]]),
    0.06 * np.array([[1.0, -1.0], [-1.0, 2.0]]),
    np.array([[1.0, -1.0], [-1.0, 2.0]]),
    [0.0, 1.0],
    [0.0, 3.0],
    1.0,
    load=[[0.1, 0.2], [0.3 - 0.1j, 0.0]],
    inertial_load=[[0.0, 0.0], [0.0, 0.2 + 0.4j]],
)


def _same(row, column, system, omega):
    """What kernels see of a cell is `loaded_system` of the reduced system."""
    (group,) = row.alike
    wanted = loaded_system(reduced(system), omega)
    found = (group.numbers, group.matrices, group.vectors, group.load)
    for array, other in zip(found, (wanted.numbers, wanted.matrices, wanted.vectors, wanted.load), strict=True):
        np.testing.assert_allclose(array[column], other, rtol=0, atol=1e-15)
    count = len(wanted.variation)
    np.testing.assert_allclose(group.variation[column, :count], wanted.variation, rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("changes", [{}, RICH], ids=["plain", "rich"])
def test_gears_along_the_frequency(name, changes):
    model = MODELS[name](**changes)
    row = row_systems(model, "omega", np.array([0.6, 1.3]), None)
    for column, omega in enumerate((0.6, 1.3)):
        _same(row, column, gear_system(model), omega)


@pytest.mark.parametrize(
    "axis, values", [("b", [0.4, 1.1]), ("alpha", [0.1, 0.3]), ("f_e", [0.0, 0.3]), ("f_pm", [0.2, 0.6])]
)
def test_gears_along_other_axes(axis, values):
    model = published(**RICH)
    row = row_systems(model, axis, np.array(values), 0.8)
    for column, value in enumerate(values):
        _same(row, column, gear_system(model.replace(**{axis: value})), 0.8)


def test_a_contact_system_with_a_coupled_mass():
    row = row_systems(TWO, "omega", np.array([0.9, 1.4]), None)
    for column, omega in enumerate((0.9, 1.4)):
        _same(row, column, TWO, omega)
