"""Formulas of the site: every formula of every page becomes MathML, set as TeX would set it."""

import re
from xml.etree import ElementTree

import pytest

mathml = pytest.importorskip("bevelmap_docs.mathml", reason="Sphinx is installed by `make docs`")
