"""A stored plane as figures need it: plain arrays, read once."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr

from pipeline import store
from pipeline.plan.numerics import model_at
from pipeline.plan.plan import Plan
from pipeline.plan.scales import scales_of
from pipeline.plane.boundaries import StoredBoundaries, read_boundaries
from pipeline.plane.segments import Piece, pieces_of_row
from solver import Scales, domain_code
from solver.stability import Instability

__all__ = ["StoredPlane", "read_stored"]

_POINT_ARRAYS = ("mean", "amplitude", "stable", "impact", "branch", "event")


@dataclass(frozen=True)
class StoredPlane:
    """One plane.

    Parameters
    ----------
    plan : Plan
    title : str
        Of the store.
    digest : str
        Digest of the configuration that made it.
    attributes : dict
        Axis name -> its attributes (`long_name`, `units`).
    labels : dict
        Code -> n/I label.
    domain, n_stable, open : (P, X) arrays
    dynamic : bool
        Whether `domain` and `n_stable` count the dynamically stable motions, instead of the statically stable ones.
    unstable, contradictory : (P, X) bool arrays
        Where a statically stable motion is dynamically unstable (period doubling, Neimark-Sacker), and where static and
        dynamic stability of one contradict each other.
    status : (P,) array
    points : dict
        Name -> (P, point) array of the branches; "position" is where on the sweep axis a point is.
    n_points : (P,) array
    end_reason : (P, branch, 2) array
    boundaries : StoredBoundaries or None
        None where they have not been traced.
    scales : Scales or None
        To show the plane in physical units; None shows it dimensionless.
    """

    plan: Plan
    title: str
    digest: str
    attributes: dict[str, dict]
    labels: dict[int, str]
    domain: np.ndarray
    n_stable: np.ndarray
    open: np.ndarray
    dynamic: bool
    unstable: np.ndarray
    contradictory: np.ndarray
    status: np.ndarray
    points: dict[str, np.ndarray]
    n_points: np.ndarray
    end_reason: np.ndarray
    boundaries: StoredBoundaries | None
    scales: Scales | None = None

    @property
    def rows(self) -> np.ndarray:
        """Values of the row parameter."""
        return self.plan.parameter.values

    @property
    def over_frequency(self) -> bool:
        """Whether rows run over the mesh frequency, so that natural frequencies can be shown along them."""
        return self.plan.sweep.name == "omega"

    @property
    def resonances(self) -> np.ndarray:
        """Which of the two natural frequencies lie within the sweep axis in some row, (2,) bool."""
        if not self.over_frequency:
            return np.zeros(2, dtype=bool)
        return np.any((self.modes >= self.plan.sweep.low) & (self.modes <= self.plan.sweep.high), axis=0)

    def row_points(self, row: int) -> dict[str, np.ndarray]:
        """The branch points of one row, without the unused room behind them."""
        return {name: array[row, : self.n_points[row]] for name, array in self.points.items()}

    @cached_property
    def pieces(self) -> list[list[Piece]]:
        """Per row, its branches cut at folds and grazings."""
        return [self._row_pieces(row) for row in range(self.plan.parameter.num)]

    @cached_property
    def modes(self) -> np.ndarray:
        """Linear natural frequencies of the pair for every row, lower and upper, (P, 2)."""
        return np.array([model_at(self.plan, value, self.plan.sweep.low).mesh_modes() for value in self.rows])

    def _row_pieces(self, row: int) -> list[Piece]:
        points = self.row_points(row)
        if self.plan.sweep.name == "b":
            backlash = points["position"]
        else:
            backlash = np.full(self.n_points[row], model_at(self.plan, self.rows[row], self.plan.sweep.low).b)
        return pieces_of_row(points, backlash)


def read_stored(path: Path, dynamic: bool = False, physical: bool = False, layer: int | None = None) -> StoredPlane:
    """Read a store, or of a volume one layer, labels by static or by dynamic stability, with scales if it is to be
    shown in physical units.

    Raises StoreError as `pipeline.store.read_plan` does.
    """
    plan = store.read_plan(path)
    # Plain arrays are wanted at once: dask would only cost time.
    plane = xr.open_zarr(path, chunks=None)
    branches = xr.open_zarr(path, group="branches", chunks=None)
    if layer is not None:
        plane, branches = (part.isel({plan.parameter2.name: layer}) for part in (plane, branches))
        plan = plan.layer(layer)
    n_points = branches["n_points"].values
    used = slice(int(n_points.max(initial=0)))
    points = {name: branches[name][:, used].values for name in _POINT_ARRAYS}
    points["position"] = branches[plan.sweep.name][:, used].values
    flags = plane["domain"].attrs
    static, kind = plane["stable"].values == 1, plane["instability"].values
    domain, n_stable = plane["domain"].values, plane["n_stable"].values
    if dynamic:
        kept = static & (kind == Instability.NONE)
        counts = np.sum(kept, axis=2)
        states = np.where(kept, 1 << plane["impact"].values.astype(np.int64).clip(0), 0)
        computed = domain != 0
        domain = np.where(computed, domain_code(counts, np.bitwise_or.reduce(states, axis=2)), domain)
        n_stable = np.where(computed, counts, n_stable)
    return StoredPlane(
        plan=plan,
        title=plane.attrs["title"],
        digest=plane.attrs["configuration_hash"],
        attributes={axis.name: plane[axis.name].attrs for axis in (plan.parameter, plan.sweep)},
        labels=dict(zip(map(int, flags["flag_values"]), flags["labels"], strict=True)),
        domain=domain,
        n_stable=n_stable,
        open=plane["open"].values,
        dynamic=dynamic,
        unstable=np.any(static & (kind > Instability.NONE) & (kind < Instability.CONTRADICTORY), axis=2),
        contradictory=np.any(static & (kind == Instability.CONTRADICTORY), axis=2),
        status=plane["status"].values,
        points=points,
        n_points=n_points,
        end_reason=branches["end_reason"].values,
        boundaries=read_boundaries(path, plan),
        scales=scales_of(plan) if physical else None,
    )
