"""Verification of a small plane: fair samples, credibility by other means, what is stored, written and drawn."""

import csv

import numpy as np
import pytest
import xarray as xr

from pipeline.analysis import verification
from pipeline.analysis.verification import Credibility, Verdict
from pipeline.analysis.verification.credibility import Samples, credibility
from pipeline.analysis.verification.sampling import allot, choose_cells
from pipeline.analysis.verification.tasks import check_rows
from pipeline.analysis.verification.verdicts import settling_of
from pipeline.plan.numerics import point_of
from pipeline.plane.stored import StoredPlane, read_stored
from solver import ImpactState, domain_code, domain_label, domain_parts, gear_system
from solver.timedomain import AttractorKind, orbit_state, settle, wilson_interval
from tests.pipeline.analysis.verification.verified import RUN, settings, silent
from tests.pipeline.planes import small_plan, traced_store


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A small plane around the lower resonance, verified."""
    plan = small_plan("plane.sweep.min=0.4", "plane.sweep.max=0.9", columns=26, rows=5)
    path = traced_store(tmp_path_factory.mktemp("verification") / "plane.zarr", plan)
    return plan, path, verification.verify(path, plan, settings(), RUN, silent)


@pytest.fixture
def group(made):
    return xr.open_zarr(made[1], group="verification").load()


# Sampling


@pytest.mark.parametrize("sizes", [[900, 90, 10, 1], [5, 5, 5], [1], [10**6, 1, 1, 1, 1]])
@pytest.mark.parametrize("count", [0, 3, 5, 17, 40, 10**7])
def test_every_stratum_gets_a_share(sizes, count):
    sizes = np.array(sizes)
    shares = allot(sizes, count)
    assert shares.sum() == min(count, sizes.sum()) and np.all((shares >= 0) & (shares <= sizes))
    assert np.all(shares > 0) or count < sizes.size
    # Beyond the minimum in proportion.
    assert np.all(np.diff(shares[np.argsort(sizes, kind="stable")]) >= -1)


def test_samples_of_a_plane(made):
    plan, path, _ = made
    domain, usable = StoredPlane(path, plan).domain, StoredPlane(path, plan).usable
    cells = choose_cells(domain, usable, 30, 4, 0)
    again, other = choose_cells(domain, usable, 30, 4, 0), choose_cells(domain, usable, 30, 4, 1)
    for name in ("row", "column", "stratified", "beside"):
        np.testing.assert_array_equal(getattr(cells, name), getattr(again, name))
    assert not np.array_equal(cells.column, other.column)
    assert cells.stratified.sum() == 30 and 4 < cells.beside.sum() <= 8 and np.all(cells.stratified | cells.beside)
    drawn = domain[cells.row[cells.stratified], cells.column[cells.stratified]]
    assert set(np.unique(drawn)) == set(np.unique(domain)) and np.unique(domain).size > 3
    here = set(zip(cells.row.tolist(), cells.column.tolist(), strict=True))
    assert len(here) == cells.row.size
    for row, column in zip(cells.row[cells.beside].tolist(), cells.column[cells.beside].tolist(), strict=True):
        beside = [(row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)]
        assert any(place in here and domain[place] != domain[row, column] for place in beside)
    uniform = np.full((3, 4), int(domain_code(1, 1)))
    assert choose_cells(uniform, uniform > 0, 100, 10, 0).row.size == 12
    assert choose_cells(uniform, uniform > 1000, 100, 10, 0).row.size == 0


# Verdicts


def test_samples_are_what_direct_integration_gives(made, group):
    plan, path, summary = made
    plane = xr.open_zarr(path).load()
    assert group.sizes["sample"] == sum(summary.verdicts.values())
    assert len(np.unique(group.verdict)) >= 3
    size = 0
    for i in range(0, group.sizes["sample"], 7):
        row, column, solution = (int(group[name][i]) for name in ("row", "column", "solution"))
        assert plane.stable[row, column, solution] == 1
        assert group.sample_omega[i] == plane.omega[column] and group.sample_f_e[i] == plane.f_e[row]
        model, omega = point_of(plan, float(plane.f_e[row]), float(plane.omega[column]))
        wave = float(plane.amplitude[row, column, solution]) * np.exp(1j * float(plane.phase[row, column, solution]))
        system = gear_system(model)
        state = orbit_state(system, omega, [float(plane["mean"][row, column, solution]), wave.real, -wave.imag])
        (seen,) = settle(system, omega, state[None], settling=settling_of(1500))
        assert int(group.kind[i]) == seen.kind and int(group.impact[i]) == seen.impact
        same = abs(seen.mean - group.start_mean[i]) < 0.05 * system.motion_size
        same = same and abs(seen.amplitude - group.start_amplitude[i]) < 0.05 * system.motion_size
        expected = Verdict.NOT_PERIOD_1
        if seen.kind is AttractorKind.PERIOD_1:
            expected = Verdict.OTHER_MOTION if not same else Verdict.WRONG_IMPACT
            expected = Verdict.CONFIRMED if same and seen.impact == group.start_impact[i] else expected
        assert seen.kind is AttractorKind.UNSETTLED or int(group.verdict[i]) == expected
        size += 1
    assert size > 5


# Credibility


def by_hand(domain, low, high, unstable, samples, delta):
    """The rules of the module, cell by cell."""
    rows, columns = domain.shape
    result = np.zeros(domain.shape, int)
    for i in range(rows):
        for j in range(columns):
            near = {
                int(high[k, l])
                for k in range(rows)
                for l in range(columns)
                if abs(k - i) <= delta * (rows - 1) + 1e-9 and abs(l - j) <= delta * (columns - 1) + 1e-9
            }
            own, known = int(domain[i, j]), low[i, j] == high[i, j] != 0
            if own == 0:
                continue
            same_n = domain_parts(own)[0] == domain_parts(high[i, j])[0]
            if known:
                wrong = Credibility.WRONG_IMPACT_STATE if same_n else Credibility.WRONG_COUNT
                result[i, j] = 1 if own == high[i, j] else Credibility.SHIFTED if own in near else wrong
            here = (samples.row == i) & (samples.column == j)
            verdicts = samples.verdict[here].tolist()
            if unstable[i, j] == 1 or {Verdict.NOT_PERIOD_1, Verdict.UNBOUNDED} & set(verdicts):
                result[i, j] = Credibility.NOT_PERIOD_1_MOTION
            elif verdicts and not {Verdict.UNSETTLED, Verdict.FAILED} & set(verdicts) and (not known or same_n):
                states = sum({1 << int(state) for state in samples.impact[here]})
                if Verdict.OTHER_MOTION in verdicts:
                    result[i, j] = result[i, j] if known else Credibility.WRONG_COUNT
                elif states == domain_parts(own)[1] or Verdict.WRONG_IMPACT not in verdicts:
                    result[i, j] = Credibility.CONFIRMED
                else:
                    seen = int(domain_code(domain_parts(own)[0], states))
                    result[i, j] = Credibility.SHIFTED if seen in near else Credibility.WRONG_IMPACT_STATE
    return result


def test_credibility_of_a_plane(made, group):
    plan, path, summary = made
    domain = xr.open_zarr(path)["domain"].values
    samples = Samples(*(group[name].values for name in ("row", "column", "verdict", "impact")))
    layers = [group[name].values for name in ("domain_low", "domain_high", "unstable")]
    expected = by_hand(domain, *layers, samples, settings().delta)
    np.testing.assert_array_equal(group.credibility, expected)
    for kind, share in summary.shares.items():
        assert share == pytest.approx(np.mean(expected == kind))
    assert {int(Credibility.CONFIRMED), int(Credibility.NOT_PERIOD_1_MOTION)} <= set(np.unique(expected))
    # At Omega = 0.6 and more the motions after contact loss double their period or turn chaotic.
    assert np.all(group.credibility.sel(f_e=0.5, omega=[0.62, 0.66]) == Credibility.NOT_PERIOD_1_MOTION)


def test_credibility_of_random_labels():
    random = np.random.default_rng(4)
    kinds = set()
    codes = np.array([0, *(int(domain_code(n, mask)) for n, mask in ((1, 1), (1, 2), (2, 3), (2, 5), (2, 2)))])
    shape = (9, 21)
    for delta in (0.0, 0.1, 0.3):
        domain = codes[random.choice(6, shape, p=[0.05, 0.5, 0.2, 0.15, 0.05, 0.05])]
        high = np.where(random.random(shape) < 0.6, domain, codes[random.choice(6, shape)])
        low = np.where(random.random(shape) < 0.8, high, codes[random.choice(6, shape)])
        unstable = random.choice([-1, 0, 1], shape, p=[0.1, 0.8, 0.1])
        cells = np.argwhere(random.random(shape) < 0.5)
        cells = np.repeat(cells[domain[tuple(cells.T)] != 0], 2, axis=0)
        verdict = random.choice(len(Verdict), len(cells), p=[0.4, 0.1, 0.3, 0.05, 0.05, 0.05, 0.05])
        samples = Samples(*cells.T, verdict, random.choice(3, len(cells)))
        found = credibility(domain, low, high, unstable, samples, delta)
        np.testing.assert_array_equal(found, by_hand(domain, low, high, unstable, samples, delta))
        kinds |= set(found.ravel().tolist())
    assert kinds == set(Credibility)


def test_rows_at_higher_orders(made, group):
    """Labels at order 2H from first principles of the store: a row swept by hand, another block, and its orbits."""
    from solver import sweep_row
    from solver.harmonic.galerkin import Galerkin
    from solver.rows.seeds import LiftedSeeds
    from tests.conftest import published

    plan, path, _ = made
    model, grid = published(f_e=float(group.f_e[3])), group.omega.values
    row = sweep_row(model, "omega", grid, balance=Galerkin(10), seeds=LiftedSeeds())
    np.testing.assert_array_equal(group.domain_high[3], row.domain)
    labels = group.domain_high.attrs
    assert labels["labels"][labels["flag_values"].index(int(row.domain[0]))] == domain_label(int(row.domain[0]))
    (block,) = [block for block in plan.blocks if block.start == 3]
    alone = check_rows(str(path), plan, (5, 10), 25, block)
    np.testing.assert_array_equal(alone.high[0], group.domain_high[3])
    np.testing.assert_array_equal(alone.unstable[0], group.unstable[3])
    assert set(np.unique(group.unstable)) == {0, 1}


def test_impact_states_fit_the_mask():
    assert domain_parts(domain_code(3, 1 << ImpactState.MIRRORED_PERMANENT)) == (3, 32)


# The store


def test_schema(made, group):
    plan, path, _ = made
    assert group.credibility.dims == ("f_e", "omega") and set(group.coords) == {
        "f_e",
        "omega",
        "sample_f_e",
        "sample_omega",
    }
    for name in group.variables:
        assert group[name].attrs["long_name"], name
    for name in ("verdict", "kind", "impact", "start_impact", "credibility", "unstable", "domain_low", "domain_high"):
        flags = group[name].attrs
        assert len(flags["flag_values"]) == len(flags["flag_meanings"].split())
        assert set(np.unique(group[name])) <= {*flags["flag_values"], -1}
    assert group.credibility.attrs["flag_meanings"].split() == [
        "unchecked",
        "confirmed",
        "shifted",
        "wrong_count",
        "wrong_impact_state",
        "not_period_1_motion",
    ]
    assert group.attrs["seed"] == 0 and group.attrs["made_from"] and group.attrs["configuration_hash"] == plan.digest
    assert xr.open_datatree(path, engine="zarr")["verification/credibility"].dims == ("f_e", "omega")
    np.testing.assert_array_equal(group.mean_error, group["mean"] - group.start_mean)


def test_a_second_time_there_is_nothing_to_do_unless_settings_change(made):
    plan, path, first = made
    stamp = (path / "verification/credibility/c/0/0").stat().st_mtime_ns

    def never(function, tasks):
        raise AssertionError("nothing is to be done")

    again = verification.verify(path, plan, settings(), never, silent)
    assert again.found_done and not first.found_done and again.verdicts == first.verdicts
    assert (path / "verification/credibility/c/0/0").stat().st_mtime_ns == stamp
    with pytest.raises(AssertionError):
        verification.verify(path, plan, settings(seed=1), never, silent)


# Sheets


def test_shares_per_region(made, group, tmp_path):
    plan, path, _ = made
    domain = StoredPlane(path, plan).domain
    stored = verification.read_verification(path)
    paths = verification.write_sheets(domain, stored, plan, settings(), tmp_path, "plane")
    again = verification.write_sheets(domain, stored, plan, settings(), tmp_path / "again", "plane")
    assert [path.read_bytes() for path in paths] == [path.read_bytes() for path in again]
    with paths[0].open(newline="") as file:
        lines = {line["label"]: line for line in csv.DictReader(file)}
    assert int(lines["all"]["cells"]) == domain.size and list(lines)[-1] == "all"
    cells = {}
    names = ("row", "column", "verdict", "stratified")
    for row, column, verdict, fair in zip(*(group[name].values for name in names), strict=True):
        if fair:
            cells.setdefault((int(row), int(column)), []).append(int(verdict))
    total = 0.0
    for code in np.unique(domain):
        line, own = lines[domain_label(int(code))], [v for place, v in cells.items() if domain[place] == code]
        own = [v for v in own if not {Verdict.UNSETTLED, Verdict.FAILED} & set(v)]
        right = sum(set(v) == {Verdict.CONFIRMED} for v in own)
        assert int(line["cells"]) == np.sum(domain == code) and int(line["samples"]) == len(own) > 0
        assert float(line["confirmed_share"]) == right / len(own)
        assert (float(line["confirmed_low"]), float(line["confirmed_high"])) == wilson_interval(right, len(own))
        total += right / len(own) * np.mean(domain == code)
        for kind in Credibility:
            share = np.mean(group.credibility.values[domain == code] == kind)
            assert float(line[kind.name.lower()]) == pytest.approx(share)
    assert float(lines["all"]["confirmed_share"]) == pytest.approx(total)
    assert float(lines["all"]["confirmed_low"]) < total < float(lines["all"]["confirmed_high"])
    text = paths[1].read_text()
    assert "| 1/0 |" in text and "| all |" in text and "Wilson 95 %" in text


# The figure


def test_figure(made, tmp_path):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from pipeline.figures.drawing import own_style
    from pipeline.figures.output import write_figure
    from pipeline.figures.verification import draw_verification

    plan, path, _ = made
    plane, found = read_stored(path), verification.read_verification(path)
    made_twice = []
    with own_style():
        for folder in ("one", "two"):
            (tmp_path / folder).mkdir()
            figure = draw_verification(plane, found)
            paths = write_figure(figure, plane, tmp_path / folder, "verification", ["png", "pdf"], 60)
            made_twice.append([path.read_bytes() for path in paths])
        renderer = FigureCanvasAgg(figure).get_renderer()
        # No text of the legend runs into another of its line, or out of the figure.
        legend = min(figure.axes, key=lambda axes: axes.get_zorder())
        texts = [text for text in legend.texts if text.get_text()]
        boxes = [text.get_window_extent(renderer) for text in texts]
    assert made_twice[0] == made_twice[1]
    said = {text.get_text() for text in texts}
    assert {"confirmed", "not period-1", "other motion", "fold: $n$ changes", "grazing: only $I$ changes"} <= said
    for i, box in enumerate(boxes):
        assert box.x1 <= figure.bbox.x1
        line = [j for j in range(len(texts)) if j != i and texts[j].get_position()[1] == texts[i].get_position()[1]]
        assert not any(box.overlaps(boxes[j]) for j in line)
