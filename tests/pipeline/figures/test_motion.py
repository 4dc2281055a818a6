"""The cards of motions: equal axes, the gap, what lines are and what they hold; data, not pixels."""

import functools

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex

from pipeline.figures.drawing import own_style
from pipeline.figures.motion import PER_PAGE, draw_motions, pages
from pipeline.figures.palette import hex_colour, state_colour
from pipeline.plane.stored import read_stored
from tests.made_once import made_once
from tests.pipeline.analysis.motion.places import MITER, PUBLISHED, SPUR, found_at, plan_of
from tests.pipeline.planes import small_store

TORUS = (0.6, 0.2, *PUBLISHED)
CHAOS = (0.64, 0.3, *PUBLISHED)
PAIR = (1.8, 0.1, *SPUR, "solver=hb", "solver.order=8")
GEAR = (0.9, 0.2, *MITER)
DRIVE, FREE, BACK = (hex_colour(state_colour(state)) for state in ("0", "1", "2"))


@functools.cache
def drawn(place, physical=False, first=None):
    """The figure of a place, of its first motions if so many are asked for, and, card by card, the axes of time, force,
    phase and spectrum. It is drawn once for all tests, which only look at it."""
    plan = plan_of(*place[2:])
    folder = made_once(
        f"cards-{plan.fingerprint}", lambda folder: small_store(folder / "plane.zarr", plan, plan.blocks[:1])
    )
    plane = read_stored(folder / "plane.zarr", physical=physical)
    found = found_at(*place)
    with own_style():
        figure = draw_motions(plane, found, None if first is None else pages(found)[0][:first])
    return figure, [figure.axes[i : i + 4] for i in range(0, len(figure.axes), 4)]


def lines(axes, *, dashed=False, colour=None):
    """What its lines hold, (2, points) each."""
    found = [line for line in axes.lines if (line.is_dashed() if dashed else not line.is_dashed())]
    return [np.array(line.get_data()) for line in found if colour is None or to_hex(line.get_color()) == colour]


def texts(figure):
    return " ".join(text.get_text() for text in figure.texts)


@pytest.mark.parametrize("place", [TORUS, PAIR, GEAR])
def test_all_cards_have_the_same_axes(place):
    _, cards = drawn(place, physical=place is GEAR)
    found = found_at(*place)
    assert len(cards) == len(found.attractors) + len(found.others)
    for kind in range(4):
        assert len({(card[kind].get_xlim(), card[kind].get_ylim()) for card in cards}) == 1
    for time, force, phase, spectrum in cards:
        assert time.get_xlim() == force.get_xlim() and time.get_ylim() == phase.get_xlim()
        assert spectrum.get_yscale() == "log" and spectrum.get_xlim() == (0.0, 8.0)
        # Whole orders are named, half orders have a tick.
        assert spectrum.get_xticks().tolist() == list(range(9))
        assert spectrum.get_xticks(minor=True).tolist() == [k + 0.5 for k in range(8)]


@pytest.mark.parametrize(("place", "size"), [(CHAOS, 1.0), (GEAR, 50.0)])
def test_the_gap_is_shaded(place, size):
    """Of the miter pair it is 50 um wide on either side."""
    for time, _, phase, _ in drawn(place, physical=place is GEAR)[1]:
        (across,), (along,) = ([patch.get_extents() for patch in axes.patches] for axes in (time, phase))
        low, high = time.transData.inverted().transform([[0, across.y0], [0, across.y1]])[:, 1]
        assert (low, high) == pytest.approx((-size, size))
        low, high = phase.transData.inverted().transform([[along.x0, 0], [along.x1, 0]])[:, 0]
        assert (low, high) == pytest.approx((-size, size))
        # Some of it is seen.
        assert time.get_ylim()[0] < size


def test_colours_tell_which_flank_is_in_contact():
    (time, _, phase, _), _ = drawn(CHAOS)[1]
    for colour, low, high in ((DRIVE, 1.0, 9.0), (FREE, -1.0, 1.0), (BACK, -9.0, -1.0)):
        for axes, row in ((time, 1), (phase, 0)):
            (line,) = lines(axes, colour=colour)
            values = line[1] if row == 1 else line[0][~np.isnan(line[1])]
            values = values[~np.isnan(values)]
            # A piece goes on to the sample after it.
            inside = (values >= low) & (values <= high)
            assert values.size > 10 and np.mean(inside) > 0.75
            assert np.all((values > low - 0.2) & (values < high + 0.2))


def test_lines_are_the_motions():
    found = found_at(*PAIR)
    for motion, (time, force, phase, _) in zip(found.attractors, drawn(PAIR)[1], strict=True):
        curves = motion.curves
        whole = np.full(4 * 256 + 1, np.nan)
        for colour in (DRIVE, FREE, BACK):
            for line in lines(time, colour=colour):
                there = ~np.isnan(line[1])
                whole[there] = line[1][there]
        repeated = np.tile(curves.displacement, 4)[: whole.size - 1]
        np.testing.assert_array_equal(whole[:-1], repeated)
        (forces,) = [line for line in lines(force) if line.shape[1] == whole.size]
        np.testing.assert_allclose(forces[1][:-1], np.tile(curves.force, 4)[: whole.size - 1] / found.static_force)
        assert f"{motion.quantities.dynamic_factor:.3g}" in force.texts[0].get_text()
        (points,) = [line for line in phase.lines if line.get_marker() == "o"]
        np.testing.assert_array_equal(np.array(points.get_data()).T, curves.points)


