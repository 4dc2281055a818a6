"""What margins promise: nothing that is not known, each with its source."""

import shutil

import numpy as np
import pytest
import zarr

from pipeline.analysis.margins import Design, answer
from pipeline.analysis.margins.integration import integrated
from pipeline.analysis.margins.knowledge import Known
from pipeline.analysis.margins.resonances import mesh_modes, resonances_in
from pipeline.analysis.margins.sheets import lines, markdown, tidy
from pipeline.plan.numerics import model_at
from pipeline.plan.unfelt import unfelt_harmonics
from solver import ImpactState
from solver.timedomain import settle
from tests.pipeline.analysis.margins.made_attractors import BOUND, KINDS, LOUD, QUIET, put_attractors
from tests.pipeline.analysis.margins.spur import SPUR
from tests.pipeline.planes import small_plan, traced_store


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("known")
    plans = {"spur": small_plan(*SPUR, columns=41, rows=9), "fe": small_plan("plane=omega_fe", columns=60, rows=16)}
    return {name: (traced_store(folder / f"{name}.zarr", plan), plan) for name, plan in plans.items()}


def test_first_order_promises_nothing_of_the_spur_pair(made):
    """Teeth part at (0.5, 0.1), λ from 0.95104 by integration, and order 1 says 1/0 (docs/physics.md, section 9)."""
    path, plan = made["spur"]
    model = model_at(plan, 0.1, 0.5)
    # Translations are no part of the motion: a state is λ and its speed.
    settled, slots = settle(model, 0.5, [[1.1, 0.0]])
    (slot,) = slots.tolist()
    assert settled.impact[..., slot] == ImpactState.SINGLE_SIDED
    assert settled.lowest[..., slot] == pytest.approx(0.95104, abs=2e-5)
    found = answer(path, plan, Design(0.5, 0.1, 0.5, 0.5), "HOW")
    assert found.label == "1/0" and found.doubts
    assert any("first order alone" in doubt for doubt in found.doubts)
    assert any(unfelt_harmonics(plan).words in doubt for doubt in found.doubts)
    for text in ("\n".join(lines(found)), markdown(found, "spur"), tidy(found)):
        assert "not integrated: run HOW" in text and "safe" not in text.lower()
        assert "Not verified" in text or "verified" in text
    assert [one.omega for one in found.resonances] == pytest.approx([1 / 3, 1 / 2], abs=1e-12)


@pytest.mark.costly
def test_what_integration_found_is_said(made, tmp_path):
    path, plan = made["fe"]
    path = shutil.copytree(path, tmp_path / "fe.zarr")
    design = Design(0.9, 0.1, 0.8, 1.0)
    box = answer(path, plan, design).box
    rows, columns = (
        np.flatnonzero((axis.values >= ends[0]) & (axis.values <= ends[1]))
        for axis, ends in ((plan.parameter, box.p), (plan.sweep, box.x))
    )
    cells = rows.size * columns.size
    put_attractors(path, plan, {})
    found = answer(path, plan, design, "HOW")
    assert f"integration: 1T/0 alone in {cells} of {cells} cells of the box" in found.sentences[1]
    assert all("HOW" not in text for text in lines(found)) and found.known[1].confirmed
    assert found.doubts == tuple(doubt for doubt in found.doubts if "beside it" in doubt or "contradict" in doubt)
    assert "dynamic factor K_v 1.2" in markdown(found, "fe")
    # Without a doubt the bound is said.
    assert (BOUND in markdown(found, "fe")) == (not found.doubts)

    inside, outside = (rows[0], columns[1]), (plan.parameter.num - 1, 0)
    put_attractors(path, plan, {inside: [QUIET, LOUD], outside: [{**LOUD, "force": 9.0}]})
    found = answer(path, plan, design, "HOW")
    assert found.known[1].found.motions == {"1T/0": cells - 1, "1T/0 + 2T/1": 1}
    assert any("other motions in the box" in doubt for doubt in found.doubts)
    largest = {one.name: one for one in found.known[1].found.largest}
    assert largest["dynamic factor K_v"].value == 2.5 and largest["contact loss"].value == 0.25
    assert largest["RMS of λ"].x == plan.sweep.values[columns[1]]
    assert "contact loss 25 %" in "\n".join(lines(found))

    # Some columns of the plane alone, and attractors of other rows.
    put_attractors(path, plan, {}, columns=columns[:-3])
    found = answer(path, plan, design, "HOW")
    assert f"{3 * rows.size} cells are not integrated: run HOW" in found.sentences[1]
    assert found.known[1].found.looked_at == cells - 3 * rows.size and not found.known[1].integrated
    put_attractors(path, plan, {}, digest="0" * 16)
    assert integrated(path, plan, box.x, box.p) is None


