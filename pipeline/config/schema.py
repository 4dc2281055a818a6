"""Types of every configuration key, and what values may be where that is a range or a word; values live in conf/.

Those of the gear stand in `pipeline.config.gear_schema`.
"""

import math
from dataclasses import dataclass, field
from typing import Any

from omegaconf import MISSING

from pipeline.config.allowed import allowed
from pipeline.config.gear_schema import Gear
from pipeline.config.quantities import QUANTITIES

__all__ = ["Configuration"]

#: Fewer periods leave no window over which a Lyapunov exponent says anything.
FEWEST_PERIODS = 800
_MOST = 10**6


@dataclass
class Axis:
    """One axis of a plane: `num` values from `min` to `max`, both included; these are numbers, or texts with units."""

    name: str = MISSING
    min: Any = MISSING
    max: Any = MISSING
    num: int = allowed(2)


@dataclass
class Plane:
    """Two axes, a third one for a volume, and the frequency where it is none of them."""

    sweep: Axis = MISSING
    parameter: Axis = MISSING
    parameter2: Axis | None = MISSING
    layer: float | None = MISSING
    omega: Any = MISSING
    max_cells: float = MISSING


@dataclass
class Solver:
    """Which balance, and continuation settings; see `solver.Continuation`."""

    balance: str = allowed(names=("describing_function", "galerkin"))
    order: int = allowed(1, 64)
    period: int = allowed(1, 4)
    corrector: str = allowed(names=("newton", "broyden"))
    certify: str = allowed(names=("none", "columns", "all"))
    certify_columns: int = allowed(2, 10**6)
    tolerance: float = allowed(0.0, 1e-6, above=True)
    amplitude_max: float = allowed(0.0, above=True)
    first_step: float = allowed(0.0, above=True)
    largest_step: float = allowed(0.0, above=True)
    smallest_step: float = allowed(0.0, above=True)
    largest_angle: float = allowed(0.0, math.pi, above=True)
    largest_distance: float = allowed(0.0, 10.0, above=True)
    parameter_step: float = allowed(0.0, 1.0, above=True)
    growth: float = allowed(0.0, above=True)


@dataclass
class Security:
    """Files with which a scheduler at a tls:// address and this program know each other."""

    ca_file: str | None = MISSING
    cert: str | None = MISSING
    key: str | None = MISSING


@dataclass
class Cluster:
    """Where tasks run."""

    kind: str = allowed(names=("local", "none", "scheduler", "slurm"))
    workers: int = allowed(0, 1024)
    memory: str = MISSING
    row_seconds: float = allowed(0.0, 1e6, above=True)
    dashboard: bool = MISSING
    address: str | None = MISSING
    scheduler_file: str | None = MISSING
    timeout: float = allowed(0.0, 3600.0, above=True)
    security: Security = MISSING
    # Of jobs: their file alone has them.
    queue: str | None = None
    account: str | None = None
    cores: int | None = allowed(1, 1024, default=None)
    walltime: str | None = None
    minimum_jobs: int | None = allowed(0, 10_000, default=None)
    maximum_jobs: int | None = allowed(1, 10_000, default=None)
    directives: list[str] | None = None
    host: str | None = None
    folder: str | None = None


@dataclass
class Quality:
    """Resolution that planes use unless they say otherwise."""

    sweep: int = MISSING
    parameter: int = MISSING


@dataclass
class Output:
    """Where everything goes."""

    root: str = MISSING


@dataclass
class Store:
    """The store of a plane, and how much a row may hold."""

    root: str = MISSING
    #: Of an object store: secrets may be among them, which no text has.
    storage_options: dict[str, Any] = field(default=MISSING, repr=False)
    name: str | None = MISSING
    overwrite: bool = MISSING
    wait: bool = MISSING
    max_solutions: int = allowed(1, 100)
    max_branches: int = allowed(1, 100)
    max_points: int = allowed(2, 10**7)


