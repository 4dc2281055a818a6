"""Sliders of the fixed parameters, and the new plane that they make, computed beside the page when it is asked for."""

import html
from collections.abc import Callable

import panel as pn

from pipeline.errors import ConfigurationError
from pipeline.explorer.background_run import BackgroundRun, new_plane
from pipeline.explorer.fixed_parameters import FixedParameter, fixed_parameters
from pipeline.explorer.messages import note, text
from pipeline.explorer.plain_text import plain
from pipeline.explorer.quiet import Quiet
from pipeline.explorer.style import CARDS, TYPED, WIDGETS
from pipeline.explorer.view_state import ViewState
from pipeline.figures.naming import symbol
from pipeline.plan.plan import Plan
from pipeline.plan.scales import scales_of

__all__ = ["FixedPanel"]

#: Those that engineers change first; the others are folded away.
_FIRST = ("b", "alpha", "f_e", "f_pm", "f_pv", "xi_mesh", "omega", "gap", "mean_load", "excitation", "damping_ratio")
_STEPS, _EVERY = 200, 500


class FixedPanel:
    """A part of one page.

    Parameters
    ----------
    plan : Plan
    command : str
        Of the plane.
    run : BackgroundRun
        Of all pages.
    change : callable
        change(**values) changes the view.
    arrived : callable
        arrived(new_plane) is told of a plane that has been computed; gives the address that shows it.
    """

    def __init__(self, plan: Plan, command: str, run: BackgroundRun, change: Callable, arrived: Callable):
        self._plan, self._command, self._run = plan, command, run
        self._change, self._arrived = change, arrived
        self._parameters, self._quiet, self._watched = fixed_parameters(plan), Quiet(), None
        self._state = ViewState()
        self._sliders: dict[str, pn.widgets.EditableFloatSlider] = {}
        self.reset = pn.widgets.Button(name="Reset", width=70, stylesheets=[WIDGETS])
        self.compute = pn.widgets.Button(name="Compute this plane", width=150, stylesheets=[WIDGETS])
        self.reset.on_click(lambda _: self._change(fixed=()))
        self.compute.on_click(self._begin)
        self.told = text()
        self.bar = pn.indicators.Progress(
            value=0, max=100, active=False, visible=False, sizing_mode="stretch_width", height=12
        )
        self._first, self._others = (pn.Column(sizing_mode="stretch_width", margin=0) for _ in range(2))
        self._folded = pn.Card(
            self._others,
            title="more parameters",
            collapsed=True,
            sizing_mode="stretch_width",
            margin=(2, 5),
            stylesheets=[CARDS],
        )
        self._folded.param.watch(lambda _: self._fill(), "collapsed")
        self.view = pn.Column(
            self._first, self._folded, pn.Row(self.reset, self.compute, margin=0), self.told, self.bar, margin=0
        )

    def prepare(self) -> None:
        """Make the sliders, which take longer than all the rest of a page."""
        if not self._sliders:
            self._make(self._state.physical)
            self.show(self._state)
            if self._run.running:
                # Begun from another page.
                self._follow()

    def _make(self, physical: bool) -> None:
        self._physical, scales = physical, scales_of(self._plan) if physical else None
        self._scales = {
            one.name: scales[one.name] for one in self._parameters if scales is not None and one.name in scales
        }
        self._sizes = {one.name: 1.0 for one in self._parameters} | {n: s.shown for n, s in self._scales.items()}
        self._sliders = {one.name: self._slider(one) for one in self._parameters if one.name in _FIRST}
        self._first[:], self._others[:] = list(self._sliders.values()), []
        self._fill()

    def _fill(self) -> None:
        """Make those that are folded away, once they are looked at."""
        if not self._folded.collapsed and not len(self._others):
            more = {one.name: self._slider(one) for one in self._parameters if one.name not in _FIRST}
            self._sliders |= more
            self._others[:] = list(more.values())
            self._set(self._state)

    def _slider(self, one: FixedParameter) -> pn.widgets.EditableFloatSlider:
        unit = f" ({self._scales[one.name].unit})" if one.name in self._scales else ""
        ends = sorted((one.low * self._sizes[one.name], one.high * self._sizes[one.name]))
        slider = pn.widgets.EditableFloatSlider(
            name=f"{plain(symbol(one.name))}  {one.words}{unit}",
            start=ends[0],
            end=ends[1],
            fixed_start=ends[0],
            fixed_end=ends[1],
            step=(ends[1] - ends[0]) / _STEPS,
            value=one.value * self._sizes[one.name],
            sizing_mode="stretch_width",
            stylesheets=[WIDGETS],
            margin=(2, 5),
        )
        for typed in slider.select(pn.widgets.FloatInput):
            typed.stylesheets = [*typed.stylesheets, TYPED]
        slider.param.watch(lambda event: self._moved(one, event.new), "value")
        return slider

    def _moved(self, one: FixedParameter, shown: float | None) -> None:
        if self._quiet or shown is None:
            return
        value = min(max(float(f"{shown / self._sizes[one.name]:.6g}"), one.low), one.high)
        fixed = {**dict(self._state.fixed), one.name: value}
        if abs(value - one.value) <= 1e-9 * (one.high - one.low):
            del fixed[one.name]
        self._change(fixed=tuple(sorted(fixed.items())))

    def _set(self, state: ViewState) -> None:
        fixed = dict(state.fixed)
        with self._quiet:
            for one in self._parameters:
                slider, value = self._sliders.get(one.name), fixed.get(one.name, one.value)
                if slider is not None and slider.value != value * self._sizes[one.name]:
                    slider.value = value * self._sizes[one.name]

    def show(self, state: ViewState) -> None:
        """The values of a view."""
        if self._sliders and state.physical != self._physical:
            self._make(state.physical)
        self._state = state
        self._set(state)
        fixed = state.fixed
        self.reset.disabled = self.compute.disabled = not fixed
        if self._watched is None:
            told = "The map is of the stored plane; curves and motions are of the changed gear." if fixed else ""
            self.told.object = note(told, "note")

    def _begin(self, _) -> None:
        try:
            self._run.begin(new_plane(self._command, self._plan, dict(self._state.fixed)))
        except ConfigurationError as error:
            self.told.object = note(str(error))
            return
        self._follow()

    def _follow(self) -> None:
        """Show how far the run is, until it ends."""
        self.bar.param.update(visible=True, active=True, value=0)
        self._watched = pn.state.add_periodic_callback(self._look, period=_EVERY)

    def _look(self) -> None:
        run = self._run
        self.bar.value = int(100 * run.share)
        self.told.object = note(f"{run.plane.path.stem}: {run.line or 'begins'}", "note")
        if run.running:
            return
        self._watched.stop()
        self._watched = None
        self.bar.param.update(visible=False, active=False)
        if run.succeeded:
            link = html.escape(self._arrived(run.plane), quote=True)
            self.told.object = (
                f'<div class="note">{html.escape(run.plane.path.stem)} is computed: '
                f'<a href="{link}" target="_blank">show it</a></div>'
            )
        else:
            self.told.object = note(f"{run.plane.path.stem}: {run.line or 'ended without a word'}")
