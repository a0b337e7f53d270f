"""Paint on the surface: where it lies, what it follows, what is seen of it and what leaves."""

from __future__ import annotations

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from time import thread_time

import numpy as np
import pytest

from bozzetto.document.storage.bozz_file import read_document
from bozzetto.errors import UserError
from bozzetto.exchange.export import export
from bozzetto.exchange.ink.ink_json import write_drawing
from bozzetto.geometry import Mesh, Placement
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.ink.steps import DrawStep, SetStep
from bozzetto.plugin import Context, Ink, Job, Tap
from bozzetto.plugin.cache import forget_all
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto_silhouette.appearance import live_canvas
from bozzetto_silhouette.appearance.brush_cover import Segments, covered
from bozzetto_silhouette.appearance.paint_layer import (
    laid_strokes,
    lost_strokes,
    paint_at,
    tracks_of,
)
from bozzetto_silhouette.appearance.paint_refinement import Refinement, refined
from bozzetto_silhouette.appearance.surface_look import painted, texture_of
from bozzetto_silhouette.appearance.texture_baking import LEAST
from bozzetto_silhouette.appearance.vertex_colors import Coat
from bozzetto_silhouette.model.paint_stroke import PaintStroke
from bozzetto_silhouette.model.state import Picture, SilhouetteState, Turn
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.rigging.posing import rig_of
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.evaluate import tree_body
from bozzetto_silhouette.tools import DrawOutline
from bozzetto_silhouette.tools.brush import Brush
from bozzetto_silhouette.tools.brush_marks import brush_surface, marks_under, path_of
from bozzetto_silhouette.tools.mirror import MirrorCopy
from bozzetto_silhouette.tools.tunnel import DrawTunnel
from tests.blender import asked

FRONT = Camera("orthographic", (0.0, -500.0, 0.0), (0.0, 0.0, 0.0), height=300.0)
PEN, BRUSH, CONTEXT, MODELER = Pen(FRONT), Brush(), Context(camera=FRONT), Silhouette()
RED, BLUE = (200, 30, 20), (20, 40, 210)
ACROSS = [(450.0, 420.0), (600.0, 480.0), (750.0, 430.0)]


def ball(pen: Pen = PEN, radius: float = 240.0, **changes) -> SilhouetteState:
    state = SilhouetteState(resolution=64, brush_size=40.0, brush_softness=0.0, paint=RED)
    return drawn(replace(state, **changes), pen.circle(600, 450, radius))


def drawn(state: SilhouetteState, *strokes: Stroke) -> SilhouetteState:
    for stroke in strokes:
        state = DrawOutline().apply(state, Ink((stroke,), True), CONTEXT)
    return state


def brushed(state: SilhouetteState, *strokes: Stroke, **changes) -> SilhouetteState:
    state = replace(state, **changes)
    for stroke in strokes:
        state = BRUSH.apply(state, Ink((stroke,), True), CONTEXT)
    return state


def body_of(state: SilhouetteState) -> Body:
    body = tree_body(state, state.resolution)
    assert body is not None
    return body


def paint_of(state: SilhouetteState, body: Body | None = None) -> Coat:
    """The paint at the vertices of the whole shape."""
    body = body or body_of(state)
    tracks = tracks_of(laid_strokes(state), body)
    return paint_at(tracks, body.vertices, body.normals, body.step)


def under(pen: Pen, points) -> np.ndarray:
    """Places in the plane of the sheet, (n, 2): x and z."""
    return pen.camera.on_plane(points, (0.0, 0.0, 0.0), (0.0, -1.0, 0.0))[:, [0, 2]]


def way(points, line) -> np.ndarray:
    """Distances of points (n, 2) from a polyline."""
    import shapely

    return shapely.distance(shapely.LineString(line), shapely.points(points))


# -- where it lies --


def test_paint_lies_under_the_pen_and_nowhere_else():
    state = brushed(ball(), PEN.but(pressure=1.0).along(ACROSS))
    body, radius = body_of(state), 20.0 * 300.0 / 900.0
    cover = paint_of(state).cover
    off = way(body.vertices[:, [0, 2]], under(PEN, ACROSS))
    front = body.normals[:, 1] < -0.7
    assert (cover[front & (off < radius - body.step)] > 0.99).all()
    assert (cover[off > radius + body.step] == 0.0).all()
    assert front[cover > 0.0].sum() > 50


