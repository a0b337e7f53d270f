"""Meshes whose files name others, hold more than is read, or do not say their frame."""

from __future__ import annotations

import base64
import json
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import FormatError
from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh, read_mesh_file
from bozzetto.geometry import FaceGroup, Mesh, Shapes, Solid
from tests.core.exchange.test_mesh_formats import box, tetrahedron_document, volume

BOTH = pytest.mark.parametrize("trusted", [True, False], ids=["here", "process"])


def gltf(tmp_path, uri, change=lambda document: None, name="a.gltf"):
    document, _ = tetrahedron_document()
    document["buffers"][0]["uri"] = uri
    change(document)
    path = tmp_path / name
    path.write_text(json.dumps(document))
    return path


@BOTH
@pytest.mark.parametrize("kind", ["data", "beside", "below", "escaped"])
def test_gltf_reads_its_buffer(tmp_path, kind, trusted):
    _, blob = tetrahedron_document()
    name = {"beside": "b.bin", "below": "parts/b.bin", "escaped": "a%20b.bin"}.get(kind)
    if name is None:
        uri = "data:application/octet-stream;base64," + base64.b64encode(blob).decode()
    else:
        uri, place = name, tmp_path / name.replace("%20", " ")
        place.parent.mkdir(exist_ok=True)
        place.write_bytes(blob)
    (part,) = read_mesh(gltf(tmp_path, uri), trusted=trusted).solids
    assert len(part.mesh.faces) == 4
    assert volume(part.mesh) > 0.0


@BOTH
@pytest.mark.parametrize(
    ("uri", "said"),
    [
        ("../secret.bin", "not in the folder"),
        ("%2e%2e/secret.bin", "not in the folder"),
        ("/etc/passwd", "not in the folder"),
        ("file:///etc/passwd", "not in the folder"),
        ("https://example.org/b.bin", "not in the folder"),
        ("c:\\b.bin", "not in the folder"),
        ("link.bin", "link out of the folder"),
        ("none.bin", "not there"),
        ("data:text/plain,hello", "base64"),
        ("data:application/octet-stream;base64,@@", "damaged"),
        ("data:application/octet-stream;base64,AAAA", "cut short"),
    ],
)
def test_a_buffer_is_never_looked_for_elsewhere(tmp_path, uri, said, trusted):
    (tmp_path / "secret.bin").write_bytes(bytes(200))
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "link.bin").symlink_to(tmp_path / "secret.bin")
    with pytest.raises(FormatError, match=said):
        read_mesh(gltf(folder, uri), trusted=trusted)


def test_gltf_tells_what_it_leaves_out(tmp_path):
    _, blob = tetrahedron_document()
    (tmp_path / "b.bin").write_bytes(blob)

    def richer(document):
        document["animations"] = [{"channels": []}] * 2
        document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
        document["meshes"][0]["primitives"][0]["material"] = 0
        document["nodes"] = [{"mesh": 0, "skin": 0}, {"camera": 0}]
        document["scenes"] = [{"nodes": [0, 1]}]

    read = read_mesh_file(gltf(tmp_path, "b.bin", richer))
    said = " ".join(read.left_out)
    assert "bones of a part" in said
    assert "2 motions" in said
    assert "a camera" in said
    assert "picture of a material" in said
    assert read.guess is None


def test_gltf_of_version_one_is_refused(tmp_path):
    def older(document):
        document["asset"].update(version="1.0")
        document["accessors"] = {"a": document["accessors"][0]}  # objects by name, as it had them

    with pytest.raises(FormatError, match="glTF 1"):
        read_mesh(gltf(tmp_path, "b.bin", older))


@BOTH
def test_obj_keeps_parts_groups_and_the_looks_of_its_materials(tmp_path, trusted):
    solid = Solid(box((10.0, 20.0, 30.0)), "case")
    groups = (
        FaceGroup("lid", 4, (200, 10, 20), "metal"),
        FaceGroup("base", len(solid.mesh.faces) - 4, (20, 30, 40), "glass"),
    )
    first = replace(solid, groups=groups)
    second = Solid(box((5.0, 5.0, 5.0), at=(50.0, 0.0, 0.0)), "knob", (1, 2, 3))
    export(Shapes(solids=(first, second)), tmp_path / "a.obj")
    read = read_mesh_file(tmp_path / "a.obj", trusted=trusted)
    assert [(s.name, s.color) for s in read.shapes.solids] == [("case", None), ("knob", (1, 2, 3))]
    assert read.shapes.solids[0].groups == groups
    assert volume(read.shapes.solids[0].mesh) == pytest.approx(6000.0)
    assert read.left_out == ()


def test_obj_colours_of_vertices_stay_with_their_part(tmp_path):
    colors = np.array([[k, 255 - k, 7, 255] for k in range(4)], np.uint8)
    places = np.array([[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]])
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    one = Solid(Mesh(places, faces, colors=colors), "one")
    two = Solid(Mesh(places + 9, faces, colors=colors[::-1].copy()), "two")
    export(Shapes(solids=(one, two)), tmp_path / "a.obj")
    back = read_mesh(tmp_path / "a.obj").solids
    assert [part.name for part in back] == ["one", "two"]
    assert (back[0].mesh.colors == colors).all()
    assert (back[1].mesh.colors == colors[::-1]).all()


