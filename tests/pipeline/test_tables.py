"""Tables 1 to 3: every kind of cell against the raw store, the rules at their thresholds, the formats, and refusals."""

import csv
import io
import re

import numpy as np
import pytest
import xarray as xr
import zarr
from scipy.signal import find_peaks

from pipeline import store, tables
from pipeline.errors import StoreError
from pipeline.tables.article import ARTICLE_TABLES, band_rows
from pipeline.tables.classes import (
    percent,
)
from pipeline.tables.edges import edges
from pipeline.tables.latex import escape
from pipeline.tables.peaks import resonance_peak
from pipeline.tables.pieces import Branches, multivalued_intervals, row_pieces
from pipeline.tables.rows import measure_rows, resonances
from pipeline.tables.table import build_table
from solver import Continuation, Event, domain_label, first_order_problem, sweep_row
from tests.conftest import consistent, published
from tests.pipeline.planes import small_plan, small_store

PLANES = {article.plane: article for article in ARTICLE_TABLES}
NAMES = [f"table{number}.{suffix}" for number in (1, 2, 3) for suffix in ("csv", "md", "tex")]


def make(folder, plane, *overrides, columns=121, rows=9):
    return small_store(folder / f"{plane}.zarr", small_plan(f"plane={plane}", *overrides, columns=columns, rows=rows))


def records(text):
    return list(csv.DictReader(io.StringIO(text)))


def written(stores, folder):
    return {path.name: path.read_text(encoding="utf-8") for path in tables.write(stores, folder)}


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stores")
    return {plane: (make(folder, plane), f"python -m pipeline plane={plane}") for plane in PLANES}


@pytest.fixture(scope="module")
def texts(stores, tmp_path_factory):
    return written(stores, tmp_path_factory.mktemp("tables") / "new" / "folder")


@pytest.fixture(scope="module", params=sorted(PLANES))
def plane(request, stores, texts):
    """The records of a table with the arrays of the store behind it."""
    article, path = PLANES[request.param], stores[request.param][0]
    data, branches = xr.open_zarr(path).load(), xr.open_zarr(path, group="branches").load()
    return article, records(texts[f"table{article.number}.csv"]), data, branches


def in_band(record, data):
    values = data[record["parameter"]].values
    first, last = float(record["first_value"]), float(record["last_value"])
    return np.flatnonzero((values >= first - 1e-9) & (values <= last + 1e-9))


def half(record, omega):
    split = np.sqrt(np.prod(published().mesh_modes()))
    return omega < split if record["resonance"] == "mesh" else omega >= split


def longest_run(mask, step):
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return max(edges[1::2] - edges[::2], default=0) * step


def run_around(largest, part, top, level):
    groups = np.split(part, 1 + np.flatnonzero(np.diff((largest[part] >= level * largest[top]).astype(int))))
    return next(group for group in groups if top in group)


def stands_out(largest, part, top):
    run = run_around(largest, part, top, 0.5**0.5)
    return run[0] > part[0] and run[-1] < part[-1] and np.max(largest[run]) == largest[top]


def test_bands_and_wording_are_the_articles(plane):
    article, lines, data, _ = plane
    assert [line["resonance"] for line in lines] == ["mesh", "shaft"] * len(article.bands)
    assert len(article.columns) == 3 and all(len(band.wording) == 3 for band in article.bands)
    for line in lines:
        low, high = published().mesh_modes()
        assert float(line["natural_frequency"]) == pytest.approx(low if line["resonance"] == "mesh" else high, rel=1e-9)
        assert line["configuration_hash"] == data.attrs["configuration_hash"] and line["gap"] == ""
        assert int(line["rows"]) == len(in_band(line, data))
    values = data[article.parameter].values
    if article.number == 1:
        assert float(lines[0]["first_value"]) == pytest.approx(values[np.argmin(np.abs(values - 0.1))])
        assert float(lines[4]["first_value"]) == pytest.approx(values[values > 0.98][0])
        assert float(lines[5]["last_value"]) == pytest.approx(1.5)
        assert lines[2]["article_stability"] == "Moderate"


