"""What holds between the boundaries that cross a row: solutions enumerated in several places, so that none is guessed.

What holds is one whole number: the code of the n/I label, and where dynamic stability is asked for also that of the
dynamically stable motions alone, and whether static and dynamic stability contradict each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from solver.boundaries.curve import BoundaryCurve
from solver.boundaries.problem import Plane
from solver.contact.impact import domain_code, domain_label, impact_of_range
from solver.enumeration.solutions import Proof, RowSolutions, enumerate_row
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import dead_zone_ends
from solver.model.parameter_path import place_on
from solver.regions.ceiling import ceiling_curve
from solver.regions.slabs import RegionError, RowCrossings, Slab
from solver.stability import Instability, assess
from solver.stability.instability import LEFT_TO_FOLDS

__all__ = [
    "KnownCells",
    "Labeller",
    "dynamic_code",
    "is_contradictory",
    "row_codes",
    "stability_code",
    "stability_codes",
    "static_code",
]

# Where in a slab solutions are enumerated, and elsewhere if they are too close to be told apart there; where between
# two crossings. One place would do: the others, or cells that are known, show whether a boundary is missing.
_ROWS = (np.array([1e-4, 0.1, 0.5, 0.9, 0.9999]), np.array([0.02, 0.3, 0.7, 0.98]))
_PLACES = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
_MIDDLE = 0.5
# In a part of a slab no larger than this share of the plane one place will do if no known cell contradicts it.
_SMALL = 1e-4
# How closely a boundary along a row is found, as a fraction of the slab, and where solutions may be too close to tell.
_NARROW, _BLURRED = 1e-12, 1e-6
# The code of no label.
_UNDECIDED = 0
# Bits: code of the n/I label; above it the one of the dynamically stable motions; above that, whether one contradicts.
_SIZE, _STATIC = 16, (1 << 16) - 1
_CONTRADICTORY = 1 << 2 * _SIZE


@dataclass(frozen=True, eq=False)
class KnownCells:
    """Cells of the plane whose labels are known already.

    Parameters
    ----------
    p : (r,) array
        Rows, ascending.
    x : (c,) array
        Columns, ascending.
    codes : (r, c) int array
        Codes of the labels, 0 where they are not known.
    """

    p: np.ndarray
    x: np.ndarray
    codes: np.ndarray

    def within(self, slab: Slab) -> np.ndarray:
        """The rows that lie in a slab, by number."""
        low, high = slab.inner_ends
        return np.arange(*np.searchsorted(self.p, [low, high]))

    def votes(self, rows: np.ndarray, borders: np.ndarray, codes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """How many cells of some rows say the same as `codes` (g,) between `borders` (rows, g - 1), and how many say
        something else, (g,) each."""
        gap = np.sum(borders[:, :, None] <= self.x, axis=1)
        here = self.codes[rows]
        same = here == codes[gap]
        sides = same & (here != _UNDECIDED), ~same & (here != _UNDECIDED)
        return tuple(np.bincount(gap[cells], minlength=codes.size) for cells in sides)


class Labeller:
    """Finds what holds between every two neighbouring arcs of a slab.

    Parameters
    ----------
    plane : Plane
    crossings : RowCrossings
    amplitude_max : float
    codes : callable, optional
        (plane, p, x (k,), amplitude_max) -> what holds at places of a row, (k,) ints, 0 where that is not known;
        `row_codes` unless given.
    rows, at : arrays, optional
        Fractions of a slab's height and of the distance between two arcs at which it is asked.
    blur : float
        Where a part of a slab is no larger than this share of the plane, what most of its places say holds, or what
        holds beside it.
    known : KnownCells, optional
        Where they say what one place in the middle between two arcs says, or where there is little room and none of
        them lies, no other place is asked.
    """

    def __init__(
        self,
        plane: Plane,
        crossings: RowCrossings,
        amplitude_max: float,
        codes=None,
        rows=_ROWS,
        at=_PLACES,
        blur: float = 0.0,
        known: KnownCells | None = None,
    ):
        self.plane, self.crossings, self.amplitude_max, self._known = plane, crossings, amplitude_max, known
        self._codes, self._rows, self._at, self._blur = row_codes if codes is None else codes, rows, at, blur

    def expect(self, slabs: Sequence[Slab]) -> None:
        """Look up together the rows at which slabs are asked first."""
        rows = [slab.rows([*self._rows[0], _MIDDLE]) for slab in slabs]
        rows += [self._known.p[self._known.within(slab)] for slab in slabs if self._known is not None]
        self.crossings.look_up(np.concatenate([np.empty(0), *rows]))

    def codes(self, slab: Slab, fractions, places, gaps=slice(None)) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows (v,), the places (v, gaps, f) in them between arcs, and the codes of the labels there.

        Parameters
        ----------
        slab : Slab
        fractions : (v,) sequence of float
            Where the rows are between the slab's lowest and its highest one.
        places : (f,) sequence of float
            Where the places are between two arcs.
        gaps : index, optional
            Between which arcs; all unless given.
        """
        values = slab.rows(fractions)
        arcs, x = self.crossings.matrix(values)
        x = x[:, [arcs.index(arc) for arc in slab.arcs]]
        at = (x[:, :-1, None] + np.diff(x)[:, :, None] * np.asarray(places))[:, gaps]
        rows = zip(values, at, strict=True)
        codes = [self._codes(self.plane, value, row.ravel(), self.amplitude_max) for value, row in rows]
        return values, at, np.reshape(codes, at.shape)

    def sequence(self, slab: Slab) -> list[int] | float | BoundaryCurve:
        """The codes; or what divides the slab further: a row along which a boundary runs, or where solutions pass the
        ceiling.

        Raises
        ------
        RegionError
            If places between the same two arcs have different labels for another reason, or none can be decided.
        """
        seen = [{} for _ in slab.arcs[1:]] if self._known is None else self._borne_out(slab)
        asked = np.flatnonzero([not found for found in seen])
        if not asked.size:
            return _settled(seen)
        whole = np.ptp(self.plane.x_range) * np.ptp(self.plane.p_range)
        for fractions in self._rows:
            values, at, codes = self.codes(slab, fractions, self._at, asked)
            sizes = np.max(np.ptp(at, axis=2), axis=0) * (slab.high - slab.low) / whole
            for k, labels in enumerate(seen[gap] for gap in asked):
                for row, place in zip(*np.nonzero(codes[:, k] != _UNDECIDED), strict=True):
                    labels.setdefault(int(codes[row, k, place]), []).append((at[row, k, place], values[row]))
                if len({static_code(code) for code in labels}) > 1 and sizes[k] > self._blur:
                    further = self._level(slab, asked[k], fractions) or self._ceiling(values, at[:, k], codes[:, k])
                    if further is not None:
                        return further
                    where = "; ".join(
                        f"{domain_label(static_code(code))} at {tuple(map(float, labels[code][0]))}"
                        for code in sorted(labels)
                    )
                    raise RegionError(
                        f"no boundary parts different labels: {where} of ({self.plane.x_axis}, {self.plane.p_axis})"
                    )
            if all(seen[gap] or size <= self._blur for gap, size in zip(asked, sizes, strict=True)):
                return _settled(seen)
        nowhere = next(k for k, gap in enumerate(asked) if not seen[gap] and sizes[k] > self._blur)
        raise RegionError(
            f"the solutions next to {(float(at[0, nowhere, 0]), float(values[0]))} of "
            f"({self.plane.x_axis}, {self.plane.p_axis}) cannot be told apart"
        )

    def _borne_out(self, slab: Slab) -> list[dict[int, list[tuple[float, float]]]]:
        """What one place between every two arcs says, and where it is; nothing where known cells say something else, or
        where none of them lies and there is room for much."""
        values, at, codes = self.codes(slab, [_MIDDLE], [_MIDDLE])
        at, codes = at[0, :, 0], codes[0, :, 0]
        rows = self._known.within(slab)
        arcs, x = self.crossings.matrix(np.concatenate([values, self._known.p[rows]]))
        ends = x[:, [arcs.index(arc) for arc in slab.arcs]]
        same, other = self._known.votes(rows, ends[1:, 1:-1], static_code(codes))
        sizes = np.diff(ends[0]) * (slab.high - slab.low) / (np.ptp(self.plane.x_range) * np.ptp(self.plane.p_range))
        clear = (codes != _UNDECIDED) & (other == 0) & ((same > 0) | (sizes <= _SMALL))
        places = zip(clear.tolist(), codes.tolist(), at.tolist(), strict=True)
        return [{code: [(place, values[0])]} if kept else {} for kept, code, place in places]

    def _level(self, slab: Slab, gap: int, fractions) -> float | None:
        """Where a whole gap changes its label at once: no row crosses such a boundary. None if it does not."""

        def labels(fraction: float) -> set[int]:
            return {int(code) for code in self.codes(slab, [fraction], [0.02, 0.5, 0.98], [gap])[2].ravel()}

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
            if self._codes(self.plane, value, np.array([middle]), self.amplitude_max)[0] == code:
                low = middle
            else:
                high = middle
        _, _, solutions = _enumerated(self.plane, value, np.array([low]), 2.0 * self.amplitude_max)
        motions = np.column_stack([solutions.mean[0], solutions.cos[0], solutions.sin[0]])
        misses = np.abs(solutions.amplitude[0] / self.amplitude_max - 1.0)
        if not np.any(misses < 1e-6):
            return None
        return ceiling_curve(self.plane, self.amplitude_max, np.array([*motions[np.nanargmin(misses)], low, value]))


