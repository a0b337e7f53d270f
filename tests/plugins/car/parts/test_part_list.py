"""View and files show the same car: its parts, their looks, and the colour of the object."""

import json
import re
import struct
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document import Model
from bozzetto.exchange.export import prepare_export
from bozzetto.geometry import Placement, brep_mesh
from bozzetto.scene import LIGHT, SHOWN_FINISHES, Scene, Shaded, cast_rays, render
from bozzetto.view import Camera, Rays
from bozzetto.workbench.placed import scene_in_world, shapes_in_world
from bozzetto_car.body.build import body_of
from bozzetto_car.export import shapes_of
from bozzetto_car.parts.part_list import added_parts, wheel_parts
from bozzetto_car.state import CarState
from bozzetto_car.template.loader import TEMPLATES
from bozzetto_car.view.scene import look_layers, scene_of
from tests.plugins.car.marked_car import marked

BLUE = (30, 60, 160)

KINDS = {
    "surfaces": {},
    "complete": {"complete": True, "mirrors": True},
    "on tyres": {"complete": True, "tyre": "205/55 R16"},
    "without wheels": {"complete": True, "wheels": False},
    "wheels alone": {"body": False},
}


@pytest.fixture(params=KINDS, scope="module")
def car(request):
    state = replace(marked(3), **KINDS[request.param])
    body = body_of(state)
    return state, body, shapes_of(state, body)


def surfaces(state, body):
    return [i for _, i in Scene(tuple(look_layers(state, body))).items() if isinstance(i, Shaded)]


def looks_in(shapes):
    """Name, colour, finish and material of all faces and patches that are handed over."""
    for part in shapes.breps:
        for face in part.faces:
            yield face.name, face.color or part.color, face.finish, face.material
    for work in shapes.patchworks:
        for name, look in zip(work.patch_names, work.patch_looks, strict=True):
            yield name, look.color or work.color, look.finish, look.material


def test_view_and_files_have_the_same_looks(car):
    """Beds, gaps, wells and floor of a closed body are inside and not seen."""
    state, body, shapes = car
    shown = {("clay" if i.color == "clay" else i.color, i.finish) for i in surfaces(state, body)}
    inner = {"Wheel well", "Bed", "Gap", "Floor"}
    told = {
        (color or "clay", SHOWN_FINISHES[finish][0])
        for name, color, finish, _ in looks_in(shapes)
        if name not in inner
    }
    assert shown == told


def test_every_part_is_where_it_is_handed_over():
    """Wheels are seen outside the panels, panes on the body; nothing is seen elsewhere."""
    state = replace(marked(3), **KINDS["complete"])
    body = body_of(state)
    for part in (*added_parts(state, body), *wheel_parts(state, body)):
        exact = part.exact()
        seen, told = part.mesh().bounds, brep_mesh(exact, 2.0).bounds
        assert exact.name == part.name
        assert np.abs((seen - told)[:, [0, 2]]).max() < 45.0
        assert np.abs(seen.mean(axis=0) - told.mean(axis=0)).max() < 150.0


def test_names_of_parts_are_those_of_the_files(car):
    state, body, shapes = car
    parts = [*added_parts(state, body), *wheel_parts(state, body)]
    names = [part.name for part in shapes.breps if part.name != "Body"]
    assert [part.name for part in parts] == names
    assert len({*names}) == len(names)


@pytest.mark.parametrize("complete", [False, True])
def test_the_colour_of_the_object_is_its_paint_in_view_and_files(complete):
    state = replace(marked(3), complete=complete, mirrors=True)
    body = body_of(state)
    model = Model("m1", "Car", "bozzetto.car", state=state, color=BLUE)
    world = shapes_in_world(shapes_of(state, body), model)
    painted = {color for _, color, _, material in looks_in(world) if material == "Paint"}
    assert painted == {BLUE}
    seen = scene_in_world(scene_of(state, body), model)
    items = [item for _, item in seen.items() if isinstance(item, Shaded)]
    assert {item.color for item in items if item.finish == "gloss"} >= {BLUE}
    assert "clay" not in {item.color for item in items}
    step = prepare_export(world, "car.step").data.decode()
    shades = re.findall(r"COLOUR_RGB\('',([\d.E-]+),([\d.E-]+),([\d.E-]+)\)", step)
    away = np.abs(np.array(shades, float) - np.array(BLUE) / 255.0).max(axis=1)
    assert away.min() < 1e-6


