"""Forcing periods per second of direct integration on one core, beside heyoka 7 where it is installed.

    python -m benchmarks.integrator

heyoka (F. Biscani, D. Izzo, "Revisiting high-order Taylor methods for astrodynamics and celestial mechanics", Monthly
Notices of the RAS 504 (2021) 2614-2628) compiles the same equations of motion, with the contact switches as terminal
events. All programs carry the same random states, and their ends after three periods are compared first. Processor
time.
"""

import time

import numpy as np

from solver.model.contact_system import ContactSystem, gear_system
from solver.timedomain import advance, integrate
from tests.conftest import published

TOLERANCE, STATES, PERIODS = 1e-9, 20, 1000


def spur_pair() -> ContactSystem:
    """The pair of A. Kahraman and R. Singh, Journal of Sound and Vibration 146 (1991) 135-156, with three harmonics."""
    inertial = np.array([[0.0], [0.01], [0.004], [0.002]], dtype=complex)
    harmonics = [(0.2, np.pi), (0.1, np.pi), (0.05, np.pi)]
    return ContactSystem([[1.0]], [[0.1]], [[0.0]], [1.0], [1.0], 1.0, 1.0, [1.0], harmonics, [[0.1]], inertial)


def states_of(system: ContactSystem) -> np.ndarray:
    """Random states (STATES, 2 n): lambda from 0.5 to 2, its speed from -1 to 1, all else at rest."""
    rng, states = np.random.default_rng(1), np.zeros((STATES, 2 * system.degrees))
    states[:, system.degrees - 1] = rng.uniform(0.5, 2.0, STATES)
    states[:, -1] = rng.uniform(-1.0, 1.0, STATES)
    return states


def tables(system, omega, states, periods):
    """Ends of the motions by the flows of the zones."""
    return advance(system, omega, states, periods, tolerance=TOLERANCE).states[:, -1]


def stepwise(system, omega, states, periods):
    """Ends of the motions by one Taylor series a step; they keep their steps, as a call of `integrate` does."""
    stop = 2.0 * np.pi / omega * periods
    return np.array([integrate(system, omega, s, 0.0, stop, tolerance=TOLERANCE).states[-1] for s in states])


class Heyoka:
    """The same with heyoka; parameters 0 and 1 of its system are contact (0 or 1) and offset of the zone."""

    def __init__(self, system: ContactSystem, omega: float):
        import heyoka

        self.system, self.omega, n = system, omega, system.degrees
        y, v = (heyoka.make_vars(*(f"{name}{i}" for i in range(n))) for name in "yv")
        y, v = (list(part) if n > 1 else [part] for part in (y, v))
        inverse = np.linalg.inv(system.mass)
        stiffness, damping, force, varying = (
            inverse @ part for part in (system.stiffness, system.damping, system.force, system.varying_force)
        )
        loads = system.load_harmonics(omega, max(len(system.load), len(system.inertial_load)) - 1) @ inverse.T
        waves = [(heyoka.cos(l * omega * heyoka.time), heyoka.sin(l * omega * heyoka.time)) for l in range(1, 4)]
        s = sum(
            a * np.cos(phase) * waves[l][0] - a * np.sin(phase) * waves[l][1]
            for l, (a, phase) in enumerate(system.stiffness_harmonics)
        )
        displacement = sum(w * part for w, part in zip(system.contact, y, strict=True) if w != 0.0)
        squeezed = heyoka.par[0] * (displacement - heyoka.par[1])
        rates = []
        for i in range(n):
            total = loads[0, i].real - force[i] * squeezed
            if varying[i] != 0.0:
                total -= varying[i] * s * squeezed
            for l in range(1, len(loads)):
                if loads[l, i] != 0.0:
                    total += loads[l, i].real * waves[l - 1][0] - loads[l, i].imag * waves[l - 1][1]
            for j in range(n):
                if stiffness[i, j] != 0.0:
                    total -= stiffness[i, j] * y[j]
                if damping[i, j] != 0.0:
                    total -= damping[i, j] * v[j]
            rates.append(total)
        events = [
            heyoka.t_event(displacement - level, callback=self._switch(side))
            for level, side in ((system.front_gap, 1), (-system.back_gap, -1))
        ]
        self.integrator = heyoka.taylor_adaptive(
            [*zip(y, v, strict=True), *zip(v, rates, strict=True)],
            [0.0] * (2 * n),
            pars=[1.0, 1.0],
            tol=TOLERANCE,
            t_events=events,
        )

    def _switch(self, side):
        def callback(integrator, rising):
            # Upwards through the front gap into contact, through the back gap out of it.
            self._enter(side if (rising > 0) == (side > 0) else 0)
            return True

        return callback

    def _enter(self, zone):
        offset = {1: self.system.front_gap, 0: 0.0, -1: -self.system.back_gap}[zone]
        self.integrator.pars[0], self.integrator.pars[1] = abs(zone), offset

    def __call__(self, states, periods):
        ends = np.empty_like(states)
        for state, end in zip(states, ends, strict=True):
            displacement = self.system.contact @ state[: self.system.degrees]
            self._enter(int(displacement > self.system.front_gap) - int(displacement < -self.system.back_gap))
            self.integrator.time = 0.0
            self.integrator.state[:] = state
            self.integrator.propagate_until(2.0 * np.pi / self.omega * periods)
            end[:] = self.integrator.state
        return ends


def rate(carry, *arguments) -> float:
    """Forcing periods per second of processor time, the best of three."""
    found = []
    for _ in range(3):
        begin = time.process_time()
        carry(*arguments, PERIODS)
        found.append(time.process_time() - begin)
    return STATES * PERIODS / min(found)


def main():
    """Print the table."""
    try:
        import heyoka

        print(f"heyoka {heyoka.__version__}, tolerance {TOLERANCE:g}, {STATES} states, forcing periods per second")
    except ImportError:
        heyoka = None
        print(f"heyoka is not installed; tolerance {TOLERANCE:g}, {STATES} states, forcing periods per second")
    print(f"{'':<10} {'Omega':>6} {'tables':>12} {'stepwise':>12} {'ratio':>7} {'heyoka':>12} {'ratio':>7}")
    for name, system, frequencies in (
        ("spur pair", spur_pair(), (0.5, 0.8, 1.8)),
        ("published", gear_system(published()), (0.6, 1.2)),
    ):
        states = states_of(system)
        for omega in frequencies:
            ours, steps = rate(tables, system, omega, states), rate(stepwise, system, omega, states)
            line = f"{name:<10} {omega:>6} {ours:>12,.0f} {steps:>12,.0f} {ours / steps:>7.1f}"
            if heyoka is not None:
                other = Heyoka(system, omega)
                np.testing.assert_allclose(other(states, 3), tables(system, omega, states, 3), atol=1e-6)
                theirs = rate(other, states)
                line += f" {theirs:>12,.0f} {ours / theirs:>7.1f}"
            print(line, flush=True)


if __name__ == "__main__":
    main()
