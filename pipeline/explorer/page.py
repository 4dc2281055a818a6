"""A plane as one HTML file: the map with its layers, curves of some rows, what the map tells and where it is wrong.

The file has everything in it, BokehJS too, and its policy forbids the browser to load anything: it may be mailed.
"""

import html
import json
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from bokeh.core.json_encoder import serialize_json
from bokeh.document import Document
from bokeh.events import DoubleTap, Tap
from bokeh.models import CustomJS, Span
from bokeh.resources import INLINE

from pipeline.config.quantities import QUANTITIES
from pipeline.explorer.curves_figure import curves_figure, fill_curves, value_limits
from pipeline.explorer.layer_data import Layer, MapAxis
from pipeline.explorer.layers import layer, layer_names
from pipeline.explorer.legend import legend, listed
from pipeline.explorer.map_figure import add_layer, map_figure
from pipeline.explorer.map_frame import frame_of_map
from pipeline.explorer.page_text import answer_of, doubts_of, heading_of
from pipeline.explorer.sources import Sources
from pipeline.plane.row_curves import stored_row
from pipeline.plane.stored import StoredPlane

__all__ = ["page_of"]

_HERE = Path(__file__).parent
#: What may be loaded: nothing. Bokeh makes functions of the callbacks that it was sent.
_POLICY = "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; img-src data: blob:"
#: Of the lines that show which place was clicked.
_PLACE = "#c51b1b"
_NAMES = {
    "domains": "n/I",
    "dynamic": "n/I, dynamically stable",
    "attractors": "what motions end on",
    "credibility": "where the label holds",
}


def page_of(
    plane: StoredPlane,
    *,
    physical: bool = False,
    rows: int = 9,
    quantities: Sequence[str] = ("dynamic_factor",),
    of: str = "worst",
    command: str = "",
) -> str:
    """A plane as the text of one HTML file; the same text every time.

    Parameters
    ----------
    plane : StoredPlane
        A plane, not a volume.
    physical : bool
        Whether axes and quantities are in physical units.
    rows : int
        Rows whose amplitude curves the page has, evenly over the plane.
    quantities : sequence of str
        Of `pipeline.config.quantities.QUANTITIES`, each a layer of the map.
    of : str
        Where several stable motions coexist, a quantity is the "worst" or the "mildest".
    command : str
        What makes the page anew; said at its end.

    Raises
    ------
    ConfigurationError
        As `pipeline.explorer.layers.layer`.
    """
    names = [name for name in layer_names(plane) if name not in QUANTITIES or name in quantities]
    layers = [layer(plane, name, physical=physical, of=of) for name in names]
    shown = _chosen_rows(plane, rows)
    document = Document(title=plane.path.stem)
    map_ = _map(layers)
    document.add_root(map_)
    values, ends, keys = [float(plane.rows[row]) * layers[0].y.size for row in shown], [], ""
    if shown:
        curves, scales = [stored_row(plane, row) for row in shown], frame_of_map(plane, physical).scales
        ends = [value_limits(row, scales=scales) for row in curves]
        drawn = _curves(len(curves))
        keys = listed(fill_curves(drawn, curves, layers[0].x, scales=scales))
        document.add_root(drawn)
    told = {"layers": names, "rows": values, "ends": ends}
    data = {"document": _renumbered(document.to_json(deferred=False)), **told}
    return _html(plane, physical, layers, values, keys, data, command)


def _chosen_rows(plane: StoredPlane, count: int) -> list[int]:
    """Complete rows, evenly over those there are, the first and the last of them left out."""
    complete = np.flatnonzero(plane.complete)
    places = (np.arange(count) + 0.5) / max(count, 1) * complete.size
    return list(dict.fromkeys(complete[places.astype(int)].tolist())) if complete.size else []


def _map(layers: Sequence[Layer]):
    """One figure of all layers, of which the page shows one at a time."""
    sources = Sources()
    found = map_figure(layers[0], sources=sources, legend=False, sizing_mode="stretch_both")
    for one in layers[1:]:
        add_layer(found, one, sources, legend=False)
    # The page itself says what is shown.
    found.title.visible = False
    for one in [*found.renderers, *found.right, *found.tools]:
        if one.tags and one.tags != [layers[0].name]:
            one.visible = False
    row = Span(dimension="width", line_color=_PLACE, line_width=1.5, line_dash="6 4", name="row", visible=False)
    found.add_layout(row)
    # A click right after another one counts as well.
    for event in (Tap, DoubleTap):
        found.js_on_event(event, CustomJS(code="bevelmap.tapped(cb_obj.x, cb_obj.y)"))
    return found


def _curves(count: int):
    """One figure of all rows, of which the page shows one at a time."""
    found = curves_figure(count, sizing_mode="stretch_both")
    place = Span(dimension="height", line_color=_PLACE, line_width=1, line_dash="6 4", name="place", visible=False)
    found.add_layout(place)
    return found


