"""Axes of the cards of motions: what is shown in which unit, and the limits that cards have in common."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.analysis.motion.curves import Curves
from pipeline.analysis.motion.motions import MapMotion, Motion, Motions
from pipeline.plane.stored import StoredPlane
from pipeline.run.sheets import number_text

__all__ = ["Units", "common_cards", "limits_of", "units_of"]

#: Decades of a spectrum. A motion of the map that spans so many times as much as any attractor would hide them.
_DECADES, _FAR = 4.0, 4.0
#: Share of lambda below which what varies is nothing.
_NOTHING = 1e-5


@dataclass(frozen=True)
class Units:
    """What 1 of each quantity is shown as, and the names of the axes."""

    length: float
    speed: float
    time: float
    force: float
    displacement_label: str
    speed_label: str
    time_label: str
    force_label: str
    spectrum_label: str


def units_of(plane: StoredPlane, found: Motions) -> Units:
    """Dimensionless, or physical where the plane is shown so: the force then in N, or in kN."""
    scales, static = plane.scales, abs(found.static_force)
    if scales is None:
        return Units(
            1.0,
            1.0,
            1.0,
            1.0 / static if static else 1.0,
            "$λ$",
            r"$\lambda'$",
            "time (mesh periods)",
            "$F/F_s$" if static else "$F$",
            "amplitude of $λ$",
        )
    period, length, force = 1e3 / (scales["mesh_frequency"].size * found.omega), scales["length"], scales["force"]
    thousands = static * force.shown >= 1000.0
    return Units(
        length.shown,
        scales["velocity"].shown,
        period,
        force.shown / (1000.0 if thousands else 1.0),
        f"$λ$ ({length.unit})",
        f"$\\lambda'$ ({scales['velocity'].unit})",
        f"time (ms); mesh period {number_text(period)} ms",
        f"$F$ ({'k' if thousands else ''}{force.unit})",
        f"amplitude of $λ$ ({length.unit})",
    )


def common_cards(found: Motions) -> list[Motion | MapMotion]:
    """The cards that have their axes in common: all but motions of the map that are far larger than any attractor."""
    spans = [motion.quantities.peak_to_peak for motion in found.attractors]
    # What the gap allows is not far.
    low, high = found.gap
    largest = max([high - low if np.isfinite(low) else 0.0, *spans])
    near = [motion for motion in found.others if not spans or motion.quantities.peak_to_peak <= _FAR * largest]
    return [*found.attractors, *near]


def limits_of(cards: Sequence[Motion | MapMotion], found: Motions, units: Units) -> dict[str, tuple[float, float]]:
    """Of lambda, its speed, the force and the amplitudes, for some cards.

    Parameters
    ----------
    cards : sequence
        At least one.
    found : Motions
    units : Units
    """
    curves = [curves for card in cards for curves in _curves_of(card)]
    size = max(float(abs(part.displacement).max()) for part in curves) or 1.0

    def ends(name: str, unit: float, least: float, *further: float, above: float = 0.06) -> tuple[float, float]:
        values = [getattr(part, name) for part in curves]
        low = min([*(float(part.min()) for part in values), *further])
        high = max([*(float(part.max()) for part in values), *further])
        if high - low < least:
            low, high = 0.5 * (low + high - least), 0.5 * (low + high + least)
        room = high - low
        return (low - 0.06 * room) * unit, (high + above * room) * unit

    (_, b), highest = found.gap, max(float(part.displacement.max()) for part in curves)
    largest = max([_NOTHING * size, *(float(part.amplitudes.max(initial=0.0)) for part in curves)]) * units.length
    return {
        # So much of the gap that it is seen.
        "displacement": ends(
            "displacement", units.length, 1e-2 * size, b - min(0.25 * max(highest - b, 0.0), 2.0 * abs(b))
        ),
        "speed": ends("speed", units.speed, 1e-2 * size * found.omega),
        # K_v is written above.
        "force": ends("force", units.force, 1e-2 * size, 0.0, found.static_force, above=0.5),
        "amplitude": (largest * 10.0 ** (0.3 - _DECADES), largest * 10.0**0.3),
    }


def _curves_of(card: Motion | MapMotion) -> list[Curves]:
    of_map = card.of_map if isinstance(card, Motion) else None
    return [card.curves] if of_map is None else [card.curves, of_map.curves]
