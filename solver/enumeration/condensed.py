"""The condensed balance of any system at many values of an axis, enclosed; or why nothing can be proven about it."""

import numpy as np

from solver.enumeration.coefficients import enclose_gear
from solver.enumeration.enclosed import SLOTS
from solver.enumeration.system_coefficients import FREE_MEAN, HELD_AND_MODULATED, PULLED, enclose_system
from solver.model.checks import ParameterError
from solver.model.contact_system import ContactSystem
from solver.model.gear_model import Model
from solver.model.packing import axis_vectors, packed

__all__ = ["UnprovableError", "condensed_over"]


class UnprovableError(ParameterError):
    """Nothing can be proven about the first-order solutions of such a system; the message says why."""


#: By what `enclose_system` returns: a parameter and what is allowed of it.
_REFUSED = {
    HELD_AND_MODULATED: (
        "stiffness_harmonics",
        "0 in the first harmonic for a proof, where the stiffness matrix holds lambda without the contact",
    ),
    PULLED: ("stiffness", "such that a steady force at the contact moves lambda against it, for a proof"),
    FREE_MEAN: ("load", "such that its mean presses the one flank together, where nothing else holds lambda"),
}


def condensed_over(system: Model | ContactSystem, axis: str, values: np.ndarray, omega: float | None) -> np.ndarray:
    """The condensed balance as intervals; what is given has been checked.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
    values : (X,) array
        Of the axis.
    omega : float or None
        The frequency; needed unless it is the axis.

    Returns
    -------
    (X, SLOTS, 2) array
        See `solver.enumeration.enclosed`.

    Raises
    ------
    UnprovableError
        If nothing can be proven about such a system.
    """
    enclosed = np.empty((values.size, SLOTS, 2))
    if isinstance(system, Model):
        enclose_gear(*axis_vectors(system, axis, omega), values, enclosed)
        return enclosed
    if system.cubic != 0.0:
        raise UnprovableError("cubic", system.cubic, "0 for a proof")
    refused = enclose_system(*packed(system, axis, omega, 1, 1), values, enclosed)
    if refused:
        name, allowed = _REFUSED[refused]
        raise UnprovableError(name, getattr(system, name), allowed)
    return enclosed
