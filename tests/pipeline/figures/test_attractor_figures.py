"""The attractor map and the verification: colours apart for all eyes and in grey, stripes, totals."""

import itertools

import numpy as np
import pytest

from pipeline.analysis.attractors.credibility import Credibility
from pipeline.figures.attractors import CLASSES, class_of, stripes
from pipeline.figures.cell_panels import borders_between
from pipeline.figures.verification import COLOURS
from pipeline.plan.axes import Axis
from solver.timedomain import AttractorKind as Kind
from tests.pipeline.figures.test_palette import EYES, lab


@pytest.mark.parametrize("colours", [dict(CLASSES), COLOURS], ids=["attractors", "verification"])
def test_colours_are_apart_in_grey_and_for_all_eyes(colours):
    for eyes in EYES.values():
        places = lab(list(colours.values()), eyes)
        for one, other in itertools.combinations(range(len(places)), 2):
            assert np.linalg.norm(places[one] - places[other]) >= 13.0
    grey = lab(list(colours.values()), EYES["normal"])[:, 0]
    assert np.min(np.abs(np.diff(np.sort(grey)))) >= 5.0
    # From calm to alarming they get darker.
    assert np.all(np.diff(grey) < 0.0)


def test_what_is_wrong_is_not_drawn_in_a_calm_colour():
    """Calm is pale, or grey; what is right is nearly white."""
    places = dict(zip(COLOURS, lab(list(COLOURS.values()), EYES["normal"]), strict=True))
    assert places[Credibility.CONFIRMED][0] > 93.0
    calm = (Credibility.CONFIRMED, Credibility.UNCHECKED)
    assert all(np.hypot(*place[1:]) > 40.0 for kind, place in places.items() if kind not in calm)
    assert COLOURS.keys() == set(Credibility)


def test_every_kind_has_a_class():
    classes = class_of(np.array(list(Kind)))
    assert classes[0] == -1 and np.all(classes[1:] >= 0) and set(classes[1:]) == set(range(len(CLASSES)))


def test_stripes_show_every_motion():
    classes = np.array([[[0, -1, -1, -1], [2, 0, -1, -1], [5, 0, 2, -1], [-1, -1, -1, -1], [0, 1, 2, 3]]])
    parts = stripes(classes)[0]
    assert [sorted(set(part.tolist())) for part in parts] == [[0], [0, 2], [0, 2, 5], [-1], [0, 1, 2, 3]]
    # Two motions have equal parts.
    assert np.bincount(parts[1])[[0, 2]].tolist() == [3, 3]


def test_cells_of_some_rows_fill_the_axis():
    axis = Axis("f_e", 0.0, 1.0, 11)
    borders = borders_between(np.array([0.0, 0.2, 1.0]), axis)
    np.testing.assert_allclose(borders, [-0.05, 0.1, 0.6, 1.05])
    np.testing.assert_allclose(borders_between(np.array([0.3]), axis), [-0.05, 1.05])
