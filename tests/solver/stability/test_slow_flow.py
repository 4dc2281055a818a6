"""The weakly nonlinear limit, in which the oscillator is Duffing's: multipliers of both branches by averaging.

x'' + 2 xi x' + f(x) = F cos(Omega tau) with a gap that is small against the amplitude. With x = Re(A exp(i Omega tau))
and the gain N(a) of the gap, 2i Omega A' + (N(|A|) - Omega^2 + 2i xi Omega) A = F for slow A (Krylov and Bogoliubov).
About a steady motion of amplitude a, r = a N'(a)/2 and p = N - Omega^2 + r, its exponents are
-xi +- sqrt(r^2 - p^2)/(2 Omega).
"""

import cmath

import numpy as np
import pytest

from solver import ContactSystem, Continuation
from solver.contact.dead_zone import describing_functions
from solver.harmonic.galerkin import Galerkin
from solver.stability import Instability, assess, motion_multipliers

XI, LOAD = 0.01, 0.03


@pytest.mark.parametrize("gap, accuracy", [(0.04, 8e-3), (0.01, 4e-3)])
def test_multipliers_are_those_of_the_averaged_flow(gap, accuracy):
    system = ContactSystem(
        mass=[[1.0]],
        damping=[[2.0 * XI]],
        stiffness=[[0.0]],
        contact=[1.0],
        force=[1.0],
        front_gap=gap,
        back_gap=gap,
        load=[[0.0], [LOAD]],
    )
    balance = Galerkin(15)
    closing = balance.problem(system, "gap", 0.0, gap, 0.9)
    _, linear = balance.linear_solution(closing, 0.0)
    opened = Continuation(parameter_step=0.1).trace(closing, np.append(linear, 0.0), 0.0, gap)
    start = np.append(opened.points[-1, :-1], 0.9)
    curve = Continuation(largest_step=0.05).trace(balance.problem(system, "omega", 0.9, 1.1), start, 0.9, 1.1)
    amplitude, omega = np.hypot(curve.points[:, 1], curve.points[:, 2]), curve.points[:, -1]
    # The averaged frequency is off by the square of the detuning.
    gains = np.array([describing_functions(0.0, a, gap)[1] for a in amplitude])
    near = np.abs(gains - omega**2) < 0.05
    chosen = np.flatnonzero(near & (amplitude > 10.0 * gap) & (curve.event == 0))
    assert chosen.size > 20
    oscillating = 0
    for i in chosen:
        a, w = amplitude[i], omega[i]
        _, gain, *_, gain_a, _ = describing_functions(0.0, a, gap)
        r = 0.5 * gain_a
        p = gain - w * w + r
        root = cmath.sqrt(r * r - p * p) / (2.0 * w)
        expected = np.exp(2.0 * np.pi / w * np.array([-XI - root, -XI + root]))
        found = motion_multipliers(system, w, curve.points[i, :-1])
        assert np.max(np.abs(np.sort_complex(found) - np.sort_complex(expected))) < accuracy
        oscillating += abs(root.imag) > 1e-3
    assert oscillating > 0
    kinds = assess(system, "omega", omega[chosen], curve.points[chosen, :-1], balance=balance).kind
    assert np.all(np.isin(kinds, (Instability.NONE, Instability.FOLD)))
    np.testing.assert_array_equal(kinds == Instability.NONE, curve.stable[chosen] == 1)
