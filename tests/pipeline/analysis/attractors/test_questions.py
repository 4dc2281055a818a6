"""Options, words, shares, and questions to a group that was made up."""

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from pipeline.analysis.attractors.options import check_options, grid_of, keys_of, search_of
from pipeline.analysis.attractors.queries import attractors_near, basin_share, hysteresis, hysteresis_intervals, wilson
from pipeline.analysis.attractors.sheets import label_lines, several_right
from pipeline.analysis.attractors.wording import bound, cell_label, label_meaning, likely_missed, percents
from pipeline.config.compose import compose
from pipeline.errors import ConfigurationError
from pipeline.plan.numerics import model_at
from pipeline.run.kernels import kernels_for
from solver import ParameterError, domain_code
from solver.kernels.compile import Kernel
from solver.kernels.warm import kernels_of
from solver.timedomain import AttractorKind as Kind
from solver.timedomain import SeenFrom, continue_attractors, find_attractors
from tests.pipeline.planes import small_plan


def options(*words):
    return compose([f"attractors.{word}" for word in words]).config.attractors


@pytest.mark.parametrize(
    "word",
    [
        "columns=0",
        "columns=42",
        "columns=true",
        "columns=2.5",
        "columns=many",
        "columns=[]",
        "columns=[3.0]",
        "rows=6",
        "rows=[nan]",
        "points=[]",
        "points=0.6",
        "points=[[0.6]]",
        "points=[[0.6,9.0]]",
        "points=[[0.6,true]]",
        "points=[[[0.6,0.2],[0.6,0.2]]]",
        "box=[[0,1],[0,1]]",
    ],
)
def test_what_is_not_allowed_is_named(word):
    with pytest.raises(ConfigurationError, match=rf"attractors\.{word.partition('=')[0]}"):
        check_options(options(word), small_plan())


@pytest.mark.parametrize("word", ["box=[[0,1]]", "box=[[1,0],[0,1]]", "box=[0,1]", "box=[[0,1],[0,inf]]", "starts=0"])
def test_what_is_not_allowed_at_places_is_named(word):
    with pytest.raises(ConfigurationError, match=rf"attractors\.{word.partition('=')[0]}"):
        check_options(options("points=[[0.6,0.2]]", word), small_plan())


def test_what_is_allowed():
    for words in (["columns=41", "rows=1"], ["columns=[0.3,0.6]"], ["points=[[0.6,0.2]]", "box=[[0.5,2],[-1,1]]"]):
        check_options(options(*words), small_plan())


def test_few_periods_still_settle_and_watch():
    search = search_of(options("max_periods=800"))
    assert search.transient + search.watched == 800 and search_of(options()).transient == 300


def test_random_states_belong_to_the_cell():
    plan = small_plan(columns=9, rows=5)
    whole, part = grid_of(plan, options()), grid_of(plan, options("rows=3", "columns=5"))
    assert (
        part.rows == (0, 2, 4) and part.dims == ("attractor_f_e", "attractor_omega") and whole.dims == ("f_e", "omega")
    )
    np.testing.assert_array_equal(keys_of(part, 1, 7), keys_of(whole, 2, 7)[::2])
    every = np.concatenate([keys_of(whole, row, 7) for row in range(5)])
    assert np.unique(every).size == 45 and not np.isin(keys_of(whole, 0, 8), every).any()


def test_words():
    assert cell_label([2, 1, 0, 1], [1, 2, -1, 0]) == "1T/0 + 1T/2 + 2T/1" and cell_label([0], [-1]) == ""
    assert label_meaning("2T/1 + unsettled") == "2T_I1+unsettled"
    assert "(1 - p)^4" in bound(4) and "random" in bound(0)
    share = likely_missed(7)
    assert (1.0 - share) ** 7 == pytest.approx(0.05) and likely_missed(0) == 1.0


@given(st.lists(st.integers(0, 10**6), min_size=1, max_size=8).filter(any))
def test_shares_add_up(counts):
    shares = [round(10 * float(text.removesuffix(" %"))) for text in percents(counts)]
    assert sum(shares) == 1000
    assert all((count > 0) == (share > 0) for count, share in zip(counts, shares, strict=True))
    total = sum(counts)
    assert all(abs(share - 1000 * count / total) <= len(counts) for share, count in zip(shares, counts, strict=True))


