"""The command line's options, parsed by hand, so that a mistake is one line like any other."""

from dataclasses import dataclass

from pipeline.errors import ConfigurationError

__all__ = ["OPTIONS", "Arguments", "parse"]

OPTIONS = ("-m", "--multirun", "--config-dir", "--cfg", "--shell-completion", "-h", "--help")


@dataclass(frozen=True)
class Arguments:
    """What was asked for.

    Parameters
    ----------
    overrides : tuple of str
    multirun, show, usage : bool
        Several values allowed; the configuration is to be printed; the help is.
    config_dir : str or None
        The user's own folder of choices.
    shell : str or None
        Whose completion script is to be printed.
    complete : tuple of str or None
        The words of a command line that is being typed, the last one not finished.
    """

    overrides: tuple[str, ...] = ()
    multirun: bool = False
    show: bool = False
    usage: bool = False
    config_dir: str | None = None
    shell: str | None = None
    complete: tuple[str, ...] | None = None


def parse(arguments: list[str]) -> Arguments:
    """Read the arguments.

    Raises
    ------
    ConfigurationError
        If an option is not known or lacks its value.
    """
    found, overrides = {}, []
    rest = iter(arguments)
    for argument in rest:
        option, equals, value = argument.partition("=")
        if argument in ("-h", "--help"):
            found["usage"] = True
        elif argument in ("-m", "--multirun"):
            found["multirun"] = True
        elif argument in ("--cfg", "-c"):
            found["show"] = True
        elif argument == "--complete":
            found["complete"] = tuple(rest)
        elif option in ("--config-dir", "-cd"):
            found["config_dir"] = value if equals else next(rest, None)
            if not found["config_dir"]:
                raise ConfigurationError("--config-dir needs a folder")
        elif option in ("--shell-completion", "-sc"):
            found["shell"] = value if equals else next(rest, "")
        elif argument.startswith("-"):
            raise ConfigurationError(f"{argument} is not an option; --help lists them")
        else:
            overrides.append(argument)
    return Arguments(tuple(overrides), **found)