@pytest.mark.parametrize("inflation", [0.2, 1.0])
def test_paint_does_not_go_through_to_the_back(inflation):
    state = ball()
    state = state.with_node(replace(state.parts[0], inflation=inflation))
    state = brushed(state, PEN.along(ACROSS), brush_size=200.0)
    body = body_of(state)
    assert (paint_of(state).cover[body.normals[:, 1] > 0.0] == 0.0).all()
    assert paint_of(state).cover.max() == pytest.approx(1.0)


def test_a_pen_that_is_pressed_harder_paints_wider():
    widths = []
    for pressure in (0.1, 0.5, 1.0):
        state = brushed(ball(), PEN.but(pressure=pressure).along(ACROSS))
        (stroke,) = state.parts[0].paint_strokes
        widths.append(float(np.median(stroke.radii)))
    assert widths[0] < 0.5 * widths[2] < widths[1] < widths[2]
    assert widths[2] == pytest.approx(20.0 * 300.0 / 900.0, rel=1e-5)


def test_a_mouse_paints_as_wide_as_the_brush_is():
    plain = Stroke([450.0, 750.0], [450.0, 450.0], FRONT)
    (stroke,) = brushed(ball(), plain).parts[0].paint_strokes
    assert np.ptp(stroke.radii) == 0.0
    assert stroke.radii[0] == pytest.approx(20.0 * 300.0 / 900.0, rel=1e-5)


def test_a_nearer_view_paints_finer():
    near = Pen(replace(FRONT, height=30.0), pressure=1.0)
    (stroke,) = brushed(ball(), near.along(ACROSS)).parts[0].paint_strokes
    assert np.median(stroke.radii) == pytest.approx(20.0 * 30.0 / 900.0, rel=1e-5)


def test_a_tap_paints_a_dot():
    state = BRUSH.tap(ball(), Tap(600.0, 450.0, FRONT, pressure=1.0), CONTEXT)
    cover = paint_of(state).cover
    off = np.linalg.norm(body_of(state).vertices[:, [0, 2]], axis=1)
    assert cover.max() == pytest.approx(1.0)
    assert off[cover > 0.5].max() < 20.0 * 300.0 / 900.0 + body_of(state).step


@pytest.mark.parametrize(
    ("state", "stroke", "words"),
    [
        (ball(), PEN.along([(10, 10), (60, 40)]), "passes the shape by"),
        (SilhouetteState(), PEN.along(ACROSS), "nothing to paint on"),
        (ball(), PEN.but(tool="eraser").along(ACROSS), "no paint to rub out"),
        (ball(paint=None), PEN.along(ACROSS), "no paint to rub out"),
    ],
    ids=["beside", "without a shape", "rubbed without paint", "no colour"],
)
def test_what_cannot_be_painted_is_told(state, stroke, words):
    with pytest.raises(UserError, match=words):
        BRUSH.apply(state, Ink((stroke,), True), CONTEXT)


# -- strokes and their order --


def test_strokes_that_do_not_overlap_commute():
    one, other = PEN.along([(450, 350), (750, 350)]), PEN.along([(450, 550), (750, 550)])
    first = brushed(brushed(ball(), one, paint=RED), other, paint=BLUE)
    second = brushed(brushed(ball(), other, paint=BLUE), one, paint=RED)
    body = body_of(first)
    np.testing.assert_array_equal(paint_of(first, body).rgb, paint_of(second, body).rgb)
    np.testing.assert_array_equal(paint_of(first, body).cover, paint_of(second, body).cover)


def test_later_strokes_lie_over_earlier_ones():
    state = brushed(brushed(ball(), PEN.along(ACROSS), paint=RED), PEN.along(ACROSS), paint=BLUE)
    paint = paint_of(state)
    whole = paint.cover == 1.0
    assert whole.any()
    np.testing.assert_allclose(paint.rgb[whole], [BLUE] * int(whole.sum()))


def test_a_stroke_over_itself_covers_once():
    there_and_back = PEN.along([*ACROSS, *ACROSS[::-1]])
    state = brushed(ball(), there_and_back, brush_opacity=0.5)
    assert paint_of(state).cover.max() == pytest.approx(0.5)
    twice = brushed(state, PEN.along(ACROSS))
    assert paint_of(twice).cover.max() == pytest.approx(0.75)


def test_the_eraser_rubs_paint_out_and_leaves_the_colours_of_parts():
    state = ball()
    state = state.with_node(replace(state.parts[0], color=(9, 200, 9)))
    state = brushed(state, PEN.along(ACROSS))
    rubbed = brushed(state, PEN.but(tool="eraser").along(ACROSS), brush_size=100.0)
    assert len(laid_strokes(rubbed)) == 2
    assert paint_of(rubbed).cover.max() < 1e-9
    colors = painted(rubbed, body_of(rubbed)).mesh.colors
    assert colors is not None
    np.testing.assert_array_equal(colors[:, :3], [(9, 200, 9)] * len(colors))


