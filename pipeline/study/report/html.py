"""A document as one HTML page that needs nothing else: style and figures are inside."""

import base64
from html import escape

from pipeline.study.agreement import AGREES, DIFFERS, NOT_COMPARED
from pipeline.study.report.document import Block, Bullets, Document, Grid, Heading, Listing, Paragraph, Picture

__all__ = ["html"]

_STYLE = """
body { font: 16px/1.5 Georgia, 'Times New Roman', serif; color: #1a1a1a;
  max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2, h3 { font-family: Helvetica, Arial, sans-serif; line-height: 1.25; }
h2 { margin-top: 2.5rem; border-bottom: 1px solid #bbb; padding-bottom: .2rem; }
nav li { margin: .1rem 0; }
figure { margin: 1.5rem 0; } figure img { max-width: 100%; height: auto; }
figcaption, caption { font-size: .9rem; color: #444; text-align: left; padding: .3rem 0; caption-side: top; }
div.grid { overflow-x: auto; margin: 1.2rem 0; }
table { border-collapse: collapse; font: 14px/1.4 Helvetica, Arial, sans-serif; border-top: 2px solid #1a1a1a;
  border-bottom: 2px solid #1a1a1a; }
th { text-align: left; border-bottom: 1px solid #1a1a1a; } th, td { padding: .3rem .7rem .3rem 0; vertical-align: top; }
tbody tr + tr td { border-top: 1px solid #ddd; }
.agrees { color: #00503c; font-weight: bold; } .differs { color: #8a3000; font-weight: bold; }
.cannot { font-weight: bold; }
pre { background: #f4f4f4; padding: .8rem; overflow-x: auto; font-size: .85rem; }
"""


def html(document: Document) -> str:
    """The page's text, ending with a newline."""
    sections = [block.text for block in document.blocks if isinstance(block, Heading) and block.level == 2]
    links = "\n".join(f'<li><a href="#{_anchor(text)}">{escape(text)}</a></li>' for text in sections)
    body = "\n".join(_block(block) for block in document.blocks)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(document.title)}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n<main>\n"
        f'<h1>{escape(document.title)}</h1>\n<nav aria-label="Contents">\n<ol>\n{links}\n</ol>\n</nav>\n{body}\n'
        "</main>\n</body>\n</html>\n"
    )


def _anchor(text: str) -> str:
    return "".join(c if c.isascii() and c.isalnum() else "-" for c in text.lower()).strip("-")


def _block(block: Block) -> str:
    match block:
        case Heading():
            anchor = f' id="{_anchor(block.text)}"' if block.level == 2 else ""
            return f"<h{block.level}{anchor}>{escape(block.text)}</h{block.level}>"
        case Paragraph():
            return f"<p>{escape(block.text)}</p>"
        case Bullets():
            items = "\n".join(f"<li>{escape(item)}</li>" for item in block.items)
            return f"<ul>\n{items}\n</ul>"
        case Grid():
            head = "".join(f'<th scope="col">{escape(text)}</th>' for text in block.headings)
            rows = "\n".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in block.rows)
            return (
                f'<div class="grid"><table>\n<caption>{escape(block.caption)}</caption>\n'
                f"<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}\n</tbody>\n</table></div>"
            )
        case Picture():
            data, caption = base64.b64encode(block.png).decode("ascii"), escape(block.caption)
            return (
                f'<figure>\n<img alt="{caption}" src="data:image/png;base64,{data}">\n'
                f"<figcaption>{caption}</figcaption>\n</figure>"
            )
        case Listing():
            text = f"<pre>{escape(block.text)}</pre>"
            summary = f"<summary>{escape(block.summary)}</summary>"
            return f"<details>\n{summary}\n{text}\n</details>" if block.summary else text


def _cell(text: str) -> str:
    return f"<td>{'<br>'.join(map(_line, text.splitlines()))}</td>"


def _line(text: str) -> str:
    """A line of a cell; a verdict stands out, by weight as well as by colour."""
    verdict, colon, reason = text.partition(":")
    if verdict not in (AGREES, DIFFERS, NOT_COMPARED):
        return escape(text)
    return f'<span class="{verdict.split()[0]}">{verdict}</span>{colon}{escape(reason)}'
