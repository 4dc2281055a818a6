"""The involute teeth of one gear as a drawing gives them: radii, flank and fillet.

A tooth stands upright on its centre line: y from the gear's centre, x the half thickness. The flank is the involute of
the base circle, the fillet what the rounded tip of a rack cutter leaves (docs/physics.md, section 11).
"""

import math
from dataclasses import dataclass

import numpy as np

from solver.model.checks import ParameterError, finite_number

__all__ = ["GearTeeth", "fillet", "involute", "involute_function", "junction"]


@dataclass(frozen=True)
class GearTeeth:
    """Teeth and body of one gear, of any tooth number, as virtual gears need.

    Lengths of the tooth are shares of the module, as on drawings.

    Parameters
    ----------
    teeth : float
        z, at least 5; of a gear that can be made a whole number.
    module : float
        m (m), > 0.
    bore : float
        Diameter at which the shaft holds the body (m), > 0 and below the root circle: of the bore, or of the shaft that
        is in one piece with the gear.
    pressure_angle : float
        alpha of the rack (degrees), from 10 to 35.
    addendum, dedendum : float
        h_a and h_f over m, > 0, the second above the first.
    profile_shift : float
        x, within [-1, 1].
    edge_radius : float or None
        Radius of the rack's tip over m, from 0 to what has room; None is the largest that leaves the flank straight to
        the depth h_a, as ISO 53 has it.
    youngs_modulus : float
        E (Pa), > 0.
    poisson : float
        nu, from 0 to 0.5.

    Raises
    ------
    ParameterError
        Naming the field, its value and what is allowed: teeth with a point, or without a fillet, are refused as well.
    """

    teeth: float
    module: float
    bore: float
    pressure_angle: float = 20.0
    addendum: float = 1.0
    dedendum: float = 1.25
    profile_shift: float = 0.0
    edge_radius: float | None = None
    youngs_modulus: float = 206e9
    poisson: float = 0.3

    def __post_init__(self):
        for name, bounds in {
            "teeth": {"at_least": 5.0, "at_most": 1e6},
            "module": {"above": 0.0},
            "pressure_angle": {"at_least": 10.0, "at_most": 35.0},
            "addendum": {"above": 0.0, "at_most": 2.0},
            "dedendum": {"above": 0.0, "at_most": 3.0},
            "profile_shift": {"at_least": -1.0, "at_most": 1.0},
            "youngs_modulus": {"above": 0.0},
            "poisson": {"at_least": 0.0, "at_most": 0.5},
        }.items():
            object.__setattr__(self, name, finite_number(name, getattr(self, name), **bounds))
        if self.dedendum <= self.addendum:
            raise ParameterError("dedendum", self.dedendum, f"above the addendum {self.addendum:g}")
        self._check_edge()
        bore = finite_number("bore", self.bore, above=0.0)
        if bore >= 2.0 * self.root_radius:
            raise ParameterError("bore", bore, f"below the diameter of the root circle, {2.0 * self.root_radius:.6g} m")
        object.__setattr__(self, "bore", bore)
        if self.tip_radius <= self.base_radius:
            raise ParameterError("addendum", self.addendum, "so large that the tooth reaches beyond its base circle")
        if involute(self, self.tip_angle)[0] <= 0.0:
            raise ParameterError("addendum", self.addendum, "so small that the tooth does not end in a point")
        if self._edge_depth <= 0.0:
            raise ParameterError(
                "profile_shift", self.profile_shift, f"below {self.dedendum - self._edge:.6g}, so that a fillet remains"
            )

    def _check_edge(self):
        if self._room < 0.0:
            most = 0.25 * math.pi / math.tan(math.radians(self.pressure_angle))
            raise ParameterError("dedendum", self.dedendum, f"at most {most:.6g}, where the rack ends in a point")
        if self.edge_radius is not None:
            edge = finite_number("edge_radius", self.edge_radius, at_least=0.0, at_most=self._room)
            object.__setattr__(self, "edge_radius", edge)

    @property
    def _room(self) -> float:
        """Largest radius over m that the tip of the rack has room for."""
        angle = math.radians(self.pressure_angle)
        across = (0.25 * math.pi - self.dedendum * math.tan(angle)) * math.cos(angle) / (1.0 - math.sin(angle))
        return min(across, self.dedendum)

    @property
    def _edge(self) -> float:
        """Radius of the rack's tip over m."""
        if self.edge_radius is not None:
            return self.edge_radius
        return min((self.dedendum - self.addendum) / (1.0 - math.sin(math.radians(self.pressure_angle))), self._room)

    @property
    def pitch_radius(self) -> float:
        """r = m z/2 (m)."""
        return 0.5 * self.module * self.teeth

    @property
    def base_radius(self) -> float:
        """r_b = r cos alpha (m)."""
        return self.pitch_radius * math.cos(math.radians(self.pressure_angle))

    @property
    def tip_radius(self) -> float:
        """r_a = r + (h_a + x) m (m)."""
        return self.pitch_radius + (self.addendum + self.profile_shift) * self.module

    @property
    def root_radius(self) -> float:
        """r_f = r - (h_f - x) m (m)."""
        return self.pitch_radius - (self.dedendum - self.profile_shift) * self.module

    @property
    def base_half_angle(self) -> float:
        """theta_b = (pi/2 + 2 x tan alpha)/z + inv alpha, half the tooth's angle on the base circle (rad)."""
        angle = math.radians(self.pressure_angle)
        return (0.5 * math.pi + 2.0 * self.profile_shift * math.tan(angle)) / self.teeth + involute_function(angle)

    @property
    def root_half_angle(self) -> float:
        """theta_f, half the tooth's angle on the root circle, where the fillets end (rad)."""
        return self._edge_offset / self.pitch_radius

    @property
    def tip_angle(self) -> float:
        """psi_a = arccos(r_b/r_a), the pressure angle at the tip (rad)."""
        return math.acos(self.base_radius / self.tip_radius)

    @property
    def _edge_depth(self) -> float:
        """Of the centre of the rack's rounded tip below the pitch line (m)."""
        return (self.dedendum - self.profile_shift - self._edge) * self.module

    @property
    def _edge_offset(self) -> float:
        """Of that centre from the middle of the rack's space, in which the tooth is made (m)."""
        angle = math.radians(self.pressure_angle)
        straight = 0.25 * math.pi + (self.dedendum - self._edge) * math.tan(angle) + self._edge / math.cos(angle)
        return straight * self.module


