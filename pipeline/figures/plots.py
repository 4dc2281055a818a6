"""The figures of an opened plane, as matplotlib figures for a notebook or a script."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.config.allowed import sentence_of
from pipeline.config.quantities import AMPLITUDE
from pipeline.config.schema import Figures
from pipeline.errors import ConfigurationError
from pipeline.figures.options import check_options
from pipeline.plan.plan import Plan
from solver.model.checks import finite_array

__all__ = ["Plots"]


@dataclass(frozen=True)
class Plots:
    """Figures of a stored plane; each call reads the store anew.

    Parameters
    ----------
    path : Path
        The store.
    plan : Plan
        Its plan.
    """

    path: Path
    plan: Plan

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
        self._check(None, window, stability, units, quantity, of)
        if quantity is not None and window is not None:
            raise ConfigurationError(f"window = {window} is not allowed: quantities are drawn over the whole plane")
        from pipeline.figures.drawing import own_style
        from pipeline.figures.map import draw_map, draw_window
        from pipeline.figures.quantity_map import draw_quantity_map

        plane = self._read(stability, units)
        with own_style():
            if quantity is not None:
                return draw_quantity_map(plane, quantity, of)
            return draw_map(plane) if window is None else draw_window(plane, window)

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
        name = self.plan.parameter.name
        if not values.keys() <= {name}:
            raise ConfigurationError(f"curves = {values} is not allowed: rows of this plane are chosen by {name}")
        chosen = values.get(name)
        if chosen is not None:
            chosen = finite_array(name, chosen, None).ravel().tolist()
        self._check(chosen, None, "static", units, quantity)
        from pipeline.figures.curves import draw_curves
        from pipeline.figures.drawing import own_style

        plane = self._read("static", units)
        with own_style():
            return draw_curves(plane, chosen, quantity or AMPLITUDE.name)

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
            If the plane has none: its rows do not run over the mesh frequency, or there is no mean load.
        """
        self._check(None, None, "static", units)
        from pipeline.figures.backbone import draw_backbone, has_backbone
        from pipeline.figures.drawing import own_style

        plane = self._read("static", units)
        if not has_backbone(plane):
            raise ConfigurationError(
                "backbone is not allowed for this plane: its rows must run over omega, and f_pm must not be 0"
            )
        with own_style():
            return draw_backbone(plane)

    def _check(self, curves, window, stability: str, units: str, quantity: str | None = None, of: str = "worst"):
        words = {"stability": stability, "units": units, "quantity": quantity, "of": of}
        for name, value in words.items():
            if not isinstance(value, str) and (name, value) != ("quantity", None):
                raise ConfigurationError(
                    f"figures.{name} = {value!r} is not allowed: it must be {sentence_of(Figures, name)}"
                )
        check_options(self.plan, curves, ["png"], 100, window, stability, units, None, quantity, of)

    def _read(self, stability: str, units: str):
        from pipeline.plane.stored import read_stored

        return read_stored(self.path, stability == "dynamic", units == "physical")
