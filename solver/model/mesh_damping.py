"""Mesh damping as one axis: xi_h and xi_hg together, in the ratio that the gear has.

One damper c_h between the teeth makes xi_h = c_h/(2 m_e Omega_n) and xi_hg = c_h/(2 m_g Omega_n) (docs/physics.md,
section 2), so that their ratio stays what it is when c_h changes: m_e/m_g = kappa_g with one mesh force for all rows.
"""

from solver.model.checks import ParameterError, finite_number
from solver.model.gear_model import Model
from solver.model.parameter_path import ParameterPath

__all__ = ["MESH_DAMPING"]


def _changes(model: Model, value: float) -> dict:
    finite_number("mesh_damping", value, at_least=0.0)
    if model.xi_mesh == 0.0:
        allowed = "above 0 where mesh_damping is an axis, which keeps its ratio to xi_translation"
        raise ParameterError("xi_mesh", 0.0, allowed)
    # At the gear's own value the factor is 1 exactly.
    factor = value / model.xi_mesh
    return {"xi_mesh": value, "xi_translation": tuple(xi * factor for xi in model.xi_translation)}


#: The axis; its value is xi_h.
MESH_DAMPING = ParameterPath("mesh_damping", _changes, ("xi_mesh", "xi_translation"))