def test_jump_cells(plane):
    _, lines, data, branches = plane
    fine = np.arange(0.05, 2.0, 2e-5)
    for line in lines:
        folds, widths, with_jump = [], [], 0
        for row in in_band(line, data):
            points = branches.isel({line["parameter"]: row})
            omega, fold = points.omega.values, points.event.values == Event.FOLD
            here = omega[fold & half(line, omega)]
            folds.extend(here)
            with_jump += here.size > 0
            # Branches as polylines: the number of their crossings with a frequency is the number of solutions there.
            step = np.diff(omega[: int(points.n_points)])
            same = np.diff(points.branch.values[: int(points.n_points)]) == 0
            crossings = np.zeros(fine.size + 1)
            for place, change in zip(omega[: step.size][same], step[same], strict=True):
                first, last = np.searchsorted(fine, sorted((place, place + change)))
                crossings[first] += 1
                crossings[last] -= 1
            widths.append(longest_run((np.cumsum(crossings)[:-1] > 1) & half(line, fine), 2e-5))
        assert int(line["jump_rows"]) == with_jump
        assert float(line["widest"]) == pytest.approx(max(widths), abs=5e-5)
        assert float(line["widest_relative"]) == pytest.approx(max(widths) / float(line["natural_frequency"]), abs=1e-4)
        expected = (min(folds), max(folds)) if folds else (np.nan, np.nan)
        assert [float(line["jump_low"]), float(line["jump_high"])] == pytest.approx(expected, abs=1e-9, nan_ok=True)


def test_cells_of_the_region(plane):
    _, lines, data, _ = plane
    omega = data.omega.values
    for line in lines:
        counts, labels, unstable, total = np.zeros(6), {}, 0, 0
        for row in in_band(line, data):
            here = data.isel({line["parameter"]: row})
            largest = here.amplitude.where(here.stable == 1).max("solution").values
            part = np.flatnonzero(half(line, omega))
            tops = [top for top in part[find_peaks(largest[part])[0]] if stands_out(largest, part, top)]
            several = part[here.n_solutions.values[part] > 1]
            around = run_around(largest, part, max(tops, key=lambda top: largest[top]), 0.5) if tops else []
            if len(region := [*around, *several]) == 0:
                continue
            region = slice(min(region), max(region) + 1)
            cells = here.isel(omega=region)
            total += cells.sizes["omega"]
            unstable += int((cells.stable == 0).any("solution").sum())
            for state in range(6):
                counts[state] += int(((cells.impact == state) & (cells.stable == 1)).any("solution").sum())
            for code in cells.domain.values:
                labels[domain_label(int(code))] = labels.get(domain_label(int(code)), 0) + 1
        # On this coarse grid the peak's column may be a few per mille lower than the peak, a cell more or less.
        assert int(line["cells"]) == pytest.approx(total, abs=int(line["rows"]))
        names = [name for name in line if name.startswith("share_")][:6]
        slack = 1.1 * int(line["rows"]) / total
        assert [float(line[name]) for name in names] == pytest.approx(list(counts / total), abs=slack)
        assert float(line["share_unstable"]) == pytest.approx(unstable / total, abs=slack)
        found = dict(zip(line["labels"].split(), map(float, line["label_shares"].split()), strict=True))
        assert found == pytest.approx({label: count / total for label, count in labels.items()}, abs=slack)
        assert sum(found.values()) == pytest.approx(1.0, abs=1e-5)


def test_peaks_against_a_grid_forty_times_finer(plane):
    article, lines, _, _ = plane
    fine = np.linspace(0.05, 2.0, 4801)
    for line in lines:
        for end in ("first", "last"):
            if int(line["peak_rows"]) < int(line["rows"]):
                continue
            row = sweep_row(published(**{article.parameter: float(line[f"{end}_value"])}), "omega", fine)
            largest = np.max(np.where((row.stable == 1) & half(line, fine)[:, None], row.amplitude, 0.0), axis=1)
            assert float(line[f"peak_amplitude_{end}"]) == pytest.approx(np.max(largest), rel=1e-4)
            assert float(line[f"peak_omega_{end}"]) == pytest.approx(fine[np.argmax(largest)], abs=6e-4)
            shift = float(line[f"peak_omega_{end}"]) / float(line["natural_frequency"]) - 1.0
            assert float(line[f"shift_percent_{end}"]) == pytest.approx(100.0 * shift, abs=1e-6)


