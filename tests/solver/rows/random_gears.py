"""Random plausible gears, rows over any of their parameters, and everything that must hold for such a row."""

import numpy as np

from solver import Continuation, Model, Proof, enumerate_row, uncondensed_balance
from solver.harmonic.uncondensed import translations
from solver.rows.row import Row
from solver.rows.span import RowSpan

__all__ = ["COLUMNS", "assert_row_is_right", "random_row"]

COLUMNS = 33
_CONTINUATION = Continuation()

_AXES = {
    "omega": (0.05, 2.5),
    "b": (0.0, 3.0),
    "alpha": (0.0, 0.6),
    "alpha_phase": (-3.0, 3.0),
    "f_e": (0.0, 0.6),
    "f_e_phase": (-3.0, 3.0),
    "f_pm": (0.1, 1.0),
    "f_pv": (-0.3, 0.3),
    "kappa": (0.1, 1.5),
    "xi_mesh": (0.0, 0.1),
    "xi_translation": (0.0, 0.1),
    "xi_support": (0.0, 0.1),
    "k_support": (0.3, 3.0),
    "pitch_cone_angle": (15.0, 75.0),
    "pressure_angle": (14.0, 28.0),
    "translation_coupling": (0.0, 1.2),
    "rotation_coupling": (0.5, 1.2),
    "variation_translation": (0.0, 1.0),
    "variation_rotation": (0.0, 1.0),
}


def random_row(seed: int) -> tuple[Model, str, np.ndarray, float | None]:
    """A gear, an axis, its grid values and the frequency where that is not the axis.

    One gear in twenty has no damping at all, as many are uncoupled, without excitation of one kind, or lack single
    dampings.
    """
    draw = np.random.default_rng(seed)

    def rarely():
        return draw.random() < 0.05

    undamped = rarely()

    def damping():
        return 0.0 if undamped or rarely() else 10.0 ** draw.uniform(np.log10(0.003), -1.0)

    def several(count, choose):
        return choose() if draw.random() < 0.5 else [choose() for _ in range(count)]

    def share():
        return float(draw.integers(2)) if draw.random() < 0.7 else draw.uniform()

    def coupling(low, high):
        return "geometric" if draw.random() < 0.5 else draw.uniform(low, high)

    def phase():
        return draw.uniform(-np.pi, np.pi)

    model = Model(
        b=draw.uniform(0.2, 3.0),
        alpha=0.0 if rarely() else draw.uniform(0.0, 0.6),
        alpha_phase=phase(),
        alpha_harmonics=[(draw.uniform(0.0, 0.3), phase())] if draw.random() < 0.4 else [],
        f_e=0.0 if rarely() else draw.uniform(0.0, 0.6),
        f_e_phase=phase(),
        f_pm=draw.uniform(0.1, 1.0),
        kappa=several(2, lambda: draw.uniform(0.1, 1.5)),
        xi_mesh=damping(),
        xi_translation=several(2, damping),
        xi_support=several(6, damping),
        k_support=several(6, lambda: draw.uniform(0.3, 3.0)),
        pitch_cone_angle=draw.uniform(15.0, 75.0),
        pressure_angle=draw.uniform(14.0, 28.0),
        translation_coupling=0.0 if rarely() else coupling(0.05, 1.2),
        rotation_coupling=coupling(0.5, 1.0),
        variation_translation=share(),
        variation_rotation=share(),
    )
    axis = "omega" if draw.random() < 0.6 else str(draw.choice(list(_AXES)))
    return model, axis, np.linspace(*_AXES[axis], COLUMNS), None if axis == "omega" else draw.uniform(0.1, 2.3)


def assert_row_is_right(model: Model, row: Row, omega: float | None) -> None:
    """Every solution solves all 21 equations and has the stability of their determinant; enumeration, and what the
    branches pass by Newton's method alone, are the same sets wherever the row says that it is proven."""
    proven = enumerate_row(model, row.axis, row.grid, omega=omega)
    np.testing.assert_array_equal(row.certified == 1, proven.proof == Proof.PROVEN)
    span = RowSpan(row.balance, model, row.axis, float(row.grid[0]), float(row.grid[-1]), omega, _CONTINUATION)
    met = [span.crossings(curve, row.grid) for curve in row.curves]
    size = span.problem.scale[0]
    for i, value in enumerate(row.grid):
        motions, stable = row.motions[i, : row.n_solutions[i]], row.stable[i, : row.n_solutions[i]]
        here, frequency = (model, value) if row.axis == "omega" else (model.replace(**{row.axis: value}), omega)
        for motion, state in zip(motions, stable, strict=True):
            _assert_solves(here, frequency, motion, state if row.certified[i] == 1 else None)
        if row.certified[i] != 1:
            continue
        assert len(motions) == proven.n_solutions[i]
        np.testing.assert_allclose(motions, proven.motions[i, : len(motions)], rtol=0, atol=1e-9 * size)
        passed = np.concatenate([np.empty((0, 3)), *(part.unknowns[part.column == i] for part in met)])
        unreached = sum(int(np.sum(part.unreached == i)) for part in met)
        assert len(passed) + unreached == len(motions)
        for motion in passed:
            assert np.min(np.max(np.abs(motions - motion), axis=1)) < 1e-6 * size


def _assert_solves(model: Model, omega: float, motion: np.ndarray, stable: int | None) -> None:
    unknowns = np.hstack([translations(model, omega, motion), motion[:, None]]).ravel()
    residual, jacobian = uncondensed_balance(model, omega, unknowns)
    assert np.max(np.abs(residual)) < 1e-9 * max(1.0, np.max(np.abs(unknowns)))
    if stable is not None:
        assert (np.linalg.slogdet(jacobian)[0] > 0.0) == (stable == 1)
