"""The stage boundaries of a volume: layer by layer, each a task."""

from collections import Counter
from time import perf_counter

from pipeline.analysis.boundaries.events import read_events
from pipeline.analysis.boundaries.group import write_boundaries
from pipeline.analysis.boundaries.sheets import write_sheets
from pipeline.analysis.boundaries.tracing import layer_boundaries, summary_of
from pipeline.errors import StoreError, counted
from pipeline.plan.layers import layer_name
from pipeline.plane.boundaries import StoredBoundaries, read_boundaries
from pipeline.run.job import Job, say_failures
from pipeline.run.made import made_from, still_made, write_record
from pipeline.run.progress import Reporter, RowProgress
from pipeline.run.warmup import warm_up_for
from pipeline.run.workforce import Workforce

__all__ = ["run_layers", "write_layer_sheets"]


def run_layers(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    """Trace what is not stored yet, write it with every layer that is done, and say what there is; an exit status.

    Raises
    ------
    OSError, StoreError
        If the scheduler goes away, or the store cannot be read or written.
    """
    path, plan, begin = job.store_path, job.plan, perf_counter()
    layers = [read_boundaries(path, plan, layer) for layer in range(plan.parameter2.num)]
    due = [
        layer
        for layer, stored in enumerate(layers)
        if stored is None or stored.digest != read_events(path, plan, layer).digest
    ]
    failures = _trace(job, layers, due, workforce, reporter) if due else []
    summaries = [
        summary_of(plan.layer(number), one, number not in due) for number, one in enumerate(layers) if one is not None
    ]
    failures += [text for summary in summaries for text in summary.cut_short]
    say_failures(failures, reporter)
    counts: Counter[str] = Counter()
    for summary in summaries:
        counts.update(summary.curves)
    told = ", ".join(f"{counted(n, f'{kind} curve')}" for kind, n in counts.items()) or "no boundaries"
    took = f"into {path} ({perf_counter() - begin:.2f} s)" if due else f"are in {path} already, nothing to do"
    reporter.line(f"boundaries: {told} in {len(summaries)} of {len(layers)} layers {took}")
    return 1 if failures else 0


def _trace(
    job: Job, layers: list[StoredBoundaries | None], due: list[int], workforce: Workforce, reporter: Reporter
) -> list[str]:
    """Trace some layers into `layers`; why others could not be."""
    warm_up_for(job, reporter, workforce)
    path, plan, failures = job.store_path, job.plan, []
    for layer in due:
        layers[layer] = None
    reporter.line(f"boundaries: {counted(len(due), 'layer')}; {workforce.start()}")
    with RowProgress(reporter, len(due), what="boundaries", unit="layers") as bar:
        for (_, _, layer), result in workforce.run(layer_boundaries, [(path, plan, layer) for layer in due]):
            if isinstance(result, OSError | StoreError):
                raise result
            if isinstance(result, Exception):
                value = f"{plan.parameter2.name} = {plan.parameter2.values[layer]:.6g}"
                failures.append(f"boundaries at {value} cannot be traced: {' '.join(str(result).split())}")
            else:
                layers[layer] = result
                write_boundaries(path, plan, layers)
            bar.advance(1, int(isinstance(result, Exception)))
    return failures


def write_layer_sheets(job: Job, reporter: Reporter) -> None:
    """Write CSV files of every layer, unless they are up to date."""
    folder, name = job.settings.output_root / "boundaries", job.settings.store_name
    record, origin = folder / f".{name}.json", made_from(job.store_path)
    if (names := still_made(record, origin)) is None:
        plan, names = job.plan, []
        for number in range(plan.parameter2.num):
            if (boundaries := read_boundaries(job.store_path, plan, number)) is not None:
                names += write_sheets(boundaries, plan.layer(number), folder, layer_name(name, plan, number))
        write_record(record, origin, names)
    reporter.line(f"boundaries: {counted(len(names), 'file')} in {folder.resolve()}")
