"""The stored boundaries as CSV: one line per point, and one per special point."""

from pathlib import Path

from pipeline.plan.plan import Plan
from pipeline.plane.boundaries import StoredBoundaries, special_places
from pipeline.run.sheets import csv_text, write_files
from solver.boundaries import SpecialPoint

__all__ = ["write_sheets"]


def write_sheets(boundaries: StoredBoundaries, plan: Plan, folder: Path, name: str) -> list[Path]:
    """Write `<name>.csv` and `<name>-special.csv`; the same bytes from the same store.

    Numbers have as many digits as give back the stored ones.
    """
    x, p = plan.sweep.name, plan.parameter.name
    points, special, named = [], [], {int(one): one.name.lower() for one in SpecialPoint}
    for number, curve in enumerate(boundaries.curves):
        kind = curve.kind.name.lower()
        lines = [
            [number, kind, place[3], place[4], place[0], size, stable, named[code]]
            for place, size, stable, code in zip(
                *(part.tolist() for part in (curve.points, curve.amplitude, curve.stable, curve.special)), strict=True
            )
        ]
        points += lines
        special += [[lines[i][-1], *lines[i][:-2]] for i in special_places(curve)]
    # By what they are; the sort keeps the order along the curves.
    special.sort(key=lambda line: SpecialPoint[line[0].upper()])
    places = [x, p, "mean", "amplitude"]
    return write_files(
        folder,
        {
            f"{name}.csv": csv_text(["curve", "kind", *places, "stable", "special"], points),
            f"{name}-special.csv": csv_text(["special", "curve", "kind", *places], special),
        },
    )
