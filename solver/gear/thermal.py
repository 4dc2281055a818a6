"""A gear pair at another temperature, seen on the scales of the reference temperature.

Frequencies stay referred to Omega_n of the reference and lengths to its b_c, so that a plane over temperature has one
axis Omega = Omega_h/Omega_n. With the ratios mu = k_m(T)/k_m(T_0) and nu = c_h(T)/c_h(T_0) the equations of
docs/physics.md, section 2, keep their form, and their numbers become

    kappa_g mu,    c mu,    xi_h nu/mu,    xi_hg nu,    b_h(T)/b_c,

everything else as it was: the force c k_r f is proportional to k_m and 2 c xi_h lambda' to c_h alone, f_pm is
a3 T_1/(r_1 k_m(T_0) b_c), and the stiffness harmonics are relative to k_m. Supports keep their stiffness and damping.

The axis is the temperature difference D = T_gears - T_housing in K. The housing follows the gears by a share s of their
rise, T_housing - T_0 = s (T_gears - T_0), so that T_gears = T_0 + D/(1 - s). At D = 0 every number is the
reference's own, to the bit.
"""

from dataclasses import dataclass

from solver.gear.thermal_laws import Law, Temperatures
from solver.model.checks import ParameterError, finite_number
from solver.model.gear_model import Model
from solver.model.parameter_path import ParameterPath

__all__ = ["ThermalPair"]

# What is changed, and what the rotation coupling may have been derived from.
_USES = ("b", "kappa", "rotation_coupling", "xi_mesh", "xi_translation", "pressure_angle")
_HALVINGS = 60


@dataclass(frozen=True)
class ThermalPair:
    """How a gear pair depends on temperature.

    Parameters
    ----------
    length : float
        b_c in m, > 0.
    reference : float
        T_0, degrees Celsius: gears and housing in the state that the model's numbers describe.
    housing_share : float
        s, at least 0 and below 1.
    backlash, stiffness, damping : Law

    Raises
    ------
    ParameterError
        Naming the parameter, its value and what is allowed.
    """

    length: float
    reference: float
    housing_share: float
    backlash: Law
    stiffness: Law
    damping: Law

    def __post_init__(self):
        finite_number("length", self.length, above=0.0)
        finite_number("reference", self.reference)
        if not 0.0 <= self.housing_share < 1.0:
            raise ParameterError("housing_share", self.housing_share, "at least 0 and below 1")
        self._check(0.0, "reference", self.reference)

    @property
    def path(self) -> ParameterPath:
        """The axis `temperature`."""
        return ParameterPath("temperature", self.changes, _USES, self._knots, ("b",))

    def temperatures(self, difference: float) -> Temperatures:
        """The temperatures at one difference between gears and housing."""
        rise = difference / (1.0 - self.housing_share)
        return Temperatures(self.reference + rise, self.reference + self.housing_share * rise, self.reference)

    def half_backlash(self, model: Model, difference: float) -> float:
        """b_h(T)/b_c; below 0 the gears would have jammed."""
        return model.b + self.backlash.value(self.temperatures(difference)) / self.length

    def changes(self, model: Model, difference: float) -> dict:
        """What `Model.replace` needs to take the model of the reference to a temperature difference.

        Raises
        ------
        ParameterError
            If a law does not hold there, or the gears jam.
        """
        self._check(difference, "temperature", difference)
        b = self.half_backlash(model, difference)
        if b < 0.0:
            side = "below" if difference > 0.0 else "above"
            limit = f"{side} {self._jam(model, difference):.6g} K, where the backlash is used up and the gears jam"
            raise ParameterError("temperature", difference, limit)
        at = self.temperatures(difference)
        mu, nu = self.stiffness.value(at), self.damping.value(at)
        return {
            "b": b,
            "kappa": tuple(kappa * mu for kappa in model.kappa),
            "rotation_coupling": model.rotation * mu,
            "xi_mesh": model.xi_mesh * nu / mu,
            "xi_translation": tuple(xi * nu for xi in model.xi_translation),
        }

    def _check(self, difference: float, name: str, value: float) -> None:
        at = self.temperatures(difference)
        for role in ("backlash", "stiffness", "damping"):
            law = getattr(self, role)
            low, high = law.valid
            for felt in law.felt(at):
                # A law that is given at its own ends holds there, whatever rounding says.
                if not low - 1e-9 <= felt <= high + 1e-9:
                    allowed = f"such that the law of {role} holds: it is for {low:g} to {high:g}, not for {felt:.6g}"
                    raise ParameterError(name, value, allowed)

    def _jam(self, model: Model, difference: float) -> float:
        """The difference nearest to 0 on the way to a jam, at which the backlash is used up."""
        steps = [difference * i / 256 for i in range(257)]
        jammed = next(i for i, step in enumerate(steps) if self.half_backlash(model, step) < 0.0)
        free, stuck = steps[max(jammed - 1, 0)], steps[jammed]
        for _ in range(_HALVINGS):
            middle = 0.5 * (free + stuck)
            if self.half_backlash(model, middle) < 0.0:
                stuck = middle
            else:
                free = middle
        return stuck

    @property
    def _knots(self) -> tuple[float, ...]:
        """Differences at which a law is not smooth."""
        gears = [knot for law in (self.stiffness, self.damping) for knot in law.knots]
        return (*self.backlash.knots, *((knot - self.reference) * (1.0 - self.housing_share) for knot in gears))
