"""A document as Markdown, with its figures as files beside it."""

from functools import singledispatch

from pipeline.run.sheets import escaped, pipes
from pipeline.study.report.document import Bullets, Document, Grid, Heading, Listing, Paragraph, Picture

__all__ = ["FIGURES", "markdown"]

#: Folder of the figures, beside the text.
FIGURES = "figures"


def markdown(document: Document) -> str:
    """The text, ending with a newline."""
    return "\n\n".join([f"# {escaped(document.title)}", *map(_block, document.blocks)]) + "\n"


@singledispatch
def _block(block) -> str:
    raise TypeError(f"{type(block).__name__} is no block of a document")


@_block.register
def _(block: Heading) -> str:
    return f"{'#' * block.level} {escaped(block.text)}"


@_block.register
def _(block: Paragraph) -> str:
    return escaped(block.text)


@_block.register
def _(block: Bullets) -> str:
    return "\n".join(f"- {escaped(item)}" for item in block.items)


@_block.register
def _(block: Grid) -> str:
    return f"{escaped(block.caption)}\n\n{pipes(block.headings, block.rows)}"


@_block.register
def _(block: Picture) -> str:
    caption = escaped(block.caption)
    return f"![{caption}]({FIGURES}/{block.name}.png)\n\n{caption}"


@_block.register
def _(block: Listing) -> str:
    return "\n".join([*([escaped(block.summary), ""] if block.summary else []), "```", block.text.rstrip(), "```"])
