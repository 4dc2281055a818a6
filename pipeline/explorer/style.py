"""How the page looks."""

__all__ = ["CARDS", "CSS", "LAYOUT", "PANES", "PLACES", "TYPED", "WIDGETS"]

CSS = """
html, body { margin: 0; background: #fbfbfa; color: #222;
  font: 13px/1.45 system-ui, "Segoe UI", "Helvetica Neue", Arial, sans-serif; }
"""

#: Of everything within panes, which have a style of their own.
PANES = """
:host { font: 13px/1.45 system-ui, "Segoe UI", "Helvetica Neue", Arial, sans-serif; color: #222; }
h1 { font-size: 17px; font-weight: 600; margin: 0; }
h2 { font-size: 14px; font-weight: 600; margin: 0 0 2px 0; }
p { margin: 2px 0; }
.quiet { color: #666; }
.chip { display: inline-block; padding: 0 7px; border-radius: 9px; font-weight: 600; font-size: 12px;
  border: 1px solid rgba(0, 0, 0, .15); }
.warning { background: #fff4dc; border: 1px solid #e6c77a; border-radius: 4px; padding: 6px 10px; margin: 4px 0; }
.note { background: #f0f3f6; border: 1px solid #d5dce3; border-radius: 4px; padding: 4px 10px; margin: 4px 0; }
.wide { overflow-x: auto; }
table.plain { border-collapse: collapse; font-size: 12px; width: 100%; font-variant-numeric: tabular-nums; }
table.plain th { text-align: left; font-weight: 500; color: #666; border-bottom: 1px solid #ccc; padding: 1px 6px 1px 0;
  vertical-align: bottom; }
table.plain td { padding: 1px 6px 1px 0; border-bottom: 1px solid #eee; vertical-align: top; }
.legend { display: flex; flex-wrap: wrap; gap: 2px 12px; font-size: 12px; }
.legend span.entry { white-space: nowrap; }
.legend svg { vertical-align: -2px; margin-right: 4px; }
pre { background: #f3f3f1; border: 1px solid #ddd; border-radius: 4px; padding: 6px 8px; margin: 2px 0 8px 0;
  font: 11.5px/1.4 ui-monospace, Consolas, monospace; white-space: pre-wrap; overflow-wrap: anywhere;
  user-select: all; }
"""

#: Of widgets, which are small beside the map.
WIDGETS = """
:host { font-size: 12px; }
.bk-input { font-size: 12px; padding: 2px 6px; min-height: 24px; height: 26px; }
label, .bk-slider-title { font-size: 12px; color: #444; margin: 0; }
"""

#: Of numbers beside a slider, which needs no arrows besides.
TYPED = ".bk-spin-btn { display: none !important; }"

#: Of parts that can be folded away: a line, and no box around it.
CARDS = """
:host(.card) { box-shadow: none; border: none; border-top: 1px solid #ddd; border-radius: 0;
  background: none; outline: none; }
.card-header, .card-header:focus { background: none; padding: 4px 0; min-height: 26px; outline-offset: -2px; }
.card-header-row, .card-title { font-size: 13px; font-weight: 600; margin: 0; }
.card-button { margin: 0 4px 0 0; }
"""

#: Controls, map and place side by side; on a smaller screen, and where two places are shown, places come below the map.
LAYOUT = """
:host { display: grid; gap: 6px 14px; align-items: start;
  grid-template-columns: 280px minmax(0, 1.15fr) minmax(0, 1fr); grid-template-rows: auto 1fr; }
.controls { grid-column: 1; grid-row: 1 / span 2; }
.map, .places { min-width: 0; }
.map { grid-column: 2; grid-row: 1; }
.places { grid-column: 3; grid-row: 1; }
:host(.pinned) { grid-template-columns: 280px minmax(0, 1fr); }
:host(.pinned) .places { grid-column: 2; grid-row: 2; }
@media (max-width: 1180px) {
  :host, :host(.pinned) { grid-template-columns: 260px minmax(0, 1fr); }
  .places { grid-column: 2; grid-row: 2; }
}
@media (max-width: 700px) {
  :host, :host(.pinned) { grid-template-columns: minmax(0, 1fr); grid-template-rows: auto; }
  .controls, .map, .places, :host(.pinned) .places { grid-column: 1; grid-row: auto; }
  .controls { order: 1; }
}
"""

#: One place, or two side by side.
PLACES = """
:host { display: grid; gap: 0 16px; grid-template-columns: repeat(auto-fit, minmax(300px, 1fr)); align-items: start; }
.place { min-width: 0; overflow: hidden; }
"""
