"""A row that was followed, and its spectra, as CSV and as lines for the terminal; the same text from the same store."""

from collections import Counter

import numpy as np

from pipeline.analysis.attractors.wording import attractor_name, percents
from pipeline.analysis.diagram.following import DIRECTIONS, Followed
from pipeline.analysis.diagram.options import Way
from pipeline.analysis.diagram.spectra import Spectra
from pipeline.config.quantities import AMPLITUDE, QUANTITIES, READ
from pipeline.plan.plan import Plan
from pipeline.plan.scales import scales_of
from pipeline.plane.row_curves import RowCurves
from pipeline.run.sheets import csv_text, exact_text
from solver import Scales
from solver.timedomain import AttractorKind, SlowRun

__all__ = ["diagram_lines", "diagram_sheets", "rms_along", "row_name", "spectrum_lines", "spectrum_sheets"]

_OF = (*READ, AMPLITUDE)


def row_name(plan: Plan, way: Way, *further: str) -> str:
    """Name of the files of a row, without ending: "f_e=0.3", or "f_e=0.3-force-up" with what else tells them apart."""
    return "-".join((f"{plan.parameter.name}={way.value:.10g}", *further))


def diagram_sheets(followed: Followed, curves: RowCurves, stem: str) -> dict[str, str]:
    """Name of a file -> CSV: steps of both runs with every quantity, their Poincaré points, the map's branches."""
    sweep, scales = followed.plan.sweep.name, scales_of(followed.plan)
    steps = _Table(
        ("direction", sweep, "kind", "impact", *(one.name for one in _OF), "lyapunov", "jump"), scales, {"jump": sweep}
    )
    points = _Table(("direction", sweep, "displacement"), scales, {"displacement": "length"})
    for direction in DIRECTIONS:
        run = followed.runs[direction]
        for i, value in enumerate(run.values.tolist()):
            numbers = [float(run.quantities[one.name][i]) for one in _OF]
            kind = AttractorKind(int(run.kind[i])).label.replace("_", "-")
            impact = "" if run.impact[i] < 0 else int(run.impact[i])
            steps.add(direction, value, kind, impact, *numbers, float(run.lyapunov[i]), float(run.jumps[i]))
            for point in run.sections[i][np.isfinite(run.sections[i])].tolist():
                points.add(direction, value, point)
    branches = _Table(("branch", sweep, "rms", "stable", "lasting"), scales)
    rms = rms_along(curves)
    for segment, lasting in zip(curves.segments, curves.lasting, strict=True):
        for i in range(segment.start, segment.stop):
            place = int(curves.points["branch"][i]), float(curves.points["position"][i])
            branches.add(*place, float(rms[i]), int(segment.stable), int(lasting))
    return {f"{stem}.csv": steps.text(), f"{stem}-points.csv": points.text(), f"{stem}-branches.csv": branches.text()}


def rms_along(curves: RowCurves) -> np.ndarray:
    """RMS of the varying part of lambda along the branches of a row, (point,): from all their harmonics."""
    motion = curves.points["motion"]
    return np.sqrt(0.5 * np.sum(motion[:, 1:] ** 2, axis=1))


def spectrum_sheets(spectra: Spectra, stem: str) -> dict[str, str]:
    """Name of a file -> CSV: one line for each order of each step."""
    plan, options = spectra.followed.plan, spectra.options
    sweep, of = plan.sweep.name, "length" if options.of == "displacement" else "force"
    scales = {"frequency": "mesh_frequency", "amplitude": of}
    table = _Table((sweep, "kind", "order", "frequency", "amplitude"), scales_of(plan), scales)
    orders = np.concatenate([[0.0], spectra.orders]).tolist()
    for i, value in enumerate(spectra.values.tolist()):
        kind, omega = AttractorKind(int(spectra.kind[i])).label.replace("_", "-"), float(spectra.omega[i])
        amplitudes = [float(spectra.mean[i]), *spectra.amplitudes[i].tolist()]
        for order, amplitude in zip(orders, amplitudes, strict=True):
            table.add(value, kind, order, order * omega, amplitude)
    return {f"{stem}.csv": table.text()}


