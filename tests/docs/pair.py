"""The first-order balance of a pair with six supports alike, written from docs/physics.md alone."""

import cmath
import math
from dataclasses import dataclass, replace

from tests.docs.arithmetic import angles, describing, determinant

__all__ = [
    "CONSISTENT",
    "PUBLISHED",
    "SETS",
    "Coefficients",
    "Pair",
    "corrected",
    "found",
    "jacobian",
    "reduced",
    "residual",
    "static_determinant",
]


@dataclass(frozen=True)
class Coefficients:
    """What the balance depends on at one frequency (section 4.5)."""

    D: complex
    A: complex
    P_1: complex
    P_2: complex
    F: complex
    e: complex
    c: float
    f_pm: float
    b: float


@dataclass(frozen=True)
class Pair:
    """Parameters of section 7."""

    sigma: float
    c: float
    eps_t: float
    eps_r: float
    phase: float
    alpha: float = 0.2
    f_e: float = 0.2
    f_pm: float = 0.5
    b: float = 1.0
    kappa: float = 0.5
    xi_translation: float = 0.0125
    xi_mesh: float = 0.05
    xi: float = 0.01
    k: float = 1.0

    def but(self, **changes) -> "Pair":
        """The same pair with other parameters."""
        return replace(self, **changes)

    def receptance(self, omega):
        """T and U at one frequency: two gears of sigma each."""
        per_z = omega**2 / (self.k - omega**2 + 2j * self.xi * omega)
        return 2.0 * self.sigma * self.kappa * per_z, 2.0 * self.sigma * self.xi_translation * per_z

    def coefficients(self, omega) -> Coefficients:
        """Of the balance at one mesh frequency."""
        T, U = self.receptance(omega)
        S = self.alpha * cmath.exp(1j * self.phase)
        varying = self.c * self.eps_r - T * self.eps_t
        D = -(omega**2) + 2j * omega * (self.c * self.xi_mesh - U)
        e = 0.5 * self.c * self.eps_r * S
        return Coefficients(D, self.c - T, varying * S, 0j, self.f_e * omega**2 + 0j, e, self.c, self.f_pm, self.b)


PUBLISHED = Pair(sigma=0.3173, c=0.7719, eps_t=1.0, eps_r=0.0, phase=0.0)
CONSISTENT = Pair(sigma=1.0, c=math.cos(math.radians(20.0)) ** 2, eps_t=1.0, eps_r=1.0, phase=0.0)
ANTIPHASE = CONSISTENT.but(phase=math.pi)
#: By the names of the tables of section 7.4.
SETS = {
    "published": PUBLISHED,
    "consistent": CONSISTENT,
    "antiphase": ANTIPHASE,
    "isola": CONSISTENT.but(c=math.cos(math.radians(20.0)), alpha=0.44),
}


def _rows(at: Coefficients, f_0, f_1, motion):
    """The part of (E_0, Re E_1, -Im E_1) that is linear in f_0, f_1 and Lambda_1."""
    first = at.D * motion + at.A * f_1 + at.P_1 * f_0 + at.P_2 * f_1.conjugate()
    return [at.c * f_0 + (at.e * f_1.conjugate()).real, first.real, -first.imag]


def residual(at: Coefficients, unknowns):
    """(E_0, Re E_1, -Im E_1) at (lambda_m, lambda_c, lambda_s)."""
    motion = complex(unknowns[1], -unknowns[2])
    f_0, gain = describing(unknowns[0], abs(motion), at.b)
    rows = _rows(at, f_0, gain * motion, motion)
    return [rows[0] - at.f_pm, rows[1] - at.F.real, rows[2] + at.F.imag]


def jacobian(at: Coefficients, unknowns):
    """Its derivatives by the unknowns, from the angles of contact."""
    motion = complex(unknowns[1], -unknowns[2])
    unit = motion / abs(motion)
    near, far = angles(unknowns[0], abs(motion), at.b)
    gain = describing(unknowns[0], abs(motion), at.b)[1]
    chi = (near + far) / math.pi
    by_amplitude = (math.sin(near) - math.sin(far)) / math.pi
    by_mean = 2.0 * by_amplitude
    along = (math.sin(2.0 * near) + math.sin(2.0 * far)) / math.pi
    columns = []
    for v_m, v in ((1.0, 0j), (0.0, 1.0 + 0j), (0.0, -1j)):
        v_a = (unit.conjugate() * v).real
        d_f_1 = gain * v + unit * (by_mean * v_m + along * v_a)
        columns.append(_rows(at, chi * v_m + by_amplitude * v_a, d_f_1, v))
    return [list(row) for row in zip(*columns, strict=True)]


def static_determinant(at: Coefficients, unknowns):
    """det J."""
    return determinant(jacobian(at, unknowns))


def reduced(at, t):
    """q, l and n of section 4.6 at one gain."""
    half = at.P_1 / (2.0 * at.c)
    X = at.D + t * (at.A - half * at.e.conjugate())
    Q = at.P_2 - half * at.e
    G = at.F - at.P_1 * at.f_pm / at.c
    q = abs(X) ** 2 - t**2 * abs(Q) ** 2
    l = X.conjugate() * G - t * Q * G.conjugate()
    return q, l, (at.f_pm * q - t * (at.e * l.conjugate()).real) / at.c


def corrected(at, unknowns):
    """The solution near some unknowns, by Newton's method with Cramer's rule."""
    point = list(unknowns)
    for _ in range(20):
        rest, matrix = residual(at, point), jacobian(at, point)
        whole = determinant(matrix)
        for j in range(3):
            swapped = [[-rest[i] if k == j else matrix[i][k] for k in range(3)] for i in range(3)]
            point[j] += determinant(swapped) / whole
    return point


def found(pair, omega, mean, amplitude):
    """(lambda_m, lambda_c, lambda_s) of a solution whose mean and amplitude are printed: its phase follows."""
    at = pair.coefficients(omega)
    _, gain = describing(mean, amplitude, pair.b)
    q, l, _ = reduced(at, gain)
    motion = l / q
    motion *= amplitude / abs(motion)
    return [mean, motion.real, -motion.imag]
