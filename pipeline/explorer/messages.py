"""Text of a page, and what it says where it cannot show something: one line."""

import html

import panel as pn

from pipeline.explorer.style import PANES

__all__ = ["message", "note", "text"]


def text(markup: str = "", **options) -> pn.pane.HTML:
    """Some text; what comes from outside must be escaped in it already."""
    return pn.pane.HTML(markup, stylesheets=[PANES], sizing_mode="stretch_width", margin=(2, 5), **options)


def note(words: str, kind: str = "warning") -> str:
    """Markup of one line, whatever it holds shown as text; `kind` is "warning" or "note"."""
    return f'<div class="{kind}" role="status">{html.escape(words)}</div>' if words else ""


def message(words: str) -> pn.pane.HTML:
    """A page, or a part of it, that has only this to say."""
    return text(note(words))
