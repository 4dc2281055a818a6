"""The page: a map to click, what there is at a place, a design point, what makes the view again and what it gives."""

import functools
import html
import io
from dataclasses import replace
from urllib.parse import parse_qsl, quote, urlencode

import panel as pn

from pipeline.config.quantities import QUANTITIES
from pipeline.errors import ConfigurationError
from pipeline.explorer.background_run import NewPlane
from pipeline.explorer.design_panel import DesignPanel
from pipeline.explorer.downloads import FORMATS, download, file_name
from pipeline.explorer.fixed_panel import FixedPanel
from pipeline.explorer.later import Later
from pipeline.explorer.layer_data import Layer
from pipeline.explorer.legend import legend
from pipeline.explorer.map_view import MapView
from pipeline.explorer.messages import message, note, text
from pipeline.explorer.opened import Content, Opened, said
from pipeline.explorer.place_column import PlaceColumn
from pipeline.explorer.quiet import Quiet
from pipeline.explorer.reproduction import python_lines, shell_command
from pipeline.explorer.site import Site
from pipeline.explorer.style import CARDS, CSS, LAYOUT, PLACES, WIDGETS
from pipeline.explorer.view_state import ViewState, query_of, state_of

__all__ = ["explorer", "page_of"]

_LAYERS = {
    "domains": "n/I: motions that the map counts",
    "dynamic": "n/I, dynamically stable motions",
    "attractors": "attractors, by integration",
    "credibility": "what the labels are worth",
}
_WORDS = {"map": "map", "curves": "curves of the row", "motions": "motions at the place"}


def page_of(site: Site):
    """One page, as its address asks for it; whatever is wrong with a store or an address is a line of it."""
    location = pn.state.location
    given = dict(parse_qsl((location.search if location else "").removeprefix("?"), keep_blank_values=True))
    name = given.pop("store", site.first)
    opened = site.planes.get(name)
    if opened is None:
        return message(f"store = {name!r} is not shown here: it must be one of {', '.join(site.planes)}")
    query = urlencode(given, safe=",", quote_via=quote)
    prefix = "" if name == site.first else f"store={quote(name)}"
    return explorer(opened, query, site, prefix, location)


def explorer(opened: Opened, query: str = "", site: Site | None = None, prefix: str = "", location=None):
    """The explorer of a store.

    Parameters
    ----------
    opened : Opened
    query : str
        What it shows first, as in an address.
    site : Site, optional
        Of the server.
    prefix : str
        What its address begins with.
    location : panel.io.location.Location, optional
        The page's address, which keeps the state.

    Returns
    -------
    panel.viewable.Viewable
    """
    try:
        content, wrong = opened.content(), ""
        try:
            state = state_of(query, content.allowed)
        except ConfigurationError as error:
            state, wrong = ViewState(), str(error)
        return _Page(opened, content, state, site or Site(opened), prefix, location, wrong).view
    except Exception as error:  # whatever is wrong with the store
        return message(said(error, opened.path))


