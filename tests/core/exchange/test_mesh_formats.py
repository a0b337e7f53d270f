"""Meshes out and back in; damaged and foreign files in the way that other programs write them."""

from __future__ import annotations

import json
import struct
import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.export import export
from bozzetto.exchange.import_file import read_mesh, read_mesh_file
from bozzetto.geometry import FaceGroup, Mesh, Shapes, Solid, Surface

BOTH = ["stl", "glb", "obj", "ply"]


def box(size=(10.0, 20.0, 30.0), at=(0.0, 0.0, 0.0), **more):
    """A box of twelve triangles, outwards."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return Mesh(corners * size + at, faces, **more)


def torus(nu=40, nv=20):
    u, v = np.meshgrid(
        np.arange(nu) * 2 * np.pi / nu, np.arange(nv) * 2 * np.pi / nv, indexing="ij"
    )
    r = 30 + 8 * np.cos(v)
    vertices = np.stack((r * np.cos(u), r * np.sin(u), 8 * np.sin(v)), -1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(nu), np.arange(nv), indexing="ij")
    at = lambda a, b: ((a % nu) * nv + b % nv).ravel()  # noqa: E731
    a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
    colors = np.random.default_rng(4).integers(0, 256, (nu * nv, 4)).astype(np.uint8)
    return Mesh(vertices, np.vstack((np.c_[a, b, c], np.c_[a, c, d])), colors=colors)


def volume(mesh):
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    return np.linalg.det(np.stack((a, b, c), 1)).sum() / 6


def triangles(mesh):
    """Corner positions as a set that no order of vertices or faces can change."""
    corners = np.round(mesh.vertices[mesh.faces].astype(float), 4) + 0.0
    first = [min(range(3), key=lambda k, t=t: tuple(t[k])) for t in corners]
    turned = [np.roll(t, -k, axis=0) for t, k in zip(corners, first, strict=True)]
    return sorted(tuple(map(tuple, t)) for t in turned)


@pytest.mark.parametrize("ending", BOTH)
def test_triangles_come_back(tmp_path, ending):
    mesh = torus()
    path = tmp_path / f"a.{ending}"
    export(Shapes(solids=(Solid(mesh, "ring"),)), path)
    back = read_mesh(path)
    assert len(back.solids) == 1
    assert not back.surfaces
    read = back.solids[0].mesh
    assert triangles(read) == triangles(mesh)
    assert len(read.vertices) == len(mesh.vertices)
    # 2 pi² R r², less what the polygons cut off
    assert volume(read) == pytest.approx(2 * np.pi**2 * 30 * 8**2, rel=0.03)


@pytest.mark.parametrize("ending", ["glb", "obj", "ply"])
def test_colours_come_back_to_the_bit(tmp_path, ending):
    mesh = torus()
    if ending == "obj":  # it has no place for opacity
        mesh = Mesh(mesh.vertices, mesh.faces, colors=mesh.colors | np.uint8([0, 0, 0, 255]))
    path = tmp_path / f"a.{ending}"
    export(Shapes(solids=(Solid(mesh),)), path)
    read = read_mesh(path).solids[0].mesh
    by_place = {
        tuple(v): tuple(c) for v, c in zip(mesh.vertices.round(3), mesh.colors, strict=True)
    }
    for v, c in zip(read.vertices.round(3), read.colors, strict=True):
        assert by_place[tuple(v)] == tuple(c)


def test_glb_keeps_names_part_colours_and_the_difference_of_solid_and_skin(tmp_path):
    skin = Mesh([[0, 0, 0], [5, 0, 0], [0, 5, 0]], [[0, 1, 2]])
    shapes = Shapes(
        solids=(Solid(box(), "Körper <1>", (212, 80, 47)), Solid(box(at=(50, 0, 0)), "b")),
        surfaces=(Surface(skin, "skin"),),
    )
    path = tmp_path / "a.glb"
    export(shapes, path)
    back = read_mesh(path)
    assert [(s.name, s.color) for s in back.solids] == [("Körper <1>", (212, 80, 47)), ("b", None)]
    assert [s.name for s in back.surfaces] == ["skin"]


def test_glb_tells_what_groups_are_made_of(tmp_path):
    """Materials as glTF 2.0 has them: only metal is metallic, only glass lets light through."""
    names = ("matt", "gloss", "rubber", "metal", "glass")
    groups = tuple(FaceGroup(name, 12, (200, 60, 40), name) for name in names)
    boxes = [box(at=(20.0 * k, 0, 0)) for k in range(len(names))]
    faces = np.vstack([one.faces + 8 * k for k, one in enumerate(boxes)])
    mesh = Mesh(np.vstack([one.vertices for one in boxes]), faces)
    export(Shapes(solids=(Solid(mesh, groups=groups),)), path := tmp_path / "a.glb")
    data = path.read_bytes()
    told = json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]])["materials"]
    made = {one["name"]: one["pbrMetallicRoughness"] for one in told}
    rough = [made[name]["roughnessFactor"] for name in ("glass", "gloss", "matt", "rubber")]
    assert rough == sorted(rough)
    assert [name for name in names if made[name]["metallicFactor"] == 1.0] == ["metal"]
    assert [one["name"] for one in told if one.get("alphaMode") == "BLEND"] == ["glass"]
    assert {name for name in names if made[name]["baseColorFactor"][3] < 1.0} == {"glass"}


def test_glb_is_y_up_and_in_metres(tmp_path):
    path = tmp_path / "a.glb"
    export(Shapes(solids=(Solid(box((10, 20, 30))),)), path)
    data = path.read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    position = json.loads(data[20 : 20 + size])["accessors"][0]
    np.testing.assert_allclose(position["min"], [0, 0, -0.020], atol=1e-9)
    np.testing.assert_allclose(position["max"], [0.010, 0.030, 0], atol=1e-9)


def test_3mf_holds_every_part_with_its_colours_and_no_date(tmp_path):
    shapes = Shapes(
        solids=(Solid(torus(), 'a "b" <c>'), Solid(box(), "plain")),
        surfaces=(Surface(Mesh([[0, 0, 0], [5, 0, 0], [0, 5, 0]], [[0, 1, 2]]), "s", (1, 2, 3)),),
    )
    one, two = tmp_path / "a.3mf", tmp_path / "b.3mf"
    export(shapes, one)
    export(shapes, two)
    assert one.read_bytes() == two.read_bytes()
    with zipfile.ZipFile(one) as package:
        assert package.testzip() is None
        root = ElementTree.fromstring(package.read("3D/3dmodel.model"))
    core = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
    objects = root.findall(f".//{core}object")
    assert root.get("unit") == "millimeter"
    assert [(o.get("name"), o.get("type")) for o in objects] == [
        ('a "b" <c>', "model"), ("plain", "model"), ("s", "model"),
    ]  # fmt: skip
    assert [o.get("pid") is not None for o in objects] == [True, False, True]
    assert len(root.findall(f".//{core}build/{core}item")) == 3
    assert len(objects[0].findall(f".//{core}vertex")) == len(torus().vertices)


def test_3mf_without_colours_does_not_mention_them(tmp_path):
    path = tmp_path / "a.3mf"
    export(Shapes(solids=(Solid(box()),)), path)
    with zipfile.ZipFile(path) as package:
        assert b"material" not in package.read("3D/3dmodel.model")


# -- files of other programs -----------------------------------------------------------------


def written(tmp_path, name, data):
    path = tmp_path / name
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return read_mesh(path)


QUAD_BOX = """# comment
o thing
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0
v 0 0 1\nv 1 0 1 # top\nv 1 1 1\nv 0 1 1
vt 0 0
vn 0 0 1
usemtl red
s off
f 4/1/1 3/1/1 2/1/1 1/1/1
f -4//1 -3//1 -2//1 -1//1
f 1 2 6 5\nf 2 3 \\
7 6\nf 3 4 8 7\nf 4 1 5 8
l 1 2
"""


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_obj_of_quads_with_every_kind_of_index(tmp_path, newline):
    shapes = written(tmp_path, "box.obj", QUAD_BOX.replace("\n", newline))
    assert [s.name for s in shapes.solids] == ["thing"]
    assert volume(shapes.solids[0].mesh) == pytest.approx(1)


def test_polygons_that_are_not_convex_keep_their_area(tmp_path):
    # The letter L: a fan from its first corner would leave the shape.
    text = "v 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\nv 2 0 0\nf 3 4 5 6 1 2\n"
    mesh = written(tmp_path, "l.obj", text).surfaces[0].mesh
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    z = np.cross(b - a, c - a)[:, 2] / 2
    assert (z > 0).all()
    assert z.sum() == pytest.approx(3)


def test_text_stl(tmp_path):
    facets = "".join(
        "facet normal 0 0 0\n outer loop\n"
        + "".join(f"  vertex {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in corners)
        + " endloop\nendfacet\n"
        for corners in box().vertices[box().faces].tolist()
    )
    solid = written(tmp_path, "a.stl", f"solid thing\n{facets}endsolid thing\n").solids[0].mesh
    assert len(solid.vertices) == 8
    assert volume(solid) == pytest.approx(6000)


def test_binary_stl_whose_header_says_solid(tmp_path):
    export(Shapes(solids=(Solid(box()),)), tmp_path / "a.stl")
    data = b"solid".ljust(80) + (tmp_path / "a.stl").read_bytes()[80:]
    assert volume(written(tmp_path, "b.stl", data).solids[0].mesh) == pytest.approx(6000)


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("mixed", [False, True])
def test_ply_in_every_order_with_unknown_properties(tmp_path, order, mixed):
    quads = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    rows = list(quads)
    if mixed:
        rows = [(3, 2, 1), (3, 1, 0), *quads[1:]]
    corners = [
        (0, 0, 0),
        (1, 0, 0),
        (1, 1, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 0, 1),
        (1, 1, 1),
        (0, 1, 1),
    ]
    header = (
        f"ply\nformat {order} 1.0\ncomment x\nMade by a program that forgot\n"
        "element camera 1\nproperty float f\n"
        "element vertex 8\nproperty double x\nproperty double y\nproperty double z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float quality\n"
        f"element face {len(rows)}\nproperty uchar flags\nproperty list uchar uint vertex_index\n"
        "element edge 1\nproperty int a\nend_header\n"
    )
    if order == "ascii":
        body = "35\n" + "".join(f"{x} {y} {z} 1 0 1 0.5\n" for x, y, z in corners)
        body += "".join(f"7 {len(r)} {' '.join(map(str, r))}\n" for r in rows) + "3\n"
        data = (header + body).encode()
    else:
        e = "<" if "little" in order else ">"
        body = struct.pack(e + "f", 35)
        body += b"".join(struct.pack(e + "dddBBBf", *c, 1, 0, 1, 0.5) for c in corners)
        body += b"".join(struct.pack(f"{e}BB{len(r)}I", 7, len(r), *r) for r in rows)
        data = header.encode() + body + struct.pack(e + "i", 3)
    mesh = written(tmp_path, "a.ply", data).solids[0].mesh
    assert volume(mesh) == pytest.approx(1)
    assert mesh.colors[0].tolist() == [1, 0, 1, 255]


@pytest.mark.parametrize("newline", [b"\r", b"\r\n"])
@pytest.mark.parametrize("first", [b"\n", b"\r"])
def test_a_ply_header_with_carriage_returns(tmp_path, newline, first):
    """Rhino writes them alone; the first number may begin with either byte."""
    corners = b"".join(struct.pack("<3f", *p) for p in box().vertices.tolist())
    corners = first + corners[1:]
    faces = b"".join(struct.pack("<B3I", 3, *f) for f in box().faces.tolist())
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(box().vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(box().faces)}\nproperty list uchar uint vertex_index\nend_header\n"
    )
    data = header.encode().replace(b"\n", newline) + corners + faces
    assert volume(written(tmp_path, "a.ply", data).solids[0].mesh) == pytest.approx(6000, rel=1e-5)


def glb(document, blob=b""):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    blob += b"\0" * (-len(blob) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text
    body += struct.pack("<II", len(blob), 0x004E4942) + blob
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def tetrahedron_document():
    places = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "<f4")
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], "<u2")
    blob = places.tobytes() + faces.tobytes()
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(blob)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 24},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
        "meshes": [{"name": "m", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    }, blob  # fmt: skip


def test_glb_node_transforms_are_applied_down_the_tree(tmp_path):
    document, blob = tetrahedron_document()
    half = 2**-0.5
    document["scenes"] = [{"nodes": [0]}]
    document["nodes"] = [
        {"translation": [1, 2, 3], "rotation": [0, half, 0, half], "children": [1, 2]},
        {"mesh": 0, "scale": [2, 2, 2], "name": "big"},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], "name": "mirror"},
    ]
    solids = {s.name: s.mesh for s in written(tmp_path, "a.glb", glb(document, blob)).solids}
    # A quarter turn about glTF's y takes x to -z and z to x; then the shift by (1, 2, 3) m;
    # ours is (x, -z, y) in mm.
    expected = np.array([[1, 2, 3], [1, 2, 1], [1, 4, 3], [3, 2, 3]])
    np.testing.assert_allclose(
        solids["big"].vertices, expected[:, [0, 2, 1]] * [1000, -1000, 1000], atol=1e-3
    )
    assert volume(solids["big"]) == pytest.approx(8e9 / 6, rel=1e-5)
    assert volume(solids["mirror"]) == pytest.approx(1e9 / 6, rel=1e-5)  # still outwards


def test_glb_corners_split_by_normals_make_one_solid(tmp_path):
    mesh = box()
    loose = Mesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(36).reshape(-1, 3))
    export(Shapes(surfaces=(Surface(loose, "cube"),)), tmp_path / "a.glb")
    solid = read_mesh(tmp_path / "a.glb").solids[0]
    assert (solid.name, len(solid.mesh.vertices)) == ("cube", 8)


@pytest.mark.parametrize("ending", ["glb", "off", "ply"])
def test_a_vertex_that_no_face_uses_counts_for_nothing(tmp_path, ending):
    """Scanners leave stray points, and primitives of one buffer use some of it each."""
    document, blob = tetrahedron_document()
    document["accessors"][1] |= {"byteOffset": 6, "count": 3}
    places, face = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n", "3 0 1 3\n"
    files = {
        "glb": glb(document, blob),
        "off": f"OFF\n4 1 0\n{places}{face}".encode(),
        "ply": (
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1\nproperty list uchar int vertex_index\n"
            f"end_header\n{places}{face}"
        ).encode(),
    }
    (part,) = written(tmp_path, f"a.{ending}", files[ending]).surfaces
    assert len(part.mesh.vertices) == 3
    assert np.ptp(part.mesh.bounds, axis=0).min() == 0.0


@pytest.mark.parametrize("mode", [5, 6])
def test_glb_strips_and_fans(tmp_path, mode):
    document, blob = tetrahedron_document()
    primitive = document["meshes"][0]["primitives"][0]
    primitive["mode"] = mode
    blob = blob[:48] + np.array([0, 1, 2, 3] + [0] * 8, "<u2").tobytes()
    document["accessors"][1]["count"] = 4
    faces = written(tmp_path, "a.glb", glb(document, blob)).surfaces[0].mesh.faces.tolist()
    # The specification (3.7.2.1) begins the triangles of a fan after the hub.
    assert faces == ([[0, 1, 2], [1, 3, 2]] if mode == 5 else [[1, 2, 0], [2, 3, 0]])


def apart(count=1, kind=5123, at=0) -> dict:
    """A sparse accessor's values: those of the first vertices are the first of the file."""
    return {
        "count": count,
        "indices": {"bufferView": 0, "componentType": kind, "byteOffset": at},
        "values": {"bufferView": 0},
    }


