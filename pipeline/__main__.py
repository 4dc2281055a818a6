"""`python -m pipeline`: the command line. Imports are inside the functions because every worker imports this module."""

import sys

__all__ = ["main"]

USAGE = """\
usage: python -m pipeline [-m] [--config-dir DIR] [--cfg] [GROUP=CHOICE ...] [KEY=VALUE ...]

Computes how many steady motions a bevel gear pair with backlash has over a parameter plane, stores them, draws the map.

groups
  plane    omega_b omega_alpha omega_fe omega_fpm omega_phase omega_xi omega_xi_support b_fe    (default omega_fe)
           omega_temperature (for gears in physical units), omega_b_fe (a volume)
  gear     published consistent antiphase            (default published)
           miter differential                        (from drawings, in physical units)
  quality  paper (400 x 200) draft (160 x 60)        (default paper)
  solver   first_order
  cluster  local none scheduler                      (default local: two worker processes)

keys people need
  stages=[sweep,boundaries,figures]  what to do (this is the default); each reads what the ones before it stored.
                                     There are also: verify (where the map can be trusted, by higher orders and by
                                     integration), basins (shares of random initial states), jumps (attractors followed
                                     along rows, up and down), margins (distances of a design point to the nearest
                                     boundaries), tables
  gear.b=0.5 gear.alpha=0.3          any parameter of the gear that is not an axis of the plane
  gear.physical.torque='60 N*m'      any number of a gear in physical units, with its unit; then also
                                     plane.sweep.min='500 rpm' and figures.units=physical
  plane.parameter.name=kappa         any scalar parameter as an axis, with plane.parameter.min, .max and .num
  'plane.parameter2={name:f_e,min:0,max:0.5,num:50}'
                                     a third axis: a volume of layers, for the stages sweep, figures and check
  plane.layer=0.3                    of a volume, the layer nearest to this value, as a plane for every stage
  plane.sweep.num=800                columns
  figures.curves=[0.1,0.5,1.0]       parameter values whose amplitude-frequency curves are drawn
  figures.window=[0.5,0.7,0.1,0.3]   a part of the plane, drawn in addition, as sharp as the whole: lowest and highest
                                     column value, then row value
  verify.samples=1000                cells that are integrated; also verify.order, verify.delta, verify.seed
  basins.points=[[0.6,0.2]]          where basins are measured, column value and row value; also basins.starts
  jumps.values=[0.1,0.2]             rows along which attractors are followed; also jumps.rows
  margins.point=[0.9,0.1]            the design point, column value and row value; also margins.range=[0.8,1.0] and
                                     margins.tolerances={f_e:0.02,b:0.1}
  store.name=mine                    name of the store and of its figures' folder
  store.overwrite=true               replace a store of another configuration
  solver.corrector=broyden           the study's corrector instead of Newton's
  cluster.workers=4                  worker processes on this machine
  output.root=results                where everything is written (default outputs)

options
  -m, --multirun     run every combination of comma-separated values, on one cluster
  --config-dir DIR   a folder with your own gear/, plane/, ... files
  --cfg              print the resolved configuration and do nothing
  -h, --help         this text

examples
  python -m pipeline plane=omega_b quality=draft
  python -m pipeline -m plane=omega_b,omega_alpha,omega_fe,omega_fpm
  python -m pipeline plane=omega_fe stages=[boundaries]
  python -m pipeline plane=omega_fe stages=[verify,basins,jumps,figures]
  python -m pipeline stages=[tables]

exit status: 0 all well; 1 some rows, boundaries or integrations failed (the store or a line says why);
             2 the input is not allowed (nothing was written)
"""


_KEPT = "; what is stored is kept, and the same command goes on from there"


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; the exit status."""
    arguments = sys.argv[1:] if arguments is None else arguments
    from pipeline.errors import ConfigurationError
    from pipeline.progress import Reporter

    reporter = Reporter()
    try:
        return _run(arguments, reporter)
    except ConfigurationError as error:
        reporter.error(str(error))
        return 2
    except OSError as error:
        reporter.error(f"{error}{_KEPT}")
        return 1
    except KeyboardInterrupt:
        reporter.error(f"interrupted{_KEPT}")
        return 130


def _run(arguments: list[str], reporter) -> int:
    from pipeline.config import compose, expand
    from pipeline.errors import ConfigurationError

    multirun, config_dir, show, overrides = _parse(arguments)
    if overrides is None:
        print(USAGE, end="")
        return 0
    combinations = expand(overrides)
    if len(combinations) > 1 and not multirun:
        raise ConfigurationError(f"{' '.join(overrides)}: several values need -m")
    all_settings = [compose(combination, config_dir) for combination in combinations]
    if show:
        for settings in all_settings:
            print(settings.yaml(), end="")
        return 0
    return _run_all(all_settings, reporter)


def _run_all(all_settings, reporter) -> int:
    """Prepare and run every plane, also when another one fails; the worst exit status."""
    from pipeline.cluster import Workforce
    from pipeline.errors import ConfigurationError
    from pipeline.warmup import compile_beside

    helper = compile_beside()
    from pipeline.stages import prepare, run_plane_stages, run_shared_stages

    status, jobs = 0, []
    names = [settings.store_name for settings in all_settings]
    if len(set(names)) < len(names) and any("sweep" in settings.config.stages for settings in all_settings):
        raise ConfigurationError(f"store.name = {names[0]!r} is not allowed here: several planes would share that store")
    for settings in all_settings:
        try:
            jobs.append(prepare(settings))
        except ConfigurationError as error:
            reporter.error(str(error))
            status = 2
    if helper is not None:
        helper.wait()
    if not jobs:
        return status
    with Workforce(jobs[0].settings.config.cluster) as workforce:
        for job in jobs:
            try:
                status = max(status, run_plane_stages(job, workforce, reporter))
            except ConfigurationError as error:
                reporter.error(str(error))
                status = 2
            except OSError as error:
                reporter.error(f"{error}{_KEPT}")
                status = max(status, 1)
            except (ValueError, KeyError, TypeError, RuntimeError) as error:
                reporter.error(str(_of_damage(job, error)))
                status = max(status, 1)
        # Tables need several planes: once, after all of them.
        return max(status, run_shared_stages(jobs[-1], workforce, reporter))


def _of_damage(job, error: Exception) -> Exception:
    """What to say where reading a damaged store is what went wrong; anything else is a defect of ours, and goes on up."""
    from pipeline import store

    found = store.damage_error(job.store_path)
    if found is None:
        raise error
    return found


def _parse(arguments: list[str]) -> tuple[bool, str | None, bool, list[str] | None]:
    """Options by hand, so that a mistake is one line like any other: (multirun, config_dir, show, overrides or None)."""
    from pipeline.errors import ConfigurationError

    multirun, config_dir, show, overrides = False, None, False, []
    rest = iter(arguments)
    for argument in rest:
        if argument in ("-h", "--help"):
            return multirun, config_dir, show, None
        if argument in ("-m", "--multirun"):
            multirun = True
        elif argument in ("--cfg", "-c"):
            show = True
        elif argument in ("--config-dir", "-cd"):
            config_dir = next(rest, None)
            if config_dir is None:
                raise ConfigurationError("--config-dir needs a folder")
        elif argument.startswith("--config-dir="):
            config_dir = argument.partition("=")[2]
        elif argument.startswith("-"):
            raise ConfigurationError(f"{argument} is not an option; --help lists them")
        else:
            overrides.append(argument)
    return multirun, config_dir, show, overrides


if __name__ == "__main__":
    sys.exit(main())
