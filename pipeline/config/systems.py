"""Systems that are no bevel pair: which one a configuration has, and its numbers."""

from dataclasses import asdict

from pipeline.config.gear_schema import Gear, Spur
from pipeline.config.harmonics import pairs_of
from pipeline.config.own_system import system_numbers
from pipeline.config.rotor import rotor_numbers
from pipeline.config.typed import SYSTEMS
from pipeline.errors import ConfigurationError

__all__ = ["SECTIONS", "described", "section_of"]


def section_of(config: Gear) -> str | None:
    """Which of `SECTIONS` a gear has; None of a bevel pair.

    Raises
    ------
    ConfigurationError
        If it has more than one, or keys of a bevel pair besides.
    """
    found = [name for name in SECTIONS if getattr(config, name) is not None]
    if not found:
        return None
    for name in vars(config):
        if name != found[0] and (value := getattr(config, name)) is not None:
            said = repr(value) if isinstance(value, int | float) else "{...}"
            raise ConfigurationError(
                f"gear.{name} = {said} is not allowed: it must be null, because gear.{found[0]} describes the system"
            )
    return found[0]


def described(section: str, config: Gear) -> tuple[dict, dict | None]:
    """The numbers of a system as `pipeline.plan.kinds` takes them, and what its units are where they were given.

    Parameters
    ----------
    section : str
        Of `SECTIONS`.
    config : Gear

    Raises
    ------
    ConfigurationError
        Naming the key, its value and what is allowed.
    """
    return SECTIONS[section](getattr(config, section))


def _spur(config: Spur) -> tuple[dict, None]:
    numbers = asdict(config)
    for name, value in numbers.items():
        if value is None:
            raise ConfigurationError(f"gear.spur.{name} has no value")
    names = ("alpha_harmonics", "error_harmonics", "load_harmonics")
    return numbers | {name: pairs_of(f"gear.spur.{name}", numbers[name]) for name in names}, None


#: Section of `gear` -> what makes numbers of it.
SECTIONS = dict(zip(SYSTEMS, (_spur, rotor_numbers, system_numbers), strict=True))
