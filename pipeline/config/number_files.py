"""Files of numbers that come from someone else's program: read whole, if they are of a bearable size."""

from pathlib import Path

__all__ = ["NumbersError", "read_bytes"]


class NumbersError(Exception):
    """Why something holds no such numbers, as the end of a sentence."""


def read_bytes(path: str, most: int) -> bytes:
    """What a file holds.

    Parameters
    ----------
    path : str
    most : int
        Bytes.

    Raises
    ------
    NumbersError
        If there is no such file, it is longer, or the system refuses.
    """
    try:
        file = Path(path)
        # A pipe or a device has no size, and no end.
        if not file.is_file():
            raise NumbersError("it must be a file" if file.exists() else "there is no such file")
        if file.stat().st_size > most:
            raise NumbersError(f"it must be a file of at most {most / 1e6:g} MB")
        return file.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "no path"
        raise NumbersError(f"it cannot be read ({reason})") from None
