"""Mesh stiffness of a gear in physical units from the teeth of its drawing."""

from dataclasses import dataclass

from pipeline.config.units import quantity
from pipeline.errors import ConfigurationError, refused
from solver import GearTeeth, ParameterError, PitchCones, ToothMesh, bevel_mesh, iso_6336_stiffness

__all__ = ["METHODS", "DrawnMesh", "drawn_mesh"]

FROM_GEOMETRY, ISO_6336 = "from_geometry", "iso6336"
#: Words in place of a mesh stiffness.
METHODS = (FROM_GEOMETRY, ISO_6336)
_TOOTH = "gear.physical.tooth"


@dataclass(frozen=True)
class DrawnMesh:
    """What the teeth say of the mesh.

    Parameters
    ----------
    method : str
        Of `METHODS`.
    contact_ratio : float
    stiffness : float
        Mean (N/m).
    harmonics : list of (amplitude, phase) or None
        N/m and rad; None where the method has none.
    estimate : float or None
        The mean by ISO 6336 (N/m), where it holds.
    bodies_fit : (bool, bool)
        Whether the bodies are within the range for which their compliance was fitted.
    """

    method: str
    contact_ratio: float
    stiffness: float
    harmonics: list[tuple[float, float]] | None
    estimate: float | None
    bodies_fit: tuple[bool, bool]


def drawn_mesh(
    method: str, tooth, cones: PitchCones, pressure_angle: float, bores: list[float] | None, count: int
) -> DrawnMesh:
    """Compute or estimate the mesh stiffness.

    Parameters
    ----------
    method : str
        Of `METHODS`.
    tooth : pipeline.config.gear_schema.Teeth
    cones : PitchCones
    pressure_angle : float
        Degrees.
    bores : list of float or None
        Of the blanks (m), where `tooth` has none.
    count : int
        Harmonics.

    Raises
    ------
    ConfigurationError
        One line that names the key.
    """
    mesh = _mesh(tooth, cones, pressure_angle, bores)
    if method == ISO_6336:
        try:
            stiffness = iso_6336_stiffness(mesh)
        except ParameterError as error:
            raise ConfigurationError(f"{_TOOTH}.{error}") from None
        return DrawnMesh(method, mesh.contact_ratio, stiffness, None, stiffness, mesh.bodies_fit)
    try:
        harmonics = list(mesh.harmonics(count))
    except ParameterError as error:
        raise ConfigurationError(str(error).replace("count", "gear.physical.mesh_cycle_harmonics", 1)) from None
    try:
        estimate = iso_6336_stiffness(mesh)
    except ParameterError:
        estimate = None
    return DrawnMesh(method, mesh.contact_ratio, mesh.mean_stiffness, harmonics, estimate, mesh.bodies_fit)


def _mesh(tooth, cones: PitchCones, pressure_angle: float, bores: list[float] | None) -> ToothMesh:
    gears = []
    for place in range(2):
        given = {name: _one_of_two(tooth, name, place) for name in vars(tooth) if name != "bore"}
        given["youngs_modulus"] = quantity(f"{_TOOTH}.youngs_modulus", given["youngs_modulus"], "Young's modulus")
        try:
            gears.append(
                GearTeeth(
                    teeth=cones.teeth[place],
                    module=cones.module,
                    pressure_angle=pressure_angle,
                    bore=_bore(tooth, bores, place),
                    **given,
                )
            )
        except ParameterError as error:
            raise _named(error) from None
    try:
        return bevel_mesh(*gears, cones.shaft_angle, cones.face_width)
    except ParameterError as error:
        raise _named(error) from None


def _named(error: ParameterError) -> ConfigurationError:
    """With the key in place of the solver's name."""
    name = error.name.removeprefix("first.").removeprefix("second.")
    own = name in ("teeth", "module", "pressure_angle", "shaft_angle", "face_width")
    key = f"gear.physical.{name}" if own else f"{_TOOTH}.{name}"
    return ConfigurationError(f"{key}{str(error).removeprefix(error.name)}")


def _bore(tooth, bores: list[float] | None, place: int) -> float:
    if tooth.bore is None and bores is None:
        raise ConfigurationError(f"{_TOOTH}.bore has no value: give it, or gear.physical.blanks with a bore")
    if tooth.bore is None:
        return bores[place]
    return quantity(f"{_TOOTH}.bore", _one_of_two(tooth, "bore", place), "length")


def _one_of_two(tooth, name: str, place: int):
    value = getattr(tooth, name)
    if isinstance(value, list) and len(value) != 2:
        raise refused(f"{_TOOTH}.{name}", value, "one value or one per gear")
    return value[place] if isinstance(value, list) else value
