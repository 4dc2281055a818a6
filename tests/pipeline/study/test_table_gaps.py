"""Tables of planes that are too small, too coarse, unfinished or of another kind: what is missing is said."""

import csv
import io

import numpy as np
import pytest
import zarr

from pipeline import store
from pipeline.errors import StoreError
from pipeline.study import tables
from pipeline.study.numerals import percent
from pipeline.study.tables.article import band_rows
from pipeline.study.tables.claims import Verdict
from pipeline.study.tables.latex import latex
from pipeline.study.tables.markdown import markdown
from pipeline.study.tables.table import build_table
from pipeline.study.tables.tidy import tidy
from solver import Event
from tests.conftest import consistent
from tests.pipeline.planes import small_plan, small_store
from tests.pipeline.study.golden_files import PLANES
from tests.pipeline.study.latex_parser import check_latex


def make(folder, plane, *overrides, columns=121, rows=9):
    return small_store(folder / f"{plane}.zarr", small_plan(f"plane={plane}", *overrides, columns=columns, rows=rows))


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stores")
    return {plane: (make(folder, plane, columns=9, rows=2), f"python -m pipeline plane={plane}") for plane in PLANES}


def test_a_band_that_the_plane_does_not_cover_says_so(tmp_path):
    path = make(tmp_path, "omega_b", "plane.parameter.min=0.02", "plane.parameter.max=0.15", rows=3)
    table = build_table(PLANES["omega_b"], path)
    assert [line.gap for line in table.lines] == ["", ""] + ["not covered by this plane: b = 0.02–0.15"] * 4
    assert table.rows[1].cells[0].verdict == Verdict("cannot be compared", "mesh and shaft not measured")
    lines = list(csv.DictReader(io.StringIO(tidy(table))))
    assert lines[2]["gap"] == "not covered by this plane: b = 0.02-0.15" and lines[2]["widest"] == "nan"
    assert "not covered by this plane: b = 0.02–0.15" in markdown(table) and latex(table).isascii()


@pytest.mark.costly
def test_a_plane_without_rows_in_the_bands_still_has_regions(tmp_path):
    coarse = make(tmp_path, "omega_fpm", "plane.parameter.min=0.3", "plane.parameter.max=1.2", rows=2)
    lines = build_table(PLANES["omega_fpm"], coarse).lines
    assert not any(line.gap or line.measured.peaks for line in lines)
    assert [line.measured.region.low for line in lines[::2]] == [0.5, 0.75]
    short = make(tmp_path, "omega_alpha", "plane.sweep.max=0.9", rows=3)
    table = build_table(PLANES["omega_alpha"], short)
    assert [line.gap for line in table.lines] == ["", "not covered by this plane: Ω = 0.05–0.9"] * 2
    assert table.rows[0].cells[1].verdict == Verdict("cannot be compared", "shaft not measured")


def test_boundaries_that_do_not_divide_the_plane_are_said(tmp_path):
    path = make(tmp_path, "omega_fpm", rows=7)
    event = zarr.open_group(path, mode="r+")["branches/event"]
    codes = event[:]
    codes[codes == Event.FOLD] = Event.NONE
    event[:] = codes
    table = build_table(PLANES["omega_fpm"], path)
    assert all(line.gap.startswith("no regions of one label: no boundary parts") for line in table.lines)
    assert table.labels == () and table.undivided == table.lines[0].gap
    assert {cell.verdict.kind for row in table.rows for cell in row.cells} == {"cannot be compared"}
    assert "no regions of one label" in markdown(table) and check_latex(latex(table)) == 3
    assert list(csv.DictReader(io.StringIO(tidy(table))))[0]["jump_ends"] == "nan"


@pytest.mark.costly
def test_failed_rows_are_left_out_and_counted(tmp_path):
    path = make(tmp_path, "omega_fpm", "plane.parameter.min=0.5", "plane.parameter.max=1.0", rows=7)
    rows = band_rows(PLANES["omega_fpm"].bands[1], store.read_plan(path).parameter)
    whole = build_table(PLANES["omega_fpm"], path).lines[2].measured
    zarr.open_group(path, mode="r+")["status"][rows[:2]] = store.FAILED
    table = build_table(PLANES["omega_fpm"], path)
    mesh = table.lines[2].measured
    assert table.failed == 2 and mesh.failed == 2 and mesh.peaks == whole.peaks[2:]
    assert mesh.region.shares == pytest.approx(whole.region.shares, abs=1e-8)


def test_a_gear_without_jumps(tmp_path):
    path = make(tmp_path, "omega_b", "gear=consistent", "plane.parameter.min=0.9", rows=4)
    row = build_table(PLANES["omega_b"], path).rows[2]
    line, ours = row.lines[1], [cell.ours.get("shaft") for cell in row.cells]
    band = line.measured
    assert max(band.widths) == 0.0 and band.edges["jump"] == () and np.isnan(band.envelope).all()
    single = percent(band.state_share(1))
    assert ours == ["no jump; near linear", None, f"{band.lacking.text} by dynamic stability"]
    assert single == percent(sum(share for label, share in band.region.shares.items() if label.endswith("1")))
    assert (line.resonance.natural) == pytest.approx(consistent().mesh_modes()[1])


def test_other_balances_are_refused(tmp_path, stores):
    path = small_store(tmp_path / "order.zarr", small_plan("plane=omega_b", "solver=hb", rows=3, columns=9), blocks=[])
    with pytest.raises(StoreError, match="not balanced at first order"):
        tables.write({**stores, "omega_b": (path, "command")}, tmp_path / "tables")


def test_unusable_planes_are_all_named_with_their_commands(tmp_path, stores):
    unfinished = tmp_path / "unfinished.zarr"
    small_store(unfinished, small_plan("plane=omega_alpha", rows=40, columns=9), blocks=[])
    foreign = tmp_path / "foreign.zarr"
    foreign.write_text("not a store")
    bad = {
        "omega_b": (tmp_path / "nowhere.zarr", "command 1"),
        "omega_alpha": (unfinished, "command 2"),
        "omega_fpm": (stores["omega_b"][0], "command 3"),
    }
    for changed in (bad, {**bad, "omega_fpm": (foreign, "command 3")}):
        with pytest.raises(StoreError) as caught:
            tables.write(changed, tmp_path / "tables")
        message = str(caught.value)
        assert "\n" not in message and all(f"(run: command {n})" in message for n in (1, 2, 3))
        assert all(plane in message for plane in PLANES) and "40 of 40 rows" in message
    with pytest.raises(StoreError) as caught:
        tables.write({**stores, "omega_b": bad["omega_b"]}, tmp_path / "tables")
    assert "omega_alpha" not in str(caught.value)
    assert not (tmp_path / "tables").exists()
