"""The stage verify: where the map can be trusted, by higher orders and by direct integration."""

from time import perf_counter

from pipeline.run.job import Job, note_unfinished, say_failures
from pipeline.run.progress import Reporter, RowProgress
from pipeline.run.stage import Stage
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.analysis import verification
    from pipeline.plane.stored import StoredPlane

    path, options = job.store_path, job.settings.config.verify
    note_unfinished(job, reporter, "they are not verified")
    begin = perf_counter()
    total = verification.tasks_of(path, job.plan, options)
    with RowProgress(reporter, total, what="verify", unit="motions and rows") as bar:
        summary = verification.verify(path, job.plan, options, workforce.run, bar.advance)
    folder = job.settings.output_root / "verification"
    domain, stored = StoredPlane(path, job.plan).domain, verification.read_verification(path)
    names = verification.write_sheets(domain, stored, job.plan, options, folder, job.settings.store_name)
    say_failures(summary.failures, reporter)
    whole = verification.region_lines(domain, stored)[-1]
    reporter.line(f"verify: {', '.join(f'{n} {kind.name.lower()}' for kind, n in summary.verdicts.items() if n)}")
    right = f"{whole.share:.1%} ({whole.low:.1%} to {whole.high:.1%}) right by integration; " if whole.samples else ""
    shares = ", ".join(f"{share:.1%} {kind.words}" for kind, share in summary.shares.items() if share)
    seconds = perf_counter() - begin
    done = f"are in {path} already, nothing to do" if summary.found_done else f"into {path} ({seconds:.2f} s)"
    reporter.line(f"verify: of the cells {right}{shares}; {done}")
    reporter.line(f"verify: {', '.join(name.name for name in names)} in {folder.resolve()}")
    return 1 if summary.failures else 0


STAGE = Stage("verify", _run, on_workers=True, writes=True)
