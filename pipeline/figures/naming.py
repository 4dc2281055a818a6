"""How parameters are written in figures."""

from itertools import zip_longest

from pipeline.config.physical import TEMPERATURE
from pipeline.config.quantities import Quantity
from pipeline.plan.kinds import kind_of
from pipeline.plan.numerics import System, frame_of, row_system
from pipeline.plan.plan import Plan
from pipeline.plan.traits import excitation_harmonics
from pipeline.plane.resonances import contact_modes
from pipeline.plane.stored import StoredPlane
from pipeline.run.sheets import number_text
from solver import ContactSystem, ImpactState, Model, Scales

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
    "gap": "b",
    "damping_ratio": r"\zeta",
    "mean_load": "F_m",
    "excitation": "s_e",
    "gap_scale": "s_b",
    "contact_damping": r"\tau_c",
    "damping": "s_C",
    "stiffness": "s_K",
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
    axes, start = {axis.name for axis in plan.axes}, frame_of(plan if plan.parameter2 is None else plan.layer(0))[0]
    values = {"omega": plan.omega, **_told_first(start, plan)}
    shown = ",  ".join(value_text(k, v, scales) for k, v in values.items() if k not in axes and v is not None)
    return shown if plan.thermal is None else f"at {value_text(TEMPERATURE, 0.0)}:  {shown}"


def _told_first(system: System, plan: Plan) -> dict[str, float]:
    """Parameter -> value, of those that a reader asks for first."""
    if isinstance(system, Model):
        values = {"b": system.b, "alpha": system.alpha, "f_e": system.f_e, "f_pm": system.f_pm}
        return values | ({"f_pv": system.f_pv} if system.f_pv else {})
    values = {name: plan.gear[name] for name in kind_of(plan).axes if name in plan.gear}
    still = values.get("alpha", 1.0) == 0.0
    # What is not there needs no number.
    silent = {"contact_damping", *(("alpha", "alpha_phase") if still else ())}
    return {name: value for name, value in values.items() if value or name not in silent}


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
    system = frame_of(plan if plan.parameter2 is None else plan.layer(0))[0]
    return _bevel_text(system, plan) if isinstance(system, Model) else _system_text(system, plan)


def _bevel_text(model: Model, plan: Plan) -> str:
    values = {**plan.gear, "translation_coupling": model.sigma, "rotation_coupling": model.rotation}
    axes = {axis.name for axis in plan.axes}
    texts = [
        f"{symbol(name)} = {_numbers(values.get(name, getattr(model, name)))}" for name in _OF_GEAR if name not in axes
    ]
    return "gear:  " + ",  ".join(texts)


def _system_text(system: ContactSystem, plan: Plan) -> str:
    kind = kind_of(plan)
    harmonics = {
        r"$\alpha_{2\ldots}$": system.stiffness_harmonics[1:],
        f"{kind.drives} $1\\ldots$": excitation_harmonics(system),
    }
    size = f"{system.degrees} degree{'s' * (system.degrees > 1)} of freedom"
    texts = [f"{name} = {', '.join(f'{a:.4g}' for a, _ in pairs)}" for name, pairs in harmonics.items() if pairs]
    return f"{kind.name}:  " + ",  ".join([size, *texts])


def _numbers(value) -> str:
    """One number; several if they differ."""
    if isinstance(value, int | float):
        return f"{value:.4g}"
    numbers = list(dict.fromkeys(f"{number:.4g}" for number in value))
    return numbers[0] if len(numbers) == 1 else "\u2026".join((min(numbers, key=float), max(numbers, key=float)))


def mesh_energies(plane: StoredPlane) -> tuple[str, ...]:
    """The modes, ascending, by their share of strain energy in the mesh, as "46 % mesh" or "44–46 % mesh"."""
    modes = [contact_modes(row_system(plane.plan, value)) for value in plane.rows[[0, -1]]]
    texts = []
    for ends in zip_longest(*modes):
        low, high = (f"{end(100.0 * mode[1] for mode in filter(None, ends)):.0f}" for end in (min, max))
        texts.append(f"{low} % mesh" if low == high else f"{low}\u2013{high} % mesh")
    return tuple(texts)
