"""Which cells are looked at: some of every label, and pairs of neighbours with different labels."""

from dataclasses import dataclass

import numpy as np

__all__ = ["Cells", "allot", "choose_cells", "strata_sample"]


@dataclass(frozen=True)
class Cells:
    """Cells in the order of rows and columns, each once.

    Parameters
    ----------
    row, column : (k,) int arrays
    stratified, beside : (k,) bool arrays
        Whether it was drawn for its label, and as one of a pair on both sides of a boundary. Only the former are a fair
        sample of their label.
    """

    row: np.ndarray
    column: np.ndarray
    stratified: np.ndarray
    beside: np.ndarray


def allot(sizes: np.ndarray, count: int) -> np.ndarray:
    """How many of `count` draws each stratum gets.

    Half of the draws are dealt evenly, as far as strata are large enough, the rest in proportion to what is left of
    each stratum (largest remainders). With at least as many draws as strata every stratum gets one.

    Parameters
    ----------
    sizes : (s,) int array
        Above 0.
    count : int

    Returns
    -------
    (s,) int array
        At most `sizes`; the sum is `count`, or all there are.

    Examples
    --------
    >>> allot(np.array([900, 90, 10, 1]), 40).tolist()
    [27, 7, 5, 1]
    """
    sizes = np.asarray(sizes, dtype=np.int64)
    count = min(int(count), int(sizes.sum()))
    if count < sizes.size:
        # Not enough for all: the largest strata are worth most.
        shares = np.zeros_like(sizes)
        shares[np.argsort(-sizes, kind="stable")[:count]] = 1
        return shares
    if count == 0:
        return np.zeros_like(sizes)
    shares = np.minimum(sizes, max(1, count // (2 * sizes.size)))
    left, room = count - int(shares.sum()), sizes - shares
    if left > 0:
        exact = left * room / room.sum()
        more = np.minimum(np.floor(exact).astype(np.int64), room)
        rest = np.where(more < room, exact - more, -1.0)
        more[np.argsort(-rest, kind="stable")[: left - int(more.sum())]] += 1
        shares = shares + more
    return shares


def strata_sample(stratum: np.ndarray, count: int, random: np.random.Generator) -> np.ndarray:
    """Ascending indices of `count` draws without replacement, by strata as `allot` deals them.

    Parameters
    ----------
    stratum : (k,) int array
        To which stratum each candidate belongs.
    count : int
    random : numpy.random.Generator
    """
    names, sizes = np.unique(stratum, return_counts=True)
    drawn = [
        random.choice(np.flatnonzero(stratum == name), share, replace=False)
        for name, share in zip(names, allot(sizes, count), strict=True)
    ]
    return np.sort(np.concatenate([np.empty(0, dtype=np.int64), *drawn]))


def choose_cells(domain: np.ndarray, usable: np.ndarray, samples: int, beside: int, seed: int) -> Cells:
    """A sample of a plane's cells.

    Parameters
    ----------
    domain : (P, X) array
        Codes of the labels.
    usable : (P, X) bool array
        Cells that may be drawn.
    samples : int
        Number of cells drawn by label.
    beside : int
        Number of pairs of neighbours with different labels, drawn by the pair's two labels.
    seed : int
    """
    random = np.random.default_rng(seed)
    places = np.flatnonzero(usable)
    drawn = places[strata_sample(domain.ravel()[places], samples, random)]
    pairs = _pairs(domain, usable)
    codes = np.sort(domain.ravel()[pairs].astype(np.int64), axis=1)
    sides = pairs[strata_sample(codes[:, 0] * 2**16 + codes[:, 1], beside, random)].ravel()
    cells = np.union1d(drawn, sides).astype(np.int64)
    row, column = np.unravel_index(cells, domain.shape)
    return Cells(row, column, np.isin(cells, drawn), np.isin(cells, sides))


def _pairs(domain: np.ndarray, usable: np.ndarray) -> np.ndarray:
    """Flat indices (k, 2) of usable neighbours along either axis whose labels differ."""
    index = np.arange(domain.size).reshape(domain.shape)
    found = []
    for axis in (0, 1):
        one, other = np.delete(index, -1, axis), np.delete(index, 0, axis)
        differs = (domain.ravel()[one] != domain.ravel()[other]) & usable.ravel()[one] & usable.ravel()[other]
        found.append(np.column_stack([one[differs], other[differs]]))
    return np.concatenate(found)
