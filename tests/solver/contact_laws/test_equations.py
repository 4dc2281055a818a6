"""Contact laws beside the plain dead zone - unlike flanks, damping of touching teeth, a cubic spring - in balances,
boundaries and proofs; each is held against an independent method."""

from dataclasses import replace

import numpy as np
import pytest

from solver import DescribingFunction, Event, ParameterError, ProvenSeeds, sweep_row
from solver.boundaries import BIFURCATIONS
from solver.boundaries.first_order import FirstOrderProblem
from solver.boundaries.harmonic import HarmonicProblem
from solver.boundaries.problem import Plane
from solver.harmonic.describing_function import evaluate
from solver.harmonic.galerkin import Galerkin
from solver.stability import motion_multipliers
from solver.timedomain import shoot
from tests.solver.contact_laws.laws import OMEGA, all_laws, laws, pair, random_motion, sampled
from tests.solver.enumeration.test_systems import by_newton
from tests.solver.harmonic.projection import evaluated


@all_laws
@pytest.mark.parametrize("balance", [Galerkin(3), Galerkin(2, 2)], ids=repr)
def test_the_balance_is_the_projection_of_the_law(law, balance):
    """The damper's force is sampled as what it is, c_c lambda' while the teeth touch."""
    system, base = pair(**law), OMEGA / balance.period
    for seed in range(3):
        u = random_motion(balance.harmonics, seed)
        theta, place, speed, force, slope = sampled(system, balance, u)
        plain = force + system.contact_dashpot * slope * speed * base + system.cubic * place**3
        varied = force * sum(
            size * np.cos(l * balance.period * theta + phase)
            for l, (size, phase) in enumerate(system.stiffness_harmonics, 1)
        )
        residual, _ = evaluated(balance.problem(system, "omega", 0.1, 2.0), np.append(u, OMEGA))
        for k in range(balance.harmonics + 1):
            wave = np.exp(-1j * k * theta) * (1.0 if k == 0 else 2.0) / theta.size
            dynamic = system.dynamic_stiffness(k * base)
            load = system.load_harmonics(OMEGA, 1)[k // balance.period] if k in (0, balance.period) else 0.0
            right = load - system.force * (wave @ plain) - system.varying_force * (wave @ varied)
            row = (complex(u[2 * k - 1], -u[2 * k]) if k else u[0]) - system.contact @ np.linalg.solve(dynamic, right)
            row /= 1.0 + system.contact @ np.linalg.solve(dynamic, system.force)
            found = complex(residual[2 * k - 1], -residual[2 * k]) if k else residual[0]
            scale = np.abs(np.array([row.real, 1e-3 if k == 0 else row.imag])).max()
            ratio = found / row
            # Rows carry a factor that is a power of two.
            assert abs(ratio - 2.0 ** np.round(np.log2(abs(ratio)))) < 2e-3 / scale


@all_laws
@pytest.mark.parametrize("axis", ["omega", "gap_scale", "contact_damping"])
def test_jacobians_are_differences(law, axis):
    system = pair(**law)
    for balance in (Galerkin(3), Galerkin(2, 2), *(() if system.cubic else (DescribingFunction(),))):
        problem = balance.problem(system, axis, 0.2, 2.0, OMEGA)
        for seed in range(4):
            y = np.append(random_motion(problem.unknowns // 2, seed), 0.93)
            jacobian = evaluated(problem, y)[1]
            columns = [
                (evaluated(problem, y + 1e-6 * e)[0] - evaluated(problem, y - 1e-6 * e)[0]) / 2e-6
                for e in np.eye(y.size)
            ]
            size = max(1.0, np.max(np.abs(jacobian)))
            np.testing.assert_allclose(jacobian, np.transpose(columns), rtol=0, atol=2e-6 * size)


@laws
def test_first_order_is_galerkin_of_order_one_where_the_stiffness_is_steady(law):
    system = pair(**law, stiffness_harmonics=())
    for seed in range(4):
        u = random_motion(1, seed)
        first, galerkin = evaluate(system, OMEGA, u), Galerkin(1).problem(system, "omega", 0.1, 2.0)
        residual, jacobian = evaluated(galerkin, np.append(u, OMEGA))
        np.testing.assert_allclose(first[0], residual, rtol=0, atol=1e-12)
        np.testing.assert_allclose(first[1], jacobian[:, :3], rtol=0, atol=1e-12)


def test_a_dashpot_without_a_gap_is_a_damper():
    """Where the teeth always touch it is C + c_c h w^T."""
    closed = pair(front_gap=0.0, back_gap=0.0)
    touching, damped = replace(closed, contact_dashpot=0.3), closed.at("contact_damping", 0.3)
    u, balance = random_motion(4, 1), Galerkin(4)
    rows = [evaluated(balance.problem(one, "omega", 0.1, 2.0), np.append(u, OMEGA)) for one in (touching, damped)]
    steps = [np.linalg.solve(jacobian[:, :-1], residual) for residual, jacobian in rows]
    np.testing.assert_allclose(*steps, rtol=0, atol=1e-10)
    orbits = [shoot(one, OMEGA, np.zeros(4)) for one in (touching, damped)]
    np.testing.assert_allclose(orbits[0].state, orbits[1].state, rtol=0, atol=1e-9)
    np.testing.assert_allclose(orbits[0].multipliers, orbits[1].multipliers, rtol=0, atol=1e-9)


def rows(problem, y):
    residual, jacobian = np.empty(problem.unknowns), np.empty((problem.unknowns, y.size))
    problem.residual_and_jacobian(problem.parameters, problem.parameter_slope, y, residual, jacobian)
    return residual, jacobian


@laws
@pytest.mark.parametrize("order", [None, 3], ids=["first order", "order 3"])
def test_rows_of_boundaries(law, order):
    """Test functions are those of the multipliers, and the derivatives of all rows are differences."""
    system = pair(**law)
    plane = Plane(system, "omega", "gap_scale", (0.5, 1.5), (0.4, 1.6))
    found = FirstOrderProblem(plane) if order is None else HarmonicProblem(plane, Galerkin(order))
    place, rng = np.array([OMEGA, 1.0]), np.random.default_rng(4)
    for kind in (Event.FOLD, *BIFURCATIONS):
        for seed in range(4):
            u, kappa = random_motion(order or 1, seed), rng.uniform(-1.0, 1.0)
            point, torus = np.concatenate([u, place]), kind is Event.NEIMARK_SACKER
            if order is None:
                starts = [(contact, found.lift(kind, contact, point)) for contact in found.zones(kind, point)]
                starts = [(contact, np.insert(y, 5, kappa) if torus else y) for contact, y in starts]
            else:
                starts = [(None, np.insert(point, -2, kappa) if torus else point)]
            for contact, y in starts:
                problem = found.problem(kind, contact)
                residual, jacobian = rows(problem, y)
                if kind is Event.PERIOD_DOUBLING:
                    multipliers = motion_multipliers(system, OMEGA, u)
                    expected = np.prod(1.0 + multipliers).real
                    assert abs(residual[-1] - expected) < 1e-8 * np.prod(1.0 + np.abs(multipliers))
                slopes = [
                    np.transpose(
                        [
                            (rows(problem, y + h * e)[0] - rows(problem, y - h * e)[0]) / (2.0 * h)
                            for e in np.eye(y.size)
                        ]
                    )
                    for h in (4e-6, 2e-6)
                ]
                size = 1.0 + np.max(np.abs(jacobian), axis=1, keepdims=True)
                close = np.max(np.abs(slopes[1] - slopes[0]) / size) < 1e-6
                error = np.max(np.abs(jacobian - (4.0 * slopes[1] - slopes[0]) / 3.0) / size)
                assert error < (1e-7 if close else 1e-3), (kind, contact)


@laws
def test_a_row_is_proven(law):
    """And Newton's method finds nothing else in it."""
    load, rng = [[0.05, 0.0], [0.06, 0.02j]], np.random.default_rng(3)
    system = pair(**law, stiffness_harmonics=(), load=load, damping=0.02 * np.eye(2))
    row = sweep_row(system, "omega", np.linspace(1.05, 1.15, 11), seeds=ProvenSeeds(columns=21))
    assert np.all(row.certified == 1)
    assert row.n_solutions.max() == 3
    for column in (0, int(np.argmax(row.n_solutions))):
        motions = row.motions[column, : row.n_solutions[column]]
        for motion in by_newton(system, float(row.grid[column]), rng, 20):
            assert np.min(np.max(np.abs(motions - motion), axis=1)) < 1e-6


@pytest.mark.parametrize(
    ("name", "value"),
    [("back_stiffness", 0.0), ("back_stiffness", -1.0), ("back_stiffness", np.nan), ("back_stiffness", "1")]
    + [
        ("cubic", np.nan),
        ("cubic", "1"),
        ("contact_dashpot", -0.1),
        ("contact_dashpot", np.inf),
        ("contact_dashpot", None),
    ],
)
def test_bad_values_are_refused(name, value):
    with pytest.raises(ParameterError, match=name):
        pair(**{name: value})