def test_where_things_appear_and_end(plane):
    article, lines, data, _ = plane
    values = data[article.parameter].values
    stable = data.stable == 1
    for line in lines:
        part = {"omega": np.flatnonzero(half(line, data.omega.values))}
        lost = (stable & (data.impact != 0)).isel(part).any(("omega", "solution")).values
        double = (stable & (data.impact == 2)).isel(part).any(("omega", "solution")).values
        for what, flag in (("contact_loss", lost), ("double_sided", double)):
            for kind, change in (("appears", 1), ("ends", -1)):
                places = np.flatnonzero(np.diff(flag.astype(int)) == change)
                low = float(line[f"{what}_{kind}_low"])
                assert np.isnan(low) if places.size == 0 else np.isclose(values[places], low, atol=1e-9).any()
    if article.number != 1:
        assert float(lines[1]["contact_loss_ends_high"]) > float(lines[1]["contact_loss_ends_low"])


@pytest.mark.parametrize(
    ("plane", "low", "high", "rows", "expected"),
    [
        ("omega_alpha", 0.26, 0.40, 15, {"jump_ends": ("shaft", 0.278), "contact_loss_ends": ("shaft", 0.388)}),
        ("omega_fpm", 0.565, 0.755, 20, {"jump_ends": ("shaft", 0.5855), "contact_loss_ends": ("shaft", 0.714)}),
        ("omega_b", 0.17, 0.19, 5, {"double_sided_ends": ("shaft", 0.18)}),
        ("omega_b", 1.0, 1.02, 5, {"double_sided_ends": ("mesh", 1.011)}),
    ],
)
def test_thresholds_of_the_published_gear(tmp_path, plane, low, high, rows, expected):
    # PHYSICS, section 7, within the distance of the rows; contact loss also within that of the columns.
    path = make(tmp_path, plane, f"plane.parameter.min={low}", f"plane.parameter.max={high}", columns=300, rows=rows)
    plan = store.read_plan(path)
    measured = list(measure_rows(path, plan))
    step = (high - low) / (rows - 1)
    for what, (name, value) in expected.items():
        number = ("mesh", "shaft").index(name)
        flag = {"jump": lambda row: bool(row.intervals), "contact_loss": lambda row: row.contact_lost,
                "double_sided": lambda row: row.double_sided}[what.removesuffix("_ends")]  # fmt: skip
        (edge,) = edges(plan.parameter.values, [flag(row[number]) for row in measured])
        assert not edge.appears and edge.value == pytest.approx(value, abs=step)


def test_published_folds_are_the_intervals(tmp_path, reference):
    path = make(tmp_path, "omega_b", "plane.parameter.min=0.99", "plane.parameter.max=1.01", columns=60, rows=3)
    folds = sorted(fold[0] for fold in reference["published"]["folds"])
    mesh, shaft = list(measure_rows(path, store.read_plan(path)))[1]
    assert np.ravel([mesh.intervals, shaft.intervals]) == pytest.approx(folds, abs=1e-6)


def branches_of(curves):
    counts = [len(curve.points) for curve in curves]
    joined = {name: np.concatenate([getattr(curve, name) for curve in curves])
              for name in ("amplitude", "arclength", "stable", "event")}  # fmt: skip
    omega = np.concatenate([curve.points[:, 3] for curve in curves])
    ends = np.array([curve.ends for curve in curves])
    return Branches(omega, branch=np.repeat(np.arange(len(counts)), counts), end_reason=ends, **joined)


