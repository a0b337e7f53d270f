"""Parts of any name, and several of one name, in the hands of independent readers."""

from __future__ import annotations

import pytest

from bozzetto.exchange.export import export
from bozzetto.geometry import Curve, Mesh, Shapes, Solid

pytestmark = pytest.mark.interop

TETRA = Mesh(
    [[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
)
NAMES = [
    "quo\"te's <&> \\ / : * ?",
    "Ümläut ß é",
    "車の形",
    "\N{AUTOMOBILE}\N{FIRE} \U0001f9d1\u200d\U0001f3a8",
    "x" * 200,
    "",
    " ",
    "a\tb\x07c\u2028d",
    "\ud83d half",
    "..",
    "0",
]


@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
@pytest.mark.parametrize("ending", ["stl", "3mf", "glb", "obj", "ply"])
def test_solids_of_any_name_are_read_twice(tmp_path, ending, name):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / f"a.{ending}"
    moved = Mesh(TETRA.vertices + 20, TETRA.faces)
    export(Shapes(solids=(Solid(TETRA, name), Solid(moved, name))), path)
    mesh = trimesh.load_scene(path).to_geometry()
    scale = 1e9 if ending == "glb" else 1.0
    assert mesh.volume * scale == pytest.approx(72.0, rel=1e-4)


@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
def test_lib3mf_takes_any_name(tmp_path, name):
    lib3mf = pytest.importorskip("lib3mf")
    export(Shapes(solids=(Solid(TETRA, name), Solid(TETRA, name))), tmp_path / "a.3mf")
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(tmp_path / "a.3mf"))
    assert reader.GetWarningCount() == 0
    assert model.GetBuildItems().Count() == 2


@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
def test_layers_of_any_name_pass_the_audit(tmp_path, name):
    ezdxf = pytest.importorskip("ezdxf")
    lines = tuple(Curve(1, [0, 0, 1, 1], [[k, 0, 0], [9, k, 3]], name=name) for k in range(2))
    export(Shapes(curves=lines), tmp_path / "a.dxf")
    drawing = ezdxf.readfile(tmp_path / "a.dxf")
    assert not drawing.audit().errors
    assert len(drawing.modelspace()) == 2


@pytest.mark.parametrize("name", NAMES, ids=range(len(NAMES)))
def test_an_svg_of_any_name_is_well_formed(tmp_path, name):
    from xml.etree import ElementTree

    line = Curve(1, [0, 0, 1, 1], [[0, 0, 0], [9, 0, 3]], name=name)
    export(Shapes(curves=(line, line)), tmp_path / "a.svg")
    root = ElementTree.parse(tmp_path / "a.svg").getroot()
    assert len(root.findall(".//{http://www.w3.org/2000/svg}path")) == 2