def test_the_same_strokes_give_the_same_paint():
    one, other = (brushed(ball(), PEN.along(ACROSS)) for _ in range(2))
    assert one == other
    assert hash(one.parts[0]) == hash(other.parts[0])
    assert brushed(ball(), PEN.along(ACROSS), brush_opacity=0.5).parts != one.parts


def test_a_soft_edge_fades_and_a_hard_one_does_not():
    segments = Segments.through(
        np.array([[0.0, 0, 0], [10.0, 0, 0]]), np.tile([0.0, 0, 1], (2, 1)), np.full(2, 2.0),
        np.array([True]),
    )  # fmt: skip
    away = np.linspace(0.0, 3.0, 400)
    places = np.column_stack([np.full(400, 5.0), away, 0.0 * away])
    normals = np.tile([0.0, 0, 1], (400, 1))

    def profile(softness):
        found = np.zeros(400)
        index, cover = covered(segments, softness, places, normals, 0.01)
        found[index] = cover
        return found

    hard, soft = profile(0.0), profile(1.0)
    assert (np.diff(hard) <= 0.0).all()
    assert (np.diff(soft) <= 0.0).all()
    assert ((hard > 0.01) & (hard < 0.99)).sum() <= 2
    assert (soft[away > 2.02] == 0.0).all()
    assert 0.4 < np.interp(1.0, away, soft) < 0.6


# -- what it follows --


def at_the_front(state: SilhouetteState) -> np.ndarray:
    """Middles of what is painted, seen from the front, and how wide that is, (3,)."""
    body = body_of(state)
    cover = paint_of(state).cover
    seen = body.vertices[cover > 0.5][:, [0, 2]]
    return np.append(seen.mean(axis=0), np.ptp(seen[:, 0]))


@pytest.mark.parametrize("inflation", [0.5, 2.0])
def test_paint_stays_where_it_is_seen_when_the_shape_is_inflated(inflation):
    line = PEN.along([(680, 400), (760, 440)])
    state = brushed(ball(), line)
    blown = state.with_node(replace(state.parts[0], inflation=inflation))
    assert lost_strokes(blown, body_of(blown)) == 0
    np.testing.assert_allclose(at_the_front(blown), at_the_front(state), atol=2.0)


def test_paint_stays_when_the_resolution_changes():
    state = brushed(ball(), PEN.along(ACROSS))
    fine = replace(state, resolution=160)
    assert lost_strokes(fine, body_of(fine)) == 0
    np.testing.assert_allclose(at_the_front(fine), at_the_front(state), atol=2.5)


def test_paint_lies_on_a_larger_shape_when_the_outline_is_drawn_anew():
    state = brushed(ball(), PEN.along(ACROSS))
    part = replace(state.parts[0], strokes=Strokes((PEN.circle(600, 450, 300),)))
    larger = state.with_node(part)
    assert lost_strokes(larger, body_of(larger)) == 0
    np.testing.assert_allclose(at_the_front(larger), at_the_front(state), rtol=0.25, atol=3.0)


def test_paint_goes_with_its_part_and_comes_with_its_mirror_image():
    state = brushed(drawn(ball(radius=100.0), PEN.circle(850, 450, 90)), PEN.along(
        [(820, 430), (880, 470)]
    ))  # fmt: skip
    assert [len(part.paint_strokes) for part in state.parts] == [0, 1]
    part = state.parts[1]
    shift = Placement(offset=(0.0, 0.0, 30.0))
    moved = state.with_node(replace(part, pose=shift))
    np.testing.assert_allclose(
        at_the_front(moved), at_the_front(state) + np.array([0.0, 30.0, 0.0]), atol=1e-3
    )
    twin = MirrorCopy().tap(state, Tap(850.0, 450.0, FRONT, shift=True), CONTEXT)
    body, cover = body_of(twin), paint_of(twin).cover
    sides = [body.vertices[(cover > 0.5) & (body.vertices[:, 0] * side > 0)] for side in (-1, 1)]
    assert len(sides[0]) > 5
    np.testing.assert_allclose(
        sides[0].mean(axis=0) * (-1, 1, 1), sides[1].mean(axis=0), atol=body.step
    )


