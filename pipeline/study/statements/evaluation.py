"""Ours against the published number: difference and verdict."""

from collections.abc import Mapping
from dataclasses import dataclass

from pipeline.config.places import Place
from pipeline.errors import StoreError
from pipeline.study.agreement import AGREES, DIFFERS, NOT_COMPARED, THRESHOLD_AGREES
from pipeline.study.numerals import signed
from pipeline.study.statements.planes import Planes
from pipeline.study.statements.published import STATEMENTS
from pipeline.study.statements.statement import Statement
from solver.model.checks import instance_of

__all__ = ["Evaluated", "evaluate", "evaluate_all"]


@dataclass(frozen=True)
class Evaluated:
    """One statement with our numbers.

    Parameters
    ----------
    statement : Statement
    ours, article : tuple of float
        Side by side: the article's single value is repeated for each of ours. `ours` is empty where nothing could be
        computed.
    difference : tuple of float
        Ours minus the article's; empty where their numbers do not match.
    verdict : str
        "agrees", "differs" or "cannot be compared".
    reason : str
        What is behind it, in one line.
    """

    statement: Statement
    ours: tuple[float, ...]
    article: tuple[float, ...]
    difference: tuple[float, ...]
    verdict: str
    reason: str


def evaluate(statement: Statement, planes: Planes | Mapping[str, Place]) -> Evaluated:
    """Compute a statement's numbers from stored planes and compare them.

    Parameters
    ----------
    statement : Statement
    planes : Planes or mapping of str to Place
        Stores by plane; one `Planes` for many statements divides each plane only once.

    Returns
    -------
    Evaluated
        With the verdict "cannot be compared" and the reason where the numbers cannot be computed.

    Raises
    ------
    solver.ParameterError
        If there is no statement, or the planes are no mapping of names to paths.
    """
    instance_of("statement", statement, Statement)
    planes = planes if isinstance(planes, Planes) else Planes(planes)
    try:
        ours = statement.quantity.values(planes)
    except StoreError as error:
        return Evaluated(statement, (), statement.article, (), NOT_COMPARED, str(error))
    article = statement.article * len(ours) if len(statement.article) == 1 else statement.article
    if len(ours) != len(article):
        reason = f"{len(ours)} numbers of ours against {len(article)} published ones"
        return Evaluated(statement, ours, article, (), DIFFERS, reason)
    tolerance = statement.tolerance * len(ours) if len(statement.tolerance) == 1 else statement.tolerance
    difference = tuple(a - b for a, b in zip(ours, article, strict=True))
    agrees = all(abs(gap) <= allowed for gap, allowed in zip(difference, tolerance, strict=True))
    verdict = AGREES if agrees else DIFFERS
    return Evaluated(statement, ours, article, difference, verdict, _reason(statement, difference, agrees))


def evaluate_all(planes: Mapping[str, Place]) -> tuple[Evaluated, ...]:
    """Every statement, in order.

    Raises
    ------
    solver.ParameterError
        If it is no mapping of names to paths.
    """
    shared = Planes(planes)
    return tuple(evaluate(statement, shared) for statement in STATEMENTS)


def _reason(statement: Statement, difference: tuple[float, ...], agrees: bool) -> str:
    """The criterion, and by how much."""
    if not difference:
        return "none, as published"
    tolerance = statement.tolerance * len(difference) if len(statement.tolerance) == 1 else statement.tolerance
    if statement.source == "reference":
        gaps = f"{max(map(abs, difference)):.0e} at most"
    elif all(tolerance):
        # Of what the criterion is a share of.
        shares = (THRESHOLD_AGREES * gap / allowed for gap, allowed in zip(difference, tolerance, strict=True))
        gaps = ", ".join(f"{signed(100.0 * share)} %" for share in shares)
    else:
        return "equal" if agrees else "not equal"
    return f"{'within' if agrees else 'by more than'} {statement.agreement} ({gaps})"
