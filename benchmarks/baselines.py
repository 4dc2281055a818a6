"""What speed is compared with, measured in the same run: the two programs that most authors write for such a pair.

(a) `scipy.optimize.fsolve` on the 21 unknowns of the uncondensed first-order balance, swept up and down in frequency,
each solution the start of the next. It finds what the two sweeps pass, and no unstable motion.
(b) Fixed-step Runge-Kutta of the seven degrees of freedom, compiled by numba, swept up and down, the last state of one
frequency the first of the next. It finds attractors, after so many periods of settling.
"""

import cmath

import numba
import numpy as np
from scipy.optimize import fsolve

from solver import Model
from solver.contact.dead_zone import describing_functions

__all__ = ["PERIODS", "STEPS", "fsolve_sweep", "residual", "runge_kutta_sweep", "there_and_back"]

#: Periods integrated per frequency, of which the last is looked at, and steps per period. Support damping of 0.01
#: leaves e^-9 of a transient after 150 periods at omega = 1.
PERIODS, STEPS = 150, 100


def there_and_back(grid: np.ndarray) -> np.ndarray:
    """The grid upwards, then downwards."""
    return np.concatenate([grid, grid[::-1]])


def residual(model: Model):
    """The balance of all seven degrees of freedom, a function of 21 unknowns and the frequency; nothing done twice."""
    mass, damping, stiffness = model.matrices()
    along_translation, along_rotation = model.mesh_vectors()
    wave = sum(a * cmath.exp(1j * phase) for a, phase in model.stiffness_harmonics()[:1])
    load = model.load_harmonics

    def balance(unknowns, omega):
        mean, cosine, sine = unknowns.reshape(3, 7)
        fundamental = complex(cosine[6], -sine[6])
        amplitude = abs(fundamental)
        f_0, gain = describing_functions(mean[6], amplitude, model.b)[:2]
        f_1 = gain * fundamental
        below, above = stiffness @ mean, (stiffness - omega**2 * mass + 1j * omega * damping) @ (cosine - 1j * sine)
        for vector, share in (
            (along_translation, model.variation_translation),
            (along_rotation, model.variation_rotation),
        ):
            varying = share * wave
            below = below + vector * (f_0 + 0.5 * (varying * np.conj(f_1)).real)
            above = above + vector * (f_1 + varying * f_0)
        constant, first = load(omega)
        below[6] -= constant.real
        above[6] -= first
        return np.concatenate([below, above.real, -above.imag])

    return balance


def fsolve_sweep(model: Model, grid: np.ndarray) -> tuple[np.ndarray, int]:
    """Amplitudes of the mesh coordinate up and down the grid, (2 X,), and how many solutions were found."""
    balance, start = residual(model), np.zeros(21)
    # From zero, inside the gap, nothing pulls: a guess with closed teeth is what everyone ends up with.
    start[6] = model.b + 1.0
    amplitudes, solved = np.full(2 * grid.size, np.nan), 0
    for i, omega in enumerate(there_and_back(grid)):
        start, _, status, _ = fsolve(balance, start, args=(omega,), full_output=True)
        if status == 1:
            solved += 1
            amplitudes[i] = np.hypot(start[13], start[20])
    return amplitudes, solved


@numba.njit(error_model="numpy")
def _integrate(state, omega, periods, steps, stiffness, damping, translation, rotation, drive, numbers):
    """Fixed-step RK4; the state after the last period (in place), and the first harmonic of lambda in it."""
    b, wave, phase, share_t, share_r, constant, cosine, sine = numbers
    h = 2.0 * np.pi / omega / steps
    slope, total, guess = np.empty(14), np.empty(14), np.empty(14)
    real = imag = 0.0
    for n in range(periods * steps):
        if n >= (periods - 1) * steps:
            angle = 2.0 * np.pi * (n % steps) / steps
            real += state[6] * np.cos(angle) * 2.0 / steps
            imag += state[6] * np.sin(angle) * 2.0 / steps
        total[:] = 0.0
        guess[:] = state
        for stage in range(4):
            angle = omega * (n + (0.0 if stage == 0 else 1.0 if stage == 3 else 0.5)) * h
            gap = guess[6]
            force = gap - b if gap > b else gap + b if gap < -b else 0.0
            vary = wave * np.cos(angle + phase)
            push = constant + cosine * np.cos(angle) + sine * np.sin(angle)
            for j in range(7):
                mesh = translation[j] * (1.0 + share_t * vary) + rotation[j] * (1.0 + share_r * vary)
                pull = drive[j] * push - mesh * force
                for k in range(7):
                    pull -= stiffness[j, k] * guess[k] + damping[j, k] * guess[7 + k]
                slope[j], slope[7 + j] = guess[7 + j], pull
            weight = 1.0 if stage == 0 or stage == 3 else 2.0
            reach = 0.5 * h if stage < 2 else h
            for j in range(14):
                total[j] += weight * slope[j]
                guess[j] = state[j] + reach * slope[j]
        for j in range(14):
            state[j] += h / 6.0 * total[j]
    return np.hypot(real, imag)


def runge_kutta_sweep(model: Model, grid: np.ndarray, periods: int = PERIODS, steps: int = STEPS) -> np.ndarray:
    """Amplitudes of the fundamental of lambda after settling, up and down the grid, (2 X,); one stiffness harmonic."""
    mass, damping, stiffness = model.matrices()
    inverse = np.linalg.inv(mass)
    translation, rotation = (inverse @ vector for vector in model.mesh_vectors())
    ((wave, phase),) = model.stiffness_harmonics()[:1] or ((0.0, 0.0),)
    state = np.zeros(14)
    state[6] = model.b + 1.0
    amplitudes = np.empty(2 * grid.size)
    for i, omega in enumerate(there_and_back(grid)):
        constant, first = model.load_harmonics(omega)
        numbers = (
            model.b,
            wave,
            phase,
            model.variation_translation,
            model.variation_rotation,
            constant.real,
            first.real,
            -first.imag,
        )
        amplitudes[i] = _integrate(
            state,
            omega,
            periods,
            steps,
            inverse @ stiffness,
            inverse @ damping,
            translation,
            rotation,
            np.ascontiguousarray(inverse[:, 6]),
            numbers,
        )
    return amplitudes
