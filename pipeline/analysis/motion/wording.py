"""What motions are called, said once for the console, the sheets and the figure."""

import math

from pipeline.analysis.motion.motions import MapMotion, Motion, Motions
from pipeline.config.quantities import QUANTITIES, Quantity
from pipeline.errors import counted
from pipeline.plane.quantities import scale_of
from pipeline.run.sheets import number_text
from solver import Scales
from solver.contact.quantities import Quantities
from solver.stability import Instability
from solver.timedomain import AttractorKind

__all__ = ["card_name", "quantity_line", "quantity_text", "shown_quantity", "standing", "summary"]

_GROWTH = {
    Instability.PERIOD_DOUBLING: "unstable by period doubling",
    Instability.NEIMARK_SACKER: "unstable by Neimark–Sacker",
    Instability.UNDECIDED: "stability undecided",
}


def card_name(card: Motion | MapMotion) -> str:
    """A letter of an attractor, "map 2" of a motion that is none."""
    return card.name if isinstance(card, Motion) else f"map {card.number}"


def summary(found: Motions) -> str:
    """How many motions there are, and where random starts ended that led to none."""
    text = f"{counted(len(found.attractors), 'attractor')} from {counted(found.starts, 'random start')}"
    if found.others:
        text += f", {counted(len(found.others), 'motion')} of the map that no attractor confirms"
    if found.unbounded:
        text += f", {counted(found.unbounded, 'start')} unbounded"
    if found.unsettled:
        text += f", {counted(found.unsettled, 'start')} not settled"
    return text


def standing(card: Motion | MapMotion, found: Motions) -> str:
    """How a motion stands among the others: whether it lasts, who leads to it, whether the map has it."""
    return _of_attractor(card, found) if isinstance(card, Motion) else _of_map_motion(card)


def _of_attractor(motion: Motion, found: Motions) -> str:
    parts = [_lasting(motion)]
    if found.starts:
        parts.append(f"{motion.hits} of {found.starts} random starts")
    one = motion.of_map
    if one is None:
        parts.append("not in the map")
    else:
        state = "" if one.label == motion.label else f" (there {one.label})"
        parts.append(f"motion {one.number} of the map{state}")
    return ";  ".join(parts)


def _lasting(motion: Motion) -> str:
    if motion.kind.periodic:
        return f"stable, |μ| = {number_text(motion.multiplier, 4)}"
    if motion.kind is AttractorKind.PERIOD_LONGER:
        return "repeats after more than eight periods"
    if motion.kind is AttractorKind.QUASI_PERIODIC:
        return "never repeats, neighbouring motions stay near"
    exponent = f"{number_text(motion.lyapunov, 2)} ± {number_text(motion.lyapunov_error, 1)}"
    return f"never repeats, Lyapunov exponent {exponent}"


def _of_map_motion(motion: MapMotion) -> str:
    size = "" if math.isnan(motion.multiplier) else f", |μ| = {number_text(motion.multiplier, 4)}"
    kind = motion.instability
    if kind is Instability.CONTRADICTORY:
        parts = [
            f"statically {'stable' if motion.stable else 'unstable'}, yet{size[1:]}: the map's order is too low here"
        ]
    elif not motion.stable:
        parts = [f"unstable{size}"]
    else:
        growth = _GROWTH.get(kind)
        parts = [f"statically stable, {growth}{size}" if growth else f"stable in the map{size}"]
    if motion.leads is not None:
        parts.append(f"integration from it ends on {motion.leads}")
    else:
        parts.append("no attractor")
    return ";  ".join(parts)


def shown_quantity(name: str, quantities: Quantities, scales: Scales | None) -> str:
    """A quantity with its unit, to three digits; a share in percent."""
    return quantity_text(QUANTITIES[name], getattr(quantities, name), scales)


def quantity_text(quantity: Quantity, value: float, scales: Scales | None) -> str:
    """A value of a quantity with its unit, to three digits; a share in percent."""
    if math.isnan(value):
        return "–"
    if quantity.name == "contact_loss":
        return f"{number_text(100.0 * value)} %"
    scale = scale_of(quantity, scales)
    return number_text(value) if scale is None else f"{number_text(value * scale.shown)} {scale.unit}"


def quantity_line(quantities: Quantities, scales: Scales | None) -> str:
    """The quantities that are asked for first, in one line."""

    def shown(name: str) -> str:
        return shown_quantity(name, quantities, scales)

    return ";  ".join(
        (
            f"λ from {shown('lowest')} to {shown('highest')}, RMS {shown('rms')}",
            # There is none of a system that is no bevel pair.
            *([] if math.isnan(quantities.error_rms) else [f"transmission error RMS {shown('error_rms')}"]),
            f"K_v {shown('dynamic_factor')}",
            f"contact loss {shown('contact_loss')}",
            f"impact velocity {shown('impact_velocity')}",
        )
    )
