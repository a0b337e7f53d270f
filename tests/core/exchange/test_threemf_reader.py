"""3MF in: what other programs write, our own files, colours, places, and packages that are none."""

from __future__ import annotations

import io
import shutil
import subprocess
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import FormatError
from bozzetto.exchange.export import prepare_export
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.import_file import read_mesh_file
from bozzetto.exchange.mesh import threemf_reader
from bozzetto.geometry import FaceGroup, Mesh, Shapes, Solid
from tests.core.exchange.test_mesh_formats import box, volume

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
COLORS = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
PARTS = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
TETRA = (
    '<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>'
    '<vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/></vertices>'
    '<triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/>'
    '<triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/></triangles></mesh>'
)


def model(resources, build, unit="millimeter"):
    return (
        f'<?xml version="1.0"?><model unit="{unit}" xmlns="{CORE}" xmlns:m="{COLORS}" '
        f'xmlns:p="{PARTS}"><resources>{resources}</resources><build>{build}</build></model>'
    )


def package(**models):
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w", zipfile.ZIP_DEFLATED) as file:
        for name, text in models.items():
            file.writestr(name, text)
    return data.getvalue()


def read(tmp_path, data, *, trusted=False):
    (tmp_path / "a.3mf").write_bytes(data)
    return read_mesh_file(tmp_path / "a.3mf", trusted=trusted)


def plain(resources, build, unit="millimeter"):
    return package(**{"3D/3dmodel.model": model(resources, build, unit)})


@pytest.mark.interop
@pytest.mark.skipif(shutil.which("prusa-slicer") is None, reason="PrusaSlicer is not here")
def test_what_prusaslicer_saves_comes_back(tmp_path):
    block = Solid(box((10.0, 20.0, 30.0)), "block")
    (tmp_path / "b.3mf").write_bytes(prepare_export(Shapes(solids=(block,)), "b.3mf").data)
    words = ["prusa-slicer", "--export-3mf", "--scale", "0.5", "-o", "a.3mf", "b.3mf"]
    subprocess.run(words, cwd=tmp_path, capture_output=True, check=True)
    (back,) = read_mesh_file(tmp_path / "a.3mf").shapes.solids
    assert volume(back.mesh) == pytest.approx(6000 / 8, rel=1e-5)
    np.testing.assert_allclose(np.ptp(back.mesh.bounds, axis=0), (5, 10, 15), rtol=1e-5)


@pytest.mark.parametrize("unit", ["mm", "cm", "m", "in"])
def test_our_own_files_come_back_as_they_left(tmp_path, unit):
    groups = (FaceGroup("lid", 4, (200, 10, 20)), FaceGroup("base", 8, (20, 30, 40)))
    case = replace(Solid(box((10.0, 20.0, 30.0)), "case"), groups=groups)
    knob = Solid(box((5.0, 5.0, 5.0), at=(50.0, 0.0, 0.0)), "knöb <&>", (1, 2, 3))
    data = prepare_export(Shapes(solids=(case, knob)), "a.3mf", handover=Handover(unit=unit)).data
    file = read(tmp_path, data)
    assert file.guess is None
    assert file.left_out == ()
    assert [(s.name, s.color) for s in file.shapes.solids] == [
        ("case", None), ("knöb <&>", (1, 2, 3)),
    ]  # fmt: skip
    for was, now in zip((case, knob), file.shapes.solids, strict=True):
        np.testing.assert_allclose(now.mesh.bounds, was.mesh.bounds, rtol=1e-6)
        assert volume(now.mesh) == pytest.approx(volume(was.mesh), rel=1e-5)
    areas = {g.color: g.count for g in file.shapes.solids[0].groups}
    assert areas == {(200, 10, 20): 4, (20, 30, 40): 8}


def test_painted_colours_come_back_at_their_places(tmp_path):
    mesh = box((10.0, 20.0, 30.0))
    colors = np.array([(k * 30, 255 - k * 30, 7, 255) for k in range(8)], np.uint8)
    painted = Solid(Mesh(mesh.vertices, mesh.faces, colors=colors), "a")
    data = prepare_export(Shapes(solids=(painted,)), "a.3mf").data
    (back,) = read(tmp_path, data).shapes.solids
    where = {
        tuple(p): tuple(c) for p, c in zip(mesh.vertices.tolist(), colors.tolist(), strict=True)
    }
    found = zip(back.mesh.vertices.tolist(), back.mesh.colors.tolist(), strict=True)
    assert all(where[tuple(place)] == tuple(color) for place, color in found)