@dataclass
class Figures:
    """What is drawn."""

    curves: list[float] | None = MISSING
    multipliers: list[float] | None = MISSING
    formats: list[str] = allowed(names=("png", "pdf", "svg"))
    dpi: int = allowed(30, 1200)
    stability: str = allowed(names=("static", "dynamic"))
    window: list[float] | None = MISSING
    units: str = allowed(names=("dimensionless", "physical"))
    quantity: str | None = allowed(names=tuple(QUANTITIES))
    of: str = allowed(names=("worst", "mildest"))


@dataclass
class Page:
    """What the page of a plane has besides its map; units and `of` are those of the figures."""

    rows: int = allowed(0, 40)
    quantities: list[str] = allowed(names=tuple(QUANTITIES))


@dataclass
class Attractors:
    """Which cells are integrated, and from how many random starts; see `pipeline.analysis.attractors.options`."""

    columns: Any = MISSING
    rows: Any = MISSING
    starts: int = allowed(0, _MOST)
    seed: int = allowed(0, 2**63 - 1)
    max_periods: int = allowed(FEWEST_PERIODS, 10**7)
    tolerance: float = allowed(0.0, 1.0, above=True)
    delta: float = allowed(0.0, 1.0)
    branches: int = allowed(0, 32)
    points: Any = MISSING
    box: Any = MISSING
    slice: int = allowed(0, 2000)


@dataclass
class Check:
    """What is done about damage, and how many rows are computed again."""

    repair: bool = MISSING
    recompute: int = allowed(0, 2**31 - 1)
    seed: int = allowed(0, 2**31 - 1)


@dataclass
class Debug:
    """Which row is computed again with a diary of its continuation."""

    row: int | None = MISSING


@dataclass
class Margins:
    """A design point of the plane, its operating range and its tolerances; see `pipeline.analysis.margins.options`."""

    point: Any = MISSING
    range: Any = MISSING
    tolerances: Any = MISSING
    reach: float = allowed(1.1, 100.0)


@dataclass
class Motion:
    """A point of the plane of which all motions are drawn; see `pipeline.plan.points`."""

    at: Any = MISSING


@dataclass
class Diagram:
    """The row that is followed up and down; see `pipeline.analysis.diagram.options`."""

    value: Any = MISSING
    columns: int | None = allowed(2, 10**5)
    max_periods: int = allowed(FEWEST_PERIODS, 10**7)


@dataclass
class Spectrum:
    """Spectra along a row; see `pipeline.analysis.diagram.options`."""

    value: Any = MISSING
    columns: int | None = allowed(2, 10**5)
    max_periods: int = allowed(FEWEST_PERIODS, 10**7)
    direction: str = allowed(names=("up", "down"))
    of: str = allowed(names=("displacement", "force"))
    axis: str = allowed(names=("frequency", "order"))
    orders: float = allowed(1.0, 60.0)
    periods: int = allowed(1, 1000)


@dataclass
class Explore:
    """The page of a plane, and what it shows first; see `pipeline.explorer.view_state`."""

    port: int = allowed(0, 65535)
    view: str | None = MISSING


@dataclass
class Report:
    """The reproduction report."""

    run: bool = MISSING


@dataclass
class Configuration:
    """All of it."""

    stages: list[str] = MISSING
    gear: Gear = MISSING
    plane: Plane = MISSING
    solver: Solver = MISSING
    cluster: Cluster = MISSING
    quality: Quality = MISSING
    output: Output = MISSING
    store: Store = MISSING
    attractors: Attractors = MISSING
    motion: Motion = MISSING
    diagram: Diagram = MISSING
    spectrum: Spectrum = MISSING
    margins: Margins = MISSING
    explore: Explore = MISSING
    figures: Figures = MISSING
    page: Page = MISSING
    check: Check = MISSING
    debug: Debug = MISSING
    report: Report = MISSING
