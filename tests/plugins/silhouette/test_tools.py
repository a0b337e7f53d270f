"""What the pen can do: parts, holes, refusals, the eraser, and a preview that never fails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import Unfinished, UserError
from bozzetto.geometry import Placement
from bozzetto.ink import Stroke, Strokes
from bozzetto.ink.curves.closing import signed_area
from bozzetto.plugin import Context, Drag, Ink, Tap
from bozzetto.scene import Scene, Shaded
from bozzetto.scene.picking import cast_rays
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto.view.standard_views import standard_view
from bozzetto_silhouette.model.state import Cut, Group, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.solids.placements import drawn_rings
from bozzetto_silhouette.tools import DrawOutline, all_tools
from bozzetto_silhouette.tools.outline_edits import SketchOver
from tests.previews import preview_of

PEN, TOOL, CONTEXT = Pen(), DrawOutline(), Context()


def drawn(*gestures: tuple[Stroke, ...], state: SilhouetteState | None = None) -> SilhouetteState:
    state = state or SilhouetteState()
    for strokes in gestures:
        state = TOOL.apply(state, Ink(strokes, True), CONTEXT)
    return state


def topology(state: SilhouetteState) -> list[tuple[int, int]]:
    """Bodies and holes of every part."""
    return [(outline_of(p).components, outline_of(p).genus) for p in state.parts]


OUTER, HOLE = PEN.circle(600, 450, 300), PEN.circle(600, 450, 100)
LEFT, RIGHT = PEN.circle(500, 450, 60), PEN.circle(700, 450, 60)


@pytest.mark.parametrize(
    ("gestures", "expected"),
    [
        ([(OUTER,), (HOLE,)], [(1, 1)]),
        ([(HOLE,), (OUTER,)], [(1, 1)]),
        ([(OUTER, HOLE)], [(1, 1)]),
        ([(HOLE, OUTER)], [(1, 1)]),
        ([(OUTER,), (LEFT,), (RIGHT,)], [(1, 2)]),
        ([(LEFT,), (RIGHT,), (OUTER,)], [(1, 2)]),
        ([(LEFT,), (OUTER,), (RIGHT,)], [(1, 2)]),
        ([(LEFT, RIGHT, OUTER)], [(1, 2)]),
        ([(OUTER,), (LEFT, RIGHT)], [(1, 2)]),
        ([(LEFT,), (RIGHT,)], [(1, 0), (1, 0)]),
        ([(LEFT, RIGHT)], [(2, 0)]),
        ([(OUTER,), (PEN.circle(600, 450, 200),), (HOLE,)], [(1, 1), (1, 0)]),
        ([(PEN.circle(100, 100, 60),), (LEFT,), (OUTER,)], [(1, 0), (1, 1)]),
        ([(OUTER,), (PEN.circle(880, 450, 100),)], [(1, 0), (1, 0)]),
    ],
    ids=[
        "inside",
        "around",
        "one gesture",
        "one gesture, hole first",
        "two holes, one by one",
        "around two",
        "one before, one after",
        "one gesture, holes first",
        "two holes at once",
        "two parts",
        "two bodies at once",
        "an island in a hole",
        "others stay",
        "overlapping is another part",
    ],
)
def test_parts_and_holes(gestures, expected) -> None:
    state = drawn(*gestures)
    assert topology(state) == expected
    inked = sum(len(part.strokes) for part in state.parts)
    assert inked == sum(len(strokes) for strokes in gestures)


def test_outlines_on_other_sheets_are_no_holes() -> None:
    state = drawn((OUTER,))
    right = standard_view(Camera(), "right")
    state = TOOL.apply(state, Ink((Pen(right).circle(600, 450, 100),), True), Context(camera=right))
    assert topology(state) == [(1, 0), (1, 0)]


def test_a_hole_that_touches_its_outline_is_refused() -> None:
    with pytest.raises(UserError, match=r"outlines cross .*\.") as refusal:
        drawn((OUTER, PEN.circle(850, 450, 60)))
    places = np.array(refusal.value.places)
    # Where the two circles meet, in canvas pixels.
    assert np.hypot(*(places - [600, 450]).T) == pytest.approx(np.full(len(places), 300), abs=4)
    assert np.hypot(*(places - [850, 450]).T) == pytest.approx(np.full(len(places), 60), abs=4)


def _eight(camera: Camera, x: float, y: float) -> Stroke:
    """A figure eight that crosses itself at (x, y) and starts elsewhere."""
    angle = np.linspace(0.4, 2 * np.pi + 0.4, 300)
    return Pen(camera).along(
        np.column_stack([x + 250 * np.sin(angle), y + 250 * np.sin(angle) * np.cos(angle)])
    )


@pytest.mark.parametrize("view", ["front", "right", "top", "three-quarter"])
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_a_crossing_is_shown_where_it_was_drawn(view: str, kind) -> None:
    camera = standard_view(Camera(kind), view)
    with pytest.raises(UserError, match="crosses itself") as refusal:
        TOOL.apply(SilhouetteState(), Ink((_eight(camera, 640.0, 380.0),), True), CONTEXT)
    places = np.array(refusal.value.places)
    assert np.hypot(*(places - [640.0, 380.0]).T).min() < 8.0


ARC = PEN.along(
    np.array([600, 450]) + 200 * np.stack([np.cos(a := np.linspace(0, 4.2, 90)), np.sin(a)], axis=1)
)
REST = PEN.along(
    np.array([600, 450]) + 200 * np.stack([np.cos(a := np.linspace(4.2, 6.2, 60)), np.sin(a)], 1)
)


def test_an_open_stroke_waits_until_it_is_said_to_be_all() -> None:
    with pytest.raises(Unfinished) as waiting:
        TOOL.apply(SilhouetteState(), Ink((ARC,), False), CONTEXT)
    assert waiting.value.hint.endswith(".")
    assert topology(drawn((ARC,))) == [(1, 0)]


def test_several_strokes_make_one_outline() -> None:
    state = TOOL.apply(SilhouetteState(), Ink((ARC, REST), False), CONTEXT)
    assert topology(state) == [(1, 0)]
    whole = drawn((PEN.circle(600, 450, 200),))
    assert outline_of(state.parts[0]).area == pytest.approx(
        outline_of(whole.parts[0]).area, rel=0.01
    )


def test_the_eraser_takes_the_part_under_it() -> None:
    state = drawn((LEFT,), (RIGHT,))
    rub = PEN.but(tool="eraser")
    left = TOOL.apply(state, Ink((rub.along([(670, 430), (730, 470)]),)), CONTEXT)
    assert left.parts == state.parts[:1]
    with pytest.raises(UserError, match="no part under the eraser"):
        TOOL.apply(state, Ink((rub.along([(50, 50), (90, 60)]),)), CONTEXT)
    assert TOOL.apply(left, Ink((rub.dot(500, 450),)), CONTEXT).parts == ()
    # Of two parts that lie over each other the newer one goes.
    both = drawn((OUTER,), (PEN.circle(800, 450, 150),))
    assert TOOL.apply(both, Ink((rub.dot(830, 450),)), CONTEXT).parts == both.parts[:1]


@pytest.mark.parametrize(
    "tool",
    [one for one in all_tools() if one.id not in ("paint", "brush")],
    ids=lambda tool: tool.id,
)
def test_the_eraser_does_the_same_with_every_tool(tool) -> None:
    """But with paint, of which it takes the colour away, and with the brush."""
    state = drawn((LEFT,), (RIGHT,))
    over = Ink((PEN.but(tool="eraser").along([(670, 430), (730, 470)]),))
    assert tool.apply(state, over, CONTEXT).parts == state.parts[:1]


def test_the_eraser_takes_a_part_from_any_side() -> None:
    side = Camera("orthographic", (500.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert not TOOL.apply(drawn((OUTER,)), Ink((Pen(side, tool="eraser").dot(),)), CONTEXT).parts
    with pytest.raises(UserError, match="no part under the eraser"):
        TOOL.apply(drawn((OUTER,)), Ink((Pen(side, tool="eraser").dot(20, 20),)), CONTEXT)


def test_the_eraser_fills_the_hole_under_it_and_spares_what_is_switched_off() -> None:
    state = drawn((OUTER,), (LEFT,), (RIGHT,))
    rub = PEN.but(tool="eraser")
    filled = TOOL.apply(state, Ink((rub.dot(500, 450),)), CONTEXT)
    assert topology(filled) == [(1, 1)]
    assert filled.parts[0].strokes == state.parts[0].strokes
    # Of two holes the other one is left.
    assert TOOL.apply(filled, Ink((rub.dot(500, 450),)), CONTEXT).parts == ()
    assert topology(TOOL.apply(filled, Ink((rub.dot(700, 450),)), CONTEXT)) == [(1, 0)]
    hidden = state.with_node(replace(state.parts[0], visible=False))
    with pytest.raises(UserError, match="no part under the eraser"):
        TOOL.apply(hidden, Ink((rub.dot(600, 300),)), CONTEXT)


def test_a_cut_is_erased_along_its_line_and_takes_no_other_ink() -> None:
    state = drawn((OUTER,))
    line = PEN.along([(200, 450), (1000, 470)])
    cut = Cut(id="c", name="Cut", strokes=Strokes([line]), operation="carve", surface="straight")
    state = replace(state, nodes=(*state.nodes, cut))
    rub = PEN.but(tool="eraser")
    gone = TOOL.apply(state, Ink((rub.along([(500, 456), (700, 462)]),)), CONTEXT)
    assert [node.id for node in gone.nodes] == ["n1"]
    # Across the cut's line it is the part that is rubbed.
    assert TOOL.apply(state, Ink((rub.along([(600, 300), (600, 500)]),)), CONTEXT).nodes == (cut,)
    with pytest.raises(UserError, match="no outline"):
        SketchOver().apply(state, Ink((PEN.along([(560, 457), (600, 400), (640, 457)]),)), CONTEXT)


def test_a_hole_is_drawn_into_a_part_where_it_stands_now() -> None:
    """Moved, turned over and in a group that was moved: the hole is where the pen was."""
    state = drawn((PEN.circle(300, 300, 150),))
    mirror = Placement((-1.0, 0, 0, 0, 1, 0, 0, 0, 1), 1.0, (0.0, 0.0, 0.0))
    group = Group(id="g", name="G", pose=Placement(offset=(10.0, 0.0, -15.0)))
    state = replace(state, nodes=(group, replace(state.parts[0], pose=mirror, within="g")))
    ring = drawn_rings(state, state.parts[0])[0]
    pixels, _ = Camera().project(ring)
    x, y = pixels.mean(axis=0)
    after = TOOL.apply(state, Ink((PEN.circle(x + 40, y, 50),), True), CONTEXT)
    assert topology(after) == [(1, 1)]
    hole, _ = Camera().project(drawn_rings(after, after.parts[0])[1])
    assert hole.mean(axis=0) == pytest.approx([x + 40, y], abs=0.5)
    # Where it was drawn there is nothing any more: this is another part.
    assert topology(TOOL.apply(state, Ink((PEN.circle(300, 300, 50),), True), CONTEXT)) == [
        (1, 0),
        (1, 0),
    ]


def test_edits_find_their_rings_when_parts_become_holes() -> None:
    """Two drawn over, then an outline around them: the holes have the shapes they had."""
    state = drawn((LEFT,), (RIGHT,))
    bump = PEN.along([(480, 395), (500, 360), (520, 395)])
    state = SketchOver().apply(state, Ink((bump,), True), CONTEXT)
    bump = PEN.along([(680, 505), (700, 545), (720, 505)])
    state = SketchOver().apply(state, Ink((bump,), True), CONTEXT)
    areas = sorted(outline_of(part).area for part in state.parts)
    around = drawn((OUTER,), state=state)
    assert topology(around) == [(1, 2)]
    rings = outline_of(around.parts[0]).rings
    assert sorted(-signed_area(ring) for ring in rings[1:]) == pytest.approx(areas, rel=1e-3)


@pytest.mark.parametrize("gesture", [Tap(5.0, 5.0, Camera()), Drag("x", ARC)])
def test_other_gestures_are_refused(gesture) -> None:
    with pytest.raises(UserError, match=TOOL.hint):
        TOOL.apply(SilhouetteState(), gesture, CONTEXT)
    assert not preview_of(TOOL, SilhouetteState(), gesture, CONTEXT).layers


def _odd() -> list[Stroke]:
    random = np.random.default_rng(11)
    edge_on = Camera("orthographic", (0.0, -1e-3, 1000.0), (0.0, 0.0, 0.0))
    lines = [
        [(5, 5)],
        [(5, 5), (5, 5)],
        [(0, 0), (1, 1)],
        [(0, 0), (500, 500), (1000, 1000)],
        [(1e6, 0), (0, 1e6), (-1e6, -1e6)],
        [(1e9, 1e9), (-1e9, 0), (0, -1e9)],
        [(1e-30, 0), (0, 1e-30), (1e-30, 1e-30)],
        [(0, 0), (1e-3, 0), (0, 1e9)],
        np.tile([(10, 10), (500, 300), (90, 400)], (50, 1)),
        random.normal(600, 200, (300, 2)),
        random.normal(0, 30, (400, 2)).cumsum(axis=0),
    ]
    strokes = [Stroke(*np.array(line, float).T, Camera()) for line in lines]
    strokes += [Pen(edge_on).circle(), PEN.but(tool="eraser").circle(), _eight(Camera(), 500, 400)]
    behind = Camera("perspective", (0.0, -1.0, 0.0), (0.0, -2.0, 0.0), fov_y=179.0)
    return [*strokes, Pen(behind).circle(600, 450, 5e4)]


@pytest.mark.parametrize("number", range(len(_odd())))
def test_preview_never_raises_and_apply_only_in_words(number: int) -> None:
    stroke = _odd()[number]
    for state in (SilhouetteState(), drawn((OUTER, HOLE))):
        for strokes in ((stroke,), (OUTER, stroke), (stroke, OUTER)):
            scene = preview_of(TOOL, state, Ink(strokes), CONTEXT)
            for _, item in scene.items():
                assert np.isfinite(item.mesh.vertices).all()
            assert _answer(state, strokes).endswith(".")


def _answer(state: SilhouetteState, strokes: tuple[Stroke, ...]) -> str:
    try:
        TOOL.apply(state, Ink(strokes, True), CONTEXT)
    except UserError as refusal:
        return refusal.message
    return "Taken."


def test_a_scribble_is_refused_at_once_with_few_places() -> None:
    # Rubbed fifty times around a triangle: thousands of edges lie over each other.
    corners = np.tile([(100.0, 100.0), (500.0, 300.0), (190.0, 700.0)], (50, 1))
    with pytest.raises(UserError, match="crosses itself") as refusal:
        drawn((Stroke(*corners.T, Camera()),))
    assert 1 <= len(refusal.value.places) <= 8


def _shaded(scene):
    return [item for _, item in scene.items() if isinstance(item, Shaded)]


def _covers(scene, place) -> bool:
    """Whether a line of sight through a place of the canvas meets what is previewed."""
    visible = Scene(
        tuple(
            replace(layer, items=tuple(replace(item, pickable=True) for item in layer.items))
            for layer in scene.layers
        )
    )
    return bool(cast_rays(visible, CONTEXT.camera.rays([place])).hit[0])


def test_an_outline_inside_a_shape_is_previewed_as_the_hole_that_it_becomes() -> None:
    body = drawn((PEN.circle(600, 450, 200),))
    ink = PEN.circle(600, 450, 60)
    assert len(drawn((ink,), state=body).parts) == 1  # a hole
    shown = preview_of(TOOL, body, Ink((ink,)), CONTEXT)
    assert shown.layers
    assert not _shaded(shown)  # no shape comes
    points = np.concatenate([item.points for _, item in shown.items()])
    assert np.ptp(points[:, 1]) > 20.0  # from where it goes in to where it comes out
    seen, _ = CONTEXT.camera.project(points)
    assert np.hypot(*(seen - (600.0, 450.0)).T) == pytest.approx(60.0, rel=0.05)
    # What stays apart is a shape, as is what lies beside.
    for state, where in ((replace(body, inner="apart"), 600), (body, 1000)):
        aside = PEN.circle(where, 450, 60)
        assert len(drawn((aside,), state=state).parts) == 2
        assert _shaded(preview_of(TOOL, state, Ink((aside,)), CONTEXT))


def test_an_outline_around_a_shape_is_previewed_with_its_hole() -> None:
    inner = drawn((PEN.circle(600, 450, 60),))
    around = Ink((PEN.circle(600, 450, 200),))
    assert len(drawn(around.strokes, state=inner).parts) == 1
    shown = preview_of(TOOL, inner, around, CONTEXT)
    assert _covers(shown, (740.0, 450.0))
    assert not _covers(shown, (600.0, 450.0))
    assert _covers(preview_of(TOOL, replace(inner, inner="apart"), around, CONTEXT), (600.0, 450.0))
    beside = Ink((PEN.circle(1000, 450, 100),))
    assert _covers(preview_of(TOOL, inner, beside, CONTEXT), (1000.0, 450.0))


def test_preview_swells_towards_the_hand() -> None:
    (item,) = [i for _, i in preview_of(TOOL, SilhouetteState(), Ink((ARC,)), CONTEXT).items()]
    assert item.mesh.vertices[:, 1].min() < -20.0 < 20.0 < item.mesh.vertices[:, 1].max()
    assert not item.pickable
    eraser = Ink((PEN.but(tool="eraser").circle(),))
    assert not preview_of(TOOL, SilhouetteState(), eraser, CONTEXT).layers
