"""What `--help` says. Groups and choices are read from their files, stages from the registry."""

import re
import textwrap
from pathlib import Path

from pipeline.config.typed import GROUPS, conf_folder
from pipeline.stages import STAGES

__all__ = ["usage"]

_WIDTH = 100
_INDENT = 22

_HEAD = """\
usage: python -m pipeline [-m] [--config-dir DIR] [GROUP=CHOICE ...] [KEY=VALUE ...]
       python -m pipeline warmup         compile ahead what runs need, which is done once

How many steady motions a bevel gear pair with backlash has, over a whole plane of two parameters:
computed row by row, stored, drawn as a map. Without arguments: plane=omega_fe, some seconds; the
first run compiles its kernels for a minute or two.

examples
  python -m pipeline plane=omega_b quality=draft                          a first map, quick
  python -m pipeline plane=omega_fe gear=antiphase gear.b=0.8 store.name=mine    another gear
  python -m pipeline stages=[list]                                        what there is so far

overrides that people need (every key of conf/config.yaml is one: docs/reference/configuration.md)
  gear.b=0.5                        any parameter of the gear that is no axis of the plane
  plane.parameter.name=kappa        any scalar as an axis; also plane.parameter.min, .max, .num
  plane.sweep.num=800               columns of the plane; plane.parameter.num are its rows
  stages=[sweep,boundaries,figures] what to do, of the list below; this is the default
  figures.window=[0.5,0.7,0.1,0.3]  a part of the plane, drawn in addition, as sharp as the whole
  margins.point=[0.9,0.1]           a design point for stages=[margins]: column value, row value
  store.name=mine                   name of the store and of its figures' folder
  store.overwrite=true              replace a store that was made with other numbers
  cluster.workers=4                 worker processes on this machine
  output.root=results               where everything is written (default outputs)

"""

_TAIL = """
options
  -m, --multirun            every combination of comma-separated values, on one cluster:
                            -m plane=omega_b,omega_fe
  --config-dir DIR          a folder with your own gear/, plane/, ... files, listed here too
  --cfg job                 print the resolved configuration; of --package gear, that section
  --info                    print versions, where configuration files are, and the name of the store
  --version                 print the version
  --shell-completion SHELL  print completion for bash, zsh or fish: eval "$(... bash)"
  -h, --help                this text

exit status
  0  all well
  1  rows, boundaries or integrations failed, or disk or scheduler did: a line says what
  2  the input is not allowed; nothing was written
"""


def usage(config_dir: str | None = None) -> str:
    """The text, within 100 columns; with the choices of a user's own folder where one is given."""
    folders = [conf_folder(), *([Path(config_dir)] if config_dir else [])]
    configuration = (folders[0] / "config.yaml").read_text(encoding="utf-8")
    usual = dict(re.findall(r"^  - (\w+): (\w+)$", configuration, re.MULTILINE))
    lines = ["groups and their choices (* unless told otherwise)"]
    for group in GROUPS:
        lines.append(f"  {group}")
        for file in sorted(file for folder in folders for file in (folder / group).glob("*.yaml")):
            mark = "*" if usual.get(group) == file.stem else " "
            lines.append(_entry(f"  {mark} {file.stem}", _comment(file)))
    lines += ["", "stages"]
    lines += [_entry(f"    {entry.name}", entry.sentence) for entry in STAGES]
    return _HEAD + "\n".join(lines) + "\n" + _TAIL


def _entry(name: str, text: str) -> str:
    """A name and what it is, on as many lines as that takes."""
    beside = " " * (_INDENT + 1)
    whole = textwrap.fill(
        text, _WIDTH, break_on_hyphens=False, initial_indent=f"{name:<{_INDENT}} ", subsequent_indent=beside
    )
    return whole or name


def _comment(file: Path) -> str:
    """The first sentence of the comment that a file begins with."""
    words = []
    for line in file.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        words.append(line.lstrip("# "))
    return _first_sentence(" ".join(words))


def _first_sentence(text: str) -> str:
    return re.split(r"(?<=\.)\s", text, maxsplit=1)[0].removesuffix(".")
