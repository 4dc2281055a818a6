"""How parameters are written in figures."""

from pipeline.config.physical import TEMPERATURE
from pipeline.plan.numerics import frame_of
from pipeline.plan.plan import Plan
from solver import ImpactState, Scales

__all__ = ["STATE_NAMES", "axis_label", "fixed_parameters", "symbol", "value_text"]

_SYMBOLS = {
    "omega": r"\Omega",
    "b": "b",
    "alpha": r"\alpha",
    "alpha_phase": r"\Phi_k",
    "f_e": "f_e",
    "f_e_phase": r"\Phi",
    "f_pm": "f_{pm}",
    "f_pv": "f_{pv}",
    "kappa": r"\kappa_g",
    "xi_mesh": r"\xi_h",
    "mesh_damping": r"\xi_h",
    "xi_translation": r"\xi_{hg}",
    "xi_support": r"\xi_j",
    "k_support": "k_j",
    "pitch_cone_angle": r"\delta_1",
    "pressure_angle": r"\alpha_n",
    "translation_coupling": r"\sigma",
    "rotation_coupling": "c",
    "variation_translation": r"\varepsilon_t",
    "variation_rotation": r"\varepsilon_r",
    "temperature": r"\Delta T",
}
_UNITS = {"1": "", "rad": " (rad)", "degree": " (°)", "K": " (K)"}

STATE_NAMES = {
    ImpactState.PERMANENT: "no impact",
    ImpactState.SINGLE_SIDED: "single-sided",
    ImpactState.DOUBLE_SIDED: "double-sided",
    ImpactState.FREE: "no contact",
    ImpactState.MIRRORED_SINGLE_SIDED: "single-sided, back",
    ImpactState.MIRRORED_PERMANENT: "no impact, back",
}


def symbol(name: str) -> str:
    """The article's symbol of a parameter, as mathematical text."""
    return f"${_SYMBOLS[name]}$"


def axis_label(name: str, attributes: dict) -> str:
    """Name, symbol and unit, from the attributes that the store gives its axes."""
    return f"{attributes['long_name']} {symbol(name)}{_UNITS[attributes['units']]}"


def value_text(name: str, value: float, scales: Scales | None = None) -> str:
    """A parameter with its value, "$f_e$ = 0.126", and the physical one where there are scales, "(6.3 µm)"."""
    unit = " K" if name == TEMPERATURE else ""
    text = f"{symbol(name)} = {value:.4g}{unit}".replace("-", "\N{MINUS SIGN}")
    if scales is None or name not in scales:
        return text
    return f"{text} ({value * scales[name].shown:.3g} {scales[name].unit})"


def fixed_parameters(plan: Plan, scales: Scales | None = None) -> str:
    """The parameters that a reader asks for first, as far as the plane holds them fixed; over temperature, those of the
    reference."""
    model = frame_of(plan if plan.parameter2 is None else plan.layer(0))[0]
    values = {"omega": plan.omega, "b": model.b, "alpha": model.alpha, "f_e": model.f_e, "f_pm": model.f_pm}
    if model.f_pv:
        values["f_pv"] = model.f_pv
    axes = {axis.name for axis in plan.axes}
    shown = ",  ".join(value_text(k, v, scales) for k, v in values.items() if k not in axes and v is not None)
    return shown if plan.thermal is None else f"at {value_text(TEMPERATURE, 0.0)}:  {shown}"
