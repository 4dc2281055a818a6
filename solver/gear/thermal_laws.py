"""What a temperature does to backlash, mesh stiffness and mesh damping: one frozen object a law, all replaceable.

A law of stiffness or damping gives a ratio to the value at the reference temperature, exactly 1 there; a law of
backlash gives the change of the half backlash in metres, exactly 0 there. Temperatures are in degrees Celsius. Each law
names the temperatures that it depends on and the range in which it holds.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from solver.model.checks import ParameterError, finite_number, value_range

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

__all__ = [
    "LAWS",
    "BacklashTable",
    "Expansion",
    "Law",
    "LinearModulus",
    "NoChange",
    "RatioTable",
    "Temperatures",
    "Unchanged",
    "VogelViscosity",
    "law_of",
]


class Temperatures(NamedTuple):
    """Of the gears (their oil included), of the housing, and of the state in which the gear's numbers hold."""

    gears: float
    housing: float
    reference: float

    @property
    def difference(self) -> float:
        """How much hotter the gears are than the housing."""
        return self.gears - self.housing


class Law(Protocol):
    """One law."""

    def value(self, at: Temperatures) -> float:
        """Ratio to the reference, or change of the half backlash (m)."""

    def felt(self, at: Temperatures) -> tuple[float, ...]:
        """The temperatures, or the difference of temperatures, that the law depends on."""

    @property
    def valid(self) -> tuple[float, float]:
        """Between which values of `felt` the law holds."""

    @property
    def knots(self) -> tuple[float, ...]:
        """Values of `felt` at which the law is not smooth."""


@dataclass(frozen=True)
class Expansion:
    """Backlash under thermal expansion of two straight bevel gears and their housing.

    A flank of a straight bevel gear is a cone with the gear's apex as its tip, so that uniform expansion about the apex
    maps it onto itself. What expansion does is to move the apex. Relative to the shoulder that holds gear g, at the
    mounting distance M_g from its apex, the apex moves away by M_g a_g (T_gears - T_0), and the housing moves the
    shoulder away from the point where the axes meet by M_g a_h (T_housing - T_0). The difference s_g shifts the gear
    along its axis into its mate. The normal of the contact has the axial component sin(delta_g) sin(alpha_n)
    (docs/physics.md, section 1; the other flank's normal has the same one), so that the gap at each flank closes by s_g
    sin(delta_g) sin(alpha_n):

        change of b_h = -sin(alpha_n) sum_g M_g sin(delta_g) [a_g (T_gears - T_0) - a_h (T_housing - T_0)]

    Both flanks together give the rule that an axial shift s changes normal backlash by 2 s sin(delta) sin(alpha_n).

    Parameters
    ----------
    gears : (2,) sequence
        a_g, coefficients of linear expansion, 1/K.
    housing : float
        a_h.
    distances : (2,) sequence
        M_g, m, > 0.
    cone_angles : (2,) sequence
        delta_g, degrees.
    pressure_angle : float
        alpha_n, degrees.
    valid : (low, high)
        Range of temperatures, degrees Celsius.
    """

    gears: tuple[float, float]
    housing: float
    distances: tuple[float, float]
    cone_angles: tuple[float, float]
    pressure_angle: float
    valid: tuple[float, float]

    knots = ()

    def __post_init__(self):
        for name in ("gears", "distances", "cone_angles"):
            _set(self, name, _finite(name, getattr(self, name), 2, low=0.0))
        _set(self, "housing", finite_number("housing", self.housing, at_least=0.0))
        _set(self, "valid", value_range("valid", self.valid))

    def value(self, at: Temperatures) -> float:
        closing = sum(
            m * math.sin(math.radians(d)) * (a * (at.gears - at.reference) - self.housing * (at.housing - at.reference))
            for m, d, a in zip(self.distances, self.cone_angles, self.gears, strict=True)
        )
        return -math.sin(math.radians(self.pressure_angle)) * closing

    def felt(self, at: Temperatures) -> tuple[float, ...]:
        return at.gears, at.housing


@dataclass(frozen=True)
class LinearModulus:
    """Mesh stiffness proportional to Young's modulus, E(T) = E(T_0) [1 - slope (T - T_0)].

    ASME B31.3, table C-6, carbon steel with C > 0.3 %: 202.0 GPa at 21, 197.2 at 93, 189.6 at 204, 186.8 at 260 degrees
    Celsius. The line through the first and the third has slope 3.35e-4 per K of the modulus at 21 degrees and misses
    the others between -73 and 260 degrees by less than 0.8 %.

    Parameters
    ----------
    slope : float
        1/K.
    valid : (low, high)
        Range of temperatures, degrees Celsius.
    """

    slope: float
    valid: tuple[float, float]

    knots = ()

    def __post_init__(self):
        _set(self, "slope", finite_number("slope", self.slope))
        _set(self, "valid", value_range("valid", self.valid))
        low, high = self.valid
        if not abs(self.slope) * (high - low) < 1.0:
            allowed = f"such that the modulus stays above 0 from {low:g} to {high:g} °C"
            raise ParameterError("slope", self.slope, allowed)

    def value(self, at: Temperatures) -> float:
        return 1.0 - self.slope * (at.gears - at.reference)

    def felt(self, at: Temperatures) -> tuple[float, ...]:
        return (at.gears,)


