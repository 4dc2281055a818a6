"""A stored plane as plain arrays: the one way in which what is stored of rows is read."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeline.config.places import Place
from pipeline.plan.numerics import row_system, sweep_axis
from pipeline.plan.plan import Block, Plan
from pipeline.plan.scales import scales_of
from pipeline.plane.boundaries import StoredBoundaries, read_boundaries
from pipeline.plane.resonances import contact_modes
from pipeline.plane.segments import BranchSegment, segments_of_row
from pipeline.store import COMPLETE, read_plan
from pipeline.store.stored_arrays import StoredArrays, open_arrays
from solver import Scales, domain_code
from solver.model.packing import dead_zone_ends
from solver.regions.labelling import stability_code
from solver.stability import Instability
from solver.stability.instability import LEFT_TO_FOLDS

__all__ = ["StoredPlane", "read_stored"]

_POINT_ARRAYS = ("mean", "cos", "sin", "amplitude", "stable", "impact", "branch", "event")


def _stored(name: str) -> cached_property:
    """An array of the store, read when it is first asked for."""
    return cached_property(lambda plane: plane.array(name))


@dataclass(frozen=True, eq=False)
class StoredPlane:
    """A plane, a volume or one layer of it, or some rows of a plane; P rows, X columns, S solutions.

    Every array is read when it is first asked for, and once. Where a plane may be larger than memory, its `parts` are
    read one after the other.

    Parameters
    ----------
    path : Place
    plan : Plan
        Of the plane; of the layer, where it is one.
    layer : int or None
        Number of the layer in a volume.
    volume : Plan or None
        Of that volume.
    block : Block or None
        The rows that are meant, by number within the plane; all unless given.
    dynamic : bool
        Whether `domain` and `n_stable` count the dynamically stable motions, instead of the statically stable ones.
    physical : bool
        Whether it is shown in physical units.

    Attributes
    ----------
    status : (P,) array
    open : (P, X) array
    mean, amplitude, phase, stable, impact, instability : (P, X, S) arrays
    motion : (P, X, S, n) array
        All harmonics, where the plane is of a higher order.
    n_points : (P,) array
        Points of a row's branches.
    end_reason : (P, branch, 2) array
    """

    path: Place
    plan: Plan
    layer: int | None = None
    volume: Plan | None = None
    block: Block | None = None
    dynamic: bool = False
    physical: bool = False

    status = _stored("status")
    open = _stored("open")
    mean = _stored("mean")
    amplitude = _stored("amplitude")
    phase = _stored("phase")
    stable = _stored("stable")
    impact = _stored("impact")
    instability = _stored("instability")
    motion = _stored("motion")
    n_points = _stored("branches/n_points")
    end_reason = _stored("branches/end_reason")

    def array(self, name: str, *within: slice) -> np.ndarray:
        """An array that has rows, read anew; `within` cuts it along its further dimensions."""
        place = (self._within, *within)
        return self._arrays.read(name, *(place if self.layer is None else (self.layer, *place)))

    @property
    def parts(self) -> Iterator["StoredPlane"]:
        """The plane in parts of some rows, each a few chunks of the store."""
        return map(self.part, self.plan.parts)

    def part(self, block: Block) -> "StoredPlane":
        """Some rows of the plane."""
        part = self._as(block=block)
        # One number a row: read for all rows at once.
        vars(part).update(status=self.status[part._within], n_points=self.n_points[part._within])
        return part

    def layer_at(self, index: int) -> "StoredPlane":
        """One layer of a volume."""
        return self._as(plan=self.plan.layer(index), layer=index, volume=self.plan)

    def counting(self, dynamic: bool) -> "StoredPlane":
        """The plane whose labels count the dynamically stable motions, or the statically stable ones."""
        return self if dynamic == self.dynamic else self._twin

    @cached_property
    def _twin(self) -> "StoredPlane":
        twin = self._as(dynamic=not self.dynamic)
        vars(twin)["_twin"] = self
        return twin

    def _as(self, **changes) -> "StoredPlane":
        """Another part of the same store, which is not opened again: that takes longer than to read a block of it."""
        part = replace(self, **changes)
        vars(part)["_arrays"] = self._arrays
        return part

    @cached_property
    def rows(self) -> np.ndarray:
        """Values of the row parameter, (P,)."""
        return self.plan.parameter.values[self._within]

    @cached_property
    def complete(self) -> np.ndarray:
        """Whether a row is complete, (P,) bool."""
        return self.status == COMPLETE

    @cached_property
    def about(self) -> dict:
        """What the store says of itself: title, configuration, versions, time of creation."""
        return self._arrays.attributes

    @cached_property
    def attributes(self) -> dict[str, dict]:
        """Axis name -> its attributes (`long_name`, `units`)."""
        return {axis.name: self._arrays.attributes_of(axis.name) for axis in (self.plan.parameter, self.plan.sweep)}

    @cached_property
    def labels(self) -> dict[int, str]:
        """Code -> n/I label, as in `domain`."""
        flags = self._arrays.attributes_of("domain")
        return dict(zip(map(int, flags["flag_values"]), flags["labels"], strict=True))

    @cached_property
    def domain(self) -> np.ndarray:
        """Codes of the n/I labels, (P, X); 0 in rows that are not complete."""
        stored = np.where(self.complete[..., None], self.array("domain"), 0)
        if not self.dynamic:
            return stored
        return np.where(stored != 0, self._dynamic_codes, stored)

    @cached_property
    def n_stable(self) -> np.ndarray:
        """Number of stable motions, (P, X)."""
        stored = self.array("n_stable")
        return np.where(self.domain != 0, np.sum(self._kept, axis=-1), stored) if self.dynamic else stored

    @property
    def counted(self) -> np.ndarray:
        """The motions that labels count, (P, X, S) bool: the stable ones of complete rows."""
        return (self._kept if self.dynamic else self.stable == 1) & self.complete[..., None, None]

    def extreme(self, name: str, of: str) -> np.ndarray:
        """One of `pipeline.config.quantities.QUANTITIES` in every cell, (P, X); nan where no motion is counted.

        Parameters
        ----------
        name : str
        of : str
            "worst" or "mildest": the largest or the smallest value among the motions that are counted.
        """
        values = np.where(self.counted, self.array(name), np.nan)
        return (np.fmax if of == "worst" else np.fmin).reduce(values, axis=-1)

    @cached_property
    def unstable(self) -> np.ndarray:
        """Where a statically stable motion is dynamically unstable (period doubling, Neimark-Sacker), (P, X) bool."""
        kind = self.instability
        return np.any((self.stable == 1) & (kind > Instability.NONE) & (kind < Instability.CONTRADICTORY), axis=-1)

    @cached_property
    def contradictory(self) -> np.ndarray:
        """Where static and dynamic stability of a motion contradict each other, (P, X) bool."""
        return np.any((self.stable == 1) & (self.instability == Instability.CONTRADICTORY), axis=-1)

    @cached_property
    def motions(self) -> np.ndarray:
        """All unknowns of the balance in every cell, (P, X, S, n)."""
        return self.motions_in(...)

    def motions_in(self, *cells) -> np.ndarray:
        """All unknowns of the balance in some cells, (k, S, n), by the numbers (k,) of their rows and columns."""
        if self.plan.motion_size:
            return self.motion[cells]
        mean, amplitude, phase = (values[cells] for values in (self.mean, self.amplitude, self.phase))
        return np.stack([mean, amplitude * np.cos(phase), -amplitude * np.sin(phase)], -1)

    @cached_property
    def stability_codes(self) -> np.ndarray:
        """What the cells say of n/I and of dynamic stability, as `solver.regions.labelling.stability_code`, (P, X)."""
        static = np.where(self.complete[..., None], self.array("domain"), 0).astype(np.int64)
        dynamic = self._dynamic_codes.astype(np.int64)
        return np.where(static != 0, stability_code(static, dynamic, self.contradictory), 0)

    @cached_property
    def points(self) -> dict[str, np.ndarray]:
        """Name -> (P, point) array of the branches; "position" is where on the sweep axis a point is."""
        return {**{name: self.along(name) for name in _POINT_ARRAYS}, "position": self.along(self.plan.sweep.name)}

    @cached_property
    def boundaries(self) -> StoredBoundaries | None:
        """The plane's boundaries; None where they have not been traced."""
        return read_boundaries(self.path, self.plan if self.volume is None else self.volume, self.layer)

    @cached_property
    def scales(self) -> Scales | None:
        """To show the plane in physical units; None shows it dimensionless."""
        return scales_of(self.plan) if self.physical else None

    @property
    def over_frequency(self) -> bool:
        """Whether rows run over the mesh frequency, so that natural frequencies can be shown along them."""
        return self.plan.sweep.name == "omega"

    @property
    def resonances(self) -> np.ndarray:
        """Which natural frequencies lie within the sweep axis in some row, (m,) bool."""
        if not self.over_frequency:
            return np.zeros(self.modes.shape[1], dtype=bool)
        return np.any((self.modes >= self.plan.sweep.low) & (self.modes <= self.plan.sweep.high), axis=0)

    @cached_property
    def modes(self) -> np.ndarray:
        """Linear natural frequencies in contact for every row, ascending, (P, m); nan beyond the modes of a row."""
        rows = [[natural for natural, _ in contact_modes(row_system(self.plan, value))] for value in self.rows]
        most = max(map(len, rows), default=0)
        return np.array([row + [np.nan] * (most - len(row)) for row in rows]).reshape(len(rows), most)

    @cached_property
    def segments(self) -> list[list[BranchSegment]]:
        """Per row, its branches cut at folds and grazings."""
        return [self.row_segments(row) for row in range(self.rows.size)]

    def along(self, name: str) -> np.ndarray:
        """An array of the branches, (P, point, ...), as far as any row uses the room for points; read anew."""
        return self.array(f"branches/{name}", slice(int(self.n_points.max(initial=0))))

    def row_points(self, row: int) -> dict[str, np.ndarray]:
        """The branch points of one row, without the unused room behind them."""
        return {name: array[row, : self.n_points[row]] for name, array in self.points.items()}

    def row_segments(self, row: int) -> list[BranchSegment]:
        """The branches of one row cut at folds and grazings."""
        points = self.row_points(row)
        system, axis = row_system(self.plan, self.rows[row]), sweep_axis(self.plan)
        return segments_of_row(points, *dead_zone_ends(system, axis, points["position"]))

    @property
    def _within(self) -> slice:
        return slice(None) if self.block is None else slice(self.block.start, self.block.stop)

    @cached_property
    def _arrays(self) -> StoredArrays:
        return open_arrays(self.path)

    @cached_property
    def _dynamic_codes(self) -> np.ndarray:
        """Codes of the labels that count the dynamically stable motions, (P, X)."""
        states = np.where(self._kept, 1 << self.impact.astype(np.int64).clip(0), 0)
        return domain_code(np.sum(self._kept, axis=-1), np.bitwise_or.reduce(states, axis=-1))

    @cached_property
    def _kept(self) -> np.ndarray:
        """The motions that are dynamically stable; a multiplier beyond +1 is left to static stability."""
        return (self.stable == 1) & np.isin(self.instability, LEFT_TO_FOLDS)


def read_stored(path: Place, dynamic: bool = False, physical: bool = False) -> StoredPlane:
    """Look a store over, and give its plane or volume.

    Parameters
    ----------
    path : Place
    dynamic, physical
        As for `StoredPlane`.

    Raises
    ------
    StoreError
        As `pipeline.store.read_plan`.
    """
    return StoredPlane(path, read_plan(path), dynamic=dynamic, physical=physical)
