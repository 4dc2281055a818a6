"""Mesh stiffness from the drawing: published digits, and every part by a method of its own."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad_vec
from scipy.linalg import solveh_banded
from scipy.optimize import brentq

from solver import GearTeeth, ParameterError, ToothMesh, bevel_mesh, iso_6336_stiffness, thumb_stiffness
from solver.gear.pitch_cones import PitchCones
from solver.gear.teeth import fillet, involute, involute_function, junction
from solver.gear.tooth_stiffness import body_compliance, tooth_compliance

STEP = 1e-30
STEEL = 206e9
#: The test gear of ROSS (github.com/petrobras/ross, tests of its gear element), after Ma et al. (2014).
TEST_GEAR = GearTeeth(62, 2e-3, bore=35e-3)
TEST_MESH = ToothMesh(TEST_GEAR, TEST_GEAR, 20e-3)


def teeth_of(teeth, module, **changes) -> GearTeeth:
    """With a bore of half the pitch diameter."""
    return GearTeeth(teeth, module, **{"bore": 0.5 * teeth * module, **changes})


def with_teeth(gear, teeth, shift) -> GearTeeth:
    """Another gear cut by the same rack."""
    return dataclasses.replace(gear, teeth=teeth, profile_shift=shift, bore=0.5 * teeth * gear.module)


TEETH = st.builds(
    teeth_of,
    teeth=st.floats(20.0, 150.0),
    module=st.floats(1e-3, 1e-2),
    pressure_angle=st.floats(18.0, 25.0),
    profile_shift=st.floats(-0.1, 0.3),
    edge_radius=st.none() | st.floats(0.0, 0.25),
)


# The published test gear


def test_published_numbers():
    assert TEST_MESH.contact_ratio == pytest.approx(1.7897798668330458, rel=1e-12)
    assert TEST_MESH.hertz_stiffness == pytest.approx(3555868607.9093266, rel=1e-12)
    # What is published as mean stiffness is the rule of thumb; the mean of the cycle is 4.7 % below it.
    assert thumb_stiffness(TEST_MESH) == pytest.approx(4.096607e8, rel=1e-6)
    assert TEST_MESH.mean_stiffness == pytest.approx(4.096607e8, rel=0.05)
    assert TEST_MESH.mean_stiffness == pytest.approx(3.90432e8, rel=1e-5)
    assert iso_6336_stiffness(TEST_MESH) == pytest.approx(4.60878e8, rel=1e-5)


def test_published_geometry():
    radii = [TEST_GEAR.base_radius, TEST_GEAR.pitch_radius, TEST_GEAR.tip_radius, TEST_GEAR.root_radius]
    np.testing.assert_allclose(radii, [0.05826094248872632, 0.062, 0.064, 0.0595], rtol=1e-14)
    angles = [TEST_GEAR.base_half_angle, TEST_GEAR.tip_angle, junction(TEST_GEAR)[0]]
    np.testing.assert_allclose(angles, [0.04023980849306058, 0.42672233774374957, 0.2577380345253824], rtol=1e-13)


def test_published_stiffness_of_two_pairs():
    """396622921.358 N/m where a pair comes into contact, with the places, lever and root angle that are used there.

    There the contact begins at the end of the flank, pairs are apart by a share of the pressure angle, the lever of the
    force is taken at the flank and not at the centre line, and the root half angle is 0.0456584787 instead of the
    0.0485937226 of the fillet.
    """
    low, high = 0.2577380345253824, TEST_GEAR.tip_angle
    total = 0.0
    for moved in (0.0, (high - low) / TEST_MESH.contact_ratio):
        angles = np.array([low + moved, high - moved])
        tooth = tooth_compliance(TEST_GEAR, angles)
        _, y, _, force = involute(TEST_GEAR, angles)
        body = body_compliance(force, y - 0.0595, 0.0595, 0.0456584787349235, 35e-3)
        parts = (tooth.bending + tooth.shear + tooth.compression + body) / (STEEL * 20e-3)
        total += 1.0 / (1.0 / TEST_MESH.hertz_stiffness + parts.sum())
    assert total == pytest.approx(396622921.3581085, rel=1e-10)


# Geometry


@given(TEETH, st.floats(0.0, 1.0))
def test_slopes_by_complex_step(gear, share):
    low, top = junction(gear)
    angle = top + share * (0.5 * math.pi - top)
    assert fillet(gear, angle)[2] == pytest.approx(fillet(gear, angle + 1j * STEP)[1].imag / STEP, rel=1e-9, abs=1e-18)
    roll = math.tan(low) + share * (math.tan(gear.tip_angle) - math.tan(low))
    _, y, _, _ = involute(gear, np.arctan(roll + 1j * STEP))
    assert involute(gear, math.atan(roll))[2] == pytest.approx(y.imag / STEP, rel=1e-9, abs=1e-18)


def cut_half_angles(gear: GearTeeth, radii) -> np.ndarray:
    """Half the angle of a tooth at some radii by rolling the rack past it: the least that any position leaves."""
    m, alpha = gear.module, math.radians(gear.pressure_angle)
    edge, depth = gear._edge * m, gear.dedendum * m
    # The rack's tooth, over x from the middle of its space: flank, then the rounded tip, then the flat tip.
    centre_x = 0.25 * math.pi * m + (depth - edge) * math.tan(alpha) + edge / math.cos(alpha)
    flank_y = np.linspace(m, -(depth - edge * (1.0 - math.sin(alpha))), 1500)
    flank_x = 0.25 * math.pi * m - flank_y * math.tan(alpha)
    turns = np.linspace(alpha, 0.5 * math.pi, 1500)
    tip_x, tip_y = centre_x - edge * np.cos(turns), -(depth - edge) - edge * np.sin(turns)
    x = np.concatenate([flank_x, tip_x, np.linspace(centre_x, 0.5 * math.pi * m, 200)])
    y = np.concatenate([flank_y, tip_y, np.full(200, -depth)]) + gear.profile_shift * m
    least = np.full(len(radii), math.pi / gear.teeth)
    for turn in np.linspace(-0.9, 0.9, 1801):
        # In the frame of the gear, whose pitch circle rolls on the rack's pitch line.
        u, v = x - gear.pitch_radius * turn, gear.pitch_radius + y
        along, size = np.arctan2(u, v) + turn, np.hypot(u, v)
        for i, radius in enumerate(radii):
            crossing = np.flatnonzero(np.diff(size > radius))
            if crossing.size:
                least[i] = min(least[i], along[crossing].min())
    return least


@pytest.mark.parametrize(
    "gear",
    [
        TEST_GEAR,
        teeth_of(20, 4e-3, profile_shift=0.2),
        teeth_of(12, 4e-3),
        teeth_of(13.7, 4e-3, dedendum=1.4, edge_radius=0.2),
    ],
)
def test_profile_is_what_the_rack_leaves(gear):
    low, top = junction(gear)
    rolls = np.linspace(math.tan(low), math.tan(gear.tip_angle), 6)[1:]
    points = [involute(gear, np.arctan(rolls))[:2], fillet(gear, np.linspace(top, 0.5 * math.pi, 6)[:-1])[:2]]
    x, y = np.hstack([np.array(part) for part in points])
    radii = np.hypot(x, y)
    np.testing.assert_array_less(np.abs(np.arctan2(x, y) - cut_half_angles(gear, radii)), 3e-3 * gear.module / radii)


@pytest.mark.parametrize("edge", [None, 0.0, 0.2])
def test_undercut_begins_without_a_jump(edge):
    """Around the profile shift at which the rack's flank ends on the base circle, at every distance from it."""
    gear = teeth_of(20, 3e-3, pressure_angle=18.0, edge_radius=edge)
    radius = gear._edge
    sine = math.sin(math.radians(18.0))
    limit = 1.25 - radius * (1.0 - sine) - 10.0 * sine**2
    at = ToothMesh(*[dataclasses.replace(gear, profile_shift=limit)] * 2, 0.02).mean_stiffness
    for distance in 10.0 ** np.arange(-16.0, -3.0):
        for sign in (-1.0, 1.0):
            near = dataclasses.replace(gear, profile_shift=limit + sign * distance)
            assert junction(near)[0] < 20.0 * distance + 1e-6
            assert ToothMesh(near, near, 0.02).mean_stiffness == pytest.approx(at, rel=10.0 * distance + 1e-6)


