"""A study opened: its planes, and all of them together as xarray has it."""

import html
import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr

from pipeline import store
from pipeline.config.places import Place
from pipeline.errors import StoreError
from pipeline.multirun.index import Index
from pipeline.opened_plane import OpenPlane
from pipeline.opened_volume import OpenVolume, opened_at
from pipeline.plan.plan import Plan
from pipeline.plane.stored import read_stored
from pipeline.store.files import files_at
from pipeline.store.stored_arrays import open_arrays

__all__ = ["Study"]

#: Columns of the index that are numbers, and their type.
_NUMBERS = {
    **dict.fromkeys(("rows", "rows_complete", "cells", "cells_proven", "domains"), np.int64),
    **dict.fromkeys(("several_motions", "teeth_part", "back_flanks_struck"), np.float64),
}
#: An integer that is not known.
_UNKNOWN = -1


class _Planes(Mapping):
    """The planes of a study by the name of their store, each opened when it is first asked for."""

    def __init__(self, index: Index):
        self._root, self._opened = index.root, {}
        self._names = [name for name in index.planes if store.exists(index.root / f"{name}.zarr")]

    def __getitem__(self, name: str) -> OpenPlane | OpenVolume:
        if name not in self._names:
            raise KeyError(name)
        if name not in self._opened:
            self._opened[name] = opened_at(self._root / f"{name}.zarr")
        return self._opened[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"<planes {', '.join(self._names) or 'none'}>"


@dataclass(frozen=True, eq=False)
class Study:
    """The planes of one command `python -m pipeline -m KEY=VALUE,VALUE`.

    Parameters
    ----------
    listed : pipeline.multirun.index.Index
        What `study.csv` says.
    """

    listed: Index

    @property
    def root(self) -> Place:
        """The folder of its stores."""
        return self.listed.root

    @cached_property
    def planes(self) -> Mapping[str, OpenPlane | OpenVolume]:
        """The planes that have a store, by its name; each is opened when it is first asked for."""
        return _Planes(self.listed)

    @property
    def varied(self) -> dict[str, tuple]:
        """Key of the configuration -> its values, in the order of the command."""
        planes = self.listed.planes.values()
        return {
            one.key: tuple(dict.fromkeys(plane.values[number] for plane in planes))
            for number, one in enumerate(self.listed.varied)
        }

    @property
    def index(self) -> xr.Dataset:
        """`study.csv` along `store`: values of what varies, states of rows, and what the maps tell.

        Counts that are not known are -1, shares NaN.
        """
        planes = list(self.listed.planes.values())
        data: dict = {}
        names = self._names(planes[0].told if planes else ())
        for number, (one, name) in enumerate(zip(self.listed.varied, names, strict=True)):
            data[name] = ("store", [plane.values[number] for plane in planes], _attributes(one))
        for name in planes[0].told if planes else ():
            texts = [plane.told[name] for plane in planes]
            kind = _NUMBERS.get(name)
            unknown = np.nan if kind is np.float64 else _UNKNOWN
            data[name] = (
                "store",
                texts if kind is None else np.array([kind(t) if t else unknown for t in texts], kind),
            )
        return xr.Dataset(data, {"store": [plane.store for plane in planes]})

    def __repr__(self) -> str:
        varied = ", ".join(f"{key} {len(values)}" for key, values in self.varied.items()) or "nothing"
        states = [plane.told["status"] for plane in self.listed.planes.values()]
        counts = ", ".join(f"{states.count(state)} {state}" for state in dict.fromkeys(states))
        return f"Study({str(self.root)!r}: {len(states)} planes over {varied}; {counts or 'none'})"

    def _repr_html_(self) -> str:
        return f"<pre>{html.escape(repr(self))}</pre>{self.index._repr_html_()}"

    def to_datatree(self) -> xr.DataTree:
        """All planes in one tree: the index at the root, and every plane with all its groups by the name of its store.

        Returns
        -------
        xarray.DataTree
            What varies is a coordinate of every plane. Arrays are read when they are used.

        Raises
        ------
        StoreError
            If a store cannot be read.
        """
        children = {}
        for name in self.planes:
            tree = xr.open_datatree(files_at(self.root / f"{name}.zarr").zarr(), engine="zarr")
            values = zip(self.listed.varied, self._names(tree.dims), self.listed.planes[name].values, strict=True)
            tree.dataset = tree.to_dataset().assign_coords(
                {at: ((), value, _attributes(one)) for one, at, value in values}
            )
            children[name] = tree
        return xr.DataTree(self.index, children=children)

    def to_xarray(self) -> xr.Dataset:
        """The rasters of all planes along what varies, one dimension for every key.

        A combination of values of which nothing is stored has the values that a store has of rows that are not
        computed, `status` 0 among them, and an empty `store`.

        Returns
        -------
        xarray.Dataset
            Numbers are coordinates with their unit, names are texts. Arrays are read when they are used (by dask).

        Raises
        ------
        StoreError
            If no plane is stored, their axes differ, or two planes have the same values.
        """
        if not len(self.planes):
            raise StoreError(f"nothing of the study at {self.root} is stored: the command that made it goes on with it")
        plans = {name: read_stored(self.root / f"{name}.zarr").plan for name in self.planes}
        self._check_axes(plans)
        by_values: dict[tuple, str] = {}
        for name in self.planes:
            other = by_values.setdefault(self.listed.planes[name].values, name)
            if other != name:
                raise StoreError(
                    f"{self.root} has two planes for the same values, {other} and {name}: to_datatree() keeps them "
                    "apart"
                )
        opened = {name: xr.open_zarr(files_at(self.root / f"{name}.zarr").zarr(), chunks={}) for name in plans}
        first = next(iter(opened))
        absent = _not_computed(self.root / f"{first}.zarr", opened[first])
        names, values = self._names(opened[first].dims), list(self.varied.values())
        parts = [
            opened[by_values[place]].assign_coords(store=by_values[place])
            if place in by_values
            else absent.assign_coords(store="")
            for place in itertools.product(*values)
        ]
        # From the last dimension to the first: neighbours in the product differ in the last one.
        options = dict(
            data_vars="all", coords=["store"], compat="override", join="exact", combine_attrs="drop_conflicts"
        )
        for one, name, along in reversed(list(zip(self.listed.varied, names, values, strict=True))):
            places = xr.Variable(name, list(along), _attributes(one))
            count = len(along)
            parts = [
                xr.concat(parts[i : i + count], name, **options).assign_coords({name: places})
                for i in range(0, len(parts), count)
            ]
        (whole,) = parts
        kept = ("Conventions", "bevelmap_schema", "versions")
        attributes = {key: value for key, value in whole.attrs.items() if key in kept}
        return whole.drop_attrs(deep=False).assign_attrs(
            {**attributes, "title": f"Study of {', '.join(self.varied) or 'one plane'}"}
        )

    def _names(self, taken=()) -> list[str]:
        """Names for what varies: the last part of a key, or all of it where that is taken or not unique."""
        keys = [one.key for one in self.listed.varied]
        short = [key.rpartition(".")[2] for key in keys]
        return [
            name if short.count(name) == 1 and name not in taken else key.replace(".", "_")
            for key, name in zip(keys, short, strict=True)
        ]

    def _check_axes(self, plans: Mapping[str, Plan]) -> None:
        (first, plan), *others = plans.items()
        for name, other in others:
            if (other.axes, other.max_solutions, other.motion_size) != (
                plan.axes,
                plan.max_solutions,
                plan.motion_size,
            ):
                raise StoreError(
                    f"the planes of {self.root} have different axes ({_axes(plan)} of {first}, {_axes(other)} of "
                    f"{name}): to_datatree() has them side by side"
                )


def _attributes(one) -> dict:
    return {"long_name": one.key, **({} if one.unit is None else {"units": one.unit})}


def _axes(plan: Plan) -> str:
    sizes = " x ".join(f"{axis.name} {axis.low:g}...{axis.high:g} ({axis.num})" for axis in plan.axes)
    return f"{sizes}, room for {plan.max_solutions} solutions"


def _not_computed(path: Place, like: xr.Dataset) -> xr.Dataset:
    """A raster of which nothing is computed, in the shape of another: what its template holds."""
    arrays = open_arrays(path)
    return like.assign(
        {name: xr.full_like(array, arrays.layout(name).fill_value) for name, array in like.data_vars.items()}
    )
