"""The public names of a package with their docstrings, as instructions for autodoc."""

import enum
import importlib
import inspect
import sys

__all__ = ["names", "public"]


def public(package: str) -> dict[str, str]:
    """Public name -> the module that defines it, in the order of these modules."""
    listed = importlib.import_module(package).__all__
    return dict(sorted(((name, _home(package, name)) for name in listed), key=lambda item: (item[1], item[0])))


def names(package: str) -> str:
    """Docstrings of the public names of a package, a section for every module or room of it that defines some.

    Parameters
    ----------
    package : str
        Dotted name of a package with `__all__`.
    """
    lines, section, depth = [], None, package.count(".") + 2
    for name, home in public(package).items():
        part = ".".join(home.split(".")[:depth])
        if part != section:
            section = part
            lines += [f"## {section}", "", _summary(section), ""]
        value = getattr(importlib.import_module(package), name)
        if inspect.isclass(value):
            shown = [":members:", ":undoc-members:"] if issubclass(value, enum.Enum) else [":members:"]
            lines += _directive(f"autoclass:: {package}.{name}", *shown)
        elif callable(value):
            lines += _directive(f"autofunction:: {package}.{name}")
        else:
            # The comment that describes it stands where it is defined.
            lines += _directive(f"autodata:: {home}.{name}")
    return "\n".join(lines)


def _home(package: str, name: str) -> str:
    """The module that defines a name of a package."""
    value = getattr(importlib.import_module(package), name)
    module = getattr(value, "__module__", "")
    if module.startswith(f"{package}."):
        return module
    loaded = sorted(other for other in sys.modules if other.startswith(f"{package}."))
    # Or of another package, whose names this one hands on.
    return next((other for other in loaded if name in getattr(sys.modules[other], "__all__", ())), module)


def _summary(module: str) -> str:
    """The first paragraph of a module's docstring."""
    return (inspect.getdoc(importlib.import_module(module)) or "").partition("\n\n")[0]


def _directive(*lines: str) -> list[str]:
    head, *options = lines
    return ["```{eval-rst}", f".. {head}", *(f"   {option}" for option in options), "```", ""]