def test_spectra_have_a_line_for_every_order():
    found = found_at(*PAIR)
    for motion, (*_, spectrum) in zip(found.attractors, drawn(PAIR)[1], strict=True):
        segments = [segment for collection in spectrum.collections for segment in collection.get_segments()]
        tops = {segment[1][0]: segment[1][1] for segment in map(np.asarray, segments)}
        assert tops == dict(zip(motion.curves.orders.tolist(), motion.curves.amplitudes.tolist(), strict=True))


def test_the_map_is_dashed_in_the_card_of_the_attractor_that_it_is_and_alone_elsewhere():
    found, (_, cards) = found_at(*TORUS), drawn(TORUS)
    for motion, (time, *_) in zip((*found.attractors, *found.others), cards, strict=True):
        of_map = getattr(motion, "of_map", motion)
        dashed = [line for line in lines(time, dashed=True) if line.shape[1] > 100]
        assert len(dashed) == (of_map is not None)
        if of_map is not None:
            np.testing.assert_array_equal(dashed[0][1][:256], of_map.curves.displacement)
        solid = [line for line in lines(time) if line.shape[1] > 100]
        assert bool(solid) == (motion in found.attractors)


def test_the_text_says_what_each_motion_is():
    figure, _ = drawn(TORUS)
    said = texts(figure)
    for words in ("1T/0", "quasi-periodic/1", "map 2", "map 3", "motion 1 of the map", "ends on A", "20 random starts"):
        assert words in said
    for motion in found_at(*TORUS).attractors:
        assert f"{motion.hits} of 20" in said


def test_legends_list_what_is_there():
    def listed(place):
        return [text.get_text() for text in drawn(place)[0].legends[0].get_texts()]

    assert "back flank" in listed(CHAOS) and "back flank" not in listed(PAIR)
    assert "no contact" in listed(PAIR) and "no contact" not in listed(GEAR)
    assert any("balance" in text for text in listed(GEAR))


def test_physical_units_are_on_the_axes():
    figure, ((time, force, phase, spectrum),) = drawn(GEAR, physical=True)
    found = found_at(*GEAR)
    assert "µm" in time.get_ylabel() and "N" in force.get_ylabel() and "m/s" in phase.get_ylabel()
    assert "ms" in force.get_xlabel() and "µm" in spectrum.get_ylabel() and "rpm" in texts(figure)
    (line,) = lines(time, colour=DRIVE)
    np.testing.assert_allclose(line[1][:256], 50.0 * found.attractors[0].curves.displacement, rtol=1e-12)
    # Two periods of 20 teeth at 14.4 thousand revolutions a minute.
    speed = found.omega * plan_speed()
    assert line[0][-1] == pytest.approx(2.0 * 60e3 / (20 * speed), rel=1e-9)


def plan_speed():
    from pipeline.plan.scales import scales_of

    return scales_of(plan_of(*MITER))["omega"].shown


@pytest.mark.costly
def test_motions_of_the_map_that_are_far_larger_do_not_hide_attractors():
    """Near where the first-order branch goes to infinity (docs/physics.md, section 7)."""
    words = ("gear=consistent", "gear.rotation_coupling=0.93969262", "gear.variation.translation=0")
    place = (0.5918, 0.47, "plane=omega_alpha", *words)
    found, (figure, cards) = found_at(*place), drawn(place)
    assert found.others[-1].quantities.peak_to_peak > 50.0
    assert cards[0][0].get_ylim()[1] < 4.0 < 50.0 < cards[-1][0].get_ylim()[1]
    assert texts(figure).count("axes of its own") == len(cards) - 1
    for motion, (time, *_) in zip((*found.attractors, *found.others), cards, strict=True):
        assert time.get_ylim()[0] <= motion.quantities.lowest and motion.quantities.highest <= time.get_ylim()[1]


def test_what_does_not_move_is_drawn_at_rest():
    """Nothing excites it: what is left of the motion is rounding, and no axis shows that."""
    ((_, _, phase, spectrum),) = drawn((0.7, 0.0, *PUBLISHED, "gear.alpha=0"))[1]
    assert phase.get_ylim()[1] > 1e-3 and spectrum.get_ylim()[1] > 1e-6


def test_pages_hold_all_motions_once():
    found = found_at(*TORUS)
    assert [card for page in pages(found) for card in page] == [*found.attractors, *found.others]
    assert all(len(page) <= PER_PAGE for page in pages(found))
    figure, cards = drawn(TORUS, first=2)
    assert len(cards) == 2 and figure.get_figheight() < 6.0
    # The axes are those of all.
    assert [axes.get_ylim() for axes in cards[0]] == [axes.get_ylim() for axes in drawn(TORUS)[1][0]]
    assert drawn(TORUS)[0].get_figheight() < 11.0


@pytest.mark.costly
@pytest.mark.parametrize("place", [TORUS, PAIR, PAIR[:-2], CHAOS, GEAR])
def test_nothing_lies_on_anything_else(place):
    """Texts and panels."""
    figure, cards = drawn(place, physical=place is GEAR)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    boxes = [text.get_window_extent(renderer) for text in figure.texts if text.get_text()]
    boxes += [axes.get_window_extent(renderer) for card in cards for axes in card]
    boxes += [figure.legends[0].get_window_extent(renderer)]
    for i, one in enumerate(boxes):
        assert one.x0 >= 0.0 and one.x1 <= figure.bbox.x1
        for other in boxes[i + 1 :]:
            # Ascenders of neighbouring lines may touch.
            assert not (one.x0 < other.x1 and other.x0 < one.x1 and one.y0 < other.y1 - 2 and other.y0 < one.y1 - 2)
