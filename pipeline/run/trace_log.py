"""The log of one row: its continuation step by step, as text to read and as CSV to plot."""

from dataclasses import dataclass
from pathlib import Path

from pipeline import store
from pipeline.plan.numerics import balance_of, continuation_of, row_of, seeds_of
from pipeline.plan.plan import Plan
from pipeline.run.sheets import csv_text, write_files
from solver import EndReason, Event, Row, RowError
from solver.continuation.trace_log import LoggedContinuation, Outcome, Trace

__all__ = ["RowTrace", "row_trace", "write_sheets"]

_COLUMNS = ("trace", "step", "outcome", "length", "iterations", "stray", "angle", "points", "events")


@dataclass(frozen=True)
class RowTrace:
    """What happened in one row.

    Parameters
    ----------
    plan : Plan
    index : int
    stored : str
        State of this row in the store, in words.
    traces : tuple of Trace
        In the order in which they were made.
    result : Row or str
        The row; or why it failed.
    """

    plan: Plan
    index: int
    stored: str
    traces: tuple[Trace, ...]
    result: Row | str

    @property
    def value(self) -> float:
        """Of the row parameter."""
        return self.plan.row(self.index)[1]

    @property
    def steps(self) -> int:
        """Steps tried in all traces."""
        return sum(trace.steps.outcome.size for trace in self.traces)

    @property
    def failed(self) -> tuple[str, ...]:
        """Why the row failed, if it did."""
        return (self.result,) if isinstance(self.result, str) else ()


def row_trace(path: Path, plan: Plan, index: int) -> RowTrace:
    """Compute one row again, in this process, and keep a log of it; nothing is written.

    Parameters
    ----------
    path : Path
        The store, if there is one: it says what is known of the row.
    plan : Plan
    index : int
        The row's number.
    """
    stored = "there is no store yet"
    if store.exists(path):
        words = {store.PENDING: "pending", store.COMPLETE: "complete", store.FAILED: "failed"}
        stored = f"{words[int(store.statuses(path).ravel()[index])]} in the store"
        stored += "".join(f": {text}" for row, text in store.failures(path) if row == index)
    recording = LoggedContinuation(**vars(continuation_of(plan.solver)))
    plane, value = plan.row(index)
    try:
        result = row_of(plane, value, balance_of(plan.solver), recording, seeds_of(plan.solver))
    except RowError as error:
        result = str(error)
    except Exception as error:
        # Whatever it is, the log up to there is what was asked for.
        result = f"{type(error).__name__}: {error}"
    return RowTrace(plan, index, stored, tuple(recording.traces), result)


def write_sheets(row: RowTrace, folder: Path) -> list[Path]:
    """Write `row-<n>.txt` and `row-<n>.csv`; the same bytes from the same row."""
    return write_files(folder, {f"row-{row.index}.txt": _text(row), f"row-{row.index}.csv": _csv(row)})


def _unknowns(trace: Trace) -> list[str]:
    """Names of the unknowns."""
    first = ["mean", "cos", "sin"]
    return (
        first
        if trace.problem.unknowns == 3
        else ["mean", *(f"{part}{k}" for k in range(1, (trace.problem.unknowns + 1) // 2) for part in ("cos", "sin"))]
    )


def _events(trace: Trace) -> list[str]:
    """What was located on every step: kinds and places."""
    curve, before, found = trace.curve, 1, []
    for accepted, after in zip(trace.steps.accepted, trace.steps.points, strict=True):
        here = range(before, after) if accepted else ()
        found.append(
            " ".join(
                f"{Event(int(curve.event[i])).name.lower()}@{curve.points[i, -1]:.10g}"
                for i in here
                if curve.event[i] != Event.NONE
            )
        )
        before = after
    return found


def _csv(row: RowTrace) -> str:
    """One line a step."""
    names, lines = _unknowns(row.traces[0]) if row.traces else [], []
    for number, trace in enumerate(row.traces):
        steps, events = trace.steps, _events(trace)
        for k in range(steps.outcome.size):
            lines.append(
                [
                    number,
                    k,
                    Outcome(int(steps.outcome[k])).name.lower(),
                    repr(float(steps.length[k])),
                    int(steps.iterations[k]),
                    repr(float(steps.stray[k])),
                    repr(float(steps.turn[k])),
                    int(steps.points[k]),
                    events[k],
                    *(repr(float(value)) for value in (steps.places[k, -1], *steps.places[k, :-1])),
                ]
            )
    return csv_text([*_COLUMNS, "parameter", *names], lines)


def _text(row: RowTrace) -> str:
    """For a reader."""
    plan, axis = row.plan, row.plan.sweep
    lines = [
        f"{plan.row_text(row.index)}: {axis.name} from {axis.low:g} to {axis.high:g}; {row.stored}",
        f"balance {plan.solver['balance']}, order {plan.solver['order']}, corrector {plan.solver['corrector']}; "
        f"seeds: certify={plan.solver['certify']}",
    ]
    for number, trace in enumerate(row.traces):
        lines += ["", *_trace_lines(number, trace)]
    lines += ["", *_outcome_lines(row)]
    return "\n".join(lines) + "\n"


def _trace_lines(number: int, trace: Trace) -> list[str]:
    curve, steps, names = trace.curve, trace.steps, _unknowns(trace)
    width = min(len(names), 3)
    start = ", ".join(f"{name} = {value:.10g}" for name, value in zip(names, trace.start, strict=False))
    towards = "" if trace.heading.ndim else ", towards " + ("larger values" if trace.heading > 0 else "smaller values")
    lines = [f"trace {number}: seed at parameter = {trace.start[-1]:.12g}{towards}; {start}"]
    if steps.outcome.size:
        lines.append(
            f"{'step':>5} {'length':>10} {'iter':>4} {'angle':>9} {'parameter':>14}"
            + "".join(f" {name:>13}" for name in names[:width])
            + "  what"
        )
    for k, events in enumerate(_events(trace)):
        outcome = Outcome(int(steps.outcome[k]))
        what = events if steps.accepted[k] else f"refused: {outcome.sentence}"
        place = "".join(f" {value:13.8g}" for value in steps.places[k, :width])
        lines.append(
            f"{k:5d} {steps.length[k]:10.3e} {steps.iterations[k]:4d} {steps.turn[k]:9.2e} "
            f"{steps.places[k, -1]:14.9g}{place}  {what}".rstrip()
        )
    if not len(curve.points):
        return [*lines, f"  nothing was traced: {curve.ends[1].sentence}"]
    end = curve.ends[1]
    return [
        *lines,
        f"  {len(curve.points)} points, {curve.refused} steps refused; ends at parameter = "
        f"{curve.points[-1, -1]:.12g}: {end.sentence}",
    ]


def _outcome_lines(row: RowTrace) -> list[str]:
    if isinstance(row.result, str):
        return [f"the row fails: {row.result}"]
    lines = []
    for number, curve in enumerate(row.result.curves):
        events = [Event(int(kind)).name.lower() for kind in curve.event if kind != Event.NONE]
        ends = " / ".join(EndReason(end).name.lower() for end in curve.ends)
        lines.append(f"branch {number}: {len(curve.points)} points, ends {ends}; {', '.join(events) or 'no events'}")
    return [*lines, *row.result.notes]
