"""
A finite-element model of one's own
===================================

*I have mass and stiffness matrices from a finite-element program, and a stop. Does it jump, and how many modes are
enough?*
"""

# %%
# Programs export matrices in the Matrix Market format. Here a cantilever of eight beam elements stands in for them;
# with files of your own, leave this cell out.

import numpy as np
from scipy.io import mmread, mmwrite

elements, h = 8, 1 / 8
bending = np.array([[12, 6 * h, -12, 6 * h], [0, 4 * h**2, -6 * h, 2 * h**2], [0, 0, 12, -6 * h], [0, 0, 0, 4 * h**2]])
inertia = np.array(
    [[156, 22 * h, 54, -13 * h], [0, 4 * h**2, 13 * h, -3 * h**2], [0, 0, 156, -22 * h], [0, 0, 0, 4 * h**2]]
)
stiffness, mass = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
for first in range(0, 2 * elements, 2):
    nodes = slice(first, first + 4)
    stiffness[nodes, nodes] += (bending + np.triu(bending, 1).T) / h**3
    mass[nodes, nodes] += (inertia + np.triu(inertia, 1).T) * h / 420
mmwrite("stiffness.mtx", stiffness[2:, 2:], symmetry="symmetric")
mmwrite("mass.mtx", mass[2:, 2:], symmetry="symmetric")

# %%
# Read, and turn to modes, which is where one knows the damping: 2 % of critical in each.

import scipy.linalg

import solver

K, M = mmread("stiffness.mtx"), mmread("mass.mtx")
squares, shapes = scipy.linalg.eigh(K, M)
frequencies = np.sqrt(squares)
print("natural frequencies", frequencies[:4].round(3))

# %%
# The tip meets a stop 0.05 away, which is 60 times as stiff as the beam's tip. A force at the tip drives it. What the
# contact feels and where it pushes is one vector: the tip's deflection in every mode.

TIP = -2


def beam(modes: int) -> solver.ContactSystem:
    """The beam with the stop, in its first modes."""
    tip = shapes[TIP, :modes]
    return solver.ContactSystem(
        mass=np.eye(modes),
        damping=np.diag(2 * 0.02 * frequencies[:modes]),
        stiffness=np.diag(squares[:modes]),
        contact=tip,
        force=200.0 * tip,
        front_gap=0.05,
        load=[0.0 * tip, 0.2 * tip],
    )


# %%
# Rows over the frequency of the force, every motion of first order in them enumerated with proof. Where it folds is
# where it jumps, and tells how many modes are enough:

omega = np.linspace(2.0, 8.0, 301)
rows = {modes: solver.sweep_row(beam(modes), "omega", omega) for modes in (1, 2, 3, 4, 6)}
for modes, row in rows.items():
    folds = [point for curve in row.curves for point in curve.points[curve.event == solver.Event.FOLD, -1]]
    print(f"{modes} modes: folds at {', '.join(f'{fold:.4f}' for fold in folds)}; {row.certified.sum()} values proven")

# %%
# One mode is off by 2 %: it lacks the beam's own flexibility at the tip, which is in series with the stop. With three
# modes the folds stand to 0.1 %. Is the first order enough for a motion that strikes a stop? The extremes of the tip
# that integration finds, from random states:

import matplotlib.pyplot as plt

from solver.timedomain import AttractorKind, AttractorSearch, find_attractors

row, sparse = rows[3], omega[::6]
found = find_attractors(beam(3), "omega", sparse, search=AttractorSearch(starts=8))
figure, axes = plt.subplots(figsize=(8, 4.2), layout="constrained")
for curve in row.curves:
    mean, cosine, sine, at = curve.points.T
    axes.plot(at, mean + np.hypot(cosine, sine), color="0.4", label="first order")
for kind in np.unique(found.kind[found.kind > 0]):
    column, slot = np.nonzero(found.kind == kind)
    axes.plot(sparse[column], found.highest[column, slot], ".", label=f"integrated, {AttractorKind(int(kind)).label}")
axes.axhline(0.05, color="C3", linewidth=0.8)
axes.set(xlabel="frequency of the force", ylabel="largest deflection of the tip", title="red: the stop")
axes.legend()

# %%
# Away from the resonance it is. Near the fold the motion that strikes the stop is smaller than first order says, and
# others occur beside it that no balance of one period has: over several periods, or chaotic. A higher order is one more
# word, ``balance=solver.Galerkin(order=9)``; the motions beside it remain a matter of integration.
#
# How near must the stop be, so that the beam no longer jumps? From an NPZ file, the matrices are ``gear=system`` for
# planes. Their boundary curves are left out here, since a beam has many: lines are those of cells.

import pipeline

three = beam(3)
np.savez(
    "beam.npz",
    mass=three.mass,
    damping=three.damping,
    stiffness=three.stiffness,
    contact=three.contact,
    force=three.force,
    load=three.load,
)
system = ["gear=system", "gear.system.file=beam.npz", "gear.system.front_gap=0.05", "gear.system.back_gap=inf"]
axes = ["plane.sweep.min=2", "plane.sweep.max=8", "plane.parameter.min=0.01", "plane.parameter.max=0.3"]
coarse = ["plane.sweep.num=100", "plane.parameter.num=30"]
plane = pipeline.compute("omega_gap", [*system, *axes, *coarse, "stages=[sweep]", "store.name=beam"])
plane.plot.map()

# %%
# Nearer than about 0.04. Where the map is hatched or dotted, integration has the last word.
