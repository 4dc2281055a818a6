"""Stability, reference digits and the Taylor recurrence: sections 6 to 8 of docs/physics.md.

The motions and folds that the page prints are put into the balance as the page writes it. Nothing of the solver is
imported: page and solver are checked against the same third party.
"""

import cmath
import math

import pytest

from tests.docs.arithmetic import angles, determinant, root, slopes
from tests.docs.page import table
from tests.docs.pair import CONSISTENT, PUBLISHED, SETS, corrected, found, reduced, residual, static_determinant

RIGHT = 0.5 * math.pi
#: Rows of the tables of section 7.4.
FOLDS = [(row[0], *map(float, row[1:])) for row in table("set", "$\\Omega$", "$\\lambda_m$", "$\\lambda_a$")]
SOLUTIONS = [
    (row[0], *map(float, row[1:4]), row[4])
    for row in table("set", "$\\Omega$", "$\\lambda_m$", "$\\lambda_a$", "statically")
]


def monodromy(pair, omega, unknowns, steps=200):
    """Of the states (u, lambda, u', lambda'), by the classical Runge-Kutta method between the switches of contact."""
    mean, amplitude = unknowns[0], math.hypot(*unknowns[1:])
    phase = math.atan2(-unknowns[2], unknowns[1])
    near, far = angles(mean, amplitude, pair.b)
    switches = sorted((sign * angle - phase) % (2.0 * math.pi) for angle in (near, math.pi - far) for sign in (1, -1))
    edges = [0.0, *switches, 2.0 * math.pi]
    coupling, drag = 2.0 * pair.sigma * pair.kappa, 2.0 * pair.sigma * pair.xi_translation

    def rate(theta, closed, state):
        u, mesh, v, speed = state
        s = pair.alpha * math.cos(theta + pair.phase)
        back = -2.0 * pair.xi * v - pair.k * u - 2.0 * drag * speed
        pull = 0.0
        if closed:
            back -= coupling * (1.0 + pair.eps_t * s) * mesh
            pull = (1.0 + pair.eps_r * s) * mesh
        forward = back - pair.c * (pull + 2.0 * pair.xi_mesh * speed)
        return [x / omega for x in (v, speed, back, forward)]

    columns = []
    for i in range(4):
        state = [float(i == j) for j in range(4)]
        for begin, end in zip(edges, edges[1:], strict=False):
            if end <= begin:
                continue
            middle = mean + amplitude * math.cos(0.5 * (begin + end) + phase)
            closed, step = abs(middle) > pair.b, (end - begin) / steps
            for k in range(steps):
                theta = begin + k * step
                k_1 = rate(theta, closed, state)
                k_2 = rate(theta + step / 2, closed, [x + step / 2 * y for x, y in zip(state, k_1, strict=True)])
                k_3 = rate(theta + step / 2, closed, [x + step / 2 * y for x, y in zip(state, k_2, strict=True)])
                k_4 = rate(theta + step, closed, [x + step * y for x, y in zip(state, k_3, strict=True)])
                state = [
                    x + step / 6.0 * (a + 2.0 * b + 2.0 * c + d)
                    for x, a, b, c, d in zip(state, k_1, k_2, k_3, k_4, strict=True)
                ]
        columns.append(state)
    return [list(row) for row in zip(*columns, strict=True)]


def characteristic(matrix, z):
    """det(M - z I)."""
    return determinant([[x - z * (i == j) for j, x in enumerate(row)] for i, row in enumerate(matrix)])


