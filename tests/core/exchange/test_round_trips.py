"""Our own files read and written again: the same bytes where it can be, else what differs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.exchange.export import export, write_drawing
from bozzetto.exchange.import_file import read_drawing, read_mesh_file
from bozzetto.geometry import Curve, FaceGroup, Shapes, Solid
from bozzetto.ink import Drawing, Stroke
from bozzetto.ink.stroke import Strokes
from bozzetto.view import Camera
from tests.core.exchange.skinned import skinned, tube


def tubes(rows=(("Head", (255, 0, 0)), ("Tail", None)), normals=True):
    """A plain tube and one in groups of names and colours, in half as many triangles each."""
    mesh = tube()
    mesh = mesh if normals else replace(mesh, normals=None)
    count = len(mesh.faces) // len(rows)
    groups = tuple(FaceGroup(name, count, color) for name, color in rows)
    assert count * len(rows) == len(mesh.faces)
    return Shapes(
        solids=(Solid(mesh, "Worm “é”", (200, 100, 50), groups=groups), Solid(mesh, "Plain"))
    )


def again(tmp_path, shapes, name):
    """Write, read, and write; the bytes of both files, and of those beside them."""
    found = []
    for turn in ("one", "two", "three"):
        (tmp_path / turn).mkdir()
        path = tmp_path / turn / name
        export(shapes, path)
        found.append({one.name: one.read_bytes() for one in path.parent.iterdir()})
        shapes = read_mesh_file(path, trusted=True).upright
    return found


@pytest.mark.parametrize("ending", ["glb", "stl", "ply"])
def test_meshes_come_back_byte_for_byte(tmp_path, ending):
    one, two, _ = again(tmp_path, tubes(), f"a.{ending}")
    assert one == two


@pytest.mark.parametrize("ending", ["glb", "3mf", "usda", "usdz"])
def test_pictures_and_bones_come_back_byte_for_byte(tmp_path, ending):
    shapes = Shapes(solids=(skinned(texture=True),))
    one, two, _ = again(tmp_path, shapes, f"a.{ending}")
    assert one == two


def test_obj_comes_back_byte_for_byte_but_for_normals_that_it_did_not_make(tmp_path):
    one, two, _ = again(tmp_path, tubes(normals=False), "a.obj")
    assert one == two
    other = tmp_path / "smooth"
    other.mkdir()
    one, two, three = again(other, tubes(), "a.obj")
    assert two == three
    rows = [
        [line for line in each["a.obj"].splitlines() if not line.startswith((b"vn ", b"f "))]
        for each in (one, two)
    ]
    assert rows[0] == rows[1]


@pytest.mark.parametrize("ending", ["3mf", "usda", "usdz", "obj"])
def test_what_one_way_changes_the_next_does_not(tmp_path, ending):
    """3MF gathers triangles by colour; USD drops a colour that every group hides."""
    looks = (("Head", (255, 0, 0)), ("Tail", (0, 0, 255)), ("Ring", None), ("Head", (255, 0, 0)))
    shapes = tubes(looks)
    one, two, three = again(tmp_path, shapes, f"a.{ending}")
    assert two == three
    assert one.keys() == two.keys()
    places = [
        np.array(sorted(part.mesh.vertices[part.mesh.faces].reshape(-1, 9).tolist()))
        for turn in ("one", "two")
        for part in read_mesh_file(tmp_path / turn / f"a.{ending}", trusted=True).shapes.meshes()
    ]
    half = len(places) // 2
    assert all((a == b).all() for a, b in zip(places[:half], places[half:], strict=True))


def test_ink_comes_back_from_svg_byte_for_byte_once_it_was_there(tmp_path):
    rng = np.random.default_rng(2)
    camera = Camera()
    strokes = tuple(
        Stroke(*(rng.normal(size=(2, 30)).cumsum(axis=1) * 9 + 300), camera, color=(9, 90, 200))
        for _ in range(4)
    )
    drawing = Drawing(Strokes(strokes), camera, "a")
    found = []
    for turn in ("one", "two", "three"):
        path = tmp_path / f"{turn}.svg"
        write_drawing(replace(drawing, name="a"), path)
        found.append(path.read_bytes())
        drawing = read_drawing(path, trusted=True)
    assert found[1] == found[2]
    assert len(drawing.strokes) == len(strokes)


def test_curves_come_back_from_dxf_where_they_were(tmp_path):
    """DXF gives ink: what was a spline is a line of places on it, and the file carries its date."""
    pytest.importorskip("ezdxf", reason="the extra “dxf” is not installed")
    rng = np.random.default_rng(5)
    points = np.column_stack((rng.uniform(0, 90, (7, 2)), np.zeros(7)))
    knots = np.array([0, 0, 0, 0, 1, 2, 3, 4, 4, 4, 4.0])
    curve = Curve(3, knots, points, rng.uniform(0.5, 2.0, 7))
    export(Shapes(curves=(curve,)), tmp_path / "a.dxf")
    (stroke,) = read_drawing(tmp_path / "a.dxf", trusted=True).strokes
    dense = curve.value(np.linspace(0, 4, 20_001))[:, :2] * (1, -1)
    size = float(np.linalg.norm(np.ptp(dense, axis=0)))
    low = dense.min(axis=0)
    seen = np.column_stack((stroke.x, stroke.y))
    seen = seen - seen.min(axis=0) + low
    off = [np.linalg.norm(dense - place, axis=1).min() for place in seen]
    assert max(off) < 5e-4 * size
