"""Golden files of the three tables in their three formats, from three small planes.

To renew them after a change that is meant, look at what `git diff tests/pipeline/study/golden` says afterwards:

    python -m tests.pipeline.study.golden_files
"""

import re
import tempfile
from pathlib import Path

import numpy as np

from pipeline.study import tables
from pipeline.study.tables.article import ARTICLE_TABLES
from tests.made_once import share
from tests.pipeline.planes import small_plan, small_store

__all__ = ["FOLDER", "NAMES", "PLANES", "difference", "golden", "make_stores", "written"]

FOLDER = Path(__file__).parent / "golden"
PLANES = {article.plane: article for article in ARTICLE_TABLES}
NAMES = [f"table{number}{end}" for number in (1, 2, 3) for end in (".csv", "-measured.csv", ".md", ".tex")]

# Of the ends of the articles' bands as many as may be are rows.
_ROWS = {
    "omega_b": ("plane.parameter.min=0.1", "plane.parameter.max=1.5", 15),
    "omega_alpha": ("plane.parameter.min=0.0", "plane.parameter.max=0.8", 17),
    "omega_fpm": ("plane.parameter.min=0.3", "plane.parameter.max=1.2", 31),
}
# Which configuration it was, schema version included, is not what these files are about.
_HASH = re.compile(r"\b[0-9a-f]{16}\b")
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# Of the CSV's ten digits the last ones are another machine's own; a quadrature's error is nothing but rounding.
_SAME = 1e-6


def make_stores(folder: Path) -> dict[str, tuple[Path, str]]:
    """The planes, and the commands that tables would name for them."""
    return {
        plane: (
            small_store(folder / f"{plane}.zarr", small_plan(f"plane={plane}", low, high, columns=121, rows=rows)),
            f"python -m pipeline plane={plane}",
        )
        for plane, (low, high, rows) in _ROWS.items()
    }


def written(stores: dict[str, tuple[Path, str]], folder: Path) -> dict[str, str]:
    """Name -> text of every table."""
    return {path.name: path.read_text(encoding="utf-8") for path in tables.write(stores, folder)}


def golden(name: str) -> str:
    """What a file should be."""
    return (FOLDER / name).read_text(encoding="utf-8")


def difference(expected: str, found: str) -> str:
    """The first line that differs, both ways; empty if none does. Numbers may differ by a millionth."""
    ours, theirs = (_HASH.sub("hash", text).splitlines() for text in (found, expected))
    if len(ours) != len(theirs):
        return f"{len(ours)} lines, golden {len(theirs)}"
    for number, (one, other) in enumerate(zip(ours, theirs, strict=True), 1):
        if one == other:
            continue
        same_text = _NUMBER.sub("#", one) == _NUMBER.sub("#", other)
        pairs = [[float(text) for text in _NUMBER.findall(line)] for line in (one, other)]
        if not same_text or not np.allclose(*pairs, rtol=_SAME, atol=_SAME):
            apart = (i for i, (a, b) in enumerate(zip(one, other, strict=False)) if a != b)
            at = next(apart, min(len(one), len(other)))
            cut = slice(max(at - 40, 0), at + 60)
            return f"line {number}, character {at}: ...{one[cut]!r}, golden ...{other[cut]!r}"
    return ""


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch, tempfile.TemporaryDirectory() as shared:
        share(Path(shared))
        for file, content in written(make_stores(Path(scratch)), Path(scratch) / "tables").items():
            (FOLDER / file).write_text(content, encoding="utf-8", newline="\n")
            print(FOLDER / file)
