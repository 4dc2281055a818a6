"""Verifying a stored plane: sample, integrate, sweep again at higher orders, judge, store."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.analysis.verification.credibility import Credibility, Samples, credibility
from pipeline.analysis.verification.group import (
    StoredVerification,
    digest_of,
    read_verification,
    sample_arrays,
    write_verification,
)
from pipeline.analysis.verification.sampling import choose_cells
from pipeline.analysis.verification.starts import Start, read_starts
from pipeline.analysis.verification.tasks import check_rows, follow_starts
from pipeline.analysis.verification.verdicts import Seen, Verdict
from pipeline.config.schema import HIGHEST_ORDER, Verify
from pipeline.plan.plan import Plan
from pipeline.plane.stored import StoredPlane

__all__ = ["Summary", "orders_of", "tasks_of", "verify"]

#: Motions of a task: few enough that chaotic ones, which take longest, spread over the workers.
_BATCH = 6


@dataclass(frozen=True)
class Summary:
    """What came of a verification.

    Parameters
    ----------
    verdicts : dict
        Verdict -> number of integrations.
    shares : dict
        Credibility -> share of the computed cells.
    failures : tuple of str
        What could not be done, one line each.
    found_done : bool
        Whether it was in the store already.
    """

    verdicts: dict[Verdict, int]
    shares: dict[Credibility, float]
    failures: tuple[str, ...]
    found_done: bool


def orders_of(plan: Plan, order: int) -> tuple[int, ...]:
    """The two orders at which rows are swept again: H and 2 H, or 2 and 4 times the map's own order if that is more.

    The balance ends at order 64. A map of order above 32 would be compared with itself at best, so that there is none.

    Examples
    --------
    >>> from pipeline.config.compose import compose
    >>> from pipeline.plan.planning import plan
    >>> orders_of(plan(compose([])), 5), orders_of(plan(compose(["solver=hb", "solver.order=20"])), 5)
    ((5, 10), (32, 64))
    """
    own = int(plan.solver["order"]) if plan.solver["balance"] == "galerkin" else 0
    if own >= HIGHEST_ORDER:
        return ()
    lower = min(max(order, 2 * own), HIGHEST_ORDER)
    return lower, 2 * lower


def verify(path: Path, plan: Plan, settings: Verify, run: Callable, advance: Callable[[int, int], None]) -> Summary:
    """Verify a stored plane into its group `verification`, unless that is there already.

    Parameters
    ----------
    path : Path
        The store; its complete rows count.
    plan : Plan
        The store's own.
    settings : Verify
    run : callable
        As `pipeline.run.workforce.Workforce.run`.
    advance : callable
        Told after every task how many motions and rows it did, and how many of them failed.

    Returns
    -------
    Summary
    """
    plane = StoredPlane(path, plan)
    domain = plane.domain
    made_from = digest_of(plan, domain, settings)
    stored = read_verification(path)
    if stored is not None and stored.made_from == made_from:
        return _summary(plan, domain, stored, True)
    cells = choose_cells(domain, plane.usable, settings.samples, settings.beside, settings.seed)
    starts = read_starts(path, plan, cells.row, cells.column)
    seen = _follow(plan, starts, settings, run, advance)
    layers, messages, orders = _check(path, plan, settings, domain.shape, run, advance)
    cell_of = cells.row * domain.shape[1] + cells.column
    place = np.searchsorted(cell_of, [start.row * domain.shape[1] + start.column for start in starts])
    samples = sample_arrays(starts, seen, cells.stratified[place], cells.beside[place])
    evidence = Samples(*(samples[name] for name in ("row", "column", "verdict", "impact")))
    layers["credibility"] = credibility(
        domain, layers["domain_low"], layers["domain_high"], layers["unstable"], evidence, settings.delta
    )
    found = StoredVerification(samples, layers, messages, orders, made_from)
    write_verification(path, plan, found, settings)
    return _summary(plan, domain, found, False)


def tasks_of(path: Path, plan: Plan, settings: Verify) -> int:
    """How many motions and rows there are to do; for a progress bar."""
    plane = StoredPlane(path, plan)
    cells = choose_cells(plane.domain, plane.usable, settings.samples, settings.beside, settings.seed)
    rows = plan.parameter.num if orders_of(plan, settings.order) else 0
    return len(read_starts(path, plan, cells.row, cells.column)) + rows


def _follow(plan: Plan, starts: list[Start], settings: Verify, run, advance) -> list[Seen]:
    # Neighbours on the map take equally long: dealt like cards they spread over the tasks.
    count = -(-len(starts) // _BATCH)
    batches = [tuple(starts[first::count]) for first in range(count)]
    tasks = [(plan, batch, settings.max_periods, settings.tolerance) for batch in batches]
    seen: dict[Start, Seen] = {}
    for (_, batch, _, _), result in run(follow_starts, tasks):
        if isinstance(result, BaseException):
            result = [Seen(Verdict.FAILED, message=_lost(result))] * len(batch)
        seen.update(zip(batch, result, strict=True))
        advance(len(batch), sum(one.verdict is Verdict.FAILED for one in result))
    return [seen[start] for start in starts]


def _check(path: Path, plan: Plan, settings: Verify, shape, run, advance):
    layers = {name: np.zeros(shape, np.uint16) for name in ("domain_low", "domain_high")}
    layers["unstable"] = np.full(shape, -1, np.int8)
    messages = np.full(shape[0], "", dtype=object)
    orders = orders_of(plan, settings.order)
    tasks = [(str(path), plan, orders, settings.columns, block) for block in plan.blocks] if orders else []
    for (*_, block), result in run(check_rows, tasks):
        here = slice(block.start, block.stop)
        if isinstance(result, BaseException):
            messages[here] = _lost(result)
        else:
            messages[here] = result.messages
            for name, rows in (("domain_low", result.low), ("domain_high", result.high), ("unstable", result.unstable)):
                layers[name][here] = rows
        advance(block.stop - block.start, int(np.sum(messages[here] != "")))
    return layers, messages, orders


def _lost(error: BaseException) -> str:
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


def _summary(plan: Plan, domain: np.ndarray, found: StoredVerification, found_done: bool) -> Summary:
    verdicts = Counter(found.samples["verdict"].tolist())
    judged = found.layers["credibility"][domain != 0]
    failures = [
        f"row {row} ({plan.parameter.name} = {plan.parameter.values[row]:.6g}) could not be swept again: {text}"
        for row, text in enumerate(found.row_messages)
        if text
    ]
    failed = np.flatnonzero(found.samples["verdict"] == Verdict.FAILED)
    failures += [_failed(plan, found.samples, int(i)) for i in failed]
    return Summary(
        {kind: verdicts.get(int(kind), 0) for kind in Verdict},
        {kind: float(np.mean(judged == kind)) if judged.size else 0.0 for kind in Credibility},
        tuple(failures),
        found_done,
    )


def _failed(plan: Plan, samples: dict[str, np.ndarray], i: int) -> str:
    x, p = plan.sweep, plan.parameter
    place = f"{x.name} = {x.values[samples['column'][i]]:.6g}, {p.name} = {p.values[samples['row'][i]]:.6g}"
    return f"solution {samples['solution'][i]} at {place} could not be integrated: {samples['message'][i]}"