def isola():
    """An isola (PHYSICS, section 7: consistent, c = cos 20 degrees, alpha = 0.44), and its main branch.

    At alpha = 0.5 it has joined the main branch; from there one of its solutions is followed back in alpha.
    """
    grid = np.linspace(0.05, 2.0, 400)
    gear = consistent(alpha=0.44, rotation_coupling=float(np.cos(np.radians(20.0))))
    row, joined = (sweep_row(model, "omega", grid) for model in (gear, gear.replace(alpha=0.5)))
    column = np.argmin(np.abs(grid - 0.55))
    top = joined.n_solutions[column] - 1
    start = [values[column, top] for values in (joined.mean, joined.cos, joined.sin)]
    back = first_order_problem(gear, "alpha", 0.44, 0.5, float(grid[column]))
    there = Continuation().trace(back, np.array([*start, 0.5]), 0.44, 0.5, -1).points[-1]
    problem = first_order_problem(gear, "omega", 0.05, 2.0)
    closed = Continuation().trace_both_ways(problem, np.append(there[:3], grid[column]), 0.05, 2.0)
    assert closed.closed
    main = next(curve for curve in row.curves if not curve.closed)
    return grid, row, branches_of([main, closed]), closed


def test_an_isola_gives_its_interval_and_its_peak():
    grid, row, branches, closed = isola()
    pieces = row_pieces(branches)
    intervals = [interval for interval in multivalued_intervals(pieces) if interval[1] < 0.7]
    assert np.ravel(intervals) == pytest.approx([0.511643, 0.580161], abs=1e-6)
    stable = closed.stable == 1
    height = np.where((grid > 0.5116) & (grid < 0.5801), np.max(closed.amplitude[stable]), 0.0)
    peak = resonance_peak(pieces, grid, np.maximum(height, row.amplitude[:, 0]), 0.0, 0.9)
    assert peak.amplitude == pytest.approx(np.max(closed.amplitude[stable]), rel=2e-3)
    assert 0.5116 < peak.omega < 0.5802


def test_formats(texts):
    assert sorted(texts) == sorted(NAMES)
    for name, text in texts.items():
        assert text.endswith("\n") and "\r" not in text
        if name.endswith("md"):
            blocks = re.findall(r"(?:^\|.*\|\n)+", text, flags=re.M)
            assert len(blocks) == 3
            for block in blocks:
                assert len({len(re.findall(r"(?<!\\)\|", line)) for line in block.splitlines()}) == 1
            assert "configuration_hash" in text and "kappa = 0.5" in text and not re.search(r"\bnan\b", text)
        elif name.endswith("tex"):
            assert text.isascii() and text.count("{") == text.count("}")
            assert len(re.findall(r"\\begin", text)) == len(re.findall(r"\\end\b", text)) == 6
            bare = re.sub(r"\\[%_#&]|\$[^$\n]*\$|\\[a-z]+", "", "\n".join(text.splitlines()[1:]))
            assert not set("_#%$^~") & set(bare.replace("~", "")), "everything special is escaped"
            for body in re.findall(r"\\hline\n(.*?)\\end{tabular}", text, flags=re.S):
                cells = {len(re.findall(r"(?<!\\)&", line)) for line in body.splitlines() if "tabularnewline" in line}
                assert len(cells) == 1
        else:
            for line in records(text):
                words = "table|store|configuration|parameter|band|resonance|gap|label|class|article"
                numbers = [key for key in line if not re.match(words, key)]
                assert len(numbers) == 48
                assert all(np.isfinite(float(line[key])) or line[key] == "nan" for key in numbers)


def test_labels_are_the_regions(stores, texts, plane):
    """Independent of the sheet: every label of the raster, and thresholds between the rows where the raster changes."""
    article, data = plane[0], plane[2]
    sheet = texts[f"table{article.number}.md"].split("## Labels")[1].split("## Notes")[0]
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in sheet.strip().splitlines()[2:]]
    shares = {row[0]: float(row[1].rstrip(" %")) / 100.0 for row in cells}
    assert sum(shares.values()) == pytest.approx(1.0, abs=1e-5)
    labels = dict(zip(data.domain.attrs["flag_values"], data.domain.attrs["labels"], strict=True))
    assert {labels[int(code)] for code in np.unique(data.domain)} <= set(shares)
    axis = data[article.parameter].values
    for row in cells:
        present = axis[np.any(data.domain.values == next(k for k, v in labels.items() if v == row[0]), axis=1)]
        bounds = [tuple(map(float, part.split("–"))) for text in row[2:] if text != "–" for part in text.split("; ")]
        for value in present:
            assert any(low - 1e-6 <= value <= high + 1e-6 for low, high in bounds), row


