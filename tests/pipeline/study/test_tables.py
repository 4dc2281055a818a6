"""Tables 1 to 3: cells against the raw store and enumeration, formats against golden files, and refusals."""

import csv
import io
import re
import shutil
import subprocess

import numpy as np
import pytest
import xarray as xr

from pipeline.errors import StoreError
from pipeline.plane.peaks import resonance_peak, solved
from pipeline.plane.resonances import common_resonances, resonances
from pipeline.plane.segments import segments_of_row
from pipeline.plane.stored import StoredPlane
from pipeline.study.tables.latex import escape, latex
from pipeline.study.tables.markdown import markdown
from pipeline.study.tables.rows import row_peaks
from pipeline.study.tables.table import build_table
from pipeline.study.tables.tidy import cells, tidy
from solver import Continuation, Event, domain_label, first_order_problem, sweep_row
from solver.stability import Instability
from tests.conftest import consistent, published
from tests.pipeline.planes import small_plan, small_store
from tests.pipeline.study.golden_files import NAMES, PLANES, difference, golden, make_stores, written
from tests.pipeline.study.latex_parser import check_latex


def make(folder, plane, *overrides, columns=121, rows=9):
    return small_store(folder / f"{plane}.zarr", small_plan(f"plane={plane}", *overrides, columns=columns, rows=rows))


def records(text):
    return list(csv.DictReader(io.StringIO(text)))


@pytest.fixture(scope="module")
def stores(tmp_path_factory):
    return make_stores(tmp_path_factory.mktemp("stores"))


@pytest.fixture(scope="module")
def texts(stores, tmp_path_factory):
    return written(stores, tmp_path_factory.mktemp("tables") / "new" / "folder")


@pytest.fixture(scope="module", params=sorted(PLANES))
def plane(request, stores, texts):
    """The records of a table with the arrays of the store behind it."""
    article, path = PLANES[request.param], stores[request.param][0]
    data, branches = xr.open_zarr(path).load(), xr.open_zarr(path, group="branches").load()
    return article, records(texts[f"table{article.number}-measured.csv"]), data, branches


def in_band(record, data):
    values = data[record["parameter"]].values
    beyond = 1e-9 if record["band"].startswith(">") else -1e-9
    return np.flatnonzero((values >= float(record["low"]) + beyond) & (values <= float(record["high"]) + 1e-9))


def half(record, omega):
    split = np.sqrt(np.prod(published().mesh_modes()))
    return omega < split if record["resonance"] == "mesh" else omega >= split


def test_bands_and_wording_are_the_articles(plane):
    article, lines, data, _ = plane
    assert [line["resonance"] for line in lines] == ["mesh", "shaft"] * len(article.bands)
    assert len(article.columns) == 3 and all(len(band.entries) == 3 for band in article.bands)
    for line in lines:
        low, high = published().mesh_modes()
        assert float(line["natural_frequency"]) == pytest.approx(low if line["resonance"] == "mesh" else high, rel=1e-9)
        assert line["configuration_hash"] == data.attrs["configuration_hash"] and line["gap"] == ""
    if article.number == 1:
        bands = [(float(line["low"]), float(line["high"])) for line in lines[::2]]
        assert bands == [(0.1, 0.1), (0.2, 0.6), (0.98, 1.5)]


def test_jumps_are_the_folds_of_the_raw_branches(plane):
    _, lines, data, branches = plane
    ends = 0
    for line in lines:
        folds = {}
        for row in in_band(line, data):
            points = branches.isel({line["parameter"]: row})
            here = points.omega.values[points.event.values == Event.FOLD]
            folds[float(data[line["parameter"]][row])] = np.sort(here[half(line, here)])
        for end in ("first", "last"):
            value = float(line["low" if end == "first" else "high"])
            at = next((found for row, found in folds.items() if abs(row - value) < 1e-9), None)
            if at is not None:
                expected = (at[0], at[-1]) if at.size else (np.nan, np.nan)
                found = [float(line[f"jump_{end}_low"]), float(line[f"jump_{end}_high"])]
                assert found == pytest.approx(expected, abs=1e-7, nan_ok=True)
                ends += 1
            if at is not None and at.size == 2:
                width = float(line[f"{end}_width_relative"]) * float(line["natural_frequency"])
                assert width == pytest.approx(at[1] - at[0], abs=1e-7)
        all_folds = np.concatenate([np.empty(0), *folds.values()])
        if all_folds.size:
            assert float(line["jump_low"]) <= all_folds.min() + 1e-7
            assert float(line["jump_high"]) >= all_folds.max() - 1e-7
            assert float(line["jump_height"]) > 0.0
    assert ends >= 4