class _Table:
    """Tidy CSV, numbers to ten digits; of a gear in physical units with a column "name (unit)" for each that has one.

    Parameters
    ----------
    header : sequence of str
    scales : Scales or None
    named : dict of str to str, optional
        Column -> its scale, where it is neither an axis nor a quantity of the registry.
    """

    def __init__(self, header, scales: Scales | None, named: dict[str, str] | None = None):
        self._header, self._lines, self._scaled = tuple(header), [], {}
        for place, name in enumerate(self._header if scales is not None else ()):
            scale = (named or {}).get(name) or (QUANTITIES[name].scale if name in QUANTITIES else name)
            if scale is not None and scale in scales:
                self._scaled[place] = scales[scale]

    def add(self, *cells) -> None:
        """One more line."""
        physical = [cells[place] * scale.shown for place, scale in self._scaled.items()]
        self._lines.append([exact_text(cell) for cell in (*cells, *physical)])

    def text(self) -> str:
        """All lines."""
        more = [f"{self._header[place]} ({scale.unit})" for place, scale in self._scaled.items()]
        return csv_text([*self._header, *more], self._lines)


def diagram_lines(followed: Followed) -> list[str]:
    """What a run along the row met, line by line."""
    plan, way = followed.plan, followed.way
    sweep, scales = plan.sweep.name, scales_of(plan)
    up = followed.runs["up"].values
    found = [
        f"{_value(plan.parameter.name, way.value, scales)}, {len(way.columns)} values of {sweep} from "
        f"{_value(None, up[0], scales, sweep)} to {_value(None, up[-1], scales, sweep)}: up from rest, "
        "and down from there"
    ]
    for direction in DIRECTIONS:
        run = followed.runs[direction]
        found.append(f"{direction}wards: {_shares(run)}")
        for i in np.flatnonzero(np.isfinite(run.jumps)).tolist():
            names = [attractor_name(int(run.kind[at]), int(run.impact[at])) or "not integrated" for at in (i - 1, i)]
            found.append(
                f"{direction}wards: jump at {sweep} = {_value(None, run.jumps[i], scales, sweep)} from {names[0]} to "
                f"{names[1]}"
            )
    stretches = [
        " ... ".join(_value(None, end, scales, sweep) for end in stretch) for stretch in followed.hysteresis.tolist()
    ]
    other = f"other motions downwards than upwards: {sweep} = {', '.join(stretches)}"
    found.append(other if stretches else "the same motions downwards as upwards")
    return found


def _shares(run: SlowRun) -> str:
    """Shares of the steps by kind."""
    counts = Counter(run.kind.tolist())
    kinds = sorted(counts)
    names = [AttractorKind(kind).label.replace("_", "-") or "not integrated" for kind in kinds]
    shares = percents([counts[kind] for kind in kinds])
    return ", ".join(f"{name} {share}" for name, share in zip(names, shares, strict=True))


def spectrum_lines(spectra: Spectra) -> list[str]:
    """What stands out in the spectra, line by line."""
    plan, options = spectra.followed.plan, spectra.options
    scales, sweep = scales_of(plan), plan.sweep.name
    found = [
        f"{_value(plan.parameter.name, options.way.value, scales)}, {spectra.values.size} values of {sweep} "
        f"{options.direction}wards: {options.of} at orders 1/{options.periods} ... {options.orders:g}"
    ]
    if np.isfinite(spectra.amplitudes).any():
        i, k = np.unravel_index(np.nanargmax(spectra.amplitudes), spectra.amplitudes.shape)
        size = spectra.amplitudes[i, k]
        of = "length" if options.of == "displacement" else "force"
        found.append(
            f"largest amplitude {_value(None, size, scales, of)} of order {spectra.orders[k]:.4g} at {sweep} = "
            f"{_value(None, spectra.values[i], scales, sweep)}"
        )
    return found


def _value(name: str | None, value: float, scales: Scales | None, scale: str | None = None) -> str:
    """A value to six digits, after its name if that is wanted, and in the unit of the gear where it has one."""
    text, scale = f"{value:.6g}", scale or name
    if scales is not None and scale in scales:
        text = f"{text} ({value * scales[scale].shown:.5g} {scales[scale].unit})"
    return text if name is None else f"{name} = {text}"
