"""Numbered outcomes with their sentences."""

import copy
import pickle

import numpy as np
import pytest

from solver.explained import Explained


class Light(Explained):
    RED = 0, "Stop."
    GREEN = 2, "Go."


def test_members_are_their_numbers_and_explain_themselves():
    assert [(light.name, int(light), light.value, light.sentence) for light in Light] == [
        ("RED", 0, 0, "Stop."),
        ("GREEN", 2, 2, "Go."),
    ]
    assert Light(2) is Light.GREEN and Light["RED"] is Light.RED
    np.testing.assert_array_equal(np.array([0, 2, 2], dtype=np.int8) == Light.GREEN, [False, True, True])
    assert np.full(2, Light.GREEN).dtype.kind == "i"


def test_numbers_without_a_member_and_members_without_a_sentence_are_refused():
    with pytest.raises(ValueError):
        Light(1)
    with pytest.raises(TypeError):

        class Mute(Explained):
            RED = 0


def test_members_survive_pickling_and_copying():
    assert pickle.loads(pickle.dumps(Light.GREEN)) is Light.GREEN
    assert copy.deepcopy(Light.GREEN) is Light.GREEN
