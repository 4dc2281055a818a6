"""The examples of README.md, CONTRIBUTING.md and the pages of docs/, as blocks of text."""

import re
from dataclasses import dataclass
from pathlib import Path

from tests.docs.page import DOCS, ROOT

__all__ = ["PAGES", "Block", "Page", "commands_of", "is_command", "lines_of", "name_of", "page_of"]

PAGES = tuple(
    path
    for path in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md")))
    if "_build" not in path.parts
)
_FENCE = re.compile(r"^```(.*)\n((?:.*\n)*?)```$", re.MULTILINE)
_COMMAND = re.compile(r"(?:\.venv/bin/)?(?:python -m pipeline|bevelmap)(?: (.*?))?(?:  +#.*)?")
_TABLE = re.compile(r"^\| words \|.*\n\| --- .*\n((?:\|.*\n)+)", re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """One fenced block: its language, text, the line of the page that it starts on, and the paragraph before it."""

    language: str
    text: str
    line: int
    before: str


@dataclass(frozen=True)
class Page:
    """All blocks of a page."""

    path: Path
    blocks: tuple[Block, ...]

    def of(self, language: str) -> list[Block]:
        """The blocks in one language."""
        return [block for block in self.blocks if block.language == language]

    @property
    def outputs(self) -> list[tuple[Block, Block]]:
        """Code and what the page shows as its output: a text that follows with nothing between."""
        pairs = zip(self.blocks, self.blocks[1:], strict=False)
        return [(one, two) for one, two in pairs if two.language == "text" and not two.before]

    @property
    def files(self) -> list[tuple[str, str]]:
        """Path and text of files that the page tells to write: blocks after a text that ends with their path."""
        found = []
        for block in self.blocks:
            path = re.search(r"`(mine/[\w./-]+)`[^`]*:$", block.before)
            if block.language in ("yaml", "text") and path:
                found.append((path[1], block.text))
        return found


def page_of(path: Path) -> Page:
    """Read a page."""
    text, blocks, end = path.read_text(encoding="utf-8"), [], 0
    for match in _FENCE.finditer(text):
        between = text[end : match.start()].strip()
        paragraph = re.split(r"\n\s*\n", between)[-1]
        blocks.append(Block(match[1].strip(), match[2], text.count("\n", 0, match.start()) + 2, paragraph))
        end = match.end()
    return Page(path, tuple(blocks))


def commands_of(page: Page) -> list[str]:
    """What follows `python -m pipeline` in every command of a page: lines of its blocks, and tables of such words."""
    found = [_COMMAND.fullmatch(line)[1] or "" for line in lines_of(page) if is_command(line)]
    for table in _TABLE.findall(page.path.read_text(encoding="utf-8")):
        for row in table.splitlines():
            found += re.findall("`([^`]+)`", row.split(" | ")[0])
    return found


def lines_of(page: Page) -> list[str]:
    """Lines of the shell, those that a backslash continues as one."""
    texts = [re.sub(r" *\\\n +", " ", block.text) for block in page.of("sh")]
    return [line.strip() for text in texts for line in text.splitlines() if line.strip()]


def is_command(line: str) -> bool:
    """Whether a line of the shell runs the pipeline."""
    return _COMMAND.fullmatch(line) is not None and "|" not in line


def name_of(path: Path) -> str:
    """A page's path within the repository."""
    return path.relative_to(ROOT).as_posix()
