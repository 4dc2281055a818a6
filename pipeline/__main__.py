"""`python -m pipeline`: the command line. Imports are inside the functions because every worker imports this module."""

import signal
import sys

__all__ = ["main"]

_KEPT = "; what is stored is kept, and the same command goes on from there"


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; the exit status."""
    arguments = sys.argv[1:] if arguments is None else arguments
    from pipeline.cli.process import ended_by_signals, unread_output

    with unread_output(), ended_by_signals():
        return _status(arguments)


def _status(arguments: list[str]) -> int:
    """The exit status; whatever ends the run is one line."""
    from pipeline.errors import ConfigurationError
    from pipeline.run.progress import Reporter

    reporter = Reporter()
    try:
        return _run(arguments, reporter)
    except ConfigurationError as error:
        reporter.error(str(error))
        return error.status
    except OSError as error:
        reporter.error(f"{error}{_KEPT}")
        return 1
    except KeyboardInterrupt as error:
        # As a shell has it: 128 and the number of the signal.
        number = getattr(error, "number", signal.SIGINT)
        reporter.error(f"interrupted{f' by {error}' if number != signal.SIGINT else ''}{_KEPT}")
        return 128 + number


def _run(arguments: list[str], reporter) -> int:
    from pipeline.cli.arguments import parse

    asked = parse(arguments)
    if asked.usage:
        from pipeline.cli.help import usage

        print(usage(asked.config_dir), end="")
        return 0
    if asked.complete is not None:
        from pipeline.cli.completion import candidates

        print("\n".join(candidates(asked.complete)))
        return 0
    if asked.shell is not None:
        from pipeline.cli.completion import script

        print(script(asked.shell), end="")
        return 0
    return _run_overrides(asked, reporter)


def _run_overrides(asked, reporter) -> int:
    from pipeline.config.compose import compose, expand
    from pipeline.errors import ConfigurationError

    combinations = expand(asked.overrides)
    if len(combinations) > 1 and not asked.multirun:
        raise ConfigurationError(f"{' '.join(asked.overrides)}: several values need -m")
    all_settings = [compose(combination, asked.config_dir) for combination in combinations]
    if asked.show:
        for settings in all_settings:
            print(settings.yaml(), end="")
        return 0
    return _run_all(all_settings, reporter)


def _run_all(all_settings, reporter) -> int:
    """Prepare and run every plane, also when another one fails; the worst exit status."""
    from pipeline.errors import ConfigurationError
    from pipeline.run.libraries import load_zarr

    load_zarr()
    from pipeline.run.preparation import prepare, run_plane_stages, run_shared_stages
    from pipeline.run.workforce import Workforce

    status, jobs = 0, []
    names = [settings.store_name for settings in all_settings]
    if len(set(names)) < len(names) and any("sweep" in settings.config.stages for settings in all_settings):
        raise ConfigurationError(
            f"store.name = {names[0]!r} is not allowed here: several planes would share that store"
        )
    for settings in all_settings:
        try:
            jobs.append(prepare(settings))
        except ConfigurationError as error:
            reporter.error(str(error))
            status = max(status, error.status)
    if not jobs:
        return status
    with Workforce(jobs[0].settings.config.cluster, reporter.line) as workforce:
        for job in jobs:
            status = max(status, _attempt(run_plane_stages, job, workforce, reporter))
        # Tables need several planes: once, after all of them.
        status = max(status, _attempt(run_shared_stages, jobs[-1], workforce, reporter))
    if len(jobs) < len(all_settings):
        done = ", ".join(job.settings.store_name for job in jobs)
        reporter.line(f"note: {len(jobs)} of {len(all_settings)} planes were run: {done}; the others were refused")
    return status


def _attempt(run, job, workforce, reporter) -> int:
    """Exit status of some stages; whatever ends them is one line, so that the next plane has its turn."""
    from pipeline.errors import ConfigurationError

    try:
        return run(job, workforce, reporter)
    except ConfigurationError as error:
        reporter.error(str(error))
        return error.status
    except Exception as error:  # where a store is damaged, anything may come of it; what is no damage goes on up
        reporter.error(_explained(job, error))
        return 1


def _explained(job, error: Exception) -> str:
    """What to say of an error: damage of a store, if there is any, or what the system said; others are ours."""
    from pipeline import store

    # Stages that need several planes read all stores of the folder.
    for path in [job.store_path, *sorted(set(job.store_path.parent.glob("*.zarr")) - {job.store_path})]:
        if path.exists() and (found := store.damage_error(path)) is not None:
            return str(found)
    if isinstance(error, OSError):
        return f"{error}{_KEPT}"
    raise error


if __name__ == "__main__":
    sys.exit(main())