def test_a_stroke_over_two_parts_goes_with_both():
    state = drawn(ball(radius=120.0), PEN.circle(760, 450, 110))
    state = brushed(state, PEN.along([(520, 450), (820, 450)]))
    assert [len(part.paint_strokes) for part in state.parts] == [1, 1]
    assert len(laid_strokes(state)) == 1
    body = body_of(state)
    front = (body.normals[:, 1] < -0.6) & (np.abs(body.vertices[:, 2]) < 2.0)
    between = front & (np.abs(body.vertices[:, 0] - 25.0) < 40.0)
    assert paint_of(state).cover[between].min() > 0.9


def test_where_a_hole_is_cut_the_paint_waits_and_is_told():
    state = brushed(ball(), PEN.along([(570, 450), (630, 450)]))
    holed = DrawTunnel().apply(state, Ink((PEN.circle(600, 450, 90),), True), CONTEXT)
    body = body_of(holed)
    assert lost_strokes(holed, body) == 1
    assert paint_of(holed).cover.max() == 0.0
    result = MODELER.solve(holed, Job())
    (caution,) = MODELER.cautions(holed, result)
    assert "1 stroke of paint lies on nothing" in caution.message
    assert MODELER.report(holed, result, Job())["paint"] == {"strokes": 1, "off_surface": 1}
    back = holed.without_nodes(holed.nodes[-1].id)
    np.testing.assert_array_equal(paint_of(back).cover, paint_of(state).cover)


def test_an_outline_drawn_around_parts_takes_their_paint_along():
    state = drawn(ball(radius=60.0), PEN.circle(800, 450, 60))
    state = brushed(state, PEN.along([(580, 450), (620, 450)]), PEN.along([(790, 450), (810, 450)]))
    around = drawn(state, PEN.circle(700, 450, 300))
    assert len(around.parts) == 1
    assert [stroke.number for stroke in around.parts[0].paint_strokes] == [1, 2]
    was = [stroke.points[0] for part in state.parts for stroke in part.paint_strokes]
    now = [stroke.points[0] for stroke in around.parts[0].paint_strokes]
    np.testing.assert_allclose(now, was, atol=1e-3)


def test_what_is_painted_on_a_bent_limb_lies_there_at_rest():
    corners = [(300, 420), (900, 420), (900, 480), (300, 480)]
    state = drawn(SilhouetteState(resolution=64, paint=RED), PEN.polygon(*corners))
    rig = rig_of(state)
    assert rig is not None
    joint = int(np.argsort(np.abs(rig.joints[:, 0]))[1])
    c, s = np.cos(0.5), np.sin(0.5)
    x, y, z = rig.joints[joint].tolist()
    bent = replace(state, turns=(Turn((x, y, z), (c, 0.0, s, 0.0)),))
    body = body_of(bent)
    result = MODELER.solve(bent, Job())
    assert result.mesh is not None
    away = np.linalg.norm(result.mesh.vertices - body.vertices, axis=1)
    assert away.max() > 10.0
    facing = body.normals[:, 1] < -0.9
    chosen = int(np.argmax(np.where(facing, away, 0.0)))
    (pixel,), _ = FRONT.project(result.mesh.vertices[chosen : chosen + 1])
    dot = BRUSH.tap(bent, Tap(*pixel.tolist(), FRONT, pressure=1.0), CONTEXT)
    (stroke,) = dot.parts[0].paint_strokes
    rest = dot.parts[0].placement.points(stroke.points * (1, 1, dot.parts[0].inflation))
    assert np.linalg.norm(rest[0] - body.vertices[chosen]) < 2.0 * body.step
    after = MODELER.solve(dot, Job())
    assert after.mesh is not None
    assert after.mesh.colors is not None
    assert after.mesh.cover[chosen] > 200
    assert len(after.shown.vertices) > len(after.mesh.vertices)


# -- laws --


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_a_world_of_another_scale_gives_the_same_picture(scale):
    camera = Camera("orthographic", (0.0, -500.0 * scale, 0.0), height=300.0 * scale)
    small = brushed(ball(), PEN.along(ACROSS))
    large = brushed(ball(Pen(camera)), Pen(camera).along(ACROSS))
    one, other = body_of(small), body_of(large)
    assert other.vertices.shape == one.vertices.shape
    np.testing.assert_allclose(other.vertices, scale * one.vertices, atol=1e-3 * scale)
    here, there = paint_of(small), paint_of(large)
    np.testing.assert_allclose(there.rgb, here.rgb, atol=1.0)
    np.testing.assert_allclose(there.cover, here.cover, atol=4e-3)


