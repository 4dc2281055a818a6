"""A design point with tolerances: its margins, updated as it is dragged on the map or typed."""

from collections.abc import Callable

import panel as pn

from pipeline.explorer.answers import design_answer
from pipeline.explorer.later import Later
from pipeline.explorer.messages import note, text
from pipeline.explorer.opened import Content, Opened, said
from pipeline.explorer.plain_text import plain
from pipeline.explorer.quiet import Quiet
from pipeline.explorer.style import WIDGETS
from pipeline.explorer.view_state import ViewState
from pipeline.explorer.words import chip, margin_table, place_text
from pipeline.figures.naming import symbol
from pipeline.plan.scales import scales_of

__all__ = ["DesignPanel"]

_STEPS = 200


class DesignPanel:
    """A part of one page.

    Parameters
    ----------
    opened : Opened
    content : Content
    later : Later
    change : callable
        change(**values) changes the view.
    """

    def __init__(self, opened: Opened, content: Content, later: Later, change: Callable):
        self._opened, self._content, self._later, self._change = opened, content, later, change
        self._state, self._quiet, self._shown = ViewState(), Quiet(), None
        self.wanted = pn.widgets.Checkbox(name="Show a design point; drag it, and its edges", stylesheets=[WIDGETS])
        self.wanted.param.watch(self._toggled, "value")
        self.told = text()
        plan = content.plan
        self._tolerances = [
            pn.widgets.FloatInput(
                name=f"± {plain(symbol(axis.name))}",
                start=0.0,
                end=0.5 * (axis.high - axis.low),
                step=(axis.high - axis.low) / _STEPS,
                value=0.0,
                width=105,
                stylesheets=[WIDGETS],
            )
            for axis in (plan.sweep, plan.parameter)
        ]
        for number, widget in enumerate(self._tolerances):
            widget.param.watch(lambda event, number=number: self._typed(number, event.new), "value")
        self._row = pn.Row(*self._tolerances, visible=False, margin=0)
        self.view = pn.Column(self.wanted, self._row, self.told, margin=0, sizing_mode="stretch_width")

    def show(self, state: ViewState) -> None:
        """The design point of a view."""
        self._state = state
        with self._quiet:
            self.wanted.value = self._row.visible = state.design is not None
            for widget, value in zip(self._tolerances, state.tolerances, strict=True):
                widget.value = value
        if self._shown == (state.design, state.tolerances, state.physical):
            return
        self._shown = state.design, state.tolerances, state.physical
        if state.design is None:
            self._later.forget("margins")
            self.told.object = ""
            return
        if not self.told.object:
            self.told.object = note("Margins are computed …", "note")
        content, point, tolerances = self._content, state.design, state.tolerances

        def work():
            self._opened.ready.wait()
            return design_answer(content.path, content.plan, point, tolerances)

        self._later.ask("margins", work, self._show_answer, self._failed)

    def _show_answer(self, found) -> None:
        plan = self._content.plan
        scales = scales_of(plan) if self._state.physical else None
        where = place_text(plan, (found.design.x, found.design.p), scales)
        worst = {label for corner in found.corners for label in corner.labels}
        labels = (
            " ".join(chip(label) for corner in found.corners for label in corner.labels) if worst else "not decided"
        )
        spread = any(self._state.tolerances)
        self.told.object = (
            f"<p><b>{where}</b> {chip(found.label)}</p>"
            + (f"<p>Within the tolerances, the worst first: {labels}</p>" if spread else "")
            + margin_table(found.margins, plan, scales)
            + "".join(f"<p class='quiet'>{text}</p>" for text in found.sentences[:1])
        )

    def _failed(self, error: Exception) -> None:
        self.told.object = note(said(error, self._opened.path))

    def _toggled(self, event) -> None:
        if self._quiet:
            return
        if not event.new:
            self._change(design=None)
            return
        sweep, parameter = self._content.plan.sweep, self._content.plan.parameter
        middle = (0.5 * (sweep.low + sweep.high), 0.5 * (parameter.low + parameter.high))
        self._change(design=self._state.at or middle)

    def _typed(self, number: int, value: float | None) -> None:
        if not self._quiet and value is not None:
            tolerances = list(self._state.tolerances)
            tolerances[number] = float(value)
            self._change(tolerances=tuple(tolerances))
