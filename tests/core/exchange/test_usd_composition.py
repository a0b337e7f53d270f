"""USD scenes in several files, and bodies that are told by their measures."""

from __future__ import annotations

import json
import zipfile

import numpy as np
import pytest

from bozzetto.errors import FormatError
from bozzetto.exchange.import_file import read_mesh_file
from tests.core.exchange.test_mesh_formats import volume
from tests.usd_reader import asked_usd

HEAD = '#usda 1.0\n( defaultPrim = "top"\n upAxis = "Z"\n metersPerUnit = 0.001 {more})\n'
BOX = 'def Cube "{name}" {{ double size = {size}\n{more} }}\n'
AT = 'double3 xformOp:translate = ({0}, 0, 0)\nuniform token[] xformOpOrder = ["xformOp:translate"]'


def write(path, body, more=""):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(HEAD.format(more=more) + body)


def boxes(path):
    """Names, middles along x and sizes of all that is read."""
    found = read_mesh_file(path)
    rows = [
        (
            p.name,
            round(float(p.mesh.bounds[:, 0].mean()), 6),
            round(float(np.ptp(p.mesh.bounds[:, 0])), 6),
        )
        for p in found.shapes.solids
    ]
    assert not found.shapes.surfaces
    return rows, found.left_out


def test_what_lies_in_other_files_comes_in_at_its_place(tmp_path):
    write(
        tmp_path / "parts" / "wheel.usda",
        f'def Xform "top" {{ {BOX.format(name="rim", size=2, more="")} }}',
    )
    write(tmp_path / "parts" / "car.usda",
          f'def Xform "top" {{ def "left" (references = @wheel.usda@) {{ {AT.format(10)} }}'
          f' def "right" (payload = @./wheel.usda@) {{ {AT.format(-10)} }} }}')  # fmt: skip
    write(tmp_path / "scene.usda",
          'def Xform "top" { def "one" (prepend references = @parts/car.usda@</top>) {'
          f'{AT.format(100)} over "left" {{ over "rim" {{ double size = 6 }} }} }} }}')  # fmt: skip
    assert boxes(tmp_path / "scene.usda") == ([("rim", 110, 6), ("rim", 90, 2)], ())


def test_sublayers_are_weaker_the_later_they_stand(tmp_path):
    write(
        tmp_path / "weak.usda",
        'def Xform "top" { def Cube "a" { double size = 1 } def Cube "b" { double size = 1 } }',
    )
    write(
        tmp_path / "strong.usda",
        'over "top" { over "a" { double size = 2 } over "b" { double size = 2 } }',
    )
    write(tmp_path / "scene.usda", 'over "top" { over "a" { double size = 3 } }',
          "subLayers = [ @strong.usda@, @./weak.usda@ ]")  # fmt: skip
    rows, told = boxes(tmp_path / "scene.usda")
    assert sorted(rows) == [("a", 0, 3), ("b", 0, 2)]
    assert told == ()


def test_what_a_prim_says_is_stronger_than_what_it_takes(tmp_path):
    write(tmp_path / "other.usda", 'def Cube "top" { double size = 5\n' + AT.format(50) + " }")
    write(tmp_path / "scene.usda",
          'class "kind" { double size = 4 }\n'
          'def Xform "top" { def Cube "a" (inherits = </kind>) { }\n'
          'def Cube "b" (inherits = </kind>) { double size = 3 }\n'
          'def "c" (inherits = </kind>\n references = @other.usda@) { }\n'
          'def "d" (references = </top/b>) { } }')  # fmt: skip
    rows, told = boxes(tmp_path / "scene.usda")
    assert rows == [("a", 0, 4), ("b", 0, 3), ("c", 50, 4), ("d", 0, 3)]
    assert told == ()


@pytest.mark.parametrize(
    "named",
    [
        "../out.usda",
        "/etc/out.usda",
        "a/../../out.usda",
        "http://x/out.usda",
        "away.usda",
        "text.txt",
        "scene.usda",
        "",
    ],
)
def test_what_cannot_be_taken_in_is_told(tmp_path, named):
    inner = tmp_path / "folder"
    write(tmp_path / "out.usda", BOX.format(name="top", size=9, more=""))
    write(
        inner / "scene.usda",
        f'{BOX.format(name="a", size=1, more="")}def "b" (references = @{named}@) {{}}',
    )
    (inner / "text.txt").write_text("nothing")
    rows, told = boxes(inner / "scene.usda")
    assert rows == [("a", 0, 1)]
    assert any("it takes from" in line for line in told) == bool(named)


