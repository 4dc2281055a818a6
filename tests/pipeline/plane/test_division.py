"""What boundaries divide a plane into, against cells that know nothing of boundaries."""

from types import SimpleNamespace

import numpy as np
import pytest

import pipeline
from pipeline.errors import StoreError
from pipeline.plan.numerics import frame_of
from pipeline.plane.division import _PLACES, _ROWS, _without_missed, parting_arcs, stored_division
from pipeline.plane.resonances import mesh_shares
from pipeline.plane.stability import region_stability, together
from pipeline.plane.stored import read_stored
from solver import Event, domain_label
from solver.boundaries.problem import Plane
from solver.regions.division import DividedSlab, divided
from solver.regions.labelling import KnownCells, Labeller, dynamic_code, is_contradictory, stability_codes, static_code
from solver.regions.slabs import RegionError, Slab
from tests.conftest import MODELS
from tests.pipeline.planes import small_plan, small_store, traced_store

#: Curves are stored to this, and cells nearer to one may lie on either side.
NEAR = 1e-5


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    """A part of the default plane with contradictions, two resonances 1:1 and a multiplier that passes +1."""
    swept = small_plan("plane.sweep.max=1.4", "plane.parameter.min=0.05", columns=60, rows=16)
    return read_stored(traced_store(tmp_path_factory.mktemp("division") / "plane.zarr", swept))


@pytest.fixture(scope="module")
def parametric(tmp_path_factory):
    """Period doublings at twice a natural frequency (docs/physics.md, section 8), over another pair of axes."""
    overrides = (
        "plane=omega_alpha",
        "gear=consistent",
        "gear.rotation_coupling=0.93969262",
        "plane.sweep.min=1.0",
        "plane.sweep.max=1.5",
        "plane.parameter.max=0.4",
    )
    swept = small_plan(*overrides, columns=60, rows=12)
    return read_stored(traced_store(tmp_path_factory.mktemp("division") / "parametric.zarr", swept))


