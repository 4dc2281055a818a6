"""The stage spectrum: amplitudes along a row that is followed up or down, as a figure and as a table."""

from time import perf_counter

from pipeline.analysis.diagram.options import spectrum_of
from pipeline.figures import stage as figures_stage
from pipeline.run.job import Job
from pipeline.run.progress import Reporter
from pipeline.run.sheets import write_files
from pipeline.run.stage import Stage
from pipeline.run.warmup import warm_up_for
from pipeline.run.workforce import Workforce

__all__ = ["STAGE"]


def _check(job: Job) -> None:
    spectrum_of(job.settings.config.spectrum, job.plan)
    # Its figure is drawn as the others are.
    figures_stage.STAGE.check(job)


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline import figures
    from pipeline.analysis.diagram.following import follow
    from pipeline.analysis.diagram.sheets import row_name, spectrum_lines, spectrum_sheets
    from pipeline.analysis.diagram.spectra import spectra_of
    from pipeline.figures.spectrum import draw_spectrum

    settings, begin = job.settings, perf_counter()
    options, drawing = spectrum_of(settings.config.spectrum, job.plan), settings.config.figures
    warm_up_for(job, reporter)
    spectra = spectra_of(follow(job.plan, options.way), options)
    for text in spectrum_lines(spectra):
        reporter.line(f"spectrum: {text}")
    folder = settings.output_root / "spectrum" / settings.store_name
    name = row_name(job.plan, options.way, options.of, options.direction)
    paths = write_files(folder, spectrum_sheets(spectra, name))
    paths += figures.draw_one(job.store_path, folder, name, lambda plane: draw_spectrum(plane, spectra), drawing)
    took = f"{perf_counter() - begin:.2f} s"
    reporter.line(f"spectrum: {', '.join(path.name for path in paths)} in {folder.resolve()} ({took})")
    return 0


STAGE = Stage("spectrum", _run, _check)
