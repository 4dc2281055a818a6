"""How much of each n/I region has dynamically stable motions, from the boundary curves and not from the raster."""

from collections.abc import Iterable
from dataclasses import dataclass

from pipeline.config.places import Place
from pipeline.errors import StoreError
from pipeline.plane.division import stored_division
from pipeline.plane.stored import StoredPlane, read_stored
from pipeline.store import store_path
from solver import ParameterError, domain_label, label_parts
from solver.model.checks import value_range
from solver.regions.labelling import dynamic_code, is_contradictory, static_code

__all__ = ["RegionStability", "together", "region_stability"]


@dataclass(frozen=True)
class RegionStability:
    """Dynamic stability in a static region; all are shares of the area of the plane, or of the part looked at.

    Parameters
    ----------
    share : float
        Of the region.
    none_stable : float
        In which none of its motions is dynamically stable: there is no stable 1T motion (label 0/-).
    one_unstable : float
        In which at least one of them is not dynamically stable.
    contradictory : float
        In which static and dynamic stability of one of them contradict each other: the order is too low there.
    """

    share: float = 0.0
    none_stable: float = 0.0
    one_unstable: float = 0.0
    contradictory: float = 0.0


def region_stability(
    path: Place | str | StoredPlane, window: tuple[float, float] | None = None, rows: tuple[float, float] | None = None
) -> dict[str, RegionStability]:
    """What dynamic stability says of every n/I region of a stored plane.

    Parameters
    ----------
    path : Place, str or StoredPlane
        A plane with boundaries.
    window : (low, high), optional
        Only this part of the swept axis counts, for example that of one resonance.
    rows : (low, high), optional
        Only these values of the row parameter count.

    Returns
    -------
    dict of str to RegionStability
        By static label, in the order of the labels' codes; the shares of all add up to 1. Dynamic stability is that of
        docs/physics.md, section 6: a multiplier beyond +1 is left to static stability.

    Raises
    ------
    StoreError
        If there is no such store, its boundaries are not stored or do not divide it, or the window or the rows are not
        inside the plane.
    solver.ParameterError
        If the path is none, or the window or the rows are no range.
    """
    plane = path if isinstance(path, StoredPlane) else read_stored(store_path("path", path))
    division = stored_division(plane)
    if division is None:
        raise StoreError(f"{plane.path} has no boundaries that divide it: run stages=[boundaries] first")
    windows = {"window": window, "rows": rows}
    windows = {name: None if ends is None else value_range(name, ends) for name, ends in windows.items()}
    try:
        shares = division.shares(windows["window"], windows["rows"])
    except ParameterError as error:
        raise StoreError(f"{plane.path}: {error}") from error
    found: dict[int, list[float]] = {}
    for code, share in shares.items():
        label, dynamic = domain_label(static_code(code)), domain_label(dynamic_code(code))
        (n, _), (left, _) = label_parts(label), label_parts(dynamic)
        sizes, static = (1, left == 0 < n, left < n, bool(is_contradictory(code))), int(static_code(code))
        found[static] = [a + share * b for a, b in zip(found.get(static, [0.0] * 4), sizes, strict=True)]
    return {domain_label(static): RegionStability(*found[static]) for static in sorted(found)}


def together(regions: Iterable[RegionStability]) -> RegionStability:
    """Several regions as one."""
    fields = ("share", "none_stable", "one_unstable", "contradictory")
    regions = list(regions)
    return RegionStability(*(sum((getattr(one, name) for one in regions), 0.0) for name in fields))
