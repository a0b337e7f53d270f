"""Details: exact closed bodies of the depth, draft and gap asked for, whatever the outline."""

from __future__ import annotations

from dataclasses import replace

import manifold3d
import numpy as np
import pytest

from bozzetto_product.model.curves import Curve
from bozzetto_product.model.details import Detail
from bozzetto_product.model.patches import Patch
from bozzetto_product.report import cautions_of
from tests.plugins.product.detail_kit import (
    RADIUS,
    ball,
    body,
    loop_around,
    manifold,
    polygon_around,
    solved,
    with_detail,
)

PLACES = {"inside": (20.0, 20.0, 30.0), "edge": (1.0, 25.0, 28.0), "corner": (1.5, 40.0, 2.0)}
"""Within one surface of the ball, over an edge of two, and round a corner of four."""

KINDS = ("in", "raised", "cut", "button", "split")


@pytest.mark.parametrize(
    ("kind", "place"),
    [("in", "corner"), ("cut", "inside")]
    + [pytest.param(k, p, marks=pytest.mark.slow) for k in KINDS for p in PLACES],
)
def test_every_kind_is_a_closed_body_wherever_it_lies(kind, place):
    points = loop_around(ball(), PLACES[place], 8.0, (0.12, 0.08))
    state = with_detail(ball(), [points], kind=kind, depth=1.5)
    (detail,) = solved(state).detailed.details
    assert detail.problem == ""
    made = body(state)
    assert made.exact.is_closed
    assert made.exact.largest_gap() <= made.exact.tolerance
    whole = manifold(made.mesh)
    assert whole.status() == manifold3d.Error.NoError
    assert whole.genus() == (1 if kind == "cut" else 0)


def test_a_floor_is_at_its_depth_and_walls_stand_at_their_draft_angle():
    points = loop_around(ball(), PLACES["inside"], 9.0, (0.1,))
    for kind, depth, draft in (("in", 2.0, 5.0), ("raised", 1.0, 12.0)):
        state = with_detail(ball(), [points], kind=kind, depth=depth, draft=draft)
        (shell,) = solved(state).detailed.changed
        walls = [f for f, o in zip(shell.faces, shell.owners, strict=True) if o.made]
        floor = walls.pop()
        reach = np.linalg.norm(floor.surface.value(*floor.loops[0][0].curve.value(
            np.linspace(*floor.loops[0][0].curve.range, 9)).T), axis=1)  # fmt: skip
        level = RADIUS + (depth if kind == "raised" else -depth)
        # The wall is drawn straight across the normals at its top: it ends a little off the level.
        slack = 0.02 + (depth * np.tan(np.radians(draft))) ** 2 / RADIUS
        assert np.abs(reach - level).max() < slack
        for wall in walls:
            t = np.linspace(*wall.surface.ranges[0], 9)
            top, end = wall.surface.value(t, 0 * t), wall.surface.value(t, 0 * t + 1)
            out = top / np.linalg.norm(top, axis=1, keepdims=True)
            way = (end - top) * (1.0 if kind == "raised" else -1.0)
            sine = np.linalg.norm(np.cross(way, out), axis=1)
            assert np.abs(np.degrees(np.arctan2(sine, (way * out).sum(axis=1))) - draft).max() < 0.2


@pytest.mark.slow
def test_volumes_are_those_of_caps_between_spheres():
    """A round of angle a, straight down: a cone's share of the shell between two spheres."""
    points = loop_around(ball(), PLACES["inside"], 9.0)
    axis = points.mean(axis=0) / np.linalg.norm(points.mean(axis=0))
    angle = float(np.arccos((points @ axis / np.linalg.norm(points, axis=1)).mean()))
    before = manifold(body(with_detail(ball(), [points], kind="split")).mesh).volume()
    for kind, level in (("in", RADIUS - 2.0), ("raised", RADIUS + 2.0)):
        state = with_detail(ball(), [points], kind=kind, depth=2.0, draft=0.0)
        change = manifold(body(state).mesh).volume() - before
        share = 2.0 * np.pi * (1.0 - np.cos(angle)) / 3.0
        assert change == pytest.approx(share * (level**3 - RADIUS**3), rel=0.01)


