"""How far the map's labels can be trusted, as lines for the console, CSV and Markdown; hysteresis as CSV."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.analysis.attractors.credibility import Credibility
from pipeline.analysis.attractors.queries import grid_indices, hysteresis, hysteresis_intervals
from pipeline.analysis.attractors.wording import percents
from pipeline.config.places import Place
from pipeline.plan.plan import Plan
from pipeline.plane.stored import StoredPlane
from pipeline.run.sheets import csv_text, pipes, sentence, write_files
from solver import domain_label, domain_parts

__all__ = ["Line", "MEANINGS", "label_lines", "map_labels", "result_lines", "several_right", "write_sheets"]

#: What each class means, for the notes below tables.
MEANINGS = {
    Credibility.CONFIRMED: "each motion of the label is an attractor, and no other was found",
    Credibility.MORE_MOTIONS_EXIST: "the label's motions are real, and other attractors coexist with them",
    Credibility.WRONG_IMPACT_STATE: "a motion of the label is real, in another impact state",
    Credibility.WRONG_COUNT: "two motions of the label are one, or it counts none and there is one",
    Credibility.NOT_A_PERIOD_1_MOTION: "a motion of the label is not there: it leads to 2T, a torus, chaos, or grows",
    Credibility.SHIFTED: "both labels are right within the tolerance in place: the boundary lies elsewhere",
    Credibility.UNCHECKED: "a motion did not settle, or the row failed",
}


@dataclass(frozen=True)
class Line:
    """The cells of one label, or of the whole plane.

    Parameters
    ----------
    label : str
        "all" for the whole plane.
    cells : int
    counts : dict
        Credibility -> cells; they add up to all cells.
    """

    label: str
    cells: int
    counts: dict[Credibility, int]


def map_labels(path: Place, plan: Plan, found) -> np.ndarray:
    """Codes of the map's labels in the cells that were integrated, (P, X), or (layers, P, X) of a volume."""
    rows, columns = grid_indices(found, plan)
    return StoredPlane(path, plan).domain[..., rows, :][..., columns]


def label_lines(labels: np.ndarray, judged: np.ndarray) -> list[Line]:
    """One line per label, the largest region first, and one for the whole plane.

    Parameters
    ----------
    labels : int array
        Codes of the map's labels; cells without one are left out.
    judged : int array
        `Credibility` of the same cells.
    """
    codes, sizes = np.unique(labels[labels != 0], return_counts=True)
    order = np.argsort(-sizes, kind="stable")
    lines = [_line(domain_label(int(codes[i])), judged[labels == codes[i]]) for i in order]
    return [*lines, _line("all", judged[labels != 0])]


def _line(label: str, judged: np.ndarray) -> Line:
    return Line(label, judged.size, {kind: int(np.sum(judged == kind)) for kind in MEANINGS})


def several_right(labels: np.ndarray, judged: np.ndarray) -> tuple[int, int]:
    """Of the cells whose label counts several motions: how many are confirmed, and how many there are."""
    several = domain_parts(labels)[0] >= 2
    return int(np.sum(judged[several] == Credibility.CONFIRMED)), int(np.sum(several))


def result_lines(path: Place, plan: Plan, found) -> Iterator[str]:
    """What was found, in a few sentences."""
    labels, judged, count = map_labels(path, plan, found), found.credibility.values, found.n_attractors.values
    right, several = several_right(labels, judged)
    coexist = int(np.sum(count >= 2))
    yield f"several attractors coexist in {coexist:,} of {count.size:,} cells; the map says so of {several:,}"
    if several:
        yield f"of the {several:,} cells whose label counts several motions, {right:,} are right"
    if np.any(labels != 0):
        counts = {kind: number for kind, number in label_lines(labels, judged)[-1].counts.items() if number}
        parts = zip(percents(list(counts.values())), counts, strict=True)
        yield f"labels of the map: {', '.join(f'{share} {kind.words}' for share, kind in parts)}"
        far = int(np.sum((judged == Credibility.CONFIRMED) & (found.deviation.values > found.attrs["tolerance"])))
        yield (
            f"of the confirmed cells, {far:,} have a motion whose mean or amplitude is off by more than "
            f"{found.attrs['tolerance']:g} of gap + static deflection"
        )
    yield found.attrs["bound"]


def write_sheets(path: Place, plan: Plan, found, folder: Path, name: str) -> list[Path]:
    """Write `<name>.csv` and `<name>.md`, and of a plane `<name>-hysteresis.csv`; the same bytes every time."""
    labels = map_labels(path, plan, found)
    lines = label_lines(labels, found.credibility.values)
    contents = {f"{name}.csv": _csv(lines), f"{name}.md": _markdown(path, plan, found, lines, name)}
    if plan.parameter2 is None:
        contents[f"{name}-hysteresis.csv"] = _hysteresis(plan, found)
    return write_files(folder, contents)


def _csv(lines: list[Line]) -> str:
    rows = ([line.label, line.cells, *line.counts.values()] for line in lines)
    return csv_text(["label", "cells", *(kind.name.lower() for kind in MEANINGS)], rows)


def _markdown(path: Place, plan: Plan, found, lines: list[Line], name: str) -> str:
    table = pipes(
        ["Label n/I", "Cells", *(kind.words.capitalize() for kind in MEANINGS)],
        ([line.label, str(line.cells), *percents(list(line.counts.values()))] for line in lines),
        numbers_from=1,
    )
    x, p = (f"{axis.name} = {axis.low:g}–{axis.high:g}" for axis in (plan.sweep, plan.parameter))
    told = found.attrs
    notes = [
        f"Plane: {x}, {p}; {found.n_attractors.size} cells integrated; configuration_hash {plan.fingerprint}; balance "
        f"{plan.solver['balance'].replace('_', ' ')}, order {plan.solver['order']}.",
        *map(sentence, result_lines(path, plan, found)),
        "A label is right if the motions that it counts can be given attractors of their own of that period and impact "
        f"state; it is shifted within {told['delta']:g} of the length of either axis.",
        f"A start took at most {told['max_periods']} forcing periods; seed {told['seed']}.",
        *(f"{kind.words.capitalize()}: {text}." for kind, text in MEANINGS.items()),
    ]
    return "\n\n".join([f"# Attractors of {name}", table, "\n".join(f"- {note}" for note in notes)]) + "\n"


def _hysteresis(plan: Plan, found) -> str:
    x, p = plan.sweep.name, plan.parameter.name
    stretches = [
        [value, low, high, high - low]
        for value, differs in zip(found[p].values.tolist(), hysteresis(found).values, strict=True)
        for low, high in hysteresis_intervals(found[x].values, differs).tolist()
    ]
    return csv_text([p, f"{x}_low", f"{x}_high", "width"], stretches)
