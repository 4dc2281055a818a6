r"""A table as LaTeX: three floats to \input, rules by booktabs, ASCII only."""

import re

from pipeline.study.agreement import AGREES, DIFFERS, NOT_COMPARED
from pipeline.study.tables.sheets import Sheet, grid_sheet, label_sheet, measured_sheet, notes, tally
from pipeline.study.tables.table import Table

__all__ = ["escape", "latex"]

#: What the texts may hold beyond plain ASCII words, longest first where one begins another.
_SIGNS = {
    "f_pm": r"$f_{pm}$",
    "λ_a": r"$\lambda_a$",
    "1/√2": r"$1/\sqrt{2}$",
    "Ω": r"$\Omega$",
    "α": r"$\alpha$",
    "±": r"$\pm$",
    "−": r"$-$",
    "–": "--",
    "“": "``",
    "”": "''",
    "\\": r"\textbackslash{}",
    "<": "$<$",
    ">": "$>$",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "\n": r"\newline ",
    " %": r"~\%",
    "%": r"\%",
    "_": r"\_",
    "&": r"\&",
    "#": r"\#",
    "$": r"\$",
    "{": r"\{",
    "}": r"\}",
}
_PATTERN = re.compile("|".join(re.escape(sign) for sign in _SIGNS))

_VERDICT = re.compile(rf"\\newline ({AGREES}|{DIFFERS}|{NOT_COMPARED}):")

# Room between columns, taken off the width that the columns share.
_SHARED = 0.9


def latex(table: Table) -> str:
    """The table's text."""
    number = table.article.number
    head = (
        f"% bevelmap, from {escape(table.store)}; needs \\usepackage{{booktabs}}; use with \\input{{table{number}.tex}}"
    )
    grid = _float(grid_sheet(table), f"tab:bevelmap-{number}", tally([table]))
    measured = _float(measured_sheet(table), f"tab:bevelmap-{number}-measured")
    labels = _float(label_sheet(table), f"tab:bevelmap-{number}-labels")
    # Outside of the floats: they are longer than a page may hold beside a table.
    remarks = "\n".join(f"\\par {escape(note)}" for note in notes(table))
    return f"{head}\n{grid}\n{measured}\n{labels}\n{{\\scriptsize\\raggedright\\noindent\n{remarks}\n\\par}}\n"


def _float(sheet: Sheet, label: str, said: str = "") -> str:
    columns = "".join(f"p{{{_SHARED * width:.4f}\\linewidth}}" for width in sheet.widths)
    first = [row[0] for row in sheet.rows]
    body = []
    for number, row in enumerate(sheet.rows):
        if number and sheet.grouped and first[number] != first[number - 1]:
            body.append(r"\addlinespace")
        body.append(_row(row))
    caption = f"{sheet.caption}. {said}" if said else sheet.caption
    lines = [r"\toprule", _row(sheet.headings), r"\midrule", *body, r"\bottomrule"]
    return (
        f"\\begin{{table}}[htbp]\n\\caption{{{escape(caption)}}}\n\\label{{{label}}}\n"
        f"\\scriptsize\\setlength{{\\tabcolsep}}{{0.006\\linewidth}}\\renewcommand{{\\arraystretch}}{{1.2}}\n"
        f"\\begin{{tabular}}{{@{{}}{columns}@{{}}}}\n" + "\n".join(lines) + "\n\\end{tabular}\n\\end{table}\n"
    )


def _row(cells) -> str:
    # \tabularnewline, because \raggedright gives \\ another meaning.
    texts = (_VERDICT.sub(r"\\newline \\textbf{\1}:", escape(cell)) for cell in cells)
    return " & ".join(f"\\raggedright {text}" for text in texts) + r" \tabularnewline"


def escape(text: str) -> str:
    r"""Plain text as LaTeX.

    Examples
    --------
    >>> escape("f_pm > 50 %, λ_a = −1")
    '$f_{pm}$ $>$ 50~\\%, $\\lambda_a$ = $-$1'
    """
    return _PATTERN.sub(lambda match: _SIGNS[match[0]], text)