def test_unsettled_is_nothing_else(made, tmp_path):
    path, plan = made["fe"]
    path = shutil.copytree(path, tmp_path / "fe.zarr")
    cell = int(np.argmin(np.abs(plan.parameter.values - 0.1))), int(np.argmin(np.abs(plan.sweep.values - 0.9)))
    put_attractors(path, plan, {cell: [{**QUIET, "kind": KINDS.index("unsettled"), "impact": -1}]})
    found = answer(path, plan, Design(0.9, 0.1, 0.9, 0.9))
    assert "integration: unsettled alone in the nearest cell" in found.sentences[0]
    assert not found.known[0].confirmed and any("other motions" in doubt for doubt in found.doubts)


@pytest.mark.parametrize(
    ("label", "motions", "confirmed"),
    [
        ("1/0", "1T/0", True),
        ("1/0", "1T/1", False),
        ("1/0", "2T/0", False),
        ("1/0", "1T/0 + 1T/0", False),
        ("2/0-1", "1T/0 + 1T/1", True),
        ("2/1", "1T/1 + 1T/1", True),
        ("2/0-1", "1T/0 + 1T/1 + 2T/1", False),
        ("2/0-1", "1T/0", False),
    ],
)
def test_a_label_is_confirmed_by_its_motions_and_no_other(label, motions, confirmed):
    from pipeline.analysis.margins.integration import Integrated

    assert Known("first order", label, Integrated(3, {motions: 3}, BOUND, ()), True).confirmed == confirmed
    assert not Known("first order", label, Integrated(4, {motions: 3}, BOUND, ()), True).confirmed


def test_period_doublings_are_said_and_end_the_box(made):
    """The box holds no bifurcation of a statically stable motion; a point next to one is told so."""
    from pipeline.analysis.margins.curves import BIFURCATIONS, boundaries_of
    from pipeline.plane.stored import StoredPlane

    path, plan = made["fe"]
    curves = boundaries_of(StoredPlane(path, plan).boundaries.curves, BIFURCATIONS)
    found = answer(path, plan, Design(0.72, 0.1, 0.72, 0.72))
    (loss,) = (one for one in found.losses if one.name == "omega" and not one.upward)
    assert loss.kind in BIFURCATIONS and loss.distance < 0.02 * (plan.sweep.high - plan.sweep.low)
    assert any("runs beside it" in doubt for doubt in found.doubts)
    far = answer(path, plan, Design(1.8, 0.05, 1.8, 1.8))
    assert not any("runs beside it" in doubt for doubt in far.doubts)
    x, p = ((low + 1e-6, high - 1e-6) for low, high in (far.box.x, far.box.p))
    assert not curves.kinds_in(x, p)


def test_modes_are_named_by_mesh_strain_energy():
    """docs/physics.md, section 10: lower and upper mode of three gears; the linear frequencies they have."""
    for gear, shares in (("published", (0.46, 0.54)), ("antiphase", (0.30, 0.70)), ("miter", (0.12, 0.88))):
        plan = small_plan(f"gear={gear}")
        model = model_at(plan, plan.parameter.low, 1.0)
        modes = mesh_modes(model)
        assert [share for _, share in modes] == pytest.approx(shares, abs=0.005)
        assert [natural for natural, _ in modes] == pytest.approx(model.mesh_modes(), rel=1e-12)
        natural = modes[0][0]
        assert [one.omega for one in resonances_in(model, 0.99 * natural, 1.01 * natural)] == pytest.approx([natural])


def test_a_group_that_is_no_group(made, tmp_path):
    """What is not listed counts as none."""
    path, plan = made["fe"]
    assert "attractors" not in zarr.open_group(path, mode="r")
    assert integrated(path, plan, (0.8, 1.0), (0.1, 0.2)) is None


@pytest.mark.costly
def test_an_unstable_motion_has_no_box(tmp_path):
    """docs/physics.md, section 8: one solution, statically stable; its multiplier is -1.047, and a 2T motion is met."""
    words = ("plane=omega_fe", "gear=consistent", f"gear.rotation_coupling={np.cos(np.radians(20.0))}")
    window = ("gear.variation.translation=0", "plane.sweep.min=1.1", "plane.sweep.max=1.4")
    plan = small_plan(*words, *window, columns=30, rows=5)
    path = traced_store(tmp_path / "doubled.zarr", plan)
    found = answer(path, plan, Design(1.2, 0.2, 1.2, 1.2))
    assert found.label == "1/0" and found.box is None
    assert "dynamically unstable (period doubling)" in found.notes[0]
    assert "a motion is dynamically unstable (period doubling)" in found.doubts