def test_shares_against_the_raw_cells(plane):
    """Every cell of the raster counted, rows by the trapezoidal rule: as close as 120 columns can be."""
    article, lines, data, _ = plane
    columns, checked = data.omega.values, 0
    for line in lines:
        rows = in_band(line, data)
        single = line["low"] == line["high"]
        if not single and rows.size < 5:
            continue
        checked += 1
        part = np.flatnonzero(half(line, columns))
        weights = np.ones(rows.size)
        if rows.size > 1:
            weights[[0, -1]] = 0.5
        codes = data.domain.values[np.ix_(rows, part)]
        found = dict(zip(line["labels"].split(), map(float, line["label_shares"].split()), strict=True))
        raster = {
            domain_label(int(code)): float(np.sum(weights[:, None] * (codes == code)) / np.sum(weights) / part.size)
            for code in np.unique(codes)
        }
        assert set(raster) <= set(found) or rows.size > 1
        for label in set(raster) | set(found):
            assert found.get(label, 0.0) == pytest.approx(raster.get(label, 0.0), abs=0.025), (label, line["band"])
        assert sum(found.values()) == pytest.approx(1.0, abs=1e-7)
        states = dict.fromkeys("012", 0.0)
        for label, share in found.items():
            for state in label.split("/")[1].split("-"):
                states[state] += share
        names = ("share_permanent", "share_single_sided", "share_double_sided")
        assert [float(line[name]) for name in names] == pytest.approx(list(states.values()), abs=1e-7)
        several = sum(share for label, share in found.items() if int(label.split("/")[0]) > 1)
        assert float(line["share_several_stable"]) == pytest.approx(several, abs=1e-7)
    assert checked >= 2


def test_peaks_against_a_finer_grid(plane):
    article, lines, data, _ = plane
    values = data[article.parameter].values
    fine = np.linspace(0.05, 2.0, 2401)
    for line in lines:
        rows = in_band(line, data)
        if int(line["peak_rows"]) < int(line["rows"]):
            continue
        for end, number in (("first", rows[0]), ("last", rows[-1])):
            if line["low"] == line["high"] and end == "last":
                continue
            row = sweep_row(published(**{article.parameter: values[number]}), "omega", fine)
            largest = np.max(np.where((row.stable == 1) & half(line, fine)[:, None], row.amplitude, 0.0), axis=1)
            # No point of the grid is higher, and the highest one is nearly as high and next to it.
            amplitude, omega = float(line[f"peak_amplitude_{end}"]), float(line[f"peak_omega_{end}"])
            assert np.max(largest) <= amplitude + 1e-9
            assert np.max(largest) == pytest.approx(amplitude, rel=5e-4)
            assert omega == pytest.approx(fine[np.argmax(largest)], abs=1.2e-3)
            shift = omega / float(line["natural_frequency"]) - 1.0
            assert float(line[f"shift_percent_{end}"]) == pytest.approx(100.0 * shift, abs=1e-6)


def test_where_things_appear_and_end(plane):
    """Independent of the regions: what the rows of the raster show lies where it may, and reaches close to the ends."""
    article, lines, data, _ = plane
    values = data[article.parameter].values
    stable, checked, step = data.stable == 1, 0, values[1] - values[0]
    for line in lines:
        part = {"omega": np.flatnonzero(half(line, data.omega.values))}
        lost = (stable & (data.impact != 0)).isel(part).any(("omega", "solution")).values
        double = (stable & (data.impact == 2)).isel(part).any(("omega", "solution")).values
        for what, flag in (("contact_loss", lost), ("double_sided_impact", double)):
            appears, ends = (float(line[f"{what}_{kind}"]) for kind in ("appears", "ends"))
            if np.isfinite(appears) == np.isfinite(ends):
                # Always, never, or in more than one range.
                continue
            checked += 1
            shown = values[flag]
            # Columns may miss what is narrow for a few rows more.
            if np.isfinite(appears):
                assert appears <= shown.min() + 1e-9 and shown.min() - appears < 4 * step
            else:
                assert shown.max() <= ends + 1e-9 and ends - shown.max() < 4 * step
    assert checked > 0