def test_undercut_shortens_the_path():
    bare, shifted = teeth_of(12, 4e-3), teeth_of(12, 4e-3, profile_shift=0.3)
    assert junction(bare)[1] > math.radians(20.0) and junction(shifted)[1] == math.radians(20.0)
    large = teeth_of(60, 4e-3)
    path = ToothMesh(bare, large, 0.01).path
    at_tip = large.base_radius * (math.tan(large.tip_angle) - math.tan(math.radians(20.0)))
    assert path[0] < 0.99 * at_tip


# Compliances


def section(gear, y):
    """Half thickness at a height, by inverting the profile."""
    low, top = junction(gear)
    if y >= involute(gear, low)[1]:
        high = math.tan(gear.tip_angle)
        roll = brentq(lambda one: involute(gear, math.atan(one))[1] - y, math.tan(low), high + 1e-9, xtol=1e-14)
        return involute(gear, math.atan(roll))[0]
    return fillet(gear, brentq(lambda one: fillet(gear, one)[1] - y, top, 0.5 * math.pi, xtol=1e-14))[0]


GEARS = [TEST_GEAR, teeth_of(28.28, 3.4e-3, bore=0.028), teeth_of(14, 4e-3), teeth_of(120, 4e-3, profile_shift=-0.4)]


@pytest.mark.parametrize("gear", GEARS)
@pytest.mark.parametrize("share", [0.1, 0.6, 1.0])
def test_energy_of_the_beam_by_quadrature_over_its_height(gear, share):
    low, top = junction(gear)
    angle = math.atan(math.tan(low) + share * (math.tan(gear.tip_angle) - math.tan(low)))
    contact_x, contact_y, _, force = involute(gear, angle)
    bottom, meeting = fillet(gear, 0.5 * math.pi)[1], involute(gear, low)[1]
    poisson = gear.poisson

    def energies(y):
        half = section(gear, y)
        area, inertia = 2.0 * half, 2.0 / 3.0 * half**3
        moment = math.cos(force) * (contact_y - y) - math.sin(force) * contact_x
        shear = 1.2 * 2.0 * (1.0 + poisson) * math.cos(force) ** 2 / area
        return np.array([moment**2 / inertia, shear, math.sin(force) ** 2 / area])

    found = tooth_compliance(gear, np.array([angle]))
    # Each is as large as 1, so that all are integrated to the same accuracy.
    sizes = np.array([found.bending[0], found.shear[0], found.compression[0]])
    ends = (bottom, meeting, contact_y)
    integrated = sum(quad_vec(lambda y: energies(y) / sizes, *part, epsrel=1e-8)[0] for part in pairwise(ends))
    np.testing.assert_allclose(integrated, 1.0, rtol=1e-6)


