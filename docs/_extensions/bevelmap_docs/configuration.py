"""Configuration keys as tables: types from the schema, defaults and meanings from conf/ and its comments."""

import dataclasses
import re
import types
import typing
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import yaml

from pipeline.config.allowed import sentence_of
from pipeline.config.schema import Configuration

__all__ = ["PARTS", "Key", "choices", "documented", "keys", "types_of_keys"]

CONF = Path(__file__).parents[3] / "conf"
#: Parts of the configuration whose keys stand in files of their own, and how the names of these keys begin. Of a second
#: file, those that the first one lacks.
_FILES = {
    "gear": ("gear/published.yaml", "gear."),
    "gear.physical": ("gear/dimensional.yaml", "gear."),
    "gear.thermal": ("gear/thermal/steel.yaml", "gear.thermal."),
    "gear.spur": ("gear/spur.yaml", "gear."),
    "gear.rotor": ("gear/rotor.yaml", "gear."),
    "gear.system": ("gear/system.yaml", "gear."),
    "plane": ("plane/omega_fe.yaml", "plane."),
    "solver": ("solver/first_order.yaml", "solver."),
    "cluster": ("cluster/local.yaml cluster/slurm.yaml", "cluster."),
    "quality": ("quality/paper.yaml", "quality."),
}
PARTS = (*_FILES, *(field.name for field in dataclasses.fields(Configuration) if field.name not in _FILES))
_TYPES = {float: "number", int: "whole number", str: "text", bool: "true or false", type(None): "null"}


@dataclass(frozen=True)
class Key:
    """One key: its full name, default as conf/ has it, type (empty where its meaning says it) and meaning."""

    name: str
    default: str
    type: str
    meaning: str


def keys(part: str) -> str:
    """A part of the configuration, such as `store` or `gear.physical`: its comment, and its keys as a table."""
    lines, head = ["| key | default | type | meaning |", "| --- | --- | --- | --- |"], ""
    for key in documented(part):
        if key.name == part and not key.default:
            head = f"{key.meaning}\n\n" if key.meaning else ""
            continue
        lines.append(_row(f"`{key.name}`", f"`{key.default}`" if key.default else "", key.type, key.meaning))
    return head + "\n".join(lines)


def choices(group: str) -> str:
    """The files of a group of conf/, each with the comment that it begins with, as a table."""
    defaults = yaml.safe_load((CONF / "config.yaml").read_text(encoding="utf-8"))["defaults"]
    lines = [f"| `{group}=` | what it is |", "| --- | --- |"]
    for file in sorted((CONF / group).glob("*.yaml")):
        text = file.read_text(encoding="utf-8").splitlines()
        size = next(i for i, line in enumerate(text) if not line.startswith("#"))
        mark = " (default)" if {group: file.stem} in defaults else ""
        lines.append(_row(f"`{file.stem}`{mark}", _comment(text, size, 0)))
    return "\n".join(lines)


def documented(part: str) -> list[Key]:
    """The keys of a part of the configuration, in the order of its file.

    Raises
    ------
    KeyError
        If the file has a key that the schema does not know.
    """
    files, prefix = _FILES.get(part, ("config.yaml", ""))
    found = {}
    for file in files.split():
        found |= {key.name: key for key in _of_file(part, file, prefix) if key.name not in found}
    return list(found.values())


def _of_file(part: str, file: str, prefix: str) -> list[Key]:
    text, known, found = (CONF / file).read_text(encoding="utf-8"), types_of_keys(), []
    lines = text.splitlines()
    for name, key, value in _nodes(yaml.compose(text, Loader=yaml.SafeLoader), prefix):
        if name != part and not name.startswith(f"{part}."):
            continue
        nested = isinstance(value, yaml.MappingNode)
        line = key.start_mark.line
        behind = lines[line] if nested else lines[value.end_mark.line][value.end_mark.column :]
        parts = (_comment(lines, line, 1), behind.partition("#")[2].strip())
        default = "" if nested else text[value.start_mark.index : value.end_mark.index]
        found.append(Key(name, default, known[name], " ".join(filter(None, parts))))
    return found


def types_of_keys(of: type = Configuration, prefix: str = "") -> dict[str, str]:
    """Full name of every key of the schema -> its type in words; empty for nested keys, and where any is allowed."""
    found = {}
    for name, hint in typing.get_type_hints(of).items():
        allowed = sentence_of(of, name)
        found[f"{prefix}{name}"] = f"{_words(hint)}, {allowed}" if allowed else _words(hint)
        for option in typing.get_args(hint) or (hint,):
            if dataclasses.is_dataclass(option):
                found |= types_of_keys(option, f"{prefix}{name}.")
    return found


def _words(hint) -> str:
    if hint in _TYPES:
        return _TYPES[hint]
    if typing.get_origin(hint) is list:
        (item,) = typing.get_args(hint)
        return f"list of {_TYPES[item]}s" if item is not str else "list of texts"
    if isinstance(hint, types.UnionType):
        words = [_words(option) for option in typing.get_args(hint)]
        return " or ".join(words) if all(words) else ""
    return ""


def _nodes(root: yaml.MappingNode, prefix: str) -> Iterator[tuple[str, yaml.Node, yaml.Node]]:
    """Full name, key and value of every entry of a file, nested ones after what they are nested in."""
    for key, value in root.value:
        if key.value == "defaults" and root.start_mark.column == 0:
            continue
        yield f"{prefix}{key.value}", key, value
        if isinstance(value, yaml.MappingNode):
            yield from _nodes(value, f"{prefix}{key.value}.")


def _comment(lines: list[str], stop: int, first: int) -> str:
    """The comment on the lines before line `stop`; one that begins above line `first` is about the whole file."""
    start = stop
    while start > 0 and lines[start - 1].lstrip().startswith("#"):
        start -= 1
    return "" if start < first else " ".join(line.strip(" #") for line in lines[start:stop])


def _row(*cells: str) -> str:
    """A row of a table, in which nothing of the text is taken for a border or for HTML."""
    return "| " + " | ".join(re.sub(r"([|<])", r"\\\1", cell) for cell in cells) + " |"