TRIANGLE = "v 0 0 0\nv 90 0 0\nv 0 90 0\nv 90 90 9\n{}f 1 2 3\n"


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ("mtllib none.mtl\n", "not there"),
        ("mtllib ../a.mtl\n", "not in the folder"),
        ("mtllib /etc/passwd\n", "not in the folder"),
        ("l 1 2\n", "free-form curves"),
    ],
)
def test_obj_is_read_without_what_cannot_be_had_and_says_so(tmp_path, head, said):
    (tmp_path / "a.obj").write_text(TRIANGLE.format(head))
    read = read_mesh_file(tmp_path / "a.obj")
    assert len(read.shapes.surfaces) == 1
    assert said in " ".join(read.left_out)


def test_damaged_materials_are_passed_over(tmp_path):
    (tmp_path / "a.obj").write_text(TRIANGLE.format("mtllib a.mtl\nusemtl red\n"))
    said = "newmtl red\nKd 1 0 x\nKd 9e999 0 0\nKd -1 0.5 7\nPr\nmap_Kd a.png\nnewmtl\n\0\n"
    (tmp_path / "a.mtl").write_text(said)
    read = read_mesh_file(tmp_path / "a.obj")
    assert read.shapes.surfaces[0].color == (0, 128, 255)
    assert "picture of a material" in " ".join(read.left_out)


def standing(up, size=1.0):
    """A pillar with a plate below it, as text of an OBJ file."""
    solid = box((40.0, 40.0, 4.0)), box((8.0, 8.0, 100.0), at=(16.0, 16.0, 4.0))
    rows, first = [], 1
    for mesh in solid:
        places = mesh.vertices * size
        places = places if up == "z" else places @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
        rows += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in places]
        rows += [f"f {a} {b} {c}" for a, b, c in mesh.faces + first]
        first += len(places)
    return "\n".join(rows) + "\n"


@pytest.mark.parametrize(
    ("text", "unit", "up"),
    [
        (standing("y"), "mm", "y"),
        (standing("z"), "mm", "z"),
        (standing("z", 0.01), "m", "z"),
        ("# File units = centimeters\n" + standing("y"), "cm", "y"),
        ("# units: inches, Y up\n" + standing("z"), "in", "y"),
        ("# Up axis: Z\n# Unit: 1 m\n" + standing("y"), "m", "z"),
        ("# five units sold\n# he got up in the morning\n" + standing("z"), "mm", "z"),
        (TRIANGLE.format(""), "mm", "y"),
    ],
)
def test_a_foreign_obj_is_taken_as_it_seems_to_be(tmp_path, text, unit, up):
    (tmp_path / "a.obj").write_text(text)
    guess = read_mesh_file(tmp_path / "a.obj").guess
    assert (guess.unit, guess.up) == (unit, up)
    assert "Parameters" in guess.sentence()


def test_what_says_its_frame_is_not_guessed(tmp_path):
    for ending in ("obj", "stl", "ply", "glb"):
        export(Shapes(solids=(Solid(box(), "a"),)), tmp_path / f"a.{ending}")
        read = read_mesh_file(tmp_path / f"a.{ending}")
        assert read.guess is None
        assert read.told() == ()


def test_a_thing_that_is_turned_is_guessed_turned(tmp_path):
    sizes = []
    for up in ("y", "z"):
        (tmp_path / f"{up}.obj").write_text(standing(up))
        box_of = next(read_mesh_file(tmp_path / f"{up}.obj").upright.meshes()).mesh.bounds
        sizes.append(box_of[1] - box_of[0])
    assert sizes[0] == pytest.approx(sizes[1], abs=1e-4)


def test_thousands_of_parts_take_no_longer_than_their_faces(tmp_path):
    count = 4000
    rows = [f"v {k % 97} {k % 89} {k}\n" for k in range(3 * count)]
    rows += [f"o part {k}\nf {3 * k + 1} {3 * k + 2} {3 * k + 3}\n" for k in range(count)]
    (tmp_path / "a.obj").write_text("".join(rows))
    parts = read_mesh(tmp_path / "a.obj").surfaces
    assert [part.name for part in parts] == [f"part {k}" for k in range(count)]
    assert {len(part.mesh.vertices) for part in parts} == {3}


@pytest.mark.parametrize(
    ("head", "up"),
    [
        ("OpenSCAD_Model", "z"),
        ("Exported from Blender-4.2.1 (sub 0)", "z"),
        ("", "y"),
        ("A blend of oak, Y up", "y"),
    ],
)
def test_an_stl_file_stands_as_in_the_program_that_wrote_it(tmp_path, head, up):
    """A pillar on a plate that lies on its side: by its shape alone Y is up."""
    (tmp_path / "a.obj").write_text(standing("y"))
    mesh = next(read_mesh(tmp_path / "a.obj").meshes()).mesh
    rows = [
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in mesh.vertices[face].tolist())
        + "endloop\nendfacet\n"
        for face in mesh.faces
    ]
    (tmp_path / "a.stl").write_text(f"solid {head}\n{''.join(rows)}endsolid {head}\n")
    guess = read_mesh_file(tmp_path / "a.stl").guess
    assert guess.up == up
    assert "up (" in guess.sentence()
