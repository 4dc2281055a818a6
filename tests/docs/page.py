"""docs/physics.md as text, for the tests of what it says."""

from pathlib import Path

__all__ = ["DOCS", "PHYSICS", "ROOT", "table"]

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PHYSICS = (DOCS / "physics.md").read_text(encoding="utf-8")


def table(*head: str) -> list[tuple[str, ...]]:
    """Cells of the one table of the page with these column heads, a tuple per row."""
    lines = PHYSICS.splitlines()
    (start,) = [i for i, line in enumerate(lines) if line == f"| {' | '.join(head)} |"]
    rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        rows.append(tuple(cell.strip() for cell in line.strip("|").split("|")))
    return rows
