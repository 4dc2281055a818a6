"""Computing the flows of `solver.flow.zone_flows`: Taylor series about the middle of every interval of a period."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from solver.flow.switched_system import (
    FREQUENCY,
    HIGH,
    LENGTH,
    LOW,
    ONE_ZONE,
    SWITCHED_SYSTEM,
    loaded_system,
    strength_of,
)
from solver.flow.taylor import fill_sources
from solver.flow.zone_flows import COEFFICIENTS, CUBE, ZONE_FLOWS, ZoneFlows, change_basis, matrix_at, new_flows
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.contact_system import ContactSystem, refuse_cubic

__all__ = ["MOST_INTERVALS", "loaded_flows", "zone_flows"]

_F, _I = types.float64, types.int64

#: Intervals of one period, at most: those of a mode a thousand times faster than the load.
MOST_INTERVALS = 4096

# Two terms more tell the truncation error.
_TERMS = COEFFICIENTS + 2


class _Work(NamedTuple):
    """Series about the middle of an interval: s (19,), g (19, n), columns of Phi and p (18, 2 n + 1, 2 n), what the
    contact sees of them (18, 2 n + 1), rows of Gamma (18, 2 n, 2 n) and their products with q (18, 2 n)."""

    stiffness: np.ndarray
    g: np.ndarray
    columns: np.ndarray
    contact: np.ndarray
    rows: np.ndarray
    products: np.ndarray


_WORK = types.NamedTuple((ARRAY, MATRIX, CUBE, MATRIX, CUBE, MATRIX), _Work)


@kernel(types.void(SWITCHED_SYSTEM, _I, _WORK), inner=True)
def _columns(system, zone, work):
    """Series of Phi and p in a zone, s and g being filled in."""
    n = system.vectors.shape[1]
    size, first, strength = 2 * n, n * (zone % 3), strength_of(system, zone)
    second = first + 3 * n
    matrices, vectors, z, contact = system.matrices, system.vectors, work.columns, work.contact
    varied = zone != 0 and system.variation.shape[0] > 0
    for c in range(size + 1):
        for i in range(size):
            z[0, c, i] = 1.0 if i == c else 0.0
    for j in range(_TERMS - 1):
        scale = 1.0 / (j + 1.0)
        for c in range(size + 1):
            seen, product = 0.0, 0.0
            for i in range(n):
                seen += vectors[0, i] * z[j, c, i]
            contact[j, c] = seen
            if varied:
                for i in range(j + 1):
                    product += work.stiffness[i] * contact[j - i, c]
                product *= strength
            for i in range(n):
                value = work.g[j, i] if c == size else 0.0
                if varied:
                    value -= vectors[2, i] * product
                for l in range(n):
                    value -= matrices[first + i, l] * z[j, c, l] + matrices[second + i, l] * z[j, c, n + l]
                z[j + 1, c, i] = scale * z[j, c, n + i]
                z[j + 1, c, n + i] = scale * value


@kernel(types.void(SWITCHED_SYSTEM, _I, _WORK), inner=True)
def _rows(system, zone, work):
    """Series of Gamma = (a, b) in a zone: a' = b S_z + r_z s (b q) w, b' = b D_z - a."""
    n = system.vectors.shape[1]
    size, first, strength = 2 * n, n * (zone % 3), strength_of(system, zone)
    second = first + 3 * n
    matrices, vectors, z, products = system.matrices, system.vectors, work.rows, work.products
    varied = zone != 0 and system.variation.shape[0] > 0
    for r in range(size):
        for i in range(size):
            z[0, r, i] = 1.0 if i == r else 0.0
    for j in range(_TERMS - 1):
        scale = 1.0 / (j + 1.0)
        for r in range(size):
            product = 0.0
            if varied:
                seen = 0.0
                for i in range(n):
                    seen += z[j, r, n + i] * vectors[2, i]
                products[j, r] = seen
                for i in range(j + 1):
                    product += work.stiffness[i] * products[j - i, r]
                product *= strength
            for l in range(n):
                left, right = product * vectors[0, l], -z[j, r, l]
                for i in range(n):
                    left += z[j, r, n + i] * matrices[first + i, l]
                    right += z[j, r, n + i] * matrices[second + i, l]
                z[j + 1, r, l], z[j + 1, r, n + l] = scale * left, scale * right


@kernel(_F(CUBE, _F, _F, _F), inner=True)
def _allowed(series, half, tolerance, length):
    """Half an interval for which the two terms beyond the polynomials are below the tolerance, by the try `half`.

    Of every column its largest term is the scale, for the last one of an affine map at least a length.
    """
    smallest = math.inf
    for c in range(series.shape[1]):
        scale = length if c == series.shape[2] else 1.0
        power, rest = 1.0, 0.0
        for j in range(_TERMS):
            largest = 0.0
            for i in range(series.shape[2]):
                largest = max(largest, abs(series[j, c, i]))
            if j < COEFFICIENTS:
                scale = max(scale, largest * power)
            else:
                rest += largest * power
            power *= half
        if not rest <= tolerance * scale:
            smallest = min(smallest, half * (tolerance * scale / rest) ** (1.0 / COEFFICIENTS))
    return smallest


@kernel(types.void(ZONE_FLOWS, _I, _I, _WORK), inner=True)
def _store(flows, zone, k, work):
    """Keep the flow of a zone in one interval."""
    vectors = flows.system.vectors
    n, half = vectors.shape[1], flows.half[0]
    size, row, power = 2 * n, (zone % 3) * flows.count[0] + k, 1.0
    for j in range(COEFFICIENTS):
        for c in range(size + 1):
            seen = 0.0
            for r in range(size):
                value = power * work.columns[j, c, r]
                flows.forward[row, j, c, r] = value
                if r < n:
                    seen += vectors[0, r] * value
                if c < size:
                    flows.backward[row, j, c, r] = power * work.rows[j, r, c]
            flows.contact[row, c, j] = seen
        flows.stiffness[k, j] = power * work.stiffness[j]
        power *= half
    for c in range(size + 1):
        change_basis(flows.contact[row, c], flows.bernstein[row, c])
    matrix_at(flows.forward, row, 0, 1.0, flows.leave[row])
    # m = Gamma(-1) (z - p(-1))
    entry, step = flows.entry[row], flows.step[row]
    matrix_at(flows.backward, row, 0, -1.0, entry)
    matrix_at(flows.forward, row, size, -1.0, step)
    for r in range(size):
        total = 0.0
        for c in range(size):
            total -= entry[c, r] * step[size, c]
        entry[size, r] = total


@kernel(types.void(ZONE_FLOWS, _I), inner=True)
def _join(flows, zone):
    """Fill in `step` from `leave` of an interval and `entry` of the next."""
    count, size = flows.count[0], flows.forward.shape[2] - 1
    for k in range(count - 1):
        row = (zone % 3) * count + k
        for c in range(size + 1):
            for r in range(size):
                total = flows.entry[row + 1, size, r] if c == size else 0.0
                for i in range(size):
                    total += flows.entry[row + 1, i, r] * flows.leave[row, c, i]
                flows.step[row, c, r] = total


@kernel(types.void(ZONE_FLOWS, _F), inner=True)
def _fill_limits(flows, tolerance):
    numbers, limits = flows.system.numbers, flows.limits
    low, high = numbers[LOW], numbers[HIGH]
    flows.slack[0] = max(1e-3 * tolerance, 4e-16) * numbers[LENGTH]
    limits[0, 0], limits[0, 1] = low, high
    limits[1, 0], limits[1, 1] = (-math.inf if numbers[ONE_ZONE] != 0.0 else high), math.inf
    limits[2, 0], limits[2, 1] = -math.inf, low


@kernel(ZONE_FLOWS(ZONE_FLOWS, SWITCHED_SYSTEM, _I), inner=True)
def _fitted(flows, system, count):
    """The tables for another system and so many intervals, or new ones if they have no room for it."""
    if 3 * count > flows.contact.shape[0]:
        return new_flows(system, count)
    return ZoneFlows(
        system,
        flows.count,
        flows.half,
        flows.forward,
        flows.backward,
        flows.contact,
        flows.bernstein,
        flows.entry,
        flows.leave,
        flows.step,
        flows.stiffness,
        flows.limits,
        flows.slack,
    )


@kernel(ZONE_FLOWS(SWITCHED_SYSTEM, _F, ZONE_FLOWS), inner=True, shared=True)
def zone_flows(system, tolerance, flows):
    """The flows of a system under its load.

    Parameters
    ----------
    system : SwitchedSystem
    tolerance : float
        Truncation error over an interval relative to the state, or to the length of the system if that is larger.
    flows : ZoneFlows
        Of the same number of coordinates; overwritten if it has room enough.

    Returns
    -------
    ZoneFlows
        The one given or a new one. `count` is 0 where the period needs more than MOST_INTERVALS intervals or the
        series are not finite.
    """
    n, span = system.vectors.shape[1], 2.0 * math.pi / system.numbers[FREQUENCY]
    size, length = 2 * n, system.numbers[LENGTH]
    work = _Work(
        np.zeros(_TERMS + 1),
        np.zeros((_TERMS + 1, n)),
        np.empty((_TERMS, size + 1, size)),
        np.empty((_TERMS, size + 1)),
        np.empty((_TERMS, size, size)),
        np.empty((_TERMS, size)),
    )
    zones = 1 if system.numbers[ONE_ZONE] != 0.0 else (2 if system.numbers[LOW] == -math.inf else 3)
    count, k = 1, 0
    while k < count:
        half = 0.5 * span / count
        allowed = math.inf
        for index in range(zones):
            zone = 1 - index
            fill_sources(system, zone, (2 * k + 1) * half, work.stiffness, work.g)
            _columns(system, zone, work)
            _rows(system, zone, work)
            allowed = min(allowed, _allowed(work.columns, half, tolerance, length))
            allowed = min(allowed, _allowed(work.rows, half, tolerance, length))
            if not allowed >= half:
                break
            if k == 0 and index == 0:
                flows = _fitted(flows, system, count)
                flows.count[0], flows.half[0] = count, half
            _store(flows, zone, k, work)
        if allowed >= half:
            k += 1
            continue
        more = 0.5 * span / allowed
        if not more <= MOST_INTERVALS:
            flows.count[0] = 0
            return flows
        count, k = max(count + 1, int(math.ceil(more))), 0
    for index in range(zones):
        _join(flows, 1 - index)
    _fill_limits(flows, tolerance)
    return flows


@kernel(ZONE_FLOWS(SWITCHED_SYSTEM, _F))
def _tabulated(system, tolerance):
    """`zone_flows` in new tables."""
    return zone_flows(system, tolerance, new_flows(system, 1))


@lru_cache(maxsize=4)
def loaded_flows(system: ContactSystem, omega: float, tolerance: float) -> ZoneFlows:
    """The flows of a system under its load at one frequency. They serve many calls; no kernel writes into them.

    Raises
    ------
    ParameterError
        If there is a cubic spring.
    """
    refuse_cubic(system, "where motions are carried by tables of affine flows")
    return _tabulated(loaded_system(system, omega), tolerance)