def test_what_takes_in_itself_ends(tmp_path):
    write(tmp_path / "x.usda", 'def Xform "top" (references = @y.usda@) { def Cube "x" {} }')
    write(tmp_path / "y.usda", 'def Xform "top" (references = @x.usda@) { def Cube "y" {} }')
    write(tmp_path / "scene.usda", 'def Xform "top" { def "a" (references = @x.usda@) {}'
          ' def Xform "b" (references = </top>) {} }', "subLayers = [ @scene.usda@ ]")  # fmt: skip
    rows, told = boxes(tmp_path / "scene.usda")
    assert ("x", 0, 2) in rows
    assert ("y", 0, 2) in rows
    assert any("it takes from" in line for line in told)


def test_references_that_double_are_refused_in_time(tmp_path):
    rows = "".join(
        f'def "p{k}" {{ def "a" (references = </p{k - 1}>) {{}}\n'
        f'def "b" (references = </p{k - 1}>) {{}} }}\n'
        for k in range(1, 40)
    )
    write(tmp_path / "scene.usda", BOX.format(name="p0", size=1, more="") + rows)
    with pytest.raises(FormatError, match="from elsewhere"):
        read_mesh_file(tmp_path / "scene.usda")


def test_a_package_holds_its_own_files(tmp_path):
    write(
        tmp_path / "a" / "main.usda", 'def Xform "top" { def "b" (references = @sub/box.usda@) {} }'
    )
    write(tmp_path / "a" / "sub" / "box.usda", BOX.format(name="top", size=7, more=""))
    with zipfile.ZipFile(tmp_path / "p.usdz", "w") as package:
        for name in ("main.usda", "sub/box.usda"):
            package.write(tmp_path / "a" / name, name)
    assert boxes(tmp_path / "p.usdz") == ([("b", 0, 7)], ())


def test_pictures_of_referred_files_are_seen_from_these(tmp_path):
    from PIL import Image

    square = (
        "int[] faceVertexCounts = [4]\nint[] faceVertexIndices = [0, 1, 2, 3]\n"
        "point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]\n"
        'texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "vertex" )\n'
        "rel material:binding = </top/look>"
    )
    look = (
        'def Material "look" { token outputs:surface.connect = </top/look/s.outputs:surface>\n'
        'def Shader "s" { uniform token info:id = "UsdPreviewSurface"\n'
        "color3f inputs:diffuseColor.connect = </top/look/t.outputs:rgb>\ntoken outputs:surface }\n"
        'def Shader "t" { uniform token info:id = "UsdUVTexture"\nasset inputs:file = @./red.png@\n'
        "float3 outputs:rgb } }"
    )
    write(
        tmp_path / "parts" / "card.usda",
        f'def Xform "top" {{ def Mesh "card" {{ {square} }} {look} }}',
    )
    Image.new("RGB", (4, 4), (200, 10, 10)).save(tmp_path / "parts" / "red.png")
    write(tmp_path / "scene.usda", 'def "elsewhere" (references = @parts/card.usda@) {}')
    found = read_mesh_file(tmp_path / "scene.usda")
    (card,) = found.shapes.surfaces
    assert found.left_out == ()
    assert card.texture.pixels[0, 0, :3].tolist() == [200, 10, 10]