def _settled(seen: list[dict[int, list]]) -> list[int]:
    """What most places say; of what is seen nowhere, what holds beside it."""
    codes = [max(sorted(found), key=lambda code: len(found[code]), default=_UNDECIDED) for found in seen]
    known = [code for code in codes if code != _UNDECIDED]
    for i, code in enumerate(codes):
        if code == _UNDECIDED:
            codes[i] = codes[i - 1] if i else known[0] if known else _UNDECIDED
    return codes


def _enumerated(plane: Plane, value: float, x: np.ndarray, amplitude_max: float):
    """The system and the frequency of one row, and every solution at places of it."""
    system, omega = place_on(plane.p_axis, value, plane.system, plane.omega)
    return system, omega, enumerate_row(system, plane.x_axis, x, omega=omega, amplitude_max=amplitude_max)


def row_codes(plane: Plane, value: float, x: np.ndarray, amplitude_max: float) -> np.ndarray:
    """Codes of the labels at places of one row.

    Parameters
    ----------
    plane, value, x, amplitude_max
        As for `stability_codes`.

    Returns
    -------
    (k,) int array
        0 where the solutions are not proven to be all.
    """
    system, _, found = _enumerated(plane, value, x, amplitude_max)
    codes = _label_codes(_state_bits(plane, system, x, found), found.stable == 1)
    return np.where(found.proof == Proof.PROVEN, codes, _UNDECIDED)


