"""Built pages must load nothing from elsewhere: no script, style, font or picture."""

import re
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

__all__ = ["fetched", "setup"]

#: What a browser fetches by itself: attributes of these elements (not links that a reader follows), and styles.
_ELEMENT = re.compile(r"<(?:script|link|img|iframe|source|audio|video|embed|object)\b[^>]*>", re.IGNORECASE)
_ADDRESS = re.compile(r"""\b(?:src|href|srcset|data|poster)\s*=\s*["']?\s*((?:https?:)?//[^"'\s>]+)""", re.IGNORECASE)
_STYLE = re.compile(r"""(?:url\(\s*["']?|@import\s+["'])\s*((?:https?:)?//[^"')\s]+)""", re.IGNORECASE)


def fetched(text: str) -> list[str]:
    """Addresses elsewhere that a page or a style sheet would fetch."""
    return [address for tag in _ELEMENT.findall(text) for address in _ADDRESS.findall(tag)] + _STYLE.findall(text)


def _check(app: Sphinx, error: Exception | None) -> None:
    if error is not None:
        return
    files = [file for file in sorted(Path(app.outdir).rglob("*")) if file.suffix in (".html", ".css")]
    found = {
        f"{file.relative_to(app.outdir)}: {address}"
        for file in files
        for address in fetched(file.read_text(encoding="utf-8"))
    }
    if found:
        raise ExtensionError("pages fetch from elsewhere: " + ", ".join(sorted(found)))


def setup(app: Sphinx) -> dict:
    """Check the pages once they are written."""
    app.connect("build-finished", _check)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