def test_with_mirror_on_a_stroke_paints_both_sides_alike():
    state = brushed(ball(mirrored=True), PEN.along([(640, 380), (760, 470)]))
    body, tracks = body_of(state), tracks_of(laid_strokes(state), body_of(state))
    assert len(tracks) == 1
    flip = np.array([-1.0, 1.0, 1.0])
    here = paint_at(tracks, body.vertices, body.normals, body.step)
    there = paint_at(tracks, body.vertices * flip, body.normals * flip, body.step)
    assert np.abs(here.cover - there.cover).max() < 0.05
    for side in (-1.0, 1.0):
        assert here.cover[body.vertices[:, 0] * side > 0].max() == pytest.approx(1.0)


def test_mirror_paints_nothing_where_there_is_no_other_side():
    state = replace(ball(radius=80.0), mirrored=True)
    moved = state.with_node(replace(state.parts[0], pose=Placement(offset=(80.0, 0.0, 0.0))))
    middle = 600.0 + 80.0 * 3.0
    painted_once = brushed(moved, PEN.along([(middle - 20, 450), (middle + 20, 450)]))
    (stroke,) = painted_once.parts[0].paint_strokes
    assert len(stroke.starts) == 1


def test_undo_save_and_open_are_exact(tmp_path):
    drawing = Drawing(
        Strokes((PEN.circle(600, 450, 240), PEN.along(ACROSS), PEN.along(ACROSS[::-1]))),
        FRONT,
        "ball",
        steps=(
            DrawStep("draw", (0,)),
            SetStep({"brush_size": 30.0, "paint": RED}),
            DrawStep("brush", (1,)),
            SetStep({"paint": BLUE}),
            DrawStep("brush", (2,)),
        ),
    )
    from bozzetto.cli.main import main

    source = tmp_path / "ball.json"
    source.write_bytes(write_drawing(drawing))
    target, said = tmp_path / "ball.bozz", tmp_path / "said.json"
    assert main(["build", "silhouette", str(source), "-o", str(target), "--report", str(said)]) == 0
    assert '"paint"' in said.read_text()
    document, report = read_document(target, Registry())
    assert report.warnings == ()
    (model,) = document
    (part,) = model.state.parts
    assert [stroke.color for stroke in part.paint_strokes] == [RED, BLUE]
    state = replace(model.state, brush_size=30.0, paint=RED)
    again = ball(resolution=model.state.resolution, brush_softness=state.brush_softness)
    again = brushed(again, drawing.strokes[1], brush_size=30.0)
    assert again.parts[0].paint_strokes == part.paint_strokes[:1]
    again = brushed(again, drawing.strokes[2], paint=BLUE)
    assert again.parts[0].paint_strokes == part.paint_strokes
    assert json.loads(said.read_text())


@pytest.mark.parametrize(
    "change",
    [
        {"points": np.zeros((0, 3), np.float32)},
        {"normals": np.zeros((1, 3), np.float32)},
        {"radii": np.full(2, -1.0, np.float32)},
        {"radii": np.full(2, np.nan, np.float32)},
        {"starts": np.array([1], np.int32)},
        {"starts": np.array([0, 5], np.int32)},
        {"starts": np.array([0, 1, 1], np.int32)},
        {"opacity": 2.0},
        {"softness": -1.0},
    ],
)
def test_a_file_that_holds_no_stroke_of_paint_is_refused(change):
    columns = {
        "points": np.zeros((2, 3), np.float32),
        "normals": np.ones((2, 3), np.float32),
        "radii": np.ones(2, np.float32),
        "starts": np.zeros(1, np.int32),
    }
    assert PaintStroke(1, **columns)
    with pytest.raises(ValueError, match=r"paint|opacity|finite"):
        PaintStroke(1, **(columns | change))


# -- what is seen --


