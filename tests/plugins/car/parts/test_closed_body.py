"""The complete car: a closed body with panes, arches and a floor, and wheels as solids."""

import os
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import brep_mesh, counted_mesh, meshed
from bozzetto.geometry.patches import Places, foot_points, points_at
from bozzetto_car.body.build import body_of
from bozzetto_car.body.fair_lines import fair_network
from bozzetto_car.body.wheels import SPOKES
from bozzetto_car.export import shapes_of
from bozzetto_car.parts.closed_body import closed_body
from bozzetto_car.parts.part_list import seen_parts
from bozzetto_car.parts.trim import shut_lines, trim_of
from bozzetto_car.parts.wheel_arches import RADII, cut_panels
from bozzetto_car.parts.wheels import wheels_of
from bozzetto_car.parts.windows import (
    CLEARANCE,
    LAID,
    THICKNESS,
    inserts,
    windows_of,
)
from bozzetto_car.state import CarState
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.loader import TEMPLATES
from tests.plugins.car.held_out import near_template
from tests.plugins.car.marked_car import marked
from tests.plugins.car.offsets import offset_by_open_cascade


def volume(mesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces].astype(float), 1, 0)
    return float((a * np.cross(b, c)).sum() / 6.0)


def on_one(at) -> Places:
    return Places(np.zeros(len(at), np.intp), at)


def body(name: str):
    return body_of(CarState(template=name))


@pytest.mark.parametrize("name", TEMPLATES)
def test_the_body_is_one_closed_shell_within_its_box(name):
    car = body(name)
    closed = closed_body(car.network, car.nets)
    assert closed.is_closed
    assert len(closed.pieces) == 1
    size = np.ptp(car.nets.reshape(-1, 3), axis=0)
    assert 0.4 < volume(brep_mesh(closed, 20.0)) / size.prod() < 0.9


@pytest.mark.parametrize("name", TEMPLATES)
def test_each_wheel_has_an_arch_at_one_distance_from_its_axle(name):
    car = body(name)
    panels = cut_panels(car.network, car.nets)
    centres = car.network.positions[car.template.wheels[:, 0]]
    found = set()
    for number, panel in panels.items():
        for arc in panel.arcs:
            at = arc.value(np.linspace(0.0, 1.0, 101))
            places = points_at(car.nets[[number]], on_one(at))
            away = np.linalg.norm(places[:, None, ::2] - centres[:, ::2], axis=2)
            wheel = int(away.mean(axis=0).argmin())
            found.add(wheel)
            share = away[:, wheel] / centres[wheel, 2]
            assert np.ptp(share) < 1e-3
            assert min(abs(share.mean() - radius) for radius in RADII) < 1e-3
    assert found == {0, 1}


def test_both_sides_are_alike():
    car = body("sedan")
    closed = closed_body(car.network, car.nets)
    places = closed.vertices[0]
    images = places * (1.0, -1.0, 1.0)
    away = np.linalg.norm(places[:, None] - images, axis=2).min(axis=1)
    assert away.max() < 1e-9


@pytest.mark.parametrize("name", TEMPLATES)
def test_beds_of_openings_lie_below_the_panes(name):
    car = body(name)
    beds = [f for f in closed_body(car.network, car.nets).faces if f.name == "Bed"]
    windows = windows_of(car.template, car.nets)
    assert len(beds) == 2 * len(windows)
    places = np.array([face.surface.value([0.5], [0.5])[0] for face in beds])
    places = np.concatenate([places, places * (1.0, -1.0, 1.0)])  # windows are those of one half
    feet = foot_points(car.nets, places)
    away = np.linalg.norm(points_at(car.nets, feet) - places, axis=1)
    for window in windows:
        low, high = np.transpose(window.box)
        within = (feet.parameters >= low).all(axis=1) & (feet.parameters <= high).all(axis=1)
        own = away[(feet.patches == window.patch) & within]
        depth = window.depth + THICKNESS + CLEARANCE
        assert len(own)
        assert (own < 1.01 * depth).all()
        assert (own > 0.7 * depth).all()


def test_wheels_are_solids_that_stand_on_the_ground():
    car = body("hatchback")
    wheels = [part.exact() for part in wheels_of(car.network, car.nets)]
    assert len(wheels) == 8
    assert all(part.is_closed for part in wheels)
    for tyre in (part for part in wheels if part.name in ("Tyre front right", "Tyre rear left")):
        mesh = brep_mesh(tyre, 2.0)
        assert volume(mesh) > 0.0
        assert abs(mesh.bounds[0, 2]) < 3.0


