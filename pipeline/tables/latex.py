r"""A table as LaTeX: two floats to \input, in plain LaTeX without any package, ASCII only."""

import re

from pipeline.tables.sheets import Sheet, class_sheet, label_sheet, measured_sheet, notes
from pipeline.tables.table import Table

__all__ = ["escape", "latex"]

#: What the texts may hold beyond plain ASCII words, longest first where one begins another.
_SIGNS = {
    "f_pm": r"$f_{pm}$", "λ_a": r"$\lambda_a$", "1/√2": r"$1/\sqrt{2}$", "Ω": r"$\Omega$", "α": r"$\alpha$",
    "±": r"$\pm$", "−": r"$-$", "–": "--", "“": "``", "”": "''", "\\": r"\textbackslash{}", "<": "$<$", ">": "$>$",
    "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", " %": r"~\%", "%": r"\%", "_": r"\_", "&": r"\&",
    "#": r"\#", "$": r"\$", "{": r"\{", "}": r"\}",
}  # fmt: skip
_PATTERN = re.compile("|".join(re.escape(sign) for sign in _SIGNS))

# Room between columns, taken off the width that the columns share.
_SHARED = 0.9


def latex(table: Table) -> str:
    """The table's text."""
    number = table.article.number
    head = f"% bevelmap, from {escape(table.store)}; use with \\input{{table{number}.tex}}"
    measured = _float(measured_sheet(table), f"tab:bevelmap-{number}-measured", "")
    labels = _float(label_sheet(table), f"tab:bevelmap-{number}-labels", "")
    remarks = "\n".join(f"\\par {escape(note)}" for note in notes(table))
    classes = _float(class_sheet(table), f"tab:bevelmap-{number}-words", f"\\medskip\\raggedright\n{remarks}\n")
    return f"{head}\n{measured}\n{labels}\n{classes}"


def _float(sheet: Sheet, label: str, below: str) -> str:
    columns = "".join(f"p{{{_SHARED * width:.4f}\\linewidth}}" for width in sheet.widths)
    # \tabularnewline, because \raggedright gives \\ another meaning.
    lines = [
        " & ".join(f"\\raggedright {escape(cell)}" for cell in row) + r" \tabularnewline"
        for row in (sheet.headings, *sheet.rows)
    ]
    lines.insert(1, r"\hline")
    body = "\n".join(lines)
    return (
        f"\\begin{{table}}[htbp]\n\\caption{{{escape(sheet.caption)}}}\n\\label{{{label}}}\n"
        f"\\scriptsize\\setlength{{\\tabcolsep}}{{0.006\\linewidth}}\\renewcommand{{\\arraystretch}}{{1.2}}\n"
        f"\\begin{{tabular}}{{{columns}}}\n\\hline\n{body}\n\\hline\n\\end{{tabular}}\n{below}\\end{{table}}\n"
    )


def escape(text: str) -> str:
    r"""Plain text as LaTeX.

    Examples
    --------
    >>> escape("f_pm > 50 %, λ_a = −1")
    '$f_{pm}$ $>$ 50~\\%, $\\lambda_a$ = $-$1'
    """
    return _PATTERN.sub(lambda match: _SIGNS[match[0]], text)
