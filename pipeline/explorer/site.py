"""What the pages of one server have in common: the planes that they may show, and the one background run."""

from dataclasses import dataclass, field

from pipeline.explorer.background_run import BackgroundRun
from pipeline.explorer.opened import Opened

__all__ = ["Site"]


@dataclass(eq=False)
class Site:
    """Of one server.

    Parameters
    ----------
    opened : Opened
        The plane that is shown first.

    Attributes
    ----------
    planes : dict of str to Opened
        By name: no page can ask for any other.
    run : BackgroundRun
    """

    opened: Opened
    planes: dict[str, Opened] = field(init=False)
    run: BackgroundRun = field(default_factory=BackgroundRun)

    def __post_init__(self):
        self.planes = {self.first: self.opened}

    @property
    def first(self) -> str:
        """Name of the plane that is shown first."""
        return self.opened.path.stem