def test_glb_values_that_stand_apart_are_in_their_places(tmp_path):
    document, blob = tetrahedron_document()
    # Vertices 3 and 1 are said again, in other places; the others are as they were.
    view = len(document["bufferViews"])
    more = np.array([1, 3], "<u4").tobytes() + np.float32([[5, 6, 7], [8, 9, 10]]).tobytes()
    document["bufferViews"].append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(more)})
    document["accessors"][0]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": view, "componentType": 5125},
        "values": {"bufferView": view, "byteOffset": 8},
    }
    document["buffers"][0]["byteLength"] = len(blob) + len(more)
    (other,) = written(tmp_path, "a.glb", glb(document, blob + more)).meshes()
    expected = [[0, 0, 0], [5000, -7000, 6000], [0, 0, 1000], [8000, -10000, 9000]]
    found = sorted(other.mesh.vertices.tolist())
    np.testing.assert_allclose(found, sorted(expected), rtol=1e-6, atol=1e-3)


@pytest.mark.parametrize("kind", ["normalTexture", "occlusionTexture", "emissiveTexture"])
def test_glb_with_a_picture_of_relief_or_glow_is_read_and_tells(tmp_path, kind):
    document, blob = tetrahedron_document()
    document["materials"] = [{"name": "Skin", kind: {"index": 0}}]
    document["meshes"][0]["primitives"][0]["material"] = 0
    (tmp_path / "a.glb").write_bytes(glb(document, blob))
    found = read_mesh_file(tmp_path / "a.glb")
    assert len(list(found.shapes.meshes())) == 1
    assert any("relief" in str(line) for line in found.left_out)