@pytest.mark.parametrize("gear", GEARS[:2])
def test_energy_of_the_beam_by_finite_elements(gear):
    """A cantilever of 800 straight Timoshenko elements, loaded at its end by the force and its moment."""
    angle = gear.tip_angle
    contact_x, contact_y, _, force = involute(gear, angle)
    heights = np.linspace(fillet(gear, 0.5 * math.pi)[1], contact_y, 801)
    half = np.array([section(gear, y) for y in 0.5 * (heights[1:] + heights[:-1])])
    size = 3 * heights.size
    # Its lower diagonals.
    stiffness = np.zeros((6, size))
    for i, (length, x) in enumerate(zip(np.diff(heights), half, strict=True)):
        area, inertia, shear_modulus = 2.0 * x, 2.0 / 3.0 * x**3, 0.5 / (1.0 + gear.poisson)
        phi = 12.0 * inertia * 1.2 / (shear_modulus * area * length**2)
        bend = inertia / (length**3 * (1.0 + phi))
        element = np.zeros((6, 6))
        element[np.ix_([0, 3], [0, 3])] = area / length * np.array([[1, -1], [-1, 1]])
        element[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = bend * np.array(
            [
                [12.0, 6.0 * length, -12.0, 6.0 * length],
                [6.0 * length, (4.0 + phi) * length**2, -6.0 * length, (2.0 - phi) * length**2],
                [-12.0, -6.0 * length, 12.0, -6.0 * length],
                [6.0 * length, (2.0 - phi) * length**2, -6.0 * length, (4.0 + phi) * length**2],
            ]
        )
        for below in range(6):
            stiffness[below, 3 * i : 3 * i + 6 - below] += np.diagonal(element, -below)
    load = np.zeros(size)
    load[-3:] = -math.sin(force), math.cos(force), -math.sin(force) * contact_x
    moved = solveh_banded(stiffness[:, 3:], load[3:], lower=True)
    found = tooth_compliance(gear, np.array([angle]))
    expected = found.bending + found.shear + found.compression
    assert load[3:] @ moved == pytest.approx(expected[0], rel=2e-4)


def test_body_is_taken_at_the_ends_of_its_fit():
    at = [body_compliance(0.2, 4e-3, 0.06, 0.05, bore) for bore in (1e-6, 1e-3, 2 * 0.06 / 7.0)]
    np.testing.assert_allclose(at, at[0], rtol=1e-13)
    assert body_compliance(0.2, 4e-3, 0.06, 0.05, 0.05) < at[0]


# The mesh


@settings(max_examples=20, deadline=None)
@given(TEETH, st.floats(20.0, 150.0), st.floats(-0.05, 0.2), st.integers(0, 2**32 - 1))
def test_harmonics_are_those_of_the_sampled_cycle(first, teeth, shift, seed):
    mesh = ToothMesh(first, with_teeth(first, teeth, shift), 0.02)
    # Between the jumps, so that the sum of the samples converges: the ends of the path are left out.
    edge = 2.0 * math.pi * (mesh.contact_ratio - math.floor(mesh.contact_ratio))
    nodes, weights = np.polynomial.legendre.leggauss(80)
    half = np.array([[0.5 * edge], [math.pi - 0.5 * edge]])
    phase = half * (nodes + 1.0) + [[0.0], [edge]]
    sampled = half * weights * [mesh.stiffness(part) for part in phase] / (2.0 * math.pi)
    found = mesh.coefficients(3)
    for count in (0, 1, 3):
        assert abs(found[count] - np.sum(sampled * np.exp(-1j * count * phase))) < 1e-7 * mesh.mean_stiffness
    turned = np.random.default_rng(seed).uniform(0.0, 2.0 * math.pi, 5)
    np.testing.assert_allclose(mesh.stiffness(turned + 4.0 * math.pi), mesh.stiffness(turned), rtol=1e-6)


def test_harmonics_add_up_to_the_cycle():
    phase = np.linspace(1.5, 4.5, 7)
    harmonics = TEST_MESH.harmonics(100)
    series = sum(a * np.cos(l * phase + p) for l, (a, p) in enumerate(harmonics, 1)) + TEST_MESH.mean_stiffness
    np.testing.assert_allclose(series, TEST_MESH.stiffness(phase), rtol=0.05)


@settings(max_examples=20, deadline=None)
@given(TEETH, st.floats(0.2, 5.0))
def test_similar_gears_are_as_stiff_and_equal_ones_symmetric(gear, scale):
    mesh = ToothMesh(gear, gear, 0.02)
    larger = dataclasses.replace(gear, module=scale * gear.module, bore=scale * gear.bore)
    assert ToothMesh(larger, larger, 0.02).mean_stiffness == pytest.approx(mesh.mean_stiffness, rel=1e-9)
    place = np.linspace(0.0, sum(mesh.path), 9)
    np.testing.assert_allclose(mesh.pair_stiffness(place), mesh.pair_stiffness(place)[::-1], rtol=1e-9)


@settings(max_examples=20, deadline=None)
@given(TEETH, st.floats(20.0, 150.0), st.floats(0.0, 0.2))
def test_turned_round_the_cycle_runs_backwards(first, teeth, shift):
    second = with_teeth(first, teeth, shift)
    mesh, back = ToothMesh(first, second, 0.02), ToothMesh(second, first, 0.02)
    place = np.linspace(0.0, sum(mesh.path), 9)
    np.testing.assert_allclose(mesh.pair_stiffness(place), back.pair_stiffness(place)[::-1], rtol=1e-8)


def test_working_angle_and_contact_ratio_of_a_textbook_pair():
    """Shifted teeth touch without backlash at the working distance: their thicknesses fill the pitch there."""
    mesh = ToothMesh(teeth_of(20, 4e-3, profile_shift=0.4), teeth_of(50, 4e-3, profile_shift=0.1), 0.03)
    thickness = 0.0
    for gear in (mesh.first, mesh.second):
        radius = gear.base_radius / math.cos(mesh.working_angle)
        thickness += 2.0 * radius * (gear.base_half_angle - involute_function(mesh.working_angle))
    pitch = 2.0 * math.pi * mesh.first.base_radius / (math.cos(mesh.working_angle) * mesh.first.teeth)
    assert thickness == pytest.approx(pitch, rel=1e-13)
    reach = [math.sqrt(gear.tip_radius**2 - gear.base_radius**2) for gear in (mesh.first, mesh.second)]
    length = sum(reach) - mesh.centre_distance * math.sin(mesh.working_angle)
    assert mesh.contact_ratio == pytest.approx(length / mesh.base_pitch, rel=1e-13)


def test_softer_wheel_of_another_material():
    plastic = dataclasses.replace(TEST_GEAR, youngs_modulus=3e9, poisson=0.4)
    mesh = ToothMesh(TEST_GEAR, plastic, 20e-3)
    assert mesh.hertz_stiffness == pytest.approx(0.5 * math.pi * 20e-3 / (0.91 / STEEL + 0.84 / 3e9), rel=1e-12)
    assert mesh.mean_stiffness < 0.04 * TEST_MESH.mean_stiffness


# Bevel pairs


def test_bevel_pair_is_the_sum_of_its_slices():
    """Slices of 1/40 of the width as spur pairs of their own, moved and levered as their distance from the apex."""
    first, second = teeth_of(20, 4e-3, bore=0.02), teeth_of(30, 4e-3, bore=0.03)
    cones = PitchCones((20, 30), 4e-3, 75.0, 0.018)
    mesh = bevel_mesh(first, second, 75.0, 0.018)
    edges = np.linspace(cones.cone_distance - 0.018, cones.cone_distance, 41)
    mean, total, ratios = cones.cone_distance - 0.009, 0.0, set()
    for radius in 0.5 * (edges[1:] + edges[:-1]):
        taper = radius / cones.cone_distance
        gears = [
            dataclasses.replace(
                gear,
                teeth=gear.teeth / cosine,
                module=4e-3 * taper,
                bore=gear.bore / cosine * taper / (mean / cones.cone_distance),
            )
            for gear, cosine in zip((first, second), np.cos(np.radians(cones.cone_angles)), strict=True)
        ]
        one = ToothMesh(*gears, 0.018 / 40)
        ratios.add(round(one.contact_ratio, 9))
        total += one.mean_stiffness * (radius / mean) ** 2
    assert mesh.mean_stiffness == pytest.approx(total, rel=1e-5) and ratios == {round(mesh.contact_ratio, 9)}
    # A bore that does not taper makes no more than half a percent.
    straight = 0.0
    for radius in 0.5 * (edges[1:] + edges[:-1]):
        taper = radius / cones.cone_distance
        gears = [
            dataclasses.replace(gear, teeth=gear.teeth / cosine, module=4e-3 * taper, bore=gear.bore / cosine)
            for gear, cosine in zip((first, second), np.cos(np.radians(cones.cone_angles)), strict=True)
        ]
        straight += ToothMesh(*gears, 0.018 / 40).mean_stiffness * (radius / mean) ** 2
    assert straight == pytest.approx(mesh.mean_stiffness, rel=5e-3)


def test_bevel_pair_with_parallel_shafts_is_the_spur_pair():
    gear = teeth_of(62, 2e-3, bore=35e-3)
    nearly = bevel_mesh(gear, gear, 0.01, 20e-3)
    assert nearly.mean_stiffness == pytest.approx(TEST_MESH.mean_stiffness, rel=1e-5)


# ISO 6336


def test_iso_6336_by_hand():
    """z 20/50, x 0.3/0.1: q' = 0.04723 + 0.0077755 + 0.0051582 - 0.001905 - 0.0017481 - 0.000193 - 0.00048376 + ..."""
    first, second = teeth_of(20, 4e-3, profile_shift=0.3), teeth_of(50, 4e-3, profile_shift=0.1)
    mesh = ToothMesh(first, second, 0.03)
    series = 0.04723 + 0.0077755 + 0.0051582 - 0.001905 - 0.0017481 - 0.000193 - 0.00048376 + 0.0004761 + 0.0000182
    single = 0.8 * 0.975 / series
    assert iso_6336_stiffness(mesh) == pytest.approx(single * (0.75 * mesh.contact_ratio + 0.25) * 30.0 * 1e6, rel=1e-9)


@settings(max_examples=20, deadline=None)
@given(st.integers(18, 120), st.integers(18, 120))
def test_the_estimates_are_of_the_size_of_the_cycle(one, other):
    mesh = ToothMesh(teeth_of(one, 3e-3), teeth_of(other, 3e-3), 0.02)
    for estimate in (iso_6336_stiffness(mesh), thumb_stiffness(mesh)):
        assert 0.7 < mesh.mean_stiffness / estimate < 1.3


# What is refused


@pytest.mark.parametrize(
    ("name", "made"),
    [
        ("bore", lambda: teeth_of(20, 4e-3, bore=0.08)),
        ("addendum", lambda: teeth_of(8, 4e-3, profile_shift=1.0)),
        ("dedendum", lambda: teeth_of(20, 4e-3, dedendum=1.0)),
        ("dedendum", lambda: teeth_of(20, 4e-3, pressure_angle=35.0)),
        ("edge_radius", lambda: teeth_of(20, 4e-3, edge_radius=0.6)),
        ("profile_shift", lambda: teeth_of(60, 4e-3, profile_shift=0.9)),
        ("second.module", lambda: ToothMesh(teeth_of(20, 4e-3), teeth_of(20, 5e-3), 0.02)),
        ("second.pressure_angle", lambda: ToothMesh(teeth_of(20, 4e-3), teeth_of(20, 4e-3, pressure_angle=21), 0.02)),
        ("addendum", lambda: ToothMesh(teeth_of(20, 4e-3), teeth_of(20, 4e-3, addendum=1.3, dedendum=1.35), 0.02)),
        ("addendum", lambda: ToothMesh(*[teeth_of(20, 4e-3, addendum=0.4)] * 2, 0.02)),
        (
            "profile_shift",
            lambda: iso_6336_stiffness(ToothMesh(TEST_GEAR, teeth_of(62, 2e-3, profile_shift=0.1), 0.02)),
        ),
        ("shaft_angle", lambda: bevel_mesh(teeth_of(20, 4e-3), teeth_of(40, 4e-3), 120.0, 0.01)),
        ("first.teeth", lambda: bevel_mesh(teeth_of(20.5, 4e-3), teeth_of(40, 4e-3), 90.0, 0.01)),
        ("face_width", lambda: bevel_mesh(teeth_of(20, 4e-3), teeth_of(40, 4e-3), 90.0, 0.5)),
        ("place", lambda: TEST_MESH.pair_stiffness(np.array([0.1]))),
        ("angle", lambda: tooth_compliance(TEST_GEAR, np.array([0.1]))),
    ],
)
def test_what_does_not_mesh_is_refused(name, made):
    with pytest.raises(ParameterError) as error:
        made()
    assert error.value.name == name and "\n" not in str(error.value)
