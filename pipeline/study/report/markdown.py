"""A document as Markdown, with its figures as files beside it."""

from pipeline.run.sheets import escaped, pipes
from pipeline.study.report.document import Block, Bullets, Document, Grid, Heading, Listing, Paragraph, Picture

__all__ = ["FIGURES", "markdown"]

#: Folder of the figures, beside the text.
FIGURES = "figures"


def markdown(document: Document) -> str:
    """The text, ending with a newline."""
    return "\n\n".join([f"# {escaped(document.title)}", *map(_block, document.blocks)]) + "\n"


def _block(block: Block) -> str:
    match block:
        case Heading():
            return f"{'#' * block.level} {escaped(block.text)}"
        case Paragraph():
            return escaped(block.text)
        case Bullets():
            return "\n".join(f"- {escaped(item)}" for item in block.items)
        case Grid():
            return f"{escaped(block.caption)}\n\n{pipes(block.headings, block.rows)}"
        case Picture():
            caption = escaped(block.caption)
            return f"![{caption}]({FIGURES}/{block.name}.png)\n\n{caption}"
        case Listing():
            summary = [escaped(block.summary), ""] if block.summary else []
            return "\n".join([*summary, "```", block.text.rstrip(), "```"])
