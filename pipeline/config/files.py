"""Looking over a user's own configuration files before Hydra reads them: they may come from someone else.

YAML names nodes and repeats them by name, so that a few lines can stand for more than any memory holds; and Hydra's
reader walks nested nodes by recursion. Both are counted here on the parser's events, of which nothing is built.
"""

import re
from pathlib import Path

import yaml

from pipeline.errors import ConfigurationError

__all__ = ["check_files"]

_MOST_BYTES = 2**20
_MOST_NODES = 10_000
_MOST_DEEP = 30


def check_files(folder: Path) -> None:
    """Raise ConfigurationError unless every YAML file of a folder is plain data of a bearable size."""
    for file in sorted(folder.rglob("*.yaml")):
        if not file.is_file():
            raise _refused(file, "it must be a file")
        try:
            if file.stat().st_size > _MOST_BYTES:
                raise _refused(file, f"it must be at most {_MOST_BYTES} bytes long")
            nodes = _nodes(file, file.read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError) as error:
            raise _refused(file, f"it cannot be read ({' '.join(str(error).split())})") from None
        except yaml.YAMLError as error:
            raise _refused(file, f"it must be YAML ({' '.join(str(error).split())})") from None
        if nodes > _MOST_NODES:
            raise _refused(file, f"it must stand for at most {_MOST_NODES} values, repeated ones included")


def _refused(file: Path, allowed: str) -> ConfigurationError:
    return ConfigurationError(f"--config-dir: {file} is not allowed: {allowed}")


def _nodes(file: Path, text: str) -> int:
    """Values in a file with all repetitions written out, or more than are allowed."""
    open_, sizes = [["", 0]], {}
    for event in yaml.parse(text, Loader=yaml.SafeLoader):
        tag = getattr(event, "tag", None)
        if tag is not None and not re.fullmatch(r"!|tag:yaml\.org,2002:\w+", tag):
            raise _refused(file, f"the tag {tag[:80]!r} names no plain data")
        if isinstance(event, yaml.CollectionStartEvent):
            open_.append([event.anchor, 1])
        elif isinstance(event, yaml.CollectionEndEvent):
            anchor, size = open_.pop()
            sizes[anchor] = size
            open_[-1][1] += size
        elif isinstance(event, yaml.ScalarEvent):
            sizes[event.anchor] = 1
            open_[-1][1] += 1
        elif isinstance(event, yaml.AliasEvent):
            # A node within itself is not known yet, and has no end.
            open_[-1][1] += sizes.get(event.anchor, _MOST_NODES + 1)
        if len(open_) > _MOST_DEEP:
            raise _refused(file, f"it must not be nested deeper than {_MOST_DEEP}")
        if open_[-1][1] > _MOST_NODES:
            return open_[-1][1]
    return open_[0][1]
