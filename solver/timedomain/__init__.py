"""Direct integration, periodic orbits and attractors of any system with one contact: pure numerics.

Not imported by `import solver`: the kernels are many.
"""

from solver.contact.quantities import Quantities
from solver.timedomain.attractor import Attractor, AttractorKind, contact_impact
from solver.timedomain.basins import BasinShare, basin_box, basin_shares, same_attractor, wilson_interval
from solver.timedomain.integrator import Status, Trajectory, Zone, integrate
from solver.timedomain.poincare import Measurement, Sections, advance, growth, measure, monodromy
from solver.timedomain.quantities import motion_quantities
from solver.timedomain.settling import Settling, settle
from solver.timedomain.shooting import PeriodicOrbit, ShootingStatus, orbit_state, shoot
from solver.timedomain.sweeping import AttractorSweep, resting_state, sweep_attractors

__all__ = [
    "Attractor",
    "AttractorKind",
    "AttractorSweep",
    "BasinShare",
    "Measurement",
    "PeriodicOrbit",
    "Quantities",
    "Sections",
    "Settling",
    "ShootingStatus",
    "Status",
    "Trajectory",
    "Zone",
    "advance",
    "basin_box",
    "basin_shares",
    "contact_impact",
    "growth",
    "integrate",
    "measure",
    "monodromy",
    "motion_quantities",
    "orbit_state",
    "resting_state",
    "same_attractor",
    "settle",
    "shoot",
    "sweep_attractors",
    "wilson_interval",
]
