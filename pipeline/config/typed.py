"""What is typed, before Hydra reads it: bounded, so that no parser runs away, and expanded into single runs.

Hydra reads an override by recursion and a number by Python's own limits; what is longer, deeper or has more digits than
any configuration needs is refused here, in one line.
"""

import functools
import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import ConfigurationError, shown

__all__ = ["GROUPS", "SYSTEMS", "conf_folder", "expand", "key_of", "loader", "parsed"]

#: Groups whose files are chosen by name, the folders of conf/, in the order in which help shows them.
GROUPS = ("plane", "gear", "quality", "solver", "cluster")

#: Sections of a gear that describe something else than a bevel pair.
SYSTEMS = ("spur", "rotor", "system")

_MOST_OVERRIDES = 200
_MOST_CHARACTERS = 10_000
_MOST_DIGITS = 100
_MOST_DEEP = 20
_MOST_RUNS = 1000

_OVERRIDE = re.compile(r"[+~]{0,2}[A-Za-z]")
#: A plain name, or one in a folder of the group; none leads out of it.
_CHOICE = re.compile(r"[A-Za-z0-9_][\w+=-]*(?:[./][\w+=-]+)*")
_OPENING, _CLOSING = "([{", ")]}"


def conf_folder() -> Path:
    """The configuration folder: inside the installed package where it exists, else the repository's."""
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "conf", package.parent / "conf"):
        if (folder / "config.yaml").is_file():
            return folder
    raise ConfigurationError(f"no configuration found at {package / 'conf'} or {package.parent / 'conf'}")


def loader(config_dir: str | None = None):
    """What Hydra knows of the files of conf/ and of a user's own folder: a ConfigLoader."""
    from hydra._internal.config_loader_impl import ConfigLoaderImpl
    from hydra._internal.utils import create_config_search_path

    path = create_config_search_path(f"file://{conf_folder()}")
    if config_dir is not None:
        path.prepend("user", f"file://{Path(config_dir).resolve()}", "schema")
    return ConfigLoaderImpl(config_search_path=path)


@functools.lru_cache(maxsize=1024)
def parsed(override: str, config_dir: str | None = None):
    """What Hydra reads in one override: an Override. Reading is slow, and each is needed several times."""
    from hydra.core.override_parser.overrides_parser import OverridesParser

    # The plural one tells `glob` of the files.
    (read,) = OverridesParser.create(config_loader=_Groups(config_dir)).parse_overrides([override])
    return read


def key_of(override: str) -> str:
    """The key or the group that an override is about.

    Examples
    --------
    >>> key_of("gear.b=0.5"), key_of("+gear@other=miter"), key_of("~gear.b")
    ('gear.b', 'gear', 'gear.b')
    """
    return re.split("[=@]", override.lstrip("+~"), maxsplit=1)[0]


def expand(overrides: Sequence[str], config_dir: str | None = None) -> list[list[str]]:
    """All combinations of several values, in the order in which Hydra's multirun takes them.

    Parameters
    ----------
    overrides : sequence of str
        As typed: `gear.b=0.5,0.6`, `gear.b=range(0.1,0.5,0.1)`, `gear=choice(miter,published)`, `plane=glob(*)`.
    config_dir : str, optional
        The folder of the user's own files, of which `glob` knows too.

    Raises
    ------
    ConfigurationError
        One line that shows the override: it cannot be read, is too long, or stands for too many runs.
    """
    if len(overrides) > _MOST_OVERRIDES:
        raise ConfigurationError(f"{len(overrides)} overrides are not allowed: at most {_MOST_OVERRIDES} are")
    for override in overrides:
        _check_text(override)
    choices = [_values(override, config_dir) for override in overrides]
    runs = 1
    for values in choices:
        runs *= len(values)
    if runs > _MOST_RUNS:
        raise _too_many(" ".join(overrides))
    return [list(combination) for combination in itertools.product(*choices)]