def test_finer_triangles_leave_the_surface_closed_and_as_it_is():
    state = brushed(ball(), PEN.along(ACROSS), PEN.but(pressure=0.05).along(ACROSS[::-1]))
    body = body_of(state)
    mesh = Mesh(body.vertices.astype(np.float32), body.faces, body.normals.astype(np.float32))
    tracks = tracks_of(laid_strokes(state), body)
    fine = Refinement.of(mesh)
    for track in tracks:
        fine = refined(fine, track, body.step)
    whole = fine.applied(mesh)
    assert len(fine.faces) > len(mesh.faces)
    sides = np.sort(np.stack([fine.faces, np.roll(fine.faces, -1, 1)], 2).reshape(-1, 2), axis=1)
    assert (np.unique(sides, axis=0, return_counts=True)[1] == 2).all()

    def area(one):
        a, b, c = np.moveaxis(one.vertices[one.faces].astype(float), 1, 0)
        return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()

    assert area(whole) == pytest.approx(area(mesh), rel=1e-6)
    # Between the vertices the colours are those of the function.
    corners = fine.faces[:: 1 + len(fine.faces) // 4000]
    points, normals = (
        values[corners].mean(axis=1).astype(float) for values in (whole.vertices, whole.normals)
    )
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    meant = paint_at(tracks, points, normals, body.step / 8.0).cover
    off = np.abs(fine.paint.cover[corners].mean(axis=1) - meant)
    assert np.quantile(off, 0.95) < 0.34
    assert off.mean() < 0.05


def test_the_preview_is_what_the_stroke_leaves_and_only_new_places_are_worked_out():
    state, line = ball(mirrored=True), PEN.along([(480, 400), (560, 480), (650, 430)])
    preview = BRUSH.begin(state, CONTEXT)
    for count in range(1, len(line) + 1, 3):
        part = Stroke(line.x[:count], line.y[:count], FRONT, pressure=line.pressure[:count])
        preview.update(Ink((part,)))
    scene = preview.update(Ink((line,)))
    (item,) = scene.layers[0].items
    live = item.mesh
    state = brushed(state, line)
    body = body_of(state)
    tracks = tracks_of(laid_strokes(state), body)
    meant = paint_at(
        tracks, live.vertices.astype(float), live.normals.astype(float), body.step / 4.0
    )
    off = np.abs(live.cover / 255.0 - meant.cover)
    assert (off > 0.3).mean() < 0.02
    assert off.mean() < 0.01
    assert live.cover.max() == 255
    # From the hand's first touch on there is something to see.
    assert BRUSH.begin(ball(), CONTEXT).update(Ink((PEN.dot(),))).layers
    assert not BRUSH.begin(SilhouetteState(), CONTEXT).update(Ink((PEN.dot(),))).layers


@pytest.mark.parametrize("size", [12.0, 90.0])
def test_a_pen_that_hovers_shows_how_wide_it_paints(size):
    state = ball(brush_size=size)
    scene = BRUSH.begin(state, CONTEXT).update(Tap(500.0, 460.0, FRONT))
    lines = [item for _, item in scene.items()]
    assert len(lines) == 2, "the line, and its rim"
    for line in lines:
        away = np.linalg.norm(FRONT.project(line.points)[0] - (500.0, 460.0), axis=1)
        assert away == pytest.approx(0.5 * size, abs=0.01)
    assert BRUSH.begin(SilhouetteState(), CONTEXT).update(Tap(500.0, 460.0, FRONT)).layers


def test_what_a_stroke_begins_with_is_found_while_the_pen_hovers(monkeypatch):
    state = brushed(ball(radius=235.0), PEN.along(ACROSS))
    asked = []
    found = live_canvas.Unpainted.of.__func__
    monkeypatch.setattr(
        live_canvas.Unpainted,
        "of",
        classmethod(lambda cls, *given: asked.append(1) or found(cls, *given)),
    )
    BRUSH.begin(state, CONTEXT).update(Tap(600.0, 450.0, FRONT))
    assert asked == [1]
    first = BRUSH.begin(state, CONTEXT).update(Ink((PEN.dot(),)))
    again = BRUSH.begin(state, CONTEXT).update(Ink((PEN.dot(),)))
    assert asked == [1]
    one, other = (scene.layers[0].items[0].mesh for scene in (first, again))
    np.testing.assert_array_equal(one.colors, other.colors)
    assert one.cover.max() == 255


def test_keys_size_the_brush():
    keys = {command.key: command for command in MODELER.commands() if command.menu == "Brush"}
    state = ball(brush_size=20.0)
    assert (
        keys["["].run(state, CONTEXT).brush_size < 20.0 < keys["]"].run(state, CONTEXT).brush_size
    )
    assert keys["["].run(replace(state, brush_size=1.0), CONTEXT).brush_size == 1.0
    assert keys["]"].run(replace(state, brush_size=400.0), CONTEXT).brush_size == 400.0
    sizes = [1.0]
    for _ in range(12):
        sizes.append(keys["]"].run(replace(state, brush_size=sizes[-1]), CONTEXT).brush_size)
    assert (np.diff(sizes) >= 1.0).all()


@pytest.mark.parametrize("softness", [0.0, 0.5])
def test_a_pen_pressed_unevenly_keeps_few_places_and_covers_the_same(softness):
    """Against the stroke with all of its marks: narrow ones lie within wide ones."""
    random = np.random.default_rng(31)
    line = PEN.along([(470, 400), (560, 480), (700, 430), (600, 540), (500, 500)])
    line = Stroke(line.x, line.y, FRONT, pressure=random.uniform(0.0, 1.0, len(line)))
    state = ball(brush_size=30.0, brush_softness=softness)
    surface = brush_surface(state)
    marks = marks_under(surface, *path_of(line, 30.0), FRONT)
    (stroke,) = brushed(state, line).parts[0].paint_strokes
    assert len(stroke.points) < 0.4 * len(marks.points)
    whole = Segments.through(marks.points, marks.normals, marks.radii, marks.joined)
    (track,) = tracks_of(laid_strokes(brushed(state, line)), surface.body)
    places = surface.body.vertices, surface.body.normals, 0.5 * surface.body.step
    covers = np.zeros((2, len(surface.body.vertices)))
    for row, segments in zip(covers, (whole, track.segments), strict=True):
        index, cover = covered(segments, softness, *places)
        row[index] = cover
    off = np.abs(np.diff(covers, axis=0))
    assert off.max() < 0.4  # where a hard edge lies 0.05 radii beside
    assert off.mean() < 0.003
    assert off[:, covers[0] > 0.999].mean() < 1e-3


def test_two_paintings_at_once_are_what_each_is_alone():
    lines = [PEN.along([(480 + 4 * k, 400), (560, 480), (650, 430 + 5 * k)]) for k in range(6)]
    starts = [ball(radius=231.0), ball(radius=229.0, brush_softness=0.5)]

    def colors(start):
        result = MODELER.solve(brushed(start, *lines), Job())
        return result.shown.colors, result.shown.cover

    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(colors, starts))
    for (color, cover), start in zip(together, starts, strict=True):
        alone = brushed(start, *lines)
        fine = painted_alone(alone)
        np.testing.assert_array_equal(cover, fine.cover)
        np.testing.assert_array_equal(color, fine.colors)


