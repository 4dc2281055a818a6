"""What a stage is given: a checked configuration and the plan of its plane; its log; and what stages say alike."""

import itertools
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from pipeline import store
from pipeline.config.compose import Settings
from pipeline.plan.layers import Layer
from pipeline.plan.plan import Plan
from pipeline.run.progress import Reporter

__all__ = ["Job", "note_unfinished", "open_log", "say_failures", "sweep_command"]


@dataclass(frozen=True)
class Job:
    """A checked configuration with the plan of its plane, or of a volume's layer (None where no stage needs one)."""

    settings: Settings
    plan: Plan | None
    layer: Layer | None = None

    @property
    def store_path(self) -> Path:
        """Where the plane's store is, or will be."""
        return self.settings.store_path.resolve()

    def asks(self, stage: str) -> bool:
        """Whether the user wants this stage."""
        return stage in self.settings.config.stages


def sweep_command(settings: Settings, plane: str | None = None) -> str:
    """The command that computes a plane with these choices of gear, quality and store."""
    choices, root = settings.choices, settings.config.store.root
    words = ["python -m pipeline", f"plane={plane or choices['plane']}"]
    words += [
        f"{group}={choices[group]}"
        for group, usual in (("gear", "published"), ("quality", "paper"))
        if choices[group] != usual
    ]
    kept = ("output.root=", "store.root=", "solver=", "solver.order=", "solver.period=")
    words += [override for override in settings.overrides if override.startswith(kept)]
    if plane is None and settings.config.store.name is not None:
        words.append(f"store.name={settings.config.store.name}")
    return " ".join(words) if root else words[0]


def open_log(job: Job, reporter: Reporter) -> None:
    """Make the folder of this run with the configuration as resolved and as typed; the reporter logs into it."""
    stamp = datetime.now(UTC).strftime("%Y-%m-%dT%H-%M-%S.%fZ")
    runs = job.settings.output_root / "runs" / job.settings.store_name
    # A clock that was set back may show the time of an earlier run.
    names = itertools.chain([stamp], (f"{stamp}-{number}" for number in itertools.count(2)))
    folder = next(runs / name for name in names if not (runs / name).exists())
    folder.mkdir(parents=True)
    (folder / "config.yaml").write_text(job.settings.yaml(), encoding="utf-8")
    (folder / "overrides.txt").write_text("".join(f"{line}\n" for line in job.settings.overrides), encoding="utf-8")
    reporter.log = folder / "run.log"
    reporter.line(f"run: configuration and log in {folder.resolve()}")


def note_unfinished(job: Job, reporter: Reporter, consequence: str) -> None:
    unfinished = int(np.sum(store.statuses(job.store_path) != store.COMPLETE))
    if unfinished:
        reporter.line(f"note: {unfinished} rows of {job.store_path} are not complete, {consequence}")


def say_failures(failures, reporter: Reporter) -> None:
    for text in failures[:10]:
        reporter.error(text)
    if len(failures) > 10:
        reporter.line(f"  and {len(failures) - 10} more; the store has every reason")
