"""
A first map in a notebook
=========================

*At which speeds can my gear pair jump, and how bad is it there?*

A map answers for a whole plane of two parameters at once. Here it is the reference pair, over mesh frequency and
transmission error.
"""

# %%
# One line computes the plane, with the curves between its domains. Numbers that differ from those in ``conf/`` follow,
# as on the command line; here they make the plane a coarse one. What is stored already is kept, so that the same line
# opens the plane the next time.

import pipeline

plane = pipeline.compute("omega_fe", ["plane.sweep.num=200", "plane.parameter.num=60"])
plane.plot.map()

# %%
# A label n/I is the number n of stable motions with their impact states I: 0, the teeth stay in contact; 1, they part;
# 2, they strike the back flanks, too. Where n is 2 the pair can jump. The lines are computed as curves, which are as
# sharp in a coarse plane as in a fine one.
#
# Any place can be asked, on the grid or not. All motions there are computed anew:

motions = plane.motions_at(omega=0.6, f_e=0.2)
for solution in range(motions.sizes["solution"]):
    motion = motions.isel(solution=solution)
    print(
        f"amplitude {motion.amplitude:.3f}, largest force {motion.dynamic_factor:.2f} times the static one,",
        "stable" if motion.stable == 1 else "unstable",
    )

# %%
# Two stable motions, and an unstable one between them. Where the pair comes from decides which of the two it takes: the
# curve of amplitudes folds over, and between its folds a run up and a run down differ.

plane.plot.curves(f_e=0.2)

# %%
# How much transmission error is too much, if the pair runs through this lower resonance and may not jump?

for found in plane.thresholds("2/0-1", window=(0.4, 0.8)):
    print(f"2/0-1 occurs for f_e = {found.appears:.4f} to {found.disappears:.4f}")

# %%
# Such numbers come from the curves; no cell was counted. The map itself is of first order, and what that leaves out is
# the next thing to ask: :doc:`/how-to/trust`.
