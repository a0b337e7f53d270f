"""What is seen of a car leaves as parts with names and materials, the same in every format."""

import json
import os
import re
import shutil
import struct
import subprocess
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.exchange.export import prepare_export
from bozzetto.exchange.handover import Handover
from bozzetto.geometry import brep_mesh, meshed
from bozzetto.geometry.patches import foot_points, points_at
from bozzetto_car.body.build import body_of
from bozzetto_car.export import shapes_of
from bozzetto_car.parts.body_lines import body_lines
from bozzetto_car.parts.closed_body import closed_body
from bozzetto_car.parts.wheel_arches import cut_panels
from bozzetto_car.parts.windows import CLEARANCE, SET_IN, THICKNESS, inserts
from bozzetto_car.state import CarState
from bozzetto_car.template.loader import TEMPLATES
from tests.plugins.car.marked_car import marked

WHEELS = {f"{part} {axle} {side}" for part in ("Tyre", "Rim") for axle in ("front", "rear")
          for side in ("left", "right")}  # fmt: skip

LEAST_GAP = 0.3
"""Beside a pane where its window is pointed, mm: the clearance is a share of the mean size."""


def volume(mesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    return float((a * np.cross(b, c)).sum() / 6.0)


@pytest.fixture(scope="module")
def whole():
    """A complete car with mirrors: its shapes."""
    state = replace(marked(3), complete=True, mirrors=True)
    return shapes_of(state, body_of(state))


@pytest.fixture(scope="module")
def sheets():
    """The surfaces of a car, and its wheels."""
    state = marked(3)
    return shapes_of(state, body_of(state))


def glb(shapes, **wishes):
    data = prepare_export(shapes, "car.glb", handover=Handover(**wishes)).data
    (length,) = struct.unpack("<I", data[12:16])
    return json.loads(data[20 : 20 + length])


def threemf(shapes, tmp_path, **wishes):
    path = tmp_path / "car.3mf"
    path.write_bytes(prepare_export(shapes, path, handover=Handover(**wishes)).data)
    return path, zipfile.ZipFile(path).read("3D/3dmodel.model").decode()


def test_parts_have_the_same_names_in_all_formats(whole, tmp_path):
    names = [part.name for part in whole.breps]
    assert len(set(names)) == len(names)
    assert {*names} > {"Body", "Glass windscreen", "Glass front left", "Mirror right", *WHEELS}
    assert {*names} > {"Headlamp left", "Headlamp right", "Grille", "Arch lip front left"}
    drawn = [node["name"] for node in glb(whole)["nodes"] if "mesh" in node]
    assert drawn == names
    _, model = threemf(whole, tmp_path)
    assert re.findall(r'<object id="\d+" type="model" name="([^"]*)"', model) == names
    made = prepare_export(whole, "car.obj")
    told = re.findall(r"^o (.*)$", made.data.decode(), re.M)
    assert told == [name.replace(" ", "_") for name in names]
    step = prepare_export(whole, "car.step").data.decode()
    assert {*re.findall(r"(?:MANIFOLD_SOLID_BREP|BREP_WITH_VOIDS)\('([^']*)'", step)} == {*names}


def test_materials_are_those_of_a_car_in_all_formats(whole, sheets):
    for shapes in (whole, sheets):
        told = {face.material for part in shapes.breps for face in part.faces}
        told |= {look.material for work in shapes.patchworks for look in work.patch_looks}
        assert told >= {"Paint", "Glass", "Rubber", "Chrome"}
        file = glb(shapes)
        assert {one["name"] for one in file["materials"]} == told
        assert len(file["materials"]) == len(told)
        glass = next(one for one in file["materials"] if one["name"] == "Glass")
        assert glass["alphaMode"] == "BLEND"
        made = prepare_export(shapes, "car.obj")
        library = dict(made.beside)["car.mtl"].decode()
        assert re.findall(r"^newmtl (.*)$", library, re.M) == list(
            dict.fromkeys(re.findall(r"^usemtl (.*)$", made.data.decode(), re.M))
        )
        words = re.findall(r"^newmtl (.*)$", library, re.M)
        assert {word.replace("_", " ") for word in words} == told


def test_colours_of_parts_are_in_3mf_and_step(whole, tmp_path):
    _, model = threemf(whole, tmp_path)
    step = prepare_export(whole, "car.step").data.decode()
    for color in {face.color for part in whole.breps for face in part.faces} - {None}:
        assert "#{:02X}{:02X}{:02X}FF".format(*color) in model
        red, green, blue = (value / 255 for value in color)
        shades = re.findall(r"COLOUR_RGB\('',([\d.E-]+),([\d.E-]+),([\d.E-]+)\)", step)
        rows = np.array(shades, float)
        assert np.abs(rows - (red, green, blue)).max(axis=1).min() < 1e-6


def test_wheels_leave_whatever_the_switch(sheets):
    assert {part.name for part in sheets.breps} == WHEELS
    state = replace(marked(3), body=False)
    alone = shapes_of(state, body_of(state))
    assert {part.name for part in alone.breps} == WHEELS
    assert not alone.patchworks


def test_surfaces_are_what_they_were_and_windows_of_glass(sheets):
    state = replace(marked(3), wheels=False)
    body = body_of(state)
    (work,) = shapes_of(state, body).patchworks
    assert not shapes_of(state, body).breps
    for name in ("nets", "edges", "sides", "name", "patch_names", "color"):
        np.testing.assert_array_equal(getattr(work, name), getattr(body.patchwork, name))
    glass = {
        name
        for name, look in zip(work.patch_names, work.patch_looks, strict=True)
        if look.finish == "glass"
    }
    assert glass == {patch.name for patch in body.template.patches if patch.glass}
    paint = {look.color for look in work.patch_looks if look.material == "Paint"}
    assert paint == {None}, "a person's colour of the object counts"
    assert meshed(sheets).surfaces[0].groups


def test_volume_and_bounds_are_the_same_taken_apart(whole):
    whole_meshes = list(meshed(whole).meshes())
    apart = prepare_export(whole, "car.obj", handover=Handover(separate_parts=True)).data.decode()
    places = np.array([line.split()[1:4] for line in apart.splitlines() if line[:2] == "v "], float)
    rows = [line.split()[1:] for line in apart.splitlines() if line[:2] == "f "]
    faces = np.array([[int(word.partition("/")[0]) - 1 for word in row] for row in rows])
    a, b, c = np.moveaxis(places[faces], 1, 0)
    found = float((a * np.cross(b, c)).sum() / 6.0)
    wanted = sum(volume(part.mesh) for part in whole_meshes)
    assert found == pytest.approx(wanted, rel=1e-5)
    bounds = np.array([part.mesh.bounds for part in whole_meshes])
    reach = bounds[:, 1, 0].max() - bounds[:, 0, 0].min()
    np.testing.assert_allclose(np.ptp(places, axis=0)[0], reach, atol=0.01)


def test_panes_are_objects_of_their_own_in_3mf_taken_apart(sheets, tmp_path):
    _, model = threemf(sheets, tmp_path, separate_parts=True)
    names = re.findall(r'<object id="\d+" type="model" name="([^"]*)"', model)
    assert {"windscreen.R", "glass_front.L", "hood.R", *WHEELS} <= {*names}


@pytest.mark.parametrize("name", TEMPLATES)
def test_what_stands_in_openings_is_solid(name):
    car = body_of(CarState(template=name))
    made = [part.exact() for part in inserts(car.network, car.nets)]
    assert len({part.name for part in made}) == len(made) >= 8
    for part in made:
        assert part.is_closed
        assert len(part.pieces) == 1
        assert volume(brep_mesh(part, 1.0)) > 0.0


def test_what_stands_in_openings_is_free_of_the_body():
    from manifold3d import Manifold, Mesh

    car = body_of(CarState())

    def solid(part):
        mesh = brep_mesh(part, 0.5)
        made = Manifold(Mesh(np.array(mesh.vertices), np.array(mesh.faces, np.uint32)))
        assert made.num_tri()
        return made

    body = solid(closed_body(car.network, car.nets))
    for part in inserts(car.network, car.nets):
        own = solid(part.exact())
        assert (own ^ body).volume() < 1e-3 * own.volume()
        assert LEAST_GAP < own.min_gap(body, 10.0 * CLEARANCE) < CLEARANCE


@pytest.mark.parametrize("name", ["sedan", "van"])
def test_panes_lie_below_the_body_by_the_depth_of_the_gap(name):
    car = body_of(CarState(template=name))
    for part in (one.exact() for one in inserts(car.network, car.nets)):
        if not part.name.startswith("Glass"):
            continue
        at = np.random.default_rng(3).uniform(0.2, 0.8, (20, 2))
        for face, deep in ((part.faces[0], SET_IN), (part.faces[1], SET_IN + THICKNESS)):
            places = face.surface.value(*at.T)
            feet = foot_points(car.nets, places)
            away = np.linalg.norm(points_at(car.nets, feet) - places, axis=1)
            assert (0.75 * deep < away).all()
            assert (away < 1.02 * deep).all()


@pytest.mark.parametrize("name", TEMPLATES)
def test_sill_and_bumper_lines_lie_on_the_surface_between_the_arches(name):
    car = body_of(CarState(template=name))
    lines = list(body_lines(car.network, car.nets, cut_panels(car.network, car.nets)))
    words = {words for words, _ in lines}
    kinds = ("Sill line", "Bumper line front", "Bumper line rear")
    assert words == {f"{kind} {side}" for side in ("left", "right") for kind in kinds}
    axles = car.network.positions[car.template.wheels.ravel()]
    front, rear = sorted({float(x) for x in axles[:, 0].round(6)})
    share = np.linspace(0.0, 1.0, 9)[:, None]
    for told, (a, b, c, d) in lines:
        places = ((1 - share) ** 3 * a + 3 * share * (1 - share) ** 2 * b
                  + 3 * share**2 * (1 - share) * c + share**3 * d)  # fmt: skip
        away = np.linalg.norm(points_at(car.nets, foot_points(car.nets, places)) - places, axis=1)
        assert away.max() < 1e-6
        assert (places[:, 1] < 1e-9).all() or (places[:, 1] > -1e-9).all()
        for axle in axles:
            assert np.linalg.norm((places - axle)[:, ::2], axis=1).min() > 1.049 * axle[2]
        middle = places[4, 0]
        where = "front" if middle < front else "rear" if middle > rear else "sill"
        assert where in told.lower()


def test_lines_of_neighbouring_panels_meet():
    car = body_of(CarState())
    ends = [points[[0, 3]] for name, points in body_lines(car.network, car.nets, {})
            if name == "Sill line right"]  # fmt: skip
    places = np.concatenate(ends)
    met = np.linalg.norm(places[:, None] - places, axis=2) + 1e9 * np.eye(len(places))
    assert (met.min(axis=1) < 1e-9).sum() == 2 * (len(ends) - 1)


def test_a_thousand_times_smaller_it_has_the_same_parts(whole):
    small = prepare_export(whole, "car.glb", handover=Handover(scale=1e-3))
    names = [part.name for part in whole.breps]
    assert [part.name for part in small.parts.breps] == names
    sizes = [np.ptp(p.mesh.vertices, axis=0).max() for p in meshed(whole).meshes()]
    told = [np.ptp(p.mesh.vertices, axis=0).max() for p in meshed(small.parts).meshes()]
    np.testing.assert_allclose(told, np.array(sizes) * 1e-3, rtol=1e-3)


@pytest.mark.interop
def test_a_slicer_reads_every_part_as_a_sound_object(whole, tmp_path):
    slicer = shutil.which("prusa-slicer")
    if slicer is None:
        pytest.skip("there is no PrusaSlicer")
    path, _ = threemf(whole, tmp_path, scale=0.02)
    told = subprocess.run([slicer, "--info", str(path)], capture_output=True, text=True,
                          check=True, env=os.environ | {"LC_ALL": "C"}).stdout  # fmt: skip
    assert len(re.findall(r"^size_x", told, re.M)) == len(whole.breps)
    assert told.count("manifold = yes") == len(whole.breps)
    assert "open_edges" not in told


READ = """
import sys
from OCP.STEPControl import STEPControl_Reader
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_SOLID
from OCP.TopExp import TopExp_Explorer
reader = STEPControl_Reader()
reader.ReadFile(sys.argv[1])
reader.TransferRoots()
found, explorer = [], TopExp_Explorer(reader.OneShape(), TopAbs_SOLID)
while explorer.More():
    made = GProp_GProps()
    BRepGProp.VolumeProperties_s(explorer.Current(), made)
    found.append((BRepCheck_Analyzer(explorer.Current()).IsValid(), made.Mass()))
    explorer.Next()
print(all(valid for valid, _ in found), len(found), sum(size for _, size in found))
"""


@pytest.mark.interop
def test_open_cascade_finds_valid_solids_of_the_same_volume(whole, tmp_path):
    python = os.environ.get("BOZZETTO_CAD_READERS")
    if not python:
        pytest.skip("BOZZETTO_CAD_READERS names no Python with the readers")
    path = tmp_path / "car.step"
    path.write_bytes(prepare_export(whole, path).data)
    told = subprocess.run([python, "-c", READ, str(path)], capture_output=True, text=True,
                          check=True).stdout.split()[-3:]  # fmt: skip
    assert told[0] == "True"
    assert int(told[1]) == sum(len(part.pieces) for part in whole.breps)
    meshes = sum(volume(part.mesh) for part in meshed(whole).meshes())
    assert float(told[2]) == pytest.approx(meshes, rel=2e-3)
