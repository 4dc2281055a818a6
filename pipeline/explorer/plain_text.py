"""Mathematical text of figures as plain text, for pages that have no typesetting."""

import re

from pipeline.config.quantities import Quantity

__all__ = ["axis_text", "plain", "quantity_title"]

_LETTERS = {
    r"\Omega": "Ω",
    r"\alpha": "α",
    r"\Phi": "Φ",
    r"\kappa": "κ",
    r"\xi": "ξ",
    r"\delta": "δ",
    r"\sigma": "σ",
    r"\varepsilon": "ε",
    r"\Delta": "Δ",
    r"\lambda": "λ",
    r"\psi": "ψ",
    r"\mu": "μ",
    r"\zeta": "ζ",
    r"\tau": "τ",
    r"\ldots": "…",
    r"\,": " ",
}
_COMMAND = re.compile(r"\\(?:[A-Za-z]+|,)")


def plain(text: str) -> str:
    """Mathematical text without its markup.

    Examples
    --------
    >>> plain(r"mean load $f_{pm}$"), plain(r"$\\lambda'$ (m/s)"), plain(r"$\\Omega$"), plain(r"b_c \\Omega_n")
    ('mean load f_pm', "λ' (m/s)", 'Ω', 'b_c Ω_n')
    """
    return _COMMAND.sub(lambda found: _LETTERS[found[0]], text).translate({ord(c): None for c in "${}"})


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
