"""Every public function and method of some modules, by inspection, and what may be wrong with an argument."""

import enum
import functools
import importlib
import inspect
import re
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, is_dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

__all__ = [
    "COUNT",
    "NAME",
    "NOT_NEGATIVE",
    "NUMBER",
    "OBJECT",
    "POSITIVE",
    "RANGE",
    "Argument",
    "Public",
    "argument",
    "array",
    "assert_wrong_calls_are_refused",
    "documented",
    "optional",
    "public",
    "section",
]

_SECTION = r"^{}\n-+\n(.*?)(?=^\w+\n-+\n|\Z)"


@dataclass(frozen=True)
class Public:
    """A public function, class or method.

    Parameters
    ----------
    name : str
        Module, class and function.
    function : callable
    method : bool
        Whether it is called on an object.
    """

    name: str
    function: Callable
    method: bool

    @property
    def parameters(self) -> list[inspect.Parameter]:
        """What a caller gives."""
        return list(inspect.signature(self.function).parameters.values())[int(self.method) :]


def public(modules: tuple[str, ...], *only: str) -> dict[str, Public]:
    """Everything that a user of some modules can call, by name; of their names all unless some are given."""
    return {found.name: found for module in modules for found in _of_module(module, only)}


def _of_module(name: str, only: tuple[str, ...]) -> Iterator[Public]:
    module = importlib.import_module(name)
    for key in only or module.__all__:
        value = getattr(module, key)
        if inspect.isfunction(value):
            yield Public(f"{name}.{key}", value, False)
        elif (
            inspect.isclass(value) and not issubclass(value, enum.Enum | Exception) and Protocol not in value.__bases__
        ):
            if is_dataclass(value) or "__init__" in vars(value):
                yield Public(f"{name}.{key}", value, False)
            for method in dir(value):
                static = inspect.getattr_static(value, method)
                if method[0] != "_" and (inspect.isfunction(static) or isinstance(static, staticmethod)):
                    yield Public(f"{name}.{key}.{method}", getattr(value, method), inspect.isfunction(static))


class Argument(NamedTuple):
    """A value that is right for a parameter, values that are wrong, and by what name an error may call it."""

    right: Any
    wrong: tuple
    names: tuple[str, ...]


def argument(right, wrong, *names: str) -> Argument:
    """An argument; errors call it by its own name or one of `names`."""
    return Argument(right, tuple(wrong), names)


NUMBER = (None, "1", True, np.True_, np.nan, np.inf, -np.inf, 1j, [1.0], {}, np.ma.masked, 10**400)
POSITIVE = (*NUMBER, 0.0, -1.0)
NOT_NEGATIVE = (*NUMBER, -1.0)
COUNT = (None, "1", True, np.True_, 2.5, 2.0, np.nan, np.inf, [1], -1, 10**18)
NAME = ("foo", "", None, 1, True, ["omega"], np.nan, b"omega")
OBJECT = (None, 1, "foo", [], {}, object())
RANGE = (None, 1.0, "ab", [], (1.0,), (1.0, 1.0), (2.0, 1.0), (np.nan, 1.0), (0.1, np.inf), (0.1, 0.2, 0.3), ("a", "b"))


def optional(wrong: tuple) -> tuple:
    """The wrong values without None."""
    return tuple(value for value in wrong if value is not None)


def array(right, *further, finite: bool = True, any_shape: bool = False, empty: bool = False) -> tuple:
    """What is wrong in place of an array of the shape of `right`, and `further` values.

    With `finite` nan and infinity are wrong, without `any_shape` other shapes; with `empty` an empty one is not.
    """
    right = np.asarray(right, dtype=float)
    size, shape = right.size, right.shape
    entries = [[None], ["x"], [True], [{}]]
    filled = [np.resize(np.array(entry, dtype=object), size).reshape(shape).tolist() for entry in entries]
    masked = np.ma.masked_array(right, np.arange(size).reshape(shape) == size - 1)
    wrong = [None, "ab", {}, object(), *filled, masked, right.astype(object), right > 0.0, right.astype(str)]
    if finite:
        for bad in (np.nan, np.inf):
            one = right.copy()
            one.flat[size // 2] = bad
            wrong.append(one)
    if not any_shape:
        wrong += [1.0, right[None, None], np.append(right.ravel(), 1.0)[None, None]] + ([] if empty else [[]])
    return (*wrong, *further)


def section(function: Callable, title: str) -> str:
    """A section of a docstring; empty where there is none."""
    found = re.search(_SECTION.format(title), inspect.getdoc(function) or "", flags=re.MULTILINE | re.DOTALL)
    return found[1] if found else ""


def documented(function: Callable) -> set[str]:
    """Names in the section Parameters of a docstring."""
    heads = [line.partition(" : ")[0] for line in section(function, "Parameters").splitlines() if line[:1].strip()]
    return {name.strip(" *") for head in heads for name in head.split(",")}


def assert_wrong_calls_are_refused(function: Callable, arguments: dict, *errors: type[Exception]) -> None:
    """Fail unless the right arguments are taken, and each wrong one is refused by one of the errors, on one line.

    Parameters
    ----------
    function : callable
    arguments : dict of str to Argument
        `self` is the object of a method.
    *errors : type
        An error must call the parameter by its name, or one of those that its `Argument` has.
    """
    if "self" in arguments:
        function = functools.partial(function, arguments.pop("self"))
    right = {name: one.right for name, one in arguments.items()}
    function(**right)
    faults = []
    for name, one in arguments.items():
        for value in one.wrong:
            try:
                # A warning would be another way to let it pass.
                with warnings.catch_warnings():
                    warnings.simplefilter("error")
                    found = function(**{**right, name: value})
            except errors as error:
                called = str(error).partition(" = ")[0]
                if not any(said in called for said in (name, *one.names)) or "\n" in str(error):
                    faults.append(f"{name} = {value!r}: {error}")
            except Exception as error:
                faults.append(f"{name} = {value!r}: {type(error).__name__}: {error}")
            else:
                faults.append(f"{name} = {value!r} is answered with {str(found)[:80]}")
    assert not faults, "\n".join(faults)
