"""Mesh cycles from files: what is fitted, every dialect of one cycle, what is asked back, and hostile files."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.config.csv_table import read_table
from pipeline.config.mesh_cycle import read_mesh_cycle
from pipeline.config.number_files import NumbersError
from pipeline.errors import ConfigurationError
from pipeline.plan.planning import warnings
from pipeline.plan.scales import gear_of
from solver import PitchCones
from tests.pipeline.planes import small_plan

HEADER = "angle (deg), stiffness (N/um), error (um)"


def cycle_file(folder, header=HEADER, lines=None):
    if lines is None:
        angles = np.arange(24) * 15.0
        lines = [
            f"{a}, {220 + 40 * np.cos(np.radians(a) + 0.5)}, {3 + 9 * np.cos(2 * np.radians(a) - 1.0)}" for a in angles
        ]
    path = folder / "cycle.csv"
    path.write_text("\n".join([header, *lines, ""]))
    return path


def with_cycle(path, *more):
    given = ("mesh_stiffness=null", "mesh_stiffness_harmonics=[]", "error_harmonics=[]", f"mesh_cycle={path}")
    return small_plan("gear=miter", *(f"gear.physical.{text}" for text in (*given, *more)))


def test_a_mesh_cycle_is_fitted(tmp_path):
    found = with_cycle(cycle_file(tmp_path))
    gear = gear_of(found)
    assert gear.mesh_stiffness == pytest.approx(220e6)
    np.testing.assert_allclose(gear.mesh_stiffness_harmonics[0], (40e6, 0.5), rtol=1e-10)
    np.testing.assert_allclose(gear.error_harmonics[1], (9e-6, -1.0), rtol=1e-10)
    unfelt, line = warnings(found)
    assert "stiffness harmonic" not in unfelt and "transmission error harmonic 2 drive" in unfelt
    assert line.startswith("mesh cycle of 24 points fitted with 3 harmonics: stiffness residual ")
    assert "error residual" in line
    coarse = warnings(with_cycle(cycle_file(tmp_path), "mesh_cycle_harmonics=1"))
    largest = max(abs(9 * np.cos(2 * np.arange(24) * np.pi / 12 - 1)))
    assert f"error residual {9 / math.sqrt(2):.3g} um rms, {largest:.3g}" in coarse[0]


def test_either_column_may_be_missing_and_the_cycle_counted_in_cycles(tmp_path):
    lines = [f"{230 + 40 * np.cos(2 * np.pi * p)},{p}" for p in np.arange(10) / 10]
    path = cycle_file(tmp_path, "stiffness (N/um),phase (cycle)", lines)
    gear = gear_of(
        small_plan(
            "gear=miter",
            "gear.physical.mesh_stiffness=null",
            "gear.physical.mesh_stiffness_harmonics=[]",
            f"gear.physical.mesh_cycle={path}",
        )
    )
    assert gear.mesh_stiffness == pytest.approx(230e6) and gear.error_harmonics[0][0] == pytest.approx(1e-5)


ANGLES = [f"{angle}, 200, 1" for angle in range(0, 360, 30)]


@pytest.mark.parametrize(
    ("header", "lines", "said"),
    [
        (HEADER, [*ANGLES, "30, 200, 1"], "the angle 30 deg must be given once"),
        (
            HEADER,
            ANGLES[:8],
            "the angle 210 deg must be followed by another after less than half a period of harmonic 3",
        ),
        (
            HEADER,
            ANGLES[::3],
            "gear.physical.mesh_cycle_harmonics = 3 is not allowed: it must be at most 1 for 4 points",
        ),
        (HEADER, [*ANGLES, "361, 200, 1"], "line 14: the angle must be at least 0 and at most one mesh cycle"),
        (HEADER, [*ANGLES, "-1, 200, 1"], "line 14: the angle must be at least 0"),
        (HEADER, [*ANGLES[:3], "95, nan, 1"], "line 5: 'stiffness (N/um)' = 'nan' must be a finite number"),
        (HEADER, [*ANGLES[:3], "95, , 1"], "line 5: 'stiffness (N/um)' = '' must be a finite number"),
        (HEADER, [*ANGLES[:3], "95, 200"], "line 5 has 2 entries, the header has 3"),
        (HEADER, [*ANGLES[:3], "95, -1, 1"], "line 5: the stiffness must be at least 0"),
        (HEADER, [f"{a}, {200 if a in (0, 30) else 0}, 1" for a in range(0, 360, 30)], "mesh_stiffness_harmonics = "),
        (
            "angle (deg), stiffness (um)",
            ["0, 1"],
            "unit of stiffness = 'um' is not allowed: it must be a unit of stiffness",
        ),
        ("angle, stiffness", ["0, 1"], "its header has 'angle'"),
        ("angle (deg), angle (deg)", ["0, 1"], "its header has 'angle (deg)'"),
        ("angle (deg)", ["0"], "one or both of stiffness"),
        ("stiffness (N/um), error (um)", ["1, 1"], "its header must have one of angle (deg)"),
        ("", [], "it is empty"),
    ],
)
def test_mesh_cycles_that_are_not_allowed(header, lines, said, tmp_path):
    with pytest.raises(ConfigurationError) as error:
        with_cycle(cycle_file(tmp_path, header, lines))
    assert said in str(error.value) and "\n" not in str(error.value)


def test_mesh_cycles_that_cannot_be_read(tmp_path):
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x01")
    files = {"none.csv": "no such file", "binary.csv": "CSV file in UTF-8", ".": "it must be a file"}
    for name, said in files.items():
        with pytest.raises(ConfigurationError, match=said):
            with_cycle(tmp_path / name)


# Dialects

CONES = PitchCones((20, 31), 4e-3, 90.0, 16e-3)
SHARES = np.arange(30) / 30 + 0.01 * np.sin(np.arange(30))
STIFFNESS = 224e6 + 45e6 * np.cos(2.0 * np.pi * SHARES + 0.4) + 9e6 * np.cos(6.0 * np.pi * SHARES)
ERROR = 1e-6 + 8e-6 * np.cos(2.0 * np.pi * SHARES - 0.7)
#: Column -> what one mesh cycle is in it, and the length that has to be said.
PLACES = {
    "angle (deg)": (360.0, None),
    "Angle [deg]": (360.0, None),
    "mesh_angle [\u00b0]": (360.0, None),
    "phase (cycle)": (1.0, None),
    "angle (rad)": (2.0 * np.pi, None),
    "pinion angle (deg)": (18.0, None),
    "Wheel Angle [deg]": (360.0 / 31.0, None),
    "angle [deg] ": (24.0, "24 deg"),
    "time [ms]": (1.25, "1.25 ms"),
    "t (s)": (1.25e-3, "1.25 ms"),
}
STIFFNESSES = {
    "stiffness (N/um)": 1e6,
    "stiffness [N/\u00b5m]": 1e6,
    "mesh stiffness (N/m)": 1.0,
    "Mesh_Stiffness [N/mm]": 1e3,
    "stiffness (N/(mm um))": 16e6,
    "stiffness [N/(mm\u00b7\u00b5m)]": 16e6,
    "stiffness (N/(mm*um))": 16e6,
    "stiffness [N/mm/um]": 16e6,
}
ERRORS = {"error (um)": 1e-6, "transmission error [\u00b5m]": 1e-6, "error (mm)": 1e-3, "error [m]": 1.0}


@st.composite
def dialects(draw):
    """The bytes of a file that holds the cycle, and the length that the user has to type."""
    place, (cycle, length) = draw(st.sampled_from(sorted(PLACES.items())))
    stiffness, force = draw(st.sampled_from(sorted(STIFFNESSES.items())))
    error, size = draw(st.sampled_from(sorted(ERRORS.items())))
    shares = SHARES - SHARES[0] if "t" in (place[0], place[:1].lower()) else SHARES
    columns = [(place, shares * cycle), (stiffness, STIFFNESS / force), (error, ERROR / size)]
    columns = draw(st.permutations(columns))
    rows = np.column_stack([values for _, values in columns])
    if draw(st.booleans()):
        closing = rows[0].copy()
        closing[[name for name, _ in columns].index(place)] += cycle
        rows = np.vstack([rows, closing])
    separator = draw(st.sampled_from([",", ";", "; ", "\t", ", "]))
    comma = separator.strip() != "," and draw(st.booleans())
    lines = [[f"{value:.13g}" for value in row] for row in rows]
    if comma:
        lines = [[text.replace(".", ",") for text in row] for row in lines]
    header = separator.join(name for name, _ in columns)
    if draw(st.booleans()):
        header = "# " + header
    elif draw(st.booleans()):
        header = separator.join(f'"{name}"' for name, _ in columns)
    text = [header, *(separator.join(row) for row in lines)]
    if draw(st.booleans()):
        text.insert(0, "# program X, load 100 N*m, 2 000 points")
    if draw(st.booleans()):
        text.insert(len(text) // 2, "# half of it")
    encoding = draw(st.sampled_from(["utf-8", "utf-8-sig", "latin-1"]))
    end = draw(st.sampled_from(["\n", "\r\n"]))
    return (end.join(text) + draw(st.sampled_from(["", end, 2 * end]))).encode(encoding), length


@settings(max_examples=150, deadline=None)
@given(dialects())
def test_every_dialect_reads_to_the_same_numbers(tmp_path_factory, dialect):
    data, length = dialect
    path = tmp_path_factory.getbasetemp() / "dialect.csv"
    path.write_bytes(data)
    found = read_mesh_cycle(str(path), 3, CONES, length)
    # Time counts from the first row.
    turned = 2.0 * np.pi * SHARES[0] if b"ms]" in data or b"t (s)" in data else 0.0
    assert found.points == 30
    assert found.stiffness.mean == pytest.approx(224e6, rel=1e-9) and found.stiffness.largest < 1.0
    for fit, order, amplitude, phase in (
        (found.stiffness, 1, 45e6, 0.4),
        (found.stiffness, 3, 9e6, 0.0),
        (found.error, 1, 8e-6, -0.7),
    ):
        a, p = fit.harmonics[order - 1]
        expected = amplitude * np.exp(1j * (phase + order * turned))
        assert abs(a * np.exp(1j * p) - expected) < 1e-8 * amplitude


def read(tmp_path, text, length=None):
    path = tmp_path / "cycle.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_mesh_cycle(str(path), 1, CONES, length)


def lines_of(header, angles, values, last=""):
    return "\n".join([header, *(f"{a},{v}" for a, v in zip(angles, values, strict=True)), last])


ROUND = [200 + v for v in (0, 5, 8, 9, 7, 3, -4, -9, -6, -2)]


def test_a_closing_row_that_repeats_the_first_is_left_out(tmp_path):
    degrees = range(0, 360, 36)
    bare = read(tmp_path, lines_of("angle (deg),stiffness (N/um)", degrees, ROUND))
    closed = read(tmp_path, lines_of("angle (deg),stiffness (N/um)", degrees, ROUND, "360,200"))
    assert closed == bare and closed.points == 10
    opened = read(tmp_path, lines_of("angle (deg),stiffness (N/um)", [*range(36, 361, 36)], [*ROUND[1:], 200]))
    assert opened.points == 10 and opened.stiffness.mean == pytest.approx(bare.stiffness.mean, rel=1e-12)


def test_a_closing_row_of_time_says_the_length(tmp_path):
    seconds = np.arange(10) * 2e-4 + 0.7
    closed = read(tmp_path, lines_of("time (s),stiffness (N/um)", seconds, ROUND, "0.702,200"))
    said = read(tmp_path, lines_of("time (s),stiffness (N/um)", seconds, ROUND), "2 ms")
    np.testing.assert_allclose(closed.stiffness.harmonics, said.stiffness.harmonics, rtol=1e-8)


@pytest.mark.parametrize(
    ("text", "length", "named"),
    [
        # What is left open is asked back, with what to type.
        (lines_of("time (s),stiffness (N/um)", range(10), ROUND), None, "gear.physical.mesh_cycle_length='1.2 ms'"),
        (lines_of("angle (deg),stiffness (N/um)", np.arange(10) * 1.8, ROUND), None, "'pinion angle'"),
        (lines_of("angle (deg),stiffness (N/um)", np.arange(10) * 1.8, ROUND), None, "mesh_cycle_length='18 deg'"),
        (lines_of("angle,stiffness (N/um)", range(10), ROUND), None, "angle (deg) or angle (rad)"),
        (lines_of("angle (deg),stiffness", range(10), ROUND), None, "stiffness (N/um) or stiffness (N/(mm um))"),
        ("angle (deg);stiffness (N/um)\n0,5;1.5\n", None, "points and commas"),
        ("angle (deg),stiffness (N/um)\n0,5,1,5\n", None, "separate columns by ;"),
        # What contradicts itself is refused.
        (lines_of("angle (deg),stiffness (N/um)", range(0, 360, 36), ROUND, "360,201"), None, "line 12 closes"),
        (lines_of("pinion angle (deg),stiffness (N/um)", range(0, 30, 3), ROUND), None, "18 deg"),
        (lines_of("angle (deg),stiffness (N/um)", range(0, 360, 36), ROUND), "-360 deg", "mesh_cycle_length"),
        (lines_of("angle (deg),stiffness (N/um)", range(0, 360, 36), ROUND), "2 ms", "mesh_cycle_length"),
        (lines_of("time (s),stiffness (N/um)", [0, 1, 2, 2, 3, 4, 5, 6, 7, 8], ROUND), "10 s", "line 5: the time"),
        (lines_of("time (s),stiffness (N/um)", range(10), ROUND), "5 s", "line 8: the time"),
        (lines_of("time (s),angle (deg)", range(10), ROUND), None, "'angle (deg)'"),
        (lines_of("angle (deg),pressure (MPa)", range(10), ROUND), None, "'pressure (MPa)'"),
        (lines_of("angle (deg),stiffness (N/mm*um)", range(10), ROUND), None, "unit of stiffness"),
        (lines_of("angle (deg),stiffness (N/(s um))", range(10), ROUND), None, "unit of stiffness"),
        ("# angle (deg), stiffness (N/um)\n", None, "it is empty"),
        ("angle (deg),stiffness (N/um)\n", None, "no rows"),
        # Hostile files.
        (b"angle (deg),stiffness (N/um)\n0,1\x00\n", None, "UTF-8 or Latin-1"),
        ("angle (deg),stiffness (N/um)\n0,1e31\n", None, "line 2"),
        ("angle (deg),stiffness (N/um)\n0,1_0\n", None, "line 2"),
        ("angle (deg),stiffness (N/um)\n0,\u0661\n", None, "line 2"),
        ("angle (deg),stiffness (N/um)\n0,=1+1\n", None, "line 2"),
        ('angle (deg),stiffness (N/um)\n0,"1\n', None, "line 2"),
        (f"{'a ' * 200_000}(deg),stiffness (N/um)\n0,1\n", None, "line 1"),
        (f"{'a ' * 60_000}(deg),stiffness (N/um)\n0,1\n", None, "its header has"),
        (f"angle ({'(' * 100_000}deg),stiffness (N/um)\n0,1\n", None, "its header has"),
        ("angle (deg),stiffness (N/um)\n" + "0,1\n" * 100_001, None, "100000 are allowed"),
    ],
)
def test_what_is_open_is_asked_back_and_what_is_wrong_is_named(text, length, named, tmp_path):
    with pytest.raises(ConfigurationError) as error:
        read(tmp_path, text, length)
    assert named in str(error.value) and "\n" not in str(error.value) and len(str(error.value)) < 1000


def test_large_files_are_not_read(tmp_path):
    path = tmp_path / "large.csv"
    with path.open("wb") as file:
        file.truncate(10_000_001)
    with pytest.raises(NumbersError, match="10 MB"):
        read_table(str(path))


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=200) | st.text('0123456789.,;eE+-#\t\n "angle(deg)[]', max_size=200).map(str.encode))
def test_whatever_a_file_holds_the_answer_is_one_line(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "any.csv"
    path.write_bytes(b"angle (deg),stiffness (N/um)\n" * (len(data) % 2) + data)
    try:
        found = read_mesh_cycle(str(path), 1, CONES)
    except ConfigurationError as error:
        assert "\n" not in str(error)
    else:
        assert math.isfinite(found.stiffness.mean)


def test_the_length_is_a_key_of_the_gear(tmp_path):
    path = tmp_path / "cycle.csv"
    path.write_text(lines_of("time (ms),stiffness (N/um)", range(10), ROUND))
    gear = gear_of(with_cycle(path, "mesh_cycle_length=10 ms", "error_harmonics=[[1 um,0 deg]]"))
    assert gear.mesh_stiffness == pytest.approx(np.mean(ROUND) * 1e6)
