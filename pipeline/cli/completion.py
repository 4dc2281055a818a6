"""Completion of groups, choices, keys and stages in a shell, by what Hydra's own completion knows of our configuration.

Hydra offers it to programs that `hydra.main` starts, of which this is none. Its query is used; the scripts are ours.
"""

import re
import shlex
import sys
from pathlib import Path

from pipeline.cli.arguments import OPTIONS
from pipeline.config.typed import loader
from pipeline.errors import ConfigurationError
from pipeline.stages import STAGES

__all__ = ["SHELLS", "candidates", "script"]

_BASH = """\
_bevelmap()
{
    local line=${COMP_LINE:0:COMP_POINT} IFS=$' \\t\\n'
    local -a words
    read -ra words <<< "$line"
    [[ $line == *[[:space:]] ]] && words+=("")
    if [[ ${words[0]##*/} == python* && ${words[*]:1:2} != "-m pipeline" ]]; then
        return
    fi
    IFS=$'\\n'
    COMPREPLY=($(COMMAND --complete "${words[@]}" 2> /dev/null))
    # Readline takes what follows the last = for the word.
    local word=${words[-1]}
    if [[ $COMP_WORDBREAKS == *=* && $word == *=* ]]; then
        COMPREPLY=("${COMPREPLY[@]#"${word%=*}="}")
    fi
}
complete -o nospace -o bashdefault -o default -F _bevelmap bevelmap python python3
"""

_ZSH = """\
_bevelmap()
{
    if [[ ${words[1]:t} == python* && "${words[2]} ${words[3]}" != "-m pipeline" ]]; then
        _default
        return
    fi
    local -a found
    found=("${(@f)$(COMMAND --complete "${(@)words[1,CURRENT]}" 2> /dev/null)}")
    compadd -S '' -a found
}
compdef _bevelmap bevelmap python python3
"""

_FISH = """\
function __bevelmap
    COMMAND --complete (commandline -opc) (commandline -ct) 2> /dev/null
end
complete -c bevelmap -f -a '(__bevelmap)'
complete -c python -c python3 -f -a '(__bevelmap)' \\
    -n '__fish_seen_argument -s m; and __fish_seen_subcommand_from pipeline'
"""

SHELLS = {"bash": _BASH, "zsh": _ZSH, "fish": _FISH}

#: The members of a list, which Hydra offers as keys.
_MEMBER = re.compile(r"[=.]\d+[=.]$")


def script(shell: str) -> str:
    """What a shell must evaluate.

    Raises
    ------
    ConfigurationError
        If the shell is not known.
    """
    if shell not in SHELLS:
        raise ConfigurationError(
            f"--shell-completion = {shell!r} is not allowed: it must be one of {', '.join(SHELLS)}"
        )
    return SHELLS[shell].replace("COMMAND", f"{shlex.quote(sys.executable)} -m pipeline")


def candidates(words: tuple[str, ...]) -> list[str]:
    """What the last word of a command line may become, sorted.

    Parameters
    ----------
    words : tuple of str
        The line so far, the command itself included; the last is being typed and may be empty.

    Examples
    --------
    >>> candidates(("bevelmap", "quality=d"))
    ['quality=draft']
    >>> candidates(("python", "-m", "pipeline", "plane=omega_b,omega_fp"))
    ['plane=omega_b,omega_fpm']
    >>> candidates(("bevelmap", "stages=[sweep,ta"))
    ['stages=[sweep,tables']
    """
    if not words:
        return []
    given = list(words[3 if Path(words[0]).name.startswith("python") else 1 :]) or [""]
    *before, word = given
    if word.startswith("-"):
        return [option for option in OPTIONS if option.startswith(word)]
    if word.startswith("stages="):
        return _listed(word, "[")
    config_dir, overrides = _split(before)
    head, comma, _ = word.rpartition(",")
    key, equals, _ = word.partition("=")
    if not comma:
        return _asked(word, overrides, config_dir)
    # Of several values the last one is being typed.
    last = f"{key}{equals}{word.rpartition(',')[2]}"
    return [f"{head},{found.partition('=')[2]}" for found in _asked(last, overrides, config_dir)]


def _listed(word: str, bracket: str) -> list[str]:
    value = word.partition("=")[2].lstrip(bracket)
    head, comma, start = value.rpartition(",")
    names = [entry.name for entry in STAGES]
    return sorted(f"stages={bracket}{head}{comma}{name}" for name in names if name.startswith(start))


def _split(words: list[str]) -> tuple[str | None, list[str]]:
    """The user's own folder among the words, and the overrides among them that Hydra can read."""
    config_dir, overrides, rest = None, [], iter(words)
    for word in rest:
        if word in ("--config-dir", "-cd"):
            config_dir = next(rest, None)
        elif word.startswith("--config-dir="):
            config_dir = word.partition("=")[2]
        elif "=" in word and not word.startswith("-") and "," not in word:
            overrides.append(word)
    return config_dir, overrides


def _asked(word: str, overrides: list[str], config_dir: str | None) -> list[str]:
    """Hydra's answer, without its own settings."""
    from hydra.plugins.completion_plugin import DefaultCompletionPlugin

    known = loader(config_dir)
    found = DefaultCompletionPlugin(known)._query("config", " ".join([*overrides, word]))
    # It also offers its own settings, and members of lists as keys.
    found = [one for one in found if one.startswith(word) and not one.startswith("hydra") and not _MEMBER.search(one)]
    lists = _lists(known, overrides, found)
    return sorted({_with_value(one, lists) for one in found})


def _lists(known, overrides: list[str], found: list[str]) -> set[str]:
    """Which of the keys that Hydra takes for sections are lists."""
    from hydra.errors import HydraException
    from hydra.types import RunMode
    from omegaconf import OmegaConf

    sections = [key for key in found if key.endswith(".")]
    try:
        config = known.load_configuration("config", overrides=overrides, run_mode=RunMode.RUN) if sections else {}
    except HydraException:
        return set()
    return {key for key in sections if OmegaConf.is_list(OmegaConf.select(config, key[:-1]))}


def _with_value(key: str, lists: set[str]) -> str:
    """A key as it goes on: lists take a value as a whole, and so do groups that have folders beside their files."""
    if key in lists:
        return f"{key[:-1]}="
    return key if "=" in key or key[-1] in "./" else f"{key}="
