"""`python -m pipeline`: the command line. Imports are inside the functions because every worker imports this module."""

import atexit
import contextlib
import os
import signal
import sys

__all__ = ["main"]


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; the exit status."""
    arguments = sys.argv[1:] if arguments is None else arguments
    from pipeline.cli.process import ended_by_signals, unread_output
    from pipeline.run.libraries import drawing_into_files
    from pipeline.run.progress import Reporter

    with unread_output(), drawing_into_files():
        reporter = Reporter()
        with ended_by_signals(lambda number: _end_abruptly(number, reporter)):
            return _status(arguments, reporter)


def _status(arguments: list[str], reporter) -> int:
    """The exit status; whatever ends the run is one line."""
    from pipeline.errors import KEPT, ConfigurationError

    try:
        return _run(arguments, reporter)
    except ConfigurationError as error:
        reporter.error(str(error))
        return error.status
    except OSError as error:
        reporter.error(f"{error}{KEPT}")
        return 1
    except Exception as error:
        from pipeline.run.libraries import failed_import

        if (said := failed_import(error)) is None:
            raise
        reporter.error(str(said))
        return said.status
    except KeyboardInterrupt as error:
        # As a shell has it: 128 and the number of the signal.
        number = getattr(error, "number", signal.SIGINT)
        reporter.error(_interrupted(number))
        return 128 + number


def _interrupted(number: int) -> str:
    from pipeline.errors import KEPT

    return f"interrupted{f' by {signal.Signals(number).name}' if number != signal.SIGINT else ''}{KEPT}"


def _end_abruptly(number: int, reporter) -> None:
    """What an interrupted run owes to others, where its own code has no turn any more."""
    import multiprocessing

    from pipeline.store.lock import let_go

    for worker in multiprocessing.active_children():
        worker.kill()
    if (jobs := sys.modules.get("pipeline.run.slurm_jobs")) is not None:
        jobs.give_back()
    let_go()
    reporter.error(_interrupted(number))


def _run(arguments: list[str], reporter) -> int:
    from pipeline.cli.arguments import parse
    from pipeline.config.folders import quoted_home

    asked = parse([quoted_home(argument) for argument in arguments])
    text = _answer(asked)
    if asked.warmup:
        from pipeline.run.warmup import warm_up_everything

        warm_up_everything(reporter)
        return 0
    if text is None:
        return _run_overrides(asked, reporter)
    print(text, end="")
    return 0


def _answer(asked) -> str | None:
    """What is printed where nothing is to be run."""
    if asked.usage:
        from pipeline.cli.help import usage

        return usage(asked.config_dir)
    if asked.version:
        from pipeline.cli.information import version

        return f"{version()}\n"
    if asked.complete is not None:
        from pipeline.cli.completion import candidates

        return "\n".join([*candidates(asked.complete), ""])
    if asked.shell is not None:
        from pipeline.cli.completion import script

        return script(asked.shell)
    return None


def _run_overrides(asked, reporter) -> int:
    from pipeline.config.compose import compose, expand
    from pipeline.config.secrets import hidden, without_secrets
    from pipeline.errors import ConfigurationError, shown

    try:
        combinations = expand(asked.overrides, asked.config_dir)
    except ConfigurationError as error:
        raise ConfigurationError(hidden(str(error), asked.overrides)) from None
    if len(combinations) > 1 and not asked.multirun:
        raise ConfigurationError(f"{shown(' '.join(map(without_secrets, asked.overrides)))}: several values need -m")
    all_settings = [compose(combination, asked.config_dir) for combination in combinations]
    if asked.show or asked.info:
        from pipeline.cli.information import configuration, information

        for settings in all_settings:
            print(information(settings) if asked.info else configuration(settings, asked.package), end="")
        return 0
    return _run_all(all_settings, reporter)


def _check_names(all_settings) -> None:
    """Raise ConfigurationError unless every plane of a multirun has a store of its own."""
    from pipeline.config.secrets import without_secrets
    from pipeline.config.typed import key_of
    from pipeline.errors import ConfigurationError

    by_path = {}
    for settings in all_settings:
        other = by_path.setdefault(settings.store_path.resolve(), settings)
        if other is settings or not ("sweep" in settings.config.stages or "sweep" in other.config.stages):
            continue
        if other.config == settings.config:
            raise ConfigurationError(
                f"-m {' '.join(map(without_secrets, settings.overrides))} is not allowed: it asks for one plane twice"
            )
        varied = [key_of(mine) for mine, its in zip(settings.overrides, other.overrides, strict=True) if mine != its]
        name = "-".join([other.default_name, *(f"${{{key}}}" for key in varied if key != "store.name")])
        raise ConfigurationError(
            f"store.name = {other.store_name!r} is not allowed here: several planes would share that store; "
            f"store.name='{name}' gives each its own"
        )


def _run_all(all_settings, reporter) -> int:
    """Prepare and run every plane, also when another one fails; the worst exit status."""
    from pipeline.run.early import early_helpers
    from pipeline.store.zarr_library import check_assertions

    # Before hours of computing, and not when their results are read.
    check_assertions()
    _check_names(all_settings)
    with early_helpers(all_settings) as helpers:
        return _run_each(all_settings, reporter, helpers)


def _run_each(all_settings, reporter, helpers) -> int:
    from pipeline.errors import ConfigurationError
    from pipeline.run.attempt import attempt
    from pipeline.run.preparation import prepare, run_plane_stages, run_shared_stages
    from pipeline.run.workforce import Workforce

    status, jobs = 0, []
    for settings in all_settings:
        try:
            jobs.append(prepare(settings))
        except ConfigurationError as error:
            reporter.error(str(error))
            status = max(status, error.status)
    if not jobs:
        return status
    with Workforce(jobs[0].settings.config.cluster, reporter.line, helpers) as workforce:
        if len(all_settings) == 1:
            status = attempt(run_plane_stages, jobs[0], workforce, reporter)
        else:
            from pipeline.multirun.running import run_planes

            status = max(status, run_planes(all_settings, jobs, workforce, reporter))
        # Tables need several planes: once, after all of them.
        status = max(status, attempt(run_shared_stages, jobs[-1], workforce, reporter, beside=True))
    if len(jobs) < len(all_settings):
        done = ", ".join(job.settings.store_name for job in jobs)
        reporter.line(f"note: {len(jobs)} of {len(all_settings)} planes were run: {done}; the others were refused")
    return status


def _leave(statuses: list[int]) -> None:
    """End the process with the status of `main`, the last thing that is done at exit.

    Python would first take apart every module and everything in them, which takes a quarter of a second.
    """
    if statuses:
        # They may be closed, or nobody may read them.
        for stream in filter(None, (sys.stdout, sys.stderr)):
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
        os._exit(statuses[0])


if __name__ == "__main__":
    _STATUSES: list[int] = []
    # What is registered first is called last.
    atexit.register(_leave, _STATUSES)
    _STATUSES.append(main())
    sys.exit(_STATUSES[0])