@pytest.mark.slow
def test_a_button_stands_apart_by_its_gap():
    points = loop_around(ball(), PLACES["edge"], 8.0)
    state = with_detail(ball(), [points], kind="button", depth=1.0, gap=0.7, draft=0.0)
    (shell,) = solved(state).detailed.changed
    tops = [
        wall.surface.value(t := np.linspace(*wall.surface.ranges[0], 33), 0 * t)
        for wall, owner in zip(shell.faces, shell.owners, strict=True)
        if owner.made and wall.surface.degrees[1] == 1
    ]
    middle = points.mean(axis=0)
    reach = [float(np.linalg.norm(top - middle, axis=1).mean()) for top in tops]
    border = np.mean([min(reach), max(reach)])
    outer = np.concatenate([top for top, r in zip(tops, reach, strict=True) if r > border])
    inner = np.concatenate([top for top, r in zip(tops, reach, strict=True) if r <= border])
    fine = np.linalg.norm(inner[:, None] - outer[None], axis=2).min(axis=1)
    assert fine.min() == pytest.approx(0.7, abs=0.02)
    assert fine.max() < 0.85  # between samples of the outer border


@pytest.mark.slow
def test_corners_stay_corners():
    square = 6.0 * np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    points, marks = polygon_around(ball(), PLACES["inside"], square)
    state = with_detail(ball(), [points], [marks], kind="in", depth=1.0, draft=20.0)
    assert solved(state).detailed.details[0].problem == ""
    (shell,) = solved(state).detailed.changed
    places = np.array([shell.edges[t.edge].control_points[0] for t in shell.faces[-1].loops[0]])
    for corner in points[marks]:
        # The floor's corner is as far from both sides as the draft angle says.
        gap = np.linalg.norm(places - corner, axis=1).min()
        inset = np.tan(np.radians(20.0))
        assert gap == pytest.approx(np.hypot(np.sqrt(2.0) * inset, 1.0), rel=0.06)
    assert manifold(body(state).mesh).status() == manifold3d.Error.NoError


@pytest.mark.slow
def test_rings_in_rings_are_holes_and_islands():
    outer = loop_around(ball(), PLACES["inside"], 10.0)
    inner = loop_around(ball(), PLACES["inside"], 6.5)
    island = loop_around(ball(), PLACES["inside"], 3.0)
    before = manifold(body(with_detail(ball(), [outer], kind="split")).mesh).volume()
    # Triangles are a hundredth of a millimetre off, over 300 mm².

    def sunk(*rows):
        state = with_detail(ball(), list(rows), kind="in", depth=1.0, draft=0.0)
        assert solved(state).detailed.details[0].problem == ""
        return before - manifold(body(state).mesh).volume()

    disc = [sunk(row) for row in (outer, inner, island)]
    assert sunk(outer, inner[::-1]) == pytest.approx(disc[0] - disc[1], abs=4.0)
    assert sunk(island, inner, outer) == pytest.approx(disc[0] - disc[1] + disc[2], abs=4.0)


@pytest.mark.slow
def test_which_way_and_from_where_an_outline_runs_says_nothing():
    points = loop_around(ball(), PLACES["edge"], 7.0, (0.15, 0.1))
    volumes = [
        manifold(body(with_detail(ball(), [row], kind="in", depth=1.0)).mesh).volume()
        for row in (points, points[::-1], np.roll(points, 17, axis=0))
    ]
    assert np.ptp(volumes) < 1e-3 * (4.0 / 3.0 * np.pi * RADIUS**3 - volumes[0])


