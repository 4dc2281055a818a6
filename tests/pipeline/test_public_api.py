"""Every public function of the pipeline, and every question to a stored plane, refuses what it cannot use.

As `tests.solver.test_public_api`: what is public is found by inspection.
"""

import numpy as np
import pytest

import pipeline
from pipeline.__main__ import main
from pipeline.errors import ConfigurationError
from pipeline.multirun.index import Index
from pipeline.study.statements import STATEMENTS
from solver import ParameterError
from tests.pipeline.planes import COARSE, small_plan, small_store, traced_store
from tests.public import NAME, NUMBER, OBJECT, RANGE, argument, array, assert_wrong_calls_are_refused, optional, public

PUBLIC = public(("pipeline", "pipeline.api"))
#: What the documentation calls besides.
PUBLIC |= public(("pipeline.figures.plots",))
PUBLIC |= public(("pipeline.store",), "read_plan") | public(("pipeline.study.statements",), "evaluate", "evaluate_all")
#: Made by `open_plane`; the others are given by both names.
RESULTS = {"pipeline.api.OpenPlane", "pipeline.api.OpenVolume", "pipeline.api.Study", "pipeline.figures.plots.Plots"}
TWICE = {"pipeline.api.compute", "pipeline.api.open_plane", "pipeline.api.open_study"}

PATHS = (None, 1, True, [], {}, b"omega_fe", "", "a\0b", "x" * 5000, "nowhere.zarr")
WRONG_PLANES = (None, 1, "omega_fe", ["omega_fe"], *({"omega_fe": path} for path in PATHS[:-1]))
LABELS = (*(value for value in NAME if value is not None), "2/7", "2/1-0", "0/0", "1/-")


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    path = tmp_path_factory.mktemp("asked") / "omega_fe.zarr"
    planned = small_plan(*COARSE)
    traced_store(path, planned)
    words = [*COARSE, "stages=[attractors]", "cluster=none", "store.name=omega_fe"]
    few = ["attractors.columns=3", "attractors.rows=2", "attractors.starts=1", "attractors.branches=2"]
    folders = [f"store.root={path.parent}", f"output.root={path.parent / 'outputs'}"]
    assert main([*words, *few, *folders]) == 0
    Index(path.parent, (), {}).write()
    return pipeline.open_plane(path)


def place():
    """A point of the plane; what is wrong with either coordinate."""
    return {
        "omega": argument(0.6, (*NUMBER, 0.0, 2.5, np.array([0.6, 0.7])), "place"),
        "f_e": argument(0.2, (*NUMBER, -0.1, 5.0), "place"),
    }


def row():
    return {"f_e": argument(0.2, (*NUMBER, -0.1, 5.0), "place")}


def followed(key):
    """A row that is followed in few steps."""
    return {
        "columns": argument(3, ("foo", 2.5, [], {}, 0, 1, -1, 10**9)),
        "max_periods": argument(800, ("foo", 2.5, [], {}, 0, 799, -1, 10**9)),
        "f_e": argument(0.2, (*(v for v in NUMBER if v != [1.0]), -0.1, 5.0, [0.2]), f"{key}.value"),
    }


def window(plane):
    return {
        "label": argument("2/0-1", LABELS),
        "window": argument((0.5, 0.8), optional((*RANGE, (0.0, 0.8), (0.5, 9.0)))),
    }


def physical():
    # The gear of the plane is dimensionless.
    return {"physical": argument(False, (True, 1, "yes", None, []))}


WRONG_WORDS = ("foo", "", None, 1, True, [])


def volume(plane):
    """A volume beside the plane."""
    path = plane.path.parent / "omega_b_fe.zarr"
    if not path.exists():
        small_store(path, small_plan("plane=omega_b_fe", "plane.parameter2.num=2", columns=9, rows=3))
    return pipeline.open_plane(path)


