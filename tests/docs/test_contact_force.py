"""Harmonics of the contact force: sections 4.1 to 4.4 of docs/physics.md, against quadrature and differences.

Nothing of the solver is imported: page and solver are checked against the same third party.
"""

import cmath
import math
from random import Random

import pytest

from tests.docs.arithmetic import angles, average, coefficient, complex_number, dead_zone, describing, root, slopes

RIGHT = 0.5 * math.pi
#: Trapezoidal rule on a function with kinks.
QUADRATURE = 3e-6


class TestConvolution:
    HARMONICS = 3
    GAP = 0.6

    def motion(self, seed):
        """Two-sided coefficients L_0 ... L_H of a motion that touches both flanks, and lambda itself."""
        random = Random(seed)
        L = [complex(0.3)] + [complex_number(random) for _ in range(self.HARMONICS)]
        return (
            L,
            lambda theta: (
                L[0].real + 2.0 * sum((L[m] * cmath.exp(1j * m * theta)).real for m in range(1, self.HARMONICS + 1))
            ),
        )

    def spectra(self, motion, size):
        """chi^+ and chi^- in closed form from the crossing angles."""
        steps = [2.0 * math.pi * i / 600 for i in range(601)]
        spectra = []
        for sign in (1.0, -1.0):

            def beyond(theta, sign=sign):
                return sign * motion(theta) - self.GAP

            crossings = [
                (root(beyond, low, high), beyond(high) > 0.0)
                for low, high in zip(steps, steps[1:], strict=False)
                if (beyond(low) > 0.0) != (beyond(high) > 0.0)
            ]
            chi = [0j] * size
            for i, (begin, closes) in enumerate(crossings):
                if closes:
                    end = crossings[(i + 1) % len(crossings)][0]
                    end += 2.0 * math.pi if end < begin else 0.0
                    chi[0] += (end - begin) / (2.0 * math.pi)
                    for m in range(1, size):
                        chi[m] += (cmath.exp(-1j * m * begin) - cmath.exp(-1j * m * end)) / (2j * math.pi * m)
            spectra.append(chi)
        return spectra

    @staticmethod
    def at(chi, k):
        return chi[k] if k >= 0 else chi[-k].conjugate()

    @pytest.mark.parametrize("seed", [1, 2, 5])
    def test_harmonics_of_the_force_are_a_convolution(self, seed):
        L, motion = self.motion(seed)
        front, back = self.spectra(motion, 12)
        assert front[0].real > 0.05 and back[0].real > 0.05
        chi = [x + y for x, y in zip(front, back, strict=True)]
        for k in range(8):
            total = chi[k] * L[0] - self.GAP * (front[k] - back[k])
            for m in range(1, self.HARMONICS + 1):
                total += self.at(chi, k - m) * L[m] + chi[k + m] * L[m].conjugate()
            expected = coefficient(lambda theta: dead_zone(motion(theta), self.GAP), k)
            assert abs(total - expected) < QUADRATURE

    def test_its_jacobian_is_chi(self):
        L, motion = self.motion(2)
        front, back = self.spectra(motion, 12)
        chi = [x + y for x, y in zip(front, back, strict=True)]

        def force(real, k):
            """Two-sided f_k of the real unknowns (lambda_m, lambda_c1, lambda_s1, ...)."""

            def moved(theta):
                total = real[0]
                for m in range(1, self.HARMONICS + 1):
                    total += real[2 * m - 1] * math.cos(m * theta) + real[2 * m] * math.sin(m * theta)
                return dead_zone(total, self.GAP)

            return coefficient(moved, k)

        real = [L[0].real]
        for m in range(1, self.HARMONICS + 1):
            real += [2.0 * L[m].real, -2.0 * L[m].imag]
        for k in (0, 1, 2, 5):
            (found,) = slopes(lambda point, k=k: [force(point, k)], real, step=1e-3)
            expected = [chi[k]]
            for m in range(1, self.HARMONICS + 1):
                near, far = self.at(chi, k - m), chi[k + m]
                expected += [0.5 * (near + far), -0.5j * (near - far)]
            assert max(abs(x - y) for x, y in zip(found, expected, strict=True)) < 2e-3


