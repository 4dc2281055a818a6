"""Parts of pages that are made from the program itself: `<!-- generated: keys store -->` becomes a table of keys."""

import re

from sphinx.application import Sphinx

from bevelmap_docs import cases, commands, configuration, names, store

__all__ = ["GENERATORS", "MARK", "expanded", "setup"]

MARK = re.compile(r"^<!-- generated: (\w+)((?: [\w.]+)*) -->$", re.MULTILINE)
GENERATORS = {
    "keys": configuration.keys,
    "choices": configuration.choices,
    "stages": commands.stages,
    "usage": commands.usage_text,
    "arrays": store.arrays,
    "names": names.names,
    "cases": cases.published,
}


def expanded(text: str) -> str:
    """A page with all its marks replaced by what they stand for.

    Raises
    ------
    KeyError
        If a mark names no generator.
    """
    return MARK.sub(lambda mark: GENERATORS[mark[1]](*mark[2].split()), text)


def _expand(app: Sphinx, page: str, source: list[str]) -> None:
    source[0] = expanded(source[0])


def _keep_bars(app: Sphinx, what: str, name: str, value, options, lines: list[str]) -> None:
    """Docstrings write moduli as |x|, which is a substitution to docutils."""
    lines[:] = [line.replace("|", r"\|") for line in lines]


def setup(app: Sphinx) -> dict:
    """Expand pages as they are read."""
    app.connect("source-read", _expand)
    app.connect("autodoc-process-docstring", _keep_bars)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