def involute(gear: GearTeeth, angle):
    """The flank where its pressure angle is psi.

    Parameters
    ----------
    gear : GearTeeth
    angle : float or array
        psi (rad), from 0 on the base circle.

    Returns
    -------
    x, y : as `angle`
        Half thickness and height above the gear's centre (m).
    slope : as `angle`
        dy/d(tan psi) (m).
    force : as `angle`
        The angle tan psi - theta_b of the contact normal against x (rad).
    """
    roll = np.tan(angle)
    force = roll - gear.base_half_angle
    radius = gear.base_radius
    x = radius * (roll * np.cos(force) - np.sin(force))
    y = radius * (roll * np.sin(force) + np.cos(force))
    return x, y, radius * roll * np.cos(force), force


def fillet(gear: GearTeeth, angle):
    """The fillet where the rack's normal, through the pitch point, is inclined by gamma against the pitch line.

    Parameters
    ----------
    gear : GearTeeth
    angle : float or array
        gamma (rad), from the pressure angle, where the rack's flank goes over into its tip, to pi/2 at the root.

    Returns
    -------
    x, y : as `angle`
        Half thickness and height above the gear's centre (m).
    slope : as `angle`
        dy/d gamma (m), below 0.
    """
    radius, depth, sine = gear.pitch_radius, gear._edge_depth, np.sin(angle)
    turn = (depth / np.tan(angle) + gear._edge_offset) / radius
    reach = depth / sine + gear._edge * gear.module
    turn_slope, reach_slope = -depth / (radius * sine**2), -depth * np.cos(angle) / sine**2
    x = radius * np.sin(turn) - reach * np.cos(angle - turn)
    y = radius * np.cos(turn) - reach * np.sin(angle - turn)
    slope = (
        -radius * np.sin(turn) * turn_slope
        - reach_slope * np.sin(angle - turn)
        - reach * np.cos(angle - turn) * (1.0 - turn_slope)
    )
    return x, y, slope


def junction(gear: GearTeeth) -> tuple[float, float]:
    """Where flank and fillet meet: psi of the flank and gamma of the fillet (rad).

    The rack's flank ends there, or, of a tooth that it undercuts, the fillet crosses the involute.
    """
    angle = math.radians(gear.pressure_angle)
    straight = gear._edge_depth + gear._edge * gear.module * math.sin(angle)
    roll = math.tan(angle) - straight / (gear.base_radius * math.sin(angle))
    if roll >= 0.0:
        return math.atan(roll), angle
    # scipy.optimize takes 0.3 s to import, which every worker would pay.
    from scipy.optimize import brentq

    # Undercut: where the rack's flank ends, the fillet is outside the involute; on the base circle, inside it. If there
    # is so little that rounding hides it, as powers of the roll, they meet on the base circle.
    if _radius(gear, angle) <= gear.base_radius or _gap(gear, angle) <= 0.0:
        return 0.0, angle
    lowest = brentq(lambda one: _radius(gear, one) - gear.base_radius, angle, 0.5 * math.pi, xtol=1e-15)
    if _gap(gear, lowest) >= 0.0:
        return 0.0, angle
    crossing = brentq(lambda one: _gap(gear, one), angle, lowest, xtol=1e-15)
    return math.acos(min(gear.base_radius / _radius(gear, crossing), 1.0)), crossing


def _radius(gear: GearTeeth, angle):
    """Distance of the fillet from the gear's centre (m)."""
    x, y, _ = fillet(gear, angle)
    return np.hypot(x, y)


def _gap(gear: GearTeeth, angle):
    """By how much half the tooth's angle is larger at the fillet than at the involute (rad)."""
    x, y, _ = fillet(gear, angle)
    flank = np.arccos(np.minimum(gear.base_radius / _radius(gear, angle), 1.0))
    return np.arctan2(x, y) - gear.base_half_angle + involute_function(flank)


def involute_function(angle):
    """inv psi = tan psi - psi, of a number or an array (rad)."""
    return np.tan(angle) - angle
