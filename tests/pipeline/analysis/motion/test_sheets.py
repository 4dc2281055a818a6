"""What is written of motions: every number of the figure, in both kinds of units."""

import csv
import io

import numpy as np
import pytest

from pipeline.analysis.motion.motions import MapMotion
from pipeline.analysis.motion.sheets import contents, lines, place_name
from pipeline.config.quantities import READ
from pipeline.plan.scales import scales_of
from solver.timedomain import AttractorKind as Kind
from tests.pipeline.analysis.motion.places import MITER, PUBLISHED, SPUR, found_at, plan_of

TORUS = (0.6, 0.2, *PUBLISHED)
GEAR = (0.9, 0.2, *MITER)
PLACES = [TORUS, GEAR, (1.8, 0.1, *SPUR)]


def read(place, ending):
    found, plan = found_at(*place), plan_of(*place[2:])
    text = contents(found, plan, "plane")[f"{place_name(found, plan)}{ending}"]
    return list(csv.DictReader(io.StringIO(text)))


def series(rows, motion, source, name):
    chosen = [row for row in rows if (row["motion"], row["source"], row["series"]) == (motion, source, name)]
    return np.array([[float(row["x"]), float(row["y"])] for row in chosen]).T


def drawn(found):
    for motion in found.attractors:
        yield motion.name, "integration", motion
        if motion.of_map:
            yield motion.name, "balance", motion.of_map
    for motion in found.others:
        yield f"map {motion.number}", "balance", motion


@pytest.mark.costly
@pytest.mark.parametrize("place", PLACES)
def test_curves_are_given_as_they_are_drawn(place):
    found, rows = found_at(*place), read(place, "-curves.csv")
    count = 0
    for name, source, motion in drawn(found):
        curves = motion.curves
        for key, x, y in (
            ("displacement", curves.periods, curves.displacement),
            ("speed", curves.periods, curves.speed),
            ("force", curves.periods, curves.force / found.static_force),
            ("poincare", *curves.points.T),
            ("spectrum", curves.orders, curves.amplitudes),
        ):
            given = series(rows, name, source, key)
            np.testing.assert_allclose(given, [x, y], rtol=1e-9, atol=1e-300)
            count += x.size
    assert count == len(rows) > 1000


def test_physical_values_are_the_others_times_what_1_is():
    found, scales = found_at(*GEAR), scales_of(plan_of(*MITER))
    second = 1.0 / (scales.gear.frequency_unit * found.omega / (2.0 * np.pi))
    stiffness, length = scales.gear.mesh_stiffness, scales.gear.length_unit
    sizes = {
        "displacement": (1e3 * second, "ms", length * 1e6, "µm"),
        "speed": (1e3 * second, "ms", length * scales.gear.frequency_unit, "m/s"),
        "force": (1e3 * second, "ms", stiffness * length * found.static_force, "N"),
        "poincare": (length * 1e6, "µm", length * scales.gear.frequency_unit, "m/s"),
        "spectrum": (1.0, "1", length * 1e6, "µm"),
    }
    rows = read(GEAR, "-curves.csv")
    assert {row["series"] for row in rows} == set(sizes)
    for row in rows[::7]:
        x, x_unit, y, y_unit = sizes[row["series"]]
        assert (row["physical_x_unit"], row["physical_y_unit"]) == (x_unit, y_unit)
        assert float(row["physical_x"]) == pytest.approx(x * float(row["x"]), rel=1e-8, abs=1e-12)
        assert float(row["physical_y"]) == pytest.approx(y * float(row["y"]), rel=1e-8, abs=1e-12)
    # 100 N m over a mean radius of 34.4 mm and cos 20 degrees: 3.1 kN.
    forces = [float(row["physical_y"]) for row in rows if row["series"] == "force"]
    assert np.mean(forces) == pytest.approx(100.0 / scales.gear.mean_radii[0] / np.cos(np.radians(20.0)), rel=0.02)
    (line,) = [row for row in read(GEAR, ".csv") if row["source"] == "integration"]
    assert float(line["support_force (N)"]) == pytest.approx(
        float(line["support_force"]) * stiffness * length, rel=1e-8
    )
    assert float(line["rms (µm)"]) == pytest.approx(float(line["rms"]) * length * 1e6, rel=1e-8)


@pytest.mark.parametrize("place", PLACES)
def test_every_motion_has_a_line_with_its_quantities(place):
    found, rows = found_at(*place), read(place, ".csv")
    for row, (name, source, motion) in zip(rows, drawn(found), strict=True):
        assert (row["motion"], row["source"], row["kind"]) == (name, source, motion.label)
        assert (float(row["omega"]), float(list(row.values())[1])) == place[:2]
        for one in READ:
            assert float(row[one.name]) == pytest.approx(getattr(motion.quantities, one.name), rel=1e-9)
        if isinstance(motion, MapMotion):
            assert (
                row["hits"] == ""
                and row["map_motion"] == str(motion.number)
                and row["leads_to"] == (motion.leads or "")
            )
        else:
            assert int(row["hits"]) == motion.hits and int(row["starts"]) == 20
            assert (row["multiplier"] == "") == (motion.kind > Kind.PERIOD_8)


@pytest.mark.parametrize("place", PLACES)
def test_the_page_and_the_console_name_every_motion(place):
    found, plan = found_at(*place), plan_of(*place[2:])
    page = contents(found, plan, "my plane")[f"{place_name(found, plan)}.md"]
    said = "\n".join(lines(found, plan))
    for text in (page, said):
        for name, _, motion in drawn(found):
            assert name in text and motion.label in text
        for motion in found.attractors:
            assert f"{motion.hits} of 20 random starts" in text
        assert "(1 - p)^20" in text and ";  " not in text
    assert "my plane" in page and all(one.title in page for one in READ)


def test_where_a_motion_of_the_map_leads_is_said():
    said = "\n".join(lines(found_at(*TORUS), plan_of(*PUBLISHED)))
    assert "motion 1 of the map" in said and "integration from it ends on A" in said and "not in the map" in said


def test_places_have_names_of_their_own():
    plan = plan_of(*PUBLISHED)
    assert place_name(found_at(*TORUS), plan) == "omega=0.6-f_e=0.2"
