"""Hand-over: unit, axes, size, triangles and lying flat, the same for every format."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.exchange.export import export, prepare_export
from bozzetto.exchange.formats import FORMATS
from bozzetto.exchange.handover import MM_PER, FileFrame, Handover
from bozzetto.exchange.import_file import read_mesh
from bozzetto.exchange.mesh.manifold_check import bounds_volume, check_solid, enclosed_volume
from bozzetto.exchange.ready_shapes import Ready
from bozzetto.exchange.triangle_budget import triangle_count, within_budget
from bozzetto.geometry import (
    Curve,
    FaceGroup,
    Mesh,
    Placement,
    Shapes,
    Solid,
    Surface,
    closest_on_mesh,
    mesh_points,
)
from bozzetto.geometry.decimation import decimated
from bozzetto.geometry.resting_place import lying_flat


def ball(radius=20.0, segments=48):
    import manifold3d

    made = manifold3d.Manifold.sphere(radius, segments).to_mesh()
    return Mesh(made.vert_properties[:, :3], made.tri_verts)


def ring():
    import manifold3d

    made = manifold3d.CrossSection.circle(4, 24).translate((20, 0)).revolve(64).to_mesh()
    return Mesh(made.vert_properties[:, :3], made.tri_verts)


def block(size=(10.0, 20.0, 30.0), refined=1):
    import manifold3d

    made = manifold3d.Manifold.cube(size).refine(refined).to_mesh()
    return Mesh(made.vert_properties[:, :3], made.tri_verts)


BLOCK = Shapes(solids=(Solid(block(), "block"),))


# -- unit and axes -----------------------------------------------------------------------------


def stl_points(data):
    count = struct.unpack_from("<I", data, 80)[0]
    rows = np.frombuffer(data, np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("s", "<u2")]),
                         count, 84)  # fmt: skip
    return rows["c"].reshape(-1, 3)


def obj_points(data):
    rows = [line.split()[1:4] for line in data.decode().splitlines() if line.startswith("v ")]
    return np.array(rows, float)


@pytest.mark.parametrize("unit", list(MM_PER))
@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize(("ending", "points"), [("stl", stl_points), ("obj", obj_points)])
def test_numbers_are_in_the_unit_and_the_axes_asked_for(unit, up, ending, points):
    made = prepare_export(BLOCK, f"a.{ending}", handover=Handover(unit=unit, up=up))
    found = np.ptp(points(made.data), axis=0) * MM_PER[unit]
    expected = (10, 30, 20) if up == "y" else (10, 20, 30)
    np.testing.assert_allclose(found, expected, rtol=1e-5)
    assert str(FileFrame(unit, up)).encode() in made.data[:200]


def test_the_change_of_axes_is_a_turn_and_no_mirror():
    placement = FileFrame("in", "y").placement
    assert not placement.mirrors
    np.testing.assert_allclose(placement.points([[0, 0, 25.4]]), [[0, 1, 0]], atol=1e-12)


def test_a_format_that_has_its_own_unit_says_so_and_keeps_it():
    plain = prepare_export(BLOCK, "a.glb")
    asked = prepare_export(BLOCK, "a.glb", handover=Handover(unit="in", up="z"))
    assert asked.data == plain.data
    assert plain.notes == ()
    assert "metres" in asked.notes[0]
    assert "Y up" in asked.notes[1]
    assert set(asked.notes) <= set(asked.warnings())
    assert prepare_export(BLOCK, "a.glb", handover=Handover(unit="m", up="y")).notes == ()


@pytest.mark.parametrize(
    "wrong",
    [{"unit": "ft"}, {"up": "x"}, {"scale": 0.0}, {"scale": float("nan")}, {"triangles": 3},
     {"lines": "art"}, {"scale": float("inf")}, {"scale": -1.0}],
)  # fmt: skip
def test_what_cannot_be_is_refused(wrong):
    with pytest.raises(UserError):
        Handover(**wrong)


def test_scale_makes_the_things_larger_in_every_format():
    for one in FORMATS:
        if one.writes and "mesh" in one.holds:
            made = Ready(BLOCK, Handover(scale=2.5))
            np.testing.assert_allclose(made.size, (25, 50, 75))


# -- OBJ and what lies beside it ---------------------------------------------------------------


def test_obj_names_its_materials_and_they_have_the_colours(tmp_path):
    groups = (FaceGroup("red side", 6, (255, 0, 0)), FaceGroup("steel", 6, finish="metal"))
    shapes = Shapes(
        solids=(Solid(block(), "a b", (0, 0, 255), groups=groups), Solid(block(), "a b")),
    )
    export(shapes, tmp_path / "my part.obj")
    text = (tmp_path / "my part.obj").read_text().splitlines()
    library = next(line for line in text if line.startswith("mtllib")).split()[1]
    said = (tmp_path / library).read_text()
    blocks = {one.splitlines()[0]: one for one in said.split("newmtl ")[1:]}
    used = [line.split()[1] for line in text if line.startswith("usemtl")]
    assert sorted(used) == sorted(blocks)
    assert len(set(used)) == 3
    assert "Kd 1.0000 0.0000 0.0000" in blocks["red_side"]
    assert "Kd 0.0000 0.0000 1.0000" in blocks["steel"]
    assert "Pm 1.0000" in blocks["steel"]
    assert "Kd 1.0000 1.0000 1.0000" in blocks["a_b"]


def test_normals_of_obj_are_those_of_the_faces_where_edges_are_sharp(tmp_path):
    made = prepare_export(BLOCK, "a.obj", handover=Handover(up="z"))
    lines = made.data.decode().splitlines()
    places = np.array([line.split()[1:4] for line in lines if line.startswith("v ")], float)
    normals = np.array([line.split()[1:] for line in lines if line.startswith("vn ")], float)
    for line in (line for line in lines if line.startswith("f ")):
        corner, normal = np.array([word.split("//") for word in line.split()[1:]], int).T - 1
        a, b, c = places[corner]
        across = np.cross(b - a, c - a)
        across /= np.linalg.norm(across)
        np.testing.assert_allclose(normals[normal], np.tile(across, (3, 1)), atol=1e-4)


# -- fewer triangles ---------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.5, 0.2, 0.05])
@pytest.mark.parametrize(
    ("make", "genus", "lost", "off"),
    [(ball, 0, 16.0, 600.0), (ring, 1, 30.0, 600.0), (lambda: block(refined=8), 0, 1e-3, 1e-2)],
)
def test_fewer_triangles_bound_the_same_volume_with_the_same_holes(make, genus, lost, off, share):
    """Of n equal triangles in a ball it loses 11 / n of its volume; flat sides lose nothing."""
    mesh = make()
    most = int(share * len(mesh.faces))
    made = decimated(mesh, most)
    fewer = Mesh(mesh.vertices[made.vertices], made.faces)
    assert len(fewer.faces) <= most
    assert check_solid(Solid(fewer)).genus == genus
    assert enclosed_volume(fewer) == pytest.approx(enclosed_volume(mesh), rel=lost / most)
    near = closest_on_mesh(fewer, mesh.vertices)
    there = mesh_points(fewer, near.faces, near.weights)
    assert np.linalg.norm(there - mesh.vertices, axis=1).max() < off / most


def test_a_block_needs_no_more_than_twelve():
    mesh = block(refined=12)
    made = decimated(mesh, 12)
    fewer = Mesh(mesh.vertices[made.vertices], made.faces)
    assert len(made.faces) == 12
    assert enclosed_volume(fewer) == pytest.approx(6000)


def test_colours_stay_with_their_vertices():
    mesh = ball()
    colors = np.full((len(mesh.vertices), 4), 255, np.uint8)
    colors[:, :3] = np.abs(mesh.vertices).astype(np.uint8)
    painted = Solid(Mesh(mesh.vertices, mesh.faces, colors=colors), "b")
    made = within_budget(Shapes(solids=(painted,)), 300).solids[0].mesh
    assert len(made.faces) <= 300
    np.testing.assert_array_equal(made.colors[:, :3], np.abs(made.vertices).astype(np.uint8))


def test_groups_stay_where_they_were():
    mesh = block(refined=8)
    normals = np.cross(*(np.diff(mesh.vertices[mesh.faces], axis=1).transpose(1, 0, 2)))
    side = np.argmax(np.abs(normals), axis=1) * 2 + (normals.sum(axis=1) > 0)
    order = np.argsort(side, kind="stable")
    groups = tuple(FaceGroup(str(k), int((side == k).sum())) for k in range(6))
    solid = Solid(Mesh(mesh.vertices, mesh.faces[order]), "b", groups=groups)
    made = within_budget(Shapes(solids=(solid,)), 40).solids[0]
    assert sum(group.count for group in made.groups) == len(made.mesh.faces) <= 40
    begin = 0
    for number, group in enumerate(made.groups):
        corners = made.mesh.vertices[made.mesh.faces[begin : begin + group.count]]
        begin += group.count
        assert np.ptp(corners.reshape(-1, 3)[:, number // 2]) < 1e-5


def test_an_open_surface_keeps_its_border():
    n = 21
    x, y = np.meshgrid(np.linspace(0, 40, n), np.linspace(0, 30, n))
    points = np.column_stack((x.ravel(), y.ravel(), np.sin(x.ravel() / 6)))
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate((
        np.column_stack((corner, corner + 1, corner + n)),
        np.column_stack((corner + 1, corner + n + 1, corner + n)),
    ))  # fmt: skip
    made = within_budget(Shapes(surfaces=(Surface(Mesh(points, faces), "s"),)), 120)
    mesh = made.surfaces[0].mesh
    assert triangle_count(made) <= 120
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0)[:2], (40, 30), rtol=1e-6)
    sides = np.diff(mesh.vertices[mesh.faces], axis=1)
    across = np.cross(sides[:, 0], sides[:, 1])
    assert (across[:, 2] > 0).all()
    assert 0.5 * across[:, 2].sum() == pytest.approx(1200, rel=1e-6)


def test_parts_share_the_budget_and_a_budget_that_is_too_small_is_told():
    shapes = Shapes(solids=(Solid(ball(), "a"), Solid(ring(), "b")))
    made = prepare_export(shapes, "a.stl", handover=Handover(triangles=800))
    assert len(stl_points(made.data)) // 3 <= 800
    assert made.notes == ()
    tight = prepare_export(shapes, "a.stl", handover=Handover(triangles=8))
    assert "not 8" in tight.notes[0]
    assert len(stl_points(tight.data)) // 3 > 8


def spread(mesh):
    """A picture in two halves: what looks up in the left one, what looks down in the right one."""
    from bozzetto.geometry import Texture

    pixels = np.full((64, 128, 4), 255, np.uint8)
    pixels[..., 0] = np.linspace(0, 255, 128).astype(np.uint8)
    pixels[..., 1] = np.linspace(0, 255, 64).astype(np.uint8)[:, None]
    corners = mesh.vertices[mesh.faces].astype(float)
    low, high = mesh.bounds
    places = ((corners - low) / (high - low))[..., :2] * (0.45, 0.9) + (0.02, 0.05)
    down = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] < 0
    places[down, :, 0] += 0.5
    return Texture(pixels, places)


def test_pictures_stay_where_they_are_on_fewer_triangles():
    """Every corner that is left has a place that it had on its side of the seam."""
    mesh = ball()
    shapes = Shapes(solids=(Solid(mesh, "a", texture=spread(mesh)),))
    (fewer,) = within_budget(shapes, 200).solids
    assert len(fewer.mesh.faces) <= 200
    assert fewer.texture is not None
    before = np.column_stack(
        (mesh.vertices[mesh.faces].reshape(-1, 3), spread(mesh).corners.reshape(-1, 2))
    )
    corners = fewer.mesh.vertices[fewer.mesh.faces].reshape(-1, 3)
    after = np.column_stack((corners, fewer.texture.corners.reshape(-1, 2)))
    known = {row.tobytes() for row in before.astype(np.float32)}
    assert all(row.tobytes() in known for row in after.astype(np.float32))
    halves = fewer.texture.corners[..., 0] > 0.5
    assert (halves.all(axis=1) | ~halves.any(axis=1)).all()
    made = prepare_export(shapes, "a.glb", handover=Handover(triangles=200))
    assert made.warnings() == ()


def test_a_picture_that_is_unrolled_around_stays_whole():
    """The seam of a map of a ball has two places for each vertex: no triangle spans the map."""
    from bozzetto.geometry import Texture

    mesh = ball()
    middle = mesh.bounds.mean(axis=0)
    rays = mesh.vertices[mesh.faces].astype(float) - middle
    around = np.arctan2(rays[..., 1], rays[..., 0]) / (2 * np.pi) + 0.5
    around -= np.round(around - around[:, :1])  # each triangle in one piece
    around = (around + 1.0) / 3.0
    height = np.arccos(np.clip(rays[..., 2] / np.linalg.norm(rays, axis=2), -1, 1)) / np.pi
    places = np.stack((around, height), axis=2).astype(np.float32)
    picture = Texture(np.zeros((8, 8, 4), np.uint8), places)
    (fewer,) = within_budget(Shapes(solids=(Solid(mesh, "a", texture=picture),)), 300).solids
    assert fewer.texture is not None
    assert bounds_volume(fewer.mesh)
    assert np.ptp(fewer.texture.corners[..., 0], axis=1).max() < 0.3


def test_a_picture_in_too_many_pieces_is_told_and_the_budget_kept():
    """All triangles lie at random places: none could go without a hole in the picture."""
    from bozzetto.geometry import Texture

    mesh = ball()
    places = np.random.default_rng(1).random((len(mesh.faces), 3, 2))
    picture = Texture(np.zeros((4, 4, 4), np.uint8), places)
    shapes = Shapes(solids=(Solid(mesh, "a", texture=picture),))
    (fewer,) = within_budget(shapes, 200).solids
    assert len(fewer.mesh.faces) <= 200
    made = prepare_export(shapes, "a.glb", handover=Handover(triangles=200))
    assert "picture" in " ".join(made.warnings())


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**31), st.integers(4, 60))
@example(28077, 4)  # its tetrahedron lay inside out
def test_any_closed_mesh_stays_closed(seed, most):
    """Bumpy balls: what is decimated is closed, looks outward and names no vertex in vain."""
    chance = np.random.default_rng(seed)
    mesh = ball(segments=16)
    mesh = Mesh(mesh.vertices * chance.uniform(0.6, 1.4, (len(mesh.vertices), 1)), mesh.faces)
    made = decimated(mesh, most)
    fewer = Mesh(mesh.vertices[made.vertices], made.faces)
    assert len(np.unique(made.faces)) == len(made.vertices)
    check = Mesh(fewer.vertices, fewer.faces)
    assert bounds_volume(check)


# -- lying flat --------------------------------------------------------------------------------


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**31))
def test_what_lies_flat_lies_on_its_largest_face_however_it_was_turned(seed):
    chance = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(chance.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    points = block().vertices.astype(float) @ turn.T + chance.uniform(-90, 90, 3)
    placement = lying_flat(points)
    assert not placement.mirrors
    lying = placement.points(points)
    gaps = [np.linalg.norm(rows - rows[0], axis=1) for rows in (points, lying)]
    np.testing.assert_allclose(*gaps, atol=1e-9)
    assert np.ptp(lying, axis=0)[2] == pytest.approx(10, abs=1e-3)  # the least height: 20 × 30
    assert lying[:, 2].min() == pytest.approx(0, abs=1e-6)
    again = lying_flat(lying).points(lying)
    np.testing.assert_allclose(again, lying, atol=1e-3)


def test_a_face_that_does_not_hold_the_thing_is_not_lain_on():
    """A leaning wedge would fall from its largest face if the mass is not above it."""
    base = np.array([[0, 0], [10, 0], [10, 10], [0, 10]], float)
    low = np.column_stack((base, np.zeros(4)))
    high = np.column_stack((base + np.array([60.0, 0.0]), np.full(4, 40.0)))
    lying = lying_flat(np.vstack((low, high)))
    down = lying.points(np.vstack((low, high)))
    mass = down.mean(axis=0)
    touching = down[down[:, 2] < 1e-6]
    assert (touching[:, :2].min(axis=0) <= mass[:2]).all()
    assert (touching[:, :2].max(axis=0) >= mass[:2]).all()


@pytest.mark.parametrize(
    "points", [np.zeros((0, 3)), [[1, 2, 3]], [[0, 0, 5], [1, 0, 5]],
               [[0, 0, 0], [1, 0, 1], [0, 1, 0], [1, 1, 1]], np.zeros((9, 3))]
)  # fmt: skip
def test_little_or_flat_things_lie_too(points):
    made = lying_flat(points)
    lying = made.points(points)
    assert not len(lying) or lying[:, 2].min() == pytest.approx(0)


def test_flat_for_printing_in_a_file(tmp_path):
    stood = Shapes(solids=(Solid(block((5, 40, 60)), "b"),))
    made = prepare_export(stood, "a.stl", handover=Handover(lay_flat=True))
    points = stl_points(made.data)
    np.testing.assert_allclose(sorted(np.ptp(points, axis=0)), (5, 40, 60), atol=1e-4)
    assert np.ptp(points[:, 2]) == pytest.approx(5, abs=1e-4)
    assert points[:, 2].min() == pytest.approx(0, abs=1e-5)


def test_the_same_value_twice_gives_the_same_file():
    wanted = Handover(triangles=200, lay_flat=True, scale=1.5)
    shapes = Shapes(solids=(Solid(ball(), "a"),))
    for ending in ("stl", "3mf", "glb", "obj", "ply"):
        first, second = (prepare_export(shapes, f"a.{ending}", handover=wanted) for _ in "12")
        assert first.data == second.data
        assert json.dumps(first.as_values()) == json.dumps(second.as_values())


def test_placements_of_frames_come_back():
    for unit in MM_PER:
        for up in ("y", "z"):
            there = FileFrame(unit, up).placement
            both = there.inverse().after(there)
            np.testing.assert_allclose(both.rotation, Placement().rotation, atol=1e-12)
            assert both.scale == pytest.approx(1.0)


# -- what comes back ---------------------------------------------------------------------------


@pytest.mark.parametrize("unit", [None, *MM_PER])
@pytest.mark.parametrize("up", [None, "y", "z"])
@pytest.mark.parametrize("ending", ["stl", "obj", "ply", "glb"])
def test_what_we_wrote_comes_back_as_large_and_as_upright_as_it_was(tmp_path, ending, unit, up):
    path = tmp_path / f"a.{ending}"
    mesh = block((10.0, 20.0, 30.0))
    export(BLOCK, path, handover=Handover(unit=unit, up=up))
    back = read_mesh(path, trusted=True)
    assert len(back.solids) == 1
    np.testing.assert_allclose(back.solids[0].mesh.bounds, mesh.bounds, atol=2e-5)


def test_obj_has_y_up_where_nobody_chooses():
    points = obj_points(prepare_export(BLOCK, "a.obj").data)
    np.testing.assert_allclose(np.ptp(points, axis=0), (10, 30, 20), rtol=1e-6)


@pytest.mark.parametrize("trusted", [True, False])
def test_glb_of_ours_comes_back_with_names_groups_and_colours(tmp_path, trusted):
    groups = (
        FaceGroup("lid", 4, (200, 10, 30), "gloss"),
        FaceGroup("body", 8, (20, 130, 240), "metal"),
    )
    shapes = Shapes(
        solids=(Solid(block(), "pot", groups=groups), Solid(ring(), "handle", (9, 99, 199))),
    )
    export(shapes, tmp_path / "a.glb")
    back = read_mesh(tmp_path / "a.glb", trusted=trusted)
    assert [(s.name, s.color) for s in back.solids] == [("pot", None), ("handle", (9, 99, 199))]
    assert back.solids[0].groups == groups
    for one, other in zip(shapes.solids, back.solids, strict=True):
        np.testing.assert_array_equal(one.mesh.faces, other.mesh.faces)
        np.testing.assert_allclose(one.mesh.vertices, other.mesh.vertices, atol=1e-5)


def test_a_mesh_is_built_from_the_command_line_and_keeps_its_parts(tmp_path):
    from bozzetto.cli.main import main

    groups = (FaceGroup("lid", 4, (200, 10, 30)), FaceGroup("body", 8, (20, 130, 240)))
    shapes = Shapes(solids=(Solid(block(), "pot", groups=groups), Solid(ring(), "handle")))
    first, document = tmp_path / "a.glb", tmp_path / "a.bozz"
    export(shapes, first)
    assert main(["build", "mesh", str(first), "-o", str(document)]) == 0
    second, third = tmp_path / "b.glb", tmp_path / "b.stl"
    wanted = ["--triangles", "900", "--scale", "2", "--unit", "cm"]
    assert main(["export", str(document), "-o", str(second), "-o", str(third), *wanted]) == 0
    back = read_mesh(second, trusted=True)
    assert [s.name for s in back.solids] == ["pot", "handle"]
    assert back.solids[0].groups == groups
    np.testing.assert_allclose(
        np.ptp(back.solids[0].mesh.vertices, axis=0), (20, 40, 60), rtol=1e-5
    )
    assert triangle_count(back) <= 900
    assert len(stl_points(third.read_bytes())) // 3 == triangle_count(back)


@pytest.mark.parametrize(
    "wrong", [["--unit", "ft"], ["--scale", "big"], ["--triangles", "1"], ["--drawing", "oil"]]
)
def test_a_wrong_switch_is_an_error_and_writes_nothing(tmp_path, wrong, capsys):
    from bozzetto.cli.main import main

    export(BLOCK, tmp_path / "a.stl")
    target = tmp_path / "b.stl"
    assert main(["build", "mesh", str(tmp_path / "a.stl"), "-o", str(target), *wrong]) == 2
    assert capsys.readouterr().err.startswith("error: ")
    assert not target.exists()


def test_materials_of_others_are_never_replaced_unasked(tmp_path):
    (tmp_path / "a.mtl").write_text("newmtl precious\n")
    with pytest.raises(UserError, match=r"a\.mtl.*another name"):
        export(BLOCK, tmp_path / "a.obj")
    assert (tmp_path / "a.mtl").read_text() == "newmtl precious\n"
    assert [path.name for path in tmp_path.iterdir()] == ["a.mtl"]


def test_materials_go_with_the_file_that_is_replaced(tmp_path):
    export(BLOCK, tmp_path / "a.obj")
    red = Shapes(solids=(Solid(block(), "block", (255, 0, 0)),))
    export(red, tmp_path / "a.obj")
    assert "Kd 1.0000 0.0000 0.0000" in (tmp_path / "a.mtl").read_text()
    (tmp_path / "a.obj").unlink()
    export(red, tmp_path / "a.obj")  # the same materials may lie there
    assert (tmp_path / "a.obj").exists()


def test_a_full_disk_leaves_no_materials_without_their_mesh(tmp_path, monkeypatch):
    from bozzetto.exchange import export as exporting

    real = exporting.write_bytes

    def full(path, data):
        if str(path).endswith(".obj"):
            raise UserError("There is no room.")
        real(path, data)

    monkeypatch.setattr(exporting, "write_bytes", full)
    with pytest.raises(UserError, match="no room"):
        export(BLOCK, tmp_path / "a.obj")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("ending", "wish"),
    [("stl", {"lines": "blueprint"}), ("glb", {"lines": "outlines"}), ("stl", {"hidden": True}),
     ("svg", {"hidden": True}), ("svg", {"triangles": 100}), ("svg", {"levels": True}),
     ("svg", {"uvs": True}), ("stl", {"levels": True}), ("stl", {"uvs": True})],
)  # fmt: skip
def test_a_wish_that_changes_nothing_is_told(ending, wish):
    line = Curve(1, np.array([0.0, 0.0, 1.0, 1.0]), np.array([[0.0, 0.0, 0.0], [10.0, 5.0, 0.0]]))
    shapes = BLOCK + Shapes(curves=(line,))
    plain = prepare_export(shapes, f"a.{ending}")
    asked = prepare_export(shapes, f"a.{ending}", handover=Handover(**wish))
    assert asked.data == plain.data
    assert len(asked.notes) == len(plain.notes) + 1