def _check_text(override: str) -> None:
    """Raise unless Hydra may read it."""
    if not _OVERRIDE.match(override):
        raise _refused(override, "it must be KEY=VALUE, such as gear.b=0.5")
    if len(override) > _MOST_CHARACTERS:
        raise _refused(override, f"it must be at most {_MOST_CHARACTERS} characters long")
    if not override.isprintable():
        raise _refused(override, "it must be printable text in UTF-8")
    if re.search(rf"[\d_]{{{_MOST_DIGITS + 1}}}", override):
        raise _refused(override, f"numbers must have at most {_MOST_DIGITS} digits")
    deep = 0
    for character in override:
        deep += (character in _OPENING) - (character in _CLOSING)
        if deep > _MOST_DEEP:
            raise _refused(override, f"it must not be nested deeper than {_MOST_DEEP}")
    if key_of(override).startswith("hydra"):
        raise ConfigurationError(f"{shown(override)}: Hydra's own settings are fixed here, so that it writes nothing")


def _values(override: str, config_dir: str | None) -> list[str]:
    """The overrides that one stands for: itself, unless it has several values."""
    from hydra.errors import HydraException

    key = key_of(override)
    try:
        read = parsed(override, config_dir)
    except HydraException as error:
        raise ConfigurationError(f"{shown(override)} cannot be read as KEY=VALUE: {_reason(error)}") from None
    except (ValueError, ArithmeticError) as error:
        raise ConfigurationError(f"{shown(override)} cannot be read as KEY=VALUE: {error}") from None
    if read.is_interval_sweep():
        raise _refused(
            override, f"an interval has no values of its own; -m {key}=0.1,0.2 or -m '{key}=range(0,1,0.1)' has"
        )
    if not read.is_sweep_override():
        if key in GROUPS and not read.is_delete() and not _is_choice(read.value()):
            raise _refused(override, f"it must be the name of one file of that group, such as {_example(key)}")
        return [override]
    if read.is_range_sweep() and _steps(read.value()) > _MOST_RUNS:
        raise _too_many(override)
    try:
        values = list(itertools.islice(read.sweep_string_iterator(), _MOST_RUNS + 1))
        if read.is_range_sweep():
            # Hydra adds steps up: 0.1, 0.2, 0.30000000000000004.
            values = [f"{float(value):.12g}" if "." in value else value for value in values]
    except (HydraException, ValueError, ArithmeticError, TypeError) as error:
        raise _refused(override, f"it stands for no values ({_reason(error)})") from None
    if not values:
        raise _refused(override, "it stands for no values")
    if len(values) > _MOST_RUNS:
        raise _too_many(override)
    if key in GROUPS and not all(_is_choice(value) for value in values):
        raise _refused(override, f"each must be the name of one file of that group, such as {_example(key)}")
    return [f"{read.get_key_element()}={value}" for value in values]


def _steps(sweep) -> float:
    """Number of values of a range, before any is made; 0 where it has none."""
    return abs(sweep.stop - sweep.start) / abs(sweep.step) if sweep.step else 0.0


@dataclass(frozen=True)
class _Groups:
    """The files of a group, looked up when a `glob` asks for them."""

    config_dir: str | None

    def get_group_options(self, group_name: str, **kinds) -> Iterator[str]:
        if group_name not in GROUPS:
            raise ValueError(f"glob is for the groups {', '.join(GROUPS)}")
        return loader(self.config_dir).get_group_options(group_name, **kinds)


def _is_choice(value) -> bool:
    # Hydra takes texts alone, and a name with its suffix for another choice.
    return isinstance(value, str) and _CHOICE.fullmatch(value) is not None and not value.endswith(".yaml")


def _example(group: str) -> str:
    return f"{group}={next(file.stem for file in sorted((conf_folder() / group).glob('*.yaml')))}"


def _reason(error: Exception) -> str:
    """What Hydra says, on one line and without where its grammar is explained."""
    if str(error).startswith("LexerNoViableAlt"):
        return "spaces around = are not allowed, and a value with special characters stands in quotes, KEY='VALUE'"
    return shown(re.split(r" See https?://", " ".join(str(error).split()))[0], 300)


def _refused(override: str, allowed: str) -> ConfigurationError:
    return ConfigurationError(f"{shown(override)} is not allowed: {allowed}")


def _too_many(text: str) -> ConfigurationError:
    return ConfigurationError(f"{shown(text)} is not allowed: one command makes at most {_MOST_RUNS} runs")
