"""Mesh stiffness over the mesh cycle from the geometry of the teeth, by the potential energy under the contact force.

Yang and Lin (1987) for bending and compression, Tian (2004) for shear, Sainsot, Velex and Duverger (2004) for the body
under the tooth, Hertz for the contact (docs/physics.md, section 11).
"""

import dataclasses
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from solver.gear.pitch_cones import PitchCones
from solver.gear.teeth import GearTeeth, fillet, involute, involute_function, junction
from solver.model.checks import ParameterError, finite_array, finite_number, instance_of, whole_number
from solver.model.gear_model import Harmonics

__all__ = ["Compliance", "ToothMesh", "bevel_mesh", "body_compliance", "tooth_compliance"]

#: Shear energy of a rectangular section, over that of an even shear stress.
_SHEAR = 1.2
#: Sainsot's fit, rows L, M, P, Q, columns of 1/theta^2, h^2, h/theta, 1/theta, h, 1.
_BODY = np.array(
    [
        [-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045],
        [60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086],
        [-50.952e-5, 185.50e-3, 0.0538e-4, 53.300e-3, 0.2895, 0.9236],
        [-6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904],
    ]
)
#: Where the fit was made: h = r_f/r_bore, and theta_f (rad).
_BODY_RATIOS, _BODY_ANGLES = (1.4, 7.0), (0.01, 0.12)
#: Gauss-Legendre points: along fillet or flank, and along the path of contact.
_ALONG_TOOTH, _ALONG_PATH = 40, 60


@dataclass(frozen=True)
class Compliance:
    """Displacements along the line of action under a unit force on a unit width, times Young's modulus.

    Parameters
    ----------
    bending, shear, compression, body : array
        Of the tooth as a beam, and of the body under it; without unit.
    """

    bending: np.ndarray
    shear: np.ndarray
    compression: np.ndarray
    body: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """Their sum."""
        return self.bending + self.shear + self.compression + self.body


def tooth_compliance(gear: GearTeeth, angle) -> Compliance:
    """What one tooth gives way where the pressure angle of its contact point is psi.

    Parameters
    ----------
    gear : GearTeeth
    angle : (n,) array
        psi (rad), on the flank.

    Raises
    ------
    ParameterError
        If a point is not on the flank.
    """
    instance_of("gear", gear, GearTeeth)
    angle = finite_array("angle", angle, (None,))
    lowest, fillet_top = junction(gear)
    outside = angle[(angle < lowest - 1e-12) | (angle > gear.tip_angle + 1e-12)]
    if outside.size:
        raise ParameterError("angle", float(outside[0]), f"on the flank, from {lowest:.6g} to {gear.tip_angle:.6g} rad")
    nodes, weights = np.polynomial.legendre.leggauss(_ALONG_TOOTH)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    # Sections of the fillet, the same for every contact point, then those of the flank below it.
    x, y, slope = fillet(gear, fillet_top + (0.5 * math.pi - fillet_top) * nodes)
    heights = -slope * weights * (0.5 * math.pi - fillet_top)
    rolls = np.tan(lowest) + np.outer(np.tan(angle) - np.tan(lowest), nodes)
    flank_x, flank_y, flank_slope, _ = involute(gear, np.arctan(rolls))
    flank_heights = flank_slope * weights * (np.tan(angle) - np.tan(lowest))[:, None]
    shape = (angle.size, nodes.size)
    x, y, heights = (
        np.hstack([np.broadcast_to(same, shape), flank])
        for same, flank in ((x, flank_x), (y, flank_y), (heights, flank_heights))
    )
    contact_x, contact_y, _, force = involute(gear, angle)
    across, along = np.cos(force), np.sin(force)
    moment = across[:, None] * (contact_y[:, None] - y) - (along * contact_x)[:, None]
    over_area = np.sum(heights / (2.0 * x), axis=1)
    return Compliance(
        bending=np.sum(moment**2 * heights / (2.0 / 3.0 * x**3), axis=1),
        shear=_SHEAR * 2.0 * (1.0 + gear.poisson) * across**2 * over_area,
        compression=along**2 * over_area,
        body=body_compliance(
            force,
            contact_y - contact_x * np.tan(force) - gear.root_radius,
            gear.root_radius,
            gear.root_half_angle,
            gear.bore,
        ),
    )