class TestSection6:
    def test_multipliers_multiply_to_the_damping(self):
        """Liouville: det M = exp(-2 (sum xi + c xi_h + sum d^2 xi_hg) 2 pi/Omega), whatever the contact does."""
        solution = corrected(PUBLISHED.coefficients(0.6), found(PUBLISHED, 0.6, 1.15146214, 1.79064815))
        matrix = monodromy(PUBLISHED, 0.6, solution)
        drag = 2.0 * PUBLISHED.sigma * PUBLISHED.xi_translation
        rate = 2.0 * (PUBLISHED.xi + PUBLISHED.c * PUBLISHED.xi_mesh + drag)
        assert determinant(matrix) == pytest.approx(math.exp(-rate * 2.0 * math.pi / 0.6), rel=1e-7)

    def test_supports_across_the_contact_direction(self):
        """Their multipliers are exp[(-xi +- sqrt(xi^2 - k)) T]: the free vibration w'' + 2 xi w' + k w = 0."""
        xi, k, tau, step = 0.1, 1.3, 0.7, 1e-4
        for sign in (1, -1):
            exponent = -xi + sign * cmath.sqrt(xi * xi - k)
            w = [cmath.exp(exponent * (tau + i * step)) for i in (-1, 0, 1)]
            second, first = (w[0] - 2.0 * w[1] + w[2]) / step**2, (w[2] - w[0]) / (2.0 * step)
            assert abs(second + 2.0 * xi * first + k * w[1]) < 1e-6

    def test_a_multiplier_below_minus_1_where_first_order_sees_nothing(self):
        """Section 8: c = cos 20 degrees, eps_t = 0, Omega = 1.2; det(M + I) < 0, and the multiplier is -1.047."""
        pair = CONSISTENT.but(c=math.cos(math.radians(20.0)), eps_t=0.0)
        at = pair.coefficients(1.2)
        _, l, n = reduced(at, 1.0)
        q = reduced(at, 1.0)[0]
        motion, mean = l / q, pair.b + n / q
        assert mean - abs(motion) > pair.b
        matrix = monodromy(pair, 1.2, [mean, motion.real, -motion.imag])
        assert static_determinant(at, [mean, motion.real, -motion.imag]) > 0.0
        assert characteristic(matrix, -1.0) < 0.0
        assert round(root(lambda z: characteristic(matrix, z), -1.3, -1.0), 3) == -1.047

    def test_the_sign_of_det_m_plus_i_counts_real_multipliers_below_minus_1(self):
        for values, sign in (([-1.2, 0.4, 0.3], -1), ([-1.2, -1.1, 0.3], 1), ([-0.9, 0.4, 0.3], 1)):
            diagonal = [[x if i == j else 0.0 for j in range(3)] for i, x in enumerate(values)]
            assert math.copysign(1.0, characteristic(diagonal, -1.0)) == sign
        turning = [[-1.1, -0.4, 0.0], [0.4, -1.1, 0.0], [0.0, 0.0, 0.2]]
        assert characteristic(turning, -1.0) > 0.0


def at_fold(pair, omega, unknowns):
    """Omega and the unknowns of the fold nearby: E = 0 and det J = 0 by Newton's method, slopes by differences."""

    def system(point):
        at = pair.coefficients(point[3])
        return [*residual(at, point[:3]), static_determinant(at, point[:3])]

    point = [*unknowns, omega]
    for _ in range(8):
        rest, matrix = system(point), slopes(system, point)
        whole = determinant(matrix)
        for j in range(4):
            swapped = [[-rest[i] if k == j else matrix[i][k] for k in range(4)] for i in range(4)]
            point[j] += determinant(swapped) / whole
    return point[3], point[:3]


class TestSection7:
    def test_every_set_has_its_digits(self):
        assert len(FOLDS) == 16 and len(SOLUTIONS) == 13

    @pytest.mark.parametrize("name, omega, mean, amplitude", FOLDS)
    def test_folds(self, name, omega, mean, amplitude):
        place, unknowns = at_fold(SETS[name], omega, found(SETS[name], omega, mean, amplitude))
        assert (place, unknowns[0], math.hypot(*unknowns[1:])) == pytest.approx((omega, mean, amplitude), abs=1.01e-6)

    @pytest.mark.parametrize("name, omega, mean, amplitude, stable", SOLUTIONS)
    def test_solutions(self, name, omega, mean, amplitude, stable):
        at = SETS[name].coefficients(omega)
        unknowns = corrected(at, found(SETS[name], omega, mean, amplitude))
        digits = 1e-6 if name == "isola" else 2e-8
        assert (unknowns[0], math.hypot(*unknowns[1:])) == pytest.approx((mean, amplitude), abs=digits)
        assert (static_determinant(at, unknowns) > 0.0) == (stable == "stable")

    def test_signs_add_up_to_the_degree(self):
        """Section 4.8, at every place of which the page prints all solutions."""
        places = {(name, omega) for name, omega, *_ in SOLUTIONS}
        assert len(places) == 7
        for name, omega in places:
            here = [1 if row[4] == "stable" else -1 for row in SOLUTIONS if row[:2] == (name, omega)]
            q = reduced(SETS[name].coefficients(omega), 1.0)[0]
            assert sum(here) == math.copysign(1.0, q)

    def test_the_direction_of_the_published_set(self):
        cone, pressure = math.radians(45.0), math.radians(20.0)
        normal = math.cos(cone) * math.sin(pressure), math.sin(cone) * math.sin(pressure), math.cos(pressure)
        assert [round(math.sqrt(0.3173) * x, 4) for x in normal] == [0.1362, 0.1362, 0.5293]

    def test_ratios_of_error_and_load(self):
        assert [round(x, 3) for x in (0.12 / 0.5, 0.2 / 0.75, 0.140 / 0.5, 0.2 / 0.714)] == [0.24, 0.267, 0.28, 0.28]


