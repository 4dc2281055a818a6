"""Docstrings of the solver: every argument is described, and what is raised."""

import importlib
import inspect
import pkgutil
from dataclasses import is_dataclass

import pytest

import solver
from tests.public import documented, section
from tests.solver.test_public_api import PUBLIC, asked

_FEW = 3


def of_all_modules() -> dict[str, object]:
    """Functions and dataclasses that modules offer to others, kernels excepted, by name."""
    found = {}
    for module in pkgutil.walk_packages(solver.__path__, "solver."):
        offered = importlib.import_module(module.name)
        for name in getattr(offered, "__all__", ()):
            value = getattr(offered, name)
            if inspect.isfunction(value) or (inspect.isclass(value) and is_dataclass(value)):
                found[f"{value.__module__}.{name}"] = value
    return found


OFFERED = of_all_modules()


def lacking(function, names) -> set[str]:
    """Arguments that the docstring of a function, or of a class that it extends, does not describe."""
    documents = [function, *getattr(function, "__mro__", ())[1:-1]]
    return set(names) - set().union(*map(documented, documents))


@pytest.mark.parametrize("name", OFFERED)
def test_arguments_are_described(name):
    names = list(inspect.signature(OFFERED[name]).parameters)
    if len(names) >= _FEW:
        assert not lacking(OFFERED[name], names), f"{name} does not describe these"


@pytest.mark.parametrize("name", PUBLIC)
def test_arguments_of_public_methods_are_described(name):
    names = [parameter.name for parameter in PUBLIC[name].parameters]
    if len(names) >= _FEW:
        assert not lacking(PUBLIC[name].function, names), f"{name} does not describe these"


@pytest.mark.parametrize("name", asked())
def test_what_is_raised_is_said(name):
    function, names = PUBLIC[name].function, PUBLIC[name].parameters
    raised = section(function, "Raises")
    if len(names) < _FEW:
        raised = raised or (inspect.getdoc(function) or "").partition("raises ")[2]
    assert "ParameterError" in raised or "occurrences" in raised, f"{name} can raise ParameterError"