def test_wilson_intervals_by_the_formula():
    hits, starts = np.array([0, 19, 40, 4, 0]), np.array([40, 40, 40, 4, 0])
    low, high = wilson(hits, starts)
    z = 1.959963984540054
    for k, n, a, b in list(zip(hits, starts, low, high, strict=True))[:-1]:
        p, s = k / n, z * z / n
        half = np.sqrt(p * (1 - p) * s + s * s / 4)
        assert (a, b) == pytest.approx(((p + s / 2 - half) / (1 + s), (p + s / 2 + half) / (1 + s)), abs=1e-12)
    assert (low[-1], high[-1]) == (0.0, 1.0)


@pytest.fixture
def group():
    """Three columns of one row: one attractor; two, of which a run upwards meets one; two unsettled ones."""
    up, down = int(SeenFrom.UPWARDS), int(SeenFrom.DOWNWARDS)
    kind = np.array([[[1, 0, 0], [1, 2, 0], [Kind.UNSETTLED, Kind.UNSETTLED, 0]]], np.int8)
    seen = np.array([[[up | down, 0, 0], [up, down, 0], [up, down, 0]]], np.uint8)
    impact = np.array([[[0, -1, -1], [0, 1, -1], [-1, -1, -1]]], np.int8)
    hits = np.array([[[4, 0, 0], [1, 3, 0], [1, 0, 0]]], np.int32)
    dims = ("f_e", "omega", "attractor")
    return xr.Dataset(
        {
            "kind": (dims, kind),
            "seen": (dims, seen),
            "impact": (dims, impact),
            "hits": (dims, hits),
            "starts": (dims[:2], np.array([[4, 4, 0]], np.int32)),
        },
        {"f_e": [0.2], "omega": [0.5, 1.0, 1.5]},
        {"bound": bound(4)},
    )


def test_hysteresis_is_between_attractors(group):
    assert hysteresis(group).values.tolist() == [[False, True, False]]
    # One way alone is none either.
    one_way = group.assign(seen=group.seen & int(SeenFrom.UPWARDS))
    assert not hysteresis(one_way).any()


def test_stretches_of_hysteresis():
    x = np.arange(6.0)
    assert hysteresis_intervals(x, np.array([0, 1, 1, 0, 0, 1])).tolist() == [[0.5, 2.5], [4.5, 5.0]]
    assert hysteresis_intervals(x, np.zeros(6)).size == 0


def test_shares_of_basins(group):
    found = basin_share(group, "2T")
    assert found.hits.values.tolist() == [[0, 3, 0]] and found.share.values[0, 1] == 0.75
    assert np.isnan(found.share.values[0, 2]) and found.attrs["bound"] == bound(4)
    assert np.all(found.low <= found.share.fillna(0.5)) and np.all(found.share.fillna(0.5) <= found.high)
    assert basin_share(group, "2T/0").hits.sum() == 0 and basin_share(group, "1T/0").hits.sum() == 5
    for wrong in ("3", "2t", "1T/7", "", 2):
        with pytest.raises(ParameterError):
            basin_share(group, wrong)


def test_what_was_found_near_a_place(group):
    plan = small_plan("plane.parameter.min=0.1", columns=9, rows=5)
    here = attractors_near(group, plan, 1.1, 0.3)
    assert here.kind.values.tolist() == [1, 2] and float(here.omega) == 1.0
    assert here.share_low.values[1] < 0.75 < here.share_high.values[1]


def test_lines_of_labels_add_up():
    one, two = int(domain_code(1, 1)), int(domain_code(2, 3))
    labels = np.array([[one, one, two, 0], [one, two, two, one]])
    judged = np.array([[1, 2, 1, 0], [1, 6, 0, 4]])
    lines = label_lines(labels, judged)
    assert [line.label for line in lines] == ["1/0", "2/0-1", "all"]
    assert all(sum(line.counts.values()) == line.cells for line in lines) and lines[-1].cells == 7
    assert several_right(labels, judged) == (1, 3)


def test_kernels_that_the_stage_calls_are_compiled_ahead(monkeypatch):
    """Every kernel that Python calls while a row is searched and gone on with."""
    plan, called = small_plan(columns=3, rows=2), set()
    honest = Kernel.__call__
    monkeypatch.setattr(Kernel, "__call__", lambda kernel, *given: called.add(kernel) or honest(kernel, *given))
    model, search = model_at(plan, 0.2, plan.sweep.low), search_of(options("starts=1"))
    row = find_attractors(model, "omega", [0.9, 1.0], search=search)
    columns, kinds, states = row.gains(0)
    continue_attractors(model, "omega", [0.9, 1.0], row, columns, kinds, states, round=1, search=search)
    assert called and called <= set(kernels_of(kernels_for(["attractors"], "describing_function")))