CAPSULE = np.pi * (0.5**2 * 3.0 + 4.0 / 3.0 * 0.5**3)
BODIES = {
    'Cube "s" { double size = 3 }': (27.0, (3, 3, 3)),
    'Sphere "s" { double radius = 2 }': (4.0 / 3.0 * np.pi * 8.0, (4, 4, 4)),
    'Cylinder "s" { double height = 5\n token axis = "X" }': (5.0 * np.pi, (5, 2, 2)),
    'Cone "s" { double radius = 2\n token axis = "Y" }': (8.0 / 3.0 * np.pi, (4, 2, 4)),
    'Capsule "s" { double height = 3 }': (CAPSULE, (1, 1, 4)),
    'Cylinder_1 "s" { double radiusBottom = 2\n double radiusTop = 1 }': (
        14.0 / 3.0 * np.pi,
        (4, 4, 2),
    ),
}


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("body", BODIES)
def test_bodies_are_closed_and_of_their_size(tmp_path, body, mirrored):
    turn = (
        'double3 xformOp:scale = ({0}, 1, 1)\nuniform token[] xformOpOrder = ["xformOp:scale"] }}'
    )
    write(tmp_path / "a.usda", "def " + body[:-1] + "\n" + turn.format(-1 if mirrored else 1))
    found = read_mesh_file(tmp_path / "a.usda")
    (solid,) = found.shapes.solids
    wanted, size = BODIES[body]
    assert volume(solid.mesh) == pytest.approx(wanted, rel=0.004)
    np.testing.assert_allclose(np.ptp(solid.mesh.bounds, axis=0), size, rtol=1e-6)
    assert bool(found.left_out) == (not body.startswith("Cube"))


@pytest.mark.parametrize("axis", "XYZ")
def test_a_plane_faces_along_its_axis(tmp_path, axis):
    write(
        tmp_path / "a.usda",
        f'def Plane "s" {{ double width = 3\n double length = 5\n token axis = "{axis}" }}',
    )
    (part,) = read_mesh_file(tmp_path / "a.usda").shapes.surfaces
    a, b, c = (part.mesh.vertices[part.mesh.faces[0, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    np.testing.assert_allclose(normal / np.linalg.norm(normal), np.eye(3)["XYZ".index(axis)])


@pytest.mark.parametrize(
    "wrong", ["double size = -1", "double size = nan", "double[] size = [1, 2]", 'token axis = "W"']
)
def test_measures_that_are_none_are_refused_or_passed_over(tmp_path, wrong):
    write(tmp_path / "a.usda", f'def Cube "s" {{ {wrong} }}')
    if "[]" in wrong:
        assert boxes(tmp_path / "a.usda")[0] == [("s", 0, 2)]
    else:
        with pytest.raises(FormatError):
            read_mesh_file(tmp_path / "a.usda")


EXTENTS = """
answer = {}
cache = UsdGeom.XformCache()
for prim in stage.Traverse():
    if prim.IsA(UsdGeom.Gprim):
        time = Usd.TimeCode.Default()
        extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), time)
        box = Gf.BBox3d(Gf.Range3d(*map(Gf.Vec3d, extent)), cache.GetLocalToWorldTransform(prim))
        range = box.ComputeAlignedRange()
        answer[prim.GetName()] = [list(range.GetMin()), list(range.GetMax())]
"""


@pytest.mark.interop
def test_usds_own_library_has_bodies_of_the_same_extent_at_the_same_places(tmp_path):
    kinds = [body.replace('"s"', f'"s{k}"', 1) for k, body in enumerate(BODIES) if "_1" not in body]
    kinds += [
        'Plane "p0" { token axis = "Y"\n double width = 3 }',
        'Plane "p1" { token axis = "X"\n double width = 3 }',
    ]
    body = "".join(
        "def " + kind[:-1] + "\n" + AT.format(7 * k) + "\n}\n" for k, kind in enumerate(kinds)
    )
    write(tmp_path / "parts.usda", 'def Xform "top" {\n' + body + "}")
    write(
        tmp_path / "scene.usda",
        'def Xform "top" (references = @parts.usda@) {\n'
        ' double xformOp:rotateZ = 90\nuniform token[] xformOpOrder = ["xformOp:rotateZ"]\n}',
    )
    seen = asked_usd(EXTENTS, tmp_path / "scene.usda")
    parts = {part.name: part for part in read_mesh_file(tmp_path / "scene.usda").shapes.meshes()}
    assert parts.keys() == seen.keys(), json.dumps(seen)
    for name, box in seen.items():
        np.testing.assert_allclose(parts[name].mesh.bounds, box, atol=5e-3)