class TestOneHarmonic:
    @pytest.mark.parametrize(
        "mean, amplitude, b", [(0.3, 1.7, 0.6), (1.4, 0.9, 1.0), (-0.2, 0.9, 0.5), (2.0, 0.5, 1.0)]
    )
    def test_one_harmonic(self, mean, amplitude, b):
        """The forms by theta, by G and H, and by the contact angles; f_2; derivatives of f_0 and N_a."""
        phase = 0.8
        motion = amplitude * cmath.exp(1j * phase)

        def force(theta):
            return dead_zone(mean + amplitude * math.cos(theta + phase), b)

        f_0, gain = describing(mean, amplitude, b)
        assert f_0 == pytest.approx(average(force), abs=QUADRATURE)
        assert abs(gain * motion - 2.0 * coefficient(force, 1)) < 2 * QUADRATURE

        def G(mu):
            return 2.0 / math.pi * (mu * math.asin(mu) + math.sqrt(1.0 - mu * mu)) if abs(mu) <= 1.0 else abs(mu)

        def H(mu):
            if abs(mu) > 1.0:
                return math.copysign(1.0, mu)
            return 2.0 / math.pi * (math.asin(mu) + mu * math.sqrt(1.0 - mu * mu))

        ahead, behind = (b - mean) / amplitude, (-b - mean) / amplitude
        assert f_0 == pytest.approx(mean + 0.5 * amplitude * (G(ahead) - G(behind)), abs=1e-12)
        assert gain == pytest.approx(1.0 - 0.5 * (H(ahead) - H(behind)), abs=1e-12)

        near, far = angles(mean, amplitude, b)
        front, back = RIGHT - near, far - RIGHT
        by_angles = (b - mean) * front + amplitude * math.cos(front) - (-b - mean) * back - amplitude * math.cos(back)
        if abs(ahead) <= 1.0:
            assert amplitude * math.sin(front) == pytest.approx(b - mean, abs=1e-12)
        assert f_0 == pytest.approx(mean + by_angles / math.pi, abs=1e-12)
        inside = front + math.sin(front) * math.cos(front) - back - math.sin(back) * math.cos(back)
        assert gain == pytest.approx(1.0 - inside / math.pi, abs=1e-12)

        second = 2.0 / (3.0 * math.pi) * (math.sin(near) ** 3 - math.sin(far) ** 3) * motion**2 / amplitude
        assert abs(second - 2.0 * coefficient(force, 2)) < 2 * QUADRATURE

        found = slopes(lambda point: list(describing(*point)), [mean, amplitude, b])
        difference, total = (math.sin(near) - math.sin(far)) / math.pi, (math.sin(near) + math.sin(far)) / math.pi
        doubled = (math.sin(2.0 * near) + math.sin(2.0 * far)) / math.pi
        expected = [
            [(near + far) / math.pi, difference, (far - near) / math.pi],
            [2.0 * difference / amplitude, doubled / amplitude, -2.0 * total / amplitude],
        ]
        for row, other in zip(found, expected, strict=True):
            assert row == pytest.approx(other, abs=1e-8)

    def test_large_motions_feel_the_gap_as_4_b_over_pi_amplitude(self):
        for amplitude in (1e3, 1e4):
            missing = 1.0 - describing(0.7, amplitude, 1.0)[1]
            assert missing * amplitude * math.pi / 4.0 == pytest.approx(1.0, rel=1e-5)

    def test_where_contact_loss_begins_the_second_harmonic_is_what_the_gain_lacks(self):
        for margin in (1e-2, 1e-4):
            mean, amplitude = 2.0 - margin, 1.0
            near, _ = angles(mean, amplitude, 1.0)
            second = 2.0 / (3.0 * math.pi) * math.sin(near) ** 3
            assert second / (1.0 - describing(mean, amplitude, 1.0)[1]) == pytest.approx(1.0, abs=2.0 * margin)


class TestBalances:
    def test_products_with_the_stiffness(self):
        """One-sided harmonics 0 and 1 of s f for s with two harmonics, and what first order leaves out: f_2 and f_3."""
        random = Random(7)
        S = [None, complex_number(random), complex_number(random)]
        f = [random.uniform(-1, 1)] + [complex_number(random) for _ in range(3)]

        def value(parts, theta, mean=0.0):
            return mean + sum((x * cmath.exp(1j * k * theta)).real for k, x in enumerate(parts) if k > 0)

        def product(theta):
            return value(S, theta) * value(f, theta, f[0])

        zeroth = 0.5 * sum((S[l] * f[l].conjugate()).real for l in (1, 2))
        assert average(product) == pytest.approx(zeroth, abs=1e-12)
        first = S[1] * f[0] + 0.5 * S[2] * f[1].conjugate() + 0.5 * (S[1].conjugate() * f[2] + S[2].conjugate() * f[3])
        assert abs(2.0 * coefficient(product, 1) - first) < 1e-12

    def test_the_printed_balance(self):
        """Mean and sine row of x'' + 2 z x' + (1 + K) f = F with f = f_0 + Re f_1 exp(i theta), by projection."""
        f_0, f_c, f_s, K_c, K_s, x_c, x_s, omega, zeta = 0.3, 0.5, -0.2, 0.15, 0.08, 0.9, 0.4, 1.3, 0.06

        def left(theta):
            cosine, sine = math.cos(theta), math.sin(theta)
            force = f_0 + f_c * cosine + f_s * sine
            return (
                -(omega**2) * (x_c * cosine + x_s * sine)
                + 2.0 * zeta * omega * (x_s * cosine - x_c * sine)
                + (1.0 + K_c * cosine + K_s * sine) * force
            )

        assert average(left) == pytest.approx(f_0 + 0.5 * (K_c * f_c + K_s * f_s), abs=1e-12)
        sine_row = 2.0 * average(lambda theta: left(theta) * math.sin(theta))
        expected = -(omega**2) * x_s - omega * 2.0 * zeta * x_c + f_s + K_s * f_0
        assert sine_row == pytest.approx(expected, abs=1e-12)
