"""Colours of labels and states: apart for all eyes, darker with more solutions, each of its own; names of axes."""

import itertools

import numpy as np
import pytest

from pipeline.figures.naming import axis_label
from pipeline.figures.palette import label_colour, sequential_colours, state_colour
from solver import SCALAR_PARAMETERS, ImpactState, domain_labels

STATES = ("0", "1", "2", "0-1", "0-2", "1-2", "0-1-2")
USUAL = [f"{n}/{states}" for n in (1, 2, 3) for states in STATES if len(states.split("-")) <= n]
#: Labels of the four reference planes.
PUBLISHED = ["1/0", "1/1", "1/2", "2/0-1", "2/0-2", "2/1", "2/2", "2/1-2", "3/0-2", "3/1-2", "3/0-1-2"]
#: Severity 1.0 of Machado, Oliveira and Fernandes (2009), on linear RGB.
EYES = {
    "normal": np.eye(3),
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]],
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
}
RGB_TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.072175], [0.0193339, 0.119192, 0.9503041]]
)


def lab(colours, eyes):
    """CIE L*a*b* (D65) of sRGB colours as these eyes see them."""
    encoded = np.array(colours) / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    seen = np.clip(linear @ np.transpose(eyes), 0.0, 1.0)
    t = seen @ RGB_TO_XYZ.T / (0.95047, 1.0, 1.08883)
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    x, y, z = f.T
    return np.column_stack([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("eyes", EYES)
def test_colours_stay_apart(eyes):
    for labels, distance in ((USUAL, 13.0), (PUBLISHED, 17.0)):
        places = lab([label_colour(label) for label in labels], EYES[eyes])
        for (one, here), (other, there) in itertools.combinations(zip(labels, places, strict=True), 2):
            assert np.linalg.norm(here - there) >= distance, (one, other)


def test_more_solutions_are_darker():
    for states in STATES:
        colours = [label_colour(f"{n}/{states}") for n in range(len(states.split("-")), 9)]
        assert np.all(np.diff(lab(colours, EYES["normal"])[:, 0]) < 0.0), states


def test_every_label_has_a_colour_of_its_own():
    labels = domain_labels(4).values()
    assert len({label_colour(label) for label in labels}) == len(labels)
    assert all(0 <= part <= 255 for label in domain_labels(8).values() for part in label_colour(label))
    assert len({state_colour(state.symbol) for state in ImpactState}) == len(ImpactState)


def test_lines_of_states_differ_in_grey():
    # As printers and image programs make grey of colours (ITU-R BT.601).
    grey = np.array([state_colour(symbol) for symbol in "012f"]) @ (0.299, 0.587, 0.114)
    assert np.diff(np.sort(grey)).min() > 15.0, grey


def test_colours_of_quantities_are_even_and_read_in_grey():
    places = lab(sequential_colours(), EYES["normal"])
    # Between neighbours 8 bits a channel leave more than that.
    steps = np.linalg.norm(places[32:] - places[:-32], axis=1)
    assert steps.max() < 1.15 * steps.min()
    for eyes in EYES.values():
        assert np.all(np.diff(lab(sequential_colours(), eyes)[::8, 0]) < -0.5)


def test_every_axis_has_a_label():
    for name in ("omega", *SCALAR_PARAMETERS):
        text = axis_label(name, {"long_name": "something", "units": "rad"})
        assert text.startswith("something $") and text.endswith("$ (rad)")
