"""Extrusions: what grows out of a ring fits the ring, is rooted, and is refused in words."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import Unfinished, UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Drag, Ink, Tap
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto.view.standard_views import standard_view
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.solids.part_solid import body_of
from bozzetto_silhouette.tools.extrude import Extrude
from bozzetto_silhouette.view.picking import shape_seen
from tests.plugins.silhouette.bodies import solid
from tests.previews import preview_of

FRONT = Camera()
RIGHT, TOP = standard_view(FRONT, "right"), standard_view(FRONT, "top")
EXTRUDE = Extrude()
RADIUS = 70.0


def ball() -> SilhouetteState:
    pixels = 200.0 * FRONT.pixels_per_mm / Camera().pixels_per_mm
    part = Part(id="n1", name="Part 1", strokes=Strokes((Pen(FRONT).circle(600, 450, pixels),)))
    return SilhouetteState().with_node(part)


RING = Pen(FRONT).circle(600, 450, 60)


def side_view(points, camera: Camera = RIGHT) -> Stroke:
    """A stroke through places (towards the front, up) in mm, as seen from a side."""
    line = np.asarray(points, float)
    axis = camera.axes[1] if camera is RIGHT else camera.axes[0]
    world = np.outer(line[:, 0], [0.0, -1.0, 0.0]) + np.outer(line[:, 1], axis)
    return Pen(camera).along(camera.project(world)[0])


def nose(tip: float = 110.0, camera: Camera = RIGHT) -> Stroke:
    angle = np.linspace(np.pi / 2, -np.pi / 2, 40)
    round_end = np.column_stack([tip - 15.0 + 15.0 * np.cos(angle), 15.0 * np.sin(angle)])
    return side_view([(64.0, 17.0), *round_end, (64.0, -17.0)], camera)


def grown(state: SilhouetteState, *strokes: Stroke) -> SilhouetteState:
    return EXTRUDE.apply(state, Ink(strokes, True), Context(camera=strokes[-1].camera))


@pytest.mark.parametrize("camera", [RIGHT, TOP], ids=["right", "top"])
def test_a_nose_grows_out_of_the_ring(camera: Camera) -> None:
    state = grown(ball(), RING, nose(camera=camera))
    made = solid(state)
    assert made.genus() == 0
    assert len(made.decompose()) == 1
    assert made.volume() > solid(ball()).volume()
    part = state.parts[1]
    assert (part.operation, part.blend) == ("add", Part().blend)
    assert made.bounding_box()[1] == pytest.approx(-110.0, abs=0.5)
    # Where it stands on the ball it is as deep as the ring is across the view.
    ring_width = 2 * 60.0 / FRONT.pixels_per_mm * 437.0 / 500.0
    vertices = body_of(part, 64).vertices
    along, across = (1, 0) if camera is RIGHT else (1, 2)
    at_base = np.abs(vertices[:, along] + 66.0) < 3.0
    assert np.ptp(vertices[at_base, across]) == pytest.approx(ring_width, rel=0.15)


def test_the_drawn_line_stays_the_outline() -> None:
    part = grown(ball(), RING, nose()).parts[1]
    outline = outline_of(part)
    from shapely import Point

    shape = outline.polygon().boundary
    drawn = part.sheet.from_pixels(part.strokes[0].points, part.strokes[0].camera)
    assert max(shape.distance(Point(p)) for p in drawn[2:-2]) < 0.5
    # The root lies well inside the ball.
    root = part.sheet.to_world(
        part.sheet.from_pixels(part.strokes[1].points, part.strokes[1].camera)
    )
    assert np.linalg.norm(root, axis=1).max() < RADIUS
    assert np.linalg.norm(root, axis=1).min() > 0.25 * RADIUS


def test_the_hand_may_come_from_either_side() -> None:
    stroke = nose()
    back = Stroke(stroke.x[::-1], stroke.y[::-1], stroke.camera)
    one, other = (solid(grown(ball(), RING, s)).volume() for s in (stroke, back))
    assert one == pytest.approx(other, rel=1e-3)


def test_a_stroke_into_the_shape_makes_a_dent() -> None:
    inwards = side_view([(64.0, 17.0), (45.0, 14.0), (35.0, 0.0), (45.0, -14.0), (64.0, -17.0)])
    state = grown(ball(), RING, inwards)
    assert state.parts[1].operation == "carve"
    made = solid(state)
    assert made.genus() == 0
    assert len(made.decompose()) == 1
    assert made.volume() < solid(ball()).volume()
    hits = shape_seen(state).under([(600, 450)], FRONT)
    assert hits.points[0, 1] == pytest.approx(-35.0, abs=1.5)


def test_after_the_ring_it_waits() -> None:
    with pytest.raises(Unfinished, match="what grows out of it"):
        EXTRUDE.apply(ball(), Ink((RING,)), Context())
    with pytest.raises(UserError, match="what grows out of it"):
        EXTRUDE.apply(ball(), Ink((RING,), True), Context())


SCRIBBLE = Stroke(*np.random.default_rng(8).normal((600, 450), 30, (120, 2)).T, FRONT)


@pytest.mark.parametrize(
    ("strokes", "words"),
    [
        ((Pen(FRONT).dot(),), "ring"),
        ((Pen(FRONT).along([(500, 450), (700, 450)]),), "ring"),
        ((Pen(FRONT).circle(100, 100, 50),), "beside the shape"),
        ((RING, nose(), nose()), "Two strokes"),
        ((RING, Pen(FRONT).along([(560, 450), (600, 300), (640, 450)])), "face on"),
        ((RING, side_view([(150, 60), (200, 0), (150, -60)])), "start and end at the ring"),
        ((RING, Pen(RIGHT).dot()), r"Begin on one side"),
        ((RING, side_view([(64, 17), (110, 5), (110, -5), (64, 16)])), "at one place"),
        ((RING, side_view([(64, 17), (64, -17)])), "neither out nor in"),
        ((RING, side_view([(64, 17), (120, -20), (120, 20), (64, -17)])), "crosses itself"),
        ((RING, Pen(Camera(eye=(500, -900, 0), target=(500, -1900, 0))).circle()), "."),
        ((SCRIBBLE, nose()), "."),
    ],
    ids=[
        "dot", "line", "beside", "three", "face on", "away", "second dot", "closed",
        "flat", "crosses itself", "behind", "scribble",
    ],
)  # fmt: skip
def test_refused(strokes, words: str) -> None:
    with pytest.raises(UserError, match=words) as refusal:
        grown(ball(), *strokes)
    assert refusal.value.message.endswith(".")


def test_nothing_to_grow_from() -> None:
    with pytest.raises(UserError, match="Draw a shape first"):
        grown(SilhouetteState(), RING, nose())


@pytest.mark.parametrize("gesture", [Tap(600, 450, FRONT), Drag("x", RING)])
def test_other_gestures_are_refused(gesture) -> None:
    with pytest.raises(UserError, match=EXTRUDE.hint):
        EXTRUDE.apply(ball(), gesture, Context())
    assert not preview_of(EXTRUDE, ball(), gesture, Context()).layers
