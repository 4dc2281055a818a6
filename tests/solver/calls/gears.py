"""Wrong calls of models, gears in SI units, contact systems and labels."""

import numpy as np

from solver import Scales
from tests.public import COUNT, NAME, NOT_NEGATIVE, NUMBER, OBJECT, POSITIVE, argument, array, optional
from tests.solver.calls.subjects import GEAR, GRID, PAIR, ROTOR, TEETH, model, pair, stop, teeth, tooth_mesh


def gear_arguments() -> dict:
    plain = of("alpha f_e f_pm alpha_phase f_e_phase f_pv variation_translation variation_rotation", NUMBER, GEAR)
    above = of("b xi_mesh", NOT_NEGATIVE, GEAR)
    two = of("kappa", gears(2, POSITIVE), GEAR) | of("xi_translation", gears(2, NOT_NEGATIVE), GEAR)
    six = of("k_support", gears(6, POSITIVE), GEAR) | of("xi_support", gears(6, NOT_NEGATIVE), GEAR)
    angles = of("pitch_cone_angle", (*NOT_NEGATIVE, 180.0), GEAR) | of("pressure_angle", (*NOT_NEGATIVE, 90.0), GEAR)
    couplings = of("translation_coupling", (*NOT_NEGATIVE, "foo"), GEAR) | of("rotation_coupling", POSITIVE, GEAR)
    further = {name: harmonics() for name in ("alpha_harmonics", "f_e_harmonics")}
    return plain | above | two | six | angles | couplings | further


def pair_arguments() -> dict:
    above = of("module mesh_stiffness", POSITIVE, PAIR) | of("face_width", (*POSITIVE, 1.0), PAIR)
    angles = of("shaft_angle", (*POSITIVE, 180.0), PAIR) | of("pressure_angle", (*NOT_NEGATIVE, 90.0), PAIR)
    least = of("mesh_damping_ratio", NOT_NEGATIVE, PAIR)
    least |= {"half_backlash": argument(5e-5, (*NOT_NEGATIVE, 0.0), "reference_length")}
    two = of("mass inertia", gears(2, POSITIVE), PAIR)
    six = of("support_stiffness", gears(6, POSITIVE), PAIR) | of("support_damping", gears(6, NOT_NEGATIVE), PAIR)
    given = {"reference_length": argument(None, optional(POSITIVE)), "load_torque": argument(None, optional(NUMBER))}
    teeth = (None, 20, "ab", {}, (20,), (20, 30, 40), (20.0, 30), (0, 30), (-20, 30), (True, 30), (None, 30))
    series = {"mesh_stiffness_harmonics": harmonics(((2e7, 0.0),)), "error_harmonics": harmonics()}
    loads = of("torque torque_fluctuation", NUMBER, PAIR)
    return above | angles | least | two | six | given | series | loads | {"teeth": argument((20, 30), teeth)}


def rotor_arguments() -> dict:
    above = of("mesh_stiffness", POSITIVE, ROTOR) | of("mesh_damping half_backlash", NOT_NEGATIVE, ROTOR)
    two = of("inertia base_radius mass support_stiffness", gears(2, POSITIVE), ROTOR)
    two |= of("far_inertia shaft_stiffness", gears(2, POSITIVE), ROTOR)
    two |= of("support_damping shaft_damping", gears(2, NOT_NEGATIVE), ROTOR)
    series = {f"{name}_harmonics": harmonics() for name in ("stiffness", "error", "torque")}
    return above | two | series | of("torque", NUMBER, ROTOR)


def gears(count: int, wrong: tuple) -> tuple:
    """What is wrong for one number or so many."""
    numbers = [value for value in wrong if not isinstance(value, list | dict)]
    several = [[1.0] * (count - 1), [1.0] * (count + 1), [1.0] * (count - 1) + [wrong[-1]], np.ones((count, 1))]
    return (*numbers, *several, {}, [], [np.nan] * count, [None] * count, ["1"] * count)


def harmonics(right=((0.1, 0.0),)):
    wrong = (None, 1.0, "ab", {}, [1.0], [(1.0,)], [(1.0, 2.0, 3.0)], [(np.nan, 0.0)], [("a", "b")], [(True, 0.0)])
    return argument(right, (*wrong, [(0.1, np.inf)], np.ones((1, 3)), [None]))


def of(names: str, wrong: tuple, values: dict) -> dict:
    """Arguments of several parameters whose values are wrong in the same ways."""
    return {name: argument(values[name], wrong) for name in names.split()}


