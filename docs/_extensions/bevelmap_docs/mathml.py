"""Formulas as MathML, which browsers draw by themselves: no script and no font is fetched from anywhere."""

import re
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator

__all__ = ["mathml", "setup"]

#: What the pages write, as GitHub reads it, and docutils does not know.
_WORDS = {r"\dots": r"\ldots", r"\gt": ">", r"\lt": "<", "°": r"^\circ"}
#: TeX takes \frac12 for one half, docutils for the number 12 over what follows.
_FRACTION = re.compile(r"(frac)(\d)(\d|\\[a-z]+)")
_PRIMES = re.compile(r"('+)(?:\^(\w))?")
_ACCENTS, _SIGNS, _OPENING = frozenset("˙¨^ˆ~˜"), frozenset("−+±∓"), frozenset(",;=<>≤≥([|")
_APPLY = "\u2061"
_THIN = "0.1667em"


def mathml(formula: str, block: bool) -> str:
    """One formula of LaTeX as MathML.

    Parameters
    ----------
    formula : str
    block : bool
        Whether it stands on lines of its own.

    Raises
    ------
    docutils.utils.math.MathError
        If the formula has a command that docutils does not know.
    """
    for word, known in _WORDS.items():
        formula = re.sub(re.escape(word) + r"(?![a-zA-Z])", lambda _, known=known: known, formula)
    formula = _FRACTION.sub(r"\1{\2}{\3}", formula)
    formula = _PRIMES.sub(lambda found: "^{" + len(found[1]) * r"\prime " + (found[2] or "") + "}", formula)
    text = tex2mathml(formula, as_block=block).replace("&ApplyFunction;", _APPLY)
    root = ElementTree.fromstring(re.sub(r' xmlns="[^"]*"', "", text))
    for element in root.iter():
        element[:] = [_beside(child) for child in element]
        _space(element)
    return ElementTree.tostring(root, encoding="unicode")


def _beside(element: Element) -> Element:
    """An accented symbol with its index beside it, which docutils sets below, and its accent clear of it."""
    if element.tag == "mover" and element[1].text in _ACCENTS:
        element.attrib.clear()
    if element.tag != "munderover" or element[2].text not in _ACCENTS:
        return element
    base, index, accent = element
    accented, found = Element("mover"), Element("msub")
    accented.extend([base, accent])
    found.extend([accented, index])
    return found


def _space(row: Element) -> None:
    """The spaces of TeX: thin ones around names of functions, none around bars and slashes."""
    children = [child for child in row if child.text != _APPLY]
    stretched = any(child.tag == "mtable" or "maxsize" in child.attrib for child in children)
    for before, child, after in zip([None, *children], children, [*children[1:], None], strict=False):
        if child.tag == "mi" and re.fullmatch("[A-Za-z]{2,}", child.text):
            child.tag = "mo"
            child.set("lspace", "0" if before is None or before.tag == "mo" else _THIN)
            child.set("rspace", "0" if after is None or after.text in ("(", "[") else _THIN)
        elif child.tag == "mo" and child.text in _SIGNS and before is not None and before.text in _OPENING:
            child.attrib |= {"form": "prefix", "lspace": "0", "rspace": "0"}
        elif child.tag == "mo" and child.text in ("|", "/"):
            child.attrib |= {"lspace": "0", "rspace": "0"} | ({} if stretched else {"stretchy": "false"})
    if row.tag in ("math", "mrow", "mstyle", "mtd"):
        row[:] = children


def _write(translator: HTML5Translator, node: nodes.math | nodes.math_block, block: bool) -> None:
    text = ""
    try:
        text = mathml(node.astext(), block)
    except MathError as error:
        logging.getLogger(__name__).warning("formula %r: %s", node.astext(), error, location=node)
    translator.body.append(f'<div class="formula">{text}</div>' if block else text)
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict:
    """Make it a choice of `html_math_renderer`."""
    app.add_html_math_renderer(
        "mathml",
        inline_renderers=(lambda translator, node: _write(translator, node, False), None),
        block_renderers=(lambda translator, node: _write(translator, node, True), None),
    )
    return {"parallel_read_safe": True, "parallel_write_safe": True}