def _renumbered(document) -> dict:
    """A document as JSON whose models are numbered as they come: Bokeh counts all that a process has ever made."""
    known: dict[str, str] = {}

    def renamed(part):
        if isinstance(part, dict):
            is_model = part.get("type") == "object" or part.keys() == {"id"}
            return {
                key: known.setdefault(one, f"m{len(known)}") if is_model and key == "id" else renamed(one)
                for key, one in part.items()
            }
        return [renamed(one) for one in part] if isinstance(part, list) else part

    return renamed(json.loads(serialize_json(document)))


def _html(
    plane: StoredPlane,
    physical: bool,
    layers: Sequence[Layer],
    rows: Sequence[float],
    keys: str,
    data: dict,
    command: str,
) -> str:
    about, name = plane.about, html.escape(plane.path.stem)
    head = heading_of(plane, physical)
    title = f"{name}: {html.escape(layers[0].y.label)} over {html.escape(layers[0].x.label)}"
    # A script of this kind ends at the first "</".
    content = json.dumps(data, ensure_ascii=False, separators=(",", ":")).replace("</", "<\\/")
    text = "\n".join(f"<p>{html.escape(line)}</p>" for line in head)
    doubts = "\n".join(f"<li>{html.escape(line)}</li>" for line in doubts_of(plane))
    legends = "\n".join(
        f'<div class=aside data-layer="{one.name}"{"" if i == 0 else " hidden"}><h2>{html.escape(one.title)}</h2>'
        f"{legend(one)}</div>"
        for i, one in enumerate(layers)
    )
    section = _CURVES.format(buttons=_row_buttons(layers[0].y, rows), keys=keys) if rows else ""
    made = f"Made by <code>{html.escape(command)}</code>. " if command else ""
    return _PAGE.format(
        policy=_POLICY,
        title=title,
        style=(_HERE / "page.css").read_text(encoding="utf-8"),
        head=text,
        answer=html.escape(answer_of(plane)),
        buttons=_layer_buttons(layers),
        legends=legends,
        curves=section,
        doubts=doubts,
        made=f"{made}Configuration {html.escape(str(about['configuration_hash']))}.",
        bokeh=_bokeh(),
        content=content,
        script=(_HERE / "page.js").read_text(encoding="utf-8"),
    )


def _bokeh() -> str:
    """BokehJS without widgets and tables, which the page has none of."""
    resources = INLINE.clone(components=["bokeh"])
    return "\n".join(
        re.sub(r"//# sourceMappingURL=\S+", "", raw).replace("</script", "<\\/script") for raw in resources.js_raw
    )


def _layer_buttons(layers: Sequence[Layer]) -> str:
    return "\n".join(
        f'<button type=button data-layer="{one.name}" aria-pressed={"true" if i == 0 else "false"}>'
        f"{html.escape(_NAMES.get(one.name) or QUANTITIES[one.name].label)}</button>"
        for i, one in enumerate(layers)
    )


def _row_buttons(axis: MapAxis, rows: Sequence[float]) -> str:
    unit = f" {axis.unit}" if axis.unit else ""
    return f"<span>{html.escape(axis.symbol)} =</span>\n" + "\n".join(
        f"<button type=button data-row={i} aria-pressed=false>{value:.4g}{unit}</button>"
        for i, value in enumerate(rows)
    )


_CURVES = """<section aria-label="Curves">
<h2>Amplitude-frequency curves</h2>
<p>Of one row, the dashed line on the map. A click on the map shows the row next to it.</p>
<nav id=rows>
{buttons}
</nav>
<div class=pair><div id=curves></div><div class=aside>{keys}</div></div>
</section>"""

_PAGE = """<!DOCTYPE html>
<html lang=en>
<head>
<meta charset=utf-8>
<meta http-equiv=Content-Security-Policy content="{policy}">
<meta name=viewport content="width=device-width, initial-scale=1">
<meta name=color-scheme content=light>
<title>{title}</title>
<style>
{style}
</style>
</head>
<body>
<header>
<h1>{title}</h1>
<p class=answer>{answer}</p>
<details><summary>Gear and method</summary>
{head}
</details>
</header>
<main>
<section aria-label="Map">
<nav id=layers>
{buttons}
</nav>
<div class=pair><div><div id=map></div>
<p id=told aria-live=polite>Point at the map, or click it: it says what happens there. The wheel zooms.</p></div>
<div>{legends}</div></div>
</section>
{curves}
<section aria-label="Trust">
<h2>Where the map is not the truth</h2>
<ul>
{doubts}
</ul>
</section>
</main>
<footer><p>{made}</p></footer>
<noscript><p>The map is drawn by a script in this file, which this browser does not run.</p></noscript>
<script>
{bokeh}
</script>
<script type="application/json" id=plane>
{content}
</script>
<script>
{script}
</script>
</body>
</html>
"""
