"""Pitch cones of a straight bevel pair."""

import math
from dataclasses import dataclass

import numpy as np

from solver.model.checks import ParameterError, finite_number, list_length, whole_number

__all__ = ["PitchCones"]


@dataclass(frozen=True)
class PitchCones:
    """Two pitch cones with a common apex.

    Parameters
    ----------
    teeth : (int, int)
        z_1 and z_2, > 0.
    module : float
        Outer transverse module (m), > 0.
    shaft_angle : float
        Sigma within (0, 180) (degrees).
    face_width : float
        m, > 0 and at most the cone distance.

    Raises
    ------
    ParameterError
        Naming the field, its value and what is allowed.
    """

    teeth: tuple[int, int]
    module: float
    shaft_angle: float
    face_width: float

    def __post_init__(self):
        object.__setattr__(self, "teeth", _teeth(self.teeth))
        for name in ("module", "shaft_angle", "face_width"):
            object.__setattr__(self, name, finite_number(name, getattr(self, name), above=0.0))
        if self.shaft_angle >= 180.0:
            raise ParameterError("shaft_angle", self.shaft_angle, "an angle in degrees, above 0 and below 180")
        if self.face_width > self.cone_distance:
            raise ParameterError("face_width", self.face_width, f"at most the cone distance {self.cone_distance:.6g} m")

    @property
    def ratio(self) -> float:
        """u = z_2/z_1."""
        return self.teeth[1] / self.teeth[0]

    @property
    def cone_angles(self) -> tuple[float, float]:
        """Pitch cone angles (degrees): tan delta_1 = sin Sigma/(u + cos Sigma), delta_2 = Sigma - delta_1.

        One of them may exceed a right angle (an internal bevel gear): the contact normal holds there as well, its
        radial component turning its sign.
        """
        angle = math.radians(self.shaft_angle)
        first = math.degrees(math.atan2(math.sin(angle), self.ratio + math.cos(angle)))
        return first, self.shaft_angle - first

    @property
    def cone_distance(self) -> float:
        """Outer cone distance m z_1/(2 sin delta_1) (m)."""
        return 0.5 * self.module * self.teeth[0] / math.sin(math.radians(self.cone_angles[0]))

    @property
    def mean_radii(self) -> np.ndarray:
        """r_g = (m z_g - face width sin delta_g)/2, at mid face (m), (2,)."""
        return 0.5 * (self.module * np.array(self.teeth) - self.face_width * np.sin(np.radians(self.cone_angles)))


def _teeth(value) -> tuple[int, int]:
    if list_length(value) != 2:
        raise ParameterError("teeth", value, "two whole numbers above 0")
    return tuple(whole_number(f"teeth[{i}]", count, 1, 10_000) for i, count in enumerate(value))