def stability_codes(plane: Plane, value: float, x: np.ndarray, amplitude_max: float) -> np.ndarray:
    """What n/I and dynamic stability say at places of one row.

    Parameters
    ----------
    plane : Plane
    value : float
        p of the row.
    x : (k,) array
    amplitude_max : float
        Solutions of larger amplitude do not count.

    Returns
    -------
    (k,) int64 array
        0 where the solutions are not proven to be all; see `static_code`, `dynamic_code` and `is_contradictory`.
    """
    system, omega, found = _enumerated(plane, value, x, amplitude_max)
    stable = found.stable == 1
    column, which = np.nonzero(stable)
    kind = np.zeros(stable.shape, np.int8)
    # No band about the unit circle: boundaries tell where multipliers pass it, and next to them they are close to it.
    kind[column, which] = assess(
        system,
        plane.x_axis,
        x[column],
        found.motions[column, which],
        omega=omega,
        static=found.stable[column, which],
        tolerance=0.0,
    ).kind
    bits = _state_bits(plane, system, x, found)
    static = _label_codes(bits, stable).astype(np.int64)
    dynamic = _label_codes(bits, stable & np.isin(kind, LEFT_TO_FOLDS)).astype(np.int64)
    contradictory = np.any(stable & (kind == Instability.CONTRADICTORY), axis=1)
    known = (found.proof == Proof.PROVEN) & ~np.any(kind == Instability.UNDECIDED, axis=1)
    return np.where(known, stability_code(static, dynamic, contradictory), _UNDECIDED)


def _state_bits(plane: Plane, system: Model | ContactSystem, x: np.ndarray, found: RowSolutions) -> np.ndarray:
    """The bit of the impact state of every solution, (k, solutions)."""
    low, high = dead_zone_ends(system, plane.x_axis, x)
    ends = low[:, None], high[:, None]
    states = impact_of_range(found.mean - found.amplitude, found.mean + found.amplitude, *ends)
    return 1 << states.astype(np.int64).clip(0)


def _label_codes(bits: np.ndarray, counted: np.ndarray) -> np.ndarray:
    """Codes of the labels of the solutions that are counted, (k,) uint16."""
    states = np.bitwise_or.reduce(np.where(counted, bits, 0), axis=1, initial=0)
    return domain_code(np.sum(counted, axis=1), states)


def stability_code(static, dynamic, contradictory):
    """One code of three.

    Parameters
    ----------
    static, dynamic : int arrays
        Codes of the label, and of the one that counts dynamically stable motions alone.
    contradictory : bool array
    """
    return static | dynamic << _SIZE | np.where(contradictory, _CONTRADICTORY, 0)


def static_code(code):
    """The code of the n/I label."""
    return code & _STATIC


def dynamic_code(code):
    """The code of the label that counts the dynamically stable ones of the motions of n/I.

    One for which static and dynamic stability contradict each other counts.
    """
    return code >> _SIZE & _STATIC


def is_contradictory(code):
    """Whether static and dynamic stability of a motion of n/I contradict each other."""
    return code & _CONTRADICTORY != 0
