"""What a stage is given: a checked configuration and the plan of its plane; its log; and what stages say alike."""

import itertools
import shlex
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np

from pipeline import store
from pipeline.config.compose import Settings
from pipeline.config.places import Place
from pipeline.config.secrets import without_secrets
from pipeline.config.typed import key_of
from pipeline.errors import StoreError, counted
from pipeline.plan.layers import Layer
from pipeline.plan.plan import Plan
from pipeline.run.progress import Reporter

__all__ = ["Job", "command", "note_unfinished", "open_log", "other_numbers", "say_failures"]


@dataclass(frozen=True)
class Job:
    """A checked configuration with the plan of its plane, or of a volume's layer (None where no stage needs one)."""

    settings: Settings
    plan: Plan | None
    layer: Layer | None = None

    @property
    def store_path(self) -> Place:
        """Where the plane's store is, or will be."""
        return self.settings.store_path.resolve()

    def asks(self, stage: str) -> bool:
        """Whether the user wants this stage."""
        return stage in self.settings.config.stages


def command(settings: Settings, *changes: str) -> str:
    """The command that computes the plane of some settings, with everything that was typed but the stages.

    Parameters
    ----------
    settings : Settings
    *changes : str
        Overrides in place of those of the same key; "store.name=" alone leaves that out.

    Examples
    --------
    >>> from pipeline.config.compose import compose
    >>> command(compose(["gear.b=0.5", "stages=[figures]", "figures.curves=[0.1]"]), "store.overwrite=true")
    "python -m pipeline plane=omega_fe gear.b=0.5 'figures.curves=[0.1]' store.overwrite=true"
    """
    gone = {"stages", "debug.row", *map(key_of, changes)}
    typed = [override for override in settings.overrides if key_of(override) not in gone]
    if "plane" not in map(key_of, typed):
        typed = [f"plane={settings.choices['plane']}", *typed]
    own = [f"--config-dir={settings.config_dir}"] if settings.config_dir else []
    changed = [change for change in changes if not change.endswith("=")]
    return " ".join(["python -m pipeline", *map(shlex.quote, [*own, *map(without_secrets, typed), *changed])])


def other_numbers(settings: Settings, path: Place, changes: str) -> StoreError:
    """What is said where a store was made with other numbers than are asked for: the difference and the ways on."""
    if settings.overridden("store.name") and settings.config.plane.layer is None:
        beside = command(settings, "store.name=")
    else:
        # Of a layer, the volume's name is what can be chosen.
        beside = command(settings, f"store.name={settings.default_name}-2")
    return StoreError(
        f"{path} was made with other numbers ({changes}); another store beside it: {beside}; "
        f"this one computed again: {command(settings, 'store.overwrite=true')}"
    )


def open_log(job: Job, reporter: Reporter) -> None:
    """Make the folder of this run with the configuration as resolved and as typed; the reporter logs into it."""
    stamp = datetime.now(UTC).strftime("%Y-%m-%dT%H-%M-%S.%fZ")
    runs = job.settings.output_root / "runs" / job.settings.store_name
    # A clock that was set back may show the time of an earlier run.
    names = itertools.chain([stamp], (f"{stamp}-{number}" for number in itertools.count(2)))
    folder = next(runs / name for name in names if not (runs / name).exists())
    folder.mkdir(parents=True)
    (folder / "config.yaml").write_text(job.settings.yaml(), encoding="utf-8")
    (folder / "overrides.txt").write_text(
        "".join(f"{without_secrets(line)}\n" for line in job.settings.overrides), encoding="utf-8"
    )
    reporter.log = folder / "run.log"
    reporter.line(f"run: configuration and log in {folder.resolve()}")


def note_unfinished(job: Job, reporter: Reporter, consequence: str) -> None:
    unfinished = int(np.sum(store.statuses(job.store_path) != store.COMPLETE))
    if unfinished:
        reporter.line(f"note: {counted(unfinished, 'row')} of {job.store_path} not complete, {consequence}")


def say_failures(failures, reporter: Reporter) -> None:
    for text in failures[:10]:
        reporter.error(text)
    if len(failures) > 10:
        reporter.line(f"  and {len(failures) - 10} more; the store has every reason")
