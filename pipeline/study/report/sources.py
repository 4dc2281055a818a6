"""The stored planes that the report reads, and the commands that make them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline import store
from pipeline.config.compose import Settings, compose
from pipeline.config.places import Place
from pipeline.config.typed import key_of
from pipeline.errors import StoreError
from pipeline.plan.planning import plan
from pipeline.run.job import command
from pipeline.store.stored_arrays import open_group

__all__ = ["OTHER_GEARS", "STUDY_PLANES", "Source", "missing", "sources_of"]

#: The study's planes, of the published gear.
STUDY_PLANES = ("omega_fe", "omega_b", "omega_alpha", "omega_fpm")
#: Gears that are compared with the published one, and the plane in which they are.
OTHER_GEARS = ("consistent", "antiphase")
COMPARED, VERIFIED = "omega_fe", "omega_fe"

#: What belongs to a plane or to this run alone, and is not carried over to the planes of the report.
_OWN = ("plane", "gear", "stages", "store.name", "store.overwrite", "report", "margins", "figures")
_STAGES = "stages=[sweep,boundaries]"


@dataclass(frozen=True)
class Source:
    """One plane that the report reads.

    Parameters
    ----------
    plane, gear : str
    settings : Settings
        Composed as the command would be.
    verified : bool
        Whether it is the plane that direct integration looks at.
    """

    plane: str
    gear: str
    settings: Settings
    verified: bool

    @property
    def path(self) -> Place:
        """Where its store is."""
        return self.settings.store_path.resolve()

    @property
    def command(self) -> str:
        """What makes it."""
        return command(self.settings, *(text for text in self.settings.overrides if key_of(text) == "stages"))


def sources_of(overrides: Sequence[str], config_dir: str | None = None) -> tuple[Source, ...]:
    """All planes that a report with these overrides reads, the study's first.

    Parameters
    ----------
    overrides : sequence of str
        Of the report; those about resolution, places and solver hold for every plane.
    config_dir : str, optional
    """
    kept = [text for text in overrides if not _is_own(text)]
    pairs = [*((plane, "published") for plane in STUDY_PLANES), *((COMPARED, gear) for gear in OTHER_GEARS)]
    found = []
    for plane, gear in pairs:
        verified = plane == VERIFIED and gear == "published"
        own = [f"plane={plane}", *([f"gear={gear}"] if gear != "published" else [])]
        stages = "stages=[sweep,boundaries,attractors]" if verified else _STAGES
        found.append(Source(plane, gear, compose([*own, stages, *kept], config_dir), verified))
    return tuple(found)


def _is_own(override: str) -> bool:
    key = key_of(override)
    return key in _OWN or key.startswith(("gear.", "report.", "margins.", "figures."))


def missing(sources: Sequence[Source]) -> Iterator[tuple[Source, str]]:
    """Sources that cannot be read yet, each with the reason."""
    for source in sources:
        try:
            complete = store.check(source.path, plan(source.settings))
        except StoreError as error:
            yield source, str(error)
            continue
        if not complete:
            yield source, f"there is no store at {source.path}"
            continue
        pending = int(np.sum(store.statuses(source.path) == store.PENDING))
        if pending:
            yield source, f"{pending} rows of {source.path} are not computed yet"
        elif open_group(source.path, "boundaries") is None:
            yield source, f"{source.path} has no boundaries"
        elif source.verified and open_group(source.path, "attractors") is None:
            yield source, f"{source.path} has no attractors"
