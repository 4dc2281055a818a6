"""The laws, a system that has them, and motions that strike both of its flanks."""

import numpy as np
import pytest

from solver import ContactSystem
from solver.harmonic.galerkin import Galerkin

LAWS = {
    "soft back": dict(back_stiffness=0.3),
    "stiff back": dict(back_stiffness=2.5),
    "dashpot": dict(contact_dashpot=0.2),
    "both": dict(back_stiffness=0.5, contact_dashpot=0.15),
}
CUBIC = {
    "cubic": dict(cubic=0.4),
    "softening": dict(cubic=-0.05, back_stiffness=2.0),
    "cubic and dashpot": dict(cubic=0.3, contact_dashpot=0.1, back_stiffness=0.6),
}
laws = pytest.mark.parametrize("law", list(LAWS.values()), ids=list(LAWS))
all_laws = pytest.mark.parametrize("law", [*LAWS.values(), *CUBIC.values()], ids=[*LAWS, *CUBIC])
OMEGA = 0.9


def pair(**changes) -> ContactSystem:
    """Two masses on springs, gaps that differ, a stiffness that varies; both flanks are struck at OMEGA."""
    given = dict(
        mass=[[1.0, 0.1], [0.1, 0.8]],
        damping=[[0.08, -0.02], [-0.02, 0.06]],
        stiffness=[[0.6, -0.2], [-0.2, 0.4]],
        contact=[1.0, -0.5],
        force=[0.7, -0.35],
        front_gap=0.3,
        back_gap=0.5,
        varying_force=[0.35, -0.175],
        stiffness_harmonics=((0.3, 0.2), (0.1, 1.0)),
        load=[[0.05, 0.0], [0.5, 0.2j]],
    )
    return ContactSystem(**{**given, **changes})


def random_motion(order: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=2 * order + 1) / np.maximum(1.0, np.arange(2 * order + 1) / 2.0)


def sampled(system: ContactSystem, balance: Galerkin, motion, samples: int = 2**14):
    """Angles, lambda, d lambda/d theta, f and its slope of a motion."""
    theta = 2.0 * np.pi * (np.arange(samples) + 0.5) / samples
    k = np.arange(1, balance.harmonics + 1)
    waves = np.exp(1j * np.multiply.outer(theta, k))
    place = motion[0] + waves.real @ motion[1::2] + waves.imag @ motion[2::2]
    speed = waves.real @ (k * motion[2::2]) - waves.imag @ (k * motion[1::2])
    slope = np.where(place > system.front_gap, 1.0, np.where(place < -system.back_gap, system.back_stiffness, 0.0))
    return theta, place, speed, system.contact_force(place), slope
