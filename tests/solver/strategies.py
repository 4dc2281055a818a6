"""Hypothesis strategies: gear pairs of all kinds, and states of them."""

import numpy as np
from hypothesis import strategies as st

from solver import Model


def numbers(low, high):
    """Floats of a few digits, both ends included, which shrink and print well."""
    return st.integers(0, 10_000).map(lambda i: round(low + (high - low) * i / 10_000, 12))


def random_model(seed, **fixed) -> Model:
    """A gear pair with couplings and harmonics of every kind, supports that differ by axis and gear or partly agree."""
    draw = np.random.default_rng(seed)

    def number(low, high):
        return 0.0 if low <= 0.0 and draw.random() < 0.08 else round(draw.uniform(low, high), 4)

    def several(count, choose):
        return choose() if draw.random() < 0.3 else [choose() for _ in range(count)]

    def harmonics():
        return [(number(0.0, 0.3), number(-3.0, 3.0)) for _ in range(draw.integers(3))]

    def coupling(low, high):
        return "geometric" if draw.random() < 0.4 else number(low, high)

    values = dict(
        b=number(0.0, 2.0),
        alpha=number(0.0, 0.6),
        alpha_phase=number(-3.0, 3.0),
        alpha_harmonics=harmonics(),
        f_e=number(0.0, 0.5),
        f_e_phase=number(-3.0, 3.0),
        f_e_harmonics=harmonics(),
        f_pm=number(-1.0, 1.0),
        f_pv=number(-0.3, 0.3),
        kappa=several(2, lambda: number(0.1, 1.0)),
        xi_mesh=number(0.0, 0.1),
        xi_translation=several(2, lambda: number(0.0, 0.05)),
        # Few values, so that neighbouring supports agree in one of the two, in both or in none.
        xi_support=several(6, lambda: draw.choice([0.02, 0.05, 0.1])),
        k_support=several(6, lambda: draw.choice([0.5, 1.0, 2.5])),
        pitch_cone_angle=number(5.0, 85.0),
        pressure_angle=number(5.0, 35.0),
        translation_coupling=coupling(0.0, 1.0),
        rotation_coupling=coupling(0.3, 1.0),
        variation_translation=number(0.0, 1.0),
        variation_rotation=number(0.0, 1.0),
    )
    return Model(**{**values, **fixed})


def models(**fixed):
    """Models of `random_model`; a failing example prints the model itself."""
    return st.integers(0, 10**9).map(lambda seed: random_model(seed, **fixed))


#: (lambda_m, lambda_c, lambda_s) of motions of the size that matters.
motions = st.tuples(numbers(-3.0, 3.0), numbers(-2.0, 2.0), numbers(-2.0, 2.0)).map(np.array)

frequencies = numbers(0.1, 2.0)


def value_on(model, axis):
    """A value of the axis that lies inside what is allowed."""
    if axis == "omega":
        return 0.83
    value = getattr(model, axis)
    if isinstance(value, str):
        return 0.7
    return float(np.mean(value)) + 0.01