def check_cells(plane, count=4000, seed=0):
    """Random places: what the regions say is what enumeration and multipliers say; their number."""
    plan, division = plane.plan, stored_division(plane)
    frame, draw, looked = Plane(*frame_of(plan), plan.omega), np.random.default_rng(seed), 0
    for p in draw.uniform(plan.parameter.low, plan.parameter.high, 20):
        x = np.sort(draw.uniform(plan.sweep.low, plan.sweep.high, count // 20))
        said, cells = division.codes_at(x, np.array([p]))[0], stability_codes(frame, float(p), x, 100.0)
        borders = np.concatenate([curve.crossings(np.array([p]))[1][:, 3] for curve in division.curves])
        away = np.min(np.abs(x[:, None] - borders), axis=1, initial=np.inf) > NEAR
        away &= cells != 0
        np.testing.assert_array_equal(said[away], cells[away], f"{plan.parameter.name} = {p}")
        looked += int(away.sum())
    return looked


def test_random_places_are_what_their_region_says(plane):
    assert check_cells(plane) > 3900


def test_random_places_of_a_parametric_resonance(parametric):
    assert check_cells(parametric) > 3900
    kinds = {curve.kind for curve in parametric.boundaries.curves}
    assert Event.PERIOD_DOUBLING in kinds
    assert any(dynamic_code(code) != static_code(code) for code in stored_division(parametric).shares())


def test_stored_cells_are_what_their_region_says(plane):
    said = stored_division(plane).codes_at(plane.plan.sweep.values, plane.rows)
    np.testing.assert_array_equal(said[:, 1:-1], plane.stability_codes[:, 1:-1])
    assert np.any(is_contradictory(said)) and np.any(dynamic_code(said) != static_code(said))
    assert np.any(plane.contradictory) and np.any(plane.unstable)


def asked_places(plane, known, curves=None):
    """How many places a division enumerates, and its codes."""
    division, asked = stored_division(plane), []

    def codes(frame, p, x, ceiling):
        asked.append(x.size)
        return stability_codes(frame, p, x, ceiling)

    found = divided(
        division.plane,
        division.curves if curves is None else curves,
        lambda met: Labeller(division.plane, met, 100.0, codes, _ROWS, _PLACES, 1e-8, known),
    )
    return sum(asked), [part.codes for part in found.slabs]


def cells_of(plane):
    return KnownCells(plane.rows, plane.plan.sweep.values[1:-1], plane.domain[:, 1:-1].astype(np.int64))


def test_what_known_cells_bear_out_is_asked_once(plane):
    """Cells save places; what one says that is wrong only makes them be asked again."""
    known = cells_of(plane)
    wrong = KnownCells(known.p, known.x, np.where(known.codes == known.codes.max(), 0, known.codes.max()))
    (fewest, codes), (fewer, same), (all_places, expected) = (
        asked_places(plane, cells) for cells in (known, wrong, None)
    )
    assert codes == same == expected == [part.codes for part in stored_division(plane).slabs]
    assert fewest < fewer < all_places


def test_cells_notice_that_a_boundary_is_missing(plane):
    curves = tuple(curve for curve in stored_division(plane).curves if curve.kind is not Event.FOLD)
    with pytest.raises(RegionError, match="no boundary parts different labels"):
        asked_places(plane, cells_of(plane), curves)


def test_shares_are_those_of_the_thresholds(plane):
    """Two ways to the same area: stored cubics here, boundaries followed again there."""
    static = {}
    for code, share in stored_division(plane).shares().items():
        label = domain_label(static_code(code))
        static[label] = static.get(label, 0.0) + share
    found = {}
    for one in pipeline.thresholds(plane.path):
        found[one.label] = found.get(one.label, 0.0) + one.share
    assert static.keys() == found.keys() and sum(static.values()) == pytest.approx(1.0, abs=1e-12)
    for label, share in found.items():
        assert static[label] == pytest.approx(share, abs=2e-7)


def test_a_region_has_so_much_without_a_stable_motion(plane):
    """Shares of a part of the plane are those of a lattice over it."""
    window, rows = (1.1, 1.4), (0.2, 0.45)
    found = region_stability(plane, window, rows)
    whole = together(found.values())
    x = window[0] + (np.arange(1500) + 0.5) / 1500 * (window[1] - window[0])
    p = rows[0] + (np.arange(600) + 0.5) / 600 * (rows[1] - rows[0])
    codes = stored_division(plane).codes_at(x, p)
    static, dynamic = static_code(codes), dynamic_code(codes)
    assert whole.share == pytest.approx(1.0, abs=1e-12)
    assert whole.none_stable == pytest.approx(float(np.mean((dynamic >> 6 == 0) & (static >> 6 > 0))), abs=1e-3)
    assert whole.one_unstable == pytest.approx(float(np.mean(static != dynamic)), abs=1e-3)
    assert 0.6 < whole.none_stable < whole.one_unstable < 0.8
    assert found["1/0"].none_stable == 0.0 and 0.5 < found["1/1"].none_stable / found["1/1"].share < 1.0
    assert list(found) == sorted(found, key=lambda label: (int(label[0]), len(label), label))


def test_lines_part_what_differs(plane):
    """Static lines are folds and grazings of stable motions; dynamic ones are not drawn where nothing changes."""
    static, dynamic = parting_arcs(plane), parting_arcs(read_stored(plane.path, dynamic=True))
    assert static.keys() == dynamic.keys()
    folds = [number for number, curve in enumerate(plane.boundaries.curves) if curve.kind is Event.FOLD]
    drawn, left = (sum(int(arcs[number].sum()) for number in folds) for arcs in (static, dynamic))
    assert 0 < left < drawn
    for number, shown in static.items():
        if plane.boundaries.curves[number].kind in (Event.FOLD, Event.MIN_AT_DRIVE):
            assert np.mean(shown[plane.boundaries.curves[number].arc_shows]) > 0.95


@pytest.mark.costly
def test_at_a_higher_order_regions_are_what_their_cells_say(tmp_path):
    """No solution is enumerated there: cells have what the region says, and every place has a label."""
    overrides = ("solver=hb", "solver.order=3", "plane.sweep.min=0.45", "plane.sweep.max=0.75")
    plane = read_stored(
        traced_store(tmp_path / "order.zarr", small_plan(*overrides, "plane.parameter.min=0.1", columns=60, rows=10))
    )
    division = stored_division(plane)
    said, cells = division.codes_at(plane.plan.sweep.values, plane.rows), plane.stability_codes
    np.testing.assert_array_equal(said[1:-1, 1:-1], cells[1:-1, 1:-1])
    shares = division.shares()
    assert 0 not in shares and sum(shares.values()) == pytest.approx(1.0, abs=1e-12)
    assert len({static_code(code) for code in shares}) > 3
    assert any(static_code(code) != dynamic_code(code) for code in shares)
    fine = division.codes_at(np.linspace(0.45, 0.75, 300), np.linspace(0.1, 0.5, 200))
    assert np.all(fine != 0)


@pytest.mark.parametrize(
    ("codes", "widths", "expected"),
    [
        # Between two folds, and the same on both sides of each: the pair was missed.
        ((65, 65, 65), (0.4, 0.2, 0.4), [65, 0, 65]),
        # The narrower side of a single fold.
        ((65, 65), (0.9, 0.1), [65, 0]),
        ((65, 66), (0.5, 0.5), [65, 66]),
    ],
)
def test_a_fold_tells_of_a_pair_that_a_row_has_missed(codes, widths, expected):
    curves = [SimpleNamespace(kind=Event.FOLD)] * (len(codes) - 1)
    arcs = ((-1, 0), *((i, 0) for i in range(len(codes) - 1)), (-1, 1))
    part = DividedSlab(Slab(0.0, 1.0, arcs), codes, np.array(widths))
    x = np.concatenate([[0.0], np.cumsum(widths)])
    assert _without_missed(SimpleNamespace(curves=curves), part, x) == expected


def test_what_is_not_allowed_is_said(plane, tmp_path):
    with pytest.raises(StoreError, match="x_window"):
        region_stability(plane, (0.0, 1.0))
    with pytest.raises(StoreError, match="p_window"):
        region_stability(plane, None, (0.2, 0.9))
    with pytest.raises(StoreError, match="stages="):
        region_stability(small_store(tmp_path / "untraced.zarr", small_plan(columns=5, rows=2)))


def test_modes_are_named_by_their_mesh_energy():
    """docs/physics.md, section 10."""
    for gear, percent in (("published", (46, 54)), ("consistent", (30, 70)), ("antiphase", (30, 70))):
        assert tuple(round(100.0 * share) for share in mesh_shares(MODELS[gear]())) == percent
    # A contact that moves no support has all of its energy in the mesh.
    assert max(mesh_shares(MODELS["published"](translation_coupling=0.0))) == pytest.approx(1.0)
