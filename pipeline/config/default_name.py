"""The default name of a store: the plane's, and whatever differs from the defaults and changes numbers.

`plane=omega_fe gear.b=0.5` is `omega_fe-b=0.5`. The same configuration has the same name however it was typed, and
another one has another, so that `-m gear.b=0.5,0.6` makes two stores. The numbers of columns and rows are left out:
a map of another resolution is the same map.
"""

import hashlib
import re
from collections.abc import Iterator, Mapping

__all__ = ["default_name", "is_name"]

#: Choices of groups that have no word of their own.
_USUAL = {"gear": ("published",), "solver": ("first_order", "hb"), "quality": ("paper",)}
#: Sections whose values are compared.
_SECTIONS = ("gear", "plane", "solver")
#: What has a word of its own, or does not change what is mapped.
_LEFT_OUT = re.compile(r"plane\.(\w+\.num|layer|max_cells)|solver\.(balance|order|period)")

_LONGEST = 80
_DIGEST = 8
_NAME = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9_.+=-]{0,118}[A-Za-z0-9_+=-])?")
#: Names of devices on Windows, with whatever extension.
_DEVICE = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)


def is_name(name: str) -> bool:
    """Whether every system takes a name for a file and for a folder."""
    return _NAME.fullmatch(name) is not None and _DEVICE.fullmatch(name) is None


def default_name(choices: Mapping[str, str], config: Mapping, usual: Mapping) -> str:
    """The name of the store of a configuration.

    Parameters
    ----------
    choices : mapping
        Group -> chosen file.
    config, usual : mapping
        The configuration as plain data, and the one with the same choices where nothing else was typed.

    Returns
    -------
    str
        At most 80 characters that every file system takes, with a digest where that shortened or changed any.

    Examples
    --------
    >>> default_name({"plane": "omega_fe", "gear": "miter"}, {"gear": {"b": 0.5}}, {"gear": {"b": 1.0}})
    'omega_fe-miter-b=0.5'
    """
    words = [choices.get("plane", "plane")]
    words += [choices[group] for group, names in _USUAL.items() if choices.get(group, names[0]) not in names]
    solver = config.get("solver", {})
    if solver.get("balance", "describing_function") != "describing_function":
        words.append(f"order{solver['order']}")
    if solver.get("period", 1) != 1:
        words.append(f"period{solver['period']}")
    here, there = (
        {key: value for s in _SECTIONS for key, value in _flat(whole.get(s), s)} for whole in (config, usual)
    )
    changed = [key for key in here.keys() | there.keys() if here.get(key) != there.get(key)]
    words += [
        f"{key.partition('.')[2]}={_text(here.get(key))}" for key in sorted(changed) if not _LEFT_OUT.fullmatch(key)
    ]
    return _safe("-".join(words))


def _flat(value, key: str) -> Iterator[tuple[str, object]]:
    """Keys and values of the leaves."""
    if isinstance(value, Mapping):
        for name, child in value.items():
            yield from _flat(child, f"{key}.{name}")
    else:
        yield key, value


def _text(value) -> str:
    """A value as a word."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, list):
        return f"[{'+'.join(map(_text, value))}]"
    return repr(value).removesuffix(".0") if isinstance(value, int | float) else str(value)


def _safe(text: str) -> str:
    """A text as a name of a file, with a digest where it had to be changed.

    Examples
    --------
    >>> _safe("omega_fe-b=0.5"), _safe("omega_fe-torque=90 N*m")
    ('omega_fe-b=0.5', 'omega_fe-torque=90_N_m-1960c4df')
    """
    name = re.sub(r"[^A-Za-z0-9_.+=-]+", "_", text).strip("_.")
    if name == text and len(name) <= _LONGEST and is_name(name):
        return name
    digest = hashlib.sha256(text.encode()).hexdigest()[:_DIGEST]
    return f"{name[: _LONGEST - _DIGEST - 1] or 'plane'}-{digest}"
