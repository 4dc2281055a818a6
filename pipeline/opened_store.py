"""What an opened plane and an opened volume have in common: what is stored, as xarray shows it, and what it is."""

import html
from dataclasses import dataclass

import xarray as xr

from pipeline.config.places import Place
from pipeline.plan.plan import Plan
from pipeline.plane.stored import StoredPlane

__all__ = ["OpenStore"]


@dataclass(frozen=True, eq=False)
class OpenStore:
    """A store that is open.

    Parameters
    ----------
    stored : StoredPlane
        The arrays of rows, read when they are used.
    tree : xarray.DataTree
        Everything that is stored, as xarray shows it; read when it is used.
    """

    stored: StoredPlane
    tree: xr.DataTree

    @property
    def path(self) -> Place:
        """The store."""
        return self.stored.path

    @property
    def name(self) -> str:
        """Of the store."""
        return self.path.stem

    @property
    def plan(self) -> Plan:
        """What was computed."""
        return self.stored.plan

    @property
    def attributes(self) -> dict:
        """Of the store: title, configuration, versions, time of creation."""
        return self.stored.about

    def __repr__(self) -> str:
        sizes = " x ".join(f"{axis.name} {axis.num}" for axis in self.plan.axes)
        return f"{type(self).__name__}({self.name!r}: {sizes}; {', '.join(sorted(self.tree.children))})"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(self.describe())}</pre>"

    def describe(self) -> str:
        """What it is, in a line."""
        return repr(self)

    def to_xarray(self) -> xr.DataTree:
        """Everything that is stored, read into memory: the raster at the root, and the groups by name.

        Returns
        -------
        xarray.DataTree
            A copy, which may be changed: the store is not.
        """
        return self.tree.copy(deep=False).load()
