"""Mass and polar inertia of a bevel gear blank: a frustum of a cone without its bore."""

import math
from dataclasses import dataclass

from solver.model.checks import ParameterError, finite_number

__all__ = ["STEEL", "Blank"]

#: Density of steel, kg/m^3.
STEEL = 7850.0


@dataclass(frozen=True)
class Blank:
    """A steel blank, all lengths in m.

    Parameters
    ----------
    large_diameter, small_diameter : float
        Of the frustum's two faces, > 0, the first at least as large as the second. The pitch diameters at
        both ends of the teeth balance what the tooth spaces take away and the tips add.
    width : float
        Along the axis, > 0.
    bore : float
        Diameter of the bore, from 0 to below `small_diameter`.
    density : float
        kg/m^3, > 0.

    Raises
    ------
    ParameterError
        Naming the field, its value and what is allowed.
    """

    large_diameter: float
    small_diameter: float
    width: float
    bore: float = 0.0
    density: float = STEEL

    def __post_init__(self):
        for name in ("large_diameter", "small_diameter", "width", "density"):
            object.__setattr__(self, name, finite_number(name, getattr(self, name), above=0.0))
        object.__setattr__(self, "bore", finite_number("bore", self.bore, at_least=0.0))
        if self.small_diameter > self.large_diameter:
            raise ParameterError(
                "small_diameter", self.small_diameter, f"at most the large_diameter {self.large_diameter:g} (m)"
            )
        if self.bore >= self.small_diameter:
            raise ParameterError("bore", self.bore, f"below the small_diameter {self.small_diameter:g} (m)")

    @property
    def mass(self) -> float:
        """kg: rho pi (w (R^2 + R r + r^2)/3 - w s^2), the integral of rho pi radius^2 along the axis."""
        large, small, bore = 0.5 * self.large_diameter, 0.5 * self.small_diameter, 0.5 * self.bore
        squares = (large**2 + large * small + small**2) / 3.0 - bore**2
        return self.density * math.pi * self.width * squares

    @property
    def inertia(self) -> float:
        """kg m^2: rho pi/2 (w (R^4 + R^3 r + R^2 r^2 + R r^3 + r^4)/5 - w s^4), of rho pi radius^4/2 along the axis."""
        large, small, bore = 0.5 * self.large_diameter, 0.5 * self.small_diameter, 0.5 * self.bore
        fourths = sum(large ** (4 - k) * small**k for k in range(5)) / 5.0 - bore**4
        return 0.5 * self.density * math.pi * self.width * fourths
