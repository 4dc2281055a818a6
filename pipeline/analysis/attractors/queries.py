"""Questions to the group `attractors`: what there is in a cell, hysteresis, shares of basins."""

from typing import TYPE_CHECKING

import numpy as np

from pipeline.analysis.attractors.dataset import read_attractors
from pipeline.config.places import Place
from pipeline.errors import StoreError
from pipeline.plan.plan import Plan
from solver import ImpactState, ParameterError
from solver.timedomain import AttractorKind, SeenFrom

if TYPE_CHECKING:
    import xarray

__all__ = [
    "attractors_near",
    "attractors_of",
    "basin_share",
    "grid_indices",
    "hysteresis",
    "hysteresis_intervals",
    "wilson",
]


def attractors_of(path: Place) -> "xarray.Dataset":
    """The group of a store.

    Raises
    ------
    StoreError
        If there is none.
    """
    found = read_attractors(path)
    if found is None:
        raise StoreError(f"{path} has no attractors: run stages=[attractors] first")
    return found


def grid_indices(found: "xarray.Dataset", plan: Plan) -> tuple[np.ndarray, np.ndarray]:
    """Which rows and columns of the plane were integrated."""
    return tuple(np.flatnonzero(np.isin(axis.values, found[axis.name].values)) for axis in (plan.parameter, plan.sweep))


def attractors_near(found: "xarray.Dataset", plan: Plan, x: float, p: float) -> "xarray.Dataset":
    """Everything that was found in the integrated cell nearest to a place, along `attractor`.

    Parameters
    ----------
    found : xarray.Dataset
        Of a plane.
    plan : Plan
    x, p : float

    Returns
    -------
    xarray.Dataset
        With `share_low` and `share_high`, the ends of Wilson's 95 % interval of `share`.
    """
    place = {
        found[axis.name].dims[0]: int(np.argmin(np.abs(found[axis.name].values - value)))
        for axis, value in ((plan.sweep, x), (plan.parameter, p))
    }
    here = found.isel(place).load()
    here = here.isel(attractor=np.flatnonzero(here.kind.values != AttractorKind.NONE))
    low, high = wilson(here.hits.values, np.broadcast_to(here.starts.values, here.hits.shape))
    return here.assign(
        share_low=("attractor", low, {"long_name": "lower end of the share's 95 % interval", "units": "1"}),
        share_high=("attractor", high, {"long_name": "upper end of the share's 95 % interval", "units": "1"}),
    )


def hysteresis(found: "xarray.Dataset") -> "xarray.DataArray":
    """Where a run along the row upwards meets other attractors than one downwards; bool.

    Only attractors count: two runs that both end on what had not settled are no hysteresis.
    """
    settled = (found.kind >= AttractorKind.PERIOD_1) & (found.kind <= AttractorKind.CHAOTIC)
    ways = [settled & ((found.seen & int(bit)) != 0) for bit in (SeenFrom.UPWARDS, SeenFrom.DOWNWARDS)]
    differs = (ways[0] != ways[1]).any("attractor") & ways[0].any("attractor") & ways[1].any("attractor")
    return differs.rename("hysteresis").assign_attrs(
        long_name="attractors that are met upwards and downwards along the row differ"
    )


def hysteresis_intervals(x: np.ndarray, differs: np.ndarray) -> np.ndarray:
    """Ends (i, 2) of the stretches of columns where the two ways differ, halfway to the neighbours outside.

    Examples
    --------
    >>> hysteresis_intervals(np.arange(6.0), np.array([0, 1, 1, 0, 0, 1])).tolist()
    [[0.5, 2.5], [4.5, 5.0]]
    """
    change = np.diff(np.concatenate([[0], differs, [0]]).astype(np.int8))
    middles = np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]])
    return np.column_stack([middles[change == 1], middles[change == -1]])


def basin_share(found: "xarray.Dataset", what: str) -> "xarray.Dataset":
    """Share of the random starts of every cell that reached attractors of a kind.

    Parameters
    ----------
    found : xarray.Dataset
    what : str
        "2T", "quasi-periodic", ..., or with an impact state, "2T/1".

    Returns
    -------
    xarray.Dataset
        `share`, nan without starts, `low` and `high` (Wilson's 95 % interval), `hits`, `starts`.

    Raises
    ------
    ParameterError
        If it is no kind of attractor.
    """
    kinds = {kind.label.replace("_", "-"): int(kind) for kind in AttractorKind if kind.label}
    states = {state.symbol: int(state) for state in ImpactState}
    kind, slash, state = what.partition("/") if isinstance(what, str) else ("", "", "")
    if kind not in kinds or (slash and state not in states):
        raise ParameterError("what", what, f"one of {', '.join(kinds)}, alone or with an impact state as in 2T/1")
    meant = found.kind == kinds[kind]
    if slash:
        meant &= found.impact == states[state]
    hits = found.hits.where(meant, 0).sum("attractor").rename("hits")
    starts = found.starts.load()
    share = (hits / starts.where(starts > 0)).rename("share")
    low, high = wilson(hits.values, starts.values)
    result = share.to_dataset().assign(low=share.copy(data=low), high=share.copy(data=high), hits=hits, starts=starts)
    texts = {"share": f"share of the random starts that reached {what}", "low": "lower end of the 95 % interval"}
    for name, text in (texts | {"high": "upper end of the 95 % interval", "hits": "starts that reached it"}).items():
        result[name].attrs = {"long_name": text, "units": "1"}
    return result.assign_attrs(bound=found.attrs["bound"])


def wilson(hits: np.ndarray, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends of Wilson's 95 % interval of shares; 0 and 1 without starts.

    Parameters
    ----------
    hits, starts : int arrays of one shape
    """
    from scipy.stats import binomtest

    pairs, place = np.unique(np.stack([hits.ravel(), starts.ravel()], axis=-1), axis=0, return_inverse=True)
    ends = [binomtest(k, n).proportion_ci(method="wilson") if n else (0.0, 1.0) for k, n in pairs.tolist()]
    low, high = np.array(ends, dtype=float).reshape(-1, 2)[place.ravel()].T
    return low.reshape(hits.shape), high.reshape(hits.shape)
