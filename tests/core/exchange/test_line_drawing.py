"""Line drawings: what is seen is compared with rays, outlines with the shadows of the things."""

from __future__ import annotations

import time
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.exchange.export import prepare_export
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.import_file import read_drawing
from bozzetto.exchange.line_drawing.blueprint import SCALES, SHEET, blueprint_page
from bozzetto.exchange.line_drawing.page import net_to_draw, outlines_page, parallel_lines
from bozzetto.geometry import Curve, Mesh, Placement, Shapes, Solid, Surface
from bozzetto.view.camera import Camera
from bozzetto.view.page_views import framing

FRONT = np.array([[1.0, 0, 0], [0, 0, 1], [0, 1, 0]])


def manifold_mesh(made):
    mesh = made.to_mesh()
    return Mesh(mesh.vert_properties[:, :3], mesh.tri_verts)


def block(size=(30.0, 20.0, 10.0), at=(0.0, 0.0, 0.0)):
    import manifold3d

    return manifold_mesh(manifold3d.Manifold.cube(size).translate(at))


def ball(radius=10.0, at=(0.0, 0.0, 0.0), segments=64):
    import manifold3d

    return manifold_mesh(manifold3d.Manifold.sphere(radius, segments).translate(at))


def ring(inner=4.0, outer=12.0):
    import manifold3d

    section = manifold3d.CrossSection.circle(inner, 32).translate((outer, 0))
    return manifold_mesh(section.revolve(96))


def of(*meshes):
    return Shapes(solids=tuple(Solid(mesh, f"part {k}") for k, mesh in enumerate(meshes)))


def lengths(lines, *, visible):
    return sum(
        np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum()
        for line in lines
        if line.visible is visible
    )


def axes_of(seed):
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn)) * np.array([[1.0], [1.0], [-1.0]])


