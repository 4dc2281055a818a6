"""What a solution curve is, as compiled kernels see it."""

from dataclasses import dataclass

import numpy as np

__all__ = ["Problem"]


@dataclass(frozen=True)
class Problem:
    """A curve E(u, p) = 0 as compiled kernels see it.

    Parameters
    ----------
    balance, monitor : compiled kernels
        With the signatures `solver.compiled.BALANCE` and `MONITOR`; values[0] of the monitor is the amplitude, each of
        the others has a grazing where it vanishes.
    theta, direction : arrays
        Parameters at p = 0 and what p adds to them.
    scale : (n + 1,) array
        Typical size of each unknown and of p.
    monitors : int
        Number of monitor values, >= 1.
    """

    balance: object
    monitor: object
    theta: np.ndarray
    direction: np.ndarray
    scale: np.ndarray
    monitors: int

    @property
    def unknowns(self) -> int:
        """Number n of unknowns u."""
        return self.scale.size - 1
