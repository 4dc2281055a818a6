"""Margins of planes of higher order: labels, distances and tolerances against rows of their own."""

import functools

import numpy as np
import pytest

from pipeline.analysis.margins import Design, answer
from pipeline.analysis.margins.distances import further_axis
from pipeline.analysis.margins.options import nominal_value
from pipeline.analysis.margins.sheets import lines, markdown
from pipeline.plan.numerics import balance_of, continuation_of, model_at, seeds_of
from solver import domain_label, sweep_row
from tests.pipeline.analysis.margins.spur import SPUR
from tests.pipeline.planes import small_plan, traced_store

ORDER = ("solver=hb", "solver.order=3")


PLANES = {"fe": (*ORDER, "plane=omega_fe", "plane.sweep.min=0.5", "plane.sweep.max=1.1"), "spur": (*SPUR, *ORDER)}


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """Path and plan of a plane by its name, made when it is first asked for."""
    folder = tmp_path_factory.mktemp("orders")

    @functools.cache
    def make(name):
        plan = small_plan(*PLANES[name], columns=30, rows=6)
        return traced_store(folder / f"{name}.zarr", plan), plan

    return make


def swept(plan, axis, grid, x, p, **changes):
    """Labels along one parameter through (x, p), from a fine row of its own."""
    at = {plan.sweep.name: x, plan.parameter.name: p, **changes}
    omega = at.pop("omega", plan.omega)
    at.pop(axis, None)
    row = sweep_row(
        model_at(plan, p, x).replace(**at),
        axis,
        grid,
        omega=None if axis == "omega" else omega,
        continuation=continuation_of(plan.solver),
        seeds=seeds_of(plan.solver),
        balance=balance_of(plan.solver),
    )
    return [domain_label(int(code)) for code in row.domain]


@pytest.mark.costly
@pytest.mark.parametrize(
    ("name", "x", "p", "further"),
    [("fe", 0.62, 0.2, {"alpha": 0.05}), ("fe", 0.9, 0.1, {"b": 0.1}), ("spur", 0.5, 0.1, {"alpha": 0.02})],
)
def test_distances(stored, name, x, p, further):
    path, plan = stored(name)
    design = Design(x, p, x, x, 0.0, further)
    found = answer(path, plan, design)
    assert [found.label] == swept(plan, "omega", np.array([plan.sweep.low, x, plan.sweep.high]), x, p)[1:2]
    met, rows = 0, {}
    for margin in (one for one in found.margins if one.name != plan.parameter.name):
        value = nominal_value(plan, x, p, margin.name)
        if margin.name not in rows:
            whole = plan.sweep if margin.name == "omega" else further_axis(plan, design, margin.name)
            # Branches may be reached from one side alone: all of the axis is swept.
            grid = np.unique([*np.linspace(whole.low, whole.high, 601), value])
            rows[margin.name] = grid, np.array(swept(plan, margin.name, grid, x, p))
        grid, labels = rows[margin.name]
        here = (grid >= value) if margin.upward else (grid <= value)
        labels, grid = labels[here], grid[here]
        labels, grid = (labels, grid) if margin.upward else (labels[::-1], grid[::-1])
        change = next((i for i, label in enumerate(labels) if label != labels[0]), None)
        assert (margin.place is None) == (change is None)
        if change is not None:
            met += 1
            low, high = sorted(grid[change - 1 : change + 1])
            assert low - 1e-9 <= margin.place <= high + 1e-9
            assert domain_label(margin.beyond) == labels[change]
    assert met


@pytest.mark.costly
@pytest.mark.parametrize(
    ("name", "design"),
    [
        ("fe", Design(0.62, 0.2, 0.55, 0.68, 0.05, {"b": 0.2})),
        pytest.param("spur", Design(0.5, 0.1, 0.44, 0.56, 0.02, {"alpha": 0.05}), marks=pytest.mark.slow),
        ("spur", Design(0.45, 0.1, 0.45, 0.45, 0.05)),
    ],
)
def test_labels_within_tolerances(stored, name, design):
    """Every label of a fine raster over range and tolerance, with both ends of a parameter that is no axis."""
    path, plan = stored(name)
    found = answer(path, plan, design)
    assert len(found.corners) == (3 if design.further else 1)
    across = np.unique([plan.sweep.low, *np.linspace(design.low, design.high, 90), plan.sweep.high])
    inside = (across >= design.low) & (across <= design.high)
    for corner in found.corners:
        seen = set()
        for row in np.linspace(design.p - design.tolerance, design.p + design.tolerance, 11):
            changes = {plan.parameter.name: row, **corner.values}
            seen |= set(np.array(swept(plan, "omega", across, design.x, design.p, **changes))[inside])
        # Narrow strips between two rows are seen by neither.
        assert seen <= set(corner.labels)
        assert set(corner.labels) <= seen or len(corner.labels) == len(seen) + 1
    assert "search" in found.notes[-1]


@pytest.mark.costly
def test_the_box(stored):
    path, plan = stored("fe")
    found = answer(path, plan, Design(0.9, 0.1, 0.85, 1.0, 0.01))
    assert found.label == "1/0" and found.box.x[0] <= 0.85 and found.box.x[1] >= 1.0
    across = np.linspace(*found.box.x, 60)
    for row in np.linspace(*found.box.p, 9):
        assert set(swept(plan, "omega", across[1:-1], 0.9, float(row))) == {"1/0"}
    assert "Largest box of 1/0 at order 3" in markdown(found, "hb")
    assert "label at omega = 0.9, f_e = 0.1: 1/0" in lines(found)[0]


def test_the_spur_pair_loses_contact_at_order_3(stored):
    """docs/physics.md, section 9: λ from 0.95104 at (0.5, 0.1), where first order says 1/0."""
    found = answer(*stored("spur"), Design(0.5, 0.1, 0.5, 0.5))
    assert found.label == "1/1" and found.box is None
    assert not any("does not feel" in doubt for doubt in found.doubts)
