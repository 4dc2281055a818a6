"""Mathematical text of figures as plain text, for pages that have no typesetting."""

import re
import unicodedata

from pipeline.config.quantities import Quantity

__all__ = ["axis_text", "plain", "quantity_title"]

#: A letter with the space that ends its name, dots, or a narrow space.
_COMMAND = re.compile(r"\\([A-Za-z]+ ?|,)")
_SIGNS = {",": " ", "ldots": "…"}
#: What Unicode writes otherwise.
_SPELT = {"lambda": "lamda", "varepsilon": "epsilon", "varphi": "phi"}


def plain(text: str) -> str:
    """Mathematical text without its markup.

    Examples
    --------
    >>> plain(r"mean load $f_{pm}$"), plain(r"$\\lambda'$ (m/s)"), plain(r"$\\Omega$"), plain(r"b_c \\Omega_n")
    ('mean load f_pm', "λ' (m/s)", 'Ω', 'b_c Ω_n')
    """
    return _COMMAND.sub(_letter, text).translate({ord(c): None for c in "${}"})


def _letter(found: re.Match) -> str:
    """The sign or Greek letter that a command stands for, else its name."""
    name = found[1].strip()
    if name in _SIGNS:
        return _SIGNS[name]
    size, spelt = "capital" if name[0].isupper() else "small", _SPELT.get(name.lower(), name)
    try:
        return unicodedata.lookup(f"greek {size} letter {spelt}".upper())
    except KeyError:
        return name


def axis_text(name: str, symbol: str, unit: str = "") -> str:
    """An axis: name, symbol and unit.

    Examples
    --------
    >>> axis_text("half backlash", "b"), axis_text("speed", "", "m/s")
    ('half backlash b', 'speed (m/s)')
    """
    return " ".join(part for part in (name, symbol, f"({unit})" if unit else "") if part)


def quantity_title(quantity: Quantity, unit: str = "") -> str:
    """A quantity with its symbol, and its unit: physical, or what 1 of it is."""
    reference = plain(quantity.reference)
    return axis_text(quantity.label, plain(quantity.symbol), unit or reference)