def test_thresholds_of_the_published_gear(texts):
    """docs/physics.md, section 7, to the digits printed there, from planes of a dozen rows."""
    for table, name, what, value, digits in (
        (2, "shaft", "jump_ends", 0.278, 5e-4),
        (2, "shaft", "contact_loss_ends", 0.388, 5e-4),
        (3, "shaft", "jump_ends", 0.5855, 5e-5),
        (3, "shaft", "contact_loss_ends", 0.714, 5e-4),
        (1, "mesh", "double_sided_impact_ends", 1.011, 5e-4),
        (1, "shaft", "double_sided_impact_ends", 0.18, 5e-3),
    ):
        lines = [line for line in records(texts[f"table{table}-measured.csv"]) if line["resonance"] == name]
        assert {round(float(line[what]), 9) for line in lines} == {round(float(lines[0][what]), 9)}
        assert float(lines[0][what]) == pytest.approx(value, abs=digits)


@pytest.mark.costly
def test_columns_do_not_enter(tmp_path):
    """The same numbers from a raster four times as coarse."""
    fine, coarse = (
        records(tidy(build_table(PLANES["omega_fpm"], make(tmp_path / str(n), "omega_fpm", columns=n, rows=13))))
        for n in (200, 50)
    )
    for one, other in zip(fine, coarse, strict=True):
        # Dynamic stability is counted in cells.
        for name in one.keys() - {"configuration_hash", "share_without_stable_1T"}:
            a, b = one[name], other[name]
            try:
                assert float(a) == pytest.approx(float(b), abs=1e-6, nan_ok=True), name
            except ValueError:
                shares = [np.array(text.split(), dtype=float) for text in (a, b)] if name == "label_shares" else None
                assert np.allclose(*shares, atol=1e-6, rtol=0.0) if shares else a == b, name


def test_resonances_follow_the_modes_of_every_row(tmp_path):
    plan = small_plan("plane.parameter.name=kappa", "plane.parameter.min=0.3", "plane.parameter.max=0.8", rows=4)
    found = [resonances(plan, value) for value in plan.parameter.values]
    for value, (mesh, shaft) in zip(plan.parameter.values, found, strict=True):
        assert (mesh.natural, shaft.natural) == pytest.approx(published(kappa=value).mesh_modes(), rel=1e-12)
        assert mesh.low == 0.0 and shaft.high == np.inf
        assert mesh.high == shaft.low == pytest.approx(np.sqrt(mesh.natural * shaft.natural), rel=1e-12)
    assert len({mesh.natural for mesh, _ in found}) == 4 and common_resonances(plan) is None
    path = small_store(tmp_path / "kappa.zarr", plan)
    peaks = row_peaks(StoredPlane(path, plan), np.arange(4))
    assert [row[1].natural for row in peaks.values()] == [shaft.natural for _, shaft in found]
    with pytest.raises(StoreError, match="natural frequencies move with kappa"):
        build_table(PLANES["omega_b"], path)
    for name in PLANES:
        plan = small_plan(f"plane={name}", rows=3)
        assert common_resonances(plan) == resonances(plan, plan.parameter.high)


