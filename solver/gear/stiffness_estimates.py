"""Quick estimates of the mean mesh stiffness: ISO 6336-1 method B, and a rule of thumb of rotor dynamics."""

import math

from solver.gear.tooth_stiffness import ToothMesh
from solver.model.checks import ParameterError, instance_of

__all__ = ["iso_6336_stiffness", "thumb_stiffness"]

#: C_1 to C_9 of q' (mm um/N).
_SERIES = (0.04723, 0.15551, 0.25791, -0.00635, -0.11654, -0.00193, -0.24188, 0.00529, 0.00182)
#: C_M, what is measured over what is computed of solid teeth; and Young's modulus of the steel (Pa).
_MEASURED, _STEEL = 0.8, 206e9
_UNIT = 1e9  # N/(mm um) in N/m^2


def iso_6336_stiffness(mesh: ToothMesh) -> float:
    """Mean mesh stiffness of a spur pair of solid gears by ISO 6336-1, method B.

    c' = c'_th C_M C_R C_B with c'_th = 1/q', C_M = 0.8, C_R = 1 and
    C_B = (1 + 0.5 (1.2 - h_f)) (1 - 0.02 (20 - alpha)), times E/E_steel. The mean is
    c_gamma = c' (0.75 eps_alpha + 0.25).
    It holds for loads of at least 100 N on 1 mm of the width; teeth are softer under less.

    Parameters
    ----------
    mesh : ToothMesh
        With x_1 >= x_2, x_1 + x_2 from -0.5 to 2, and a contact ratio from 1.2 to 2.5.

    Returns
    -------
    float
        c_gamma times the face width (N/m).

    Raises
    ------
    ParameterError
        Naming what is outside the range of the method.
    """
    instance_of("mesh", mesh, ToothMesh)
    first, second = mesh.first, mesh.second
    one, other = first.profile_shift, second.profile_shift
    if one < other or not -0.5 <= one + other <= 2.0:
        raise ParameterError(
            "profile_shift", (one, other), "x_1 >= x_2 with a sum from -0.5 to 2, for which ISO 6336 has its series"
        )
    if not 1.2 <= mesh.contact_ratio <= 2.5:
        raise ParameterError(
            "addendum",
            first.addendum,
            f"one that gives a contact ratio from 1.2 to 2.5, as ISO 6336 wants, not {mesh.contact_ratio:.4g}",
        )
    terms = (
        1.0,
        1.0 / first.teeth,
        1.0 / second.teeth,
        one,
        one / first.teeth,
        other,
        other / second.teeth,
        one**2,
        other**2,
    )
    series = math.fsum(c * term for c, term in zip(_SERIES, terms, strict=True))
    dedendum = 0.5 * (first.dedendum + second.dedendum)
    rack = (1.0 + 0.5 * (1.2 - dedendum)) * (1.0 - 0.02 * (20.0 - first.pressure_angle))
    single = _MEASURED * rack / series * _elastic(mesh) / (0.5 * _STEEL)
    return _UNIT * single * (0.75 * mesh.contact_ratio + 0.25) * mesh.face_width


def thumb_stiffness(mesh: ToothMesh) -> float:
    """Mean mesh stiffness by a rule of thumb, eps_alpha B/9 E_1 E_2/(E_1 + E_2), whatever the shape of the teeth.

    Parameters
    ----------
    mesh : ToothMesh

    Returns
    -------
    float
        N/m.

    Raises
    ------
    ParameterError
        If it is no mesh.
    """
    instance_of("mesh", mesh, ToothMesh)
    return mesh.contact_ratio * mesh.face_width * _elastic(mesh) / 9.0


def _elastic(mesh: ToothMesh) -> float:
    """E_1 E_2/(E_1 + E_2) (Pa)."""
    one, other = mesh.first.youngs_modulus, mesh.second.youngs_modulus
    return one * other / (one + other)
