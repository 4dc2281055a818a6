"""Stored quantities against direct integration of the motions that the map counts."""

import numpy as np
import pytest

import pipeline
from pipeline.config.quantities import QUANTITIES, READ
from pipeline.plan.numerics import model_at
from pipeline.plan.scales import scales_of
from pipeline.plane.quantities import scale_of
from pipeline.plane.stored import read_stored
from solver import gear_system
from solver.timedomain import motion_quantities, orbit_state, shoot
from tests.pipeline.planes import small_plan, small_store

HB15 = ("plane=omega_fe", "solver=hb", "solver.order=15", "solver.certify_columns=5")
#: A spur pair without supports in the contact, where harmonic 2 is four times harmonic 1 (docs/physics.md, section 9).
SPUR = (
    "gear.translation_coupling=0.0",
    "gear.rotation_coupling=1.0",
    "gear.variation.rotation=1.0",
    "gear.f_pm=0.1",
    "gear.alpha_phase=3.141592653589793",
    "gear.alpha_harmonics=[[0.1,3.141592653589793],[0.05,3.141592653589793]]",
    "gear.f_e_harmonics=[[0.004,0.0],[0.002,0.0]]",
    "plane.sweep.min=0.45",
    "plane.sweep.max=0.55",
    "plane.parameter.min=0.0",
    "plane.parameter.max=0.02",
)


def integrated(plane, row, column, slot):
    """Quantities of the true orbit next to a stored motion, (13,)."""
    model = model_at(plane.plan, plane.rows[row], plane.plan.sweep.low)
    omega = float(plane.plan.sweep.values[column])
    orbit = shoot(gear_system(model), omega, orbit_state(gear_system(model), omega, plane.motions[row, column, slot]))
    found, _ = motion_quantities(model, omega, orbit.state)
    return np.array([getattr(found, one.name) for one in READ])


def stored(plane, row, column, slot):
    return np.array([plane.array(one.name)[row, column, slot] for one in READ])


@pytest.fixture(scope="module")
def fifteen(tmp_path_factory):
    planned = small_plan(*HB15, "plane.sweep.min=0.4", columns=9, rows=5)
    return read_stored(small_store(tmp_path_factory.mktemp("quantities") / "fifteen.zarr", planned))


def test_order_15_is_integration_to_1e_6_where_teeth_stay_in_contact(fifteen):
    stable = (fifteen.stable == 1) & (fifteen.instability == 0)
    touching = np.argwhere(stable & (fifteen.array("contact_loss") == 0.0))
    apart = np.argwhere(stable & (fifteen.array("contact_loss") > 0.02))
    assert len(touching) > 20 and len(apart) > 4
    for place in touching[:: max(len(touching) // 8, 1)]:
        np.testing.assert_allclose(stored(fifteen, *place), integrated(fifteen, *place), rtol=0, atol=1e-6)
    for place in apart[:: max(len(apart) // 4, 1)]:
        # The force has kinks: its harmonics beyond the fifteenth are left out.
        np.testing.assert_allclose(stored(fifteen, *place), integrated(fifteen, *place), rtol=0, atol=3e-3)


def test_first_order_is_integration_to_its_own_accuracy(tmp_path):
    plane = read_stored(small_store(tmp_path / "first.zarr", small_plan("plane=omega_fe", columns=9, rows=5)))
    away = np.argwhere((plane.stable == 1) & (plane.instability == 0) & (plane.impact == 0))
    errors = [np.abs(stored(plane, *place) - integrated(plane, *place)) for place in away[::4]]
    # Without contact loss only the second harmonic of the parametric excitation is missing.
    assert len(errors) > 5 and np.median(np.max(errors, axis=1)) < 0.03 and np.max(errors) < 0.5
    zero = [READ.index(one) for one in READ if one.name in ("contact_loss", "impact_velocity")]
    assert np.max(np.array(errors)[:, zero]) == 0.0


def test_peak_to_peak_sees_the_harmonics_that_the_amplitude_does_not(tmp_path):
    planned = small_plan(*SPUR, "solver=hb", "solver.order=15", "solver.certify_columns=5", columns=3, rows=3)
    plane = pipeline.open_plane(small_store(tmp_path / "spur.zarr", planned))
    motion = plane.motions_at(omega=0.5, f_e=0.01)
    first = int(np.argmin(np.abs(motion["mean"].values - 1.09286)))
    here = motion.isel(solution=first)
    assert float(here.amplitude) == pytest.approx(0.03002, abs=2e-5)
    assert (float(here.lowest), float(here.highest)) == pytest.approx((0.95104, 1.24239), abs=2e-5)
    # Of harmonic 1 alone it would be 0.06: harmonic 2 is 0.12401.
    assert float(here.peak_to_peak) == pytest.approx(0.29134, abs=4e-5)
    assert float(here.rms) == pytest.approx(np.hypot(0.03002, np.hypot(0.12401, 0.00442)) / np.sqrt(2.0), abs=1e-4)
    assert float(here.contact_loss) > 0.15 and float(here.support_force) == 0.0


def test_what_1_is_of_every_quantity_in_physical_units():
    scales = scales_of(small_plan("plane=omega_fe", "gear=miter", columns=4, rows=2))
    length, frequency = scales.gear.length_unit, scales.gear.frequency_unit
    sizes = {
        "length": (1e6 * length, "µm"),
        "velocity": (length * frequency, "m/s"),
        "force": (scales.gear.mesh_stiffness * length, "N"),
    }
    kinds = {"rms": "length", "impact_velocity": "velocity", "support_force": "force", "dynamic_factor": None}
    assert {name: QUANTITIES[name].scale for name in kinds} == kinds
    for one in QUANTITIES.values():
        found = scale_of(one, scales)
        if one.scale is None:
            assert found is None
        else:
            size, unit = sizes[one.scale]
            assert (found.shown, found.unit) == (pytest.approx(size, rel=1e-14), unit)
