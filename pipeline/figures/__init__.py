"""Figures drawn from a stored plane; nothing is solved again but rows that it does not have."""

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from pipeline import store
from pipeline.config.places import Place
from pipeline.config.quantities import AMPLITUDE
from pipeline.config.schema import Figures
from pipeline.figures.options import check_options, figure_options
from pipeline.plan.layers import layer_name
from pipeline.plane.stored import StoredPlane, read_stored

__all__ = ["NAMES", "check_options", "draw", "draw_named", "draw_one", "figure_options", "names_of"]

#: Figures of a plane, those that take longest first.
NAMES = (
    "map",
    "map-quantity",
    "curves",
    "map-window",
    "multipliers",
    "attractors",
    "verification",
    "basins",
    "backbone",
)


def draw(
    store_path: Place,
    folder: Path,
    curves: list[float] | None,
    formats: Sequence[str],
    dpi: int,
    *,
    only: Sequence[str] | None = None,
    **further,
) -> list[Path]:
    """Draw the map, the amplitude-frequency curves and the backbone of a stored plane, and a part of the map if asked.

    Parameters
    ----------
    store_path : Place
        A store of this program.
    folder : Path
        Where the files go; made if need be.
    curves, formats, dpi, **further
        As for `pipeline.figures.options.figure_options`. Curves are solved where no row has them; None: a quarter, half
        and three quarters of the way.
    only : sequence of str, optional
        Names of the figures that are drawn; all there are unless given.

    Returns
    -------
    list of Path
        map, map-<quantity>-<of>, map-window, curves or curves-<quantity>, multipliers, attractors, verification, basins
        and backbone, each in all formats; "-dynamic" stands behind the names of those of dynamic stability. Attractors
        and verification are drawn where the store has the group `attractors`, basins where it has `places`. The
        backbone is left out where the plane's rows do not run over the mesh frequency, without mean load, and of
        systems that are no bevel pair. Of a volume, layers: maps of up to five of them; and attractors-<name>=<value>
        of each of these, where they have been sought.

    Raises
    ------
    ConfigurationError
        If the options are not allowed for this plane, or there is no store of ours.
    """
    options = figure_options(curves, formats, dpi, **further)
    drawn = draw_named(store_path, folder, options, NAMES if only is None else only)
    return [path for paths in drawn.values() for path in paths]


def draw_named(store_path: Place, folder: Path, options: Figures, names: Sequence[str]) -> dict[str, list[Path]]:
    """`draw` some figures, as a task of a worker: name -> its paths, without those that the plane does not have."""
    plane = read_stored(store_path, options.stability == "dynamic", options.units == "physical")
    check_options(plane.plan, options)
    folder.mkdir(parents=True, exist_ok=True)
    with _without_collector():
        if plane.plan.parameter2 is not None:
            return {"layers": _draw_layers(plane, folder, options)}
        return _draw(plane, folder, options, names)


def names_of(store_path: Place, options: Figures) -> list[str]:
    """Figures that a plane may have with the options of `draw`, those that take longest first."""
    kept = {"map-quantity": options.quantity, "map-window": options.window, "multipliers": options.multipliers}
    lacking = {name for name, value in kept.items() if value is None}
    if not store.exists(store_path / "attractors"):
        lacking |= {"attractors", "verification"}
    if not store.exists(store_path / "places"):
        lacking.add("basins")
    return [name for name in NAMES if name not in lacking]


def draw_one(
    store_path: Place, folder: Path, name: str, drawn: Callable[[StoredPlane], object], options: Figures
) -> list[Path]:
    """Draw one figure of a stored plane as `name` in all formats.

    Parameters
    ----------
    store_path, folder
        As for `draw`.
    name : str
    drawn : callable
        drawn(plane) is the figure.
    options : Figures
        Its formats, dpi and units.
    """
    from pipeline.figures.drawing import own_style
    from pipeline.figures.output import write_figure

    folder.mkdir(parents=True, exist_ok=True)
    with _without_collector(), own_style():
        plane = read_stored(store_path, physical=options.units == "physical")
        return write_figure(drawn(plane), plane, folder, name, options.formats, options.dpi)


