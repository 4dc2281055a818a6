"""Small planes as the explorer is given them."""

import shutil
from pathlib import Path

from pipeline.__main__ import main
from tests.made_once import made_once
from tests.pipeline.planes import small_plan, traced_store

__all__ = ["integrated_store"]

_SIZES = ("plane.sweep.num=60", "plane.parameter.num=16")


def integrated_store(folder: Path, *overrides: str) -> Path:
    """A copy of a traced store with attractors in a few cells, integrated once in a session."""

    def integrate(made: Path) -> None:
        traced_store(made / "plane.zarr", small_plan(*_SIZES, *overrides))
        few = ["attractors.columns=12", "attractors.rows=5", "attractors.starts=2"]
        words = [
            "stages=[attractors]",
            "cluster=none",
            "store.name=plane",
            f"store.root={made}",
            f"output.root={made}/o",
        ]
        assert main([*_SIZES, *overrides, *words, *few]) == 0

    made = made_once("explorer-" + "-".join(overrides).replace("/", "_"), integrate)
    return shutil.copytree(made / "plane.zarr", folder / "plane.zarr")