def test_the_colour_of_the_object_is_its_paint_for_a_renderer():
    state = marked(3)
    model = Model("m1", "Car", "bozzetto.car", state=state, color=BLUE)
    shapes = replace(shapes_of(state, body_of(state)), breps=())
    data = prepare_export(shapes_in_world(shapes, model), "car.glb").data
    (length,) = struct.unpack("<I", data[12:16])
    file = json.loads(data[20 : 20 + length])
    (paint,) = [one for one in file["materials"] if one["name"] == "Paint"]
    linear = [((c / 255 + 0.055) / 1.055) ** 2.4 for c in BLUE]
    told = paint["pbrMetallicRoughness"]["baseColorFactor"][:3]
    assert told == pytest.approx(linear, abs=2e-3)


def test_two_cars_of_two_colours_are_told_apart():
    state = replace(marked(3), complete=True)
    body = body_of(state)
    scene, red = scene_of(state, body), (170, 30, 30)
    shift = Placement(offset=(0.0, 3000.0, 0.0))
    one = Model("m1", "One", "bozzetto.car", state=state, color=BLUE)
    other = Model("m2", "Two", "bozzetto.car", state=state, color=red, placement=shift)
    for model, wrong in ((one, red), (other, BLUE)):
        items = [i for _, i in scene_in_world(scene, model).items() if isinstance(i, Shaded)]
        colors = {item.color for item in items}
        assert model.color in colors
        assert not {wrong, "clay"} & colors


def test_what_is_seen_is_hit():
    """A ray from outside meets the very part: the wheel, the pane, the mirror, the lip."""
    state = replace(marked(3), complete=True, mirrors=True)
    body = body_of(state)
    scene = scene_of(state, body)
    for part in (*added_parts(state, body), *wheel_parts(state, body)):
        mesh = part.mesh()
        a, b, c = mesh.vertices[mesh.faces].astype(float).transpose(1, 0, 2)
        normals = np.cross(b - a, c - a)
        best = int(np.argmax(np.linalg.norm(normals, axis=1)))
        normal = normals[best] / np.linalg.norm(normals[best])
        place = (a + b + c)[best] / 3.0
        hits = cast_rays(scene, Rays((place + 20.0 * normal)[None], -normal[None]))
        assert np.linalg.norm(hits.points[0] - place) < 0.1, part.name


def test_windows_are_glass_in_the_view_and_let_it_through():
    """Behind the side window of the surfaces is the other one, and not the body's colour."""
    state = replace(marked(3), network=False, wheels=False)
    body = body_of(state)
    glass = [i for i in surfaces(state, body) if i.opacity < 1.0]
    assert [i.opacity for i in glass] == [SHOWN_FINISHES["glass"][1]]
    wanted = {n for n, p in enumerate(body.template.patches) if p.glass}
    corners = body.nets[sorted(wanted)][:, [0, 0, 3, 3], [0, 3, 0, 3]].reshape(-1, 3)
    found = glass[0].mesh.vertices.astype(float)
    away = np.linalg.norm(corners[:, None] - found, axis=2).min(axis=1)
    assert away.max() < 1e-2
    (pane,) = [n for n, p in enumerate(body.template.patches) if p.name == "glass_front.R"]
    middle = body.nets[pane].reshape(-1, 3).mean(axis=0)
    at = middle + np.array((0.0, 6000.0, 0.0))
    camera = Camera("orthographic", tuple(at), tuple(middle), height=2000.0, viewport=(200, 200))
    with_glass = render(Scene(tuple(look_layers(state, body))), camera, LIGHT, size=(200, 200))
    clay = replace(body.template, patches=tuple(
        replace(patch, glass=False) for patch in body.template.patches))  # fmt: skip
    bare = replace(body, network=replace(body.network, template=clay))
    without = render(Scene(tuple(look_layers(state, bare))), camera, LIGHT, size=(200, 200))
    one, other = (picture[100, 100, :3].astype(int) for picture in (with_glass, without))
    assert np.abs(one - other).max() > 20


@pytest.mark.parametrize("name", TEMPLATES)
def test_over_a_sketch_the_body_is_one_thin_mesh(name):
    """A frame there costs what it did: every mesh that is seen through is drawn twice."""
    state = CarState(template=name, shading="draft", complete=True, mirrors=True)
    (item,) = surfaces(state, body_of(state))
    assert item.opacity < 1.0
    assert item.finish == "clay"
