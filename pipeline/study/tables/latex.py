r"""A table as LaTeX: three floats to \input, rules by booktabs, ASCII only."""

import re

from pipeline.study.tables.sheets import Sheet, class_sheet, label_sheet, measured_sheet, notes
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

# Room between columns, taken off the width that the columns share.
_SHARED = 0.9


def latex(table: Table) -> str:
    """The table's text."""
    number = table.article.number
    head = (
        f"% bevelmap, from {escape(table.store)}; needs \\usepackage{{booktabs}}; use with \\input{{table{number}.tex}}"
    )
    measured = _float(measured_sheet(table), f"tab:bevelmap-{number}-measured")
    labels = _float(label_sheet(table), f"tab:bevelmap-{number}-labels")
    classes = _float(class_sheet(table), f"tab:bevelmap-{number}-words")
    # Outside of the floats: they are longer than a page may hold beside a table.
    remarks = "\n".join(f"\\par {escape(note)}" for note in notes(table))
    return f"{head}\n{measured}\n{labels}\n{classes}\n{{\\scriptsize\\raggedright\\noindent\n{remarks}\n\\par}}\n"


def _float(sheet: Sheet, label: str) -> str:
    columns = "".join(f"p{{{_SHARED * width:.4f}\\linewidth}}" for width in sheet.widths)
    first = [row[0] for row in sheet.rows]
    body = []
    for number, row in enumerate(sheet.rows):
        if number and sheet.grouped and first[number] != first[number - 1]:
            body.append(r"\addlinespace")
        body.append(_row(row))
    lines = [r"\toprule", *_spanner(sheet), _row(sheet.headings), r"\midrule", *body, r"\bottomrule"]
    return (
        f"\\begin{{table}}[htbp]\n\\caption{{{escape(sheet.caption)}}}\n\\label{{{label}}}\n"
        f"\\scriptsize\\setlength{{\\tabcolsep}}{{0.006\\linewidth}}\\renewcommand{{\\arraystretch}}{{1.2}}\n"
        f"\\begin{{tabular}}{{@{{}}{columns}@{{}}}}\n" + "\n".join(lines) + "\n\\end{tabular}\n\\end{table}\n"
    )


def _row(cells) -> str:
    # \tabularnewline, because \raggedright gives \\ another meaning.
    return " & ".join(f"\\raggedright {escape(cell)}" for cell in cells) + r" \tabularnewline"


def _spanner(sheet: Sheet) -> list[str]:
    """A heading over several columns, with a rule below it."""
    if sheet.spanner is None:
        return []
    text, start, stop = sheet.spanner
    before, after = "& " * start, " &" * (len(sheet.headings) - stop)
    return [
        f"{before}\\multicolumn{{{stop - start}}}{{c}}{{{escape(text)}}}{after} \\tabularnewline",
        f"\\cmidrule(lr){{{start + 1}-{stop}}}",
    ]


def escape(text: str) -> str:
    r"""Plain text as LaTeX.

    Examples
    --------
    >>> escape("f_pm > 50 %, λ_a = −1")
    '$f_{pm}$ $>$ 50~\\%, $\\lambda_a$ = $-$1'
    """
    return _PATTERN.sub(lambda match: _SIGNS[match[0]], text)
