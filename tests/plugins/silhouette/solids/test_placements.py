"""Where parts are: moved, in groups, mirrored, hidden."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Placement
from bozzetto.ink import Strokes
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto.view.standard_views import standard_view
from bozzetto_silhouette.model.state import Group, Part, SilhouetteState
from bozzetto_silhouette.solids.evaluate import tree_body
from bozzetto_silhouette.solids.placements import (
    carried,
    distances_under,
    drawn_rings,
    is_shown,
    on_sheet,
    placement_of,
    shown_parts,
    stroke_in,
)

TURN = Placement((0.0, -1.0, 0, 1.0, 0, 0, 0, 0, 1.0), 2.0, (10.0, -5.0, 3.0))
MIRROR = Placement((-1.0, 0, 0, 0, 1, 0, 0, 0, 1), 0.5, (4.0, 0.0, 0.0))
AWAY = Placement(offset=(0.0, 20.0, 40.0))

PART = Part(id="p", strokes=Strokes([Pen().circle(500, 400, 120)]), pose=TURN, within="inner")
INNER = Group(id="inner", within="outer", pose=MIRROR)
OUTER = Group(id="outer", pose=AWAY)
STATE = SilhouetteState(nodes=(OUTER, INNER, PART), selected="p")


def test_poses_add_up_from_the_part_outwards() -> None:
    points = np.random.default_rng(1).normal(size=(5, 3))
    expected = AWAY.points(MIRROR.points(TURN.points(points)))
    assert carried(STATE, PART).points(points) == pytest.approx(expected)
    assert carried(STATE, OUTER) == AWAY


def test_rings_lie_on_the_shape_that_is_shown() -> None:
    """An oracle of another room: the body of the whole tree."""
    body = tree_body(STATE, 48)
    assert body is not None
    (ring,) = drawn_rings(STATE, PART)
    for ring_end, body_end in zip((ring.min(0), ring.max(0)), body.bounds, strict=True):
        # The outline spans the shape in two of three directions; the third is its depth.
        assert np.sort(np.abs(ring_end - body_end))[:2] == pytest.approx([0.0, 0.0], abs=0.3)


@pytest.mark.parametrize("view", ["front", "right", "top", "three-quarter"])
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_a_stroke_on_the_sheet_is_under_the_pen(view: str, kind) -> None:
    camera = standard_view(Camera(kind), view)
    state = replace(STATE, nodes=(OUTER, INNER, replace(PART, pose=TURN.after(TURN))))
    part = state.parts[0]
    stroke = Pen(camera).along([(300, 300), (700, 450), (800, 700)])
    flat = on_sheet(state, part, stroke)
    if not np.isfinite(flat).all():
        pytest.skip("the sheet lies edge-on in this view")
    world = placement_of(state, part).points(np.column_stack([flat, np.zeros(len(flat))]))
    seen, _ = camera.project(world)
    assert seen == pytest.approx(stroke.points, abs=0.05)
    assert len(stroke_in(state, part, stroke)) == len(stroke)


def test_the_distance_under_the_pen_is_that_of_the_ball() -> None:
    """A circle is a ball: the line of sight meets it where a quadratic equation says."""
    group = Group(id="g", pose=Placement(scale=1.5, offset=(20.0, -60.0, 10.0)))
    part = replace(PART, within="g", pose=MIRROR)
    state = SilhouetteState(nodes=(group, part))
    ring = drawn_rings(state, part)[0]
    centre, radius = ring.mean(axis=0), np.ptp(ring[:, 0]) / 2
    camera = standard_view(Camera(), "three-quarter")
    (middle,), _ = camera.project(centre[None])
    pixels = middle + np.array([(0, 0), (10, -15), (-25, 8), (500, 0)])
    origins, directions = camera.rays(pixels)
    b = ((origins - centre) * directions).sum(axis=1)
    c = ((origins - centre) ** 2).sum(axis=1) - radius**2
    found = distances_under(state, part, pixels, camera)
    assert found[:3] == pytest.approx((-b - np.sqrt(np.maximum(b * b - c, 0)))[:3], rel=2e-3)
    assert np.isinf(found[3])


def test_what_is_switched_off_is_not_shown() -> None:
    assert shown_parts(STATE) == (PART,)
    for hidden in STATE.nodes:
        state = replace(
            STATE,
            nodes=tuple(replace(n, visible=n is not hidden) for n in STATE.nodes),
        )
        assert not is_shown(state, state.node("p"))


def test_groups_that_go_round_in_a_ring_end() -> None:
    ring = (replace(OUTER, within="inner"), INNER, PART)
    state = replace(STATE, nodes=ring)
    assert is_shown(state, PART)
    assert carried(state, PART).scale == pytest.approx(1.0)
