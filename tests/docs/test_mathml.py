"""Formulas of the site: every formula of every page becomes MathML, set as TeX would set it."""

import re
from xml.etree import ElementTree

import pytest

from tests.docs.examples import PAGES

mathml = pytest.importorskip("bevelmap_docs.mathml", reason="Sphinx is installed by `make docs`").mathml


def tree(formula):
    return ElementTree.fromstring(mathml(formula, block=False))


def shape(element):
    """Tags and texts of a formula, without layout."""
    text = (element.text or "").strip()
    return (element.tag, text) if text else (element.tag, *map(shape, element))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_formula_is_known(page):
    text = re.sub(r"^```.*?^```$|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    for formula in re.findall(r"\$\$(.*?)\$\$|\$([^$]+)\$", text, flags=re.DOTALL):
        mathml("".join(formula), block=bool(formula[0]))


def test_an_index_stands_beside_an_accented_symbol():
    q = ("mover", ("mi", "q"), ("mo", "¨"))
    assert shape(tree(r"\ddot q_j")) == ("math", ("msub", q, ("mi", "j")))


def test_primes_are_raised_with_the_index_below():
    assert shape(tree("x_j'^2")) == ("math", ("msubsup", ("mi", "x"), ("mi", "j"), ("mrow", ("mi", "′"), ("mn", "2"))))


def test_one_half_without_braces():
    assert shape(tree(r"\frac12 (a)"))[1] == ("mfrac", ("mn", "1"), ("mn", "2"))


def test_spaces_of_functions_signs_and_bars():
    spaces = {child.text: (child.get("lspace"), child.get("rspace")) for child in tree(r"2 \sin x, -\lvert y\rvert")}
    assert spaces["sin"] == ("0.1667em", "0.1667em")
    assert spaces["−"] == spaces["|"] == ("0", "0")


def test_an_unknown_command_is_an_error():
    from docutils.utils.math import MathError

    with pytest.raises(MathError):
        mathml(r"\nonsense", block=False)