@dataclass(frozen=True)
class VogelViscosity:
    """Mesh damping proportional to a power of the oil's viscosity, nu(T) = a exp[B/(T + C)] (Vogel 1921).

    Squeeze-film damping is proportional to viscosity (Reynolds' equation is linear in it); a smaller exponent stands
    for damping that comes in part from elsewhere. With C = 95 K, as in Cameron's form of the equation, B = 1075 K takes
    an ISO VG 220 oil from 220 mm2/s at 40 degrees Celsius, which defines the grade (ISO 3448), to 19 mm2/s at 100
    degrees, usual for mineral gear oils of viscosity index 95.

    Parameters
    ----------
    constant : float
        B, K.
    offset : float
        C, K.
    exponent : float
        Of the viscosity, >= 0.
    valid : (low, high)
        Range of temperatures, degrees Celsius, above -C.
    """

    constant: float
    offset: float
    exponent: float
    valid: tuple[float, float]

    knots = ()

    def __post_init__(self):
        for name in ("constant", "offset", "exponent"):
            _set(self, name, finite_number(name, getattr(self, name), at_least=0.0))
        _set(self, "valid", value_range("valid", self.valid))
        if not self.valid[0] > -self.offset:
            raise ParameterError("valid", self.valid, f"above {-self.offset:g} °C, where the viscosity is infinite")

    def value(self, at: Temperatures) -> float:
        power = self.exponent * self.constant
        return math.exp(power / (at.gears + self.offset) - power / (at.reference + self.offset))

    def felt(self, at: Temperatures) -> tuple[float, ...]:
        return (at.gears,)


@dataclass(frozen=True)
class _Table:
    """Values measured or computed at ascending temperatures, joined by a cubic spline.

    Parameters
    ----------
    table : sequence of (temperature, value)
        At least 2 points, temperatures ascending; values above 0, and the spline as well.
    """

    table: tuple[tuple[float, float], ...]

    def __post_init__(self):
        points = self.table
        if isinstance(points, str) or not hasattr(points, "__len__") or len(points) < 2:
            raise ParameterError("table", points, "a list of at least 2 [temperature, value] pairs")
        _set(self, "table", tuple(_finite("table", pair, 2) for pair in points))
        temperatures = np.array(self.table)[:, 0]
        if not np.all(np.diff(temperatures) > 0.0):
            raise ParameterError("table", points, "a list of pairs with ascending temperatures, none of them twice")
        if not np.min(self._spline(np.linspace(temperatures[0], temperatures[-1], 1001))) > 0.0:
            allowed = "a list of pairs whose values, and the spline between them, are above 0"
            raise ParameterError("table", points, allowed)

    @cached_property
    def _spline(self) -> "CubicSpline":
        # It takes 0.4 s to import, which every worker would pay.
        from scipy.interpolate import CubicSpline

        # Not-a-knot: three points are joined by a parabola, four by one cubic.
        return CubicSpline(*np.transpose(self.table))

    @property
    def valid(self) -> tuple[float, float]:
        return self.table[0][0], self.table[-1][0]

    @property
    def knots(self) -> tuple[float, ...]:
        return tuple(temperature for temperature, _ in self.table)


class RatioTable(_Table):
    """Mesh stiffness or damping at some gear temperatures (degrees Celsius), in any unit; only ratios count."""

    def value(self, at: Temperatures) -> float:
        return float(self._spline(at.gears)) / float(self._spline(at.reference))

    def felt(self, at: Temperatures) -> tuple[float, ...]:
        return at.gears, at.reference


class BacklashTable(_Table):
    """Half backlash (m) at some temperature differences between gears and housing (K)."""

    def value(self, at: Temperatures) -> float:
        return float(self._spline(at.difference)) - float(self._spline(0.0))

    def felt(self, at: Temperatures) -> tuple[float, ...]:
        return at.difference, 0.0


@dataclass(frozen=True)
class Unchanged:
    """Stiffness or damping that the temperature does not change."""

    valid = (-math.inf, math.inf)
    knots = ()

    def value(self, at: Temperatures) -> float:
        return 1.0

    def felt(self, at: Temperatures) -> tuple[float, ...]:
        return ()


class NoChange(Unchanged):
    """Backlash that the temperature does not change."""

    def value(self, at: Temperatures) -> float:
        return 0.0


#: The laws of each role under the names that users type.
LAWS = {
    "backlash": {"expansion": Expansion, "table": BacklashTable, "none": NoChange},
    "stiffness": {"linear": LinearModulus, "table": RatioTable, "none": Unchanged},
    "damping": {"vogel": VogelViscosity, "table": RatioTable, "none": Unchanged},
}


def law_of(role: str, law: str, **parameters) -> Law:
    """The law of a role under its name.

    Parameters
    ----------
    role : str
        One of `LAWS`.
    law : str
        Name of the law.
    **parameters
        Its fields.

    Raises
    ------
    ParameterError
        Naming `<role>.<parameter>`, its value and what is allowed.
    """
    if law not in LAWS[role]:
        raise ParameterError(f"{role}.law", law, f"one of {', '.join(LAWS[role])}")
    try:
        return LAWS[role][law](**parameters)
    except ParameterError as error:
        raise ParameterError(f"{role}.{error.name}", error.value, error.allowed) from None


def _set(law, name: str, value) -> None:
    object.__setattr__(law, name, value)


def _finite(name: str, values, count: int, low: float = -math.inf) -> tuple[float, ...]:
    """`count` finite numbers, none below `low`."""
    allowed = f"a list of {count} finite numbers" + (f", at least {low:g}" if low > -math.inf else "")
    try:
        found = tuple(finite_number(name, value) for value in values)
    except (TypeError, ParameterError):
        raise ParameterError(name, values, allowed) from None
    if len(found) != count or min(found) < low:
        raise ParameterError(name, values, allowed)
    return found
