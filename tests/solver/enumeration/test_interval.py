"""Every bound that the proofs rest on, against exact or extended arithmetic."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.contact.dead_zone import describing_functions
from solver.enumeration import interval
from solver.enumeration.coefficients import enclosed_coefficients
from solver.enumeration.contact_law import contact_law
from solver.enumeration.gain_bounds import gain_over, gain_slopes
from solver.harmonic.condensed import coefficients
from solver.model.packing import axis_vectors
from tests.conftest import MODELS

NUMBERS = st.floats(min_value=-1e30, max_value=1e30, allow_nan=False)
PLACES = st.fractions(min_value=0, max_value=1, max_denominator=1000)
exactly = settings(deadline=None, derandomize=True, max_examples=120)

_LONG = np.longdouble
_PI = np.arccos(_LONG(-1))


@st.composite
def enclosures(draw):
    """An interval and an exact number inside it."""
    low, high = sorted((draw(NUMBERS), draw(NUMBERS)))
    place = draw(PLACES)
    return (low, high), Fraction(low) + place * (Fraction(high) - Fraction(low))


def contains(bounds, value):
    return Fraction(bounds[0]) <= value <= Fraction(bounds[1])


@exactly
@given(enclosures(), enclosures())
def test_real_operations_contain_the_exact_result(first, second):
    (x, a), (y, b) = first, second
    assert contains(interval.add(x, y), a + b)
    assert contains(interval.subtract(x, y), a - b)
    assert contains(interval.multiply(x, y), a * b)
    assert contains(interval.square(x), a * a)
    assert contains(interval.times(abs(y[0]), x), abs(Fraction(y[0])) * a)
    meeting = interval.hull(x, (float(a), float(a)))
    assert contains(interval.intersect(meeting, interval.hull((float(a), float(a)), y)), Fraction(float(a)))
    assert contains(interval.absolute(x), abs(a))
    assert contains(interval.hull(x, y), a) and contains(interval.hull(x, y), b)
    quotient = interval.divide(x, y)
    if y[0] > 0.0 or y[1] < 0.0:
        if np.all(np.isfinite(quotient)):
            assert contains(quotient, a / b)
    else:
        assert np.all(np.isnan(quotient))
    low, high = interval.length(x, y)
    assert Fraction(low) ** 2 <= a * a + b * b <= Fraction(high) ** 2


@exactly
@given(enclosures(), enclosures(), enclosures(), enclosures())
def test_complex_operations_contain_the_exact_result(first, second, third, fourth):
    (x, a), (y, b), (z, c), (w, d) = first, second, third, fourth
    product = interval.complex_multiply((x, y), (z, w))
    assert contains(product[0], a * c - b * d) and contains(product[1], a * d + b * c)
    total, difference = interval.complex_add((x, y), (z, w)), interval.complex_subtract((x, y), (z, w))
    assert contains(total[0], a + c) and contains(difference[1], b - d)
    assert contains(interval.complex_scale(x, (z, w))[1], a * d)
    assert contains(interval.complex_conjugate((x, y))[1], -b)
    inverse = interval.complex_reciprocal((x, y))
    if np.all(np.isfinite(inverse)) and a * a + b * b:
        assert contains(inverse[0], a / (a * a + b * b)) and contains(inverse[1], -b / (a * a + b * b))


@exactly
@given(st.floats(-400.0, 400.0), st.floats(0.0, 1e-6))
def test_sine_and_cosine(middle, radius):
    x = (middle - radius, middle + radius)
    for place in (_LONG(x[0]), _LONG(middle), _LONG(x[1])):
        low, high = interval.cosine(x)
        assert low <= np.cos(place) <= high
        low, high = interval.sine(x)
        assert low <= np.sin(place) <= high


def _law(cosine, beta):
    """Mean force and gain in extended precision."""
    cosine, beta = np.asarray(cosine, dtype=_LONG), np.asarray(beta, dtype=_LONG)
    force, gain = _LONG(0), _LONG(0)
    for sign, flank in ((1, cosine), (-1, 2 * beta - cosine)):
        flank = np.clip(flank, _LONG(-1), _LONG(1))
        angle, sine = np.arccos(flank), np.sqrt((1 - flank) * (1 + flank))
        force, gain = force + sign * (sine - angle * flank), gain + angle - sine * flank
    return force / _PI, gain / _PI


#: Nothing but the contact holds lambda, and there are two flanks.
GEAR = (0.0, 0.0, 1.0)


def test_rounding_of_the_contact_law_stays_within_a_quarter_of_its_margin():
    rng = np.random.default_rng(1)
    worst = 0.0
    for _ in range(20_000):
        beta = rng.choice([rng.uniform(0.0, 1.2), 10.0 ** rng.uniform(-12, 0), 1.0 - 10.0 ** rng.uniform(-12, 0)])
        top = min(beta, 1.0)
        small = 10.0 ** rng.uniform(-14, 0)
        cosine = rng.choice([rng.uniform(-1.0, top), top - small, small - 1.0])
        cosine = min(max(cosine, -1.0), top)
        force, gain, margin, _, _ = contact_law(cosine, beta, GEAR)
        exact_force, exact_gain = _law(cosine, beta)
        worst = max(worst, abs(force - exact_force) / margin, abs(gain - exact_gain) / margin)
    assert worst < 0.25


def test_contact_law_agrees_with_the_describing_functions():
    rng = np.random.default_rng(2)
    for _ in range(500):
        amplitude, b = rng.uniform(0.1, 3.0), rng.uniform(0.0, 2.0)
        mean = rng.uniform(0.0, b + amplitude)
        if b - mean >= amplitude:
            continue
        force, gain = describing_functions(mean, amplitude, b)[:2]
        law = contact_law((b - mean) / amplitude, b / amplitude, GEAR)
        assert law[0] == pytest.approx(force / amplitude, abs=1e-13)
        assert law[1] == pytest.approx(gain, abs=1e-13)


def test_gain_over_bounds_gain_and_slopes_on_rectangles():
    rng = np.random.default_rng(3)
    step = 1e-6
    for k in range(2_000):
        width = 10.0 ** rng.uniform(-12, -0.3)
        beta = rng.uniform(0.0, 1.1) if k % 3 else 10.0 ** rng.uniform(-8, 0)
        cosine = rng.uniform(-1.0, min(beta, 1.0))
        phi, gain = (float(v) for v in _law(cosine, beta))
        before, after = rng.uniform(0.0, width, 2), rng.uniform(0.0, width, 2)
        guess = rng.choice([np.nan, cosine, rng.uniform(-1.0, 1.0)])
        phi_bounds, beta_bounds = (phi - before[0] - 1e-15, phi + after[0] + 1e-15), (beta - before[1], beta + after[1])
        slack = rng.choice([0.0, 1e-12, 1e-3 * width])
        gains, cosines = gain_over(phi_bounds, beta_bounds, GEAR, guess, slack)
        by_force, by_gap = gain_slopes(phi_bounds, beta_bounds, cosines, GEAR, slack)
        assert gains[0] <= gain <= gains[1]
        assert cosines[0] <= cosine <= cosines[1]
        assert by_force[0] >= 0.0 and by_gap[1] <= 0.0
        # Slopes of the law along its two parameters, in extended precision.
        if -1.0 + step < cosine < min(beta, 1.0) - step and beta > step:
            (f_0, n_0), (f_1, n_1) = _law(cosine - step / 1000, beta), _law(cosine + step / 1000, beta)
            (f_2, n_2), (f_3, n_3) = _law(cosine, beta - step / 1000), _law(cosine, beta + step / 1000)
            slope_force = (n_1 - n_0) / (f_1 - f_0)
            slope_gap = ((n_3 - n_2) - slope_force * (f_3 - f_2)) / (step / 500)
            assert by_force[0] - 1e-6 <= slope_force <= by_force[1] + 1e-6
            assert by_gap[0] - 1e-6 <= slope_gap <= by_gap[1] + 1e-6


def test_gain_over_at_the_edges():
    assert gain_over((1.0, np.inf), (0.0, np.inf), GEAR, np.nan, 0.0)[0] == (1.0, 1.0)
    low, high = gain_over((0.0, 0.0), (1.0, 5.0), GEAR, np.nan, 0.0)[0]
    assert low == 0.0 and high < 1e-12
    low, high = gain_over((0.3, 0.3), (0.0, 0.0), GEAR, np.nan, 0.0)[0]
    assert low > 1.0 - 1e-14 and high == 1.0
    assert gain_over((np.nan, np.nan), (0.0, 1.0), GEAR, np.nan, 0.0)[0] == (0.0, 1.0)


@pytest.mark.parametrize("omega", [0.05, 0.6, 1.0, 1.3, 2.5])
def test_enclosed_coefficients_contain_the_floating_point_ones_tightly(gear, omega):
    model = gear[1].replace(alpha_harmonics=[(0.1, 0.3)], f_pv=0.05, xi_support=[0.01, 0.02, 0.03, 0.01, 0.01, 0.005])
    theta, direction = axis_vectors(model, "omega")
    values, _, constants, _ = coefficients(theta, direction, omega)
    enclosed, c = enclosed_coefficients(theta, direction, omega)
    assert c[0] <= constants[0] <= c[1]
    for value, (real, imaginary) in zip(values, enclosed, strict=True):
        margin = 1e-15 * abs(value)
        assert real[0] - margin <= value.real <= real[1] + margin
        assert imaginary[0] - margin <= value.imag <= imaginary[1] + margin
        assert max(real[1] - real[0], imaginary[1] - imaginary[0]) <= 1e-13 * max(abs(value), 1e-6)


def test_enclosed_coefficients_contain_the_exact_ones():
    """At angles whose cosines are rational the coefficients are rational functions of the parameters."""
    model = MODELS["consistent"](pressure_angle=60.0, pitch_cone_angle=60.0, alpha=0.3, alpha_phase=0.0)
    omega = 0.625
    enclosed, c = enclosed_coefficients(*axis_vectors(model, "omega"), omega)
    w, xi, k = Fraction(omega), Fraction(model.xi_support[0]), Fraction(model.k_support[0])
    real, imaginary = k - w * w, 2 * xi * w
    size = real * real + imaginary * imaginary
    # d.d over both gears is 2 sigma = 2; cos^2 60 degrees = 1/4.
    T = (2 * w * w * Fraction(0.5) * real / size, -2 * w * w * Fraction(0.5) * imaginary / size)
    U = tuple(part * Fraction(0.0125) / Fraction(0.5) for part in T)
    damping = (Fraction(1, 4) * Fraction(0.05) - U[0], -U[1])
    assert contains(c, Fraction(1, 4))
    assert contains(enclosed[0][0], -w * w - 2 * w * damping[1])
    assert contains(enclosed[0][1], 2 * w * damping[0])
    assert contains(enclosed[1][0], Fraction(1, 4) - T[0]) and contains(enclosed[1][1], -T[1])
    assert contains(enclosed[2][0], (Fraction(1, 4) - T[0]) * Fraction(0.3))
    assert contains(enclosed[4][0], Fraction(0.2) * w * w)
