"""A new plane computed beside the page, by the same command that a user would type, with its progress."""

import re
import shlex
import subprocess
import sys
import threading
from collections.abc import Mapping
from dataclasses import dataclass

from pipeline.config.compose import compose
from pipeline.config.places import Place
from pipeline.config.secrets import HIDDEN
from pipeline.config.typed import key_of
from pipeline.errors import ConfigurationError
from pipeline.explorer.fixed_parameters import changed_plan
from pipeline.explorer.typed_changes import check_same, typed_changes
from pipeline.plan.plan import Plan
from pipeline.plan.planning import plan as plan_of

__all__ = ["BackgroundRun", "NewPlane", "new_plane"]

_STAGES = "stages=[sweep,boundaries]"
_PROGRESS = re.compile(r"\s*(\d+)/(\d+) \w+")


@dataclass(frozen=True)
class NewPlane:
    """A plane with other fixed parameters.

    Parameters
    ----------
    overrides : tuple of str
        As typed, without stages.
    path : Place
        Of its store, whose name is its own.
    """

    overrides: tuple[str, ...]
    path: Place

    @property
    def command(self) -> str:
        """That of the plane, without stages."""
        return " ".join(["python -m pipeline", *map(shlex.quote, self.overrides)])


def new_plane(command: str, plan: Plan, fixed: Mapping[str, float]) -> NewPlane:
    """The plane of a command with fixed parameters changed.

    Parameters
    ----------
    command : str
        Of the plane that is shown, "python -m pipeline plane=omega_fe".
    plan : Plan
        Of that plane.
    fixed : mapping
        Name -> value.

    Raises
    ------
    ConfigurationError
        If there is no such plane: the command is not known, nothing is changed, or no command gives what is changed.
    """
    if not command:
        raise ConfigurationError("the command that made this plane is not known: type the new one")
    if not fixed:
        raise ConfigurationError("no fixed parameter is changed: this plane is computed already")
    words, config_dir = shlex.split(command)[3:], None
    if words and words[0].startswith("--config-dir="):
        config_dir = words.pop(0).partition("=")[2]
    if any(word.endswith(f"={HIDDEN}") for word in words):
        raise ConfigurationError(
            "store.storage_options were typed, and no command has their values: put them into the environment instead"
        )
    meant, config = changed_plan(plan, fixed), compose(words, config_dir).config
    changes = typed_changes(config.gear, plan, meant)
    if config.store.name is not None:
        # A name that was typed belongs to the plane it was typed for.
        named = [config.store.name, *(f"{name}={value:.6g}" for name, value in sorted(fixed.items()))]
        changes["store.name"] = f"'{'-'.join(named)}'"
    kept = [word for word in words if key_of(word) not in {*changes, "store.overwrite"}]
    typed = [*kept, *(f"{key}={value}" for key, value in sorted(changes.items()))]
    settings = compose(typed, config_dir)
    made = plan_of(settings)
    check_same(made, meant, fixed)
    if made.fingerprint == plan.fingerprint:
        raise ConfigurationError(f"{', '.join(sorted(fixed))}: that changes nothing in this plane")
    own = [f"--config-dir={config_dir}"] if config_dir else []
    return NewPlane((*own, *typed), settings.store_path.resolve())


class BackgroundRun:
    """One at a time; ends with the server.

    Attributes
    ----------
    plane : NewPlane or None
        The last one that was begun.
    """

    def __init__(self):
        self.plane: NewPlane | None = None
        self._process: subprocess.Popen | None = None
        self._lines: list[str] = []
        self._share, self._alone = 0.0, threading.Lock()
        self._reader: threading.Thread | None = None

    def begin(self, plane: NewPlane) -> None:
        """Begin to compute a plane.

        Raises
        ------
        ConfigurationError
            If another one is being computed.
        """
        with self._alone:
            if self.running:
                raise ConfigurationError(f"{self.plane.path.stem} is being computed: one at a time")
            self.plane, self._lines, self._share = plane, [], 0.0
            self._process = subprocess.Popen(
                [sys.executable, "-m", "pipeline", *plane.overrides, _STAGES],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                # Ctrl-C is for the server, which ends it.
                start_new_session=True,
            )
            self._reader = threading.Thread(
                target=self._read, args=(self._process,), name="background run", daemon=True
            )
            self._reader.start()

    @property
    def running(self) -> bool:
        """Whether a plane is being computed."""
        return self._process is not None and self._process.poll() is None

    @property
    def succeeded(self) -> bool:
        """Whether the last one was computed."""
        return self._process is not None and self._process.poll() == 0

    @property
    def share(self) -> float:
        """How much of its rows is computed, from 0 to 1."""
        return 1.0 if self.succeeded else self._share

    @property
    def line(self) -> str:
        """What it said last, and of one that failed its error; empty before it says anything."""
        errors = [] if self.running or self.succeeded else [one for one in self._lines if one.startswith("error")]
        return [*self._lines[-1:], *errors][-1] if self._lines else ""

    def wait(self, seconds: float | None = None) -> None:
        """Wait until it has ended and everything that it said is read; raises subprocess.TimeoutExpired."""
        if self._process is not None:
            self._process.wait(seconds)
            self._reader.join()

    def end(self) -> None:
        """End it; what is stored is kept."""
        if self.running:
            self._process.terminate()
            try:
                self.wait(20.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self.wait()

    def _read(self, process: subprocess.Popen) -> None:
        with process.stdout as lines:
            for line in lines:
                if found := _PROGRESS.match(line):
                    self._share = int(found[1]) / max(int(found[2]), 1)
                self._lines = [*self._lines[-20:], line.strip()]
