"""The command line's options, parsed by hand, so that a mistake is one line like any other.

Hydra's own options are known too: what makes sense here is done, and the others are answered with what to type instead.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from pipeline.errors import ConfigurationError, shown

__all__ = ["OPTIONS", "Arguments", "parse"]

OPTIONS = (
    "-m",
    "--multirun",
    "--config-dir",
    "--cfg",
    "--package",
    "--info",
    "--version",
    "--shell-completion",
    "-h",
    "--help",
)

_SHORT = {
    "-m": "--multirun",
    "-h": "--help",
    "-c": "--cfg",
    "-p": "--package",
    "-i": "--info",
    "-cd": "--config-dir",
    "-sc": "--shell-completion",
    "-r": "--run",
    "-cp": "--config-path",
    "-cn": "--config-name",
}
_FLAGS = {"--help": "usage", "--multirun": "multirun", "--version": "version", "--resolve": "", "--run": ""}
_VALUES = {"--config-dir": "config_dir", "--shell-completion": "shell", "--package": "package"}
_NEEDS = {
    "--config-dir": "needs a folder",
    "--shell-completion": "needs a shell: bash, zsh or fish",
    "--package": "needs a section, such as gear",
}
#: Options of Hydra's that may be followed by one of some words; those that are done here come first.
_OPTIONAL = {
    "--cfg": ("job", "hydra", "all"),
    "--info": ("all", "config", "defaults", "defaults-tree", "plugins", "searchpath"),
}
_OWN = "Hydra's own settings are fixed here, so that it writes nothing"
#: Hydra's options that have nothing to do here, and what does what they do.
_INSTEAD = {
    "--config-path": "files of your own go into a folder with gear/, plane/, ..., named by --config-dir DIR",
    "--config-name": "files of your own are chosen by group, as in --config-dir DIR gear=mine",
    "--experimental-rerun": "what a run was told is in outputs/runs/NAME/TIME/overrides.txt; type that again",
    "--hydra-help": f"{_OWN}; --help says what there is",
}


@dataclass(frozen=True)
class Arguments:
    """What was asked for.

    Parameters
    ----------
    overrides : tuple of str
    multirun, usage, version, warmup : bool
        Several values allowed; the help is to be printed; the version is; everything is to be compiled.
    show : bool
        The resolved configuration is to be printed.
    package : str or None
        Of the configuration, this section alone.
    info : bool
        Where the configuration comes from is to be printed.
    config_dir : str or None
        The user's own folder of choices.
    shell : str or None
        Whose completion script is to be printed.
    complete : tuple of str or None
        The words of a command line that is being typed, the last one not finished.
    """

    overrides: tuple[str, ...] = ()
    multirun: bool = False
    usage: bool = False
    version: bool = False
    warmup: bool = False
    show: bool = False
    package: str | None = None
    info: bool = False
    config_dir: str | None = None
    shell: str | None = None
    complete: tuple[str, ...] | None = None


def parse(arguments: list[str]) -> Arguments:
    """Read the arguments.

    Raises
    ------
    ConfigurationError
        If an option is not known, lacks its value, or is one of Hydra's that is not for this program.

    Examples
    --------
    >>> asked = parse(["-m", "gear.b=0.5,0.6", "--cfg", "job"])
    >>> asked.multirun, asked.show, asked.overrides
    (True, True, ('gear.b=0.5,0.6',))
    """
    found, overrides = {}, []
    rest = _Words(arguments)
    for word in rest:
        if word == "--complete":
            found["complete"] = tuple(rest)
        elif word == "warmup":
            found["warmup"] = True
        elif word.startswith("-"):
            _read_option(word, rest, found)
        else:
            overrides.append(word)
    if "warmup" in found and overrides:
        raise ConfigurationError(f"{shown(overrides[0])} is not allowed with warmup, which compiles all that runs need")
    if "package" in found and "show" not in found:
        raise ConfigurationError(f"--package {shown(found['package'])} is not allowed alone: --cfg job needs it")
    return Arguments(tuple(overrides), **found)


class _Words:
    """Words of a command line, of which the next one can be looked at."""

    def __init__(self, words: list[str]):
        self._left = list(reversed(words))

    def __iter__(self) -> Iterator[str]:
        return self

    def __next__(self) -> str:
        if not self._left:
            raise StopIteration
        return self._left.pop()

    def take(self, allowed) -> str | None:
        """The next word, if it is allowed; then it is used up."""
        return self._left.pop() if self._left and allowed(self._left[-1]) else None


def _read_option(word: str, rest: _Words, found: dict) -> None:
    """Put into `found` what an option says."""
    name, equals, value = word.partition("=")
    option = _SHORT.get(name, name)
    if option in _INSTEAD:
        raise ConfigurationError(f"{name} is not for this program: {_INSTEAD[option]}")
    if option in _FLAGS and not equals:
        found |= {_FLAGS[option]: True} if _FLAGS[option] else {}
    elif option in _OPTIONAL:
        words = _OPTIONAL[option]
        kind = value if equals else rest.take(lambda following: following in words) or words[0]
        if kind not in words:
            raise ConfigurationError(f"{shown(word)} is not allowed: {option} takes one of {', '.join(words)}")
        if option == "--cfg" and kind != "job":
            raise ConfigurationError(f"--cfg {kind} is not for this program: {_OWN}; --cfg job prints the others")
        found["show" if option == "--cfg" or kind == "config" else "info"] = True
    elif option in _VALUES:
        text = value if equals else rest.take(lambda following: not following.startswith("-"))
        if not text:
            raise ConfigurationError(f"{option} {_NEEDS[option]}")
        found[_VALUES[option]] = text
    else:
        raise ConfigurationError(f"{shown(word)} is not an option; --help lists them")
