"""The registry of stages, in the order of a run. A new stage is one module with a `STAGE`, and one entry here."""

import importlib
from dataclasses import dataclass

__all__ = ["STAGES", "Entry"]


@dataclass(frozen=True)
class Entry:
    """What is known of a stage before its module is loaded.

    Parameters
    ----------
    name : str
        As typed in `stages=[...]`.
    sentence : str
        What it does, as `--help` shows it.
    module : str
        The module that has its `STAGE`.
    several_planes : bool
        Whether it reads several planes, so that it runs once after all of them.
    """

    name: str
    sentence: str
    module: str
    several_planes: bool = False

    def load(self):
        """The stage itself, a `pipeline.run.stage.Stage`."""
        return importlib.import_module(self.module).STAGE


STAGES = (
    Entry("sweep", "rows of the plane that are not in the store yet", "pipeline.run.sweep"),
    Entry(
        "boundaries",
        "folds, grazings and bifurcations as curves, started from the stored rows",
        "pipeline.analysis.boundaries.stage",
    ),
    Entry(
        "attractors",
        "what motions end on in every cell, and so what the labels of the map are worth",
        "pipeline.analysis.attractors.stage",
    ),
    Entry(
        "motion",
        "every motion at one point: time history, phase portrait, spectrum, mesh force",
        "pipeline.figures.motion_stage",
    ),
    Entry(
        "diagram",
        "what one motion does along a row, up and down: Poincaré points, extremes, RMS, jumps",
        "pipeline.figures.diagram_stage",
    ),
    Entry(
        "spectrum",
        "amplitudes over speed and over frequency or order along such a row, with Campbell's lines",
        "pipeline.figures.spectrum_stage",
    ),
    Entry(
        "margins", "how far a design point is from anything that changes its label", "pipeline.figures.margins_stage"
    ),
    Entry("explore", "the stored plane in a browser, asked by clicking", "pipeline.explorer.stage"),
    Entry("figures", "pictures of the stored plane; nothing is solved again", "pipeline.figures.stage"),
    Entry(
        "page",
        "the plane as one HTML file to mail: its map with all layers, curves of some rows",
        "pipeline.explorer.page_stage",
    ),
    Entry(
        "check",
        "every file of a store against its checksum and the template; repair of what is damaged",
        "pipeline.run.check",
    ),
    Entry("debug", "one row computed again in this process, step by step; no store is touched", "pipeline.run.debug"),
    Entry("tables", "tables 1 to 3 of the study from the stored planes", "pipeline.study.tables.stage", True),
    Entry(
        "report", "the published study against what is computed here, as one page", "pipeline.study.report.stage", True
    ),
    Entry("list", "which stores there are, and in what state", "pipeline.run.listing", True),
)