def test_an_isola_has_its_peak():
    """An isola (docs/physics.md, section 7: consistent, c = cos 20 degrees, alpha = 0.44), wherever it was started.

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
    curves = [main, closed]
    points = {
        name: np.concatenate([getattr(curve, name) for curve in curves]) for name in ("amplitude", "stable", "event")
    }
    unknowns = np.concatenate([curve.points for curve in curves])
    points |= {
        "position": unknowns[:, 3],
        "mean": unknowns[:, 0],
        "impact": np.zeros(len(unknowns), int),
        "branch": np.repeat([0, 1], [len(curve.points) for curve in curves]),
    }
    peak = resonance_peak(
        points, segments_of_row(points, *np.multiply.outer((-gear.b, gear.b), np.ones(len(unknowns)))), 0.0, 0.9
    )
    stable = closed.stable == 1
    assert peak.amplitude == pytest.approx(np.max(closed.amplitude[stable]), rel=2e-3)
    assert 0.5116 < peak.omega < 0.5802
    exact = solved(gear, peak)
    assert exact.amplitude >= np.max(closed.amplitude[stable]) - 1e-9 or exact.fold


# Formats -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_golden_files(texts, name):
    assert not (text := difference(golden(name), texts[name])), f"{name}: {text}"


def test_the_parser_sees_faults():
    rows = "\\toprule\na & b \\tabularnewline\n\\midrule\n\\bottomrule\n"
    good = "\\begin{tabular}{@{}p{1}p{2}@{}}\n" + rows + "\\end{tabular}"
    assert check_latex(good) == 1
    for fault in ("a & b", "\\midrule\n", "\\end{tabular}", "\\tabularnewline"):
        with pytest.raises(AssertionError):
            assert check_latex(good.replace(fault, "a" if fault == "a & b" else "")) == 1


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
            assert text.isascii() and check_latex(text) == 3 and r"needs \usepackage{booktabs}" in text.splitlines()[0]
            bare = re.sub(r"\\[%_#&]|\$[^$\n]*\$|\\[a-z]+", "", "\n".join(text.splitlines()[1:]))
            assert not set("_#%$^~") & set(bare.replace("~", "")), "everything special is escaped"
        elif "measured" in name:
            for line in records(text):
                words = "table|store|configuration|parameter|band|resonance|gap|label"
                numbers = [key for key in line if not re.match(words, key)]
                assert len(numbers) == 42
                assert all(np.isfinite(float(line[key])) or line[key] == "nan" for key in numbers)


def test_latex_compiles(texts, tmp_path):
    program = shutil.which("tectonic") or shutil.which("pdflatex")
    if program is None:
        # What can be said without a compiler.
        assert all(check_latex(texts[name]) == 3 for name in NAMES if name.endswith("tex"))
        return
    for name in NAMES:
        if name.endswith("tex"):
            (tmp_path / name).write_text(texts[name], encoding="ascii")
    inputs = "\n".join(rf"\input{{table{number}.tex}}\clearpage" for number in (1, 2, 3))
    document = (
        f"\\documentclass{{article}}\n\\usepackage{{booktabs}}\n\\begin{{document}}\n{inputs}\n\\end{{document}}\n"
    )
    (tmp_path / "all.tex").write_text(document, encoding="ascii")
    options = [] if program.endswith("tectonic") else ["-interaction=nonstopmode", "-halt-on-error"]
    result = subprocess.run([program, *options, "all.tex"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout[-2000:]


def test_labels_are_the_regions(stores, texts, plane):
    """Independent of the sheet: every label of the raster, and thresholds between the rows where the raster changes."""
    article, data = plane[0], plane[2]
    sheet = texts[f"table{article.number}.md"].split("| Label n/I ")[1].split("## Notes")[0]
    found = [[cell.strip() for cell in line.split("|")[1:-1]] for line in sheet.strip().splitlines()[2:]]
    shares = {row[0]: float(row[1].lstrip("<").rstrip(" %")) / 100.0 for row in found}
    assert sum(shares.values()) == pytest.approx(1.0, abs=1e-2)
    labels = dict(zip(data.domain.attrs["flag_values"], data.domain.attrs["labels"], strict=True))
    assert {labels[int(code)] for code in np.unique(data.domain)} <= set(shares)
    axis = data[article.parameter].values
    for row in found:
        present = axis[np.any(data.domain.values == next(k for k, v in labels.items() if v == row[0]), axis=1)]
        bounds = [tuple(map(float, part.split("–"))) for text in row[2:] if text != "–" for part in text.split("; ")]
        for value in present:
            assert any(low - 5e-4 <= value <= high + 5e-4 for low, high in bounds), row


def grid(article, text):
    """The rows of the study's grid in Markdown: lists of cells, each a list of lines."""
    rows = [line for line in text.split("## Appendix")[0].splitlines() if line.startswith("| ")][2:]
    return [[cell.strip().split("<br>") for cell in row.split("|")[1:-1]] for row in rows]


