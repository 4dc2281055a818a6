"""The systems of the cells of a row, and states to start from: at rest, on motions of a map, at random."""

from dataclasses import dataclass, field

import numpy as np

from solver.flow.loads import loaded_system_at
from solver.flow.switched_system import DASHPOT, FREQUENCY, HIGH, LOW, NUMBERS, STRENGTH, count_degrees
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.kernels.linear import copy_into
from solver.model.contact_system import ContactSystem, reduced, refuse_cubic
from solver.model.gear_model import Model
from solver.model.packing import packed
from solver.model.parameters import LOADS, STIFFNESSES
from solver.timedomain.gauge import Gauge, gauge_at, system_gauges

__all__ = ["RowSystems", "motion_states", "random_states", "row_systems"]

_BOXES = types.float64[:, :, ::1]


@kernel(types.void(ARRAY, ARRAY, ARRAY, types.int64[::1]))
def _count(parameters, parameter_slope, values, degrees):
    """Coordinates of the system at every value."""
    for i in range(values.shape[0]):
        degrees[i] = count_degrees(parameters, parameter_slope, values[i])


@kernel(types.void(ARRAY, ARRAY, ARRAY, MATRIX, _BOXES, _BOXES, _BOXES, _BOXES))
def _fill(parameters, parameter_slope, values, numbers, matrices, vectors, variation, load):
    """Numbers of the systems at values where they have equally many coordinates."""
    for i in range(values.shape[0]):
        system = loaded_system_at(parameters, parameter_slope, values[i])
        copy_into(numbers[i], system.numbers)
        for j in range(system.matrices.shape[0]):
            copy_into(matrices[i, j], system.matrices[j])
        for j in range(system.vectors.shape[0]):
            copy_into(vectors[i, j], system.vectors[j])
        for j in range(system.variation.shape[0]):
            copy_into(variation[i, j], system.variation[j])
        for j in range(system.load.shape[0]):
            copy_into(load[i, j], system.load[j])


@dataclass(frozen=True, eq=False)
class _Alike:
    """Systems of n coordinates each: their columns in the row, and arrays as of `SwitchedSystem`."""

    columns: np.ndarray
    numbers: np.ndarray
    matrices: np.ndarray
    vectors: np.ndarray
    variation: np.ndarray
    load: np.ndarray


@dataclass(frozen=True, eq=False)
class RowSystems:
    """The systems of the X cells of a row.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Of `solver.model.packing.packed`.
    values : (X,) array
        Of the axis.
    degrees : (X,) int array
        Coordinates n that the contact reaches.
    rest : (X, m) array
        At rest under the mean load with the front contact closed; nan beyond 2 n.
    box : (X, 2) array
        Half widths of the default box of random states about 0: of the coordinates, 3 times the largest gap plus the
        deflection that the sum of the load amplitudes gives in permanent contact, or 1 without both; of the speeds, as
        much times the frequency of the softest mode in contact or, where that is lower, Omega.
    gaps : (X, 2) array
        Ends of the dead zone of lambda.
    omega : (X,) array
    gauges : tuple of X Gauge
        What quantities are read with, beside the motion.
    alike : tuple
        The systems as arrays, those of one number of coordinates together.
    """

    parameters: np.ndarray
    parameter_slope: np.ndarray
    values: np.ndarray
    degrees: np.ndarray
    rest: np.ndarray
    box: np.ndarray
    gaps: np.ndarray
    omega: np.ndarray
    gauges: tuple[Gauge, ...] = field(repr=False)
    alike: tuple[_Alike, ...] = field(repr=False)

    @property
    def size(self) -> int:
        """Numbers m of the largest state."""
        return self.rest.shape[1]

    def adapted(self, i: int, states: np.ndarray) -> np.ndarray:
        """States (k, m) of other cells as states of cell i.

        Where the number of coordinates differs, lambda and its speed are brought and the others are at rest.
        """
        size = 2 * int(self.degrees[i])
        if not (np.isnan(states[:, :size]).any() or np.isfinite(states[:, size:]).any()):
            return states[:, :size]
        own, n = np.tile(self.rest[i, :size], (len(states), 1)), size // 2
        for target, state in zip(own, states, strict=True):
            given = np.count_nonzero(np.isfinite(state)) // 2
            target[n - 1], target[2 * n - 1] = state[given - 1], state[2 * given - 1]
        return own