def painted_alone(state: SilhouetteState) -> Mesh:
    """The shown mesh, worked out with nothing remembered."""
    forget_all()
    shown = MODELER.solve(state, Job()).shown
    assert shown is not None
    return shown


def test_the_eraser_is_seen_at_work():
    state = brushed(ball(), PEN.along(ACROSS))
    MODELER.solve(state, Job())
    rub = PEN.but(tool="eraser").along(ACROSS)
    (item,) = (
        BRUSH.begin(replace(state, brush_size=100.0), CONTEXT).update(Ink((rub,))).layers[0].items
    )
    before = painted(state, body_of(state)).mesh.cover
    assert before is not None
    assert before.max() == 255
    assert item.mesh.cover.max() < 3


def test_a_part_that_was_painted_is_not_worked_out_again():
    state = ball()
    one, other = (
        MODELER.solve(state, Job()),
        MODELER.solve(brushed(state, PEN.along(ACROSS)), Job()),
    )
    assert other.body is one.body


# -- what leaves --


def test_the_texture_shows_the_paint_and_is_large_enough():
    state = brushed(ball(), PEN.along(ACROSS))
    body = body_of(state)
    texture = texture_of(state, body)
    assert texture is not None
    height, width = texture.pixels.shape[:2]
    assert max(height, width) >= LEAST
    random = np.random.default_rng(3)
    face = random.integers(0, len(body.faces), 6000)
    weights = random.dirichlet((1.0, 1.0, 1.0), 6000)
    spots = np.einsum("nk,nkd->nd", weights, texture.corners[face].astype(float))
    column, row = (spots * (width, height)).astype(int).T
    found = texture.pixels[row, column, 3] / 255.0
    corners = body.faces[face]
    points, normals = (
        np.einsum("nk,nkd->nd", weights, values[corners])
        for values in (body.vertices, body.normals)
    )
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    tracks = tracks_of(laid_strokes(state), body)
    meant = paint_at(tracks, points, normals, body.step / 16.0).cover
    assert (meant > 0.5).mean() > 0.02
    assert (np.abs(found - meant) > 0.25).mean() < 0.01
    assert texture_of(ball(), body_of(ball())) is None


def test_a_projected_picture_is_baked_large_enough_too():
    pixels = np.full((8, 8, 4), 255, np.uint8)
    picture = Picture(pixels, (-100.0, 0.0, 100.0), (200.0, 0.0, 0.0), (0.0, 0.0, -200.0))
    state = replace(ball(), picture=picture)
    texture = texture_of(state, body_of(state))
    assert texture is not None
    assert max(texture.pixels.shape[:2]) >= LEAST


# -- hostile --


