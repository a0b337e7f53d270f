"""Tunnels and cuts by pen: what falls away, what is left, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import Unfinished, UserError
from bozzetto.geometry import Placement
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Drag, Ink, Tap
from bozzetto.scene import Lines, Shaded
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto.view.standard_views import standard_view
from bozzetto_silhouette.model.state import Cut, Group, Part, SilhouetteState
from bozzetto_silhouette.tools.arrange import Arrange, after_motion
from bozzetto_silhouette.tools.cut import DrawCut
from bozzetto_silhouette.tools.draw_outline import DrawOutline
from bozzetto_silhouette.tools.extrude import Extrude
from bozzetto_silhouette.tools.tunnel import DrawTunnel
from bozzetto_silhouette.view.drag_motion import mirrored
from bozzetto_silhouette.view.handles import depth_grip
from bozzetto_silhouette.view.picking import shape_seen
from tests.plugins.silhouette.bodies import solid
from tests.previews import preview_of

FRONT = Camera()
ARRANGE, TUNNEL, CUT = Arrange(), DrawTunnel(), DrawCut()


def ball(radius: float = 220.0) -> SilhouetteState:
    part = Part(id="n1", name="Part 1", strokes=Strokes((Pen(FRONT).circle(600, 450, radius),)))
    return SilhouetteState().with_node(part)


def applied(tool, state: SilhouetteState, *strokes: Stroke) -> SilhouetteState:
    return tool.apply(state, Ink(strokes, True), Context(camera=strokes[0].camera))


@pytest.mark.parametrize("kind", ["orthographic", "perspective"])
@pytest.mark.parametrize("view", ["front", "right", "top", "three-quarter"])
def test_a_tunnel_from_any_side_is_one_more_handle(view: str, kind) -> None:
    camera = standard_view(Camera(kind), view)
    state = applied(TUNNEL, ball(), Pen(camera).circle(600, 450, 60))
    assert solid(state).genus() == 1
    tunnel = state.parts[1]
    assert (tunnel.surface, tunnel.operation, tunnel.blend) == ("straight", "carve", 0.0)
    # One looks through it: no line of sight inside the outline meets the shape.
    turn = np.linspace(0, 2 * np.pi, 40)
    around = np.column_stack([600 + 57 * np.cos(turn), 450 + 57 * np.sin(turn)])
    seen = shape_seen(state)
    assert not seen.under(np.vstack([around, [(600, 450)]]), camera).hit.any()
    beside = np.column_stack([600 + 63 * np.cos(turn), 450 + 63 * np.sin(turn)])
    assert seen.under(beside, camera).hit.all()


def test_two_tunnels_that_meet_are_three_handles() -> None:
    state = applied(TUNNEL, ball(), Pen(standard_view(FRONT, "right")).circle(600, 450, 60))
    assert solid(applied(TUNNEL, state, Pen(FRONT).circle(600, 450, 40))).genus() == 3


@pytest.mark.parametrize("view", ["front", "right", "three-quarter"])
def test_the_smaller_side_falls_away_and_the_other_can_be_had(view: str) -> None:
    camera = standard_view(FRONT, view)
    whole = solid(ball()).volume()
    for line in ([(200, 350), (1000, 350)], [(1000, 550), (200, 550)], [(700, 100), (690, 800)]):
        state = applied(CUT, ball(), Pen(camera).along(line))
        left = solid(state).volume()
        cut = state.parts[1]
        assert isinstance(cut, Cut)
        other = state.with_node(replace(cut, side="left" if cut.side == "right" else "right"))
        assert left > solid(other).volume()
        assert left + solid(other).volume() == pytest.approx(whole, rel=1e-6)


def test_a_cut_face_is_as_large_as_the_section() -> None:
    camera = Camera("orthographic", height=180.0)
    made = solid(applied(CUT, ball(), Pen(camera).along([(100, 450), (1100, 450)])))
    mesh = made.to_mesh64()
    corners = np.asarray(mesh.vert_properties)[:, :3][np.asarray(mesh.tri_verts)]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2.0
    flat = np.abs(corners[:, :, 2]).max(axis=1) < 1e-4
    section = solid(ball()).slice(0.0).area()
    assert np.abs(normal[flat, 2]).sum() == pytest.approx(section, rel=1e-4)


def test_a_narrow_slot_is_a_cut() -> None:
    slot = PEN.along([(580, 100), (580, 500), (620, 500), (620, 100)])
    state = applied(CUT, ball(), slot)
    assert solid(state).genus() == 0
    assert 0.8 < solid(state).volume() / solid(ball()).volume() < 1.0


@pytest.mark.parametrize("tool", [TUNNEL, CUT, Extrude()], ids=["tunnel", "cut", "extrude"])
def test_the_other_end_of_the_pen_takes_away_what_was_cut(tool) -> None:
    camera = standard_view(FRONT, "right")
    holed = applied(TUNNEL, ball(), Pen(camera).circle(600, 450, 60))
    rubbed = Pen(camera).but(tool="eraser").along([(570, 430), (630, 470)])
    assert not preview_of(tool, holed, Ink((rubbed,)), Context()).layers
    assert applied(tool, holed, rubbed).parts == ball().parts


@pytest.mark.parametrize("tool", [TUNNEL, CUT, Extrude()], ids=["tunnel", "cut", "extrude"])
def test_what_is_cut_moves_with_the_group_of_what_it_cuts(tool) -> None:
    """The shape is that of a tree without groups, and no other part is cut once they move."""
    group = Group(id="g", name="Group", pose=Placement(offset=(3.0, 0.0, -2.0)))
    beside = Part(id="n2", name="Beside", strokes=Strokes((PEN.circle(150, 450, 80),)), blend=0.0)
    flat = ball().with_node(beside)
    (one, other) = flat.parts
    inner = replace(one, within="g", pose=group.pose.inverse())
    grouped = SilhouetteState((group, inner, other))
    ring = PEN.circle(600, 450, 60)
    side = Pen(standard_view(FRONT, "top"))
    strokes = {
        TUNNEL.id: (ring,),
        CUT.id: (PEN.along([(700, 100), (690, 800)]),),
    }.get(tool.id, (ring, side.along([(560, 640), (570, 780), (630, 780), (640, 640)])))
    wanted = solid(applied(tool, flat, *strokes)).volume()
    found = applied(tool, grouped, *strokes)
    assert found.nodes[-1].within == "g"
    assert solid(found).volume() == pytest.approx(wanted, rel=1e-5)
    apart = Placement(offset=(0.0, 500.0, 0.0))
    moved = replace(found, nodes=(replace(group, pose=apart), *found.nodes[1:]))
    assert solid(moved).volume() == pytest.approx(wanted, rel=1e-5)


def test_a_cut_across_two_groups_belongs_to_neither() -> None:
    """One that would only cut the part under the line, if it were in its group."""
    group = Group(id="g", name="Group")
    below = Part(id="n2", name="Below", strokes=Strokes((PEN.circle(600, 800, 60),)), blend=0.0)
    inner = replace(ball().parts[0], within="g")
    line = PEN.along([(200, 600), (1000, 600)])
    found = applied(CUT, SilhouetteState((group, inner, below)), line)
    assert found.nodes[-1].within == ""
    assert len(solid(found).decompose()) == 1


def test_previews_show_what_would_go() -> None:
    line = PEN.along([(200, 350), (1000, 350)])
    shown = preview_of(CUT, ball(), Ink((line,)), Context())
    (tint,) = (item for _, item in shown.items() if isinstance(item, Shaded))
    # The smaller side lies above the line.
    seen, _ = FRONT.project(tint.mesh.vertices[tint.mesh.faces].mean(axis=1))
    assert 340.0 < seen[:, 1].max() < 351.0
    body = shape_seen(ball()).body
    every, _ = FRONT.project(body.vertices[body.faces].mean(axis=1))
    assert len(tint.mesh.faces) == pytest.approx((every[:, 1] < 350.0).sum(), rel=0.01)


@pytest.mark.parametrize("kind", ["orthographic", "perspective"])
def test_a_tunnels_preview_is_where_it_goes_in_and_comes_out(kind) -> None:
    camera = standard_view(Camera(kind), "three-quarter")
    ring = Pen(camera).circle(600, 450, 60)
    shown = preview_of(TUNNEL, ball(), Ink((ring,)), Context(camera=camera))
    (rims, *_) = (item for _, item in shown.items() if isinstance(item, Lines))
    middle, radius = np.zeros(3), float(np.ptp(shape_seen(ball()).body.bounds[:, 2])) / 2.0
    assert np.linalg.norm(rims.points - middle, axis=1) == pytest.approx(radius, rel=0.02)
    seen, depth = camera.project(rims.points)
    assert np.hypot(*(seen - (600, 450)).T) == pytest.approx(60.0, rel=0.02)
    assert np.ptp(depth) > radius


def test_drawing_goes_on_after_a_cut() -> None:
    state = applied(CUT, ball(), Pen(FRONT).along([(200, 350), (1000, 350)]))
    holed = applied(DrawOutline(), state, Pen(FRONT).circle(600, 500, 50))
    assert solid(holed).genus() == 1
    apart = applied(DrawOutline(), state, Pen(FRONT).circle(150, 150, 50))
    assert len(apart.nodes) == 3


PEN = Pen(FRONT)
RANDOM = np.random.default_rng(3)
SCRIBBLE = Stroke(*RANDOM.normal((600, 450), 80, (200, 2)).T, FRONT)
BEHIND = Camera("perspective", (0.0, -200.0, 0.0), (0.0, -400.0, 0.0))


@pytest.mark.parametrize(
    ("stroke", "words"),
    [
        (PEN.dot(), "dot"),
        (SCRIBBLE, "crosses itself"),
        (PEN.circle(150, 150, 60), "passes the shape by"),
        (PEN.circle(600, 450, 400), "Nothing of the shape would be left"),
        (PEN.along([(500, 450), (700, 450)]), "encloses nothing"),
        (Pen(BEHIND).circle(600, 450, 60), "."),
    ],
    ids=["dot", "scribble", "beside", "around", "open", "behind"],
)
def test_no_tunnel(stroke: Stroke, words: str) -> None:
    with pytest.raises(UserError, match=words):
        applied(TUNNEL, ball(), stroke)


@pytest.mark.parametrize(
    ("stroke", "words"),
    [
        (PEN.dot(), "dot"),
        (SCRIBBLE, "."),
        (PEN.along([(100, 100), (1100, 100)]), "passes the shape by"),
        (PEN.circle(600, 450, 60), "comes back to its start"),
        (PEN.along([(100, 300), (900, 600), (700, 700), (700, 100)]), "crosses itself"),
    ],
    ids=["dot", "scribble", "beside", "closed", "crosses itself"],
)
def test_no_cut(stroke: Stroke, words: str) -> None:
    with pytest.raises(UserError, match=words):
        applied(CUT, ball(), stroke)


@pytest.mark.parametrize("tool", [TUNNEL, CUT], ids=["tunnel", "cut"])
def test_nothing_to_cut(tool) -> None:
    stroke = PEN.circle() if tool is TUNNEL else PEN.along([(100, 450), (900, 450)])
    with pytest.raises(UserError, match="Draw a shape first"):
        applied(tool, SilhouetteState(), stroke)


@pytest.mark.parametrize("tool", [TUNNEL, CUT], ids=["tunnel", "cut"])
@pytest.mark.parametrize("gesture", [Tap(600, 450, FRONT), Drag("x", PEN.circle())])
def test_other_gestures_are_refused(tool, gesture) -> None:
    with pytest.raises(UserError, match=tool.hint):
        tool.apply(ball(), gesture, Context())
    assert not preview_of(tool, ball(), gesture, Context()).layers


def test_an_open_outline_waits() -> None:
    with pytest.raises(Unfinished, match="press Enter"):
        TUNNEL.apply(ball(), Ink((PEN.along([(500, 450), (600, 300), (700, 450)]),)), Context())


def test_cuts_and_tunnels_come_back_from_a_file(shell, pen) -> None:
    shell.open("silhouette")
    shell.set(resolution=48)
    shell.draw(pen.circle(600, 450, 220))
    shell.draw(pen.circle(600, 500, 40), tool="tunnel")
    shell.draw(pen.along([(200, 350), (1000, 350)]), tool="cut")
    before = shell.shapes().solids[0].mesh
    assert not shell.reopen()
    after = shell.shapes().solids[0].mesh
    assert np.array_equal(before.vertices, after.vertices)
    assert isinstance(shell.state.parts[2], Cut)
    # The other side, as the form sets it.
    shell.set(side="right" if shell.state.parts[2].side == "left" else "left")
    assert shell.shapes().solids[0].mesh.bounds[1, 2] > before.bounds[1, 2] + 5.0


def _odd() -> list[Stroke]:
    random = np.random.default_rng(17)
    edge_on = Camera("orthographic", (0.0, -1e-3, 1000.0), (0.0, 0.0, 0.0))
    inside = Camera("perspective", (0.0, -20.0, 0.0), (0.0, 0.0, 0.0), fov_y=170.0)
    lines = [
        [(5, 5), (5, 5)],
        [(0, 0), (1, 1)],
        [(1e6, 0), (0, 1e6), (-1e6, -1e6)],
        [(1e9, 1e9), (-1e9, 0), (0, -1e9)],
        [(600, 450), (600.001, 450), (600, 450.001)],
        [(0, 450), (1e9, 450.5)],
        [(600, -1e6), (600, 1e6)],
        np.tile([(400, 300), (800, 450), (500, 700)], (30, 1)),
        random.normal((600, 450), 150, (200, 2)),
        random.normal(0, 12, (300, 2)).cumsum(axis=0) + 450.0,
    ]
    strokes = [Stroke(*np.array(line, float).T, FRONT) for line in lines]
    strokes += [Pen(edge_on).circle(), Pen(inside).circle()]
    strokes.append(Pen(inside).along([(0, 440), (1200, 460)]))
    return strokes


@pytest.mark.parametrize("number", range(len(_odd())))
@pytest.mark.parametrize("tool", [TUNNEL, CUT, Extrude()], ids=["tunnel", "cut", "extrude"])
def test_odd_ink_makes_a_solid_or_words(tool, number: int) -> None:
    stroke = _odd()[number]
    for strokes in ((stroke,), (PEN.circle(600, 450, 60), stroke), (stroke, stroke)):
        state, words = ball(), "."
        for _, item in preview_of(tool, state, Ink(strokes), Context(camera=FRONT)).items():
            points = item.mesh.vertices if isinstance(item, Shaded) else item.points
            assert np.isfinite(points).all()
        try:
            state = applied(tool, state, *strokes)
        except UserError as refusal:
            words = refusal.message
        assert words.endswith(".")
        assert solid(state).volume() > 0.0


def of_depth(state: SilhouetteState, depth: float) -> SilhouetteState:
    return state.with_node(replace(state.parts[-1], depth=depth))


@pytest.mark.parametrize("view", ["front", "right", "top", "three-quarter"])
def test_a_tunnel_of_a_depth_is_a_pocket_behind_its_outline(view: str) -> None:
    camera = standard_view(Camera("orthographic"), view)
    tunnel = applied(TUNNEL, ball(), Pen(camera).circle(600, 450, 60))
    part = tunnel.parts[-1]
    drawn = part.sheet.from_pixels(part.strokes[0].points, camera)
    radius = 0.5 * np.ptp(drawn, axis=0)[0]
    large = 0.5 * np.ptp(shape_seen(ball()).body.bounds, axis=0)[0]
    rise = large - np.sqrt(large**2 - radius**2)
    cap = np.pi * rise**2 * (3.0 * large - rise) / 3.0
    for depth in (7.0, 20.0, 50.0):
        pocket = solid(of_depth(tunnel, depth))
        assert pocket.genus() == 0
        taken = solid(ball()).volume() - pocket.volume()
        assert taken == pytest.approx(np.pi * radius**2 * depth + cap, rel=0.03)


@pytest.mark.parametrize("kind", ["orthographic", "perspective"])
def test_the_depth_of_a_tool_follows_its_handle(kind) -> None:
    drawn_from = standard_view(Camera(kind), "right")
    state = applied(TUNNEL, ball(), Pen(drawn_from).circle(600, 450, 60))
    assert state.parts[-1].depth == 0.0
    assert solid(state).genus() == 1
    camera = Camera(kind)
    for pixels, handles in ((80.0, 0), (-60.0, 0), (900.0, 1)):
        grip = depth_grip(state, state.parts[-1])
        start = camera.project([grip.place])[0][0]
        toward = camera.project([grip.place + grip.inwards])[0][0] - start
        end = start + pixels * toward / np.hypot(*toward)
        before = state.parts[-1].depth
        gesture = Drag(f"depth:{state.selected}", Pen(camera).along([start, end]))
        state = ARRANGE.apply(state, gesture, Context(camera=camera))
        moved = depth_grip(state, state.parts[-1])
        assert np.allclose(camera.project([moved.place])[0][0], end, atol=1e-6)
        assert (state.parts[-1].depth - before) * pixels > 0.0
        assert solid(state).genus() == handles
    state = state.with_node(replace(state.parts[-1], depth=1.0))
    out = Drag(f"depth:{state.selected}", Pen(camera).along([end, end - 900.0 * toward]))
    assert 0.0 < ARRANGE.apply(state, out, Context(camera=camera)).parts[-1].depth < 1.0


def test_the_depth_is_not_set_from_where_it_is_not_seen() -> None:
    state = applied(TUNNEL, ball(), Pen(FRONT).circle(600, 450, 60))
    gesture = Drag(f"depth:{state.selected}", Pen(FRONT).along([(600, 450), (620, 470)]))
    with pytest.raises(UserError, match="Turn the view"):
        ARRANGE.apply(state, gesture, Context(camera=FRONT))


def test_a_pocket_grows_with_its_part_and_has_a_mirror_image() -> None:
    state = of_depth(
        applied(TUNNEL, ball(), Pen(standard_view(FRONT, "right")).circle(600, 450, 60)), 8.0
    )
    taken = solid(ball()).volume() - solid(state).volume()
    middle = shape_seen(ball()).body.bounds.mean(axis=0)
    flip = mirrored(middle, np.array([1.0, 0.0, 0.0]))
    tool = state.parts[-1]
    both = state.with_node(replace(after_motion(state, tool, flip), id="n9"))
    assert solid(both).volume() == pytest.approx(solid(state).volume() - taken, rel=1e-3)
    large = SilhouetteState(tuple(replace(part, pose=Placement(scale=3.0)) for part in state.parts))
    assert solid(large).volume() == pytest.approx(27.0 * solid(state).volume(), rel=1e-3)
