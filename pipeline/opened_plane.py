"""A stored plane opened for questions: labels, masks, curves, motions, boundaries, whatever the store's layout.

An object around the DataTree, not an accessor on it: the answers need the store's path and its checked plan, which a
tree does not carry, and an accessor would be looked up by a name that no editor knows.
"""

import xarray as xr

from pipeline.analysis.margins.distances import Margin
from pipeline.config.quantities import READ
from pipeline.errors import StoreError
from pipeline.figures.plots import Plots
from pipeline.opened_store import OpenStore
from pipeline.plan.layers import layer_name
from pipeline.plan.scales import scales_of
from pipeline.plane.datasets import dataset_of_branches, dataset_of_motions
from pipeline.plane.labels import TRAITS
from pipeline.plane.motions import MOTION, proven_label, solved_motions
from pipeline.plane.places import cell_of, nearest, place_of, value_of
from pipeline.plane.row_curves import solved_curves, stored_row
from pipeline.plane.summary import summary_of
from solver import ParameterError, Scales, domain_label
from solver.model.checks import instance_of
from solver.regions.regions import Occurrence

__all__ = ["OpenPlane"]


class OpenPlane(OpenStore):
    """A stored plane.

    Places are given by the axes' own names: `omega=0.6, f_e=0.2`. What ends in `_near` reads the nearest stored cell or
    row; what ends in `_at` computes anew, exactly there, except for attractors, which are stored.

    Examples
    --------
    >>> import tempfile, pipeline
    >>> from pathlib import Path
    >>> from pipeline import store
    >>> from pipeline.analysis import boundaries
    >>> from pipeline.config.compose import compose
    >>> from pipeline.plan.planning import plan
    >>> from pipeline.run.rows import sweep_block
    >>> swept = plan(compose(["plane=omega_fe", "plane.sweep.num=79", "plane.parameter.num=9"]))
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = Path(folder.name) / "omega_fe.zarr"
    >>> store.create(path, swept, "omega_fe", "")
    >>> for block in swept.blocks:
    ...     _ = sweep_block(str(path), swept, block)
    >>> _ = boundaries.trace(path, swept)

    >>> plane = pipeline.open_plane("omega_fe", root=folder.name)
    >>> plane
    OpenPlane('omega_fe': omega 79 x f_e 9; boundaries, branches)
    >>> plane.label_near(omega=0.6, f_e=0.2), plane.label_at(omega=0.6, f_e=0.2)
    ('2/0-1', '2/0-1')
    >>> mask = plane.mask("jump")
    >>> mask.dims, bool(mask.sel(omega=0.6, f_e=0.2, method="nearest"))
    (('f_e', 'omega'), True)
    >>> plane.motions_at(omega=0.6, f_e=0.2).amplitude.values.round(8).tolist()
    [0.4004013, 1.29089291, 1.79064815]
    >>> plane.motions_at(omega=0.6, f_e=0.2).dynamic_factor.values.round(4).tolist()
    [1.9376, 3.0994, 2.6937]
    >>> curve = plane.curve_at(f_e=0.2)
    >>> curve.omega.values[curve.event.values == 1].round(6).tolist()
    [0.634641, 0.559374, 1.229708, 1.22381]
    >>> nearest = plane.nearest_boundaries(omega=0.6, f_e=0.2)[0]
    >>> nearest.name, nearest.kind.name, round(nearest.place, 6), plane.label_of(nearest.beyond)
    ('omega', 'MIN_AT_BACK', 0.567178, '2/0-2')
    >>> [round(found.appears, 4) for found in plane.thresholds("2/0-2")]
    [0.1976]
    >>> folder.cleanup()
    """

    @property
    def name(self) -> str:
        """Of the store; of a layer as `plane.layer` calls what it takes out."""
        name, stored = self.path.stem, self.stored
        return name if stored.layer is None else layer_name(name, stored.volume, stored.layer)

    def describe(self) -> str:
        """What the plane is, and what is stored of it: a few lines."""
        return "\n".join([repr(self), *summary_of(self.stored, self.tree.children)])

    @property
    def plot(self) -> Plots:
        """Figures: `plane.plot.map()`, `plane.plot.curves(f_e=0.2)`, `plane.plot.backbone()`."""
        return Plots(self.path, self.plan, self.stored.layer)

    def explore(self, view: str = ""):
        """The plane to be clicked, in a notebook: as `stages=[explore]` shows it in a page of its own.

        Parameters
        ----------
        view : str
            What is shown first, as a page's address has it: "layer=dynamic&at=0.6,0.2".

        Returns
        -------
        panel.viewable.Viewable

        Raises
        ------
        ConfigurationError
            If Panel or Bokeh are not installed, or there is no such view.
        solver.ParameterError
            If the view is no text.
        """
        instance_of("view", view, str)
        from pipeline.explorer.stage import check_installed

        check_installed()
        if self.stored.layer is not None:
            raise StoreError(f"explore is not allowed for a layer of {self.path}: plane.layer=VALUE takes out a plane")
        from pipeline.explorer.notebook import in_notebook

        return in_notebook(self.path, view)

    @property
    def labels(self) -> dict[int, str]:
        """Code -> n/I label, as in `domain`."""
        return self.stored.labels

    def label_of(self, code: int) -> str:
        """The n/I label of a code; empty for 0, a label that is not known.

        Raises
        ------
        solver.ParameterError
            If it is no code.
        """
        return domain_label(code)

    def label_near(self, **place: float) -> str:
        """The label of the nearest stored cell; empty where its row has not been computed.

        Raises
        ------
        solver.ParameterError
            If the place is not given by the names of both axes, or lies outside of the plane.
        """
        return self.labels[int(self.stored.domain[cell_of(self.plan, place)])]

    def label_at(self, **place: float) -> str:
        """The label at a point, every solution there enumerated with proof.

        Raises
        ------
        StoreError
            If the plane is of a higher order, of which solutions cannot be enumerated.
        ArithmeticError
            If the solutions there are not proven to be all, as on a boundary.
        solver.ParameterError
            As `label_near`.
        """
        if not self.plan.is_first_order:
            raise StoreError(
                f"{self.path} is of order {self.plan.solver['order']}, of which solutions cannot be enumerated: "
                "label_near reads the stored one"
            )
        return proven_label(self.plan, *place_of(self.plan, place))

    def mask(self, what: str) -> xr.DataArray:
        """Where a label ("2/0-1") or a trait ("jump", "contact loss", "double-sided impact") occurs.

        Returns
        -------
        (row, column) bool DataArray
            False as well where nothing has been computed.

        Raises
        ------
        solver.ParameterError
            If it is neither a label that the plane may have nor a trait.
        """
        known = {label: code for code, label in self.labels.items() if label}
        if not isinstance(what, str) or what not in known and what not in TRAITS:
            raise ParameterError("what", what, f"a label n/I such as 2/0-1, or one of {', '.join(TRAITS)}")
        codes = [known[what]] if what in known else [code for label, code in known.items() if TRAITS[what](label)]
        domain = self.tree["domain"]
        return domain.isin(codes).rename("mask").assign_attrs(long_name=what)

    def curve_near(self, *, physical: bool = False, **value: float) -> xr.Dataset:
        """The branches of the nearest stored row.

        Parameters
        ----------
        physical : bool
            Whether everything that has a unit is in it (µm, m/s, N, rpm), instead of dimensionless.
        **value : float
            Of the row parameter, by its name; dimensionless.

        Returns
        -------
        Dataset
            Along `point`: the swept parameter, every quantity of `motions_at`, `cos` and `sin` of the fundamental,
            `stable`, `impact`, `branch` (which connected curve), `event`.

        Raises
        ------
        StoreError
            If that row has not been computed.
        solver.ParameterError
            If the value is not given by the name of the row parameter, or lies outside of the plane, or physical
            values are asked for of a dimensionless gear.
        """
        row = nearest(self.plan.parameter, value_of(self.plan.parameter, value))
        if not self.stored.complete[row]:
            raise StoreError(f"row {row} of {self.path} is not complete: stages=[sweep] computes it")
        return dataset_of_branches(stored_row(self.stored, row), self._scales(physical))

    def curve_at(self, *, physical: bool = False, **value: float) -> xr.Dataset:
        """The branches at exactly one value of the row parameter, computed anew; as `curve_near` gives them.

        Raises
        ------
        solver.RowError
            If a branch cannot be followed.
        solver.ParameterError
            As `curve_near`.
        """
        p = value_of(self.plan.parameter, value)
        return dataset_of_branches(solved_curves(self.plan, p), self._scales(physical))

    def motions_near(self, *, physical: bool = False, **place: float) -> xr.Dataset:
        """The stored motions of the nearest cell; as `motions_at` gives them.

        Raises
        ------
        solver.ParameterError
            As `motions_at`.
        """
        row, column = cell_of(self.plan, place)
        cell = {self.plan.parameter.name: row, self.plan.sweep.name: column}
        here = {name: self.tree[name].isel(cell).values for name in (*MOTION, *(one.name for one in READ))}
        there = here["stable"] >= 0
        values = {name: array[there] for name, array in here.items()}
        places = {axis.name: float(axis.values[cell[axis.name]]) for axis in (self.plan.sweep, self.plan.parameter)}
        return dataset_of_motions(self.plan, values, places, self._scales(physical))

    def motions_at(self, *, physical: bool = False, **place: float) -> xr.Dataset:
        """Every motion at a point, on or off the grid, computed anew: at first order enumerated with proof, at higher
        orders those of the row through the point.

        Parameters
        ----------
        physical : bool
            Whether everything that has a unit is in it (µm, m/s, N, rpm), instead of dimensionless.
        **place : float
            Values of both axes, by their names; dimensionless.

        Returns
        -------
        Dataset
            Along `solution`, by ascending amplitude of the fundamental: `mean`, `amplitude`, `phase`; `lowest`,
            `highest`, `rms`, `peak_to_peak` of the mesh displacement; the same of the dynamic transmission error,
            `error_lowest`, ...; `dynamic_factor`, `contact_loss`, `impact_velocity`, `support_force`; `stable`,
            `impact`, `instability`, `multiplier`. `attrs` of each has `long_name` and `units`.

        Raises
        ------
        ArithmeticError
            If at first order the solutions are not proven to be all, as on a boundary.
        solver.RowError
            If a branch of the row cannot be followed.
        solver.ParameterError
            As `label_near`, or if physical values are asked for of a dimensionless gear.
        """
        x, p = place_of(self.plan, place)
        places = {self.plan.sweep.name: x, self.plan.parameter.name: p}
        return dataset_of_motions(self.plan, solved_motions(self.plan, x, p), places, self._scales(physical))

    def nearest_boundaries(self, **place: float) -> tuple[Margin, ...]:
        """Changes of label met from a point along either axis and in either direction, the nearest first.

        Returns
        -------
        tuple of pipeline.analysis.margins.distances.Margin
            Up to four, by distance as a share of the axis: `name` of the parameter, `kind` of boundary, `place`,
            `distance`, and `beyond`, the code of the label on the other side (0 where it is not decided).

        Raises
        ------
        StoreError
            If boundaries have not been traced.
        solver.ParameterError
            As `label_near`.
        """
        from pipeline.analysis.margins.nearest import nearest_margins

        x, p = place_of(self.plan, place)
        if self.stored.boundaries is None:
            raise StoreError(f"{self.path} has no boundaries: run stages=[boundaries] first")
        return nearest_margins(self.stored, x, p)

    def thresholds(self, label: str | None = None, window: tuple[float, float] | None = None) -> tuple[Occurrence, ...]:
        """Where labels appear and disappear in the row parameter; see `pipeline.thresholds`."""
        from pipeline.plane.regions import thresholds_of

        return thresholds_of(self.stored, label, window)

    def attractors_at(self, **place: float) -> xr.Dataset:
        """Everything that integration found in the integrated cell nearest to a place, along `attractor`, as it is
        stored: `kind`, `impact`, `share` of the random starts with its interval, amplitudes, forces, ...

        Raises
        ------
        StoreError
            If attractors have not been sought.
        solver.ParameterError
            As `label_near`.
        """
        queries, (x, p) = _queries(), place_of(self.plan, place)
        return queries.attractors_near(self._attractors(), self.plan, x, p)

    def isolated_branches(self, **value: float) -> xr.Dataset:
        """The branches that the integrated row nearest to a value of the row parameter lacks, along `isolated_point`.

        They are followed from attractors (`attractors.branches`): isolas, and motions of several mesh periods.

        Returns
        -------
        Dataset
            `branch`, `period` and `closed` of every point; amplitudes, `stable`, `instability`, `event`, ...

        Raises
        ------
        StoreError
            If they have not been sought.
        solver.ParameterError
            If it is no value of the row parameter, or outside of its range.
        """
        from pipeline.analysis.attractors.isolated import isolated_near, read_isolated

        p, found = value_of(self.plan.parameter, value), read_isolated(self.path)
        if found is None:
            raise StoreError(
                f"{self.path} has no isolated branches: run stages=[attractors] attractors.branches=5 first"
            )
        return isolated_near(found, self.plan, p)

    def hysteresis(self) -> xr.DataArray:
        """Where runs along the row meet other attractors upwards than downwards, bool; raises as `attractors_at`."""
        queries = _queries()
        return queries.hysteresis(self._attractors())

    def basin_share(self, what: str) -> xr.Dataset:
        """Share of the random starts of every cell that reached attractors of a kind, such as "2T" or "1T/0".

        Returns
        -------
        Dataset
            `share`, its 95 % interval `low` to `high`, `hits` and `starts`; the attribute `bound` says what was missed.

        Raises
        ------
        StoreError
            As `attractors_at`.
        solver.ParameterError
            If it is no kind of attractor.
        """
        queries = _queries()
        return queries.basin_share(self._attractors(), what)

    def _attractors(self) -> xr.Dataset:
        """The group `attractors`, of a layer its part."""
        found, stored = _queries().attractors_of(self.path), self.stored
        return found if stored.layer is None else found.isel({stored.volume.parameter2.name: stored.layer})

    def _scales(self, physical: bool) -> Scales | None:
        """To show values in physical units; None unless they are asked for."""
        if not instance_of("physical", physical, bool):
            return None
        scales = scales_of(self.plan)
        if scales is None:
            raise ParameterError("physical", physical, "false: the gear of this plane is dimensionless")
        return scales


def _queries():
    """Questions to attractors, which need the kernels of integration: a map alone is opened without."""
    from pipeline.analysis.attractors import queries

    return queries
