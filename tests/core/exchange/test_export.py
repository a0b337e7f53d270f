"""Export as a whole: what is refused, and that no file is ever half written."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.exchange import formats
from bozzetto.exchange.export import export
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import Curve, Mesh, Shapes, Skeleton, Solid, Surface

TETRA = Mesh(
    [[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
)
LINE = Curve(1, [0, 0, 1, 1], [[0, 0, 0], [10, 0, 5]])


def moved(mesh, shift):
    return Mesh(mesh.vertices + np.float32(shift), mesh.faces)


def together(*meshes):
    starts = np.cumsum([0] + [len(m.vertices) for m in meshes[:-1]])
    return Mesh(
        np.vstack([m.vertices for m in meshes]),
        np.vstack([m.faces + s for m, s in zip(meshes, starts, strict=True)]),
    )


def test_a_solid_is_measured():
    facts = check_solid(Solid(TETRA))
    assert facts.volume == pytest.approx(36)
    assert (facts.genus, facts.parts) == (0, 1)


def test_two_bodies_and_a_ring_are_counted():
    import manifold3d

    ring = manifold3d.CrossSection.circle(2, 24).translate((10, 0)).revolve(32).to_mesh()
    torus = Mesh(ring.vert_properties[:, :3], ring.tri_verts)
    facts = check_solid(Solid(together(torus, moved(TETRA, (50, 0, 0)))))
    assert (facts.genus, facts.parts) == (1, 2)
    assert facts.volume == pytest.approx(36 + 2 * np.pi**2 * 10 * 2**2, rel=0.03)


@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        (Mesh(TETRA.vertices, TETRA.faces[:3]), "not closed: 3 edges"),
        (Mesh(TETRA.vertices, TETRA.faces[:, ::-1]), "inside out"),
        (Mesh(TETRA.vertices, np.vstack((TETRA.faces, TETRA.faces))), "not closed"),
        (Mesh(TETRA.vertices * np.float32([1, 1, 0]), TETRA.faces), "flat"),
        (Mesh(TETRA.vertices, np.vstack((TETRA.faces[:3], [[1, 3, 2]]))), "not closed"),
        (Mesh(np.zeros((0, 3)), np.zeros((0, 3))), "no surface yet"),
    ],
    ids=["open", "inside out", "doubled", "flat", "one face turned", "empty"],
)
def test_what_is_no_solid_is_named_and_not_written(tmp_path, mesh, said):
    path = tmp_path / "a.stl"
    path.write_bytes(b"old")
    with pytest.raises(UserError, match=f"“leg”.*{said}"):
        export(Shapes(solids=(Solid(TETRA, "body"), Solid(mesh, "leg"))), path)
    assert path.read_bytes() == b"old"


def test_nothing_to_export(tmp_path):
    with pytest.raises(UserError, match="Draw something"):
        export(Shapes(), tmp_path / "a.stl")
    with pytest.raises(UserError, match=r"STL.*none.*\.svg"):
        export(Shapes(curves=(LINE,)), tmp_path / "a.stl")
    with pytest.raises(UserError, match=r"SVG.*curves.*\.stl"):
        export(Shapes(solids=(Solid(TETRA),)), tmp_path / "a.svg")
    with pytest.raises(UserError, match="Draw some"):
        export(Shapes(skeletons=(Skeleton([[0, 0, 0]], [1], []),)), tmp_path / "a.stl")
    with pytest.raises(UserError, match=r"\.3mf.*\.svg"):
        export(Shapes(solids=(Solid(TETRA),)), tmp_path / "a.docx")
    assert not list(tmp_path.iterdir())


def test_parts_without_a_place_are_left_out(tmp_path):
    export(Shapes(solids=(Solid(TETRA),), curves=(LINE,)), tmp_path / "A.STL")
    assert (tmp_path / "A.STL").stat().st_size == 84 + 4 * 50


# -- files (how they are put on the disk is tested with bozzetto.atomic_files) --


def test_a_refused_export_leaves_the_old_file_and_no_rubbish(tmp_path):
    path = tmp_path / "a.stl"
    path.write_bytes(b"old")
    with pytest.raises(UserError):
        export(Shapes(), path)
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.stl"]


# -- the table -----------------------------------------------------------------------------


def test_every_format_has_the_functions_that_it_promises():
    for one in formats.FORMATS:
        names = []
        if one.writes and {"mesh", "surfaces", "curves"} & set(one.holds):
            names.append("write_view" if one.flat else "write_shapes")
        if "ink" in one.holds:
            names += ["write_drawing"] * one.writes + ["read_drawing"] * one.reads
        if "mesh" in one.holds and one.reads:
            names.append("read_shapes")
        if "image" in one.holds:
            names.append("read_pixels")
        assert names, one.id
        for name in names:
            assert callable(formats.function(one, name)), (one.id, name)


def test_ids_and_endings_are_unique():
    kinds = ("mesh", "ink", "image")  # one ending may hold either; `is_mesh` looks into the file
    for some in (formats.writers(), *map(formats.readers, kinds)):
        endings = [ending for one in some for ending in one.endings]
        assert len(set(endings)) == len(endings)
    assert all(e == e.lower() and e.startswith(".") for e in endings)
    assert len({one.id for one in formats.FORMATS}) == len(formats.FORMATS)


def test_the_table_and_the_way_to_it_import_nothing_heavy():
    import subprocess
    import sys

    code = (
        "import sys; import bozzetto.exchange.export, bozzetto.exchange.import_file; "
        "heavy = {'scipy', 'manifold3d', 'PIL', 'shapely', 'skimage'} & set(sys.modules); "
        "formats = [m for m in sys.modules if m.startswith('bozzetto.exchange.')]; "
        "assert not heavy, heavy; assert 'bozzetto.exchange.mesh.glb' not in formats"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_surfaces_need_not_be_closed(tmp_path):
    export(Shapes(surfaces=(Surface(Mesh(TETRA.vertices, TETRA.faces[:2])),)), tmp_path / "a.obj")
    assert (tmp_path / "a.obj").read_text().count("\nf ") == 2
