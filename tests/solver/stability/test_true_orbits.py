"""Dynamic stability of a balance's motions against the true orbits next to them, found by shooting.

The orbit's own multipliers are exact. What is compared is whether a statically stable motion that loses contact is a
period doubling, a Neimark-Sacker or neither: +1 is left to det J (docs/physics.md, section 6).
"""

import numpy as np
import pytest

from solver import sweep_row
from solver.harmonic.galerkin import Galerkin
from solver.model.contact_system import gear_system
from solver.stability import Instability, assess, classify
from solver.timedomain import ShootingStatus, orbit_state, shoot
from tests.conftest import antiphase, consistent, published
from tests.solver.stability.orbits import galerkin_motion

GEARS = {"published": published, "consistent": consistent, "antiphase": antiphase}
UNSTABLE = (Instability.PERIOD_DOUBLING, Instability.NEIMARK_SACKER)


def losing_contact(make, seed: int, rows: int):
    """First-order motions (f_e, Omega, motion) of seeded rows that are statically stable and lose contact."""
    random = np.random.default_rng(seed)
    for f_e in random.uniform(0.1, 0.45, rows):
        row = sweep_row(make(f_e=float(f_e)), "omega", np.sort(random.uniform(0.3, 1.9, 40)))
        for column, place in np.argwhere((row.stable == 1) & (row.impact >= 1)):
            yield float(f_e), float(row.grid[column]), row.motions[column, place]


def agreement(make, order: int, seed: int, rows: int, most: int):
    """How many motions were compared, and how many of them the true orbit agrees with."""
    counted, agreed = 0, 0
    motions = list(losing_contact(make, seed, rows))
    chosen = np.random.default_rng(seed).permutation(len(motions))[:most]
    for f_e, omega, motion in (motions[i] for i in chosen):
        model, balance = make(f_e=f_e), None
        if order > 1:
            balance = Galerkin(order)
            try:
                motion = galerkin_motion(model, balance, omega, motion)
            except ArithmeticError:
                continue
        system = gear_system(model)
        orbit = shoot(system, omega, orbit_state(system, omega, motion))
        near = abs(orbit.harmonics[1]) - np.hypot(motion[1], motion[2])
        if orbit.status is not ShootingStatus.CONVERGED or not abs(near) < 0.25:
            continue
        (said,) = assess(model, "omega", [omega], motion[None], balance=balance, static=[1]).kind
        (true,) = classify(orbit.multipliers[None])
        counted += 1
        agreed += (said if said in UNSTABLE else 0) == (true if true in UNSTABLE else 0)
    return counted, agreed


@pytest.mark.parametrize("gear", GEARS)
@pytest.mark.parametrize("order, share", [(1, 0.93), (5, 1.0)])
def test_a_sample_of_motions(gear, order, share):
    counted, agreed = agreement(GEARS[gear], order, 3, 3, 24)
    assert counted >= 12 and agreed >= share * counted - 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("order, share", [(1, 0.96), (3, 0.99), (5, 1.0), (9, 1.0)])
def test_several_hundred_motions(order, share):
    found = [agreement(make, order, 11, 12, 150) for make in GEARS.values()]
    counted, agreed = np.sum(found, axis=0)
    assert counted >= 300 and agreed >= share * counted - 1e-9, found
