"""What can be taken away from a view: its figure as in print, and its data."""

import io
import json
from collections.abc import Callable

import xarray as xr

from pipeline.analysis.attractors.queries import attractors_of
from pipeline.config.quantities import QUANTITIES
from pipeline.errors import ConfigurationError
from pipeline.explorer import answers
from pipeline.explorer.opened import Content
from pipeline.explorer.reproduction import python_lines
from pipeline.explorer.view_state import ViewState
from pipeline.figures.attractors import draw_attractors
from pipeline.figures.curves import draw_curves
from pipeline.figures.drawing import own_style
from pipeline.figures.map import draw_map, draw_window
from pipeline.figures.motion import draw_motions
from pipeline.figures.quantity_map import draw_quantity_map
from pipeline.figures.verification import draw_verification
from pipeline.plan.scales import scales_of
from pipeline.plane.datasets import dataset_of_branches, dataset_of_motions
from pipeline.plane.stored import StoredPlane

__all__ = ["FORMATS", "download", "file_name"]

_FIGURES, _DATA, _DPI = ("png", "pdf", "svg"), ("csv", "nc", "json"), 200
#: What can be taken -> formats.
FORMATS = {"map": _FIGURES, "curves": (*_FIGURES, *_DATA), "motions": (*_FIGURES, *_DATA)}


def file_name(content: Content, state: ViewState, what: str, kind: str) -> str:
    """What the file is called: after the store, the place and what is changed."""
    words = [content.path.stem, what]
    if what != "map" and state.at is not None:
        axes = (content.plan.sweep, content.plan.parameter)
        shown = list(zip(axes, state.at, strict=True))[1 if what == "curves" else 0 :]
        words += [f"{axis.name}={value:.6g}" for axis, value in shown]
        words += [f"{name}={value:.6g}" for name, value in state.fixed]
    return f"{'-'.join(words)}.{kind}"


def download(content: Content, state: ViewState, what: str, kind: str) -> bytes:
    """A file of a view.

    Parameters
    ----------
    content : Content
    state : ViewState
    what : str
        One of `FORMATS`: the map of the layer in the window, the curves of the row through the place, or the
        motions at the place.
    kind : str
        One of its formats.

    Raises
    ------
    ConfigurationError
        If there is no such file of this view.
    """
    if kind not in FORMATS.get(what, ()):
        raise ConfigurationError(f"{what} is not given as {kind}")
    if what != "map" and state.at is None:
        raise ConfigurationError(f"{what}: click a place on the map first")
    if kind in _FIGURES:
        return _figure(content, state, what, kind)
    dataset = _dataset(content, state, what)
    dataset.attrs |= {
        "title": file_name(content, state, what, kind),
        "lines": python_lines(state, content.path, content.plan),
    }
    if kind == "csv":
        return dataset.to_dataframe().to_csv().encode()
    if kind == "json":
        return json.dumps(dataset.to_dict(), indent=1, default=float).encode()
    return bytes(_without_lists(dataset).to_netcdf())


def _dataset(content: Content, state: ViewState, what: str) -> xr.Dataset:
    (x, p), fixed = state.at, dict(state.fixed)
    plan = content.answers.plan(fixed)
    scales = scales_of(plan) if state.physical else None
    if what == "curves":
        return dataset_of_branches(content.answers.ask(answers.row, fixed, p), scales)
    found = content.answers.ask(answers.motions, fixed, x, p)
    return dataset_of_motions(plan, found.values, {plan.sweep.name: x, plan.parameter.name: p}, scales)


def _without_lists(dataset: xr.Dataset) -> xr.Dataset:
    """With attributes that NetCDF has room for: texts and numbers."""
    found = dataset.copy()
    for one in (found, *found.variables.values()):
        words = {name: value for name, value in one.attrs.items() if isinstance(value, list | tuple)}
        one.attrs |= {name: " ".join(map(str, value)) for name, value in words.items()}
    return found


def _figure(content: Content, state: ViewState, what: str, kind: str) -> bytes:
    file = io.BytesIO()
    with own_style():
        _DRAWN[what](content, state).savefig(file, format=kind, dpi=_DPI)
    return file.getvalue()


def _map(content: Content, state: ViewState):
    plane = StoredPlane(content.path, content.plan, dynamic=state.layer == "dynamic", physical=state.physical)
    if state.layer in QUANTITIES:
        return draw_quantity_map(plane, state.layer, "worst", state.window)
    if state.layer in _OF_ATTRACTORS:
        return _OF_ATTRACTORS[state.layer](plane, attractors_of(content.path), state.window)
    return draw_map(plane) if state.window is None else draw_window(plane, list(state.window))


def _curves(content: Content, state: ViewState):
    fixed = dict(state.fixed)
    row = content.answers.ask(answers.row, fixed, state.at[1])
    return draw_curves(StoredPlane(content.path, row.plan, physical=state.physical), None, rows=[row])


def _motions(content: Content, state: ViewState):
    fixed = dict(state.fixed)
    found = content.answers.ask(answers.integrated, fixed, *state.at)
    plane = StoredPlane(content.path, content.answers.plan(fixed), physical=state.physical)
    return draw_motions(plane, found)


_OF_ATTRACTORS: dict[str, Callable] = {"attractors": draw_attractors, "credibility": draw_verification}
_DRAWN: dict[str, Callable] = {"map": _map, "curves": _curves, "motions": _motions}
