"""The group `verification` of a store: what integration saw, one entry per sample, and every cell's credibility."""

import dataclasses
import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline import store
from pipeline.analysis.verification.credibility import Credibility
from pipeline.analysis.verification.starts import Start
from pipeline.analysis.verification.verdicts import Seen, Verdict
from pipeline.config.schema import Verify
from pipeline.plan.plan import Plan
from pipeline.store import groups
from solver import ImpactState, domain_labels, domain_parts
from solver.timedomain import AttractorKind

__all__ = ["StoredVerification", "digest_of", "read_verification", "write_verification"]

GROUP = "verification"

_INTEGERS = {
    "row": "int32",
    "column": "int32",
    "solution": "int32",
    "stratified": "int8",
    "beside": "int8",
    "start_impact": "int8",
    "kind": "int8",
    "period": "int32",
    "impact": "int8",
    "periods_used": "int32",
    "verdict": "int8",
}
_NUMBERS = (
    "start_mean",
    "start_amplitude",
    "mean",
    "amplitude",
    "mean_error",
    "amplitude_error",
    "lyapunov",
    "largest_multiplier",
)
_LAYERS = {"domain_low": "uint16", "domain_high": "uint16", "unstable": "int8", "credibility": "int8"}


@dataclass(frozen=True, eq=False)
class StoredVerification:
    """A verification as plain arrays.

    Parameters
    ----------
    samples : dict
        Name -> (k,) array, of the dimension `sample`.
    layers : dict
        Name -> (P, X) array: domain_low, domain_high, unstable, credibility.
    row_messages : (P,) array of str
        Why a row could not be swept again.
    orders : tuple of int
        The two orders; empty where the map's own order leaves none.
    made_from : str
        Digest of the rows and settings.
    """

    samples: dict[str, np.ndarray]
    layers: dict[str, np.ndarray]
    row_messages: np.ndarray
    orders: tuple[int, ...]
    made_from: str


def digest_of(plan: Plan, domain: np.ndarray, settings: Verify) -> str:
    """Digest of what a verification depends on: configuration, labels of the complete rows, its settings."""
    text = json.dumps({"numbers": plan.digest, **dataclasses.asdict(settings)}, sort_keys=True)
    return hashlib.sha256(text.encode() + domain.astype("<u2").tobytes()).hexdigest()[:16]


def sample_arrays(starts: list[Start], seen: list[Seen], stratified, beside) -> dict[str, np.ndarray]:
    """Starts and what became of them, as arrays."""
    of_start = {
        "row": "row",
        "column": "column",
        "solution": "solution",
        "start_mean": "mean",
        "start_amplitude": "amplitude",
        "start_impact": "impact",
    }
    of_seen = (
        "verdict",
        "kind",
        "period",
        "mean",
        "amplitude",
        "impact",
        "lyapunov",
        "largest_multiplier",
        "periods_used",
    )
    values = {name: np.array([getattr(start, source) for start in starts]) for name, source in of_start.items()}
    values |= {name: np.array([getattr(one, name) for one in seen]) for name in of_seen}
    values |= {"stratified": np.asarray(stratified), "beside": np.asarray(beside)}
    for name in ("mean", "amplitude"):
        values[f"{name}_error"] = values[name] - values[f"start_{name}"]
    arrays = {name: values[name].astype(kind) for name, kind in _INTEGERS.items()}
    arrays |= {name: values[name].astype(float) for name in _NUMBERS}
    arrays["message"] = np.array([one.message for one in seen], dtype=object)
    return arrays


def write_verification(path: Path, plan: Plan, found: StoredVerification, settings: Verify) -> None:
    """Put a verification into its store, in place of what was there."""
    import xarray as xr

    described = _attributes(plan, found)
    row, column = plan.parameter, plan.sweep
    variables = {name: ("sample", data, described[name]) for name, data in found.samples.items()}
    variables |= {
        name: ((row.name, column.name), np.asarray(found.layers[name], kind), described[name])
        for name, kind in _LAYERS.items()
    }
    variables["row_message"] = (row.name, found.row_messages, described["row_message"])
    places = {axis.name: (axis.name, axis.values, store.axis_attributes(axis.name)) for axis in (row, column)}
    for axis, index in ((column, "column"), (row, "row")):
        place = axis.values[found.samples[index]]
        places[f"sample_{axis.name}"] = ("sample", place, store.axis_attributes(axis.name))
    attributes = {
        "configuration_hash": plan.digest,
        "made_from": found.made_from,
        "orders": list(found.orders),
        **dataclasses.asdict(settings),
    }
    groups.write_group(path, GROUP, xr.Dataset(variables, places, attributes))


def read_verification(path: Path) -> StoredVerification | None:
    """What is stored; None if nothing is."""
    group = groups.open_group(path, GROUP)
    if group is None:
        return None
    samples = {name: group[name][...] for name in (*_INTEGERS, *_NUMBERS, "message")}
    layers = {name: group[name][...] for name in _LAYERS}
    return StoredVerification(
        samples, layers, group["row_message"][...], tuple(group.attrs["orders"]), group.attrs["made_from"]
    )


def _attributes(plan: Plan, found: StoredVerification) -> dict[str, dict]:
    def said(long_name, units=None, **more):
        return {"long_name": long_name, **({"units": units} if units else {}), **more}

    def yes(text):
        return said(text, flag_values=[0, 1], flag_meanings="no yes")

    states = store.flags(ImpactState, [state.symbol for state in ImpactState])
    most = max(
        plan.max_solutions,
        *(int(domain_parts(found.layers[f"domain_{end}"])[0].max(initial=0)) for end in ("low", "high")),
    )
    names = [f"at order {order}" for order in found.orders] or ["at no order: the map's own is too high"] * 2
    labels = store.label_flags(domain_labels(most))
    return {
        "row": said("index of the sample's row"),
        "column": said("index of the sample's column"),
        "solution": said("index of the solution that the integration started on"),
        "stratified": yes("drawn for its label"),
        "beside": yes("drawn because a neighbour has another label"),
        "start_mean": said("mean of the map's solution", "1"),
        "start_amplitude": said("amplitude of the fundamental of the map's solution", "1"),
        "start_impact": said("impact state of the map's solution", **states),
        "kind": said("kind of the attractor", **store.flags(AttractorKind)),
        "period": said("forcing periods after which the attractor repeats; 0 if it does not", "1"),
        "mean": said("mean of the attractor", "1"),
        "amplitude": said("amplitude of the fundamental of the attractor", "1"),
        "mean_error": said("mean of the attractor less that of the map's solution", "1"),
        "amplitude_error": said("amplitude of the attractor less that of the map's solution", "1"),
        "impact": said("impact state seen; -1: none", **states),
        "lyapunov": said("largest Lyapunov exponent per unit of time", "1"),
        "largest_multiplier": said("largest modulus of the multipliers of a periodic attractor over its period", "1"),
        "periods_used": said("forcing periods integrated", "1"),
        "verdict": said("whether the map's solution was found", **store.flags(Verdict)),
        "message": said("why the integration failed, else empty"),
        "domain_low": said(f"n/I label {names[0]}; 0: none", **labels),
        "domain_high": said(f"n/I label {names[1]}; 0: none", **labels),
        "unstable": said(
            "a solution counted by the label is dynamically unstable at the higher order; -1: unknown",
            flag_values=[-1, 0, 1],
            flag_meanings="unknown stable unstable",
        ),
        "credibility": said("how far the map's label can be trusted", **store.flags(Credibility)),
        "row_message": said("why the row could not be swept at the higher orders, else empty"),
    }