class _Page:
    """One page; `change` is the one way in which its view changes."""

    def __init__(
        self, opened: Opened, content: Content, state: ViewState, site: Site, prefix: str, location, wrong: str
    ):
        self._opened, self._content, self._state, self._prefix = opened, content, state, prefix
        self._location = location
        self._later = Later(pn.state.curdoc if location is not None else None)
        plan, change = content.plan, self.change
        self._map: MapView | None = None
        self._map_pane = pn.Column(margin=0, sizing_mode="stretch_width")
        self._legend = text(note("The map is divided into its exact regions …", "note"))
        self._pin = pn.widgets.Button(name="Pin", width=90, stylesheets=[WIDGETS])
        self._pin.on_click(lambda _: self.change(pin=None if self._state.pin == self._state.at else self._state.at))
        self._here = PlaceColumn(opened, self._later, "here", change, self._pin)
        self._pinned = PlaceColumn(opened, self._later, "pinned", None)
        self._fixed = FixedPanel(plan, opened.command, site.run, change, functools.partial(_arrived, site))
        self._design = DesignPanel(opened, content, self._later, change)
        self._wrong = text()
        self._layer = self._layer_select(content.allowed.layers)
        self._units = self._units_select(content.allowed.physical)
        self._lines = text()
        self._take = self._download_row()
        self._quiet, self._layer_shown = Quiet(), None
        self.view = self._layout()
        self._show(state, wrong)
        if location is not None:
            location.param.watch(self._addressed, "search")
            pn.state.onload(self._later.begin)

    def change(self, **values) -> None:
        """Show the view with some values changed, or say why it cannot be."""
        before, wanted = self._state, replace(self._state, **values)
        if wanted == before:
            return
        try:
            # What the page sends passes the same gate as an address.
            if "at" in values:
                wanted = replace(wanted, motion=values.get("motion"), start=values.get("start"))
            wanted = state_of(query_of(wanted), self._content.allowed)
        except ConfigurationError as error:
            self._later.turn(functools.partial(self._show, before, str(error)))
            return
        self._state = wanted
        self._later.turn(functools.partial(self._show, wanted))

    def _show(self, state: ViewState, wrong: str = "") -> None:
        if state != self._state:
            # Something else is asked for by now.
            return
        self._wrong.object = note(wrong)
        with self._quiet:
            self._layer.value = state.layer
            self._units.value = "physical" if state.physical else "dimensionless"
        self._ask_layer(state.layer, state.physical)
        if self._map is not None:
            self._map.show(state)
        self._fixed.show(state)
        self._design.show(state)
        for column, place in ((self._here, state.at), (self._pinned, state.pin)):
            column.view.visible = place is not None
            if place is not None:
                column.show(self._content, state, place)
        self._hint.visible = state.at is None and state.pin is None
        self.view.css_classes = ["explorer", *(["pinned"] if state.pin is not None and state.at is not None else [])]
        self._pin.name = "Unpin" if state.pin is not None and state.pin == state.at else "Pin"
        self._tell(state)

    def _ask_layer(self, name: str, physical: bool) -> None:
        """Have the map show a layer, unless it does already."""
        if self._layer_shown == (name, physical):
            return
        self._layer_shown = name, physical
        content = self._content
        if self._map is None:
            self._later.ask("layer", lambda: content.first_layer(name, physical), self._show_first, self._failed)
        else:
            self._later.ask("layer", lambda: content.layer(name, physical), self._show_layer, self._failed)

    def _show_first(self, found: tuple[Layer | None, bool]) -> None:
        layer, whole = found
        if layer is not None:
            self._map = MapView(layer, self._content.plan, self._later, self.change)
            self._map.window(self._state.window)
            # Whole before it is handed over: Panel sends it later than Bokeh sends what is changed in it.
            self._map.show(self._state)
            self._map_pane[:] = [pn.pane.Bokeh(self._map.figure, sizing_mode="stretch_width")]
        # What the reader does not look at first comes after the map.
        self._later.turn(self._prepare)
        if whole:
            self._legend.object = legend(layer)
        else:
            name, physical, content = *self._layer_shown, self._content
            self._later.ask("layer", lambda: content.layer(name, physical), self._show_layer, self._failed)

    def _prepare(self) -> None:
        self._fixed.prepare()
        self._here.prepare()

    def _show_layer(self, layer: Layer) -> None:
        self._legend.object = legend(layer)
        if self._map is None:
            self._show_first((layer, True))
        else:
            self._map.show_layer(layer)
            self._map.show(self._state)

    def _failed(self, error: Exception) -> None:
        self._wrong.object = note(said(error, self._opened.path))

    def _tell(self, state: ViewState) -> None:
        plan = self._content.plan
        lines = [python_lines(state, self._content.path, plan)]
        if self._opened.command:
            lines.append(shell_command(state, self._opened.command))
        heads = ("Python", "Shell")
        blocks = (f"<p>{head}</p><pre>{html.escape(words)}</pre>" for head, words in zip(heads, lines, strict=False))
        self._lines.object = "".join(blocks)
        if self._location is not None:
            query = "&".join(part for part in (self._prefix, query_of(state)) if part)
            self._location.search = f"?{query}" if query else ""

    def _addressed(self, event) -> None:
        """The reader went back, or typed another address."""
        given = dict(parse_qsl(event.new.removeprefix("?"), keep_blank_values=True))
        given.pop("store", None)
        query = urlencode(given, safe=",", quote_via=quote)
        if query != query_of(self._state):
            try:
                wanted = state_of(query, self._content.allowed)
            except ConfigurationError as error:
                self._wrong.object = note(str(error))
                return
            self.change(**vars(wanted))

    def _layer_select(self, names: tuple[str, ...]) -> pn.widgets.Select:
        options = {_LAYERS.get(name) or QUANTITIES[name].title: name for name in names}
        select = pn.widgets.Select(
            name="Map shows", options=options, sizing_mode="stretch_width", stylesheets=[WIDGETS], margin=(2, 5)
        )
        select.param.watch(lambda event: self._by_hand(layer=event.new), "value")
        return select

    def _units_select(self, physical: bool) -> pn.widgets.RadioButtonGroup:
        group = pn.widgets.RadioButtonGroup(
            options=["dimensionless", "physical"], visible=physical, stylesheets=[WIDGETS], margin=(2, 5)
        )
        group.param.watch(lambda event: self._by_hand(physical=event.new == "physical"), "value")
        return group

    def _by_hand(self, **values) -> None:
        if not self._quiet:
            self.change(**values)

    def _download_row(self) -> pn.Row:
        what = pn.widgets.Select(
            options={_WORDS[name]: name for name in FORMATS}, width=150, stylesheets=[WIDGETS], margin=(2, 5)
        )
        kind = pn.widgets.Select(options=list(FORMATS["map"]), width=75, stylesheets=[WIDGETS], margin=(2, 5))
        button = pn.widgets.FileDownload(
            callback=lambda: self._file(button, what.value, kind.value),
            filename="map.png",
            label="Save",
            embed=False,
            auto=True,
            width=60,
            height=28,
            stylesheets=[WIDGETS],
            margin=(2, 5),
        )

        def chosen(_) -> None:
            kind.options = list(FORMATS[what.value])

        what.param.watch(chosen, "value")
        return pn.Row(what, kind, button, margin=0)

    def _file(self, button, what: str, kind: str) -> io.BytesIO:
        try:
            content = download(self._content, self._state, what, kind)
        except Exception as error:  # of a store that is gone, or of what there is not
            # What is saved then says so, as the page does.
            words = said(error, self._opened.path)
            self._wrong.object = note(words)
            button.filename = "not-saved.txt"
            return io.BytesIO(f"{words}\n".encode())
        button.filename = file_name(self._content, self._state, what, kind)
        return io.BytesIO(content)

    def _layout(self):
        plan = self._content.plan
        sizes = " × ".join(str(axis.num) for axis in plan.axes)
        title = text(
            f"<h1>{html.escape(self._content.path.stem)}</h1><p class='quiet'>{sizes} cells, {plan.order_text}. "
            "Click a place; zoom with the wheel.</p>"
        )
        self._hint = text(
            "<h2>Click a place on the map</h2><p class='quiet'>Its curves, every motion with its stability, and what "
            "integration makes of it.</p>"
        )

        left = pn.Column(
            title,
            self._layer,
            self._units,
            _section("Gear", self._fixed.view),
            _section("Design point", self._design.view),
            _section("Save and repeat", self._take, self._lines, folded=True),
            sizing_mode="stretch_width",
            css_classes=["controls"],
        )
        middle = pn.Column(self._wrong, self._map_pane, self._legend, sizing_mode="stretch_width", css_classes=["map"])
        places = pn.Column(
            self._hint,
            pn.Row(self._here.view, self._pinned.view, sizing_mode="stretch_width", stylesheets=[PLACES], margin=0),
            sizing_mode="stretch_width",
            css_classes=["places"],
        )
        return pn.Column(
            left, middle, places, sizing_mode="stretch_width", stylesheets=[LAYOUT], margin=8, css_classes=["explorer"]
        )


def _section(name: str, *parts, folded: bool = False) -> pn.Card:
    # What is within is one part, as Panel would send its parts' sight with every word that they say.
    return pn.Card(
        pn.Column(*parts, sizing_mode="stretch_width", margin=0),
        title=name,
        collapsed=folded,
        sizing_mode="stretch_width",
        margin=(2, 5),
        stylesheets=[CARDS],
    )


def _arrived(site: Site, plane: NewPlane) -> str:
    """A plane that has been computed joins those that are shown; its address."""
    name = plane.path.stem
    if name not in site.planes:
        site.planes[name] = other = Opened(plane.path, plane.command)
        other.ready = site.planes[site.first].ready
    return f"/?store={quote(name)}"


pn.extension(raw_css=[CSS])
