"""Drawn with its mirror image: what is beside, across and on the plane, holes, and the preview."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Ink
from bozzetto.testing import Pen
from bozzetto.view.standard_views import standard_view
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.solids.evaluate import tree_body
from bozzetto_silhouette.tools import DrawOutline
from bozzetto_silhouette.tools.cut import DrawCut
from bozzetto_silhouette.tools.tunnel import DrawTunnel
from tests.plugins.silhouette import bodies as b
from tests.previews import preview_of

PEN, TOOL, CONTEXT = Pen(), DrawOutline(), Context()
TUNNEL, CUT = DrawTunnel(), DrawCut()
BODY = PEN.circle(600, 450, 200)
EMPTY = SilhouetteState(mirrored=True)


def drawn(*strokes: Stroke, state: SilhouetteState = EMPTY) -> SilhouetteState:
    for stroke in strokes:
        state = TOOL.apply(state, Ink((stroke,), True), CONTEXT)
    return state


def assert_symmetric(state: SilhouetteState, axis: int) -> None:
    body = tree_body(state, 48)
    assert body is not None
    b.assert_sound(body)
    low, high = body.bounds
    assert low[axis] == pytest.approx(-high[axis], abs=0.02 * (high - low).max())
    here = body.vertices[body.vertices[:, axis] > 0.0].mean(axis=0)
    there = body.vertices[body.vertices[:, axis] < 0.0].mean(axis=0)
    there[axis] *= -1.0
    assert np.abs(here - there).max() < 0.03 * (high - low).max()


def test_what_is_beside_the_plane_gets_a_twin() -> None:
    state = drawn(BODY, PEN.circle(380, 450, 60))
    assert [part.name for part in state.parts] == ["Part 1", "Part 2", "Part 2 mirrored"]
    assert_symmetric(state, 0)


def test_what_crosses_the_plane_gets_one_and_what_lies_on_it_none() -> None:
    assert len(drawn(BODY).parts) == 1
    crossing = drawn(PEN.circle(640, 450, 100))
    assert len(crossing.parts) == 2
    assert_symmetric(crossing, 0)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("rx", "ry"), [(85.0, 70.0), (30.0, 26.0), (60.0, 150.0), (200.0, 90.0)])
def test_a_head_that_a_hand_draws_over_the_middle_is_one_part(
    rx: float, ry: float, seed: int
) -> None:
    """Round shapes have few corners in their meshes: their surfaces are compared, not these."""
    rng = np.random.default_rng(seed)
    turn = np.radians(np.linspace(90.0, 452.0, 160))  # the ends pass one another a little
    x = 600.0 + rng.uniform(-0.005, 0.005) * rx + rx * np.cos(turn) + rng.normal(0.0, 0.4, 160)
    y = 300.0 + ry * np.sin(turn) + rng.normal(0.0, 0.4, 160)
    state = drawn(Stroke(x, y, PEN.camera))
    assert [part.name for part in state.parts] == ["Part 1"]


def test_a_hole_has_its_image_in_the_same_part_or_in_the_twin() -> None:
    eyes = drawn(BODY, PEN.circle(530, 400, 30))
    assert [outline_of(part).genus for part in eyes.parts] == [2]
    ears = drawn(BODY, PEN.circle(340, 450, 90), PEN.circle(330, 450, 20))
    assert [outline_of(part).genus for part in ears.parts] == [0, 1, 1]
    assert_symmetric(ears, 0)
    assert outline_of(drawn(BODY, PEN.circle(610, 450, 40)).parts[0]).genus == 1


def test_from_the_side_the_image_lies_across_the_plane_of_symmetry() -> None:
    camera = standard_view(PEN.camera, "right")
    limb = Pen(camera).circle(760, 450, 60)
    state = TOOL.apply(EMPTY, Ink((limb,), True), Context(camera=camera))
    assert len(state.parts) == 2
    assert_symmetric(state, 1)


def test_tunnels_are_drawn_on_both_sides() -> None:
    body = drawn(BODY)
    eyes = TUNNEL.apply(body, Ink((PEN.circle(520, 400, 30),), True), CONTEXT)
    assert [part.name for part in eyes.parts] == ["Part 1", "Tunnel 1", "Tunnel 1 mirrored"]
    assert_symmetric(eyes, 0)
    middle = TUNNEL.apply(body, Ink((PEN.circle(600, 450, 30),), True), CONTEXT)
    assert len(middle.parts) == 2


def test_cuts_are_drawn_on_both_sides() -> None:
    line = PEN.along([(460, 200), (455, 450), (460, 700)])
    cheeks = CUT.apply(drawn(BODY), Ink((line,), True), CONTEXT)
    assert [part.name for part in cheeks.parts] == ["Part 1", "Cut 1", "Cut 1 mirrored"]
    assert_symmetric(cheeks, 0)


def test_pockets_from_the_side_are_on_both_sides_when_they_have_a_depth() -> None:
    camera = standard_view(PEN.camera, "right")
    ink = Ink((Pen(camera).circle(640, 450, 40),), True)
    one = TUNNEL.apply(drawn(BODY), ink, Context(camera=camera))
    assert len(one.parts) == 3
    assert_symmetric(one, 1)


def test_the_preview_of_a_tunnel_shows_both() -> None:
    ink = Ink((PEN.circle(520, 400, 30),))
    body = drawn(BODY)
    one, both = (preview_of(TUNNEL, replace(body, mirrored=on), ink, CONTEXT) for on in (0, 1))
    assert one.bounds()[1][0] < 0.0
    assert both.bounds()[1][0] == pytest.approx(-both.bounds()[0][0], rel=1e-5)


def test_switched_off_nothing_is_mirrored() -> None:
    assert len(drawn(PEN.circle(380, 450, 60), state=SilhouetteState()).parts) == 1


def test_the_preview_shows_both() -> None:
    ink = Ink((PEN.circle(380, 450, 60),))
    one, both = (
        preview_of(TOOL, replace(EMPTY, mirrored=on), ink, CONTEXT) for on in (False, True)
    )
    low, high = both.bounds()
    assert low[0] == pytest.approx(-high[0])
    assert len(both.layers[0].items) == 2 * len(one.layers[0].items)


@pytest.mark.parametrize("size", [0.0, 1.0, 2.5])
def test_a_dot_is_no_part(size: float) -> None:
    with pytest.raises(UserError, match="a dot"):
        drawn(PEN.circle(600, 450, size), state=SilhouetteState())
    assert len(drawn(PEN.circle(600, 450, 8.0), state=SilhouetteState()).parts) == 1