def row_systems(system: Model | ContactSystem, axis: str, values: np.ndarray, omega: float | None) -> RowSystems:
    """The systems of a row; what is given has been checked.

    Parameters
    ----------
    system : Model or ContactSystem
    axis : str
        What changes along the row.
    values : (X,) array
        Of the axis.
    omega : float or None
        The mesh frequency, unless it is the axis.
    """
    refuse_cubic(system, "for attractors")
    parameters, slope = packed(system, axis, omega, 1, 1)
    degrees = np.empty(values.size, np.int64)
    _count(parameters, slope, values, degrees)
    size = 2 * int(degrees.max())
    rest, box = np.full((values.size, size), np.nan), np.empty((values.size, 2))
    gaps, frequencies, alike = np.empty((values.size, 2)), np.empty(values.size), []
    stiffnesses, loads = int(parameters[STIFFNESSES]), int(parameters[LOADS])
    for n in np.unique(degrees).tolist():
        columns = np.flatnonzero(degrees == n)
        count = columns.size
        group = _Alike(
            columns,
            np.empty((count, NUMBERS)),
            np.empty((count, 6 * n, n)),
            np.empty((count, 3, n)),
            np.zeros((count, stiffnesses, 2)),
            np.empty((count, 2 * (loads + 1), n)),
        )
        arrays = (group.numbers, group.matrices, group.vectors, group.variation, group.load)
        _fill(parameters, slope, values[columns].copy(), *arrays)
        alike.append(group)
        low, high = group.numbers[:, LOW], group.numbers[:, HIGH]
        gaps[columns], frequencies[columns] = np.column_stack([low, high]), group.numbers[:, FREQUENCY]
        closed = group.matrices[:, n : 2 * n]
        right = group.load[:, 0] + group.vectors[:, 1] * high[:, None]
        rest[columns, : 2 * n] = 0.0
        rest[columns, :n] = _solved(closed, right)
        sizes = np.hypot(group.load[:, 0::2], group.load[:, 1::2]).sum(axis=1)
        deflection = np.max(np.abs(_solved(closed, sizes)), axis=1)
        largest = np.maximum(np.abs(high), np.where(np.isfinite(low), np.abs(low), 0.0))
        reach = 3.0 * largest + np.maximum(largest, deflection)
        reach = np.where(reach > 0.0, reach, 1.0)
        modes = np.sqrt(np.abs(np.linalg.eigvals(closed)))
        modes = np.where(modes > 1e-9 * np.max(modes, axis=1, initial=1.0)[:, None], modes, np.inf)
        slowest = np.minimum(np.min(modes, axis=1), group.numbers[:, FREQUENCY])
        box[columns] = np.column_stack([reach, reach * slowest])
    if isinstance(system, Model):
        gauges = tuple(gauge_at(parameters, slope, value, False) for value in values.tolist())
    else:
        kept = reduced(system)
        gauges = system_gauges(kept, rest[:, : kept.degrees], gaps[:, 1])
    return RowSystems(parameters, slope, values, degrees, rest, box, gaps, frequencies, gauges, tuple(alike))


def _solved(matrices: np.ndarray, rights: np.ndarray) -> np.ndarray:
    """Least-squares solutions (k, n): a system may have coordinates that nothing holds."""
    return (np.linalg.pinv(matrices) @ rights[:, :, None])[:, :, 0]


def random_states(row: RowSystems, keys: np.ndarray, count: int) -> np.ndarray:
    """Uniform states (X, count, m) in the box of each cell; nan beyond 2 n.

    Parameters
    ----------
    row : RowSystems
    keys : (X,) uint64 array
        Seed of each cell.
    count : int
        States in each cell.

    Notes
    -----
    The numbers are those of SplitMix64 at key, key + golden ratio, ... (G. L. Steele, D. Lea, C. H. Flood, "Fast
    splittable pseudorandom number generators", OOPSLA 2014), so that a cell's do not depend on its neighbours.
    """
    steps = np.arange(1, count * row.size + 1, dtype=np.uint64).reshape(count, row.size)
    with np.errstate(over="ignore"):
        bits = _mixed(keys)[:, None, None] + steps * np.uint64(0x9E3779B97F4A7C15)
        bits = _mixed(bits)
    unit = (bits >> np.uint64(11)).astype(float) * 2.0**-53
    states = 2.0 * unit - 1.0
    for i, n in enumerate(row.degrees.tolist()):
        states[i, :, :n] *= row.box[i, 0]
        states[i, :, n : 2 * n] *= row.box[i, 1]
        states[i, :, 2 * n :] = np.nan
    return states


