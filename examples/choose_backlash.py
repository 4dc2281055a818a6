"""
Choosing backlash
=================

*How much backlash should I order, when I know my gears only up to their transmission error?*

Too little, and the teeth strike both flanks; more, and the pair jumps over a wider range of speeds. A volume has both,
for every transmission error that the workshop may deliver.
"""

# %%
# Mesh frequency × half backlash, in layers of transmission error, of a miter pair in physical units:

import subprocess
import sys

sizes = ["plane.sweep.num=100", "plane.parameter.num=20"]
layers = ["plane.parameter2.min=0.1", "plane.parameter2.max=0.4", "plane.parameter2.num=7"]
words = ["plane=omega_b_fe", "gear=miter", "stages=[sweep]", "store.name=backlash", *sizes, *layers]
subprocess.run([sys.executable, "-m", "pipeline", *words], check=True)

# %%
# The store is an array with three dimensions. The pair passes its main resonance on the way to its speed. So what
# counts is the worst that happens anywhere between 12,000 and 18,000 rpm.

from pathlib import Path

import numpy as np
import xarray as xr

import pipeline
from pipeline.store import read_plan

store = Path("outputs/store/backlash.zarr")
scales = pipeline.scales_of(read_plan(store))
low, high = (rpm / scales["omega"].shown for rpm in (12000, 18000))
passed = xr.open_zarr(store).sel(omega=slice(low, high)).load()

stable = passed.stable == 1
back = (stable & (passed.impact == 2)).any(("omega", "solution"))
jump = (passed.n_stable > 1).any("omega")
jumping = 100 * (passed.n_stable > 1).mean("omega")
force = passed.dynamic_factor.where(stable).max(("omega", "solution"))

# %%
# As a picture, in units of the drawing: where the back flanks are struck, and at which share of these speeds two
# motions coexist.

import matplotlib.pyplot as plt

backlash = [scales.physical("b", b) * 1e6 for b in passed.b.values]
error = [scales.physical("f_e", f_e) * 1e6 for f_e in passed.f_e.values]
figure, axes = plt.subplots(figsize=(7.5, 4.2), layout="constrained")
shares = axes.pcolormesh(backlash, error, jumping, cmap="YlGnBu", shading="nearest")
axes.contourf(backlash, error, back, levels=[0.5, 1.5], colors="none", hatches=["///"])
axes.set(xlabel="half backlash (µm)", ylabel="transmission error (µm)", title="hatched: back flanks struck")
figure.colorbar(shares, label="speeds with several motions (%)")

# %%
# Right of the hatching more backlash changes nothing: a motion that never reaches the back flank does not know how far
# away it is. So there is a smallest backlash that does, for each transmission error:

for layer in range(passed.sizes["f_e"]):
    struck = back.isel(f_e=layer)
    enough = next((size for size, one in zip(backlash, struck.values, strict=True) if not one), np.nan)
    worst = float(force.isel(f_e=layer).sel(b=~struck).max()) if not struck.all() else np.nan
    print(f"{error[layer]:4.1f} um: from {enough:4.1f} um on, then at most {worst:.2f} times the static force")
