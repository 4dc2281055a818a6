"""How numbers read in text."""

__all__ = ["percent", "signed"]


def percent(share: float) -> str:
    """A share; what is there is never shown as nothing.

    Examples
    --------
    >>> percent(0.25), percent(0.0371), percent(1e-5), percent(0.0)
    ('25 %', '3.7 %', '<0.1 %', '0 %')
    """
    text = f"{100.0 * share:.1f}"
    return "<0.1 %" if share > 0.0 and text == "0.0" else f"{text.removesuffix('.0')} %"


def signed(value: float, digits: int = 1) -> str:
    """With its sign, and 0 without one.

    Examples
    --------
    >>> signed(-2.34), signed(2.34, 0), signed(-0.01)
    ('−2.3', '+2', '0.0')
    """
    text = f"{value:+.{digits}f}"
    return text[1:] if float(text) == 0.0 else text.replace("-", "−")
