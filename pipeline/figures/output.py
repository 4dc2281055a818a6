"""Figures into files, the same bytes every time."""

from pathlib import Path

from matplotlib.figure import Figure

from pipeline.plane.stored import StoredPlane

__all__ = ["write_figure"]

#: How hard a PNG is compressed: twice the time would save a twelfth.
_COMPRESSED = {"pil_kwargs": {"compress_level": 3}}


def write_figure(
    figure: Figure, plane: StoredPlane, folder: Path, name: str, formats: list[str], dpi: int
) -> list[Path]:
    """Write a figure in every format; the paths in that order. That of dynamic stability has a name of its own."""
    name = f"{name}-dynamic" if plane.dynamic else name
    title = f"{name}: {plane.about['title']}"
    source = f"bevelmap configuration {plane.about['configuration_hash']}"
    # Dates and the library's version, which are there unless taken out, would make equal figures differ.
    metadata = {
        "png": {"Software": None, "Title": title, "Source": source},
        "pdf": {"CreationDate": None, "Title": title, "Subject": source},
        "svg": {"Date": None, "Title": title, "Source": source},
    }
    paths = []
    for kind in formats:
        path = folder / f"{name}.{kind}"
        more = _COMPRESSED if kind == "png" else {}
        figure.savefig(path, format=kind, dpi=dpi, metadata=metadata[kind], **more)
        paths.append(path)
    return paths
