"""A small parser of the tables' LaTeX, for machines without a compiler."""

import re

__all__ = ["check_latex"]


def cells_of(row):
    """Number of columns that a row of a tabular fills."""
    spans = [int(n) for n in re.findall(r"\\multicolumn\{(\d+)\}", row)]
    return len(re.findall(r"(?<!\\)&", row)) + 1 + sum(spans) - len(spans)


def check_latex(text):
    """Environments closed in order, every row of a tabular as wide as its columns, rules by booktabs; the tabulars."""
    stack = []
    for kind, name in re.findall(r"\\(begin|end)\{(\w+)\}", text):
        if kind == "begin":
            stack.append(name)
        else:
            assert stack and stack.pop() == name
    assert not stack and text.count("{") == text.count("}")
    tabulars = re.findall(r"\\begin\{tabular\}\{@\{\}(.*?)@\{\}\}\n(.*?)\\end\{tabular\}", text, flags=re.S)
    for columns, body in tabulars:
        lines = body.strip().splitlines()
        assert lines[0] == r"\toprule" and lines[-1] == r"\bottomrule" and lines.count(r"\midrule") == 1
        rules = (r"\toprule", r"\midrule", r"\bottomrule", r"\addlinespace", r"\cmidrule")
        rows = [line for line in lines if not line.startswith(rules)]
        assert all(row.endswith(r"\tabularnewline") for row in rows)
        assert {cells_of(row) for row in rows} == {columns.count("p{")}
        for first, last in re.findall(r"\\cmidrule\(lr\)\{(\d+)-(\d+)\}", body):
            assert 1 <= int(first) < int(last) <= columns.count("p{")
    return len(tabulars)