def body_compliance(force, lever, root_radius: float, root_half_angle: float, bore: float):
    """What the body under a tooth gives way, times Young's modulus (Sainsot, Velex and Duverger 2004).

    Parameters
    ----------
    force : float or array
        Angle of the force against the tooth's width (rad).
    lever : float or array
        u, from the root circle to where the line of action meets the centre line of the tooth (m).
    root_radius, root_half_angle, bore : float
        r_f (m), theta_f (rad) and the diameter of the bore (m); r_f/r_bore and theta_f are taken at the nearest end of
        the range of the fit where they are outside.
    """
    ratio, angle = np.clip(root_radius / (0.5 * bore), *_BODY_RATIOS), np.clip(root_half_angle, *_BODY_ANGLES)
    l, m, p, q = _BODY @ [angle**-2, ratio**2, ratio / angle, 1.0 / angle, ratio, 1.0]
    share = lever / (2.0 * root_radius * root_half_angle)
    return np.cos(force) ** 2 * (l * share**2 + m * share + p * (1.0 + q * np.tan(force) ** 2))


@dataclass(frozen=True)
class ToothMesh:
    """A pair of spur gears without backlash, and the stiffness of their mesh along the line of action.

    Gear 1 drives. Phase 0 of the mesh cycle is where a pair of teeth comes into contact, at the root of gear 1. Pairs
    of teeth act side by side, each with bodies of its own, as is usual: what one pair twists the bodies is not felt by
    the other. Shafts and bearings are rigid.

    Parameters
    ----------
    first, second : GearTeeth
        Of one module and pressure angle.
    face_width : float
        Of the contact (m), > 0.

    Raises
    ------
    ParameterError
        Naming the field, its value and what is allowed: teeth that do not mesh, or lose contact, are refused.
    """

    first: GearTeeth
    second: GearTeeth
    face_width: float

    def __post_init__(self):
        for name in ("first", "second"):
            instance_of(name, getattr(self, name), GearTeeth)
        object.__setattr__(self, "face_width", finite_number("face_width", self.face_width, above=0.0))
        for name in ("module", "pressure_angle"):
            one, other = getattr(self.first, name), getattr(self.second, name)
            if not math.isclose(one, other, rel_tol=1e-9):
                raise ParameterError(f"second.{name}", other, f"that of the first gear, {one:g}")
        if self._involute_of_mesh < 0.0:
            raise ParameterError("profile_shift", self._shifts, "larger in sum: no centre distance is that small")
        for one, other in ((self.first, self.second), (self.second, self.first)):
            if one.tip_radius + other.root_radius > self.centre_distance:
                raise ParameterError(
                    "addendum", one.addendum, "so small that the tip clears the root circle of the other gear"
                )
        if self.contact_ratio < 1.0:
            raise ParameterError(
                "addendum",
                self.first.addendum,
                f"so large that a pair of teeth is always in contact: the contact ratio is {self.contact_ratio:.4g}",
            )

    @property
    def _shifts(self) -> tuple[float, float]:
        return self.first.profile_shift, self.second.profile_shift

    @property
    def _involute_of_mesh(self) -> float:
        angle = math.radians(self.first.pressure_angle)
        teeth = self.first.teeth + self.second.teeth
        return float(involute_function(angle)) + 2.0 * math.tan(angle) * sum(self._shifts) / teeth

    @cached_property
    def working_angle(self) -> float:
        """alpha_w of the mesh (rad): inv alpha_w = inv alpha + 2 tan alpha (x_1 + x_2)/(z_1 + z_2)."""
        if sum(self._shifts) == 0.0:
            return math.radians(self.first.pressure_angle)
        # As in `junction`, not to be paid by every worker.
        from scipy.optimize import brentq

        return brentq(lambda angle: involute_function(angle) - self._involute_of_mesh, 0.0, 1.5, xtol=1e-15)

    @property
    def centre_distance(self) -> float:
        """(r_b1 + r_b2)/cos alpha_w (m), where both flanks touch."""
        return (self.first.base_radius + self.second.base_radius) / math.cos(self.working_angle)

    @property
    def base_pitch(self) -> float:
        """p_b = pi m cos alpha (m), between neighbouring contact points along the line of action."""
        return math.pi * self.first.module * math.cos(math.radians(self.first.pressure_angle))

    @cached_property
    def path(self) -> tuple[float, float]:
        """Length of the path of contact before and after the pitch point (m).

        It ends at the tip of one gear, or before, where the flank of the other ends in an undercut.
        """
        return self._reach(self.second, self.first), self._reach(self.first, self.second)

    def _reach(self, tip: GearTeeth, root: GearTeeth) -> float:
        tangent, (lowest, _) = math.tan(self.working_angle), junction(root)
        at_tip = tip.base_radius * (math.tan(tip.tip_angle) - tangent)
        return min(at_tip, root.base_radius * (tangent - math.tan(lowest)))

    @property
    def contact_ratio(self) -> float:
        """eps_alpha, the mean number of pairs in contact."""
        return sum(self.path) / self.base_pitch

    @property
    def hertz_stiffness(self) -> float:
        """Of one contact (N/m): pi B/(2 sum_g (1 - nu_g^2)/E_g), which is pi E B/(4 (1 - nu^2)) of equal materials."""
        return 0.5 * math.pi * self.face_width / sum((1.0 - g.poisson**2) / g.youngs_modulus for g in self._gears)

    @property
    def _gears(self) -> tuple[GearTeeth, GearTeeth]:
        return self.first, self.second

    @property
    def bodies_fit(self) -> tuple[bool, bool]:
        """Whether the body of each gear is within the range for which its compliance was fitted."""
        return tuple(
            _BODY_RATIOS[0] <= 2.0 * gear.root_radius / gear.bore <= _BODY_RATIOS[1]
            and _BODY_ANGLES[0] <= gear.root_half_angle <= _BODY_ANGLES[1]
            for gear in self._gears
        )

    def pair_stiffness(self, place) -> np.ndarray:
        """Stiffness of one pair of teeth.

        Parameters
        ----------
        place : (n,) array
            Of its contact point along the line of action (m), from 0, where the contact begins, to the end of the path.

        Returns
        -------
        (n,) array
            N/m.

        Raises
        ------
        ParameterError
            If a place is not on the path.
        """
        place, length = finite_array("place", place, (None,)), sum(self.path)
        if np.any((place < 0.0) | (place > length * (1.0 + 1e-12))):
            raise ParameterError("place", float(place.max()), f"on the path of contact, from 0 to {length:.6g} m")
        from_pitch = np.minimum(place, length) - self.path[0]
        compliance = 1.0 / self.hertz_stiffness
        for gear, sign in zip(self._gears, (1.0, -1.0), strict=True):
            roll = math.tan(self.working_angle) + sign * from_pitch / gear.base_radius
            tooth = tooth_compliance(gear, np.arctan(np.maximum(roll, 0.0))).total
            compliance = compliance + tooth / (gear.youngs_modulus * self.face_width)
        return 1.0 / compliance

    def stiffness(self, phase) -> np.ndarray:
        """Stiffness of the mesh over the mesh cycle: of all pairs that are in contact.

        Parameters
        ----------
        phase : (n,) array
            rad; of any cycle.

        Returns
        -------
        (n,) array
            N/m, with a jump where a pair enters or leaves.

        Raises
        ------
        ParameterError
            If it is no array of finite numbers.
        """
        first = np.mod(finite_array("phase", phase, (None,)) / (2.0 * math.pi), 1.0) * self.base_pitch
        total, length = np.zeros(first.size), sum(self.path)
        for pair in range(math.ceil(self.contact_ratio)):
            place = first + pair * self.base_pitch
            inside = place <= length
            total[inside] += self.pair_stiffness(place[inside])
        return total

    @property
    def mean_stiffness(self) -> float:
        """Mean over the mesh cycle (N/m)."""
        return float(self.coefficients(0)[0].real)

    def harmonics(self, count: int) -> Harmonics:
        """Amplitudes (N/m) and phases (rad) of harmonics 1 to `count` of the mesh cycle, as `GearPair` takes them.

        Parameters
        ----------
        count : int
            From 0 to 100.

        Raises
        ------
        ParameterError
            If it is something else.
        """
        return tuple((2.0 * abs(c), math.atan2(c.imag, c.real)) for c in self.coefficients(count)[1:].tolist())

    def coefficients(self, count: int) -> np.ndarray:
        """Fourier coefficients c_0 to c_count of sum_l c_l exp(i l phase), the mesh cycle (N/m).

        A sum over pairs is a sum over the periods of one pair, so that
        c_l = (1/p_b) int k(s) exp(-2 pi i l s/p_b) ds over the whole path of one pair, whose stiffness k has no jump.

        Parameters
        ----------
        count : int
            From 0 to 100.

        Raises
        ------
        ParameterError
            If it is something else.
        """
        count = whole_number("count", count, 0, 100)
        length, points = sum(self.path), _ALONG_PATH + 4 * count
        nodes, weights = np.polynomial.legendre.leggauss(points)
        place = 0.5 * length * (nodes + 1.0)
        waves = np.exp(-2.0j * math.pi * np.outer(np.arange(count + 1), place / self.base_pitch))
        return waves @ (0.5 * length * weights * self.pair_stiffness(place)) / self.base_pitch


