"""Settings of the continuation: what is refused, and that they travel."""

import dataclasses
import pickle

import numpy as np
import pytest

from solver import Broyden, Continuation, ParameterError


@pytest.mark.parametrize(
    "name, value",
    [
        *(
            (name, bad)
            for name in ("first_step", "largest_step", "smallest_step", "growth", "amplitude_max")
            for bad in (0.0, -1.0, np.inf, np.nan)
        ),
        *(("largest_angle", bad) for bad in (0.0, 3.2, np.nan)),
        *(("largest_distance", bad) for bad in (0.0, 11.0, np.nan)),
        *(("parameter_step", bad) for bad in (0.0, 1.5, np.nan)),
        *(("max_points", bad) for bad in (1, 10**8)),
    ],
)
def test_settings_out_of_range_are_refused(name, value):
    with pytest.raises(ParameterError) as caught:
        Continuation(**{name: value})
    assert caught.value.name == name and str(caught.value).startswith(f"{name} = {value!r} is not allowed")


def test_settings_are_frozen_and_comparable():
    assert Continuation() == Continuation() != Continuation(corrector=Broyden())
    with pytest.raises(dataclasses.FrozenInstanceError):
        Continuation().first_step = 1.0
    # Workers get them by pickle.
    changed = Continuation(corrector=Broyden(tolerance=1e-7), largest_step=0.3)
    assert pickle.loads(pickle.dumps(changed)) == changed
