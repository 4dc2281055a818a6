"""How parameters are written in figures."""

from pipeline.config.physical import TEMPERATURE
from pipeline.config.quantities import Quantity
from pipeline.plan.numerics import frame_of, model_at
from pipeline.plan.plan import Plan
from pipeline.plane.resonances import mesh_shares
from pipeline.plane.stored import StoredPlane
from pipeline.run.sheets import number_text
from solver import ImpactState, Scales

__all__ = [
    "STATE_NAMES",
    "axis_label",
    "fixed_parameters",
    "gear_text",
    "mesh_energies",
    "quantity_text",
    "symbol",
    "value_text",
]

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


def quantity_text(quantity: Quantity) -> str:
    """A quantity of motions with its symbol."""
    return f"{quantity.label} ${quantity.symbol}$"


def axis_label(name: str, attributes: dict) -> str:
    """Name, symbol and unit, from the attributes that the store gives its axes."""
    return f"{attributes['long_name']} {symbol(name)}{_UNITS[attributes['units']]}"


def value_text(name: str, value: float, scales: Scales | None = None) -> str:
    """A parameter with its value, "$f_e$ = 0.126", and the physical one where there are scales, "(6.3 µm)"."""
    unit = " K" if name == TEMPERATURE else ""
    text = f"{symbol(name)} = {number_text(value, 4)}{unit}"
    if scales is None or name not in scales:
        return text
    return f"{text} ({number_text(value * scales[name].shown)} {scales[name].unit})"


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


#: What identifies a gear besides what `fixed_parameters` tells.
_OF_GEAR = (
    "translation_coupling",
    "rotation_coupling",
    "variation_translation",
    "variation_rotation",
    "kappa",
    "xi_mesh",
    "xi_translation",
    "xi_support",
    "k_support",
)


def gear_text(plan: Plan) -> str:
    """The numbers of a gear that its plane holds fixed, those of a reference reader's table of data."""
    model = frame_of(plan if plan.parameter2 is None else plan.layer(0))[0]
    values = {**plan.gear, "translation_coupling": model.sigma, "rotation_coupling": model.rotation}
    axes = {axis.name for axis in plan.axes}
    texts = [
        f"{symbol(name)} = {_numbers(values.get(name, getattr(model, name)))}" for name in _OF_GEAR if name not in axes
    ]
    return "gear:  " + ",  ".join(texts)


def _numbers(value) -> str:
    """One number; several if they differ."""
    if isinstance(value, int | float):
        return f"{value:.4g}"
    numbers = list(dict.fromkeys(f"{number:.4g}" for number in value))
    return numbers[0] if len(numbers) == 1 else "\u2026".join((min(numbers, key=float), max(numbers, key=float)))


def mesh_energies(plane: StoredPlane) -> tuple[str, str]:
    """The lower and the upper mode by their share of strain energy in the mesh, as "46 % mesh" or "44–46 % mesh"."""
    models = [model_at(plane.plan, value, plane.plan.sweep.low) for value in plane.rows[[0, -1]]]
    texts = []
    for shares in zip(*(mesh_shares(model) for model in models), strict=True):
        low, high = sorted(f"{100.0 * share:.0f}" for share in shares)
        texts.append(f"{low} % mesh" if low == high else f"{low}\u2013{high} % mesh")
    return texts[0], texts[1]
