"""What is shown of one place: its row, every motion with its stability, one of them in time, and basins on demand."""

import functools
from collections.abc import Callable

import panel as pn
from bokeh.layouts import column, row
from bokeh.models import Span

from pipeline.analysis.motion.motions import Motion, Motions
from pipeline.analysis.motion.wording import quantity_line, standing
from pipeline.explorer import answers
from pipeline.explorer.curves_figure import curves_figure, fill_curves
from pipeline.explorer.later import Later
from pipeline.explorer.legend import listed
from pipeline.explorer.map_frame import frame_of_map
from pipeline.explorer.messages import note, text
from pipeline.explorer.motion_figures import fill_motions, motion_figures
from pipeline.explorer.opened import Content, Opened, said
from pipeline.explorer.plain_figure import source_of
from pipeline.explorer.quiet import Quiet
from pipeline.explorer.state_plane import fill_states, state_plane
from pipeline.explorer.style import WIDGETS
from pipeline.explorer.view_state import ViewState
from pipeline.explorer.words import chip, found_by_integration, motion_table, place_text
from pipeline.figures.motion_axes import units_of
from pipeline.plan.scales import scales_of
from pipeline.plane.motions import SolvedMotions, label_of
from pipeline.plane.row_curves import RowCurves

__all__ = ["PlaceColumn"]

#: What stands for an initial state of the reader's own among the motions.
_OWN = "own"
#: Pixels of the row, of each figure of a motion, and of the plane of states; the place in the row.
_ROW, _CARD, _STATES = 250, 190, 300
_HERE = {"line_color": "#d7301f", "line_width": 1, "line_dash": "dashed"}


