"""
The article, and where it is wrong
==================================

*Can I get the maps of the study that bevelmap reproduces, and which of its numbers should I not rely on?*

The study varies half backlash, stiffness variation, transmission error and load, each over the mesh frequency.
"""

# %%
# Its four planes, coarse. The gear, ``published``, is the default.

import pipeline

coarse = ["plane.sweep.num=80", "plane.parameter.num=16", "output.root=article"]
planes = {name: pipeline.compute(name, coarse) for name in ("omega_b", "omega_alpha", "omega_fe", "omega_fpm")}
planes["omega_b"].plot.map()

# %%
planes["omega_fpm"].plot.map()

# %%
# Every number that the study prints is kept as data, with the rule by which ours agrees with it or not. What differs:

from pipeline.study.statements import evaluate_all

article = {
    found.statement.key: found
    for found in evaluate_all({name: plane.path for name, plane in planes.items()})
    if found.statement.source == "article"
}
print(f"{sum(found.verdict == 'agrees' for found in article.values())} of {len(article)} agree\n")
for found in article.values():
    if found.verdict == "differs":
        ours, theirs = (", ".join(f"{value:.4g}" for value in side) for side in (found.ours, found.article))
        print(f"{found.statement.text}\n    ours {ours}; the study {theirs}")

# %%
# Its first table is words, of which each cell is tested as far as it can be:

from pathlib import Path

import pandas as pd

from pipeline.study import tables

tables.write({name: (planes[name].path, "") for name in ("omega_b", "omega_alpha", "omega_fpm")}, Path("tables"))
cells = pd.read_csv("tables/table1.csv")
print(cells[["b", "column", "article", "verdict"]].to_string(index=False))

# %%
# Not every difference is ours to mend. As long as no tooth parts the pair is linear, whatever its geometry: load and
# transmission error then act in proportion, and the ratio of the two at which teeth begin to part is one number. The
# study gives the onset at the upper resonance twice, once over transmission error at a load of 0.5, once over load at a
# transmission error of 0.2:

studied = {"over f_e": 0.12 / 0.5, "over f_pm": 0.2 / 0.75}
(by_error,) = planes["omega_fe"].thresholds("1/1", window=(0.95, 2.0))
by_load = max(found.disappears for found in planes["omega_fpm"].thresholds("1/1", window=(0.95, 2.0)))
ours = {"over f_e": by_error.appears / 0.5, "over f_pm": 0.2 / by_load}
for plane in studied:
    print(f"f_e / f_pm at the onset, {plane}: the study {studied[plane]:.3f}, ours {ours[plane]:.3f}")

# %%
# So at least one of these two published numbers cannot be right, in this model or in any other. The rest of the list,
# with reasons, is in :doc:`/physics`, section 7; ``python -m pipeline stages=[report] report.run=true`` writes all of
# it as one page.
