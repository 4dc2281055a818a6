"""What can be loaded beside this process from the moment on at which the configuration is known.

A plane whose rows one core computes in the time that dask's workers take to start is computed here and by helpers,
which draw it afterwards. They load while this process loads, makes the plan and writes the template.
"""

import contextlib
from collections.abc import Iterator, Sequence

from pipeline.config.compose import Settings
from pipeline.errors import ConfigurationError, Unreachable
from pipeline.store.files import files_at

__all__ = ["DRAWING", "ROWS", "early_helpers", "is_small"]

#: Cells of first order that one core computes in about the time in which two workers start and do the same.
_FEW_CELLS = 100_000
#: What makes a process ready to draw, and to solve rows of first order.
DRAWING, ROWS = "pipeline.figures.ready", "pipeline.run.ready_rows"


def is_small(settings: Settings, cells: int) -> bool:
    """Whether so many cells take less time than workers take to start; never where a cluster is asked for."""
    first_order = settings.config.solver.balance == "describing_function"
    return first_order and cells <= _FEW_CELLS and not settings.overridden("cluster")


@contextlib.contextmanager
def early_helpers(all_settings: Sequence[Settings]) -> Iterator:
    """Helpers for a new small plane that will be drawn (`pipeline.run.helpers.Helpers`); None for anything else."""
    if len(all_settings) != 1 or not _is_new_and_drawn(all_settings[0]):
        yield None
        return
    from pipeline.run.helpers import helpers

    with helpers(all_settings[0].config.cluster, [ROWS, DRAWING]) as found:
        yield found


def _is_new_and_drawn(settings: Settings) -> bool:
    plane, stages = settings.config.plane, settings.config.stages
    if not {"sweep", "figures"} <= set(stages) or plane.parameter2 is not None or plane.layer is not None:
        return False
    if not is_small(settings, plane.sweep.num * plane.parameter.num):
        return False
    try:
        return settings.config.store.overwrite or not files_at(settings.store_path).exists()
    except (ConfigurationError, Unreachable):
        # That is said where everything is checked.
        return False