def test_the_grid_is_the_articles_in_all_formats(texts, plane):
    """Every cell: its words, ours, a verdict and a reason; the same in Markdown, CSV and LaTeX; tallied on top."""
    article = plane[0]
    markdown_, csv_, tex = (texts[f"table{article.number}{end}"] for end in (".md", ".csv", ".tex"))
    rows, lines = grid(article, markdown_), iter(records(csv_))
    assert [row[0] for row in rows] == [[band.text] for band in article.bands]
    verdicts = []
    for row, band in zip(rows, article.bands, strict=True):
        for cell, column, entry in zip(row[1:], article.columns, band.entries, strict=True):
            line = next(lines)
            assert (line["column"], line["article"], line[article.parameter]) == (
                column.heading,
                entry.wording,
                band.text,
            )
            assert cell[0] == f"“{entry.wording}”" and cell[1].startswith("ours")
            verdict, _, reason = cell[-1].removeprefix("**").partition("**: ")
            assert (verdict, reason) == (line["verdict"], line["reason"]) and reason
            assert f"\\newline \\textbf{{{verdict}}}: {escape(reason)}" in tex
            for name in ("mesh", "shaft"):
                assert line[f"ours_{name}"] in " ".join(cell[1:-1])
            verdicts.append(verdict)
    assert next(lines, None) is None
    (said,) = re.findall(r"Table \d, (\d+) cells: agrees (\d+), differs (\d+), cannot be compared (\d+)\.", markdown_)
    kinds = ("agrees", "differs", "cannot be compared")
    assert list(map(int, said)) == [len(verdicts), *(verdicts.count(kind) for kind in kinds)]
    assert len(verdicts) == {1: 9, 2: 6, 3: 6}[article.number]


def test_stable_is_said_of_dynamic_stability(texts, plane):
    """The share without a stable motion of one period, counted here in the raw cells."""
    article, lines, data, _ = plane
    # A contradictory motion is not known to be unstable.
    stable = (data.stable == 1) & data.instability.isin([Instability.NONE, Instability.CONTRADICTORY])
    for line in lines:
        rows, part = in_band(line, data), np.flatnonzero(half(line, data.omega.values))
        if line["low"] == line["high"]:
            rows = [np.argmin(np.abs(data[article.parameter].values - float(line["low"])))]
        none = ~stable.any("solution").values[np.ix_(rows, part)]
        assert float(line["share_without_stable_1T"]) == pytest.approx(none.mean(), abs=2.0 / part.size)
    if article.number == 1:
        last = [line for line in records(texts["table1.csv"]) if line["column"] == "Stability"][-1]
        assert (last["article"], last["verdict"]) == ("Stable", "differs") and "dynamic stability" in last["ours_shaft"]


def test_an_isola_is_named(texts):
    """docs/physics.md, section 7: jumps at the shaft resonance come back in an isola, which sweeps miss."""
    (line,) = (one for one in records(texts["table2.csv"]) if one["article"] == "Reduced in shaft frequency")
    assert "isola born at α = 0.689, which sweeps miss" in line["reason"] and line["verdict"] == "differs"


def test_latex_escapes():
    assert escape(r"a_b & 5% #1 {x} ~ ^ \ $") == (
        r"a\_b \& 5\% \#1 \{x\} \textasciitilde{} \textasciicircum{} \textbackslash{} \$"
    )
    assert escape("α = −1–2 ± 3 %") == r"$\alpha$ = $-$1--2 $\pm$ 3~\%"


def test_the_same_store_gives_the_same_bytes(stores, texts):
    table = build_table(PLANES["omega_fpm"], stores["omega_fpm"][0])
    for end, render in ((".csv", cells), ("-measured.csv", tidy), (".md", markdown), (".tex", latex)):
        assert render(table) == texts[f"table3{end}"]