class PlaceColumn:
    """A column of a page.

    Parameters
    ----------
    opened : Opened
    later : Later
    name : str
        Tells apart the columns of a page.
    change : callable or None
        change(**values) changes the view, where the reader asks for something within the column; None where the column
        only shows.
    button : panel widget, optional
        Beside the heading.
    """

    def __init__(self, opened: Opened, later: Later, name: str, change: Callable | None, button=None):
        self._opened, self._later, self._name, self._change = opened, later, name, change
        self._place_of = self._card_of = self._plane_of = None
        self._found: Motions | None = None
        self._quiet = Quiet()
        self._line = Span(dimension="height", **_HERE)
        # Each holds figures that are made once and then filled with what there is at a place.
        self.heading, self.verdict, self.motions, self.told = text(), text(), text(), text()
        self.row, self.card, self.states = (column(sizing_mode="stretch_width") for _ in range(3))
        self.row_legend, self.card_legend, self.states_told = text(), text(), text()
        self.which = pn.widgets.Select(name="In time, integrated", width=200, stylesheets=[WIDGETS])
        self.slice = pn.widgets.Toggle(name="Basins", width=80, margin=(23, 5, 5, 5), stylesheets=[WIDGETS])
        self.which.param.watch(self._chosen, "value")
        self.slice.param.watch(self._toggled, "value")
        head = self.heading if button is None else pn.Row(self.heading, button, sizing_mode="stretch_width", margin=0)
        parts = [head, self.verdict, _pane(self.row), self.row_legend, self.motions]
        if change is not None:
            parts.append(pn.Row(self.which, self.slice, margin=0))
        self.view = pn.Column(
            *parts,
            self.told,
            self.card_legend,
            _pane(self.card),
            self.states_told,
            _pane(self.states),
            sizing_mode="stretch_width",
            margin=(0, 6),
            css_classes=["place", f"place-{name}"],
        )

    @functools.cached_property
    def _curves(self):
        drawn = curves_figure(height=_ROW, sizing_mode="stretch_width")
        drawn.add_layout(self._line)
        return drawn

    @functools.cached_property
    def _figures(self) -> dict:
        return motion_figures(height=_CARD, sizing_mode="stretch_width")

    @functools.cached_property
    def _plane(self):
        drawn = state_plane(height=_STATES, sizing_mode="stretch_width")
        source_of(drawn, "start").on_change("data", self._dragged)
        return drawn

    def prepare(self) -> None:
        """Have the figures of a place in the page before the first place is asked for."""
        _put(self.row, [self._curves])
        _put(self.card, _pairs(self._figures))

    def show(self, content: Content, state: ViewState, place: tuple[float, float]) -> None:
        """Show a place; what is shown already is left as it is."""
        self._content, self._state, self._at = content, state, place
        self._scales = scales_of(content.plan) if state.physical else None
        where = (id(content), state.fixed, place, state.physical)
        if self._place_of != where:
            self._place_of, self._found, self._card_of, self._plane_of = where, None, None, None
            self.heading.object = f"<h2>{place_text(content.plan, place, self._scales)}</h2>"
            if not self._opened.ready.is_set():
                self.verdict.object = note("Kernels are being loaded …", "note")
            self._ask("row", answers.row, place[1:], self._show_row, self._row_failed)
            self._ask("motions", answers.motions, place, self._show_motions, self._motions_failed)
        elif self._found is not None:
            self._show_card()
            self._show_states()

    def _ask(self, kind: str, function: Callable, where: tuple, then: Callable, failed: Callable | None = None) -> None:
        content, fixed = self._content, dict(self._state.fixed)

        def work():
            self._opened.ready.wait()
            return content.answers.ask(function, fixed, *where)

        self._later.ask(f"{self._name} {kind}", work, then, failed or self._failed)

    def _failed(self, error: Exception) -> None:
        self.told.object = note(said(error, self._opened.path))

    def _row_failed(self, error: Exception) -> None:
        self.row.visible, self.row_legend.object = False, ""
        self._failed(error)

    def _motions_failed(self, error: Exception) -> None:
        self.verdict.object = self.motions.object = ""
        self._no_card()
        self._failed(error)

    def _show_row(self, found: RowCurves) -> None:
        axis = frame_of_map(self._content.plane, self._state.physical).x
        self.row_legend.object = listed(fill_curves(self._curves, [found], axis, scales=self._scales))
        self._line.location = self._at[0] * axis.size
        _put(self.row, [self._curves])

    def _show_motions(self, found: SolvedMotions) -> None:
        label = label_of(found.stable, found.impact)
        self.verdict.object = f"<p>{chip(label)} <span class='quiet'>integration is asked …</span></p>"
        doubts = "".join(note(one, "note") for one in found.doubts)
        self.motions.object = motion_table(found, self._scales) + doubts
        self._ask(
            "integrated",
            answers.integrated,
            self._at,
            lambda motions: self._show_integrated(label, len(found.amplitude), motions),
        )

    def _show_integrated(self, label: str, count: int, found: Motions) -> None:
        self.verdict.object = f"<p>{chip(label)} {found_by_integration(found)}</p>"
        self._found = found
        options = {f"attractor {one.name}, {one.label}": one.name for one in found.attractors}
        options |= {f"from motion {i} of the map": str(i) for i in range(1, count + 1)}
        with self._quiet:
            self.which.options = {**options, "from a state of one's own": _OWN}
        self._show_card()
        self._show_states()

    def _show_card(self) -> None:
        """The motion in time that the view asks for."""
        state, found = self._state, self._found
        if self._card_of == (state.motion, state.start):
            return
        self._card_of = state.motion, state.start
        if state.start is not None:
            with self._quiet:
                self.which.value = _OWN
            self._ask("card", answers.ending_of_state, (*self._at, *state.start), self._show_ending)
            return
        by_letter = {one.name: one for one in found.attractors}
        chosen = state.motion or next(iter(by_letter), "1")
        if chosen in self.which.options.values():
            with self._quiet:
                self.which.value = chosen
        if chosen in by_letter:
            self._draw(by_letter[chosen], standing(by_letter[chosen], found))
        elif chosen.isdigit():
            self._ask("card", answers.ending_of_motion, (*self._at, int(chosen)), self._show_ending)
        else:
            self.told.object = note(f"There is no attractor {chosen} here.")
            self._no_card()

    def _show_ending(self, found: answers.Ending) -> None:
        start = f"λ = {found.start[0]:.4g}, λ' = {found.start[1]:.4g}"
        origin = f"From {start}" if found.of_map is None else f"From motion {found.of_map.number} of the map, {start}"
        if found.motion is None:
            self.told.object = note(f"{origin}, nothing settles.")
            self._no_card()
        else:
            self._draw(found.motion, f"{origin}, integration ends on {found.motion.label}")

    def _draw(self, motion: Motion, words: str) -> None:
        cards = [motion] if motion.of_map is None else [motion, motion.of_map]
        units = units_of(self._content.shown(self._state.physical), self._found)
        quantities, (_, *period) = quantity_line(motion.quantities, self._scales), units.time_label.split("; ")
        self.told.object = f"<p>{words}.</p><p class='quiet'>{'; '.join([quantities, *period])}</p>"
        self.card_legend.object = listed(fill_motions(self._figures, cards, self._found, units))
        _put(self.card, _pairs(self._figures))

    def _no_card(self) -> None:
        self.card.visible, self.card_legend.object = False, ""

    def _show_states(self) -> None:
        """The plane of initial states, where the view asks for it: with basins, or with a state to drag."""
        state = self._state
        with self._quiet:
            self.slice.value = state.basins
        wanted = state.basins or state.start is not None
        if self._plane_of == (state.basins, wanted):
            if wanted and self.states.children:
                self._show_start()
            return
        self._plane_of = state.basins, wanted
        if not wanted or self._change is None:
            self.states.visible, self.states_told.object = False, ""
        elif state.basins:
            self.states_told.object = note("The slice of basins is integrated …", "note")
            self._ask("basins", answers.basins, self._at, self._draw_states)
        else:
            self._draw_states(None)

    def _draw_states(self, place) -> None:
        entries = fill_states(self._plane, self._found.attractors, place)
        unseen = len(entries) - len(self._found.attractors)
        more = f"The slice finds {unseen} more than the random starts did." if place is not None and unseen > 0 else ""
        self.states_told.object = listed(entries) + note(more, "note")
        self._show_start()
        _put(self.states, [self._plane])

    def _show_start(self) -> None:
        """The state that can be dragged, where the view has it."""
        x, speed = self._state.start or self._first_state()
        source, shown = source_of(self._plane, "start"), {"x": [x], "y": [speed]}
        if dict(source.data) != shown:
            with self._quiet:
                source.data = shown

    def _first_state(self) -> tuple[float, float]:
        """Where an own state begins: on the first attractor."""
        if not self._found.attractors:
            return 0.0, 0.0
        x, speed = self._found.attractors[0].curves.points[0].tolist()
        return float(f"{x:.4g}"), float(f"{speed:.4g}")

    def _dragged(self, name: str, before: dict, after: dict) -> None:
        if not self._quiet and len(after["x"]) == 1:
            x, speed = (float(f"{after[key][0]:.4g}") for key in ("x", "y"))
            self._change(start=(x, speed), motion=None)

    def _chosen(self, event) -> None:
        if self._quiet or event.new is None or self._change is None:
            return
        if event.new == _OWN:
            self._change(start=self._state.start or self._first_state(), motion=None)
        else:
            self._change(motion=event.new, start=None)

    def _toggled(self, event) -> None:
        if not self._quiet and self._change is not None:
            self._change(basins=event.new)


def _pane(drawn) -> pn.pane.Bokeh:
    return pn.pane.Bokeh(drawn, sizing_mode="stretch_width", margin=0)


def _pairs(figures: dict) -> list:
    """Figures of motions, two beside each other."""
    pairs = (("time", "force"), ("phase", "spectrum"))
    return [row(*(figures[name] for name in pair), sizing_mode="stretch_width") for pair in pairs]


def _put(layout, drawn: list) -> None:
    """Have figures in a layout, in sight."""
    if not layout.children:
        layout.children = drawn
    layout.visible = True