CALLS = {
    "pipeline.compute": lambda plane: {
        "plane": argument("omega_fe", (None, 1, True, "", [], {}, "nowhere"), "omega_fe"),
        "overrides": argument(
            [*COARSE[1:], f"store.root={plane.path.parent}"],
            (None, 1, "gear.b=1", [1], [None], ["nothing=1"]),
            "nothing",
        ),
        "config_dir": argument(None, [path for path in PATHS if path is not None], "nowhere.zarr", "config-dir"),
        "progress": argument(False, (1, "yes", [], {})),
    },
    "pipeline.figures.plots.Plots.backbone": lambda plane: {
        "self": plane.plot,
        "units": argument("dimensionless", (*WRONG_WORDS, "physical")),
    },
    "pipeline.figures.plots.Plots.curves": lambda plane: {
        "self": plane.plot,
        "units": argument("dimensionless", WRONG_WORDS),
        "quantity": argument("rms", [word for word in WRONG_WORDS if word is not None]),
        "f_e": argument(0.2, (*(v for v in NUMBER if v is not None and v != [1.0]), -0.1, 5.0, []), "curves"),
    },
    "pipeline.figures.plots.Plots.diagram": lambda plane: {
        "self": plane.plot,
        "units": argument("dimensionless", (*WRONG_WORDS, "physical")),
        **followed("diagram"),
    },
    "pipeline.figures.plots.Plots.spectrum": lambda plane: {
        "self": plane.plot,
        "direction": argument("down", optional(WRONG_WORDS)),
        "of": argument("force", optional(WRONG_WORDS)),
        "axis": argument("order", optional(WRONG_WORDS)),
        "orders": argument(4.0, ("foo", [], {}, np.nan, np.inf, 0.5, 61.0)),
        "periods": argument(4, ("foo", 2.5, [], {}, 0, -1, 10**9)),
        "units": argument("dimensionless", (*WRONG_WORDS, "physical")),
        **followed("spectrum"),
    },
    "pipeline.figures.plots.Plots.map": lambda plane: {
        "self": plane.plot,
        "window": argument((0.5, 0.8, 0.1, 0.2), optional(array((0.5, 0.8, 0.1, 0.2), (0.8, 0.5, 0.1, 0.2), [1.0]))),
        "stability": argument("static", WRONG_WORDS),
        "units": argument("dimensionless", WRONG_WORDS),
        "quantity": argument(None, [word for word in WRONG_WORDS if word is not None]),
        "of": argument("worst", WRONG_WORDS),
    },
    "pipeline.figures.plots.Plots.multipliers": lambda plane: {
        "self": plane.plot,
        "units": argument("dimensionless", WRONG_WORDS),
        "f_e": argument(0.2, (*(v for v in NUMBER if v != [1.0]), -0.1, 5.0, []), "multipliers"),
    },
    "pipeline.figures.plots.Plots.motion": lambda plane: {
        "self": plane.plot,
        "units": argument("dimensionless", WRONG_WORDS),
        "attractors": argument({"starts": 1}, (1, "starts", True, [], {1: 2}, {"stars": 1}, {"starts": -1})),
        **place(),
    },
    "pipeline.open_plane": lambda plane: {
        "name": argument(plane.path, PATHS, "nowhere.zarr"),
        "root": argument("outputs", PATHS[:-1]),
        "storage_options": argument(None, (1, "region", True, [], {"region": "x"})),
    },
    "pipeline.open_study": lambda plane: {
        "root": argument(plane.path.parent, PATHS, "nowhere.zarr"),
        "storage_options": argument(None, (1, "region", True, [], {"region": "x"})),
    },
    "pipeline.scales_of": lambda plane: {"plan": argument(plane.plan, OBJECT)},
    "pipeline.store.read_plan": lambda plane: {"path": argument(plane.path, PATHS, "nowhere.zarr")},
    "pipeline.study.statements.evaluate": lambda plane: {
        "statement": argument(STATEMENTS[0], OBJECT),
        "planes": argument({}, WRONG_PLANES),
    },
    "pipeline.study.statements.evaluate_all": lambda plane: {"planes": argument({}, WRONG_PLANES)},
    "pipeline.thresholds": lambda plane: {"path": argument(plane.path, PATHS, "nowhere.zarr"), **window(plane)},
    "pipeline.api.OpenVolume.layer": lambda plane: {
        "self": volume(plane),
        "value": argument(0.2, (*NUMBER, -0.1, 5.0), "f_e"),
    },
    "pipeline.api.OpenPlane.attractors_at": lambda plane: {"self": plane, **place()},
    "pipeline.api.OpenPlane.isolated_branches": lambda plane: {"self": plane, **row()},
    "pipeline.api.OpenPlane.basin_share": lambda plane: {
        "self": plane,
        "what": argument("2T", (*NAME, "2t", "1T/7", "9T", {})),
    },
    "pipeline.api.OpenPlane.curve_at": lambda plane: {"self": plane, **row(), **physical()},
    "pipeline.api.OpenPlane.curve_near": lambda plane: {"self": plane, **row(), **physical()},
    "pipeline.api.OpenPlane.explore": lambda plane: {
        "self": plane,
        "view": argument("layer=dynamic&at=0.6,0.2", (None, 1, True, [], {}, "at=9,9", "layer=nothing", "foo"), "view"),
    },
    "pipeline.api.OpenPlane.label_at": lambda plane: {"self": plane, **place()},
    "pipeline.api.OpenPlane.label_near": lambda plane: {"self": plane, **place()},
    "pipeline.api.OpenPlane.label_of": lambda plane: {
        "self": plane,
        "code": argument(132, (None, "1", True, 2.5, 2.0, np.nan, -1, 2**16, [1], {})),
    },
    "pipeline.api.OpenPlane.mask": lambda plane: {"self": plane, "what": argument("jump", (*NAME, "2/7", "99/0", {}))},
    "pipeline.api.OpenPlane.motions_at": lambda plane: {"self": plane, **place(), **physical()},
    "pipeline.api.OpenPlane.motions_near": lambda plane: {"self": plane, **place(), **physical()},
    "pipeline.api.OpenPlane.nearest_boundaries": lambda plane: {"self": plane, **place()},
    "pipeline.api.OpenPlane.thresholds": lambda plane: {"self": plane, **window(plane)},
}


def test_every_public_function_has_its_wrong_calls():
    asked = {name for name, one in PUBLIC.items() if one.parameters} - RESULTS - TWICE
    assert asked == set(CALLS) and set(PUBLIC) >= RESULTS | TWICE


@pytest.mark.parametrize("name", CALLS)
def test_what_is_right_is_taken_and_what_is_wrong_is_named(name, plane):
    assert_wrong_calls_are_refused(PUBLIC[name].function, CALLS[name](plane), ParameterError, ConfigurationError)


@pytest.mark.parametrize("name", [name for name in CALLS if name.endswith(("_at", "_near", "nearest_boundaries"))])
def test_places_are_given_by_the_names_of_the_axes(name, plane):
    for given in ({}, {"b": 1.0}, {"omega": 0.6}, {"omega": 0.6, "f_e": 0.2, "b": 1.0}):
        with pytest.raises(ParameterError, match="place = "):
            PUBLIC[name].function(plane, **given)
