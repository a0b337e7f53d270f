"""What is drawn on a body: the four cases, loops that are pushed, chamfers, copies, joints."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import brep_mesh
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.chamfer import chamfered
from bozzetto_polyhedron.drawing_on.circles import (
    Circle,
    circle_on_face,
    polygon_of,
)
from bozzetto_polyhedron.drawing_on.copies import copied_along, joined, mirrored, moved
from bozzetto_polyhedron.drawing_on.cylinders import brep_with_cylinders, walls_of
from bozzetto_polyhedron.drawing_on.loop_on_face import loop_on_face
from bozzetto_polyhedron.drawing_on.push import dragged_depth, prism_on, pushed
from bozzetto_polyhedron.drawing_on.stroke_ends import placed_lines
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.solid.boolean import combined
from bozzetto_polyhedron.solid.exact import exact_body
from bozzetto_polyhedron.solid.face_rings import area_vector, edges_of, tangents
from bozzetto_polyhedron.solid.triangulation import face_triangles, genus_of, volume_of
from tests.plugins.polyhedron.test_exact_planes import off_planes
from tests.plugins.polyhedron.true_bodies import all_bodies, drawn, face_areas, polygon_area, prism

SOLIDS = {body.name: body for body in all_bodies() if body.genus is not None}
REACH = 12.0


def solid(name, seed=3001, share=0.01):
    answer, noise, _ = drawn(SOLIDS[name], share, np.random.default_rng(seed))
    return exact_body(answer, noise=noise)


def block(turn=None):
    """A block of 90 × 70 × 50 mm whose top is face 1."""
    vertices, faces, _ = prism([(0, 0), (90, 0), (90, 70), (0, 70)], 50.0)
    turn = np.eye(3) if turn is None else turn
    return exact_body(Answer(vertices @ turn.T, faces, 1.0, 0.0, True), noise=0.0)


def camera(kind):
    return Camera(kind, eye=(260.0, -330.0, 280.0), target=(45.0, 35.0, 25.0), height=200.0)


def line(view, start, end, rng=None):
    """A straight stroke between two points of space, with 1 px of noise where `rng` is given."""
    ends, _ = view.project([start, end])
    share = np.linspace(0.0, 1.0, 25)[:, None]
    stroke = ends[0] + share * (ends[1] - ends[0])
    return stroke if rng is None else stroke + rng.normal(0.0, 1.0, stroke.shape)


KINDS = ("orthographic", "perspective")


@pytest.mark.parametrize("kind", KINDS)
def test_ends_are_found_at_corners_on_edges_and_in_faces(kind):
    body, view = block(), camera(kind)
    corner, on_edge, in_face = (90, 0, 50), (90, 25, 50), (40, 30, 50)
    rng = np.random.default_rng(3002)
    found = placed_lines(
        body, [line(view, corner, in_face, rng), line(view, in_face, on_edge, rng)], view, REACH
    )
    assert [found.cases[k] for k in found.lines.ravel()] == ["corner", "face", "face", "edge"]
    assert found.lines[0, 1] == found.lines[1, 0]  # they meet
    points = found.points[found.lines[[0, 0, 1], [0, 1, 1]]]
    assert (points[0] == body.vertices[found.on[found.lines[0, 0]]]).all()
    assert np.abs(points - (corner, in_face, on_edge)).max() < 2.0
    assert points[1, 2] == pytest.approx(50.0, abs=1e-9)
    edge = edges_of(body.faces)[found.on[found.lines[1, 1]]]
    start, end = body.vertices[edge]
    assert np.linalg.norm(np.cross(points[2] - start, end - start)) < 1e-9 * 90**2


@pytest.mark.parametrize("kind", KINDS)
def test_a_free_end_along_an_axis_is_found_by_it(kind):
    body, view = block(), camera(kind)
    rng = np.random.default_rng(3003)
    found = placed_lines(body, [line(view, (90, 70, 50), (90, 70, 95), rng)], view, REACH)
    assert found.cases[found.lines[0, 1]] == "free"
    assert np.abs(found.points[found.lines[0, 1]] - (90, 70, 95)).max() < 3.0


@pytest.mark.parametrize("kind", KINDS)
def test_free_ends_that_hang_on_one_another_are_found_together(kind):
    """A frame on the block: two posts, and a bar between their free ends."""
    body, view = block(), camera(kind)
    rng = np.random.default_rng(3004)
    posts = [((0, 70, 50), (0, 70, 100)), ((90, 70, 50), (90, 70, 100))]
    strokes = [line(view, *post, rng) for post in posts]
    strokes.append(line(view, (0, 70, 100), (90, 70, 100), rng))
    found = placed_lines(body, strokes, view, REACH)
    ends = found.points[found.lines]
    assert np.abs(ends[2] - [(0, 70, 100), (90, 70, 100)]).max() < 4.0
    assert found.lines[2, 0] == found.lines[0, 1]


@pytest.mark.parametrize(
    "strokes", [[], [[(5.0, 5.0)]], [[(5.0, 5.0), (6.0, 5.0)]], [[(np.nan, 0.0), (100.0, 0.0)]]]
)
def test_strokes_that_are_no_lines_are_told(strokes):
    with pytest.raises(UserError):
        placed_lines(block(), strokes, camera("perspective"), REACH)


def test_lines_beside_the_body_are_somewhere_finite():
    view = camera("perspective")
    stroke = np.array([(5.0, 5.0), (60.0, 90.0)])
    assert np.isfinite(placed_lines(block(), [stroke], view, REACH).points).all()


# -- loops ---------------------------------------------------------------------------------------

LOOP = [(20, 15, 50), (60, 15, 50), (60, 45, 50), (20, 45, 50)]


def ring_strokes(view, loop, rng):
    return [line(view, a, b, rng) for a, b in zip(loop, loop[1:] + loop[:1], strict=True)]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("one_stroke", [True, False])
def test_a_loop_on_a_face_gets_the_directions_of_the_face(kind, one_stroke):
    body, view = block(), camera(kind)
    strokes = ring_strokes(view, LOOP, np.random.default_rng(3005))
    strokes = [np.vstack(strokes)] if one_stroke else [s[::-1] if k % 2 else s
                                                       for k, s in enumerate(strokes)]  # fmt: skip
    found = loop_on_face(body, strokes, view, 6.0)
    assert found.face == 1
    assert len(found.corners) == 4
    apart = np.linalg.norm(found.corners[:, None] - np.array(LOOP, float), axis=-1).min(axis=1)
    assert apart.max() < 3.0
    sides = np.roll(found.corners, -1, axis=0) - found.corners
    assert np.sort(np.abs(sides), axis=1)[:, :2].max() < 1e-9  # along the axes
    assert np.abs(found.corners[:, 2] - 50).max() < 1e-12
    assert area_vector(found.corners)[2] > 0


def test_a_side_on_an_edge_takes_its_line():
    """A slot that is open at the side: no thin wall is left."""
    body, view = block(), camera("perspective")
    loop = [(89, 15, 50), (60, 15, 50), (60, 45, 50), (89, 45, 50)]
    found = loop_on_face(body, ring_strokes(view, loop, np.random.default_rng(3006)), view, 10.0)
    assert found.corners[:, 0].max() == pytest.approx(90.0, abs=1e-12)
    slot = pushed(body, found.face, found.corners, -20.0)
    assert len(slot.faces) == 6 + 4
    assert genus_of(slot) == 0


def test_loops_off_the_body_or_open_are_told():
    view = camera("perspective")
    t = np.linspace(0, 2 * np.pi, 40)
    beside = np.c_[60 + 30 * np.cos(t), 60 + 30 * np.sin(t)]
    with pytest.raises(UserError, match="one face"):
        loop_on_face(block(), [beside], view, 6.0)
    with pytest.raises(UserError, match="close"):
        loop_on_face(block(), [line(view, *LOOP[:2])], view, 6.0)


@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("depth", [15.0, -4.0])
def test_a_pushed_loop_changes_the_volume_by_its_prism(name, depth):
    body = solid(name)
    for face in (0, len(body.faces) // 2):
        triangles = face_triangles(body.vertices, body.faces[face], body.normals[face])
        corners = body.vertices[triangles[0]]
        loop = corners.mean(axis=0) + 0.5 * (corners - corners.mean(axis=0))
        after = pushed(body, face, loop, depth)
        prism_volume = float(np.linalg.norm(area_vector(loop))) * depth
        assert off_planes(after) < 1e-9
        assert genus_of(after) == genus_of(body)
        if depth < 0 and name in ("pyramid4", "pyramid5", "frustum3"):
            continue  # near their edges they are thinner than that
        assert volume_of(after) - volume_of(body) == pytest.approx(prism_volume, rel=1e-9)


@pytest.mark.parametrize("seed", range(3020, 3024))
def test_a_loop_may_touch_a_corner_of_its_face(seed):
    """Rings of the face then touch in the corner; pushed in, a wall would have no thickness."""
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    body = block(turn)
    loop = np.array([(0, 0, 50), (40, 20, 50), (50, 50, 50), (20, 40, 50)], float) @ turn.T
    after = pushed(body, 1, loop, 12.0)
    area = float(np.linalg.norm(area_vector(loop)))
    assert volume_of(after) - volume_of(body) == pytest.approx(12.0 * area, rel=1e-9)
    assert off_planes(after) < 1e-9
    assert genus_of(after) == 0
    assert len(after.faces) == len(body.faces) + 5
    (top,) = (face for face in after.faces if len(face) == 2)
    assert len(set(top[0]) & set(top[1])) == 1
    brep = brep_with_cylinders(after, [])
    assert brep.is_closed
    assert len(brep_mesh(brep).faces) > 0
    with pytest.raises(UserError, match="touch so closely"):
        pushed(body, 1, loop, -12.0)


@pytest.mark.parametrize("name", ["frustum3", "pyramid4"])
def test_a_pocket_from_a_slanted_corner_has_walls(name):
    body = solid(name)
    face = min(range(len(body.faces)), key=lambda k: body.normals[k][2])
    ring = body.vertices[list(body.faces[face][0])]
    middle = ring.mean(axis=0)
    across = 0.1 * (ring[1] - ring[-1])
    loop = np.array((ring[0], 0.5 * (ring[0] + middle) + across, middle,
                     0.5 * (ring[0] + middle) - across))  # fmt: skip
    after = pushed(body, face, loop, 3.0)
    assert off_planes(after) < 1e-9
    assert genus_of(after) == 0
    added = 3.0 * float(np.linalg.norm(area_vector(loop)))
    assert volume_of(after) - volume_of(body) == pytest.approx(added, rel=1e-6)


@pytest.mark.parametrize("seed", range(3010, 3013))
def test_a_tunnel_both_ways_has_one_volume(seed):
    """Cut through by a loop; and drawn with a loop on either side and lines between (Masry)."""
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    body = block(turn)
    cut = pushed(body, 1, np.array(LOOP, float) @ turn.T, -np.inf)
    holes = [[(20, 15), (20, 45), (60, 45), (60, 15)]]
    vertices, faces, volume = prism([(0, 0), (90, 0), (90, 70), (0, 70)], 50.0, holes)
    lines = exact_body(Answer(vertices @ turn.T, faces, 1.0, 0.0, True), noise=0.0)
    assert genus_of(cut) == genus_of(lines) == 1
    assert volume_of(cut) == pytest.approx(volume_of(lines), rel=1e-12)
    assert volume_of(cut) == pytest.approx(volume, rel=1e-12)
    assert len(cut.faces) == len(lines.faces)
    assert np.allclose(np.sort(face_areas(cut)), np.sort(face_areas(lines)), rtol=1e-12)


def test_a_push_is_a_pure_function_of_its_depth():
    body = block()
    one, two = (pushed(body, 1, LOOP, -12.5) for _ in range(2))
    assert (one.vertices == two.vertices).all()
    assert one.faces == two.faces
    assert pushed(body, 1, LOOP, 0.0) is body


def test_faces_keep_their_numbers_when_a_loop_is_pushed():
    body = block()
    after = pushed(body, 1, LOOP, -12.5)
    assert np.abs(after.normals[:6] - body.normals).max() < 1e-12
    assert np.abs(after.offsets[:6] - body.offsets).max() < 1e-12


def test_many_pushes_stay_exact():
    body = block(np.linalg.qr(np.random.default_rng(3020).normal(size=(3, 3)))[0])
    for k in range(10):
        low = (8 + 14 * (k % 5), 8 + 14 * (k // 5))
        face = 1
        top = body.vertices[list(body.faces[face][0])]
        along, across = top[1] - top[0], top[3] - top[0]
        if np.linalg.norm(along) < np.linalg.norm(across):
            along, across = across, along
        along, across = along / np.linalg.norm(along), across / np.linalg.norm(across)
        loop = [top[0] + (low[0] + a) * along + (low[1] + b) * across
                for a, b in ((0, 0), (9, 0), (9, 9), (0, 9))]  # fmt: skip
        body = pushed(body, face, loop, -5.0 if k % 2 else 6.0)
    assert off_planes(body) < 1e-9
    assert genus_of(body) == 0


@pytest.mark.parametrize(
    "loop",
    [LOOP[:2], [*LOOP[:2], (np.nan, 0, 0)], [LOOP[0], LOOP[2], LOOP[1], LOOP[3]], [LOOP[0]] * 4],
)
def test_loops_that_are_none_are_told(loop):
    with pytest.raises(UserError):
        pushed(block(), 1, loop, 5.0)


def test_nothing_left_and_no_depth_are_told():
    whole = [(-5, -5, 50), (95, -5, 50), (95, 75, 50), (-5, 75, 50)]
    with pytest.raises(UserError, match="left"):
        pushed(block(), 1, whole, -np.inf)
    with pytest.raises(UserError):
        pushed(block(), 1, LOOP, float("nan"))


def test_a_drag_tells_its_depth():
    view = camera("perspective")
    start, normal = np.array((40.0, 30.0, 50.0)), np.array((0.0, 0.0, 1.0))
    for depth in (-20.0, 7.0, 35.0):
        pixel, _ = view.project([start + depth * normal])
        assert dragged_depth(view, normal, start, tuple(pixel[0])) == pytest.approx(depth)


# -- booleans ------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3030, 3033))
def test_the_volumes_of_union_difference_and_intersection_agree(seed):
    rng = np.random.default_rng(seed)
    names = rng.choice(list(SOLIDS), 2)
    one = solid(str(names[0]), seed)
    two = moved(solid(str(names[1]), seed + 500), rng.normal(0.0, 12.0, 3))
    union, both = combined(one, two, "union"), combined(one, two, "intersection")
    rest, other = combined(one, two, "difference"), combined(two, one, "difference")
    assert volume_of(union) + volume_of(both) == pytest.approx(volume_of(one) + volume_of(two))
    assert volume_of(rest) + volume_of(both) == pytest.approx(volume_of(one))
    assert volume_of(other) + volume_of(both) == pytest.approx(volume_of(two))
    assert max(map(off_planes, (union, both, rest, other))) < 1e-9
    swapped = combined(two, one, "union")
    assert volume_of(swapped) == pytest.approx(volume_of(union), rel=1e-12)
    assert len(swapped.faces) == len(union.faces)


def test_every_plane_of_a_result_is_a_plane_of_the_sources():
    one, two = solid("house", 3040), moved(solid("hexagon", 3041), (10.0, 5.0, 8.0))
    result = combined(one, two, "difference")
    known = np.vstack((np.c_[one.normals, one.offsets], -np.c_[two.normals, two.offsets]))
    for plane in np.c_[result.normals, result.offsets]:
        assert (np.abs(known - plane).max(axis=1) == 0.0).any()


def test_blocks_side_by_side_become_one_block():
    one, two = block(), moved(block(), (90.0, 0.0, 0.0))
    both = combined(one, two, "union")
    assert len(both.faces) == 6
    assert len(both.vertices) == 8
    assert volume_of(both) == pytest.approx(2 * volume_of(one), rel=1e-12)


# -- chamfers, mirrors, copies, joints -----------------------------------------------------------


@pytest.mark.parametrize("name", ["L", "house", "wedge"])
def test_a_chamfer_takes_or_adds_a_prism(name):
    body = solid(name, 3050)
    for one, two in edges_of(body.faces):
        after = chamfered(body, (int(one), int(two)), 5.0)
        assert off_planes(after) < 1e-9
        assert len(after.faces) == len(body.faces) + 1
        change = abs(volume_of(after) - volume_of(body))
        length = float(np.linalg.norm(body.vertices[two] - body.vertices[one]))
        assert 0.2 * 12.5 * length < change <= 12.5 * (length + 5.0)  # ends may be slanted


def test_chamfers_that_do_not_fit_are_told():
    for edge, width in (((0, 1), 80.0), ((0, 1), -1.0), ((0, 1), np.nan), ((0, 6), 5.0)):
        with pytest.raises(UserError):
            chamfered(block(), edge, width)


@pytest.mark.parametrize("name", SOLIDS)
def test_mirrored_twice_is_the_same(name):
    body = solid(name, 3060)
    once = mirrored(body, (1.0, 2.0, -0.5), 7.0)
    twice = mirrored(once, (1.0, 2.0, -0.5), 7.0)
    assert volume_of(once) == pytest.approx(volume_of(body))
    assert off_planes(once) < 1e-9
    assert np.abs(twice.vertices - body.vertices).max() < 1e-10
    assert twice.faces == body.faces


def test_a_body_joined_with_its_mirror_image_is_symmetric():
    body = block()
    whole = combined(body, mirrored(body, (1, 0, 0), 90.0), "union")
    assert len(whole.faces) == 6
    assert np.ptp(whole.vertices[:, 0]) == pytest.approx(180.0, rel=1e-14)


def test_copies_stand_at_even_steps():
    path = [(0, 0, 0), (300, 0, 0), (300, 300, 0)]
    copies = copied_along(block(), path, 4)
    corners = np.array([copy.vertices[0] for copy in copies])
    assert np.abs(corners - [(0, 0, 0), (200, 0, 0), (300, 100, 0), (300, 300, 0)]).max() < 1.0
    assert all(off_planes(copy) < 1e-9 for copy in copies)
    with pytest.raises(UserError):
        copied_along(block(), path[:1], 3)
    with pytest.raises(UserError):
        copied_along(block(), path, 0)


def test_strokes_from_corner_to_corner_join_two_solids():
    lower, upper = block(), moved(block(), (0.0, 0.0, 110.0))
    links = [(4, 0), (5, 1), (6, 2), (7, 3)]
    whole = joined(lower, upper, links)
    assert len(whole.faces) == 6
    assert volume_of(whole) == pytest.approx(90 * 70 * 160, rel=1e-12)
    aside = joined(lower, moved(upper, (40.0, 0.0, 0.0)), links)
    assert genus_of(aside) == 0
    assert volume_of(aside) == pytest.approx(90 * 70 * 160, rel=1e-12)  # Cavalieri
    twisted = joined(lower, upper, [(4, 1), (5, 2), (6, 3), (7, 0)])
    assert off_planes(twisted) < 1e-9
    with pytest.raises(UserError):
        joined(lower, upper, links[:2])


def test_prisms_look_outward_either_way():
    for depth in (20.0, -20.0):
        for loop in (LOOP, LOOP[::-1]):
            tool = prism_on(np.array((0.0, 0.0, 1.0)), 50.0, loop, depth)
            area = abs(polygon_area([p[:2] for p in loop]))
            assert volume_of(tool) == pytest.approx(20.0 * area)
            assert off_planes(tool) < 1e-12


# -- circles -------------------------------------------------------------------------------------


def ring_on(view, center, axis, radius, rng, wobble=0.01):
    """An ellipse on the sheet, with a slow wobble of the hand, as share of the radius."""
    across = tangents(np.asarray(axis, float))
    turn = rng.uniform(0, 2 * np.pi) + np.linspace(0.0, 2 * np.pi, 90)
    waves = sum(rng.normal() * np.cos(k * turn + rng.uniform(0, 6)) / k for k in (2, 3, 4))
    radii = radius * (1 + wobble * waves)
    points = np.add(center, (radii * (np.cos(turn), np.sin(turn))).T @ across)
    return view.project(points)[0]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3100, 3103))
def test_an_ellipse_on_a_face_is_a_circle(kind, seed):
    rng = np.random.default_rng(seed)
    view = camera(kind)
    stroke = ring_on(view, (45, 35, 50), (0, 0, 1), 20.0, rng)
    found = circle_on_face(block(), stroke, view)
    assert found is not None
    assert found.face == 1
    assert found.radius == pytest.approx(20.0, rel=0.03)
    assert np.linalg.norm(found.center - (45, 35, 50)) < 1.0
    after = pushed(block(), found.face, polygon_of(found), -10.0)
    removed = volume_of(block()) - volume_of(after)
    assert removed == pytest.approx(10.0 * np.pi * found.radius**2, rel=1e-9)


@pytest.mark.parametrize(
    ("ratio", "is_circle"), [(0.75, True), (1.3, True), (0.5, False), (1.8, False)]
)
def test_who_mistakes_how_a_face_is_turned_means_a_circle_all_the_same(ratio, is_circle):
    view = camera("orthographic")
    rng = np.random.default_rng(3105)
    turn = np.linspace(0.0, 2.0 * np.pi, 80)
    wobble = 1.0 + 0.01 * rng.normal(size=(80, 1))
    flat = wobble * 18.0 * np.column_stack((ratio * np.cos(turn), np.sin(turn)))
    points = np.column_stack((45.0 + flat[:, 0], 35.0 + flat[:, 1], np.full(80, 50.0)))
    found = circle_on_face(block(), view.project(points)[0], view)
    assert (found is not None) == is_circle
    if found is not None:
        assert min(ratio, 1.0) < found.radius / 18.0 < max(ratio, 1.0)


def test_a_square_on_a_face_is_no_circle():
    view = camera("perspective")
    stroke = np.vstack(ring_strokes(view, LOOP, np.random.default_rng(3110)))
    assert circle_on_face(block(), stroke, view) is None


def test_strokes_that_are_no_circles_are_told():
    view = camera("perspective")
    for stroke in ([], [(1.0, 2.0)] * 9, [(np.nan, 1.0)] * 9):
        with pytest.raises(UserError):
            circle_on_face(block(), stroke, view)


@pytest.mark.parametrize("depth", [-20.0, 15.0, -np.inf])
@pytest.mark.parametrize("seed", [3200])
def test_round_holes_and_bosses_are_exact(depth, seed):
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    body = block(turn)
    circle = Circle(np.array((45.0, 35.0, 50.0)) @ turn.T, body.normals[1], 18.0, 1, 0.0)
    made = brep_with_cylinders(pushed(body, 1, polygon_of(circle), depth), [circle])
    assert made.is_closed
    mesh = brep_mesh(made, 0.005)
    corners = mesh.vertices.astype(float)[mesh.faces]
    volume = float(np.einsum("tk,tk->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6
    change = np.pi * 18.0**2 * max(depth, -50.0)
    assert volume - volume_of(body) == pytest.approx(change, rel=2e-3)
    assert sum(face.surface.is_plane for face in made.faces) == 6 + (np.isfinite(depth))


def round_block(*pushes):
    """A block with circles on its top pushed one after another: ((x, y), radius, depth)."""
    body, circles = block(), []
    for (x, y), radius, depth in pushes:
        at = float(body.vertices[:, 2].max())
        top = int(np.flatnonzero((body.normals[:, 2] == 1.0) & (body.offsets == at))[0])
        circle = Circle(np.array((x, y, at)), body.normals[top], radius, top, 0.0)
        body = pushed(body, top, polygon_of(circle), depth)
        circles.append(circle)
    return body, circles


def test_a_stepped_shaft_has_two_cylinders():
    body, circles = round_block(((45, 35), 20.0, 30.0), ((45, 35), 10.0, 15.0))
    made = brep_with_cylinders(body, circles)
    assert made.is_closed
    assert len(walls_of(body, circles)[0]) == 2
    assert sum(face.surface.is_plane for face in made.faces) == 8


def test_cylinders_that_something_cuts_stay_flat_and_are_counted():
    """Two holes that overlap, and one that leaves by the side: still closed, still told."""
    for pushes, count in (
        ([((40, 35), 12.0, -20.0), ((55, 35), 12.0, -20.0)], 2),
        ([((5, 35), 12.0, -20.0)], 1),
    ):
        body, circles = round_block(*pushes)
        walls, cut = walls_of(body, circles)
        assert (len(walls), cut) == (0, count)
        assert brep_with_cylinders(body, circles).is_closed


def test_a_hole_through_two_walls_is_two_cylinders():
    body = pushed(block(), 2, [(0, 0, 20), (90, 0, 20), (90, 0, 30), (0, 0, 30)], -np.inf)
    top = int(np.flatnonzero((body.normals[:, 2] == 1.0) & (body.offsets == 50.0))[0])
    circle = Circle(np.array((45.0, 35.0, 50.0)), body.normals[top], 9.0, top, 0.0)
    body = pushed(body, top, polygon_of(circle), -np.inf)
    walls, cut = walls_of(body, [circle])
    assert (len(walls), cut) == (2, 0)
    assert all(wall.hollow for wall in walls)
    assert brep_with_cylinders(body, [circle]).is_closed
