"""The published numbers of docs/physics.md, section 7, in its order: the article's, and the reference digits."""

from pipeline.study.agreement import THRESHOLD_AGREES
from pipeline.study.numerals import percent
from pipeline.study.statements.quantities import (
    AllSolutions,
    DefaultInterval,
    LabelThreshold,
    RowFolds,
    ShareOfCount,
    StoredFolds,
    TraitThreshold,
    WorstImpact,
)
from pipeline.study.statements.statement import Quantity, Statement

__all__ = ["STATEMENTS"]

# The reference digits are rounded to six decimals for folds and to eight for solutions.
_FOLD_DIGITS, _SOLUTION_DIGITS = 1e-6, 2e-8
_PRINTED, _EQUAL = "the printed digits", "equality"


def _threshold(key: str, text: str, plane: str, value: float, quantity: Quantity, reference: str) -> Statement:
    agreement = f"{percent(THRESHOLD_AGREES)} of the article's value"
    return Statement(key, text, plane, quantity, (value,), (THRESHOLD_AGREES * value,), agreement, reference)


def _interval(key: str, resonance: str, low: float, high: float, reference: str) -> Statement:
    text = f"default parameters: several motions at the {resonance} resonance in an interval of Ω"
    # A twentieth of the interval, not of Ω: the intervals are narrow.
    width = (THRESHOLD_AGREES * (high - low),)
    agreement = f"{percent(THRESHOLD_AGREES)} of the width of the article's interval"
    quantity = DefaultInterval("omega_b", resonance)
    return Statement(key, text, "omega_b", quantity, (low, high), width, agreement, reference)


def _ends(plane: str, resonance: str, trait: str, value: float) -> TraitThreshold:
    return TraitThreshold(plane, resonance, trait, "to", value)


def _digits(gear: str, omega: float, *digits: float) -> Statement:
    key = f"solutions_{gear}_{omega:.2f}"
    text = f"{gear}: all solutions at Ω = {omega:g}, λ_m and λ_a"
    return Statement(
        key, text, "", AllSolutions(gear, omega), digits, (_SOLUTION_DIGITS,), _PRINTED, source="reference"
    )


def _folds(key: str, text: str, plane: str, quantity: Quantity, *digits: tuple[float, float, float]) -> Statement:
    flat = tuple(number for fold in sorted(digits) for number in fold)
    return Statement(key, text, plane, quantity, flat, (_FOLD_DIGITS,), _PRINTED, source="reference")


