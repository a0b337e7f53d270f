"""OFF files: those that Geomview, OpenSCAD and CGAL write, and a reader of others'."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import FormatError
from bozzetto.exchange.import_file import read_mesh, read_mesh_file
from bozzetto.exchange.mesh.off import read_shapes
from bozzetto.geometry import Mesh

PLACES = b"0 0 0\n20 0 0\n20 20 0\n0 20 0\n0 0 20\n20 0 20\n20 20 20\n0 20 20\n"
FACES = (b"4 0 3 2 1", b"4 4 5 6 7", b"4 0 1 5 4", b"4 1 2 6 5", b"4 2 3 7 6", b"4 3 0 4 7")


def cube(head: bytes = b"OFF\n8 6 0\n", tails: tuple[bytes, ...] = (b"",) * 6) -> bytes:
    return head + PLACES + b"".join(f + t + b"\n" for f, t in zip(FACES, tails, strict=True))


def volume(mesh: Mesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    return float(np.einsum("fi,fi->f", a, np.cross(b, c)).sum() / 6.0)


@pytest.mark.parametrize(
    "head",
    [
        b"OFF\n8 6 12\n",
        b"OFF 8 6 0\n",  # as OpenSCAD writes it
        b"# made by hand\nOFF # a word\n\n8 6 0 # counts\n",
        b"off\r\n8 6\r\n",
        b"OFF8 6 12\n",
    ],
)
def test_a_cube_is_a_solid(tmp_path, head):
    (tmp_path / "cube.off").write_bytes(cube(head))
    (solid,) = read_mesh(tmp_path / "cube.off").solids
    assert solid.name == "cube"
    assert len(solid.mesh.faces) == 12
    assert volume(solid.mesh) == pytest.approx(8000.0)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-be", "utf-16-le"])
@pytest.mark.parametrize("ending", ["off", "obj"])
def test_text_of_any_encoding_is_the_same_cube(tmp_path, ending, encoding):
    """As Windows PowerShell writes it; without a mark at its beginning UTF-16 is not known."""
    vertices, rows = PLACES.decode().splitlines(), [face.decode().split() for face in FACES]
    obj = [f"v {line}" for line in vertices]
    obj += ["f " + " ".join(str(int(at) + 1) for at in row[1:]) for row in rows]
    text = cube().decode() if ending == "off" else "\n".join(obj)
    mark = "\ufeff" if encoding.endswith("e") else ""
    path = tmp_path / f"cube.{ending}"
    path.write_bytes((mark + text).encode(encoding))
    (solid,) = read_mesh(path).solids
    assert len(solid.mesh.faces) == 12
    assert volume(solid.mesh) == pytest.approx(8000.0)


def test_colours_of_faces_are_groups_in_the_order_of_their_first_face():
    tails = (b" 255 0 0", b" 0 0 255", b" 255 0 0", b"", b" 0.0 1.0 0.0 0.5", b" 7")
    (part,) = read_shapes(cube(tails=tails)).surfaces
    assert [(g.count, g.color) for g in part.groups] == [
        (4, (255, 0, 0)), (2, (0, 0, 255)), (4, None), (2, (0, 255, 0)),
    ]  # fmt: skip
    assert part.groups[0].name == "#ff0000"


def test_one_colour_is_that_of_the_part():
    (part,) = read_shapes(cube(tails=(b" 10 20 30 255",) * 6)).surfaces
    assert (part.color, part.groups) == ((10, 20, 30), ())


def test_vertices_have_colours_and_normals():
    rows = (
        b"0 0 0 0 0 1 1.0 0.5 0.0 1.0\n1 0 0 0 0 1 0.0 0.0 1.0 1.0\n0 1 0 0 0 1 0.0 0.0 0.0 1.0\n"
    )
    (part,) = read_shapes(b"CNOFF\n3 1 0\n" + rows + b"3 0 1 2\n").surfaces
    assert part.mesh.colors is not None
    assert part.mesh.colors[:, :3].tolist() == [[255, 128, 0], [0, 0, 255], [0, 0, 0]]
    rows = b"0 0 0 9 8 7 255\n1 0 0 0 0 0 255\n0 1 0 1 1 1 255\n3 0 1 2\n"
    (part,) = read_shapes(b"COFF\n3 1 0\n" + rows).surfaces
    assert part.mesh.colors is not None
    assert part.mesh.colors.tolist()[0] == [9, 8, 7, 255]
    rows = b"0 0 0 1e308 .5 -1e999\n1 0 0 nan 0 0\n0 1 0 1 1 1\n3 0 1 2 1e308 .5 0\n"
    (part,) = read_shapes(b"COFF\n3 1 0\n" + rows).surfaces
    assert part.mesh.colors is not None
    assert part.mesh.colors[:, :3].tolist() == [[255, 128, 0], [0, 0, 0], [255, 255, 255]]


def test_too_many_colours_are_told(tmp_path):
    rows = b"".join(b"3 0 1 2 %d %d 0\n" % (k % 256, k // 256) for k in range(1001))
    (tmp_path / "a.off").write_bytes(b"OFF\n3 1001 0\n0 0 0\n1 0 0\n0 1 0\n" + rows)
    read = read_mesh_file(tmp_path / "a.off")
    assert "colours of its faces" in read.left_out[0]
    assert "PLY" in read.left_out[0]


def test_the_frame_is_guessed_and_said(tmp_path):
    (tmp_path / "a.off").write_bytes(cube(b"OFF\n# units: inch, Y up\n8 6 0\n"))
    read = read_mesh_file(tmp_path / "a.off")
    assert read.guess is not None
    assert (read.guess.unit, read.guess.up) == ("in", "y")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"4OFF\n1 1 0\n0 0 0 0\n1 0\n", "not places in space"),
        (b"OFF BINARY\n" + bytes(40), "binary"),
        (b"PLY\n", "not an OFF"),
        (b"", "not an OFF"),
        (b"OFF\n8 6 0\n1 2 3\n", "cut short"),
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "does not hold"),
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "does not hold"),
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n", "“3 0 1”"),
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 x\n3 0 1 2\n", "not made of numbers"),
        (b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n", "not finite"),
        (b"OFF\n-3 1 0\n", "“-3 1 0”"),
    ],
)
def test_what_is_wrong_is_said(data, said):
    with pytest.raises(FormatError, match=said):
        read_shapes(data)


def test_trimeshs_files_come_back(tmp_path):
    trimesh = pytest.importorskip("trimesh")
    random = np.random.default_rng(4)
    ball = trimesh.creation.icosphere(2, 30.0)
    ball.vertices = ball.vertices + random.normal(scale=0.5, size=ball.vertices.shape)
    (tmp_path / "ball.off").write_text(ball.export(file_type="off", digits=9))
    (solid,) = read_mesh(tmp_path / "ball.off").solids
    assert volume(solid.mesh) == pytest.approx(ball.volume, rel=1e-6)
    np.testing.assert_array_equal(solid.mesh.faces, ball.faces)
