"""Motions at a place as text: quantities as CSV and Markdown, what is drawn as CSV, lines for the console."""

from collections.abc import Iterator

import numpy as np

from pipeline.analysis.motion.curves import Curves
from pipeline.analysis.motion.motions import MapMotion, Motion, Motions
from pipeline.analysis.motion.wording import card_name, quantity_line, shown_quantity, standing, summary
from pipeline.config.quantities import READ
from pipeline.plan.plan import Plan
from pipeline.plan.scales import scales_of
from pipeline.plane.quantities import scale_of
from pipeline.run.sheets import csv_text, exact_text, pipes
from pipeline.store import axis_attributes
from solver import Scales

__all__ = ["contents", "curve_rows", "lines", "place_name"]

_CURVES = ("motion", "source", "series", "x", "y")
_PHYSICAL = ("physical_x", "physical_x_unit", "physical_y", "physical_y_unit")


def place_name(found: Motions, plan: Plan) -> str:
    """What files of the place are called: "omega=0.64-f_e=0.3"."""
    return f"{plan.sweep.name}={found.x:.10g}-{plan.parameter.name}={found.p:.10g}"


def contents(found: Motions, plan: Plan, name: str) -> dict[str, str]:
    """Name of a file -> its text; the same from the same plan, place and settings.

    Parameters
    ----------
    found : Motions
    plan : Plan
    name : str
        Of the store.
    """
    place = place_name(found, plan)
    return {
        f"{place}.md": _markdown(found, plan, name),
        f"{place}.csv": _quantities(found, plan),
        f"{place}-curves.csv": _curves(found, plan),
    }


def lines(found: Motions, plan: Plan) -> Iterator[str]:
    """Which motions there are and what each is, for the console."""
    scales = scales_of(plan)
    yield f"{_where(found, plan, scales)}: {summary(found)}"
    cards = [*found.attractors, *found.others]
    names = [f"{card_name(card)}  {card.label}" for card in cards]
    width = max(map(len, names), default=0)
    for name, card in zip(names, cards, strict=True):
        yield f"{name.ljust(width)}  {_plain(standing(card, found))}"
        yield f"{' ' * width}  {_plain(quantity_line(card.quantities, scales))}"
    yield from found.notes


def _where(found: Motions, plan: Plan, scales: Scales | None) -> str:
    parts = []
    for name, value in ((plan.sweep.name, found.x), (plan.parameter.name, found.p)):
        known = scales is not None and name in scales
        unit = axis_attributes(name)["units"]
        text = f"{name} = {value:.6g}" + ("" if unit == "1" else f" {unit}")
        parts.append(f"{text} ({value * scales[name].shown:.6g} {scales[name].unit})" if known else text)
    return ", ".join(parts)


def _plain(text: str) -> str:
    """Without wide gaps, which are for figures."""
    return text.replace(";  ", "; ")


def _markdown(found: Motions, plan: Plan, name: str) -> str:
    scales, cards = scales_of(plan), [*found.attractors, *found.others]
    parts = [f"# Motions at {_where(found, plan, scales)} in {name}", f"{summary(found)}."]
    if cards:
        rows = [[card_name(card), card.label, _plain(standing(card, found))] for card in cards]
        parts.append(pipes(["motion", "kind", "what it is"], rows))
        table = [[one.title, *(shown_quantity(one.name, card.quantities, scales) for card in cards)] for one in READ]
        parts += ["## Quantities", pipes(["quantity", *map(card_name, cards)], table, numbers_from=1)]
        of_map = [card for card in found.attractors if card.of_map is not None]
        if of_map:
            heads = [f"{card.name}, map {card.of_map.number}" for card in of_map]
            table = [
                [one.title, *(shown_quantity(one.name, card.of_map.quantities, scales) for card in of_map)]
                for one in READ
            ]
            parts += ["## The same by the harmonic balance of the map", pipes(["quantity", *heads], table, 1)]
    parts.append("\n".join(f"- {note}" for note in found.notes))
    return "\n\n".join(parts) + "\n"


