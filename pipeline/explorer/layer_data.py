"""What the map of a plane shows, as plain data in the units of its axes: nothing here knows how it is drawn."""

from dataclasses import dataclass, field

import numpy as np

__all__ = ["AreaClass", "Cells", "Layer", "LineKind", "MapAxis", "MarkKind", "Shade", "Told", "Written"]


@dataclass(frozen=True)
class MapAxis:
    """One axis of the map.

    Parameters
    ----------
    name : str
        The parameter, as the plane calls it.
    label : str
        Name and symbol, with the unit.
    symbol : str
        What stands before a value: "Ω", or "pinion speed" of a physical one.
    unit : str
        Empty where there is none.
    low, high : float
        Ends, as shown.
    size : float
        Shown units that 1 of the parameter stands for; 1 of a dimensionless map.
    """

    name: str
    label: str
    symbol: str
    unit: str
    low: float
    high: float
    size: float


@dataclass(frozen=True, eq=False)
class AreaClass:
    """What is told apart by colour.

    Parameters
    ----------
    name : str
        As the legend has it, such as "2/0-1".
    colour : str
        "#rrggbb".
    share : str
        Of the plane, in percent; empty where it is not told.
    polygons : tuple of (k, 2) arrays
        Where it holds exactly, without overlap; empty in a layer of cells.
    """

    name: str
    colour: str
    share: str = ""
    polygons: tuple[np.ndarray, ...] = ()


@dataclass(frozen=True, eq=False)
class Shade:
    """An area that is marked by a pattern, below which the colour stays.

    Parameters
    ----------
    name : str
    pattern : str
        "lines", "dots" or "crosses".
    colour : str
        Of the pattern.
    polygons : tuple of (k, 2) arrays
        Where it is, exactly; empty where it is known by cells.
    boxes : (k, 4) array
        Where it is, in cells: left, right, bottom, top.
    share : str
        Of the plane, in percent; empty where it is not told.
    bold : bool
        Whether the pattern takes half of the area, so that its colour counts as much as the one below.
    covers : bool
        Whether it hides what is below.
    """

    name: str
    pattern: str
    colour: str
    polygons: tuple[np.ndarray, ...] = ()
    boxes: np.ndarray = field(default_factory=lambda: np.empty((0, 4)))
    share: str = ""
    bold: bool = False
    covers: bool = False


@dataclass(frozen=True, eq=False)
class Cells:
    """Values of cells of one width and one height.

    Parameters
    ----------
    x, y : (low, high)
        Outer borders of the cells.
    values : (P, X) array
        From the lowest row upwards: numbers, nan where there is none; or ints, places in `Layer.classes`, -1 for none.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    values: np.ndarray


@dataclass(frozen=True, eq=False)
class LineKind:
    """Curves of one kind.

    Parameters
    ----------
    kind : str
        Of `pipeline.figures.map_legend.LINES`, or "mode 1", "mode 2".
    label : str
    lines : tuple of (k, 2) arrays
    """

    kind: str
    label: str
    lines: tuple[np.ndarray, ...]


@dataclass(frozen=True, eq=False)
class MarkKind:
    """Marked places of one kind: name of the `solver.boundaries.SpecialPoint`, what it is, and where, (k, 2)."""

    kind: str
    label: str
    places: np.ndarray


@dataclass(frozen=True)
class Written:
    """A label that is written on the map, and the place that a line leads to from there."""

    text: str
    place: tuple[float, float]
    colour: str
    ink: str
    leads_to: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class Told:
    """What is told of the cell below the pointer.

    Parameters
    ----------
    name : str
        What it is, such as "integration".
    cells : Cells
        Of places in `texts`.
    texts : tuple of str
    """

    name: str
    cells: Cells
    texts: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Layer:
    """One way to show a plane.

    Parameters
    ----------
    name : str
        As `layer_names` gives it.
    title : str
        What is shown, in a few words.
    unit : str
        Of the values of a quantity; empty otherwise.
    x, y : MapAxis
    classes : tuple of AreaClass
        With polygons, or as the cells count them.
    cells : Cells or None
        None where `classes` have polygons.
    ends : (low, high) or None
        Of the colours of a quantity; None of classes.
    shades : tuple of Shade
    lines : tuple of LineKind
    marks : tuple of MarkKind
    written : tuple of Written
    told : tuple of Told
    notes : tuple of str
        What a legend has to say besides.
    """

    name: str
    title: str
    unit: str
    x: MapAxis
    y: MapAxis
    classes: tuple[AreaClass, ...] = ()
    cells: Cells | None = None
    ends: tuple[float, float] | None = None
    shades: tuple[Shade, ...] = ()
    lines: tuple[LineKind, ...] = ()
    marks: tuple[MarkKind, ...] = ()
    written: tuple[Written, ...] = ()
    told: tuple[Told, ...] = ()
    notes: tuple[str, ...] = field(default=())

    @property
    def exact(self) -> bool:
        """Whether areas end at the boundary curves, and not at borders of cells."""
        return self.cells is None