def test_glb_materials_with_vertices_of_their_own_are_one_part(tmp_path):
    """As Blender and three.js write a mesh with two materials."""
    document, blob = tetrahedron_document()
    count = document["accessors"][1]["count"]
    again = dict(document["accessors"][0])
    document["accessors"] += [again, dict(document["accessors"][1])]
    document["accessors"][1]["count"] = 3
    document["accessors"][3].update(count=count - 3, byteOffset=6)
    document["materials"] = [{"name": "Red"}, {"name": "Blue"}]
    document["meshes"][0]["primitives"] = [
        {"attributes": {"POSITION": 0}, "indices": 1, "material": 0},
        {"attributes": {"POSITION": 2}, "indices": 3, "material": 1},
    ]
    (solid,) = written(tmp_path, "a.glb", glb(document, blob)).solids
    assert [(group.name, group.count) for group in solid.groups] == [("Red", 1), ("Blue", 3)]
    assert len(solid.mesh.vertices) == 4


def broken(change):
    document, blob = tetrahedron_document()
    return glb(change(document) or document, blob)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda d: d.update(extensionsRequired=["EXT_meshopt_compression"]), "without compression"),
        (lambda d: d["buffers"][0].update(uri="data.bin"), "not there"),
        (lambda d: d["accessors"][0].update(count=5), "cut short"),
        (lambda d: d["accessors"][0].update(count=-1), "below zero"),
        (lambda d: d["accessors"][0].update(count=10**18), "more than"),
        (lambda d: d["accessors"][0].update(type="VEC2"), "type"),
        (lambda d: d["accessors"][1].update(componentType=5126), "whole numbers"),
        (lambda d: d["accessors"][0].update(sparse={"count": 1}), "indices"),
        (lambda d: d["accessors"][0].update(sparse=apart(count=99)), "more sparse"),
        (lambda d: d["accessors"][0].update(sparse=apart(kind=5126)), "type"),
        (lambda d: d["accessors"][0].update(sparse=apart(at=10**9)), "cut short"),
        (lambda d: d["accessors"][0].pop("bufferView") or
         d["accessors"][0].update(count=2 * 10**7), "not in the file"),
        (lambda d: d["accessors"][0].update(count=3), "names a vertex"),
        (lambda d: d["meshes"][0]["primitives"][0].update(indices=9), "accessor 9"),
        (lambda d: d.update(nodes=[{"children": [1]}, {"children": [0]}], scenes=[{"nodes": [0]}]),
         "tree"),
        (lambda d: d.update(nodes=[{"mesh": 3}]), "mesh 3"),
        (lambda d: d.update(meshes="x"), "understood"),
        (lambda d: d["meshes"][0]["primitives"][0].update(mode=1), "no faces"),
    ],
)  # fmt: skip
def test_glb_that_cannot_be_read_says_why(tmp_path, change, said):
    with pytest.raises(FormatError, match=said):
        written(tmp_path, "a.glb", broken(change))


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "names a vertex"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "f 1 2 -4"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "understood"),
        ("a.obj", b"v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite"),
        ("a.obj", b"v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "fewer than three"),
        ("a.obj", b"v 0 0 1e300\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "further"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n", "names a vertex"),
        ("a.obj", b"hello", "no faces"),
        ("a.stl", b"hello", "not an STL"),
        ("a.stl", b"solid\nvertex 0 0 0\nvertex 1 0 0\nendsolid", "lacks a corner"),
        ("a.stl", b"x" * 80 + b"\xff\xff\xff\xff" + b"0" * 100, "not an STL"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 3\nend_header\n", "x, y and z"),
        ("a.ply", b"ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n", "more than"),
        ("a.ply", b"ply\nelement vertex 3\nproperty quark x\nend_header\n", "quark"),
        ("a.ply", b"plx", "not a PLY"),
        ("a.glb", b"glTF", "not a GLB"),
        ("a.glb", b"glTF\1\0\0\0" + b"\0" * 40, "glTF 1"),
        ("a.ply", b"", "empty"),
    ],
)  # fmt: skip
def test_damaged_files_say_what_is_wrong(tmp_path, name, data, said):
    with pytest.raises(FormatError, match=said):
        written(tmp_path, name, data)


def test_a_wrong_ending_lists_the_right_ones(tmp_path):
    with pytest.raises(UserError, match=r"\.stl.*\.glb"):
        read_mesh(tmp_path / "a.blend")
    with pytest.raises(UserError, match=r"no ending"):
        read_mesh(tmp_path / "a")


def test_what_is_not_there_is_no_format_error(tmp_path):
    for path in (tmp_path / "none.stl", tmp_path):
        with pytest.raises(UserError) as caught:
            read_mesh(path if path.suffix else tmp_path / "none.glb")
        assert not isinstance(caught.value, FormatError)
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises(UserError, match="folder"):
        read_mesh(tmp_path / "folder.stl")


@pytest.mark.parametrize("key", ["scale", "translation", "rotation"])
def test_glb_nodes_cannot_be_flung_to_infinity(tmp_path, key):
    document, blob = tetrahedron_document()
    big = [1e300] * (4 if key == "rotation" else 3)
    document["nodes"] = [{"mesh": 0, key: big}]
    with pytest.raises(FormatError, match="further"):
        written(tmp_path, "a.glb", glb(document, blob))
