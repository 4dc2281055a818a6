"""A figure that looks the same wherever it is drawn, and shows itself in a notebook."""

import io
from contextlib import AbstractContextManager
from pathlib import Path

from matplotlib import style
from matplotlib.figure import Figure

__all__ = ["Drawing", "own_style"]

_STYLE = Path(__file__).with_name("bevelmap.mplstyle")
#: Pixels per inch on a screen.
_DPI = 110


def own_style() -> AbstractContextManager:
    """Our style and nothing else: a user's own matplotlibrc must not change our figures."""
    return style.context(_STYLE, after_reset=True)


class Drawing(Figure):
    """A matplotlib figure that belongs to no window and no list of open figures.

    `savefig` writes it as it is meant to look, whatever style is in force; a notebook shows it by `_repr_png_`, whether
    pyplot is loaded or not.
    """

    def savefig(self, *arguments, **options) -> None:
        with own_style():
            super().savefig(*arguments, **options)

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        self.savefig(file, format="png", dpi=_DPI)
        return file.getvalue()
