"""Tables 1 to 3 of the study, made from stored planes."""

from pathlib import Path

from pipeline.config.places import Place
from pipeline.errors import StoreError
from pipeline.plane.stored import read_stored
from pipeline.run.sheets import write_files
from pipeline.store import PENDING
from pipeline.study.tables.article import ARTICLE_TABLES, ArticleTable
from pipeline.study.tables.latex import latex
from pipeline.study.tables.markdown import markdown
from pipeline.study.tables.table import build_table
from pipeline.study.tables.tidy import cells, tidy

__all__ = ["write"]

_FORMATS = {".csv": cells, "-measured.csv": tidy, ".md": markdown, ".tex": latex}


def write(stores: dict[str, tuple[Place, str]], folder: Path) -> list[Path]:
    """Write the study's tables 1 to 3 as measured in stored planes, each as Markdown, LaTeX and CSV.

    Parameters
    ----------
    stores : dict
        For each of "omega_b", "omega_alpha" and "omega_fpm" the store and the command that makes it.
    folder : Path
        Made if it does not exist.

    Returns
    -------
    list of Path
        table1.csv, table1-measured.csv, table1.md, table1.tex, table2.csv, ...

    Raises
    ------
    StoreError
        If a plane is missing, incomplete or another one: in one line, naming every such plane with its command.
        Nothing is written then.
    """
    problems = [text for article in ARTICLE_TABLES if (text := _problem(article, *stores[article.plane]))]
    if problems:
        raise StoreError(f"the tables need other planes than are there: {'; '.join(problems)}")
    texts = {}
    for article in ARTICLE_TABLES:
        table = build_table(article, stores[article.plane][0])
        for suffix, render in _FORMATS.items():
            texts[f"table{article.number}{suffix}"] = render(table)
    return write_files(folder, texts)


def _problem(article: ArticleTable, path: Place, command: str) -> str:
    """What keeps a table from being made of a store, with the command that helps; empty if nothing does."""
    try:
        plane = read_stored(path)
    except StoreError as error:
        return f"{article.plane}: {error} (run: {command})"
    plan = plane.plan
    axes = tuple(axis.name for axis in plan.axes)
    if axes != ("omega", article.parameter):
        other = " x ".join(axes)
        return f"{article.plane}: {path} is a plane {other}, not omega x {article.parameter} (run: {command})"
    if not plan.is_first_order:
        return f"{article.plane}: {path} is not balanced at first order, as the tables are (run: {command})"
    pending = int((plane.status == PENDING).sum())
    if pending:
        rows = plan.parameter.num
        return f"{article.plane}: {pending} of {rows} rows of {path} are not computed yet (run: {command})"
    return ""
