"""A document as data: what the report says, whatever format it is written in."""

from dataclasses import dataclass

__all__ = ["Block", "Bullets", "Document", "Grid", "Heading", "Listing", "Paragraph", "Picture"]


@dataclass(frozen=True)
class Heading:
    """A heading of level 2 or 3; level 1 is the document's title."""

    text: str
    level: int = 2


@dataclass(frozen=True)
class Paragraph:
    """Plain text."""

    text: str


@dataclass(frozen=True)
class Bullets:
    """A list of plain texts."""

    items: tuple[str, ...]


@dataclass(frozen=True)
class Grid:
    """A table of plain text under headings; every row has as many cells as there are headings."""

    caption: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Picture:
    """A figure: a plain name, unique in the document, its caption and its PNG."""

    name: str
    caption: str
    png: bytes


@dataclass(frozen=True)
class Listing:
    """Lines to be typed, or a file's text; with a summary it is folded away where the format can do that."""

    text: str
    summary: str = ""


Block = Heading | Paragraph | Bullets | Grid | Picture | Listing


@dataclass(frozen=True)
class Document:
    """Title and blocks in order."""

    title: str
    blocks: tuple[Block, ...]
