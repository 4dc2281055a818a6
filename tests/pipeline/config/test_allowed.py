"""Ranges and words of the schema: refused outside, allowed up to the ends, and true of every file of conf/."""

import dataclasses
import math

import pytest

from pipeline.config.allowed import _ALLOWED, check_one, sentence_of
from pipeline.config.compose import compose
from pipeline.config.schema import Axis, Check, Configuration, Figures, Solver
from pipeline.config.typed import conf_folder
from pipeline.errors import ConfigurationError
from solver import Continuation, Newton, ParameterError, ProvenSeeds


def _bounded(section: type):
    """Every key with something said of its value: its section, name and what that is."""
    for field in dataclasses.fields(section):
        for kind in (field.type, *getattr(field.type, "__args__", ())):
            if dataclasses.is_dataclass(kind):
                yield from _bounded(kind)
        if _ALLOWED in field.metadata:
            yield section, field.name, field.metadata[_ALLOWED]


BOUNDED = list(dict.fromkeys((*_bounded(Configuration), *_bounded(Axis))))


@pytest.mark.parametrize(("section", "name", "bounds"), BOUNDED, ids=[f"{s.__name__}.{n}" for s, n, _ in BOUNDED])
def test_values_outside_are_refused_and_the_ends_are_not(section, name, bounds):
    key = f"somewhere.{name}"
    if bounds.names:
        inside, outside = list(bounds.names), ["", "nonsense", bounds.names[0].upper()]
    else:
        ends = [end for end in (bounds.low, bounds.high) if math.isfinite(end)]
        inside = (ends[1:] if bounds.above else ends) or [bounds.low + 1.0]
        outside = [math.nan, -math.inf, bounds.low - 1, *([bounds.low] if bounds.above else [])]
        outside += [bounds.high + 1] if math.isfinite(bounds.high) else []
    assert inside and outside
    for value in inside:
        check_one(section, key, value)
    for value in outside:
        with pytest.raises(ConfigurationError) as caught:
            check_one(section, key, value)
        said = str(caught.value)
        assert said.startswith(f"{key} = ") and said.endswith(f"it must be {bounds.sentence}")


def test_there_are_ranges():
    assert len(BOUNDED) > 15
    assert sentence_of(Figures, "dpi") == "from 30 to 1200" and sentence_of(Figures, "curves") == ""
    assert sentence_of(Check, "seed") == "from 0 to 2^31 - 1"


_STEPS = [field.name for field in dataclasses.fields(Continuation) if field.name not in ("corrector", "max_points")]


@pytest.mark.parametrize("name", [*_STEPS, "tolerance", "certify_columns"])
def test_ranges_of_the_solver_are_its_own(name):
    made = {"tolerance": lambda value: Newton(tolerance=value), "certify_columns": ProvenSeeds}
    make = made.get(name, lambda value: Continuation(**{name: value}))
    (bounds,) = (bounds for section, key, bounds in BOUNDED if (section, key) == (Solver, name))
    make(bounds.high if math.isfinite(bounds.high) else 1e6)
    for value in [
        bounds.low if bounds.above else bounds.low - 1,
        bounds.high + 1 if math.isfinite(bounds.high) else -1.0,
    ]:
        with pytest.raises(ParameterError):
            make(value)


def test_every_entry_of_a_list_is_looked_at():
    check_one(Figures, "figures.formats", ["png", "svg"])
    with pytest.raises(ConfigurationError, match=r"figures\.formats = 'gif' .* a list of png, pdf, svg"):
        check_one(Figures, "figures.formats", ["png", "gif"])


@pytest.mark.parametrize(
    "override", [f"{file.parent.name}={file.stem}" for file in sorted(conf_folder().glob("*/*.yaml"))]
)
def test_every_file_is_within(override):
    compose([override])


@pytest.mark.parametrize(
    "override",
    [
        "attractors.starts=-1",
        "check.seed=-1",
        "attractors.max_periods=1",
        "cluster.timeout=0",
        "figures.dpi=5000",
        "margins.reach=1",
    ],
)
def test_what_is_typed_is_looked_at_whatever_is_to_be_done(override):
    with pytest.raises(ConfigurationError, match=override.partition("=")[0]):
        compose([override, "stages=[list]"])
