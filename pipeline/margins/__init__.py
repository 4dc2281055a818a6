"""The stage `margins`: what a stored plane says of a design point with its operating range and tolerances."""

from pathlib import Path
from time import perf_counter

import numpy as np

from pipeline.margins.answer import Answer, answer
from pipeline.margins.options import Design, design_of
from pipeline.margins.sheets import lines, markdown, tidy

__all__ = ["Answer", "Design", "answer", "design_of", "run", "write_sheets"]


def run(job, reporter) -> int:
    """Answer, print and write what was asked of the job's plane; the exit status.

    Parameters
    ----------
    job : pipeline.stages.Job
    reporter : Reporter
    """
    from pipeline import figures

    settings, path = job.settings, job.store_path
    name, options = settings.store_name, settings.config.figures
    begin = perf_counter()
    design = design_of(settings.config.margins, job.plan)
    try:
        found = answer(path, job.plan, design)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError) as error:
        reporter.error(f"margins in {path} cannot be told: {' '.join(str(error).split())}")
        return 1
    for text in lines(found):
        reporter.line(text)
    folder = settings.output_root / "margins"
    sheets = write_sheets(found, folder, name)
    drawn = settings.output_root / "figures" / name
    paths = figures.draw_design(path, drawn, found, options.formats, options.dpi, options.units)
    for there, files in ((folder, sheets), (drawn, paths)):
        reporter.line(f"margins: {', '.join(file.name for file in files)} in {there.resolve()}")
    reporter.line(
        f"margins: {len(found.margins)} distances, {len(found.corners)} sets of tolerances "
        f"({perf_counter() - begin:.2f} s)"
    )
    return 0


def write_sheets(found: Answer, folder: Path, name: str) -> list[Path]:
    """Write `<name>.md` and `<name>.csv`; the same bytes from the same store."""
    folder.mkdir(parents=True, exist_ok=True)
    texts = {folder / f"{name}.md": markdown(found, name), folder / f"{name}.csv": tidy(found)}
    for path, text in texts.items():
        draft = path.with_name(f".{path.name}.draft")
        draft.write_text(text, encoding="utf-8", newline="\n")
        draft.replace(path)
    return list(texts)
