"""Reduction of the first-order balance to one equation, and static stability: sections 4.5 to 5 of docs/physics.md.

Nothing of the solver is imported: page and solver are checked against the same third party.
"""

import math
from random import Random

import pytest

from tests.docs.arithmetic import angles, complex_number, describing, determinant, gain_of, root, slopes
from tests.docs.pair import CONSISTENT, PUBLISHED, Coefficients, jacobian, reduced, residual, static_determinant


def solved(seed, b=0.8):
    """Random coefficients, and a motion that solves their balance."""
    random = Random(seed)
    D, A, P_1, P_2, e = (size * complex_number(random) for size in (1.0, 1.0, 0.3, 0.3, 0.3))
    mean, motion, c = random.uniform(0.2, 1.6), complex_number(random) * 1.5, random.uniform(0.5, 1.5)
    f_0, gain = describing(mean, abs(motion), b)
    f_1 = gain * motion
    F = D * motion + A * f_1 + P_1 * f_0 + P_2 * f_1.conjugate()
    f_pm = c * f_0 + (e * f_1.conjugate()).real
    return Coefficients(D, A, P_1, P_2, F, e, c, f_pm, b), mean, motion


class TestReduction:
    @pytest.mark.parametrize("seed", range(8))
    def test_reduction_to_one_equation(self, seed):
        """Lambda_1 = l/q, f_0 = n/q, h = 0 at a solution, det J = -c q chi h' there; J itself by differences."""
        at, mean, motion = solved(seed)
        unknowns = [mean, motion.real, -motion.imag]
        assert residual(at, unknowns) == pytest.approx([0.0, 0.0, 0.0], abs=1e-13)
        f_0, gain = describing(mean, abs(motion), at.b)
        q, l, n = reduced(at, gain)
        assert abs(l / q - motion) < 1e-11 and n / q == pytest.approx(f_0, abs=1e-11)

        def h(t):
            q, l, n = reduced(at, t)
            return gain_of(abs(n) / abs(l), at.b * abs(q) / abs(l)) - t

        assert h(gain) == pytest.approx(0.0, abs=1e-11)
        for row, other in zip(jacobian(at, unknowns), slopes(lambda point: residual(at, point), unknowns), strict=True):
            assert row == pytest.approx(other, abs=1e-7)
        chi = sum(angles(mean, abs(motion), at.b)) / math.pi
        if 0.01 < chi < 0.99:
            slope = (h(gain + 1e-6) - h(gain - 1e-6)) / 2e-6
            assert static_determinant(at, unknowns) == pytest.approx(-at.c * q * chi * slope, rel=1e-5, abs=1e-7)

    def test_both_flanks_and_one_are_among_these(self):
        shares = [angles(mean, abs(motion), at.b) for at, mean, motion in map(solved, range(8))]
        assert any(far > 0.0 for _, far in shares) and any(far == 0.0 < near < math.pi for near, far in shares)

    @pytest.mark.parametrize("nu, beta", [(0.2, 0.5), (0.7, 0.9), (0.9, 1.3), (0.6, 0.1)])
    def test_contact_law(self, nu, beta):
        """phi, N and their slopes; N as a function of (phi, beta)."""
        near, far = angles(nu, 1.0, beta)
        phi, gain = describing(nu, 1.0, beta)
        by_phi = 2.0 * (math.sin(near) - math.sin(far)) / (near + far)
        by_beta = -4.0 / math.pi * (far * math.sin(near) + near * math.sin(far)) / (near + far)
        assert gain_of(phi, beta) == pytest.approx(gain, abs=1e-12)
        ((found_phi, found_beta),) = slopes(lambda point: [gain_of(*point)], [phi, beta])
        assert (found_phi, found_beta) == pytest.approx((by_phi, by_beta), abs=1e-7)
        assert 0.0 <= by_phi <= 2.0 and -4.0 / math.pi <= by_beta <= 0.0
        ((by_nu,),) = slopes(lambda point: [describing(point[0], 1.0, beta)[0]], [nu])
        assert by_nu == pytest.approx((near + far) / math.pi, abs=1e-8)

    def test_contact_law_at_its_ends(self):
        assert describing(0.0, 1.0, 0.4)[0] == pytest.approx(0.0, abs=1e-15)
        assert describing(1.4, 1.0, 0.4)[0] == pytest.approx(1.0, abs=1e-14)
        assert describing(2.4, 1.0, 0.4)[1] == pytest.approx(1.0, abs=1e-14)

    def test_where_the_linear_pair_resonates_parametrically(self):
        """q(1) has its least zero in alpha at 0.4590, Omega = 0.5918: the unbounded branch of section 7."""
        pair = CONSISTENT.but(c=math.cos(math.radians(20.0)), eps_t=0.0)

        def least(alpha):
            places = [0.55 + 1e-4 * i for i in range(1000)]
            return min((reduced(pair.but(alpha=alpha).coefficients(w), 1.0)[0], w) for w in places)

        threshold = root(lambda alpha: -least(alpha)[0], 0.40, 0.50)
        assert round(threshold, 4) == 0.4590 and round(least(threshold)[1], 4) == 0.5918


class TestSection5:
    def test_without_varying_stiffness_a_closed_mesh_has_a_positive_determinant(self):
        at = PUBLISHED.but(alpha=0.0, b=0.0).coefficients(0.6)
        assert static_determinant(at, [0.7, 0.2, -0.1]) == pytest.approx(at.c * abs(at.D + at.A) ** 2)
        at = CONSISTENT.but(b=0.0).coefficients(0.6)
        assert static_determinant(at, [0.7, 0.2, -0.1]) == pytest.approx(at.c * reduced(at, 1.0)[0])

    def test_a_force_of_one_sign_is_larger_in_the_mean_than_half_its_fundamental(self):
        """Why a positive load keeps lambda_max above b at first order as long as |eps_r alpha| <= 1."""
        for mean, amplitude in ((-0.3, 0.9), (-1.6, 0.5), (-0.9, 1.7)):
            f_0, gain = describing(mean, amplitude, 1.0)
            assert mean + amplitude <= 1.0 and gain * amplitude <= 2.0 * abs(f_0) + 1e-15

    def test_the_sign_of_the_determinant_from_tangent_and_bordered_matrix(self):
        """det E_u = p' det B, along a curve of two unknowns."""
        random = Random(9)
        rows = [[random.uniform(-1, 1) for _ in range(3)] for _ in range(2)]
        minors = [determinant([[row[j] for j in range(3) if j != i] for row in rows]) for i in range(3)]
        length = math.hypot(*minors)
        tangent = [sign * minor / length for sign, minor in zip((1, -1, 1), minors, strict=True)]
        for row in rows:
            assert sum(x * y for x, y in zip(row, tangent, strict=True)) == pytest.approx(0.0, abs=1e-15)
        assert minors[2] == pytest.approx(tangent[2] * determinant([*rows, tangent]))

    def test_turning_points_of_fold_curves(self):
        """p - p* along the folds of A xi^2/2 + B xi eta + C eta^2/2 + h (p - p*) = 0."""
        for A, B, C, h in ((1.0, 0.4, 0.7, 0.5), (-1.2, 0.9, 0.3, 0.8), (0.6, -0.8, 0.2, -1.1)):
            eta = 0.3
            xi = -B * eta / A
            height = -(A * xi * xi / 2.0 + B * xi * eta + C * eta * eta / 2.0) / h
            assert height == pytest.approx(-(A * C - B * B) * eta * eta / (2.0 * h * A))
