"""How far first order can be trusted, from the stores: dynamic stability everywhere, integration in one plane."""

from collections.abc import Mapping

from pipeline.analysis.attractors.queries import attractors_of
from pipeline.analysis.attractors.sheets import MEANINGS, label_lines, map_labels
from pipeline.analysis.attractors.wording import percents
from pipeline.config.places import Place
from pipeline.errors import StoreError
from pipeline.plane.stability import region_stability, together
from pipeline.plane.stored import read_stored
from pipeline.study.numerals import percent
from pipeline.study.report.document import Grid

__all__ = ["dynamic_grid", "integration", "verified_grid"]


def dynamic_grid(paths: Mapping[str, Place]) -> Grid:
    """Of every plane, how much of its area has motions that the label counts and that are not dynamically stable."""
    rows = []
    for name, path in paths.items():
        try:
            all_of_it = together(region_stability(path).values())
            shares = (all_of_it.one_unstable, all_of_it.none_stable, all_of_it.contradictory)
            rows.append((name, *map(percent, shares)))
        except StoreError:
            rows.append((name, *["its boundaries do not divide it"] * 3))
    headings = ("Plane", "One is unstable", "None is stable", "One is contradictory")
    return Grid(
        "Motions that the label counts, by dynamic stability: shares of the plane's area, from the boundary curves.",
        headings,
        tuple(rows),
    )


def integration(path: Place, name: str) -> str:
    """Where and from what a plane was integrated, counted."""
    found, plan = attractors_of(path), read_stored(path).plan
    cells, starts = int((found.label.values != 0).sum()), int(found.starts.values.max())
    return (
        f"In {cells:,} of the {plan.parameter.num * plan.sweep.num:,} cells of the plane {name} the equations of "
        f"motion were integrated: from every stable solution, from rest, from {starts} random "
        f"state{'s' * (starts != 1)}, and "
        "from the attractors of the neighbouring cells."
    )


def verified_grid(path: Place) -> Grid:
    """Per label of a plane with attractors, in how many cells the map is right; the last line for all of it."""
    found, plane = attractors_of(path), read_stored(path)
    lines = label_lines(map_labels(path, plane.plan, found), found.credibility.values)
    rows = [(line.label, str(line.cells), *percents(list(line.counts.values()))) for line in lines]
    headings = ("Label n/I", "Cells", *(kind.words.capitalize() for kind in MEANINGS))
    text = f"Labels of the plane, shares of cells; the last line is for all of it. {found.attrs['bound']}"
    return Grid(text, headings, tuple(rows))