class TestSection8:
    def test_taylor_recurrence(self):
        """Against the differential equation itself, at the end of a step: one coordinate and the mesh."""
        pair, omega, begin, order, step = PUBLISHED, 0.9, 0.4, 24, 0.3
        S, K = 2.0 * pair.sigma * pair.kappa, [[pair.k, 0.0], [0.0, 0.0]]
        drag = 2.0 * pair.sigma * pair.xi_translation
        C = [[2.0 * pair.xi, 2.0 * drag], [0.0, 2.0 * pair.c * pair.xi_mesh]]
        h, h_v = [S, pair.c], [pair.eps_t * S, pair.eps_r * pair.c]

        def derivative(amplitude, phase, k):
            """Taylor coefficient k of amplitude cos(omega tau + phase) at `begin`."""
            return amplitude * omega**k * math.cos(omega * begin + phase + k * RIGHT) / math.factorial(k)

        y = [[0.2, 1.6], [0.1, -0.3]]
        for k in range(order - 1):
            touched = [y[i][1] - (pair.b if i == 0 else 0.0) for i in range(k + 1)]
            product = sum(derivative(pair.alpha, pair.phase, i) * touched[k - i] for i in range(k + 1))
            load = [0.0, derivative(pair.f_e * omega**2, 0.0, k) + (pair.f_pm if k == 0 else 0.0)]
            right = []
            for i in range(2):
                pulled = sum((k + 1) * C[i][j] * y[k + 1][j] + K[i][j] * y[k][j] for j in range(2))
                right.append(load[i] - pulled - h[i] * touched[k] - h_v[i] * product)
            # M is ((1, 0), (-1, 1)).
            y.append([x / ((k + 2) * (k + 1)) for x in (right[0], right[1] + right[0])])

        def motion(delta, derivatives):
            powers = range(derivatives, len(y))
            factors = [math.factorial(k) / math.factorial(k - derivatives) * delta ** (k - derivatives) for k in powers]
            return [sum(f * y[k][i] for f, k in zip(factors, powers, strict=True)) for i in range(2)]

        (u, mesh), (v, rate), (second, mesh_second) = (motion(step, n) for n in range(3))
        s = pair.alpha * math.cos(omega * (begin + step) + pair.phase)
        force = mesh - pair.b
        assert force > 0.0
        expected = -2.0 * pair.xi * v - pair.k * u - S * (1.0 + pair.eps_t * s) * force - 2.0 * drag * rate
        assert second == pytest.approx(expected, abs=1e-12)
        load = pair.f_pm + pair.f_e * omega**2 * math.cos(omega * (begin + step))
        expected += load - pair.c * ((1.0 + pair.eps_r * s) * force + 2.0 * pair.xi_mesh * rate)
        assert mesh_second == pytest.approx(expected, abs=1e-12)

    def test_chords_and_monotone_pieces(self):
        """A polynomial leaves its chord by at most B d^2/8, and is monotone where its slope exceeds B d."""

        def value(x):
            return 0.3 + 0.7 * x - 1.9 * x**2 + 0.8 * x**3

        width, bound = 0.25, 3.8
        for i in range(20):
            left = 0.04 * i
            ends = value(left), value(left + width)
            for part in (0.2, 0.5, 0.8):
                chord = ends[0] + part * (ends[1] - ends[0])
                assert abs(value(left + part * width) - chord) <= bound * width**2 / 8.0
