"""CF attributes: names and units of parameters, flags of enumerations and labels."""

__all__ = ["axis_attributes", "flags", "label_flags"]

LONG_NAMES = {
    "omega": "dimensionless mesh frequency",
    "b": "half backlash",
    "alpha": "mesh stiffness variation",
    "alpha_phase": "phase of the mesh stiffness variation",
    "f_e": "transmission error amplitude",
    "f_e_phase": "phase of the transmission error",
    "f_pm": "mean load",
    "f_pv": "fluctuating load",
    "kappa": "mesh stiffness referred to the masses",
    "xi_mesh": "mesh damping ratio",
    "mesh_damping": "mesh damping ratio",
    "xi_translation": "mesh damping referred to the masses",
    "xi_support": "support damping ratio",
    "k_support": "support stiffness",
    "pitch_cone_angle": "pitch cone angle",
    "pressure_angle": "normal pressure angle",
    "translation_coupling": "translation coupling",
    "rotation_coupling": "rotation coupling",
    "variation_translation": "share of the stiffness variation in the translation rows",
    "variation_rotation": "share of the stiffness variation in the mesh row",
    "temperature": "temperature difference between gears and housing",
    "gap": "half of the gap",
    "damping_ratio": "damping ratio",
    "mean_load": "mean load",
    "excitation": "factor on the excitation",
    "gap_scale": "factor on the gap",
    "contact_damping": "contact damping over contact stiffness",
    "damping": "factor on the damping",
    "stiffness": "factor on the stiffness",
}
UNITS = {
    "alpha_phase": "rad",
    "f_e_phase": "rad",
    "pitch_cone_angle": "degree",
    "pressure_angle": "degree",
    "temperature": "K",
}


def flags(members, labels=None) -> dict:
    """CF attributes of an enumeration."""
    return {
        "flag_values": [int(member) for member in members],
        "flag_meanings": " ".join(member.name.lower() for member in members),
        **({"labels": labels} if labels else {}),
    }


def label_flags(labels: dict[int, str]) -> dict:
    """CF attributes of codes of n/I labels; 0 is "not computed"."""
    return {
        "flag_values": [0, *labels],
        "flag_meanings": " ".join(["not_computed", *(_meaning(label) for label in labels.values())]),
        "labels": ["", *labels.values()],
    }


def _meaning(label: str) -> str:
    """An n/I label in the alphabet of CF flag meanings: 2/0-1 -> n2_I0-1."""
    n, states = label.split("/")
    return f"n{n}" if states == "-" else f"n{n}_I{states}"


def axis_attributes(name: str, kind: str = "bevel") -> dict:
    """Name and unit of a parameter; matrices of one's own have no mesh, and any consistent units."""
    own = kind == "system" and name == "omega"
    return {"long_name": "frequency of the excitation" if own else LONG_NAMES[name], "units": UNITS.get(name, "1")}
