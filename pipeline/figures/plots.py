"""The figures of an opened plane, as matplotlib figures for a notebook or a script."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real

from pipeline.analysis.attractors.options import check_box
from pipeline.config.allowed import sentence_of
from pipeline.config.compose import compose
from pipeline.config.places import Place
from pipeline.config.quantities import AMPLITUDE
from pipeline.config.schema import Attractors, Figures
from pipeline.errors import ConfigurationError, refused
from pipeline.figures.options import check_options, figure_options
from pipeline.plan.plan import Plan
from pipeline.plane.stored import StoredPlane, read_stored
from solver import ParameterError
from solver.model.checks import finite_array, finite_number

__all__ = ["Plots"]


@dataclass(frozen=True)
class Plots:
    """Figures of a stored plane; each call reads the store anew.

    Parameters
    ----------
    path : Place
        The store.
    plan : Plan
        Its plan; of the layer, where it is one.
    layer : int or None
        Number of the layer in a volume.
    """

    path: Place
    plan: Plan
    layer: int | None = None

    def map(
        self,
        window: Sequence[float] | None = None,
        stability: str = "static",
        units: str = "dimensionless",
        quantity: str | None = None,
        of: str = "worst",
    ):
        """The n/I map, or a part of it alone; or a quantity of the motions over the plane.

        Parameters
        ----------
        window : (x low, x high, p low, p high), optional
            The part, on the sweep axis and on the parameter axis.
        stability : str
            Which motions labels count: "static" or "dynamic".
        units : str
            Of the axes: "dimensionless" or "physical".
        quantity : str, optional
            What is drawn instead of labels, such as "dynamic_factor", "rms" or "support_force": any quantity that
            `plane.motions_at` tells, by its name.
        of : str
            Where several motions coexist that the label counts: "worst", the largest value, or "mildest", the
            smallest.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ConfigurationError
            If an option is not allowed for this plane.
        solver.ParameterError
            If the window is no four numbers.
        """
        window = None if window is None else finite_array("window", window, (4,)).tolist()
        self._check(units, window=window, stability=stability, quantity=quantity, of=of)
        from pipeline.figures.map import draw_map, draw_window
        from pipeline.figures.quantity_map import draw_quantity_map

        def drawn(plane: StoredPlane):
            if quantity is not None:
                return draw_quantity_map(plane, quantity, of, window)
            return draw_map(plane) if window is None else draw_window(plane, window)

        return self._drawn(drawn, units, stability)

    def curves(self, units: str = "dimensionless", quantity: str | None = None, **values: float | Sequence[float]):
        """A quantity and the mean over the sweep axis at some values of the row parameter.

        Parameters
        ----------
        units : str
            As for `map`.
        quantity : str, optional
            As for `map`; the amplitude of the fundamental unless given.
        **values : float or sequence of float
            Of the row parameter, by its name, such as `f_e=0.2` or `f_e=[0.1, 0.2]`, solved where no row has them; a
            quarter, half and three quarters of the way unless given.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ConfigurationError
            If another parameter is named, or a value lies outside the plane.
        solver.ParameterError
            If a value is no finite number.
        """
        chosen = self._rows("curves", values)
        self._check(units, chosen, quantity=quantity)
        from pipeline.figures.curves import draw_curves

        return self._drawn(lambda plane: draw_curves(plane, chosen, quantity or AMPLITUDE.name), units)

    def multipliers(self, units: str = "dimensionless", **values: float | Sequence[float]):
        """Floquet multipliers along the branches at some values of the row parameter.

        Parameters
        ----------
        units : str
            As for `map`.
        **values : float or sequence of float
            Of the row parameter, by its name, such as `f_e=0.2` or `f_e=[0.1, 0.2]`, solved where no row has them.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ConfigurationError
            If no value or another parameter is named, or a value lies outside the plane.
        solver.ParameterError
            If a value is no finite number.
        """
        chosen = self._rows("multipliers", values)
        if not chosen:
            raise ConfigurationError(
                f"multipliers = {values} is not allowed: it must name a value of {self.plan.parameter.name}"
            )
        self._check(units, multipliers=chosen)
        from pipeline.figures.multipliers import draw_multipliers

        return self._drawn(lambda plane: draw_multipliers(plane, chosen), units)

    def backbone(self, units: str = "dimensionless"):
        """Backbones of the free vibration, and the largest stable amplitude near each resonance over the rows.

        Parameters
        ----------
        units : str
            As for `map`.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ConfigurationError
            If the plane has none: its rows do not run over the mesh frequency, there is no mean load, or it is of a
            system that is no bevel pair.
        """
        self._check(units)
        from pipeline.figures.backbone import draw_backbone, has_backbone

        def drawn(plane: StoredPlane):
            if not has_backbone(plane):
                raise ConfigurationError(
                    "backbone is not allowed for this plane: its rows must run over omega, those of a bevel pair, and "
                    "f_pm must not be 0"
                )
            return draw_backbone(plane)

        return self._drawn(drawn, units)

    def motion(self, units: str = "dimensionless", attractors: Mapping[str, object] | None = None, **place: float):
        """Every motion at a point, computed anew: time history, mesh force, phase portrait and spectrum of each.

        Parameters
        ----------
        units : str
            As for `map`.
        attractors : mapping, optional
            Settings of the search for attractors by name, such as `{"starts": 100}`: the keys of `attractors` in the
            configuration. Others are as they are there.
        **place : float
            By the axes' own names, such as `omega=0.64, f_e=0.3`.

        Returns
        -------
        matplotlib.figure.Figure
            With a card for each motion.

        Raises
        ------
        ConfigurationError
            If an option is not allowed for this plane, or it is a volume.
        solver.ParameterError
            If the place is not given by the names of both axes, or lies outside of the plane.
        solver.RowError
            If the balance leaves the mean open there.
        """
        axes = (self.plan.sweep, self.plan.parameter)
        if self.plan.parameter2 is not None:
            raise ConfigurationError("motion is not allowed for a volume: plane.layer=VALUE takes out a plane")
        if set(place) != {axis.name for axis in axes}:
            raise ParameterError("place", place, f"given by {axes[0].name} and {axes[1].name}, each with a value")
        x, p = (finite_number(a.name, place[a.name], at_least=a.low, at_most=a.high) for a in axes)
        self._check(units)
        settings = _search_settings(attractors)
        from pipeline.analysis.motion.motions import motions_at
        from pipeline.figures.motion import draw_motions

        return self._drawn(lambda plane: draw_motions(plane, motions_at(self.plan, x, p, settings)), units)

    def diagram(
        self, units: str = "dimensionless", columns: int | None = None, max_periods: int | None = None, **value: float
    ):
        """What one motion does along a row, up from rest and down from there, integrated anew.

        Parameters
        ----------
        units : str
            As for `map`.
        columns : int, optional
            Steps of each direction; the columns of the plane, at least 400, unless given.
        max_periods : int, optional
            Forcing periods of a step; as the configuration has it unless given.
        **value : float
            Of the row parameter, by its name, such as `f_e=0.3`.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ConfigurationError
            If an option is not allowed for this plane, or it is a volume.
        """
        options = self._along("diagram", value, units, columns=columns, max_periods=max_periods)
        from pipeline.analysis.diagram.following import follow
        from pipeline.analysis.diagram.options import way_of
        from pipeline.figures.diagram import draw_diagram
        from pipeline.plane.row_curves import curves_at

        way = way_of("diagram", options, self.plan)
        return self._drawn(
            lambda plane: draw_diagram(plane, follow(self.plan, way), curves_at(plane, way.value)), units
        )

    def spectrum(
        self,
        direction: str = "up",
        of: str = "displacement",
        axis: str = "frequency",
        orders: float = 10.0,
        periods: int = 24,
        units: str = "dimensionless",
        columns: int | None = None,
        max_periods: int | None = None,
        **value: float,
    ):
        """Amplitudes over the swept parameter and over frequency or order, along such a row.

        Parameters
        ----------
        direction : str
            "up" or "down".
        of : str
            "displacement" of the mesh, or mesh "force".
        axis : str
            What is drawn upwards: "frequency" or "order".
        orders : float
            Highest order of the mesh frequency.
        periods : int
            Forcing periods of a record: orders are multiples of one over it.
        units, columns, max_periods, **value
            As for `diagram`.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ConfigurationError
            As `diagram`.
        """
        own = {"direction": direction, "of": of, "axis": axis, "orders": orders, "periods": periods}
        own |= {"columns": columns, "max_periods": max_periods}
        options = self._along("spectrum", value, units, **own)
        from pipeline.analysis.diagram.following import follow
        from pipeline.analysis.diagram.options import spectrum_of
        from pipeline.analysis.diagram.spectra import spectra_of
        from pipeline.figures.spectrum import draw_spectrum

        asked = spectrum_of(options, self.plan)
        return self._drawn(lambda plane: draw_spectrum(plane, spectra_of(follow(self.plan, asked.way), asked)), units)

    def _along(self, key: str, value: dict, units: str, **own):
        """Settings of a row that is followed, what is None as the configuration has it."""
        name = self.plan.parameter.name
        if self.plan.parameter2 is not None:
            raise ConfigurationError(f"{key} is not allowed for a volume: plane.layer=VALUE takes out a plane")
        if set(value) != {name}:
            raise ConfigurationError(f"{key} = {value} is not allowed: rows of this plane are chosen by {name}")
        self._check(units)
        typed = [f"{key}.{setting}={given}" for setting, given in own.items() if given is not None]
        given = value[name]
        given = float(given) if isinstance(given, Real) and not isinstance(given, int) else given
        return dataclasses.replace(getattr(compose(typed).config, key), value=given)

    def _rows(self, key: str, values: dict) -> list[float] | None:
        """Values of the row parameter that a figure is asked for by its name; None where there are none."""
        name = self.plan.parameter.name
        if not values.keys() <= {name}:
            raise ConfigurationError(f"{key} = {values} is not allowed: rows of this plane are chosen by {name}")
        chosen = values.get(name)
        return None if chosen is None else finite_array(name, chosen, None).ravel().tolist()

    def _check(self, units: str, curves: list[float] | None = None, **further) -> None:
        options = figure_options(curves, ["png"], 100, units=units, **further)
        for name in ("stability", "units", "quantity", "of"):
            value = getattr(options, name)
            if not isinstance(value, str) and (name, value) != ("quantity", None):
                raise refused(f"figures.{name}", value, sentence_of(Figures, name))
        check_options(self.plan, options)

    def _drawn(self, draw: Callable[[StoredPlane], object], units: str, stability: str = "static"):
        """The figure that `draw` makes of the plane."""
        from pipeline.figures.drawing import own_style

        stored = read_stored(self.path, stability == "dynamic", units == "physical")
        with own_style():
            return draw(stored if self.layer is None else stored.layer_at(self.layer))


def _search_settings(given: Mapping[str, object] | None) -> Attractors:
    """Settings of the search for attractors, those that are not given as the configuration has them."""
    given = {} if given is None else given
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        raise ParameterError("attractors", given, "settings by name, such as {'starts': 100}")
    values = [f"attractors.{key}={'null' if value is None else value}" for key, value in given.items()]
    settings = compose(values).config.attractors
    check_box(settings.box)
    return settings
