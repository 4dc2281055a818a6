"""What a page says of its plane in words: what it is, what it tells, and where it is not the truth."""

from collections.abc import Iterator

import numpy as np

from pipeline.analysis.attractors.dataset import read_attractors
from pipeline.analysis.attractors.sheets import result_lines
from pipeline.explorer.plain_text import plain
from pipeline.figures.heading import balance_text
from pipeline.figures.naming import fixed_parameters, gear_text, symbol
from pipeline.plan.scales import scales_of
from pipeline.plan.unfelt import unfelt_harmonics
from pipeline.plane.division import stored_division
from pipeline.plane.result import result_line, share_percent
from pipeline.plane.stability import region_stability, together
from pipeline.plane.stored import StoredPlane
from pipeline.run.sheets import sentence
from pipeline.store import FAILED

__all__ = ["answer_of", "doubts_of", "heading_of"]


def heading_of(plane: StoredPlane, physical: bool) -> tuple[str, ...]:
    """The plane, its balance and grid; what is fixed; the gear."""
    plan = plane.plan
    sizes = " × ".join(f"{axis.num} {plain(symbol(axis.name))}" for axis in plan.axes)
    fixed = plain(fixed_parameters(plan, scales_of(plan) if physical else None))
    return f"{balance_text(plan)}, {sizes}", fixed, plain(gear_text(plan))


def answer_of(plane: StoredPlane) -> str:
    """What the map tells, in one sentence."""
    return sentence(result_line(plane) or "nothing of the plane has been computed")


def doubts_of(plane: StoredPlane) -> tuple[str, ...]:
    """Where the map is not the truth, or may not be, in sentences."""
    return tuple(sentence(text) for text in _doubts(plane))


def _doubts(plane: StoredPlane) -> Iterator[str]:
    failed, complete = int(np.sum(plane.status == FAILED)), int(np.sum(plane.complete))
    if missing := plane.rows.size - complete - failed:
        yield f"{missing} of {plane.rows.size} rows are not computed"
    if failed:
        yield f"{failed} of {plane.rows.size} rows failed"
    if open_ := int(np.sum(plane.open == 1)):
        yield f"in {open_} cells motions above the ceiling of the amplitude are not excluded"
    if (unfelt := unfelt_harmonics(plane.plan)) is not None:
        yield f"the balance does not feel: {unfelt.words}"
    if stored_division(plane) is not None:
        found = together(region_stability(plane).values())
        if found.one_unstable:
            share = share_percent(found.one_unstable)
            yield f"in {share} of the plane not all motions that the label counts are dynamically stable"
        if found.contradictory:
            yield (
                f"in {share_percent(found.contradictory)} of the plane static and dynamic stability contradict each "
                "other: the order of the balance is too low there"
            )
    else:
        yield "regions are drawn as cells: the plane has no boundary curves that divide it"
    attractors = read_attractors(plane.path)
    if attractors is None:
        yield "nothing was integrated, so that nobody has checked what motions really end on (stages=[attractors] does)"
    else:
        yield from result_lines(plane.path, plane.plan, attractors)
