"""Figures of a stored plane as PNG in memory."""

import tempfile
from collections.abc import Sequence
from pathlib import Path

from pipeline import figures
from pipeline.config.places import Place

__all__ = ["pictures_of"]

_DPI = 120


def pictures_of(path: Place, names: Sequence[str], curves: list[float] | None) -> dict[str, bytes]:
    """Draw a plane and give back the figures of these names, as far as it has them.

    Parameters
    ----------
    path : Place
        A store.
    names : sequence of str
        Of "map", "curves", "backbone", "verification".
    curves : list of float or None
        As `pipeline.figures.draw` takes them.
    """
    with tempfile.TemporaryDirectory(prefix="bevelmap-") as folder:
        paths = figures.draw(path, Path(folder), curves, ["png"], _DPI, only=names)
        return {place.stem: place.read_bytes() for place in paths}
