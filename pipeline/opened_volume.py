"""A stored volume opened: its layers are planes, with everything that a plane can be asked for."""

import numpy as np
import xarray as xr

from pipeline.config.places import Place
from pipeline.opened_plane import OpenPlane
from pipeline.opened_store import OpenStore
from pipeline.plane.boundaries import GROUP
from pipeline.plane.stored import read_stored
from pipeline.store.files import files_at
from solver.model.checks import finite_number

__all__ = ["OpenVolume", "opened_at"]


class OpenVolume(OpenStore):
    """A stored volume."""

    @property
    def values(self) -> np.ndarray:
        """Values of the third axis, at which the layers are."""
        return self.plan.parameter2.values

    def layer(self, value: float) -> OpenPlane:
        """The plane of the layer nearest to a value of the third axis, with its boundaries and attractors.

        Raises
        ------
        solver.ParameterError
            If the value lies outside of the volume.
        """
        axis = self.plan.parameter2
        value = finite_number(axis.name, value, at_least=axis.low, at_most=axis.high)
        index = int(np.abs(axis.values - value).argmin())
        return OpenPlane(self.stored.layer_at(index), self._tree_of(index))

    def _tree_of(self, index: int) -> xr.DataTree:
        name = self.plan.parameter2.name
        found = {}
        for group, node in (("/", self.tree), *self.tree.children.items()):
            dataset = node.to_dataset(inherit=False)
            found[group] = _curves_of(dataset, index) if group == GROUP else dataset.isel({name: index})
        return xr.DataTree.from_dict(found)


def _curves_of(boundaries: xr.Dataset, layer: int) -> xr.Dataset:
    """The curves of one layer."""
    here = boundaries["layer"].values == layer
    points = np.repeat(here, boundaries["row_size"].values)
    # A layer's digest of events is its own.
    digest = {"events_hash": boundaries.attrs["events_hash"][layer]}
    return boundaries.isel(curve=here, boundary_point=points).drop_vars("layer").assign_attrs(digest)


def opened_at(path: Place) -> OpenPlane | OpenVolume:
    """The plane or the volume of a store.

    Raises
    ------
    StoreError
        As `pipeline.open_plane`.
    """
    stored = read_stored(path)
    tree = xr.open_datatree(files_at(path).zarr(), engine="zarr")
    return OpenPlane(stored, tree) if stored.plan.parameter2 is None else OpenVolume(stored, tree)
