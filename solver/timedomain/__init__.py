"""Direct integration, periodic orbits and attractors of any system with one contact: pure numerics.

Not imported by `import solver`: the kernels are many.
"""

from solver.timedomain.attractor import AttractorKind
from solver.timedomain.attractor_row import AttractorRow, AttractorSearch, SeenFrom
from solver.timedomain.attractors import continue_attractors, find_attractors, settle
from solver.timedomain.integrator import Status, Trajectory, Zone, integrate
from solver.timedomain.isolated import IsolatedBranch, IsolatedBranches, isolated_branches
from solver.timedomain.orders import order_spectrum
from solver.timedomain.poincare import Measurement, Sections, advance, growth, measure, monodromy
from solver.timedomain.quantities import Quantities, motion_quantities
from solver.timedomain.shooting import PeriodicOrbit, ShootingStatus, orbit_state, shoot
from solver.timedomain.slow_run import SlowRun, slow_run
from solver.timedomain.trajectory import SampledMotion, trajectory

__all__ = [
    "AttractorKind",
    "AttractorRow",
    "AttractorSearch",
    "IsolatedBranch",
    "IsolatedBranches",
    "Measurement",
    "PeriodicOrbit",
    "Quantities",
    "SampledMotion",
    "Sections",
    "SlowRun",
    "SeenFrom",
    "ShootingStatus",
    "Status",
    "Trajectory",
    "Zone",
    "advance",
    "continue_attractors",
    "find_attractors",
    "growth",
    "integrate",
    "isolated_branches",
    "measure",
    "monodromy",
    "motion_quantities",
    "orbit_state",
    "order_spectrum",
    "settle",
    "shoot",
    "slow_run",
    "trajectory",
]