def test_parts_of_parts_in_other_models_lie_at_their_places(tmp_path):
    """As Bambu Studio saves a project; the matrices as in section 3.3 of the core specification."""
    inner = model(f'<object id="7">{TETRA}</object>', "")
    top = model(
        '<object id="2" name="pair" type="model"><components>'
        '<component p:path="/3D/Objects/one.model" objectid="7" '
        'transform="1 0 0 0 1 0 0 0 1 5 0 0"/>'
        '<component p:path="/3D/Objects/one.model" objectid="7" '
        'transform="-2 0 0 0 2 0 0 0 2 0 0 0"/></components></object>'
        f'<object id="3" type="support">{TETRA}</object>',
        '<item objectid="2" transform="0 1 0 -1 0 0 0 0 1 10 20 30"/><item objectid="3"/>'
        '<item objectid="2" printable="0"/>',
        unit="centimeter",
    )
    rels = (
        '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
        '<Relationship Target="/3D/top.model" Id="r" '
        'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
    )
    data = package(**{"_rels/.rels": rels, "3D/top.model": top, "3D/Objects/one.model": inner})
    file = read(tmp_path, data)
    shifted, mirrored = file.shapes.solids
    # The inner model is in millimetres; a quarter turn takes x to y, then 100, 200, 300 mm.
    np.testing.assert_allclose(shifted.mesh.bounds, [(99, 250, 300), (100, 251, 301)])
    np.testing.assert_allclose(mirrored.mesh.bounds, [(98, 198, 300), (100, 200, 302)])
    assert volume(mirrored.mesh) == pytest.approx(8 / 6)  # right side out
    assert (shifted.name, mirrored.name) == ("pair", "pair")
    (said,) = file.left_out
    assert "a support or helper of a slicer" in said


def test_what_is_no_triangle_is_told(tmp_path):
    beams = (
        '<beamlattice radius="1" minlength="0"><beams><beam v1="0" v2="1"/></beams></beamlattice>'
    )
    bare = TETRA[: TETRA.index("<triangles>")]
    file = read(tmp_path, plain(
        f'<slicestack id="2"/><object id="1" slicestackid="2">{TETRA[:-7]}{beams}</mesh></object>',
        '<item objectid="1"/>',
    ))  # fmt: skip
    assert [said.split(": ")[1].split(" (")[0] for said in file.left_out] == [
        "a beam of a lattice", "the layers of a part",
    ]  # fmt: skip
    with pytest.raises(FormatError, match=r"no faces.*a beam of a lattice"):
        read(
            tmp_path, plain(f'<object id="1">{bare}{beams}</mesh></object>', '<item objectid="1"/>')
        )


def group(number):
    """An object of ten times the next one."""
    inner = f'<component objectid="{number + 1}"/>' * 10
    return f'<object id="{number}"><components>{inner}</components></object>'


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"PK\x03\x04 no zip", "damaged"),
        (b"solid x", "not a 3MF"),
        (package(**{"a.txt": "x"}), "no model"),
        (plain("", ""), "no faces"),
        (plain("", '<item objectid="4"/>'), "object 4"),
        (plain(f'<object id="1">{TETRA}</object>', '<item objectid="1" transform="1 2"/>'),
         "number"),
        (plain(f'<object id="1">{TETRA}</object>', "<item/>"), "objectid"),
        (plain(f'<object id="1">{TETRA}</object>', "", "parsec"), "parsec"),
        (plain('<object id="1">' + TETRA.replace('v3="3"', 'v3="9"') + "</object>",
               '<item objectid="1"/>'), "vertex"),
        (plain('<object id="1">' + TETRA.replace('x="1"', 'x="nan"') + "</object>",
               '<item objectid="1"/>'), "finite"),
        (plain('<m:colorgroup id="5"><m:color color="#12"/></m:colorgroup>', ""), "colour"),
        (plain('<m:colorgroup id="5"><m:color color="#112233"/></m:colorgroup>'
               f'<object id="1" pid="5" pindex="8">{TETRA}</object>', ""), "colour"),
        (plain('<object id="1"><components><component objectid="1"/></components></object>',
               '<item objectid="1"/>'), "part of itself"),
        (plain("".join(group(k) for k in range(9)) + f'<object id="9">{TETRA}</object>',
               '<item objectid="0"/>'), "parts"),
        (package(**{"3D/3dmodel.model": '<!DOCTYPE m [<!ENTITY a "b">]><model/>'}), "DOCTYPE"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused_with_a_sentence(tmp_path, data, said):
    with pytest.raises(FormatError, match=said):
        read(tmp_path, data)


def test_a_package_that_unpacks_to_far_more_is_refused(monkeypatch):
    monkeypatch.setattr(threemf_reader, "MAX_MODEL_BYTES", 1 << 20)
    bomb = package(**{"3D/3dmodel.model": b"<model>" + b" " * (2 << 20)})
    assert len(bomb) < 1 << 14
    with pytest.raises(FormatError, match="bytes in a model"):
        threemf_reader.read_shapes(bomb)


def test_a_mesh_and_its_components_under_one_number_are_one_object(tmp_path):
    """As trimesh writes a node that has a mesh and nodes below it."""
    mesh = f'<object id="2" name="arm">{TETRA}</object><object id="3" name="hand">{TETRA}</object>'
    below = (
        '<object id="2"><components><component objectid="3" transform="1 0 0 0 1 0 0 0 1 5 0 0"/>'
    )
    whole = f"{mesh}{below}</components></object>"
    solids = read(tmp_path, plain(whole, '<item objectid="2"/>')).shapes.solids
    assert [(one.name, float(one.mesh.vertices[:, 0].min())) for one in solids] == [
        ("arm", 0.0), ("hand", 5.0),
    ]  # fmt: skip
    twice = f'<object id="2">{TETRA}</object>' * 2
    with pytest.raises(FormatError, match="one number"):
        read(tmp_path, plain(twice, '<item objectid="2"/>'))
