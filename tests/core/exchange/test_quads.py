"""Quads in files: as quads where a format holds them, with groups, colours and bones."""

from __future__ import annotations

import json
import struct
from collections import Counter
from functools import cache

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.errors import UserError
from bozzetto.exchange.export import prepare_export
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.import_file import read_mesh
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.exchange.quad_budget import within_quads
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.rig import Rig, Skin
from bozzetto.geometry.shapes import FaceGroup, Shapes, Solid
from bozzetto.geometry.texture import Texture
from tests.core.geometry.quads.test_remeshing import ball, shaken

ENDINGS = ("obj", "ply", "usda", "glb", "stl", "3mf")


def egg(**more):
    places, faces = shaken(*ball((10.0, 20.0, 30.0), rows=12))
    order = np.argsort(places[faces][:, :, 2].mean(axis=1), kind="stable")
    return Solid(Mesh(places.astype(np.float32), faces[order].astype(np.int32)), "egg", **more)


@cache
def plain():
    """The egg of quads, laid once for all who look at it."""
    return made_of(egg())


def made_of(solid, count=300):
    return within_quads(Shapes((solid,)), count, lambda *_: None)


def sizes_in(data, ending):
    """How many faces of how many corners a file has."""
    if ending == "obj":
        return Counter(len(line.split()) - 1 for line in data.decode().splitlines()
                       if line.startswith("f "))  # fmt: skip
    if ending == "ply":
        head, body = data.split(b"end_header\n")
        rows = {line.split()[1]: int(line.split()[2]) for line in head.decode().splitlines()
                if line.startswith("element")}  # fmt: skip
        at = rows["vertex"] * (12 + 4 * ("uchar red" in head.decode()))
        found = Counter()
        for _ in range(rows["face"]):
            found[body[at]] += 1
            at += 1 + 4 * body[at]
        assert at == len(body)
        return found
    text = data.decode().split("faceVertexCounts = [")[1].split("]")[0]
    return Counter(int(word) for word in text.split(","))


@pytest.mark.parametrize("ending", ENDINGS)
def test_formats_of_polygons_hold_quads_and_the_others_say_that_they_are_triangles(ending):
    made = plain()
    file = prepare_export(Shapes((egg(),)), f"a.{ending}", handover=Handover(quads=300))
    if ending in ("obj", "ply", "usda"):
        assert sizes_in(file.data, ending) == Counter({4: made.quads, 3: made.triangles})
        assert not any("two of them" in note for note in file.notes)
    else:
        assert any("each quad is two" in note for note in file.notes)
    assert made.quads > 5 * made.triangles
    check_solid(made.shapes.solids[0])


@pytest.mark.parametrize("ending", ["obj", "ply", "usda", "glb"])
def test_what_is_written_comes_back_as_large_and_closed(tmp_path, ending):
    file = prepare_export(Shapes((egg(),)), f"a.{ending}", handover=Handover(quads=300))
    path = tmp_path / f"a.{ending}"
    file.write(path)
    back = next(read_mesh(path).meshes()).mesh
    want = plain().shapes.solids[0].mesh
    assert len(back.faces) == len(want.faces)
    assert np.sort(np.ptp(back.vertices, axis=0)) == pytest.approx(
        np.sort(np.ptp(want.vertices, axis=0)), rel=1e-5
    )


def test_groups_stay_and_lie_where_they_were():
    half = len(egg().mesh.faces) // 2
    groups = (
        FaceGroup("low", half, (255, 0, 0)), FaceGroup("high", len(egg().mesh.faces) - half),
    )  # fmt: skip
    part = made_of(egg(groups=groups)).shapes.solids[0]
    assert [group.name for group in part.groups] == ["low", "high"]
    first = part.groups[0].count
    heights = part.mesh.vertices[part.mesh.faces].mean(axis=1)[:, 2]
    assert np.median(heights[:first]) < np.median(heights[first:])
    ends = np.cumsum(part.polygons)
    assert first in ends, "a group ends with a face"
    file = prepare_export(
        Shapes((egg(groups=groups),)), "a.usda", handover=Handover(quads=300)
    ).data.decode()
    indices = [int(word) for block in file.split("int[] indices = [")[1:]
               for word in block.split("]")[0].split(",")]  # fmt: skip
    assert sorted(indices) == list(range(len(part.polygons)))


def test_colours_are_those_of_the_place():
    solid = egg()
    height = solid.mesh.vertices[:, 2]
    share = np.rint(255 * (height - height.min()) / np.ptp(height)).astype(np.uint8)
    colors = np.column_stack((share, share, share, np.full(len(share), 255))).astype(np.uint8)
    part = made_of(
        Solid(Mesh(solid.mesh.vertices, solid.mesh.faces, None, colors), "egg")
    ).shapes.solids[0]
    there = 255 * (part.mesh.vertices[:, 2] - height.min()) / np.ptp(height)
    assert np.abs(part.mesh.colors[:, 0] - there).max() < 2.0


