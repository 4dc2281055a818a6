"""Small planes as the explorer is given them."""

import shutil
from pathlib import Path

from pipeline.__main__ import main
from tests.made_once import made_once
from tests.pipeline.planes import small_plan, traced_store

__all__ = ["WORDS", "integrated_store"]

#: About the upper resonance of the published gear: folds, grazings and period doublings in a few slabs.
WORDS = (
    "plane.sweep.min=1.0",
    "plane.sweep.max=1.5",
    "plane.sweep.num=40",
    "plane.parameter.min=0.1",
    "plane.parameter.max=0.4",
    "plane.parameter.num=9",
)


def integrated_store(folder: Path, *overrides: str) -> Path:
    """A copy of a traced store with attractors in a few cells, integrated once in a session."""

    def integrate(made: Path) -> None:
        traced_store(made / "plane.zarr", small_plan(*WORDS, *overrides))
        few = ["attractors.columns=12", "attractors.rows=4", "attractors.starts=2"]
        words = [
            "stages=[attractors]",
            "cluster=none",
            "store.name=plane",
            f"store.root={made}",
            f"output.root={made}/o",
        ]
        assert main([*WORDS, *overrides, *words, *few]) == 0

    made = made_once("explorer-" + "-".join(overrides).replace("/", "_"), integrate)
    return shutil.copytree(made / "plane.zarr", folder / "plane.zarr")
