"""Choosing, moving, turning, sizing and mirroring: there and back again is nothing."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Drag, Ink, Tap
from bozzetto.scene import Handle
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto.view.standard_views import standard_view
from bozzetto_silhouette.model.sketch_plane import Sheet
from bozzetto_silhouette.model.state import Group, Part, SilhouetteState
from bozzetto_silhouette.solids.placements import carried
from bozzetto_silhouette.tools.arrange import Arrange
from bozzetto_silhouette.tools.mirror import MirrorCopy
from bozzetto_silhouette.view.handles import grip_of, handles_layer
from bozzetto_silhouette.view.picking import shape_seen, touched_part
from tests.previews import preview_of

FRONT = Camera()
ARRANGE, MIRROR = Arrange(), MirrorCopy()
VIEWS = ["front", "right", "top", "three-quarter"]
KINDS = ["orthographic", "perspective"]


def part(number: int, x: float, y: float, radius: float, **options: object) -> Part:
    plain = Part(
        id=f"n{number}",
        name=f"Part {number}",
        strokes=Strokes((Pen(FRONT).circle(x, y, radius),)),
        blend=0.0,
    )
    return replace(plain, **options)


def two() -> SilhouetteState:
    state = SilhouetteState((part(1, 500, 450, 120), part(2, 760, 450, 80)))
    return replace(state, selected="n2")


def grouped() -> SilhouetteState:
    outer = Group(
        id="g1",
        pose=Placement((0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0), 1.2, (3.0, 4.0, 5.0)),
    )
    inner = Group(id="g2", within="g1", pose=Placement(offset=(-9.0, 2.0, 1.0)))
    nodes = (outer, inner, part(1, 500, 450, 120), part(2, 760, 450, 80, within="g2"))
    return SilhouetteState(nodes, selected="n2")


def handle_pixel(state: SilhouetteState, kind: str, camera: Camera) -> np.ndarray:
    layer = handles_layer(state)
    (item,) = [i for i in layer.items if isinstance(i, Handle) and i.id.startswith(kind)]
    return camera.project([item.point])[0][0]


def dragged(state, kind: str, camera: Camera, by, *, shift: bool = False) -> SilhouetteState:
    start = handle_pixel(state, kind, camera)
    path = Pen(camera).along([start, start + by])
    gesture = Drag(f"{kind}:{state.selected}", path, shift)
    return ARRANGE.apply(state, gesture, Context(camera=camera))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("make", [two, grouped])
def test_the_middle_follows_the_pen_and_comes_back(view: str, kind, make) -> None:
    camera = standard_view(Camera(kind, height=300.0), view)
    state = make()
    start = handle_pixel(state, "move", camera)
    there = dragged(state, "move", camera, (70.0, -40.0))
    assert handle_pixel(there, "move", camera) == pytest.approx(
        start + np.array([70.0, -40.0]), abs=0.01
    )
    depths = [camera.project([grip_of(s, s.node("n2")).middle])[1][0] for s in (state, there)]
    assert depths[0] == pytest.approx(depths[1], rel=1e-6)
    back = dragged(there, "move", camera, (-70.0, 40.0))
    assert carried(back, back.node("n2")).offset == pytest.approx(
        carried(state, state.node("n2")).offset, abs=1e-3
    )


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("make", [two, grouped])
def test_four_quarter_turns_are_none(view: str, make) -> None:
    camera = standard_view(FRONT, view)
    state = first = make()
    for _ in range(4):
        middle = handle_pixel(state, "move", camera)
        start = handle_pixel(state, "turn", camera)
        x, y = start - middle
        state = dragged(state, "turn", camera, middle + np.array([-y, x]) - start, shift=True)
    one, other = (carried(s, s.node("n2")) for s in (first, state))
    assert other.rotation == pytest.approx(one.rotation, abs=1e-9)
    assert other.offset == pytest.approx(one.offset, abs=1e-9)


def test_a_turn_goes_as_the_pen_goes() -> None:
    camera = Camera("orthographic", height=180.0)
    state = two()
    turned = dragged(state, "turn", camera, (0.0, -5.0))
    ring = [grip_of(s, s.node("n2")) for s in (state, turned)]
    seen = [camera.project([g.middle + g.radius * g.right])[0][0] for g in ring]
    assert seen[1][1] < seen[0][1]


def test_size_grows_with_the_pen_about_the_middle() -> None:
    state = two()
    middle, start = (handle_pixel(state, kind, FRONT) for kind in ("move", "size"))
    larger = dragged(state, "size", FRONT, 0.5 * (start - middle))
    assert larger.node("n2").pose.scale == pytest.approx(1.5, rel=1e-4)
    assert handle_pixel(larger, "move", FRONT) == pytest.approx(middle, abs=1e-3)
    smaller = dragged(larger, "size", FRONT, (start - middle) * -0.5)
    assert smaller.node("n2").pose.scale == pytest.approx(1.0, rel=1e-4)


def test_with_shift_it_moves_along_one_axis() -> None:
    camera = standard_view(FRONT, "three-quarter")
    for axis in range(3):
        way = camera.project([np.zeros(3), 20.0 * np.eye(3)[axis]])[0]
        moved = dragged(two(), "move", camera, way[1] - way[0] + (1.0, 1.0), shift=True)
        offset = np.abs(moved.node("n2").pose.offset)
        assert offset[axis] > 10.0
        assert np.delete(offset, axis) == pytest.approx([0.0, 0.0], abs=1e-9)


def test_thousands_of_drags_leave_a_rotation() -> None:
    state = two()
    random = np.random.default_rng(2)
    for step in range(600):
        kind = ("turn", "size", "move")[step % 3]
        camera = standard_view(FRONT, VIEWS[step % 4])
        with suppress(UserError):
            state = dragged(state, kind, camera, random.normal(0, 60, 2))
    pose = state.node("n2").pose
    rows = np.reshape(pose.rotation, (3, 3))
    assert np.abs(rows @ rows.T - np.eye(3)).max() < 1e-12
    assert 1e-3 <= pose.scale <= 1e3


def test_a_tap_chooses_what_is_under_it() -> None:
    state = replace(two(), selected="")
    for x, expected in ((500, "n1"), (760, "n2"), (60, "")):
        state = ARRANGE.apply(state, Tap(x, 450.0, FRONT), Context())
        assert state.selected == expected


def test_a_tap_on_an_empty_sheet_makes_no_object() -> None:
    with pytest.raises(UserError, match="nothing to arrange"):
        ARRANGE.apply(SilhouetteState(), Tap(500.0, 450.0, FRONT), Context())


def test_taps_go_from_the_group_inwards() -> None:
    state = replace(grouped(), selected="")
    middle = handle_pixel(grouped(), "move", FRONT)
    found = []
    for _ in range(4):
        state = ARRANGE.apply(state, Tap(*middle, FRONT), Context())
        found.append(state.selected)
    assert found == ["g1", "g2", "n2", "g1"]


def test_a_group_moves_as_one() -> None:
    state = replace(grouped(), selected="g1")
    before = shape_seen(state).body.bounds
    moved = dragged(state, "move", FRONT, (0.0, -50.0))
    rise = shape_seen(moved).body.bounds - before
    assert moved.nodes[1:] == state.nodes[1:]
    assert carried(moved, moved.node("n2")).offset != carried(state, state.node("n2")).offset
    assert np.abs(rise).max() > 5.0


def test_handles_are_there_only_for_what_is_chosen_and_seen() -> None:
    from bozzetto_silhouette.modeler import Silhouette

    def handles(state: SilhouetteState) -> list[str]:
        scene = Silhouette().scene(state, None)
        assert all(layer.tool == ARRANGE.id for layer in scene.layers if layer.name == "handles")
        return [item.id for _, item in scene.items() if isinstance(item, Handle)]

    state = two()
    assert handles(state) == ["move:n2", "turn:n2", "size:n2"]
    assert handles(replace(state, selected="")) == []
    assert handles(replace(state, posing=True)) == []
    assert handles(replace(state, selected="gone")) == []
    hidden = state.with_node(replace(state.node("n2"), visible=False))
    assert handles(hidden) == []


@pytest.mark.parametrize("view", VIEWS)
def test_handles_are_apart_from_every_side(view: str) -> None:
    camera = standard_view(FRONT, view)
    places = [handle_pixel(two(), kind, camera) for kind in ("move", "turn", "size")]
    for i in range(3):
        assert np.hypot(*(places[i] - places[i - 1])) > 25.0


@pytest.mark.parametrize(
    "gesture",
    [
        Drag("move:gone", Pen(FRONT).circle()),
        Drag("joint", Pen(FRONT).circle()),
        Drag("", Pen(FRONT).dot()),
        Ink((Pen(FRONT).circle(),)),
        Drag("move:n2", Stroke([0, 1e9], [0, -1e9], FRONT)),
        Drag("size:n2", Stroke([600, 1e9], [0, 1e9], FRONT)),
        Drag("turn:n2", Pen(Camera(eye=(0, 500, 0), target=(0, 900, 0))).circle()),
    ],
)
def test_odd_gestures_are_refused_in_words(gesture) -> None:
    state = two()
    preview_of(ARRANGE, state, gesture, Context())
    refused = ""
    try:
        state = ARRANGE.apply(state, gesture, Context())
    except UserError as refusal:
        refused = refusal.message
    assert refused == "" or refused.endswith(".")
    assert np.isfinite(state.node("n2").pose.offset).all()
    assert 1e-3 <= state.node("n2").pose.scale <= 1e3


def test_the_preview_is_what_comes_of_it() -> None:
    state = two()
    start = handle_pixel(state, "move", FRONT)
    gesture = Drag("move:n2", Pen(FRONT).along([start, start - (0.0, 120.0)]))
    layer, handles = preview_of(ARRANGE, state, gesture, Context()).layers
    assert layer.name == "shape"
    after = ARRANGE.apply(state, gesture, Context())
    moves = [item.point for item in handles.items if isinstance(item, Handle)]
    assert moves[0] == pytest.approx(grip_of(after, after.node("n2")).middle)
    expected = shape_seen(after).body.bounds
    assert layer.items[0].mesh.bounds == pytest.approx(expected, abs=0.5)


# -- mirror copies --


def beside(number: int, y: float, **options: object) -> Part:
    return part(number, 600, 300, 60, sheet=Sheet((0.0, y, 0.0)), **options)


def test_a_twin_is_the_mirror_image() -> None:
    ears = SilhouetteState((part(1, 600, 500, 200), beside(2, -40.0), part(3, 200, 800, 40)))
    state = MIRROR.apply(ears, Tap(600, 300, FRONT), Context())
    assert [node.name for node in state.nodes] == [
        "Part 1", "Part 2", "Part 2 mirrored", "Part 3",
    ]  # fmt: skip
    assert state.selected == state.nodes[2].id
    flip = np.array([1.0, -1.0, 1.0])
    one, twin = (shape_seen(SilhouetteState((node,))).body for node in state.nodes[1:3])
    assert twin.vertices * flip == pytest.approx(one.vertices, abs=1e-9)
    from bozzetto_silhouette.inflation.manifold_check import volume_of

    assert volume_of(twin.vertices, twin.faces) > 0.0
    # And back again.
    again = MIRROR.apply(replace(state, nodes=(state.nodes[2],)), Tap(600, 300, FRONT), Context())
    back = shape_seen(SilhouetteState((again.nodes[1],))).body
    assert back.vertices == pytest.approx(one.vertices, abs=1e-9)


def test_a_twin_in_a_group_is_mirrored_where_it_stands() -> None:
    state = grouped()
    middle = handle_pixel(state, "move", FRONT)
    plane = Context(symmetry_point=(1.0, 2.0, 3.0), symmetry_normal=(1.0, 1.0, 0.0))
    after = MIRROR.apply(state, Tap(*middle, FRONT), plane)
    twin = after.node(after.selected)
    one, other = (grip_of(after, n).middle for n in (state.node("n2"), twin))
    normal = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    assert np.cross(other - one, normal) == pytest.approx(np.zeros(3), abs=1e-6)
    assert ((one + other) / 2 - plane.symmetry_point) @ normal == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("depth", "shift", "flip"),
    [(0.0, False, (-1, 1, 1)), (0.0, True, (-1, 1, 1)), (-20.0, True, (-1, 1, 1))],
)
def test_what_was_drawn_from_the_front_has_a_left_and_a_right(depth, shift, flip) -> None:
    drawn = part(1, 300, 300, 80, pose=Placement(offset=(0.0, depth, 0.0)))
    tap = Tap(300, 300, FRONT, shift=shift)
    state = MIRROR.apply(SilhouetteState((drawn,)), tap, Context())
    one, twin = (shape_seen(SilhouetteState((node,))).body for node in state.nodes)
    assert twin.vertices == pytest.approx(one.vertices * flip, abs=1e-9)


def test_what_is_its_own_image_and_nothing_are_refused() -> None:
    state = SilhouetteState((part(1, 600, 450, 200),))
    with pytest.raises(UserError, match="its own mirror image"):
        MIRROR.apply(state, Tap(600, 450, FRONT), Context())
    with pytest.raises(UserError, match="no part here"):
        MIRROR.apply(state, Tap(10, 10, FRONT), Context())
    with pytest.raises(UserError, match="no part here"):
        MIRROR.apply(SilhouetteState(), Tap(10, 10, FRONT), Context())
    with pytest.raises(UserError, match=MIRROR.hint):
        MIRROR.apply(state, Ink((Pen(FRONT).circle(),)), Context())


def test_the_wall_of_a_tunnel_is_the_tunnel() -> None:
    from bozzetto_silhouette.tools.tunnel import DrawTunnel

    right = standard_view(FRONT, "right")
    ball = SilhouetteState((part(1, 600, 450, 220),))
    state = DrawTunnel().apply(
        ball, Ink((Pen(right).circle(600, 450, 80),), True), Context(camera=right)
    )
    aside = standard_view(FRONT, "three-quarter")
    pixels = np.stack(np.meshgrid(np.arange(450, 800, 12), np.arange(300, 620, 12)), -1)
    pixels = pixels.reshape(-1, 2).astype(float)
    points = shape_seen(state).under(pixels, aside).points
    away = np.linalg.norm(points, axis=1)
    from_axis = np.hypot(points[:, 1], points[:, 2])
    wall, skin = away < 0.9 * np.nanmax(away), from_axis > 45.0
    assert wall.sum() > 3
    assert skin.sum() > 50
    for which, name in ((wall, "Tunnel 1"), (skin, "Part 1")):
        found = {touched_part(state, x, y, aside).name for x, y in pixels[which]}
        assert found == {name}
