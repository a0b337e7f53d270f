"""Quarters of a ball that lean, and miss its corners or run past them; tails; narrow strips."""

import numpy as np
import pytest

from bozzetto_product.hand_over.network_file import network_of
from bozzetto_product.hand_over.overlaps import without_overlaps
from bozzetto_product.hand_over.point_fit import spline_through
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.meetings import meeting_place, splines_of
from tests.plugins.product.test_rough_files import facts, solved, turned

RADIUS = 50.0


def quarters(seed, lean, too_far=0.0):
    """Twelve arcs on a ball, each turned about its middle; half of their ends are too far, rad."""
    random = np.random.default_rng(seed)
    axes = turned(seed)
    made = {}
    for k in range(3):
        one, two = axes[k], axes[(k + 1) % 3]
        for quarter in range(4):
            angle = np.radians(lean) * random.uniform(0.5, 1.0) * random.choice((-1, 1))
            begin, end = 0.5 * np.pi * quarter, 0.5 * np.pi * (quarter + 1)
            before, beyond = too_far * random.choice((0.0, 0.0, 0.5, 1.0), 2) if too_far else (0, 0)
            at = np.linspace(begin - before, end + beyond, 25)[:, None]
            row = RADIUS * (np.cos(at) * one + np.sin(at) * two)
            axis = np.cos(0.5 * (begin + end)) * one + np.sin(0.5 * (begin + end)) * two
            along = np.outer(row @ axis, axis)
            row = along + np.cos(angle) * (row - along) + np.sin(angle) * np.cross(axis, row)
            made[f"c{k}{quarter}"] = row[:: random.choice((-1, 1))]
    return made


def places_of(state: ProductState):
    splines = splines_of(state)
    joints = [meeting_place(splines, one.meetings[0], state.symmetry) for one in state.joints]
    return np.array(joints)


@pytest.mark.parametrize("scale", [1.0, 1000.0])
def test_four_arcs_that_nearly_meet_do_so_once(scale):
    given = {name: scale * row for name, row in quarters(77, 0.8).items()}
    state = network_of(facts(given)).state
    axes = turned(77)
    wanted = RADIUS * np.concatenate((axes, -axes))
    places = places_of(state) / scale
    assert len(places) == 6
    assert all(len(joint.meetings) == 4 for joint in state.joints)
    apart = np.linalg.norm(places[:, None] - wanted[None], axis=2).min(axis=1)
    assert apart.max() < 1.0  # 0.6 % of the diagonal; each arc is up to 0.5 mm beside


@pytest.mark.parametrize("seed", [8301, 8302, 8303])
def test_arcs_that_lean_and_run_past_their_corners_make_eight_surfaces(seed):
    result, told = solved(facts(quarters(seed, 0.8, 0.1)))
    assert told["closed"]
    assert len(told["patches"]) == 8
    away = [np.abs(np.linalg.norm(one.mesh.vertices, axis=1) - RADIUS) for one in result.filled]
    assert np.concatenate(away).max() < 0.5  # the arcs are up to 0.5 mm beside one another
    assert max(one["g1_deg"] for one in told["patches"]) <= 2.0  # as they lean: 0.8° each


def strip(width):
    """Two bars beside one another, with short edges between their ends: a narrow strip."""
    at = np.linspace(0.0, 1.0, 9)[:, None]
    bar = 100.0 * at * np.array((1.0, 0.0, 0.0))
    far = bar + np.array((0.0, width, 0.0))
    short = np.linspace(bar[-1], far[-1], 4)
    return {"near": bar, "far": far, "first": np.linspace(bar[0], far[0], 4), "last": short}


@pytest.mark.parametrize("off", [0.0, 0.05])
def test_a_narrow_strip_keeps_both_of_its_sides(off):
    """Its corners are 0.8 % of the diagonal apart, and an edge goes from one to the other."""
    given = strip(0.8)
    given["first"] = given["first"] + (off, 0.0, 0.0)
    state = network_of(facts(given)).state
    assert len(state.joints) == 4


def test_a_short_curve_beside_another_joint_keeps_both_of_its_ends():
    """A small ring of three curves on a knob: its corners are near a joint of the body."""
    at = np.linspace(0.0, 1.0, 13)[:, None]
    x, y, z = np.eye(3)
    corners = 1.6 * np.array((x, 0.5 * y - 0.5 * x, -0.5 * y - 0.5 * x))
    small = {}
    for k in range(3):
        begin, end = corners[k] + 0.05 * z * (k - 1), corners[(k + 1) % 3] - 0.03 * z
        small[f"s{k}"] = begin + at * (end - begin) + 0.02 * at * (1 - at) * z
    body = {
        "up": corners[0] + 50.0 * at * z,
        "away": 0.5 * (corners[1] + corners[2]) - 60.0 * at * x,
    }
    state = network_of(facts({**small, **body})).state
    names = {curve.id: curve.name for curve in state.of_kind(Curve)}
    met = sorted(tuple(sorted(names[m.curve] for m in joint.meetings)) for joint in state.joints)
    assert met == [("away", "s1"), ("s0", "s1"), ("s0", "s2", "up"), ("s1", "s2")]


@pytest.mark.parametrize("case", ["crossed", "passed", "not crossed", "another ends there"])
def test_a_tail_that_leans_is_cut_where_a_third_curve_passes(case):
    at = np.linspace(0.0, 1.0, 13)[:, None]
    x, y, z = np.eye(3)
    longer = 60.0 * at * x
    shorter = 50.0 * x + at * (40.0 * x + 1.2 * y) + 0.2 * z
    third = {
        "crossed": 55.0 * x + 40.0 * (at - 0.5) * z,
        "passed": 49.4 * x + 40.0 * (at - 0.5) * z,
        "not crossed": 55.0 * x + 40.0 * (at + 0.5) * z,
        "another ends there": longer[-1] + 20.0 * at * z,
    }[case]
    splines = [spline_through(row, 1e-4) for row in (longer, shorter, third)]
    made = without_overlaps(splines, 0.03, 100.0)
    cut = [one is not before for one, before in zip(made, splines, strict=True)]
    assert cut == [case in ("crossed", "passed"), case == "crossed", False]
    if case == "passed":
        np.testing.assert_allclose(made[0].control_points[-1], 50.0 * x, atol=1e-6)
    if case == "crossed":
        np.testing.assert_allclose(made[0].control_points[-1], 55.0 * x, atol=1e-6)
        assert np.linalg.norm(made[1].control_points[0] - 55.0 * x) < 0.4