def test_bones_carry_the_quads_as_they_carried_the_triangles():
    solid = egg()
    share = np.clip((solid.mesh.vertices[:, 2] + 30) / 60, 0, 1)
    weights = np.column_stack((1 - share, share, 0 * share, 0 * share)).astype(np.float32)
    weights /= weights.sum(axis=1, keepdims=True)
    joints = np.tile(np.array((0, 1, 0, 0), np.int32), (len(weights), 1))
    turned = np.array([(0, 0, 0, 1.0), (np.sin(0.3), 0, 0, np.cos(0.3))])
    rig = Rig(np.array([(0, 0, -30.0), (0, 0, 0)]), np.array((-1, 0)), ("low", "high"), turned)
    skin = Skin(rig, joints, weights, solid.mesh)
    posed = Solid(skin.posed(solid.mesh), "egg", skin=skin)
    part = made_of(posed).shapes.solids[0]
    assert part.skin is not None
    height = np.clip((part.skin.rest.vertices[:, 2] + 30) / 60, 0, 1)
    second = np.where(part.skin.joints == 1, part.skin.weights, 0).sum(axis=1)
    assert np.abs(second - height).max() < 0.01
    assert np.array_equal(part.mesh.vertices, part.skin.posed(part.skin.rest).vertices)
    file = prepare_export(Shapes((posed,)), "a.usda", handover=Handover(quads=300))
    assert b"SkelBindingAPI" in file.data
    assert sizes_in(file.data, "usda")[4] > 200


def test_a_picture_goes_and_that_is_told():
    solid = egg()
    corners = np.zeros((len(solid.mesh.faces), 3, 2), np.float32)
    pixels = np.full((4, 4, 4), 200, np.uint8)
    file = prepare_export(
        Shapes((egg(texture=Texture(pixels, corners)),)), "a.obj", handover=Handover(quads=300)
    )
    assert any("picture" in warning for warning in file.warnings())


def test_places_for_a_picture_leave_most_quads_whole():
    file = prepare_export(Shapes((egg(),)), "a.obj", handover=Handover(quads=300, uvs=True))
    found = sizes_in(file.data, "obj")
    made = plain()
    assert found[4] * 2 + found[3] == made.quads * 2 + made.triangles
    assert found[4] > 0.8 * made.quads
    usd = prepare_export(Shapes((egg(),)), "a.usda", handover=Handover(quads=300, uvs=True))
    assert sizes_in(usd.data, "usda") == found


def test_parts_share_the_number_by_their_area():
    small = egg().placed(Placement(scale=0.5))
    made = within_quads(Shapes((egg(), small)), 1000, lambda *_: None)
    counts = [len(part.polygons) for part in made.shapes.solids]
    assert 3.0 < counts[0] / counts[1] < 4.4
    assert sum(counts) == pytest.approx(1000, rel=0.1)


def test_mirrored_parts_are_written_the_right_way_round():
    """A placement that mirrors reverses triangles; the quads are the same ones, reversed."""
    made = plain().shapes
    mirror = Placement((-1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0))
    from bozzetto.exchange.mesh.ply import write_shapes

    one, other = write_shapes(made), write_shapes(made.placed(mirror))
    assert sizes_in(one, "ply") == sizes_in(other, "ply")

    def rings(data):
        _, body = data.split(b"end_header\n")
        at, found = 12 * len(made.solids[0].mesh.vertices), []
        while at < len(body):
            size = body[at]
            ring = struct.unpack_from(f"<{size}i", body, at + 1)
            first = ring.index(min(ring))
            found.append(ring[first:] + ring[:first])
            at += 1 + 4 * size
        return found

    back = [(ring[0], *ring[:0:-1]) for ring in rings(other)]
    assert back == rings(one)


@pytest.mark.parametrize("wrong", [{"quads": 5}, {"quads": 300, "triangles": 300}])
def test_what_cannot_be_is_refused(wrong):
    with pytest.raises(UserError):
        Handover(**wrong)


def test_formats_without_meshes_say_that_they_hold_no_quads(tmp_path):
    from bozzetto.geometry.shapes import Curve

    line = Curve(1, np.array((0, 0, 1, 1.0)), np.array([(0, 0, 0), (1, 0, 0.0)]))
    file = prepare_export(Shapes(curves=(line,)), "a.step", handover=Handover(quads=300))
    assert any("no quads" in note for note in file.notes)


def test_the_command_line_writes_quads_and_refuses_both_numbers(tmp_path, capsys):
    path = tmp_path / "egg.obj"
    prepare_export(Shapes((egg(),)), path).write(path)
    out = tmp_path / "out.obj"
    wanted = ["build", "mesh", str(path), "-o", str(out), "--quads", "300"]
    report = tmp_path / "report.json"
    assert main([*wanted, "--report", str(report)]) == 0
    assert sizes_in(out.read_bytes(), "obj")[4] > 200
    assert json.loads(report.read_text())
    again = tmp_path / "again.obj"
    wanted[wanted.index(str(out))] = str(again)
    assert main([*wanted, "--triangles", "300"]) != 0
    assert not again.exists()
