"""Every solution at one point by brute force: Newton's method from very many starts, without continuation."""

import numpy as np

from solver.harmonic.describing_function import linear_solution, residual_and_jacobian
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import eliminate
from solver.model.gear_model import Model
from solver.model.packing import axis_vectors


@kernel(types.int64(ARRAY, ARRAY, types.float64, MATRIX, types.float64, MATRIX))
def _search(theta, direction, p, starts, size, found):
    """Fill `found` with the distinct points that damped Newton steps from `starts` reach; their number."""
    count = 0
    y, step, jacobian, square = np.empty(4), np.empty(3), np.empty((3, 4)), np.empty((3, 3))
    residual = np.empty(3)
    for s in range(starts.shape[0]):
        y[:3], y[3] = starts[s], p
        for _ in range(60):
            residual_and_jacobian(theta, direction, y, residual, jacobian)
            square[:, :] = jacobian[:, :3]
            step[:] = residual
            if eliminate(square, step) == 0.0:
                break
            length = np.max(np.abs(step))
            if not np.isfinite(length):
                break
            y[:3] -= step * min(1.0, 0.5 * size / length) if length > 0.0 else step
            if length < 1e-12 * size:
                known = False
                for k in range(count):
                    known = known or np.max(np.abs(found[k] - y[:3])) < 1e-7 * size
                if not known and count < found.shape[0]:
                    found[count, :] = y[:3]
                    count += 1
                break
    return count


def all_solutions(model: Model, omega: float, starts: int = 300, seed: int = 0) -> np.ndarray:
    """(k, 3) array of (lambda_m, lambda_c, lambda_s), ascending in amplitude."""
    theta, direction = axis_vectors(model, "omega")
    size, linear = model.motion_size, np.empty(3)
    linear_solution(theta, direction, omega, linear)
    reach = max(size, 2.0 * float(np.max(np.abs(linear))))
    draw = np.random.default_rng(seed)
    points = draw.uniform(-1.0, 1.0, (starts, 3)) * np.where(draw.random((starts, 1)) < 0.5, 2.0 * size, reach)
    found = np.empty((32, 3))
    found = found[: _search(theta, direction, omega, points, size, found)]
    return found[np.argsort(np.hypot(found[:, 1], found[:, 2]))]
