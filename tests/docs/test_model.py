"""The equations of motion and their condensation: sections 1 to 3 and 10 of docs/physics.md.

Nothing of the solver is imported: page and solver are checked against the same third party.
"""

import cmath
import math
from random import Random

import pytest

from tests.docs.arithmetic import complex_number, dead_zone, slopes
from tests.docs.pair import CONSISTENT, PUBLISHED


class TestSection1:
    def test_the_contact_normal_has_length_1_as_derived_and_not_as_printed(self):
        cone, pressure = math.radians(35.0), math.radians(20.0)
        normal = math.cos(cone) * math.sin(pressure), math.sin(cone) * math.sin(pressure), math.cos(pressure)
        printed = math.cos(cone) * math.sin(pressure), math.cos(cone) * math.cos(pressure), math.cos(pressure)
        assert sum(x * x for x in normal) == pytest.approx(1.0, abs=1e-15)
        assert sum(x * x for x in printed) == pytest.approx(math.cos(cone) ** 2 + math.cos(pressure) ** 2)
        assert sum(x * x for x in printed) > 1.5

    def test_virtual_work_of_the_printed_displacement_is_no_force_along_the_normal(self):
        """Factors 1 instead of a_3: forces across the normal, and a torque that is not F_n a_3 r."""
        pressure, cone, radius = math.radians(20.0), math.radians(35.0), 0.05
        a_1, a_2, a_3 = math.cos(cone) * math.sin(pressure), math.sin(cone) * math.sin(pressure), math.cos(pressure)

        def displacement(third):
            return lambda q: a_1 * q[0] - a_2 * q[1] - third * q[2] + third * radius * q[3]

        for third, length in ((a_3, 1.0), (1.0, math.sqrt(a_1**2 + a_2**2 + 1.0))):
            (force,) = slopes(lambda q, third=third: [displacement(third)(q)], [0.0] * 4)
            assert math.hypot(*force[:3]) == pytest.approx(length, rel=1e-9)
            assert force[3] == pytest.approx(third * radius, rel=1e-9)


class TestSection2:
    def test_energy(self):
        """d/dtau [sum (x'^2 + k x^2)/(2 kappa) + psi'^2/(2 c) + V] = p psi'/c - damping, for any d and c."""
        random = Random(2)
        for _ in range(20):
            d = [random.uniform(-1, 1) for _ in range(6)]
            kappa = [random.uniform(0.2, 1.0)] * 3 + [random.uniform(0.2, 1.0)] * 3
            xi, k = [random.uniform(0, 0.1) for _ in d], [random.uniform(0.3, 2.0) for _ in d]
            c, xi_mesh, load, b = random.uniform(0.5, 1.5), 0.07, random.uniform(-1, 1), 0.4
            x, v = [random.uniform(-1, 1) for _ in d], [random.uniform(-1, 1) for _ in d]
            mesh, rate = random.uniform(-2, 2), random.uniform(-1, 1)
            force = dead_zone(mesh, b) + 2.0 * xi_mesh * rate
            acceleration = [-d[j] * kappa[j] * force - 2.0 * xi[j] * v[j] - k[j] * x[j] for j in range(6)]
            turning = rate - sum(d[j] * v[j] for j in range(6))
            turning_acceleration = load - c * force
            power = sum((v[j] * acceleration[j] + k[j] * x[j] * v[j]) / kappa[j] for j in range(6))
            power += turning * turning_acceleration / c + dead_zone(mesh, b) * rate
            taken = sum(2.0 * xi[j] * v[j] ** 2 / kappa[j] for j in range(6)) + 2.0 * xi_mesh * rate**2
            assert power == pytest.approx(load * turning / c - taken, abs=1e-12)