def bevel_mesh(first: GearTeeth, second: GearTeeth, shaft_angle: float, face_width: float) -> ToothMesh:
    """The virtual spur gears of a straight bevel pair (Tredgold): back cones at mid face, rolled out.

    Teeth and body taper towards the common apex, so that all sections are similar and have the same stiffness of a unit
    width. A rotation moves the section at the cone distance R by a displacement that grows as R, and its force has a
    lever that does. The stiffness that belongs to the radius R_m at mid face is hence the integral of
    k' (R/R_m)^2, as of a spur pair of the width B (1 + B^2/(12 R_m^2)).

    Parameters
    ----------
    first, second : GearTeeth
        Pinion and wheel as drawn: whole teeth, outer transverse module, and the bore at mid face.
    shaft_angle : float
        Between the shafts (degrees), from above 0 to below 180; neither pitch cone may reach 90 degrees.
    face_width : float
        B (m), > 0 and at most the cone distance.

    Returns
    -------
    ToothMesh
        Of z_g/cos delta_g teeth, with the module at mid face and bores over cos delta_g.

    Raises
    ------
    ParameterError
        Naming the parameter, its value and what is allowed.
    """
    for name, gear in (("first", first), ("second", second)):
        instance_of(name, gear, GearTeeth)
        if not gear.teeth.is_integer():
            raise ParameterError(f"{name}.teeth", gear.teeth, "a whole number of a gear that can be made")
    cones = PitchCones((int(first.teeth), int(second.teeth)), first.module, shaft_angle, face_width)
    mean = cones.cone_distance - 0.5 * cones.face_width
    virtual = []
    for gear, angle in zip((first, second), cones.cone_angles, strict=True):
        if angle >= 89.0:
            raise ParameterError(
                "shaft_angle", shaft_angle, f"so small that no pitch cone angle is {angle:.4g} degrees"
            )
        cosine = math.cos(math.radians(angle))
        virtual.append(
            dataclasses.replace(
                gear,
                teeth=gear.teeth / cosine,
                module=gear.module * mean / cones.cone_distance,
                bore=gear.bore / cosine,
            )
        )
    width = cones.face_width * (1.0 + cones.face_width**2 / (12.0 * mean**2))
    return ToothMesh(*virtual, face_width=width)
