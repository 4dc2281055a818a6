"""Where a motion comes nearest to a flank, as continuation steps over a corner of contact; of any balance."""

import math

import numpy as np

from solver.contact.spectrum import displacement, extrema
from solver.continuation.setup import ANGLE, CONTACT_ROW, FLANK, MARGIN, SENSE
from solver.kernels import types
from solver.kernels.compile import ARRAY, MATRIX, kernel
from solver.model.parameters import BACK_GAP, FRONT_GAP

__all__ = ["contacts"]


@kernel(types.int64(ARRAY, ARRAY, ARRAY, MATRIX))
def contacts(parameters, parameter_slope, y, rows):
    """Every local extremum of lambda against each flank that there is; see `solver.continuation.setup.CONTACTS`.

    Parameters
    ----------
    parameters, parameter_slope : arrays
        Parameters at p = 0 and what p adds to them.
    y : (n + 1,) array
        (u, p).
    rows : (k, CONTACT_ROW + n + 1) array
        Filled as far as there is room.
    """
    n = y.shape[0] - 1
    slope, angles, zones = np.empty(n), np.empty(2 * n + 8), np.empty(2 * n + 8, np.int64)
    count, written = extrema(y[:n], slope, angles, zones), 0
    for i in range(count):
        value = displacement(y[:n], angles[i])[0]
        turn = complex(math.cos(angles[i]), math.sin(angles[i]))
        for slot, flank in ((FRONT_GAP, 1.0), (BACK_GAP, -1.0)):
            if not math.isfinite(parameters[slot]) or written == rows.shape[0]:
                continue
            row = rows[written]
            # Where the slope becomes positive lambda is smallest.
            row[ANGLE], row[FLANK], row[SENSE] = angles[i], flank, -1.0 if zones[i] == 1 else 1.0
            row[MARGIN] = value - flank * (parameters[slot] + y[n] * parameter_slope[slot])
            row[CONTACT_ROW], row[CONTACT_ROW + n] = 1.0, -flank * parameter_slope[slot]
            z = 1.0 + 0j
            for k in range(1, n // 2 + 1):
                z *= turn
                row[CONTACT_ROW + 2 * k - 1], row[CONTACT_ROW + 2 * k] = z.real, z.imag
            written += 1
    return written
