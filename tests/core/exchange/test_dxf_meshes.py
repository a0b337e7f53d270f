"""Meshes of DXF files, against files that ezdxf writes."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import FormatError
from bozzetto.exchange import import_file
from bozzetto.exchange.cad import dxf_document
from bozzetto.exchange.cad.dxf_document import mostly_faces
from bozzetto.exchange.cad.dxf_mesh_reader import read_shapes
from bozzetto.exchange.import_file import is_mesh, read_mesh, read_mesh_file
from bozzetto.exchange.reading import Reading
from tests.core.exchange.test_dxf_reader import drawn, square
from tests.core.exchange.test_off import volume

pytest.importorskip("ezdxf", reason="the extra “dxf” is not installed")

CORNERS = [(x, y, z) for x in (0, 30) for y in (0, 20) for z in (0, 10)]
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def box(**more):
    from ezdxf.render import MeshBuilder

    made = MeshBuilder()
    made.add_mesh(vertices=CORNERS, faces=QUADS)
    return made


WAYS = {
    "3DFACE": lambda space, **more: box().render_3dfaces(space, **more),
    "polyface": lambda space, **more: box().render_polyface(space, **more),
    "MESH": lambda space, **more: box().render_mesh(space, **more),
}
EVERY = pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)


@EVERY
def test_a_box_is_a_solid_in_the_files_unit(tmp_path, way):
    (tmp_path / "box.dxf").write_bytes(drawn(way, units=1))
    assert is_mesh(tmp_path / "box.dxf")
    (solid,) = read_mesh(tmp_path / "box.dxf").solids
    assert solid.name == "box"
    assert len(solid.mesh.faces) == 12
    assert volume(solid.mesh) == pytest.approx(6000.0 * 25.4**3, rel=1e-5)


@EVERY
def test_layers_are_parts_with_their_colours_and_hidden_ones_are_not_seen(way):
    def layers(space):
        space.doc.layers.add("Roof", color=1)
        space.doc.layers.add("Away").off()
        way(space, dxfattribs={"layer": "Roof"})
        way(space, dxfattribs={"layer": "Away"})
        way(space, dxfattribs={"true_color": 0x102030})

    parts = read_shapes(drawn(layers)).surfaces
    assert sorted((one.name, one.color) for one in parts) == [
        ("", (16, 32, 48)), ("Roof", (255, 0, 0)),
    ]  # fmt: skip


@EVERY
def test_blocks_are_taken_apart_and_placed(way):
    def blocks(space):
        way(space.doc.blocks.new("b"))
        space.add_blockref("b", (100, 0, 7), dxfattribs={"xscale": 2, "rotation": 90})

    (part,) = read_shapes(drawn(blocks)).surfaces
    np.testing.assert_allclose(part.mesh.bounds, [[80, 0, 7], [100, 60, 17]], atol=1e-4)


def test_a_grid_closes_where_it_says_so():
    def ring(space):
        mesh = space.add_polymesh((12, 8))
        for i in range(12):
            for j in range(8):
                a, b = 2 * np.pi * i / 12, 2 * np.pi * j / 8
                wide = 30 + 10 * np.cos(b)
                mesh.set_mesh_vertex((i, j), (wide * np.cos(a), wide * np.sin(a), 10 * np.sin(b)))
        mesh.close(m_close=True, n_close=True)

    (part,) = read_shapes(drawn(ring)).surfaces
    assert len(part.mesh.faces) == 12 * 8 * 2
    edges = np.sort(np.concatenate([part.mesh.faces[:, [k, k - 2]] for k in range(3)]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


def test_what_is_no_face_is_told():
    def both(space):
        WAYS["3DFACE"](space)
        space.add_line((0, 0), (1, 1))
        space.add_text("a")

    reading = Reading()
    read_shapes(drawn(both, units=0), reading)
    told = " ".join(reading.left_out)
    assert "1 LINE, 1 TEXT" in told
    assert "does not say its unit" in told


def test_a_file_of_more_lines_than_faces_is_a_drawing(tmp_path):
    def both(space, lines):
        space.add_3dface([(0, 0), (1, 0), (1, 1)])
        WAYS["polyface"](space)
        for k in range(lines):
            square(space, 5.0 + k)

    for lines, mesh in ((0, True), (1, False)):
        data = drawn(lambda space, lines=lines: both(space, lines))
        assert mostly_faces(data) == mesh
        assert mostly_faces(data.replace(b"\r\n", b"\n").replace(b"\n", b"\r\n")) == mesh


def test_a_polyline_is_a_line(tmp_path):
    data = drawn(lambda space: space.add_polyline3d([(0, 0, 0), (1, 0, 0), (1, 1, 1)]))
    assert not mostly_faces(data)
    (tmp_path / "a.dxf").write_bytes(data)
    assert not is_mesh(tmp_path / "a.dxf")
    with pytest.raises(FormatError, match="no faces"):
        read_mesh_file(tmp_path / "a.dxf")


def test_a_row_of_meshes_counts_their_corners(monkeypatch):
    monkeypatch.setattr(dxf_document, "MAX_STROKES", 60)

    def rows(space):
        WAYS["polyface"](space.doc.blocks.new("b"))
        for k in range(6):
            space.add_blockref("b", (40 * k, 0))

    with pytest.raises(FormatError, match="60"):
        read_shapes(drawn(rows))


def test_the_command_line_takes_either(tmp_path, capsys):
    from bozzetto.cli.main import main

    (tmp_path / "box.dxf").write_bytes(drawn(WAYS["MESH"]))
    target = tmp_path / "box.stl"
    assert main(["build", "mesh", str(tmp_path / "box.dxf"), "-o", str(target)]) == 0
    (solid,) = read_mesh(target).solids
    assert volume(solid.mesh) == pytest.approx(6000.0)
    assert main(["info", str(tmp_path / "box.dxf")]) == 0
    assert "12" in capsys.readouterr().out


def test_a_very_large_file_is_asked_by_its_beginning(tmp_path, monkeypatch):
    path = tmp_path / "box.dxf"
    path.write_bytes(drawn(WAYS["3DFACE"]))
    monkeypatch.setattr(import_file, "MAX_INK_BYTES", path.stat().st_size - 1)
    assert is_mesh(path)
    assert len(read_mesh(path, trusted=True).solids) == 1
