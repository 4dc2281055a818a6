"""The examples in the docstrings of `solver` run."""

import doctest
import importlib
import pkgutil

import pytest

import solver

MODULES = ["solver", *(module.name for module in pkgutil.walk_packages(solver.__path__, "solver."))]


@pytest.mark.parametrize("name", MODULES)
def test_doctests(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_there_are_examples_at_all():
    for name, fewest in (("solver.contact.impact", 2), ("solver.contact.dead_zone", 1)):
        assert doctest.testmod(importlib.import_module(name)).attempted >= fewest, name


def test_everything_exported_exists_and_is_documented():
    for name in MODULES:
        module = importlib.import_module(name)
        assert module.__doc__
        for public in getattr(module, "__all__", ()):
            thing = getattr(module, public)
            # Functions, kernels and classes have names of their own; numbers and numba types have not.
            assert not hasattr(thing, "__name__") or thing.__doc__, f"{name}.{public}"