def test_every_spoke_and_disc_looks_outward():
    car = body("hatchback")
    wheels = wheels_of(car.network, car.nets)
    rim = next(part for part in wheels if part.name.startswith("Rim")).exact()
    mesh, counts = counted_mesh(rim, 2.0)
    bounds = np.cumsum([0, *counts])
    assert len(rim.pieces) == 1 + SPOKES
    for piece in rim.pieces:
        faces = np.concatenate([mesh.faces[bounds[k] : bounds[k + 1]] for k in piece])
        assert volume(replace(mesh, faces=faces)) > 0.0


def test_what_is_handed_over_tells_glass_paint_rubber_and_metal():
    state = replace(marked(3), complete=True)
    shapes = shapes_of(state, body_of(state))
    solids = meshed(replace(shapes, breps=shapes.breps[:3])).solids
    assert solids[0].name == "Body"
    assert len(solids) == 3
    lips = [part for part in shapes.breps if part.name.startswith("Arch lip")]
    inset = [part for part in shapes.breps if part.name.startswith(("Glass", "Head", "Tail"))]
    assert len(inset) == 10
    assert len(shapes.breps) == 9 + len(lips) + len(inset) + len({"Grille", "Intake"})
    assert len(lips) >= 4
    assert {group.finish for group in solids[0].groups} == {"gloss", "rubber", "matt"}
    assert {face.finish for part in shapes.breps for face in part.faces} >= {
        "gloss",
        "glass",
        "rubber",
        "metal",
    }
    glass = [part.name for part in shapes.breps if part.faces[0].finish == "glass"]
    assert len(glass) == len(set(glass)) == 6


def test_without_wheels_none_is_handed_over():
    state = replace(marked(3), complete=True, wheels=False)
    parts = shapes_of(state, body_of(state)).breps
    assert not [part for part in parts if part.name.startswith(("Tyre", "Rim"))]
    assert parts[0].is_closed


@pytest.mark.slow
def test_cars_that_no_template_knows_are_closed():
    cars = [*near_template(range(900, 904)), *near_template(range(911, 912))]
    for car in cars:
        network = fair_network(car.template, car.positions)
        assert closed_body(network, fair_nets(network)).is_closed


@pytest.mark.parametrize("name", TEMPLATES)
def test_panes_are_seen_just_outside_the_body_on_both_sides(name):
    car = body(name)
    looks = dict(map(reversed, seen_parts(inserts(car.network, car.nets))))
    assert {look.material for look in looks} == {
        "Glass", "Lamp glass", "Tail lamp glass", "Black plastic"
    }  # fmt: skip
    for mesh in looks.values():
        some = mesh.vertices[::40].astype(float)
        away = np.linalg.norm(points_at(car.nets, foot_points(car.nets, some)) - some, axis=1)
        assert np.abs(away - LAID).max() < 0.2
        low, high = mesh.bounds
        assert abs(low[1] + high[1]) < 1e-2


@pytest.mark.parametrize("name", TEMPLATES)
def test_lips_and_mirrors_are_solids_in_pairs(name):
    car = body(name)
    parts = [part.exact() for part in trim_of(car.network, car.nets, with_mirrors=True)]
    names = [part.name for part in parts]
    assert len(set(names)) == len(names)
    assert {"Mirror right", "Mirror left", "Arch lip front right", "Arch lip rear left"} <= {*names}
    for part in parts:
        mesh, counts = counted_mesh(part, 2.0)
        bounds = np.cumsum([0, *counts])
        assert part.is_closed
        for piece in part.pieces:
            faces = np.concatenate([mesh.faces[bounds[k] : bounds[k + 1]] for k in piece])
            assert volume(replace(mesh, faces=faces)) > 0.0


def test_shut_lines_lie_on_the_surface_and_end_at_the_arches():
    car = body("sedan")
    axles = car.network.positions[car.template.wheels.ravel()]
    lines = list(shut_lines(car.network, car.nets))
    for _, points in lines:
        at = points[[0, 3]]
        away = np.linalg.norm(points_at(car.nets, foot_points(car.nets, at)) - at, axis=1)
        assert away.max() < 1e-6
        for axle in axles:
            assert np.linalg.norm((at - axle)[:, [0, 2]], axis=1).min() > axle[2]
    assert {"Shut line S3-B3 right", "Shut line S3-B3 left"} <= {name for name, _ in lines}


@pytest.mark.interop
@pytest.mark.parametrize(
    "name",
    ["sedan", "hatchback", "minivan", "estate", "coupe", "limousine", "city_car", "suv", "pickup"],
)
def test_open_cascade_offsets_a_closed_body_by_two_millimetres(name):
    python = os.environ.get("BOZZETTO_CAD_READERS")
    if not python:
        pytest.skip("BOZZETTO_CAD_READERS names no Python with the readers")
    car = body(name)
    made = offset_by_open_cascade(closed_body(car.network, car.nets), python)
    assert made.is_sound, made
