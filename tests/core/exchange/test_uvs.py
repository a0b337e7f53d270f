"""Texture coordinates: charts that cover each other nowhere, and what the files say of them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bozzetto.errors import Cancelled
from bozzetto.exchange.export import prepare_export, prepare_file
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.mesh.picture_places import STEP
from bozzetto.exchange.ready_shapes import Ready
from bozzetto.geometry import Mesh, Shapes, Solid
from bozzetto.geometry.atlas.chart_flattening import areas
from bozzetto.geometry.atlas.unwrapping import Atlas, unwrapped, unwrapped_together
from tests.core.exchange.atlas_pictures import drawn_out, least_gap, overlapping
from tests.core.exchange.skinned import skinned
from tests.core.exchange.test_handover import ball
from tests.core.exchange.test_skins import opened


def box() -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([[x, y, z] for x in (0, 3.0) for y in (0, 2.0) for z in (0, 1.0)])
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    return corners, np.array(
        [*faces, [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    )


def torus(around: int = 40, across: int = 16) -> tuple[np.ndarray, np.ndarray]:
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = 2 * np.pi * u / around, 2 * np.pi * v / across
    wide = 20.0 + 7.0 * np.cos(b)
    points = np.stack([wide * np.cos(a), 7.0 * np.sin(b), -wide * np.sin(a)], 2).reshape(-1, 3)
    at = lambda i, j: (i % around) * across + j % across  # noqa: E731
    one, two, three, four = at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1)
    faces = np.stack([one, two, three, one, three, four], 2).reshape(-1, 3)
    return points, faces


def helix(turns: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """A ramp that lies over itself when it is seen from above."""
    angle = np.linspace(0.0, 2 * np.pi * turns, 30 * turns)
    inner = np.column_stack([4 * np.cos(angle), 4 * np.sin(angle), angle])
    outer = np.column_stack([9 * np.cos(angle), 9 * np.sin(angle), angle])
    points = np.stack([inner, outer], 1).reshape(-1, 3)
    k = 2 * np.arange(len(angle) - 1)
    return points, np.concatenate([
        np.column_stack([k, k + 1, k + 3]), np.column_stack([k, k + 3, k + 2])
    ])  # fmt: skip


def sphere() -> tuple[np.ndarray, np.ndarray]:
    mesh = ball()
    return mesh.vertices.astype(float), mesh.faces


BODIES = {"ball": sphere, "box": box, "ramp": helix, "ring": torus}


@cache
def laid(name: str) -> Atlas:
    """The atlas of a body, once for all laws."""
    return unwrapped(*BODIES[name]())


@pytest.mark.parametrize("name", BODIES)
def test_nothing_lies_over_anything_else_or_is_mirrored(name):
    import shapely

    atlas = laid(name)
    assert atlas.corners.min() >= 0.0
    assert atlas.corners.max() <= 1.0
    size = areas(atlas.corners)
    assert (size < 0.0).all()  # v runs down: seen from outside, as it is
    whole = shapely.union_all(shapely.polygons(atlas.corners))
    assert whole.area == pytest.approx(-size.sum(), rel=1e-6)


@pytest.mark.parametrize("side", [512, 1024, 2048])
@pytest.mark.parametrize("name", BODIES)
def test_texels_are_of_one_chart_and_charts_as_far_apart_as_said(name, side):
    atlas = laid(name)
    assert overlapping(atlas.corners, atlas.chart, side) == 0
    assert least_gap(atlas.corners, atlas.chart, side) >= side / 256 - 1.0


def folded_ball() -> tuple[np.ndarray, np.ndarray]:
    """A ball with thin folds: some vertices lie a little beyond those beside them."""
    points, faces = sphere()
    random = np.random.default_rng(910_500)
    for one, other in faces[random.choice(len(faces), 25, replace=False), :2]:
        points[one] = points[other] + 0.02 * (points[other] - points[one])
    return points, faces


def test_thin_folds_do_not_make_charts_of_their_own():
    points, faces = folded_ball()
    atlas = unwrapped(points, faces)
    plain = laid("ball")
    assert atlas.chart.max() <= plain.chart.max() + 4
    size = -areas(atlas.corners)
    assert -size[size < 0.0].sum() < 2e-4 * size.sum()


@pytest.mark.parametrize("name", BODIES)
def test_charts_are_drawn_out_little(name):
    points, faces = BODIES[name]()
    atlas = laid(name)
    stretch = drawn_out(points, faces, atlas.corners * atlas.side)
    assert np.quantile(stretch[:, 0], 0.98) < 2.0
    assert np.quantile(stretch[:, 1], 0.02) > 0.5


@pytest.mark.parametrize("name", BODIES)
def test_charts_keep_a_cell_of_256_apart(name):
    import shapely

    atlas = laid(name)
    charts = [
        shapely.union_all(shapely.polygons(atlas.corners[atlas.chart == k]))
        for k in range(int(atlas.chart.max()) + 1)
    ]
    apart = [a.distance(b) for k, a in enumerate(charts) for b in charts[:k]]
    assert min(apart, default=1.0) > 0.98 / 256


@pytest.mark.parametrize(
    ("name", "least"), [("ball", 0.66), ("box", 0.78), ("ramp", 0.5), ("ring", 0.6)]
)
def test_the_square_is_full_as_a_picture_shows(name, least):
    """Drawn by another program: every texel that a triangle covers counts once."""
    from PIL import Image, ImageDraw

    side = 1024
    picture = Image.new("1", (side, side))
    draw = ImageDraw.Draw(picture)
    for corners in laid(name).corners * side:
        draw.polygon([(float(x), float(y)) for x, y in corners], fill=1)
    share = float(np.asarray(picture).mean())
    assert share > least


@pytest.mark.parametrize(("name", "most"), [("ball", 8), ("box", 6), ("ramp", 12), ("ring", 12)])
def test_charts_are_few(name, most):
    assert laid(name).chart.max() < most


@pytest.mark.parametrize("turns", [1, 2, 5])
def test_a_winding_ramp_has_no_more_than_four_charts_a_turn(turns):
    assert unwrapped(*helix(turns)).chart.max() < 4 * turns


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_size_and_place_change_nothing_and_twice_is_the_same(factor):
    points, faces = torus(24, 10)
    points = points * (1.4, 1.0, 1.0)  # about no axis turns to itself, so that nothing is a tie
    one, two = unwrapped(points, faces), unwrapped(points * factor, faces)
    np.testing.assert_array_equal(one.corners, unwrapped(points, faces).corners)
    np.testing.assert_array_equal(one.chart, two.chart)
    assert two.side == pytest.approx(factor * one.side, rel=1e-6)


def test_a_glb_has_them_beside_its_colours_and_bones():
    mesh = ball()
    colors = np.full((len(mesh.vertices), 4), (200, 30, 10, 255), np.uint8)
    shapes = Shapes(
        solids=(skinned(5, 40.0, turned=True), Solid(replace(mesh, colors=colors), "ball"))
    )
    gltf, _ = opened(prepare_export(shapes, "a.glb", handover=Handover(uvs=True)).data)
    for record, named in zip(gltf["meshes"], ("JOINTS_0", "COLOR_0"), strict=True):
        for primitive in record["primitives"]:
            found = primitive["attributes"]
            assert {"TEXCOORD_0", "NORMAL", named} <= set(found)
            assert len({gltf["accessors"][k]["count"] for k in found.values()}) == 1
    assert "images" not in gltf


def test_the_shape_is_the_same_with_and_without(tmp_path):
    points, faces = torus()
    shapes = Shapes(solids=(Solid(Mesh(points.astype(np.float32), faces.astype(np.int32)), "a"),))
    for name, uvs in (("with", True), ("without", False)):
        made = prepare_export(shapes, "a.glb", handover=Handover(uvs=uvs))
        made.write(tmp_path / f"{name}.glb")
    one, two = (read_mesh_file(tmp_path / f"{n}.glb") for n in ("with", "without"))
    a, b = (next(iter(s.shapes.meshes())).mesh for s in (one, two))
    np.testing.assert_array_equal(a.vertices[a.faces], b.vertices[b.faces])


@pytest.mark.parametrize("ending", ["glb", "obj", "usda", "usdz"])
def test_making_them_tells_how_far_it_is_and_stops_when_nobody_waits(ending):
    told: list[float] = []

    def watched(done: float, step: str) -> None:
        assert step == STEP
        told.append(done)

    def stopped(done: float, step: str) -> None:
        if done > 0.85:
            raise Cancelled(step)

    shapes = Shapes(solids=(Solid(ball(), "ball"),))
    wanted, path = Handover(uvs=True), f"a.{ending}"
    prepare_file(Ready(shapes, wanted, watched), path, None)
    assert told == sorted(told)
    assert told[0] == 0.0
    assert told[-1] > 0.9
    assert np.diff(told).max() < 0.55
    with pytest.raises(Cancelled):
        prepare_file(Ready(shapes, wanted, stopped), path, None)
    told.clear()
    prepare_file(Ready(shapes, Handover(), watched), path, None)
    assert told == []


def test_other_formats_say_that_they_have_none():
    shapes = Shapes(solids=(Solid(ball(), "ball"),))
    notes = prepare_export(shapes, "a.stl", handover=Handover(uvs=True)).notes
    assert any("UVs" in note for note in notes)


@cache
def three() -> Shapes:
    """A ring, a box and a screw a hundredth as large, apart."""
    parts = [(torus(), 0.0, 1.0), (box(), 60.0, 5.0), (torus(12, 6), 90.0, 0.05)]
    solids = [
        Solid(Mesh((points * size + (x, 0, 0)).astype(np.float32), faces.astype(np.int32)), name)
        for ((points, faces), x, size), name in zip(parts, ("ring", "box", "screw"), strict=True)
    ]
    return Shapes(solids=tuple(solids))


def test_all_parts_share_one_square_at_one_scale():
    import shapely

    parts = [part.mesh for part in three().meshes()]
    laid = unwrapped_together([(mesh.vertices.astype(float), mesh.faces) for mesh in parts])
    corners = np.concatenate([one.corners for one in laid])
    whole = shapely.union_all(shapely.polygons(corners))
    assert whole.area == pytest.approx(np.abs(areas(corners)).sum(), rel=1e-6)
    for mesh, one in zip(parts, laid, strict=True):
        a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
        surface = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
        assert np.abs(areas(one.corners)).sum() * one.side**2 == pytest.approx(surface, rel=1e-3)
    numbers = [set(one.chart.tolist()) for one in laid]
    assert not numbers[0] & numbers[1]
    assert not numbers[1] & numbers[2]


def in_glb(path):
    import trimesh

    scene = trimesh.load(path, process=False)
    return [(one.vertices, one.faces, one.visual.uv) for one in scene.geometry.values()]


def in_obj(path):
    """Read by hand: places of vertices, faces, and places in the picture with v up."""
    rows: dict[str, list[list[str]]] = {"v": [], "vt": [], "f": []}
    for line in path.read_text().splitlines():
        word, *rest = line.split()
        if word in rows:
            rows[word].append(rest)
    corner = np.array([[[int(k) for k in word.split("/")] for word in face] for face in rows["f"]])
    points, places = np.array(rows["v"], float)[:, :3], np.array(rows["vt"], float)
    count = corner[..., 0].size
    return [(points[corner[..., 0] - 1].reshape(-1, 3), np.arange(count).reshape(-1, 3),
             places[corner[..., 1] - 1].reshape(-1, 2))]  # fmt: skip


@pytest.mark.parametrize("ending", ["glb", "obj"])
def test_a_file_of_several_parts_holds_one_picture_for_all(tmp_path, ending):
    if ending == "glb":
        pytest.importorskip("trimesh")
    import shapely

    path = tmp_path / f"a.{ending}"
    prepare_export(three(), path.name, handover=Handover(uvs=True)).write(path)
    found = (in_glb if ending == "glb" else in_obj)(path)
    assert len(found) == (3 if ending == "glb" else 1)
    corners = np.concatenate([uv[faces] for _, faces, uv in found])
    assert 0.0 <= corners.min() <= corners.max() <= 1.0
    assert (areas(corners) > 0.0).all()  # v up: seen from outside, not mirrored
    whole = shapely.union_all(shapely.polygons(corners), grid_size=1e-7)
    assert whole.area == pytest.approx(areas(corners).sum(), rel=1e-3)


def test_an_obj_without_them_has_none(tmp_path):
    prepare_export(three(), "a.obj", handover=Handover()).write(tmp_path / "a.obj")
    assert "\nvt " not in (tmp_path / "a.obj").read_text()
    assert "\nmtllib" in (tmp_path / "a.obj").read_text()
