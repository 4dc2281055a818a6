"""The line that a run ends with, and the console around it."""

import io
import re

import numpy as np
import pytest
import zarr

from pipeline import store
from pipeline.__main__ import main
from pipeline.plane.result import result_line
from pipeline.plane.stored import StoredPlane
from pipeline.run import progress
from pipeline.run.progress import Reporter, RowProgress
from solver import label_parts
from tests.pipeline.planes import small_plan, small_store

_SMALL = ["plane.sweep.num=40", "plane.parameter.num=5", "cluster=none", "figures.formats=[png]", "figures.dpi=30"]


@pytest.fixture(scope="module")
def default_run(tmp_path_factory):
    """A folder, and what a default run of a small plane says."""
    folder = tmp_path_factory.mktemp("run")
    patch = pytest.MonkeyPatch()
    with patch.context() as here:
        here.setattr("sys.stdout", io.StringIO())
        assert main([*_SMALL, f"output.root={folder}"]) == 0
        import sys

        return folder, sys.stdout.getvalue().splitlines()


def test_a_run_ends_with_what_the_map_tells(default_run):
    folder, said = default_run
    name, domains, *shares = re.fullmatch(
        r"(\S+): (\d+) domains; several motions in ([\d.]+) % of the plane, teeth part in ([\d.]+) %, "
        r"back flanks struck in ([\d.]+) %",
        said[-1],
    ).groups()
    root = zarr.open_group(folder / "store/omega_fe.zarr", mode="r")
    assert name == "omega_fe" and int(domains) == np.unique(root["domain"][...]).size
    # Counted again, from the motions and not from the labels.
    stable = root["stable"][...] == 1
    impact = root["impact"][...]
    expected = (
        np.mean(np.sum(stable, axis=2) > 1),
        np.mean(np.any(stable & ~np.isin(impact, (0, 5)), axis=2)),
        np.mean(np.any(stable & (impact == 2), axis=2)),
    )
    assert [float(share) for share in shares] == pytest.approx([100 * one for one in expected], abs=0.051)


def test_nothing_is_said_that_every_run_says(default_run):
    _, said = default_run
    assert not [line for line in said if re.search(r"\b0 rows/s|\b0 failed|0 rows failed|^note", line)]


def test_what_is_not_computed_is_left_out(tmp_path):
    plan = small_plan(columns=9, rows=6)
    path = small_store(tmp_path / "plane.zarr", plan, plan.blocks[:2])
    assert "of what is computed of the plane" in result_line(StoredPlane(path, plan))
    empty = tmp_path / "empty.zarr"
    store.create(empty, plan, "empty", "")
    assert result_line(StoredPlane(empty, plan)) == ""


def test_labels_are_counted_once(default_run):
    folder, said = default_run
    root = zarr.open_group(folder / "store/omega_fe.zarr", mode="r")
    flags = root["domain"].attrs
    known = dict(zip(flags["flag_values"], flags["labels"], strict=True))
    several = sum(label_parts(known[code])[0] > 1 for code in np.unique(root["domain"][...]))
    assert 0 < several < int(re.search(r"(\d+) domains", said[-1])[1])


def test_progress_says_how_fast_it_goes_and_not_that_it_stands_still(monkeypatch):
    now = iter(np.arange(0.0, 1000.0, 20.0))
    monkeypatch.setattr(progress.time, "monotonic", lambda: float(next(now)))
    stream = io.StringIO()
    with RowProgress(Reporter(stream), 4) as bar:
        for _ in range(4):
            bar.advance(1, 0)
    lines = stream.getvalue().splitlines()
    assert len(lines) == 3 and lines[0].split() == ["1/4", "rows,", "20", "s", "a", "row,", "60", "s", "left"]
    assert not any(re.search(r"\b0 rows/s|failed", line) for line in lines)
