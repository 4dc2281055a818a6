"""Where labels are written in a map: inside of their regions, or beside narrow ones with a line that leads there."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

__all__ = ["RegionLabel", "placed_labels"]

#: Inches: side of a pixel, width of a character, height of a label, distance kept from other labels.
_PIXEL, _CHARACTER, _TALL, _APART = 0.01, 0.052, 0.1, 0.03
#: Regions that are labelled again besides the largest of their label, and the smallest that are labelled at all, as
#: shares of the panel.
_AGAIN, _LEAST = 0.02, 2e-5


@dataclass(frozen=True)
class RegionLabel:
    """A label, its middle, and the place in the region that a line leads to; in shares of the panel."""

    text: str
    code: int
    place: tuple[float, float]
    leads_to: tuple[float, float] | None = None


def placed_labels(
    code: np.ndarray,
    drawn: np.ndarray,
    labels: dict[int, str],
    size: tuple[float, float],
    blocked: Sequence[tuple[float, float, float, float]] = (),
    unled: Sequence[tuple[float, float]] = (),
) -> list[RegionLabel]:
    """Places for the labels of the regions of a panel.

    Parameters
    ----------
    code : (m, n) int array
        Of the labels, evenly over the panel; 0 where there is none.
    drawn : (m, n) int array
        What is drawn there besides, below 2^8, of which a label covers one kind only, where it can.
    labels : dict
        Code -> text.
    size : (width, height)
        Of the panel, in inches.
    blocked : sequence of (left, right, low, high)
        Where nothing is written, in shares of the panel.
    unled : sequence of (left, right)
        Stretches in which no line leads to narrow regions: another panel shows them larger.

    Returns
    -------
    list of RegionLabel
        At most one with a line for every label.
    """
    code, drawn = (_reduced(image, size).astype(np.int32) for image in (code, drawn))
    parts = code << 8 | drawn
    rows, columns = code.shape
    free = np.ones(code.shape, dtype=bool)
    for left, right, low, high in blocked:
        free[_slice(low, high, rows), _slice(left, right, columns)] = False
    edges = ndimage.maximum_filter(parts, 3) != ndimage.minimum_filter(parts, 3)
    plain = ndimage.maximum_filter(code, 3) == ndimage.minimum_filter(code, 3)
    found, waiting = [], []
    for value in sorted(int(value) for value in np.unique(code) if value and labels[int(value)]):
        regions, count = ndimage.label(code == value)
        areas = np.bincount(regions.ravel(), minlength=count + 1)[1:]
        boxes = ndimage.find_objects(regions)
        for number in np.argsort(-areas, kind="stable"):
            largest = number == np.argmax(areas)
            if areas[number] < (_LEAST if largest else _AGAIN) * code.size:
                continue
            # Nothing outside of its box matters to a region.
            box = boxes[number]
            region, open_here = regions[box] == number + 1, free[box]
            place = _inside(region, ~edges[box] & open_here, labels[value])
            place = place or _inside(region, plain[box] & open_here, labels[value])
            if place is not None:
                place = _within_panel(place, box)
                found.append(RegionLabel(labels[value], value, _share(place, code.shape)))
                _block(free, place, labels[value])
            elif largest:
                waiting.append((value, _within_panel(_deepest(region), box)))
    for value, target in waiting:
        across = (target[1] + 0.5) / columns
        if any(left <= across <= right for left, right in unled):
            continue
        place = _beside(target, ~edges & free, labels[value])
        if place is not None:
            found.append(RegionLabel(labels[value], value, _share(place, code.shape), _share(target, code.shape)))
            _block(free, place, labels[value])
    return found


def _within_panel(place: tuple[int, int], box: tuple[slice, slice]) -> tuple[int, int]:
    return place[0] + box[0].start, place[1] + box[1].start


def _reduced(image: np.ndarray, size: tuple[float, float]) -> np.ndarray:
    """An image of so many pixels as the panel has here."""
    columns, rows = (max(int(round(inches / _PIXEL)), 2) for inches in size)
    up = ((np.arange(rows) + 0.5) / rows * image.shape[0]).astype(int)
    across = ((np.arange(columns) + 0.5) / columns * image.shape[1]).astype(int)
    return image[np.ix_(up, across)]


def _box(text: str) -> tuple[int, int]:
    """Rows and columns that a label takes."""
    return int(_TALL / _PIXEL) + 2, int((_CHARACTER * len(text) + 0.04) / _PIXEL) + 2


def _fits(allowed: np.ndarray, text: str) -> np.ndarray:
    """Where the middle of a label may be, (m, n) bool."""
    return ndimage.minimum_filter(allowed.astype(np.uint8), size=_box(text), mode="constant", cval=0) == 1


def _inside(region: np.ndarray, allowed: np.ndarray, text: str) -> tuple[int, int] | None:
    fits = _fits(region & allowed, text)
    if not np.any(fits):
        return None
    # As far from the border as there is, but no further than is of use.
    depth = np.where(fits, np.minimum(_depth(region), 4 * _box(text)[0]), 0.0)
    best = np.argwhere(depth == depth.max())
    return tuple(int(v) for v in best[len(best) // 2])


def _beside(target: tuple[int, int], allowed: np.ndarray, text: str) -> tuple[int, int] | None:
    """The nearest place, not so near that the line would be hidden."""
    places = np.argwhere(_fits(allowed, text))
    tall, wide = _box(text)
    gaps = np.abs(places - target) - (0.5 * tall, 0.5 * wide)
    distance = np.hypot(*np.maximum(gaps, 0.0).T)
    distance[distance < 0.09 / _PIXEL] = np.inf
    if not np.any(np.isfinite(distance)):
        return None
    return tuple(int(v) for v in places[np.argmin(distance)])


def _depth(region: np.ndarray) -> np.ndarray:
    """Distance from the border of a region."""
    return ndimage.distance_transform_edt(np.pad(region, 1))[1:-1, 1:-1]


def _deepest(region: np.ndarray) -> tuple[int, int]:
    depth = _depth(region)
    best = np.argwhere(depth == depth.max())
    return tuple(int(v) for v in best[len(best) // 2])


def _block(free: np.ndarray, place: tuple[int, int], text: str) -> None:
    half = (np.array(_box(text)) // 2 + int(_APART / _PIXEL)).tolist()
    free[max(place[0] - half[0], 0) : place[0] + half[0] + 1, max(place[1] - half[1], 0) : place[1] + half[1] + 1] = (
        False
    )


def _slice(low: float, high: float, count: int) -> slice:
    return slice(max(int(low * count), 0), max(int(np.ceil(high * count)), 0))


def _share(place: tuple[int, int], shape: tuple[int, int]) -> tuple[float, float]:
    """Across and up."""
    return (place[1] + 0.5) / shape[1], (place[0] + 0.5) / shape[0]
