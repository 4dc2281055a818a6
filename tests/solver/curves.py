"""Curves of the gear pair over the mesh frequency, and what holds along every one of them."""

import numpy as np

from solver import Continuation, Event, first_order_problem, impact_state
from solver.harmonic.describing_function import evaluate
from tests.solver.exhaustive import all_solutions

LOW, HIGH = 0.05, 2.0
COS_20 = 0.93969262

#: Extremes and flanks that an event of each kind says are equal: (min or max, +b or -b).
GRAZINGS = {
    Event.MIN_AT_DRIVE: (-1.0, -1.0),
    Event.MIN_AT_BACK: (-1.0, 1.0),
    Event.MAX_AT_DRIVE: (1.0, -1.0),
    Event.MAX_AT_BACK: (1.0, 1.0),
}


def swept(model, **settings_):
    """The curve over frequency that starts from the (single) solution at its low end."""
    problem = first_order_problem(model, "omega", LOW, HIGH)
    start = all_solutions(model, LOW)
    assert len(start) == 1
    return Continuation(**settings_).trace(problem, np.append(start[0], LOW), LOW, HIGH)


def folds(curve):
    """(Omega, lambda_m, lambda_a) of all folds, ascending."""
    at = np.flatnonzero(curve.event == Event.FOLD)
    return sorted((p[3], p[0], a) for p, a in zip(curve.points[at], curve.amplitude[at], strict=True))


def margins(curve, model):
    """(points, 4) values that vanish at the four kinds of grazing."""
    mean, amplitude = curve.points[:, 0], curve.amplitude
    return np.column_stack([mean + e * amplitude + f * model.b for e, f in GRAZINGS.values()])


def check_invariants(curve, model):
    """Everything that holds along every curve over frequency."""
    omega, event, size = curve.points[:, 3], curve.event, max(1.0, np.max(np.abs(curve.points[:, :3])))
    assert set(event) <= {0, *Event}
    # Every point is a solution, and stable where its determinant is positive.
    evaluated = [evaluate(model, y[3], y[:3]) for y in curve.points]
    assert max(np.max(np.abs(residual)) for residual, _ in evaluated) < 1e-8 * size
    determinants = np.array([np.linalg.det(jacobian) for _, jacobian in evaluated])
    clear = (np.abs(determinants) > 1e-8) & (event != Event.FOLD)
    np.testing.assert_array_equal(curve.stable[clear] == 1, determinants[clear] > 0.0)
    # Folds turn p round and stability over, nothing else does.
    at = [0, *np.flatnonzero(event == Event.FOLD), len(omega) - 1]
    senses, states = [], []
    for first, last in zip(at, at[1:], strict=False):
        steps = np.diff(omega[first : last + 1])
        assert np.all(steps >= 0.0) or np.all(steps <= 0.0)
        senses.append(np.sign(omega[last] - omega[first]))
        inside = {*curve.stable[first + 1 : last]} or {1 - states[-1]}
        assert len(inside) == 1
        states.append(inside.pop())
    assert all(a == -b for a, b in zip(senses, senses[1:], strict=False))
    assert all(a == 1 - b for a, b in zip(states, states[1:], strict=False))
    assert np.all(curve.stable[event == Event.FOLD] == 0)
    # A grazing is where its margin vanishes; it changes sign there and nowhere else.
    for kind, values in zip(GRAZINGS, margins(curve, model).T, strict=True):
        at = np.flatnonzero(event == kind)
        assert np.max(np.abs(values[at]), initial=0.0) < 1e-9 * size
        pieces = [np.sign(piece[1 if i else 0 :]) for i, piece in enumerate(np.split(values, at))]
        pieces = [set(piece) for piece in pieces if len(piece)]
        assert all(len(piece) == 1 for piece in pieces)
        signs = [piece.pop() for piece in pieces]
        assert all(a == -b for a, b in zip(signs, signs[1:], strict=False))
    # So the kind of motion is the same between two neighbouring events.
    impact = impact_state(curve.points[:, 0] - curve.amplitude, curve.points[:, 0] + curve.amplitude, model.b)
    for piece in np.split(np.arange(len(omega)), np.flatnonzero(event > Event.FOLD)):
        assert len({*impact[piece[1 if event[piece[0]] > Event.FOLD else 0 :]]}) <= 1
    # Orientation is kept: tangents are unit vectors and follow the chords.
    assert np.all(np.diff(curve.arclength) > 0.0) and curve.arclength[0] == 0.0
    np.testing.assert_allclose(np.linalg.norm(curve.tangents, axis=1), 1.0, rtol=0, atol=1e-12)


def check_steps(curve, problem, continuation):
    """No accepted step is longer or turns further than allowed, and tangents point along the curve."""
    # Located events lie inside of a step, where the curve may turn there and back again.
    whole = (curve.event[1:] == 0) & (curve.event[:-1] == 0)
    turns = np.sum(curve.tangents[1:] * curve.tangents[:-1], axis=1)
    assert np.min(turns[whole]) > np.cos(continuation.largest_angle) - 1e-12
    assert np.min(turns) > 0.5
    chords = np.diff(curve.points / problem.scale, axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    along = np.sum(chords * curve.tangents[:-1], axis=1) / lengths
    assert np.min(along[whole]) > np.cos(continuation.largest_angle)
    sizes = np.max(np.abs(curve.points[:-1, :-1] / problem.scale[:-1]), axis=1)
    limit = np.maximum(continuation.largest_step, continuation.growth * sizes)
    assert np.all(np.diff(curve.arclength) <= 1.2 * limit)
    reach = continuation.parameter_step * (HIGH - LOW)
    assert np.max(np.abs(np.diff(curve.points[:, -1]))) < 1.2 * reach


def solutions_on(curve, omega):
    """How many points the curve has at a frequency."""
    return int(np.sum(np.diff(np.sign(curve.points[:, 3] - omega)) != 0))