def _mixed(bits: np.ndarray) -> np.ndarray:
    bits = (bits ^ (bits >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    bits = (bits ^ (bits >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return bits ^ (bits >> np.uint64(31))


def motion_states(row: RowSystems, motions: np.ndarray, period: int) -> np.ndarray:
    """States (X, S, m) at tau = 0 that belong to harmonic-balance motions of lambda, nan where there is none.

    The contact force f of that lambda acts on the linear system: in every harmonic k of Omega / nu

        [-(k Omega / nu)^2 + i (k Omega / nu) D + S_0] Y_k = g_k - (1 + i (k Omega / nu) c_c) h f_k - q (s f)_k

    Where S_0 is singular (a mean that the contact alone carries) the mean of lambda is imposed instead.

    Parameters
    ----------
    row : RowSystems
    motions : (X, S, 2 H + 1) array
        Lambda_0, then c_k, s_k of lambda = Lambda_0 + sum_k c_k cos k theta + s_k sin k theta, theta = Omega tau / nu.
    period : int
        nu.
    """
    states = np.full((*motions.shape[:2], row.size), np.nan)
    for group in row.alike:
        here = motions[group.columns]
        cell, place = np.nonzero(np.all(np.isfinite(here), axis=2))
        if cell.size:
            found = _states(group, cell, here[cell, place], period)
            states[group.columns[cell], place, : found.shape[1]] = found
    return states


def _states(group: _Alike, cell: np.ndarray, motions: np.ndarray, period: int) -> np.ndarray:
    count, order, n = len(motions), motions.shape[1] // 2, group.vectors.shape[2]
    samples = max(64, 16 * order)
    wave = np.zeros((count, samples // 2 + 1), complex)
    wave[:, 0] = motions[:, 0]
    wave[:, 1 : order + 1] = 0.5 * (motions[:, 1::2] - 1j * motions[:, 2::2])
    displacement = np.fft.irfft(samples * wave, samples, axis=1)
    low, high = group.numbers[cell, LOW, None], group.numbers[cell, HIGH, None]
    strength, dashpot = group.numbers[cell, STRENGTH, None], group.numbers[cell, DASHPOT, None]
    force = np.maximum(displacement - high, 0.0) + strength * np.minimum(displacement - low, 0.0)
    theta = 2.0 * np.pi * np.arange(samples) / samples
    varied = np.zeros_like(force)
    for l in range(group.variation.shape[1]):
        real, imaginary = group.variation[cell, l, :, None].transpose(1, 0, 2)
        varied += real * np.cos((l + 1) * period * theta) - imaginary * np.sin((l + 1) * period * theta)
    loads = group.load[cell][:, 0::2] + 1j * group.load[cell][:, 1::2]
    highest = min(max(4 * order, 4 * period, period * (loads.shape[1] - 1)), samples // 2 - 1)
    plain, varied = _one_sided(force, highest), _one_sided(varied * force, highest)
    rates = np.arange(highest + 1) * group.numbers[cell, FREQUENCY, None] / period
    plain = plain * (1.0 + 1j * rates * dashpot)
    right = -plain[:, :, None] * group.vectors[cell, 1][:, None] - varied[:, :, None] * group.vectors[cell, 2][:, None]
    kept = min(loads.shape[1], highest // period + 1)
    right[:, : kept * period : period] += loads[:, :kept]
    free, damping = group.matrices[cell, :n], group.matrices[cell, 3 * n : 4 * n]
    stiffness = free[:, None] + 1j * rates[:, :, None, None] * damping[:, None]
    stiffness = stiffness - (rates**2)[:, :, None, None] * np.eye(n)
    amplitude = np.zeros_like(right)
    held = np.linalg.cond(free) < 1e12
    amplitude[:, 1:] = np.linalg.solve(stiffness[:, 1:], right[:, 1:, :, None])[..., 0]
    amplitude[held, 0] = np.linalg.solve(free[held], right[held, 0].real[..., None])[..., 0]
    # Elsewhere the mean of lambda is imposed, and the contact force balances what remains along h.
    bordered = np.zeros((count, n + 1, n + 1))
    bordered[:, :n, :n], bordered[:, :n, n], bordered[:, n, :n] = free, group.vectors[cell, 1], group.vectors[cell, 0]
    rights = np.column_stack([right[:, 0].real, motions[:, 0]])
    amplitude[~held, 0] = _solved(bordered[~held], rights[~held])[:, :n]
    speeds = np.real(1j * rates[:, :, None] * amplitude).sum(axis=1)
    return np.concatenate([amplitude.real.sum(axis=1), speeds], axis=1)


def _one_sided(signal: np.ndarray, highest: int) -> np.ndarray:
    harmonics = np.fft.rfft(signal, axis=1)[:, : highest + 1] * (2.0 / signal.shape[1])
    harmonics[:, 0] *= 0.5
    return harmonics