def test_latex_escapes():
    assert escape(r"a_b & 5% #1 {x} ~ ^ \ $") == (
        r"a\_b \& 5\% \#1 \{x\} \textasciitilde{} \textasciicircum{} \textbackslash{} \$"
    )
    assert escape("α = −1–2 ± 3 %") == r"$\alpha$ = $-$1--2 $\pm$ 3~\%"


def test_the_same_store_gives_the_same_bytes(stores, texts, tmp_path):
    assert written(stores, tmp_path) == texts


def test_a_band_that_the_plane_does_not_cover_says_so(tmp_path):
    path = make(tmp_path, "omega_b", "plane.parameter.min=0.02", "plane.parameter.max=0.15", rows=3)
    table = build_table(PLANES["omega_b"], path)
    assert [line.gap for line in table.lines] == ["", ""] + ["not covered by this plane: b = 0.02–0.15"] * 4
    from pipeline.tables.latex import latex
    from pipeline.tables.markdown import markdown
    from pipeline.tables.tidy import tidy

    lines = records(tidy(table))
    assert lines[2]["gap"] == "not covered by this plane: b = 0.02-0.15" and lines[2]["widest"] == "nan"
    assert "not covered by this plane: b = 0.02–0.15" in markdown(table) and latex(table).isascii()


def test_a_plane_too_coarse_or_too_short_says_so(tmp_path):
    coarse = make(tmp_path, "omega_fpm", "plane.parameter.min=0.3", "plane.parameter.max=1.2", rows=2)
    gaps = {line.gap for line in build_table(PLANES["omega_fpm"], coarse).lines}
    assert gaps == {"no row of this plane lies in the band: f_pm = 0.3–1.2 in 2 rows"}
    short = make(tmp_path, "omega_alpha", "plane.sweep.max=0.9", rows=3)
    gaps = [line.gap for line in build_table(PLANES["omega_alpha"], short).lines]
    assert gaps == ["", "not covered by this plane: Ω = 0.05–0.9"] * 2


def test_failed_rows_are_left_out_and_counted(tmp_path):
    path = make(tmp_path, "omega_fpm", "plane.parameter.min=0.5", "plane.parameter.max=1.0", rows=7)
    rows = band_rows(PLANES["omega_fpm"].bands[1], store.read_plan(path).parameter)
    zarr.open_group(path, mode="r+")["status"][rows[:2]] = store.FAILED
    table = build_table(PLANES["omega_fpm"], path)
    mesh = table.lines[2].measured
    assert table.failed == 2 and mesh.failed == 2 and len(mesh.rows) == len(rows) - 2
    assert mesh.values[0] == pytest.approx(store.read_plan(path).parameter.values[rows[2]])
    zarr.open_group(path, mode="r+")["status"][rows] = store.FAILED
    table = build_table(PLANES["omega_fpm"], path)
    assert table.lines[2].gap == f"all {len(rows)} rows of this band failed" and table.lines[0].gap == ""


def test_a_gear_without_jumps(tmp_path):
    path = make(tmp_path, "omega_b", "gear=consistent", "plane.parameter.min=0.9", rows=4)
    band = build_table(PLANES["omega_b"], path).lines[5]
    assert band.measured.jump_rows == 0 and band.measured.jump_edges == () and np.isnan(band.measured.envelope).all()
    single = percent(band.measured.share(band.measured.states[1]))
    assert band.classes == ("none; near linear", f"single-sided ({single})", "stable, settled")
    low, high = (resonance.natural for resonance in resonances(store.read_plan(path)))
    assert (low, high) == pytest.approx(consistent().mesh_modes())


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
