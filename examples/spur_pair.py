"""
A spur pair and its motions over two periods
============================================

*I have the equation of a spur pair from a paper. Where do motions occur that repeat only after two mesh periods, and do
they matter?*

The pair is that of Kahraman and Singh (1991): one degree of freedom, backlash, mesh stiffness and transmission error
with three harmonics each (:doc:`/physics`, section 9).
"""

# %%
# Any linear system with one contact is a ``ContactSystem``. Here the contact coordinate is the only one, and the mesh
# the only spring. With phases of π the stiffness starts from its least value.

import matplotlib.pyplot as plt
import numpy as np

import solver

error = (0.01, 0.004, 0.002)
spur = solver.ContactSystem(
    mass=[[1.0]],
    damping=[[0.1]],
    stiffness=[[0.0]],
    contact=[1.0],
    force=[1.0],
    varying_force=[1.0],
    front_gap=1.0,
    back_gap=1.0,
    stiffness_harmonics=[(0.2, np.pi), (0.1, np.pi), (0.05, np.pi)],
    load=[[0.1]],
    inertial_load=[[0.0], *([size] for size in error)],
)

# %%
# Motions of one period, with 12 harmonics, and where their branches fold:

omega = np.linspace(0.3, 2.2, 191)
row = solver.sweep_row(spur, "omega", omega, balance=solver.Galerkin(order=12), seeds=solver.LiftedSeeds(20))
for curve in row.curves:
    print("folds at", *(curve.points[curve.event == solver.Event.FOLD, -1].round(4)))

# %%
# A balance of one period cannot tell of motions that take two. Integration does: from random states at every frequency,
# until each has settled on something.

from solver.timedomain import AttractorKind, AttractorSearch, find_attractors, trajectory

found = find_attractors(spur, "omega", omega, search=AttractorSearch(starts=10))
kinds = {AttractorKind.PERIOD_1: ("C0", "one period"), AttractorKind.PERIOD_2: ("C3", "two periods")}
figure, axes = plt.subplots(figsize=(8, 4.2), layout="constrained")
for kind, (colour, label) in kinds.items():
    column, slot = np.nonzero(found.kind == kind)
    for extreme, name in ((found.lowest, label), (found.highest, None)):
        axes.plot(omega[column], extreme[column, slot], ".", color=colour, markersize=4, label=name)
axes.axhline(1.0, color="0.6", linewidth=0.8)
axes.set(xlabel="mesh frequency", ylabel="least and largest mesh displacement", title="below the line the teeth part")
axes.legend()
print(sorted({AttractorKind(int(kind)).label for kind in found.kind[found.kind > 0]}))

# %%
# They occur near twice the natural frequency, where the varying stiffness pumps: a parametric resonance. There, the
# motion of one period stays in contact; that of two loses it. How many starts does each take at 1.8?

one = find_attractors(spur, "omega", [1.8], search=AttractorSearch(starts=400))
figure, axes = plt.subplots(figsize=(8, 3.4), layout="constrained")
for slot in np.flatnonzero(one.kind[0]):
    kind = AttractorKind(int(one.kind[0, slot]))
    share = one.hits[0, slot] / one.starts[0]
    print(f"{kind.label}: {share:.0%} of the starts, contact lost for {one.contact_loss[0, slot]:.0%} of the time")
    motion = trajectory(spur, 1.8, one.state[0, slot], periods=4, samples=200)
    axes.plot(motion.periods, motion.force / motion.static_force, color=kinds[kind][0], label=kinds[kind][1])
axes.set(xlabel="mesh periods", ylabel="mesh force / static force")
axes.legend()

# %%
# So they do matter: about every second start ends there, with a force that the motion of one period does not have. How
# little must the stiffness vary for them to be gone? The same pair is ``gear=spur``, for planes. Over the variation of
# the stiffness, counting what is stable to any small disturbance:

import pipeline

axes = ["plane.parameter.name=alpha", "plane.parameter.min=0.05", "plane.parameter.max=0.4", "plane.sweep.max=2.3"]
coarse = ["plane.sweep.num=120", "plane.parameter.num=30"]
plane = pipeline.compute("omega_load", ["gear=spur", *axes, *coarse, "store.name=spur"])
plane.plot.map(stability="dynamic")

# %%
# In the tongue at the right no motion of one period is stable. Its tip, at Ω = 2, is where damping balances what the
# stiffness pumps in: α = 4 ζ = 0.2, as Mathieu's equation has it. Beside the tongue motions of two periods coexist with
# one that is stable, which only integration tells: ``stages=[attractors]`` asks it in every cell
# (:doc:`/concepts/attractors`). Dotted, left, first order is not enough; the folds above are of order 12.
