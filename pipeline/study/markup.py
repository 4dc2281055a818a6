"""Plain text as Markdown."""

import re
from collections.abc import Iterable, Sequence

__all__ = ["escaped", "pipes"]

_MARKUP = re.compile(r"[\\|*`]|<(?=[A-Za-z/!?])")


def escaped(text: str) -> str:
    """Text that no reader of Markdown takes for markup; underscores inside words are safe."""
    return _MARKUP.sub(lambda match: f"\\{match[0]}", text)


def pipes(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A pipe table of plain text."""
    lines = [headings, ("---",) * len(headings), *rows]
    return "\n".join("| " + " | ".join(map(escaped, cells)) + " |" for cells in lines)
