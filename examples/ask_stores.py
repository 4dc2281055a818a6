"""
Asking stores with xarray
=========================

*I have stores from several runs. How do I ask all of them at once, with tools that I know already?*

A store is a Zarr group that xarray opens by itself. bevelmap is needed here only to make three of them, of pairs whose
mesh stiffness varies little, more and much.
"""

# %%
import pipeline

alphas = [0.1, 0.3, 0.4]
for alpha in alphas:
    sizes = ["plane.sweep.num=160", "plane.parameter.num=40"]
    pipeline.compute("omega_fe", [f"gear.alpha={alpha}", "stages=[sweep]", *sizes])

# %%
# Stores are named after what differs from the defaults. One dataset of them all, with that as a new dimension:

import xarray as xr

stores = [xr.open_zarr(f"outputs/store/omega_fe-alpha={alpha}.zarr").drop_vars("message") for alpha in alphas]
planes = xr.concat(stores, xr.Variable("alpha", alphas)).load()
print(dict(planes.sizes))

# %%
# In which share of the plane can the pair jump, and from which transmission error on?

jumps = planes.n_stable > 1
share = 100 * jumps.mean(("omega", "f_e"))
first = planes.f_e.where(jumps.any("omega")).min("f_e")
for alpha in alphas:
    print(f"alpha = {alpha}: {share.sel(alpha=alpha):.1f} %, from f_e = {first.sel(alpha=alpha):.3f} on")

# %%
# With enough of it the pair jumps without any transmission error. How large is the mesh force of stable motions, at
# worst, along the speed? Slots of ``solution`` that are empty have ``stable`` -1.

import matplotlib.pyplot as plt

worst = planes.dynamic_factor.where(planes.stable == 1).max("solution").sel(f_e=0.2, method="nearest")
figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
worst.plot.line(x="omega", ax=axes)
axes.set(xlabel="mesh frequency", ylabel="largest mesh force / static force", title=f"f_e = {float(worst.f_e):.3f}")

# %%
# Labels are codes with their meaning beside them. Which cells of the plane change their label as the stiffness varies
# more, and what are they then?

labels = dict(zip(planes.domain.flag_values, planes.domain.labels, strict=True))
less, more = planes.domain.sel(alpha=0.1), planes.domain.sel(alpha=0.4)
changed = more.where(less != more).to_series().dropna().astype(int).map(labels)
print(f"{len(changed)} of {less.size} cells change; most of them become")
print(changed.value_counts().head(4).to_string())

# %%
# What a store was made with stands in it, too:

print(stores[0].attrs["title"], "by bevelmap", stores[0].attrs["versions"]["bevelmap"])