#: All of them; keys are unique.
STATEMENTS: tuple[Statement, ...] = (
    _interval("interval_mesh", "mesh", 0.5575, 0.6325, "0.55937–0.63464"),
    _interval("interval_shaft", "shaft", 1.220, 1.233, "1.22381–1.22971"),
    _threshold(
        "b_mesh_1_2",
        "Ω × b: at the mesh resonance 1/2 gives way to 2/0-1 at b",
        "omega_b",
        0.6,
        LabelThreshold("omega_b", "mesh", (("1/2", "to"), ("2/0-1", "from"))),
        "0.61–0.63",
    ),
    _threshold(
        "b_mesh_2_02",
        "Ω × b: at the mesh resonance 2/0-2 is gone above b",
        "omega_b",
        0.98,
        LabelThreshold("omega_b", "mesh", (("2/0-2", "to"),)),
        "1.011",
    ),
    _threshold(
        "b_shaft_settles",
        "Ω × b: the shaft resonance settles above b, double-sided impact is gone",
        "omega_b",
        0.2,
        _ends("omega_b", "shaft", "double-sided impact", 0.2),
        "0.18",
    ),
    _threshold(
        "fe_shaft_1_1",
        "Ω × f_e: at the shaft resonance 1/0 gives way to 1/1 at f_e",
        "omega_fe",
        0.12,
        LabelThreshold("omega_fe", "shaft", (("1/1", "from"),)),
        "0.140",
    ),
    _threshold(
        "fe_mesh_2_02",
        "Ω × f_e: at the mesh resonance 2/0-2 appears at f_e",
        "omega_fe",
        0.21,
        LabelThreshold("omega_fe", "mesh", (("2/0-2", "from"),)),
        "0.198",
    ),
    _threshold(
        "fe_mesh_2_12",
        "Ω × f_e: at the mesh resonance 2/1-2 and 2/2 appear at f_e",
        "omega_fe",
        0.34,
        LabelThreshold("omega_fe", "mesh", (("2/1-2", "from"), ("2/2", "from"))),
        "0.321, 0.370",
    ),
    _threshold(
        "alpha_shaft_jumps",
        "Ω × α: jumps at the shaft resonance end at α",
        "omega_alpha",
        0.25,
        _ends("omega_alpha", "shaft", "jump", 0.25),
        "0.278",
    ),
    _threshold(
        "alpha_shaft_contact",
        "Ω × α: contact loss at the shaft resonance ends at α",
        "omega_alpha",
        0.4,
        _ends("omega_alpha", "shaft", "contact loss", 0.4),
        "0.388",
    ),
    _threshold(
        "fpm_shaft_jumps",
        "Ω × f_pm: jumps at the shaft resonance end at f_pm",
        "omega_fpm",
        0.57,
        _ends("omega_fpm", "shaft", "jump", 0.57),
        "0.5855",
    ),
    _threshold(
        "fpm_shaft_contact",
        "Ω × f_pm: contact loss at the shaft resonance ends at f_pm",
        "omega_fpm",
        0.75,
        _ends("omega_fpm", "shaft", "contact loss", 0.75),
        "0.714",
    ),
    Statement(
        "bilateral_shaft",
        "default parameters: severest impact state I at the shaft resonance",
        "omega_b",
        WorstImpact("omega_b", "shaft"),
        (2.0,),
        (0.0,),
        _EQUAL,
        "1",
    ),
    Statement(
        "n3_b",
        "Ω × b: no place with three or more stable motions",
        "omega_b",
        ShareOfCount("omega_b", 3),
        (0.0,),
        (0.0,),
        _EQUAL,
    ),
    Statement(
        "n3_fe",
        "Ω × f_e: no place with three or more stable motions",
        "omega_fe",
        ShareOfCount("omega_fe", 3),
        (0.0,),
        (0.0,),
        _EQUAL,
    ),
    _folds(
        "folds_published",
        "published: folds",
        "omega_b",
        StoredFolds("omega_b"),
        (0.559374, 1.027736, 1.991212),
        (0.634641, 1.641558, 0.708424),
        (1.223810, 1.598606, 0.882513),
        (1.229708, 1.644933, 0.684089),
    ),
    _folds("folds_consistent", "consistent: no folds", "", RowFolds("consistent")),
    _folds(
        "folds_antiphase",
        "antiphase: folds",
        "",
        RowFolds("antiphase"),
        (0.488703, 1.000241, 2.032049),
        (0.517873, 0.793933, 1.937968),
        (0.531027, 0.728561, 2.780072),
        (0.542557, 1.620306, 0.740615),
        (1.256714, 0.962657, 1.983417),
        (1.378418, 1.618688, 0.742421),
        (1.293183, 0.813761, 2.022725),
        (1.293594, 0.803868, 2.131303),
    ),
    _digits("published", 0.60, 1.6477523, 0.40040130, 1.42808129, 1.29089291, 1.15146214, 1.79064815),
    _digits("published", 1.00, 1.6477523, 0.12926713),
    _digits("published", 1.30, 1.62243625, 0.79960954),
    _digits("consistent", 0.60, 1.60305262, 0.54486579),
    _digits("consistent", 1.60, 1.57960424, 0.66437894),
    _digits("antiphase", 1.30, 1.60976775, 0.44464882, 1.29620274, 1.51102783, 0.85933784, 1.86059051),
)