@pytest.mark.slow
def test_a_mirrored_detail_is_there_twice():
    points = loop_around(ball(), (25.0, 22.0, 22.0), 6.0, (0.1,))
    once = with_detail(ball(), [points], kind="in", depth=1.0)
    twice = with_detail(ball(), [points], kind="in", depth=1.0, mirrored=True)
    whole = manifold(body(with_detail(ball(), [points], kind="split")).mesh).volume()
    gone = [whole - manifold(body(state).mesh).volume() for state in (once, twice)]
    assert gone[1] == pytest.approx(2.0 * gone[0], rel=0.02)
    one, other = solved(twice).detailed.details
    assert np.allclose(one.outlines[0] * (1, -1, 1), other.outlines[0])


def test_details_follow_when_curves_are_bent():
    points = loop_around(ball(), PLACES["inside"], 7.0)
    state = with_detail(ball(), [points], kind="in", depth=1.0)
    nodes = tuple(
        replace(n, spline=replace(n.spline, control_points=1.25 * n.spline.control_points))
        if isinstance(n, Curve)
        else n
        for n in state.nodes
    )
    (detail,) = solved(replace(state, nodes=nodes)).detailed.details
    assert detail.problem == ""
    assert np.allclose(detail.outlines[0][:-1], 1.25 * points, atol=0.02)


def test_a_detail_without_its_surface_is_told_and_kept():
    points = loop_around(ball(), PLACES["inside"], 7.0)
    state = with_detail(ball(), [points], kind="in", depth=1.0)
    detail = state.of_kind(Detail)[0]
    gone = replace(
        state,
        nodes=tuple(
            n for n in state.nodes
            if not (isinstance(n, Patch) and n.id in detail.places.patches)
        ),
    )  # fmt: skip
    (told,) = solved(gone).detailed.details
    assert "gone" in told.problem
    assert gone.of_kind(Detail) == (detail,)
    assert any(detail.name in c.message for c in cautions_of(gone, solved(gone)))
    assert solved(state).detailed.details[0].problem == ""


def test_a_detail_goes_on_where_other_surfaces_took_the_place_of_its_own():
    points = loop_around(ball(), PLACES["inside"], 7.0)
    state = with_detail(ball(), [points], kind="split")
    nodes = tuple(
        replace(n, id=f"other {n.id}") if isinstance(n, Patch) else n for n in state.nodes
    )
    (one,) = solved(replace(state, nodes=nodes)).detailed.details
    assert one.problem == ""
    assert "beside" in one.told
    assert np.allclose(one.outlines[0][:-1], points, atol=1e-9)


@pytest.mark.slow
def test_two_details_lie_side_by_side_and_overlapping_ones_are_told():
    first = loop_around(ball(), (20.0, 20.0, 30.0), 5.0)
    state = with_detail(ball(), [first], kind="in", depth=1.0)
    beside = with_detail(state, [loop_around(ball(), (30.0, 22.0, 15.0), 4.0)], kind="raised")
    assert [d.problem for d in solved(beside).detailed.details] == ["", ""]
    assert manifold(body(beside).mesh).status() == manifold3d.Error.NoError
    over = with_detail(state, [loop_around(ball(), (23.0, 22.0, 27.0), 5.0)], kind="raised")
    problems = [d.problem for d in solved(over).detailed.details]
    assert problems[0] == ""
    assert "another detail" in problems[1]
    assert manifold(body(over).mesh).status() == manifold3d.Error.NoError


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"kind": "in", "depth": 200.0}, "thick"),
        ({"kind": "in", "depth": 6.0, "draft": 55.0}, "draft"),
        ({"kind": "button", "gap": 30.0, "depth": 1.0}, "gap"),
    ],
)
def test_what_cannot_be_is_told_with_what_to_do(values, words):
    points = loop_around(ball(), PLACES["inside"], 6.0)
    state = with_detail(ball(), [points], **values)
    (detail,) = solved(state).detailed.details
    assert words in detail.problem
    assert manifold(body(state).mesh).genus() == 0  # the body is there, without the detail
