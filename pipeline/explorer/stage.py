"""The stage explore: the stored plane as a page in a browser, until Ctrl-C."""

import contextlib
import importlib.util
import signal
import threading

from pipeline.errors import ConfigurationError
from pipeline.run.job import Job, command
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage
from pipeline.run.warmup import warm_up_for
from pipeline.run.workforce import Workforce

__all__ = ["STAGE", "check_installed"]


def check_installed() -> None:
    """Raise ConfigurationError, which says what to install, unless the page can be made."""
    missing = [name for name in ("panel", "bokeh") if importlib.util.find_spec(name) is None]
    if missing:
        raise ConfigurationError(
            f"the explorer needs {' and '.join(missing)}, not installed here: pip install 'bevelmap[explore]'"
        )


def _check(job: Job) -> None:
    check_installed()
    if job.settings.config.explore.view:
        from pipeline.explorer.opened import Opened
        from pipeline.explorer.view_state import state_of

        state_of(job.settings.config.explore.view, Opened(job.store_path).content().allowed)


def _run(job: Job, workforce: Workforce, reporter: Reporter) -> int:
    from pipeline.explorer import answers
    from pipeline.explorer.app import page_of
    from pipeline.explorer.opened import Opened
    from pipeline.explorer.server import ADDRESS, make_server, run_server
    from pipeline.explorer.site import Site

    config = job.settings.config.explore
    opened = Opened(job.store_path, command(job.settings, "explore.port=", "explore.view="))
    site = Site(opened)
    server = make_server(lambda: page_of(site), config.port, job.settings.store_name)
    query = f"?{config.view.removeprefix('?')}" if config.view else ""

    def load() -> None:
        # A page shows cells at first: its clicks can be answered before its map is divided.
        warm_up_for(job, reporter)
        answers.ready(job.plan)
        opened.ready.set()
        with contextlib.suppress(Exception):
            opened.content().layer("domains", physical=False)

    try:
        reporter.line(f"explore: http://{ADDRESS}:{server.port}/{query} shows {job.store_path}; Ctrl-C ends it")
        threading.Thread(target=load, name="kernels", daemon=True).start()
        run_server(server)
    except KeyboardInterrupt as error:
        # Other signals interrupt it.
        if getattr(error, "number", signal.SIGINT) != signal.SIGINT:
            raise
        reporter.line("explore: ended")
    finally:
        site.run.end()
    return 0


def _reads(job: Job) -> bool:
    return True


STAGE = Stage("explore", _run, _check, only_reads=_reads)