def test_a_block_from_the_front_is_a_rectangle_and_hides_another():
    lines = parallel_lines(net_to_draw(of(block())), FRONT)
    # Edges along the line of sight are points; the far rectangle lies behind the near one.
    assert lengths(lines, visible=True) == pytest.approx(2 * (30 + 10), rel=1e-6)
    assert lengths(lines, visible=False) == pytest.approx(2 * (30 + 10), rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_of_a_block_nine_edges_are_seen_and_three_are_not(seed):
    axes = axes_of(seed)
    lines = parallel_lines(net_to_draw(of(block())), axes)
    edges = [np.linalg.norm(axes[:2, k]) * size for k, size in enumerate((30.0, 20.0, 10.0))]
    assert lengths(lines, visible=True) == pytest.approx(3 * sum(edges), rel=1e-6)
    assert lengths(lines, visible=False) == pytest.approx(sum(edges), rel=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_the_outline_of_a_ball_is_a_circle_and_nothing_else_is_seen(seed):
    lines = parallel_lines(net_to_draw(of(ball())), axes_of(seed))
    seen = [line for line in lines if line.visible]
    points = np.concatenate([line.points for line in seen])
    assert np.linalg.norm(points, axis=1).min() > 9.9
    assert np.linalg.norm(points, axis=1).max() < 10.001
    assert lengths(lines, visible=True) == pytest.approx(2 * np.pi * 10, rel=0.01)


def shadow(mesh, axes):
    """The union of all triangles as they are seen, by shapely."""
    import shapely

    places = mesh.vertices.astype(float) @ axes.T[:, :2] * (1, -1)
    triangles = shapely.polygons(places[mesh.faces])
    return shapely.union_all(triangles[shapely.area(triangles) > 1e-9])


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("make", [ball, ring, block])
def test_the_border_of_the_shadow_is_drawn_and_nothing_is_drawn_outside(make, seed):
    import shapely

    mesh, axes = make(), axes_of(seed)
    lines = parallel_lines(net_to_draw(of(mesh)), axes)
    drawn = shapely.union_all(shapely.linestrings([])) if not lines else shapely.union_all(
        [shapely.LineString(line.points) for line in lines if line.visible]
    )  # fmt: skip
    border = shadow(mesh, axes).boundary
    assert border.difference(drawn.buffer(0.02)).length < 0.01 * border.length
    assert drawn.difference(shadow(mesh, axes).buffer(0.02)).length == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_of_what_stands_behind_others_is_seen_what_they_leave_free(seed):
    """Blocks at different depths, by shapely's difference of rectangles."""
    import shapely

    chance = np.random.default_rng(seed)
    meshes, boxes = [], []
    for k in range(9):
        x, z = chance.uniform(-30, 30, 2)
        wide, tall = chance.uniform(5, 40, 2)
        meshes.append(block((wide, 2.0, tall), (x, 5.0 * k, z)))
        low, high = meshes[-1].bounds
        boxes.append(shapely.box(low[0], low[2], high[0], high[2]))
    nearer = shapely.Polygon()
    expected = 0.0
    for box in boxes:
        expected += box.boundary.difference(nearer).length
        nearer = nearer.union(box)
    order = chance.permutation(len(meshes))
    lines = parallel_lines(net_to_draw(of(*(meshes[k] for k in order))), FRONT)
    assert lengths(lines, visible=True) == pytest.approx(expected, rel=1e-4)


def test_lines_are_drawn_where_solids_pass_through_one_another():
    """A thin bar through a block is seen where it comes out, and the place is drawn."""
    shapes = of(block((20, 20, 20), (-10, -10, -10)), block((4, 40, 4), (-2, -20, -2)))
    lines = parallel_lines(net_to_draw(shapes), np.array([[0.0, 1, 0], [0, 0, 1], [-1, 0, 0]]))
    # From the right: a square of 20, and to either side of it three edges of the bar.
    assert lengths(lines, visible=True) == pytest.approx(4 * 20 + 2 * (10 + 10 + 4), rel=1e-5)
    assert {line.name for line in lines if line.visible} == {"part 0", "part 1"}


def test_a_picture_moves_and_grows_with_the_things():
    mesh, axes = ring(), axes_of(7)
    here = parallel_lines(net_to_draw(of(mesh)), axes)
    there = mesh.placed(Placement(scale=3.0, offset=(50.0, -20.0, 7.0)))
    moved = parallel_lines(net_to_draw(of(there)), axes)
    for visible in (True, False):
        grown = 3.0 * lengths(here, visible=visible)
        assert lengths(moved, visible=visible) == pytest.approx(grown, rel=0.02)


def test_both_sides_of_an_open_surface_hide():
    sheet = Mesh([[-20, -5, -20], [20, -5, -20], [20, -5, 20], [-20, -5, 20]],
                 [[0, 1, 2], [0, 2, 3]])  # fmt: skip
    for mesh in (sheet, Mesh(sheet.vertices, sheet.faces[:, ::-1])):
        shapes = Shapes(solids=(Solid(ball(), "b"),), surfaces=(Surface(mesh, "s"),))
        lines = parallel_lines(net_to_draw(shapes), FRONT)
        assert {line.name for line in lines if line.visible} == {"s"}
        assert lengths(lines, visible=True) == pytest.approx(160, rel=1e-6)


def test_drawn_curves_are_seen_on_what_they_lie_and_not_behind_it():
    line = np.array([[-10.0, 0, 5], [40, 0, 5]])
    front = Curve(1, [0, 0, 1, 1], line, name="front")
    back = Curve(1, [0, 0, 1, 1], line + np.array([0, 20, 0]), name="back")
    shapes = Shapes(solids=(Solid(block(), "b"),), curves=(front, back))
    lines = parallel_lines(net_to_draw(shapes), FRONT)
    own = [one for one in lines if one.name == "front"]
    far = [one for one in lines if one.name == "back"]
    assert lengths(own, visible=True) == pytest.approx(50, rel=1e-6)
    assert lengths(far, visible=True) == pytest.approx(20, rel=1e-6)
    assert lengths(far, visible=False) == pytest.approx(30, rel=1e-6)


def test_perspective_shows_near_things_larger_and_draws_nothing_behind_the_eye():
    camera = framing(block().vertices, "three-quarter")
    page = outlines_page(of(block()), camera, hidden=False)
    assert page.unit == "px"
    assert (page.width, page.height) == camera.viewport
    assert all(line.layer == "visible" for line in page.lines)
    # The corners of the picture are those of the block.
    corners, _ = camera.project(np.unique(block().vertices, axis=0))
    for point in np.concatenate([line.points for line in page.lines]):
        assert np.linalg.norm(corners - point, axis=1).min() < 1e-3
    away = Camera(eye=(0.0, 500.0, 0.0), target=(0.0, 900.0, 0.0))
    with pytest.raises(UserError, match="behind the eye"):
        outlines_page(of(block()), away, hidden=True)


def test_nothing_to_draw_is_said():
    with pytest.raises(UserError, match="nothing to draw"):
        blueprint_page(Shapes(), "x", hidden=False)


@pytest.mark.parametrize(
    "size", [(30, 20, 10), (4500, 1800, 1400), (1, 400, 3), (0.2, 0.1, 0.3), (5, 5, 900)]
)
def test_a_blueprint_has_true_scale_and_dimensions_and_stays_in_its_frame(size):
    page = blueprint_page(of(block(size)), "block", hidden=False)
    words = [text.words for text in page.texts]
    for value in size:
        assert f"{value:.4g}" in words
    ratio = next(word for word in words if word.startswith("Scale")).split()[1::2]
    scale = float(ratio[0]) / float(ratio[1])
    assert any(scale == pytest.approx(one) for one in SCALES)
    everything = np.concatenate([line.points for line in page.lines])
    assert (everything >= 0).all()
    assert (everything <= SHEET).all()
    drawn = [line.points for line in page.lines if line.layer == "visible"]
    widths = {round(float(np.ptp(row[:, 0])) / scale / size[0], 3) for row in drawn}
    assert 1.0 in widths


def words_box(text):
    """The rectangle of a dimension's number or of words in the title block."""
    import shapely

    x, y = text.place
    wide = 0.6 * text.height * len(text.words)
    if text.upwards:
        return shapely.box(x - 0.7 * text.height, y - wide / 2, x, y + wide / 2)
    left = x - wide / 2 if text.centered else x
    return shapely.box(left, y - 0.7 * text.height, left + wide, y)


@pytest.mark.parametrize("seed", range(914_300, 914_340))
def test_nothing_on_a_blueprint_lies_on_anything_else(seed):
    """Of things of any size and shape; numbers stay free of lines, and views of one another."""
    import shapely

    random = np.random.default_rng(seed)
    size = 10.0 ** random.uniform(-4, 8) * 10.0 ** random.uniform(-2.5, 0.0, 3)
    page = blueprint_page(of(block(size.tolist())), "block", hidden=True)
    sheet = shapely.box(20.0, 10.0, SHEET[0] - 10.0, SHEET[1] - 10.0)
    drawn = [(line.layer, shapely.LineString(line.points)) for line in page.lines]
    boxes = [words_box(text) for text in page.texts]
    assert all(sheet.contains(box) for box in boxes)
    for k, box in enumerate(boxes):
        assert not any(box.intersects(other) for other in boxes[:k]), page.texts[k]
        assert not any(box.intersects(line) for _, line in drawn), page.texts[k]
    assert all(line.within(sheet) for layer, line in drawn if layer != "frame")
    views = [line.buffer(0.5) for layer, line in drawn if layer in ("visible", "hidden")]
    views = shapely.get_parts(shapely.union_all(views))
    hulls = [shapely.box(*view.bounds) for view in views]
    assert len(hulls) == 4
    title = shapely.box(SHEET[0] - 190.0, SHEET[1] - 37.0, SHEET[0] - 10.0, SHEET[1] - 10.0)
    for k, hull in enumerate(hulls):
        assert not any(hull.intersects(other) for other in [*hulls[:k], title, *boxes])
    largest = max(max(hull.bounds[2] - hull.bounds[0], hull.bounds[3] - hull.bounds[1])
                  for hull in hulls)  # fmt: skip
    assert largest > 60.0


def test_what_is_flat_has_two_dimensions_and_numbers_have_no_exponents():
    corners = np.array([[0, 0, 0], [80, 0, 0], [80, 50, 0], [0, 50, 0]], np.float32)
    sheet = Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    page = blueprint_page(Shapes(surfaces=(Surface(sheet, "sheet"),)), "a", hidden=False)
    assert [text.words for text in page.texts if text.centered] == ["80", "50"]
    page = blueprint_page(of(block((45_678_900, 4e5, 0.5))), "a", hidden=False)
    assert [text.words for text in page.texts if text.centered] == ["45678900", "400000"]
    page = blueprint_page(of(block((0.000012, 0.00002, 0.00003))), "a", hidden=False)
    assert [text.words for text in page.texts][:3] == ["0.000012", "0.00003", "0.00002"]


def test_dimensions_are_in_the_unit_asked_for():
    page = blueprint_page(of(block((254.0, 508.0, 127.0))), "block", "in", hidden=False)
    words = {text.words for text in page.texts}
    assert {"10", "20", "5", "Dimensions in in"} <= words


def test_a_drawing_in_svg_has_layers_ids_and_true_size(tmp_path):
    wanted = Handover(lines="outlines", hidden=True)
    shapes = of(block())
    made = prepare_export(shapes, "a.svg", handover=wanted)
    root = ElementTree.fromstring(made.data)
    assert root.get("width").endswith("mm")
    assert float(root.get("width")[:-2]) == pytest.approx(33)
    ids = [one.get("id") for one in root.iter() if one.get("id")]
    assert len(ids) == len(set(ids))
    assert {"visible", "hidden"} <= set(ids)
    assert "part 0" in {one.get("data-part") for one in root.iter()}
    (tmp_path / "a.svg").write_bytes(made.data)
    back = read_drawing(tmp_path / "a.svg", trusted=True)
    points = np.concatenate([stroke.points for stroke in back.strokes])
    assert np.ptp(points[:, 0]) == pytest.approx(30, rel=1e-4)
    assert made.data == prepare_export(shapes, "a.svg", handover=wanted).data


@pytest.mark.parametrize("size", [1e-4, 1.0, 1e7])
@pytest.mark.parametrize("away", [0.0, 3e3])
def test_outlines_look_the_same_at_any_size_and_place(size, away):
    """Lines are as wide, and places as exact, as those of the same thing at the origin."""
    turned = Handover(lines="outlines", hidden=True)

    def seen(scale, offset):
        mesh = block((30.0 * scale, 20.0 * scale, 2.0 * scale))
        mesh = Mesh(mesh.vertices.astype(float) + offset, mesh.faces)
        made = prepare_export(of(mesh), "a.svg", handover=turned).data
        root = ElementTree.fromstring(made)
        corner = np.array(root.get("viewBox").split(), float)
        widths = [float(one.get("stroke-width")) for one in root.iter() if one.get("stroke-width")]
        rows = [one.get("d").strip("MZ").split("L") for one in root.iter() if one.get("d")]
        places = [np.array([pair.split(",") for pair in row], float) for row in rows]
        assert all(np.ptp(row, axis=0).max() > 0.0 for row in places)
        return [
            np.array(widths) / scale,
            corner[2:] / scale,
            *((row - corner[:2]) / scale for row in places),
        ]

    usual, found = seen(1.0, 0.0), seen(size, away * 30.0 * size)
    assert usual[0].max() > 0.03
    for one, other in zip(usual, found, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-2, atol=0.02)


def test_a_drawing_in_dxf_has_layers_and_millimetres():
    ezdxf = pytest.importorskip("ezdxf")
    import io

    made = prepare_export(of(block()), "a.dxf", handover=Handover(lines="blueprint", hidden=True))
    document = ezdxf.read(io.StringIO(made.data.decode()))
    assert document.header["$INSUNITS"] == 4
    layers = {entity.dxf.layer for entity in document.modelspace()}
    assert layers == {"visible", "hidden", "dimensions", "frame"}
    assert "30" in {one.dxf.text for one in document.modelspace().query("TEXT")}
    assert not document.audit().errors


@pytest.mark.quiet
def test_fifty_thousand_triangles_take_less_than_five_seconds():
    mesh = ball(50.0, segments=320)
    assert len(mesh.faces) > 50_000
    begin = time.perf_counter()
    blueprint_page(of(mesh), "ball", hidden=True)
    assert time.perf_counter() - begin < 5.0
