"""The reduced balance: that it is the balance, and that its bounds hold over intervals of gains."""

import numpy as np
import pytest

from solver import all_solutions
from solver.contact.dead_zone import describing_functions
from solver.enumeration.condensed import condensed_over
from solver.enumeration.gain_equation import gain_at, motion_over, slope_over
from solver.enumeration.reduction import ROWS, determinant_over, numerators_at, reduce_balance
from solver.harmonic.condensed import coefficients
from solver.harmonic.describing_function import evaluate
from solver.model.packing import axis_vectors
from tests.conftest import MODELS
from tests.solver.enumeration.test_solutions import random_model


def _case(seed):
    rng = np.random.default_rng(seed)
    name = sorted(MODELS)[seed % 3]
    # Strong variation, so that q and n change sign on [0, 1] in part of the cases.
    model = random_model(rng, name, alpha=rng.uniform(0.0, 1.5), xi_mesh=rng.choice([0.05, 0.005]))
    omega = rng.uniform(0.1, 2.0)
    reduced = np.empty((ROWS, 2))
    assert reduce_balance(condensed_over(model, "omega", np.array([omega]), None)[0], reduced)
    return rng, model, omega, reduced


def _polynomials(model, omega, t):
    """n, q and l at gains t, from the balance's coefficients."""
    (D, A, P_1, P_2, F, e), _, (c, f_pm, *_), _ = coefficients(*axis_vectors(model, "omega"), omega)
    A, Q, G = A - P_1 * e.conjugate() / (2 * c), P_2 - P_1 * e / (2 * c), F - P_1 * f_pm / c
    q = np.abs(D + t * A) ** 2 - t**2 * abs(Q) ** 2
    line = np.conj(D + t * A) * G - t * Q * G.conjugate()
    return (f_pm * q - t * (e * line.conj()).real) / c, q, line


def _gain(force, b):
    """N of a motion of amplitude 1 with mean force `force` >= 0, by bisection over its mean displacement."""
    low, high = 0.0, 1.0 + b + force
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if describing_functions(middle, 1.0, b)[0] < force else (low, middle)
    return describing_functions(low, 1.0, b)[1]


def _h(model, omega, t):
    n, q, line = _polynomials(model, omega, t)
    return _gain(abs(n) / abs(line), model.b * abs(q) / abs(line)) - t


@pytest.mark.parametrize("seed", range(30))
def test_bounds_hold_over_intervals(seed):
    rng, model, omega, reduced = _case(seed)
    regulars = 0
    for _ in range(20):
        width = 10.0 ** rng.uniform(-6, 0)
        left = rng.uniform(0.0, 1.0 - width) if width < 1.0 else 0.0
        right = min(left + width, 1.0)
        gain, slope, regular = slope_over(reduced, left, right, np.nan)
        q_low, q_high = determinant_over(reduced, left, right)
        mean, cosine, sine, amplitude = motion_over(reduced, left, right, np.nan)
        regulars += regular
        places = np.sort(rng.uniform(left, right, 6))
        values = [_h(model, omega, t) for t in places]
        for t, h in zip(places, values, strict=True):
            n, q, line = _polynomials(model, omega, t)
            assert gain[0] - 1e-9 <= h + t <= gain[1] + 1e-9
            assert q_low - 1e-12 <= q <= q_high + 1e-12
            bounds, near = gain_at(reduced, t, np.nan)
            assert bounds[0] - 1e-9 <= h + t <= bounds[1] + 1e-9 and bounds[1] - bounds[0] < 1e-9
            for value, (low, high) in zip((n, q, abs(line)), numerators_at(reduced, t), strict=True):
                assert low - 1e-12 <= value <= high + 1e-12
            motion = line / q
            for value, (low, high) in ((motion.real, cosine), (-motion.imag, sine), (abs(motion), amplitude)):
                assert low - 1e-9 * abs(motion) <= value <= high + 1e-9 * abs(motion)
            force = n / q
            if abs(force) < abs(motion):
                displacement = np.sign(force) * (model.b - abs(motion) * np.mean(near))
            else:
                displacement = force + np.sign(force) * model.b
            margin = 1e-7 * (abs(motion) + abs(force) + model.b)
            assert mean[0] - margin <= displacement <= mean[1] + margin
        if regular:
            # The mean value theorem, for every pair of places.
            for i in range(6):
                for j in range(i):
                    if places[i] - places[j] > 1e-3 * width:
                        secant = (values[i] - values[j]) / (places[i] - places[j])
                        assert slope[0] - 1e-9 / width <= secant <= slope[1] + 1e-9 / width
    assert regulars > 10


@pytest.mark.parametrize("seed", range(30))
def test_determinant_of_the_jacobian(seed):
    """det J = -c q chi h', at every solution."""
    _, model, omega, reduced = _case(seed)
    for mean, cosine, sine in np.transpose([getattr(all_solutions(model, omega), u) for u in ("mean", "cos", "sin")]):
        amplitude = np.hypot(cosine, sine)
        _, gain, contact, *_ = describing_functions(mean, amplitude, model.b)
        _, jacobian = evaluate(model, omega, [mean, cosine, sine])
        _, q, _ = _polynomials(model, omega, gain)
        left, right = max(gain - 1e-9, 0.0), min(gain + 1e-9, 1.0)
        slope = slope_over(reduced, left, right, np.nan)[1]
        if gain == 1.0:
            slope = (-1.0, -1.0)
        assert np.linalg.det(jacobian) == pytest.approx(-model.rotation * q * contact * np.mean(slope), rel=1e-4)
