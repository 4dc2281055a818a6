"""Labels between the boundaries that cross a row: solutions enumerated in several places, so that none is guessed."""

import numpy as np

from solver.boundaries.curve import BoundaryCurve
from solver.boundaries.problem import Plane
from solver.contact.impact import domain_code, domain_label, impact_state
from solver.enumeration.solutions import Proof, enumerate_row
from solver.model.parameter_path import place_on
from solver.regions.ceiling import ceiling_curve
from solver.regions.slabs import RegionError, RowCrossings, Slab

__all__ = ["Labeller"]

# Where in a slab solutions are enumerated, and elsewhere if they are too close to be told apart there; where between
# two crossings. One place would do: the others show whether a boundary is missing.
_ROWS = (np.array([1e-4, 0.1, 0.5, 0.9, 0.9999]), np.array([0.02, 0.3, 0.7, 0.98]))
_PLACES = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
# How closely a boundary along a row is found, as a fraction of the slab, and where solutions may be too close to tell.
_NARROW, _BLURRED = 1e-12, 1e-6
# The code of no label.
_UNDECIDED = 0


class Labeller:
    """Finds the label between every two neighbouring arcs of a slab."""

    def __init__(self, plane: Plane, crossings: RowCrossings, amplitude_max: float):
        self.plane, self.crossings, self.amplitude_max = plane, crossings, amplitude_max

    def codes(self, slab: Slab, fractions, places) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows (v,), the places (v, arcs - 1, f) in them between arcs, and the codes of the labels there.

        Parameters
        ----------
        slab : Slab
        fractions : (v,) sequence of float
            Where the rows are between the slab's lowest and its highest one.
        places : (f,) sequence of float
            Where the places are between two arcs.
        """
        values = slab.rows(fractions)
        arcs, x = self.crossings.matrix(values)
        x = x[:, [arcs.index(arc) for arc in slab.arcs]]
        at = x[:, :-1, None] + np.diff(x)[:, :, None] * np.asarray(places)
        rows = zip(values, at, strict=True)
        codes = [row_codes(self.plane, value, row.ravel(), self.amplitude_max) for value, row in rows]
        return values, at, np.reshape(codes, at.shape)

    def sequence(self, slab: Slab) -> list[int] | float | BoundaryCurve:
        """The codes; or what divides the slab further: a row along which a boundary runs, or where solutions pass the
        ceiling.

        Raises
        ------
        RegionError
            If places between the same two arcs have different labels for another reason, or none can be decided.
        """
        seen: list[dict[int, tuple[float, float]]] = [{} for _ in slab.arcs[1:]]
        for fractions in _ROWS:
            values, at, codes = self.codes(slab, fractions, _PLACES)
            for gap, labels in enumerate(seen):
                for row, place in zip(*np.nonzero(codes[:, gap] != _UNDECIDED), strict=True):
                    labels.setdefault(int(codes[row, gap, place]), (float(at[row, gap, place]), float(values[row])))
                if len(labels) > 1:
                    level = self._level(slab, gap, fractions)
                    if level is not None:
                        return level
                    curve = self._ceiling(values, at[:, gap], codes[:, gap])
                    if curve is not None:
                        return curve
                    where = "; ".join(f"{domain_label(code)} at {labels[code]}" for code in sorted(labels))
                    raise RegionError(
                        f"no boundary parts different labels: {where} of ({self.plane.x_axis}, {self.plane.p_axis})"
                    )
            if all(seen):
                return [next(iter(labels)) for labels in seen]
        nowhere = next(gap for gap, labels in enumerate(seen) if not labels)
        raise RegionError(
            f"the solutions next to {(float(at[1, nowhere, 0]), float(values[1]))} of "
            f"({self.plane.x_axis}, {self.plane.p_axis}) cannot be told apart"
        )

    def _level(self, slab: Slab, gap: int, fractions) -> float | None:
        """Where a whole gap changes its label at once: no row crosses such a boundary. None if it does not."""

        def labels(fraction: float) -> set[int]:
            return {int(code) for code in self.codes(slab, [fraction], [0.02, 0.5, 0.98])[2][0, gap]}

        steps = [(a, b) for a, b in zip(fractions[:-1], fractions[1:], strict=True) if labels(a) != labels(b)]
        if not steps:
            return None
        low, high = steps[0]
        below, above = labels(low), labels(high)
        if len(below) > 1 or len(above) > 1 or _UNDECIDED in below | above:
            return None
        while high - low > _NARROW:
            middle = 0.5 * (low + high)
            here = labels(middle)
            if here == below:
                low = middle
            elif here == above:
                high = middle
            elif _UNDECIDED in here and high - low < _BLURRED:
                break
            else:
                return None
        return float(slab.rows(0.5 * (low + high)))

    def _ceiling(self, values: np.ndarray, at: np.ndarray, codes: np.ndarray) -> BoundaryCurve | None:
        """The curve along which a branch passes the ceiling between two places of a gap; None if there is none."""
        known = codes != _UNDECIDED
        jumps = np.argwhere((codes[:, 1:] != codes[:, :-1]) & known[:, 1:] & known[:, :-1])
        if not len(jumps):
            return None
        row, column = jumps[0]
        value, low, high = values[row], at[row, column], at[row, column + 1]
        code = codes[row, column]
        for _ in range(60):
            middle = 0.5 * (low + high)
            if row_codes(self.plane, value, np.array([middle]), self.amplitude_max)[0] == code:
                low = middle
            else:
                high = middle
        solutions = _enumerated(self.plane, value, np.array([low]), 2.0 * self.amplitude_max)
        motions = np.column_stack([solutions.mean[0], solutions.cos[0], solutions.sin[0]])
        misses = np.abs(solutions.amplitude[0] / self.amplitude_max - 1.0)
        if not np.any(misses < 1e-6):
            return None
        return ceiling_curve(self.plane, self.amplitude_max, np.array([*motions[np.nanargmin(misses)], low, value]))


def _enumerated(plane: Plane, value: float, x: np.ndarray, amplitude_max: float):
    """Every solution at places of one row."""
    model, omega = place_on(plane.p_axis, value, plane.system, plane.omega)
    return enumerate_row(model, plane.x_axis, x, omega=omega, amplitude_max=amplitude_max)


def row_codes(plane: Plane, value: float, x: np.ndarray, amplitude_max: float) -> np.ndarray:
    """Codes of the labels at places of one row; 0 where the solutions are not proven to be all.

    Parameters
    ----------
    plane : Plane
    value : float
        Of the row parameter.
    x : (k,) array
        Values of the other axis.
    amplitude_max : float
        Amplitude ceiling.
    """
    found = _enumerated(plane, value, x, amplitude_max)
    b = plane.half_backlash(x, value)
    states = impact_state(found.mean - found.amplitude, found.mean + found.amplitude, b[:, None]).astype(np.int64)
    stable = found.stable == 1
    bits = np.bitwise_or.reduce(np.where(stable, 1 << states.clip(0), 0), axis=1, initial=0)
    return np.where(found.proof == Proof.PROVEN, domain_code(np.sum(stable, axis=1), bits), _UNDECIDED)
