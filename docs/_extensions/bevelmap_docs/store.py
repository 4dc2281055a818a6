"""The arrays of a store as tables, read from small stores that the program itself makes."""

import contextlib
import io
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import zarr

from pipeline import store
from pipeline.__main__ import main
from pipeline.config.compose import compose
from pipeline.plan.planning import plan
from pipeline.stages import STAGES

__all__ = ["Array", "arrays", "groups", "stored"]

_SMALL = ("plane=omega_fe", "plane.sweep.num=41", "plane.parameter.num=5", "cluster=none")
#: What keeps the stages short; none of it changes which arrays there are.
_SHORT = ("attractors.starts=1", "attractors.slice=3")
#: Of the first run alone.
_BRANCHES = "attractors.branches=3"
#: A stage that adds another group where places are asked for.
_PLACES = ("stages=[attractors]", "attractors.points=[[0.6,0.2]]")
#: Choices that have arrays of their own among the rows; the first is the default.
_BALANCES = ("solver=first_order", "solver=hb")
_DIMENSIONS = {"f_e": "row", "omega": "column"}


@dataclass(frozen=True)
class Array:
    """One array of a store: full name, dimensions, type, attributes, and the override that it needs (or "")."""

    name: str
    dimensions: tuple[str, ...]
    dtype: str
    attributes: dict
    needs: str = ""

    @property
    def meaning(self) -> str:
        """Its long name, with its unit and the override that it needs."""
        unit = self.attributes.get("units", "1")
        needs = f"; with `{self.needs}`" if self.needs else ""
        return f"{self.attributes['long_name']}{f', {unit}' if unit != '1' else ''}{needs}"

    @property
    def values(self) -> str:
        """What its numbers stand for; of labels, where to find that."""
        if "flag_values" not in self.attributes:
            return ""
        names = self.attributes["flag_meanings"].split()
        if len(names) > 12:
            return "codes: attributes `flag_values`, `labels`"
        return ", ".join(
            f"{value}\u00a0{name}" for value, name in zip(self.attributes["flag_values"], names, strict=True)
        )


def arrays(group: str = "") -> str:
    """The arrays of a group of a store, the root unless told, as a table."""
    lines = ["| array | dimensions | type | meaning | values |", "| --- | --- | --- | --- | --- |"]
    for array in stored():
        parent, _, name = array.name.rpartition("/")
        if parent == group:
            dimensions = ", ".join(_DIMENSIONS.get(name, name) for name in array.dimensions)
            lines.append(f"| `{name}` | {dimensions} | {array.dtype} | {array.meaning} | {array.values} |")
    return "\n".join(lines)


def groups() -> list[str]:
    """The groups of a store in which all stages that write have run."""
    return sorted({array.name.rpartition("/")[0] for array in stored()} - {""})


@cache
def stored() -> tuple[Array, ...]:
    """Every array that a plane can have."""
    with tempfile.TemporaryDirectory() as folder:
        stages = ",".join(entry.name for entry in STAGES if entry.load().writes)
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            words = [*_SMALL, *_SHORT, f"output.root={folder}", "store.name=plane"]
            status = main([*words, _BRANCHES, f"stages=[{stages}]"]) or main([*words, *_PLACES])
        if status != 0:
            raise RuntimeError(f"the plane that the page describes was not made:\n{said.getvalue()}")
        found = {array.name: array for array in _read(Path(folder) / "store/plane.zarr")}
        templates = []
        for choice in _BALANCES:
            path = Path(folder) / f"{choice}.zarr"
            store.create(path, plan(compose([*_SMALL, choice])), path.stem, "")
            templates.append({array.name: replace(array, needs=choice) for array in _read(path)})
        for one, other in (templates, templates[::-1]):
            found |= {name: one[name] for name in one.keys() - other.keys()}
        return tuple(found[name] for name in sorted(found))


def _read(path: Path) -> Iterator[Array]:
    for name, member in zarr.open_group(path, mode="r").members(max_depth=None):
        if isinstance(member, zarr.Array):
            dtype = "text" if member.dtype.kind == "T" else str(member.dtype)
            yield Array(name, tuple(member.metadata.dimension_names), dtype, dict(member.attrs))