class TestSection3:
    def test_condensation(self):
        """Translations by the page's formula obey their rows, and the mesh row is then the condensed one."""
        random = Random(3)
        d, kappa = [random.uniform(-1, 1) for _ in range(6)], [0.4] * 3 + [0.7] * 3
        xi, k = [random.uniform(0, 0.1) for _ in d], [random.uniform(0.3, 2.0) for _ in d]
        xi_g, c, xi_mesh, omega = [0.02] * 3 + [0.03] * 3, 0.8, 0.06, 1.3
        R_t, R_r, mesh = complex_number(random), complex_number(random), complex_number(random)
        Z = [k[j] - omega**2 + 2j * xi[j] * omega for j in range(6)]
        X = [-d[j] * (kappa[j] * R_t + 2j * omega * xi_g[j] * mesh) / Z[j] for j in range(6)]
        T = omega**2 * sum(d[j] ** 2 * kappa[j] / Z[j] for j in range(6))
        U = omega**2 * sum(d[j] ** 2 * xi_g[j] / Z[j] for j in range(6))
        load = (-(omega**2) + 2j * omega * (c * xi_mesh - U)) * mesh + c * R_r - T * R_t
        for tau in (0.0, 0.7, 2.9):
            turn = cmath.exp(1j * omega * tau)
            for j in range(6):
                left = (-(omega**2) + 2j * xi[j] * omega + k[j]) * X[j] * turn
                right = -d[j] * (kappa[j] * R_t + 2.0 * xi_g[j] * 1j * omega * mesh) * turn
                assert left.real == pytest.approx(right.real, abs=1e-12)
            second = -(omega**2) * (mesh - sum(d[j] * X[j] for j in range(6)))
            row = second + c * (R_r + 2.0 * xi_mesh * 1j * omega * mesh)
            assert (row * turn).real == pytest.approx((load * turn).real, abs=1e-12)

    def test_any_system_with_one_contact(self):
        """D Lambda + A f + B q = G for two coordinates, whose rows are solved by Cramer's rule."""
        random = Random(5)
        Z = [[complex_number(random) for _ in range(2)] for _ in range(2)]
        w, h, h_v, F = ([complex_number(random) for _ in range(2)] for _ in range(4))
        f, q = complex_number(random), complex_number(random)

        def solved(matrix, right):
            (a, b), (c, d) = matrix
            return [(d * right[0] - b * right[1]) / (a * d - b * c), (a * right[1] - c * right[0]) / (a * d - b * c)]

        def seen(y):
            return w[0] * y[0] + w[1] * y[1]

        mesh = seen(solved(Z, [F[i] - h[i] * f - h_v[i] * q for i in range(2)]))
        closed = [[Z[i][j] + h[i] * w[j] for j in range(2)] for i in range(2)]
        A, B, G = (seen(solved(closed, right)) for right in (h, h_v, F))
        assert abs((1.0 - A) * mesh + A * f + B * q - G) < 1e-12

    @pytest.mark.parametrize("pair", [PUBLISHED, CONSISTENT])
    def test_linear_modes_and_their_strain_energy(self, pair):
        """(c - w)(k - w) = S w, so that w_1 w_2 = c k and w_1 + w_2 = c + k + S; S = (1 - w_1)(w_2 - 1) for k = 1."""
        total = 2.0 * pair.sigma * pair.kappa
        half = 0.5 * (pair.c + pair.k + total)
        squares = [half + sign * math.sqrt(half**2 - pair.c * pair.k) for sign in (-1.0, 1.0)]
        shares, printed = [], []
        for w in squares:
            undamped = pair.but(xi=0.0, xi_mesh=0.0, xi_translation=0.0).coefficients(math.sqrt(w))
            assert abs(undamped.D + undamped.A) < 1e-12
            # x_j = -d_j kappa/(k - w) beside lambda = 1; the sum of d_j^2 is 2 sigma.
            support = 2.0 * pair.sigma * (pair.kappa / (pair.k - w)) ** 2 * pair.k
            shares.append(1.0 / (1.0 + support / pair.kappa))
            printed.append(pair.c / (pair.c + support))
        assert total == pytest.approx((1.0 - squares[0]) * (squares[1] - 1.0))
        # Two springs, mesh and supports along d, and two modes: the shares of a spring over the modes add up to 1.
        assert sum(shares) == pytest.approx(1.0)
        expected = {PUBLISHED: (0.46, 0.54), CONSISTENT: (0.30, 0.70)}[pair]
        assert [round(share, 2) for share in shares] == list(expected)
        # With c in front of the mesh's energy and without 1/kappa they would not.
        assert abs(sum(printed) - 1.0) > 0.2

    def test_frequencies_that_the_page_names(self):
        found = []
        for pair in (PUBLISHED, CONSISTENT, CONSISTENT.but(c=math.cos(math.radians(20.0)))):
            half = 0.5 * (pair.c + 1.0 + pair.sigma)
            found += [math.sqrt(half + sign * math.sqrt(half**2 - pair.c)) for sign in (-1.0, 1.0)]
        assert [round(x, 4) for x in found] == [0.6925, 1.2687, 0.5902, 1.5921, 0.6041, 1.6046]


class TestSection10:
    def test_forces_at_rest(self):
        """Static force T_1/(r_1 cos alpha_n) in newtons, and -d_j F on every bearing."""
        r, J, T_1, k_m, b_c, pressure = (0.03, 0.08), (1e-3, 9e-3), 40.0, 3e8, 3e-5, math.radians(20.0)
        T_2, m_e = T_1 * r[1] / r[0], 1.0 / (r[0] ** 2 / J[0] + r[1] ** 2 / J[1])
        f_pm = math.cos(pressure) * m_e * (r[0] * T_1 / J[0] + r[1] * T_2 / J[1]) / (k_m * b_c)
        force = f_pm / math.cos(pressure) ** 2
        assert force * k_m * b_c == pytest.approx(T_1 / (r[0] * math.cos(pressure)), rel=1e-13)
        d_j, kappa, k_j, m_g = -0.3, 0.4, 1.7, m_e / 0.4
        x_j = -d_j * kappa * force / k_j
        unit = k_m * b_c / kappa
        assert unit == pytest.approx(m_g * (k_m / m_e) * b_c) and k_j * x_j * unit / (k_m * b_c) == pytest.approx(
            -d_j * force
        )

    def test_transmission_error_is_an_angle_times_a_base_radius(self):
        random = Random(10)
        d, a_3, r = [random.uniform(-1, 1) for _ in range(6)], 0.94, (0.03, 0.08)
        q, turns, e = [random.uniform(-1, 1) for _ in d], (0.4, -0.2), 0.3
        mesh = sum(d[j] * q[j] for j in range(6)) + a_3 * (r[0] * turns[0] - r[1] * turns[1]) - e
        psi = mesh - sum(d[j] * q[j] for j in range(6)) + e
        assert psi == pytest.approx(a_3 * (r[0] * turns[0] - r[1] * turns[1]))