@pytest.mark.long
@pytest.mark.parametrize("uneven", [False, True])
def test_hundreds_of_long_strokes_stay_live_and_small(uneven):
    random = np.random.default_rng(12)
    state = ball(resolution=128, brush_size=8.0)
    for _ in range(200):
        turns = np.cumsum(random.normal(0.0, 0.06, 2000))
        steps = 0.4 * np.column_stack([np.cos(turns), np.sin(turns)])
        walk = np.abs((np.cumsum(steps, axis=0) + random.uniform(0, 300, 2)) % 600 - 300)
        place = walk + np.array([450.0, 300.0])
        pressure = 0.5 + 0.4 * np.sin(np.linspace(0.0, random.uniform(5.0, 60.0), 2000))
        if uneven:
            pressure = random.uniform(0.0, 1.0, 2000)
        stroke = Stroke(place[:, 0], place[:, 1], FRONT, pressure=pressure)
        state = brushed(state, stroke)
    (part,) = state.parts
    size = sum(
        stroke.points.nbytes + stroke.normals.nbytes + stroke.radii.nbytes
        for stroke in part.paint_strokes
    )
    assert len(part.paint_strokes) == 200
    assert size < 28 * 200 * 8000
    result = MODELER.solve(state, Job())
    assert result.shown is not None
    assert np.isfinite(result.shown.vertices).all()
    assert len(result.shown.faces) <= 200_000
    preview, spent = BRUSH.begin(state, CONTEXT), []
    for count in range(2, 60, 4):
        x, y = np.linspace(500, 700, 60)[:count], np.full(count, 450.0)
        begun = thread_time()
        scene = preview.update(Ink((Stroke(x, y, FRONT),)))
        spent.append(thread_time() - begun)
    assert scene.layers
    assert np.median(spent[1:]) < 0.2


@pytest.mark.parametrize(
    "stroke",
    [
        PEN.along([(600, 450)]),
        Stroke([600.0] * 50, [450.0] * 50, FRONT),
        PEN.along([(-1e5, 450), (1e5, 450)]),
        PEN.but(pressure=0.0).along(ACROSS),
        Pen(Camera("perspective", (200.0, -300.0, 150.0))).along(ACROSS),
    ],
    ids=["a dot", "many in one place", "far beyond", "without pressure", "in perspective"],
)
def test_odd_strokes_paint_something_sound(stroke):
    state = brushed(ball(), stroke, brush_size=400.0)
    paint = paint_of(state)
    assert np.isfinite(paint.rgb).all()
    assert 0.0 <= paint.cover.min() <= paint.cover.max() <= 1.0 + 1e-9
    result = MODELER.solve(state, Job())
    assert result.shown is not None


READ = """
bpy.ops.import_scene.gltf(filepath=sys.argv[1])
meshes = [o for o in bpy.data.objects if o.type == "MESH"]
mesh = max(meshes, key=lambda o: len(o.data.polygons))  # another one draws bones
image = next(image for image in bpy.data.images if image.size[0])
pixels, (width, height) = list(image.pixels), image.size
layer = mesh.data.uv_layers.active.data
rows = []
for face in list(mesh.data.polygons)[::7]:
    u = sum(layer[k].uv[0] for k in face.loop_indices) / 3.0
    v = sum(layer[k].uv[1] for k in face.loop_indices) / 3.0
    start = 4 * (int(v * height) * width + int(u * width))
    place = mesh.matrix_world @ face.center
    rows.append([*place, *pixels[start : start + 3]])
answer = {"size": [width, height], "rows": rows}
"""


@pytest.mark.interop
def test_blender_shows_the_paint_where_it_was_painted(tmp_path):
    state = brushed(ball(), PEN.but(pressure=1.0).along(ACROSS))
    shapes = MODELER.shapes(state, MODELER.solve(state, Job()))
    export(shapes, tmp_path / "ball.glb")
    seen = asked(READ, tmp_path / "ball.glb")
    assert max(seen["size"]) >= LEAST
    rows = np.array(seen["rows"])
    places = rows[:, :3] * (160.0 / np.ptp(rows[:, 0]))
    off, red = way(places[:, [0, 2]], under(PEN, ACROSS)), rows[:, 3] - rows[:, 4] > 0.3
    radius = 20.0 * 300.0 / 900.0
    on_front = places[:, 1] < -20.0
    inside = on_front & (off < 0.7 * radius)
    assert inside.sum() > 10
    assert red[inside].mean() > 0.97
    assert not red[(off > 1.3 * radius) | (places[:, 1] > 20.0)].any()
