"""Text that does nothing to a terminal: stores, locks and messages of libraries may quote anyone's."""

__all__ = ["printable"]


def printable(text: str) -> str:
    """The text on one line, without what would steer a terminal or change the order of its letters.

    Examples
    --------
    >>> printable("a\x1b[2Jb\n\u202ec"), printable("rows 0-3: f_e ≤ 0.5")
    ('a?[2Jb ?c', 'rows 0-3: f_e ≤ 0.5')
    """
    return "".join(one if one.isprintable() else " " if one.isspace() else "?" for one in text)