@contextmanager
def _without_collector() -> Iterator[None]:
    """Keep the garbage collector away from the many short-lived objects of a figure.

    It would walk all objects of the imported libraries again and again, for a quarter of the time of drawing.
    """
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _draw(plane: StoredPlane, folder: Path, options: Figures, names: Sequence[str]) -> dict[str, list[Path]]:
    # Here, because options are checked long before anything is drawn and matplotlib takes half a second to import.
    from pipeline.figures.backbone import draw_backbone, has_backbone
    from pipeline.figures.curves import draw_curves
    from pipeline.figures.drawing import own_style
    from pipeline.figures.map import draw_map, draw_window
    from pipeline.figures.output import write_figure

    drawers = {"map": lambda: draw_map(plane)}
    if options.window is not None:
        drawers["map-window"] = lambda: draw_window(plane, options.window)
    shown = options.quantity or AMPLITUDE.name
    drawers["curves"] = lambda: draw_curves(plane, options.curves, shown)
    files = {} if shown == AMPLITUDE.name else {"curves": f"curves-{shown}"}
    if options.quantity is not None:
        from pipeline.figures.quantity_map import draw_quantity_map

        drawers["map-quantity"] = lambda: draw_quantity_map(plane, shown, options.of)
        files["map-quantity"] = f"map-{shown}-{options.of}"
    if options.multipliers is not None:
        from pipeline.figures.multipliers import draw_multipliers

        drawers["multipliers"] = lambda: draw_multipliers(plane, options.multipliers)
    if any(store.exists(plane.path / group) for group in ("attractors", "places")):
        # What it needs of the solver are many kernels, and most planes have none.
        drawers |= _of_attractors(plane)
    if has_backbone(plane):
        drawers["backbone"] = lambda: draw_backbone(plane)
    with own_style():
        return {
            name: write_figure(drawn(), plane, folder, files.get(name, name), options.formats, options.dpi)
            for name, drawn in drawers.items()
            if name in names
        }


def _of_attractors(plane) -> dict:
    """Name -> what draws it, of what is only there where attractors were sought."""
    from pipeline.analysis.attractors.dataset import read_attractors
    from pipeline.analysis.attractors.places import read_places
    from pipeline.figures.attractors import draw_attractors
    from pipeline.figures.basins import draw_basins
    from pipeline.figures.verification import draw_verification

    drawers, found, places = {}, read_attractors(plane.path), read_places(plane.path)
    if found is not None:
        drawers["attractors"] = lambda: draw_attractors(plane, found)
        drawers["verification"] = lambda: draw_verification(plane, found)
    if places is not None and "slice" in places:
        drawers["basins"] = lambda: draw_basins(plane, places)
    return drawers


def _draw_layers(volume: StoredPlane, folder: Path, options: Figures) -> list[Path]:
    from pipeline.figures.drawing import own_style
    from pipeline.figures.output import write_figure
    from pipeline.figures.volume import draw_volume

    how = options.formats, options.dpi
    with own_style():
        paths = write_figure(draw_volume(volume), volume, folder, "layers", *how)
        for layer, drawer in _of_layers(volume):
            paths += write_figure(drawer(), layer, folder, f"attractors-{_layer_text(volume, layer)}", *how)
    return paths


def _layer_text(volume, layer) -> str:
    return layer_name("", volume.plan, layer.layer).removeprefix("-")


def _of_layers(volume) -> Iterator[tuple]:
    """The layers that are shown, with what draws the attractors of each, where they have been sought."""
    if not store.exists(volume.path / "attractors"):
        return
    from pipeline.analysis.attractors.dataset import read_attractors
    from pipeline.figures.attractors import draw_attractors
    from pipeline.figures.volume import shown_layers

    found = read_attractors(volume.path)
    for layer in shown_layers(volume).values() if found is not None else ():
        here = found.isel({volume.plan.parameter2.name: layer.layer})
        yield layer, partial(draw_attractors, layer, here)