def teeth_arguments() -> dict:
    above = of("module", POSITIVE, TEETH) | of("youngs_modulus", POSITIVE, TEETH)
    least = of("teeth", (*NOT_NEGATIVE, 4.0), TEETH) | of("pressure_angle", (*NUMBER, 5.0, 40.0), TEETH)
    shares = of("addendum", (*POSITIVE, 2.1), TEETH) | of("dedendum", (*POSITIVE, 1.0, 3.1), TEETH)
    body = of("bore", (*POSITIVE, 1.0), TEETH) | of("poisson", (*NOT_NEGATIVE, 0.6), TEETH)
    edge = {"edge_radius": argument(None, (*optional(NUMBER), -0.1, 1.0))}
    return above | least | shares | body | edge | of("profile_shift", (*NUMBER, -1.1, 1.1), TEETH)


CALLS = {
    "solver.Blank": lambda: {
        "large_diameter": argument(0.1, (*POSITIVE, 0.01), "small_diameter"),
        "small_diameter": argument(0.05, (*POSITIVE, 0.2)),
        "width": argument(0.02, POSITIVE),
        "bore": argument(0.01, (*NOT_NEGATIVE, 0.05)),
        "density": argument(7850.0, POSITIVE),
    },
    "solver.ContactSystem": lambda: {
        **{name: argument(np.eye(2), array(np.eye(2), np.ones((2, 3)))) for name in ("damping", "stiffness")},
        "mass": argument(np.eye(2), array(np.eye(2), np.zeros((2, 2)), np.ones((2, 2)))),
        "contact": argument(np.array([1.0, 0.0]), array(np.array([1.0, 0.0]), np.ones(3)), "mass"),
        "force": argument(np.array([1.0, 0.0]), array(np.array([1.0, 0.0]), np.ones(3))),
        "varying_force": argument(None, optional(array(np.ones(2), np.ones(3)))),
        "front_gap": argument(0.5, (*NUMBER, -1.0)),
        "back_gap": argument(0.5, (None, "1", True, np.nan, -np.inf, -1.0, 1j, [1.0])),
        "stiffness_harmonics": harmonics(),
        "load": argument(
            np.ones((2, 2)), array(np.ones((2, 2)), np.ones((2, 3)), np.ones((0, 2)).tolist(), 1j * np.ones((2, 2)))
        ),
        "inertial_load": argument(np.ones((2, 2)), array(np.ones((2, 2)), np.ones((2, 3)), 1j * np.ones((2, 2)))),
        "back_stiffness": argument(2.0, POSITIVE),
        "contact_dashpot": argument(0.1, NOT_NEGATIVE),
        "cubic": argument(0.1, NUMBER),
    },
    "solver.ContactSystem.at": lambda: {
        "self": stop(),
        "axis": argument("damping", NAME),
        "value": argument(0.5, NUMBER, "damping"),
    },
    "solver.ContactSystem.contact_force": lambda: {
        "self": stop(),
        "displacement": argument(GRID, array(GRID, any_shape=True)),
    },
    "solver.ContactSystem.dynamic_stiffness": lambda: {"self": stop(), "omega": argument(1.0, (*NUMBER, [1.0, 2.0]))},
    "solver.ContactSystem.load_harmonics": lambda: {
        "self": stop(),
        "omega": argument(1.0, POSITIVE),
        "order": argument(2, COUNT),
    },
    "solver.GearPair": pair_arguments,
    "solver.GearPair.load": lambda: {"self": pair(), "drive": argument(1.0, NUMBER), "load": argument(1.0, NUMBER)},
    "solver.GearTeeth": teeth_arguments,
    "solver.PitchCones": lambda: {
        name: pair_arguments()[name] for name in ("teeth", "module", "shaft_angle", "face_width")
    },
    "solver.Model": gear_arguments,
    "solver.Model.linear_frequencies": lambda: {
        "self": model(),
        "gain": argument(np.array([0.5, 1.0]), array(np.array([0.5, 1.0]), any_shape=True)),
    },
    "solver.Model.mesh_modes": lambda: {"self": model(), "gain": argument(1.0, NUMBER)},
    "solver.Model.load_harmonics": lambda: {
        "self": model(),
        "omega": argument(1.0, POSITIVE),
        "order": argument(2, COUNT),
    },
    "solver.Model.replace": lambda: {
        "self": model(),
        **{
            name: argument(0.3, one.wrong)
            for name, one in gear_arguments().items()
            if name in ("b", "f_e", "kappa", "k_support")
        },
    },
    "solver.Model.stiffness_variation": lambda: {"self": model(), "angle": argument(GRID, array(GRID, any_shape=True))},
    "solver.ToothMesh": lambda: {
        "first": argument(teeth(), OBJECT),
        "second": argument(teeth(), OBJECT),
        "face_width": argument(0.02, POSITIVE),
    },
    "solver.ToothMesh.coefficients": lambda: {"self": tooth_mesh(), "count": argument(2, (*COUNT, 101))},
    "solver.ToothMesh.harmonics": lambda: {"self": tooth_mesh(), "count": argument(2, (*COUNT, 101))},
    "solver.ToothMesh.pair_stiffness": lambda: {
        "self": tooth_mesh(),
        "place": argument(np.zeros(3), array(np.zeros(3), np.ones(3), -np.ones(3), empty=True)),
    },
    "solver.ToothMesh.stiffness": lambda: {"self": tooth_mesh(), "phase": argument(GRID, array(GRID, empty=True))},
    "solver.bevel_mesh": lambda: {
        "first": argument(teeth(), OBJECT),
        "second": argument(teeth(), OBJECT),
        "shaft_angle": argument(90.0, (*POSITIVE, 180.0, 179.9)),
        "face_width": argument(0.01, (*POSITIVE, 1.0)),
    },
    "solver.geared_rotor": rotor_arguments,
    "solver.spur_pair": lambda: {
        "damping_ratio": argument(0.05, NOT_NEGATIVE),
        "gap": argument(1.0, NOT_NEGATIVE),
        "mean_load": argument(0.1, NUMBER),
        **{f"{name}_harmonics": harmonics() for name in ("stiffness", "error", "load")},
    },
    "solver.iso_6336_stiffness": lambda: {"mesh": argument(tooth_mesh(), OBJECT)},
    "solver.thumb_stiffness": lambda: {"mesh": argument(tooth_mesh(), OBJECT)},
    "solver.Scale": lambda: {
        "size": argument(2.0, (*NUMBER, 0.0)),
        "unit_size": argument(2.0, (*NUMBER, 0.0)),
        "name": argument("torque", (None, 1, [])),
        "unit": argument("N m", (None, 1, [])),
    },
    "solver.Scale.dimensionless": lambda: {
        "self": Scales(pair())["b"],
        "value": argument(1.0, (None, "1", {}, [None], ["1"], True, object())),
    },
    "solver.Scale.physical": lambda: {
        "self": Scales(pair())["b"],
        "value": argument(1.0, (None, "1", {}, [None], ["1"], True, object())),
    },
    "solver.Scales": lambda: {"gear": argument(pair(), OBJECT)},
    "solver.Scales.dimensionless": lambda: {
        "self": Scales(pair()),
        "name": argument("b", NAME),
        "value": argument(1.0, (None, "1", {}, [None], ["1"], True, object())),
    },
    "solver.Scales.physical": lambda: {
        "self": Scales(pair()),
        "name": argument("b", NAME),
        "value": argument(1.0, (None, "1", {}, [None], ["1"], True, object())),
    },
    "solver.domain_code": lambda: {
        "n": argument(2, (None, "1", True, 1.5, np.nan, -1, 1023, [1.0], {}, [None])),
        "states": argument(3, (None, "1", True, 1.5, np.nan, -1, 64, [1.0], {}, [None])),
    },
    "solver.domain_label": lambda: {
        "code": argument(132, (None, "1", True, 2.5, 2.0, np.nan, -1, 2**16, [1], {}, 65, 2))
    },
    "solver.domain_labels": lambda: {"most": argument(3, (*COUNT, 1023))},
    "solver.domain_parts": lambda: {
        "code": argument(
            [132, 0], (None, "1", True, 2.5, np.nan, -1, 2**16, [1.0], {}, [None], np.ma.masked_array([1, 2], [0, 1]))
        )
    },
    "solver.fit_cycle": lambda: {
        "angle": argument(
            np.arange(9.0) * 0.69,
            array(np.arange(9.0) * 0.69, np.arange(9.0), np.zeros(9), np.arange(9.0) * 0.1),
            "count",
            "value",
        ),
        "value": argument(np.arange(9.0), array(np.arange(9.0), np.arange(8.0))),
        "count": argument(2, (*COUNT, 0, 9)),
    },
    "solver.gear_system": lambda: {"model": argument(model(), OBJECT), "separate": argument(True, OBJECT)},
    "solver.impact_state": lambda: {
        **{
            name: argument(GRID, array(GRID, np.ones(3), finite=False, any_shape=True), "b")
            for name in ("lowest", "highest")
        },
        "b": argument(1.0, (None, "1", True, np.nan, -1.0, {}, [None], [1.0, 2.0])),
    },
    "solver.label_parts": lambda: {
        "label": argument(
            "2/0-1", (*NAME, "2/7", "2/1-0", "0/0", "1/-", "x/0", "1/0-1", "2000/0", "-1/0", " 1/0", "1/0\n", "/", "1/")
        )
    },
}