def _sources(found: Motions) -> Iterator[tuple[str, str, Motion | MapMotion]]:
    """Name, source, and motion, of everything that was found."""
    for motion in found.attractors:
        yield motion.name, "integration", motion
        if motion.of_map is not None:
            yield motion.name, "balance", motion.of_map
    for motion in found.others:
        yield card_name(motion), "balance", motion


def _quantities(found: Motions, plan: Plan) -> str:
    scales = scales_of(plan)
    measured = [one for one in READ if scale_of(one, scales) is not None]
    header = [
        *(plan.sweep.name, plan.parameter.name, "motion", "source", "kind", "stable", "hits", "starts", "multiplier"),
        *("lyapunov", "lyapunov_error", "map_motion", "leads_to"),
        *(one.name for one in READ),
        *(f"{one.name} ({scale_of(one, scales).unit})" for one in measured),
    ]

    def line(name: str, source: str, motion: Motion | MapMotion) -> list:
        values = [getattr(motion.quantities, one.name) for one in READ]
        physical = [getattr(motion.quantities, one.name) * scale_of(one, scales).shown for one in measured]
        if isinstance(motion, Motion):
            number = motion.of_map.number if motion.of_map else ""
            own = [1, motion.hits, found.starts, motion.multiplier, motion.lyapunov, motion.lyapunov_error, number, ""]
        else:
            own = [int(motion.stable), "", "", motion.multiplier, "", "", motion.number, motion.leads or ""]
        return [found.x, found.p, name, source, motion.label, *own, *values, *physical]

    return csv_text(header, ([exact_text(value) for value in line(*one)] for one in _sources(found)))


def _curves(found: Motions, plan: Plan) -> str:
    scales = scales_of(plan)
    header = [*_CURVES, *(() if scales is None else _PHYSICAL)]
    return csv_text(header, curve_rows(found, scales))


def curve_rows(found: Motions, scales: Scales | None) -> Iterator[list]:
    """What is drawn, point by point: motion, source, series, x, y, and both in physical units where there are any.

    Series: `displacement`, `speed` and `force` (over the static force, or as it is where that is 0) over the time in
    mesh periods; `poincare`, speed over displacement; `spectrum`, amplitude of the displacement over the order of the
    mesh frequency.
    """
    static = abs(found.static_force) or 1.0
    for name, source, motion in _sources(found):
        for series, x, y, kinds in _series(motion.curves, static):
            columns = [x, y]
            texts = [[exact_text(value) for value in column.tolist()] for column in columns]
            if scales is not None:
                for column, kind in zip(columns, kinds, strict=True):
                    size, unit = _physical(kind, found, scales)
                    texts += [[exact_text(value) for value in (size * column).tolist()], [unit] * column.size]
            for values in zip(*texts, strict=True):
                yield [name, source, series, *values]


def _series(curves: Curves, static: float) -> Iterator[tuple[str, np.ndarray, np.ndarray, tuple[str, str]]]:
    for name in ("displacement", "speed", "force"):
        values = getattr(curves, name)
        yield name, curves.periods, values / static if name == "force" else values, ("time", name)
    yield "poincare", *curves.points.T, ("displacement", "speed")
    yield "spectrum", curves.orders, curves.amplitudes, ("order", "displacement")


def _physical(kind: str, found: Motions, scales: Scales) -> tuple[float, str]:
    """What 1 of a drawn quantity is, and its unit."""
    if kind == "order":
        return 1.0, "1"
    if kind == "time":
        return 1e3 / (scales["mesh_frequency"].size * found.omega), "ms"
    scale = scales[{"displacement": "length", "speed": "velocity", "force": "force"}[kind]]
    return scale.shown * ((abs(found.static_force) or 1.0) if kind == "force" else 1.0), scale.unit
