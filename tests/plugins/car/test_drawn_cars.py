"""The drawn cars of the gallery, and drawn cars by chance: from their marks back to the car."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from bozzetto.geometry.patches.coons import coons_nets
from bozzetto.geometry.patches.ray_intersections import ray_hits
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.view import Camera
from bozzetto_car.body.trace_edges import trace
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.marks_file import car_from_facts
from bozzetto_car.solver.bundle_adjustment import JointSolution, solve
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.solver.prior import Cost
from bozzetto_car.template.loader import PAPER_TEMPLATES, TEMPLATES, bundled
from bozzetto_car.template.network import Network, edge_called
from bozzetto_car.template.shape_constraints import Soundness
from tests.plugins.car.drawn_cars import (
    GALLERY,
    GALLERY_CARS,
    Drawn,
    drawn,
    in_docs,
    in_gallery,
    marks_in,
)
from tests.plugins.car.sketched import FRONT_QUARTER, REAR_QUARTER, SIDE, apart, rms
from tests.plugins.car.solved import assert_allowed
from tests.plugins.car.traced_car import drawn as seen_line
from tests.plugins.car.traced_car import symmetric

Array = NDArray[np.float64]

LARGEST = 300_000
"""Bytes of a picture in the repository."""


@pytest.fixture(params=GALLERY_CARS)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@cache
def solved(name: str) -> JointSolution:
    car = in_gallery(name)
    return solve(car.template, car.marked(), Cost.balanced(), Soundness.of(car.template))


# -- the files -------------------------------------------------------------------------------------


def test_there_is_a_car_for_every_template() -> None:
    assert set(GALLERY_CARS) == set(PAPER_TEMPLATES)
    assert {marks_in(name)["template"] for name in GALLERY_CARS} == set(PAPER_TEMPLATES)


def test_pictures_are_there_and_small(name: str) -> None:
    record = marks_in(name)
    assert record["image"] == record["views"][0]["image"]
    for view in record["views"]:
        path = GALLERY / view["image"]["file"]
        assert path.stat().st_size <= LARGEST
        with Image.open(path) as image:
            assert image.size == (view["image"]["width"], view["image"]["height"])


def test_files_tell_marks_and_strokes_and_nothing_of_the_truth(name: str) -> None:
    record, template = marks_in(name), bundled(name)
    assert set(record) == {"image", "template", "views", "dimensions", "styling"}
    assert set(record["dimensions"]) == {"WB"}
    for view in record["views"]:
        assert set(view) == {"kind", "image", "marks", "strokes"}
        assert view["kind"] == "auto"
        assert set(view["marks"]) <= set(template.names)
        assert set(view["strokes"]) <= set(template.edge_names)
        near = "R" if "WF.R" in view["marks"] else "L"
        wanted = (f"S3.{near}-S2.{near}", f"B3.{near}-B2.{near}", f"R2.{near}-R1.{near}")
        assert set(wanted) <= set(view["strokes"])


def test_the_marks_have_a_hands_error(name: str) -> None:
    car = in_gallery(name)
    for number, picture in enumerate(car.pictures):
        nodes = [car.template.node[node] for node in picture.marks]
        off = np.array(list(picture.marks.values())) - car.places(number)[nodes]
        # 2 px per coordinate; some fifty numbers scatter by a tenth of that.
        assert 1.4 < off.std() < 2.6
        assert np.abs(off.mean(axis=0)).max() < 1.5


def test_strokes_go_along_their_edges(name: str) -> None:
    car = in_gallery(name)
    for picture in car.pictures:
        for edge, line in picture.strokes.items():
            own = car.network.control_points[edge_called(car.template, edge)]
            path = seen_line(picture.camera, own, 300)
            assert distances_to_polyline(line, path).max() < 4.0
            assert distances_to_polyline(path[[0, -1]], line).max() < 5.0
            assert np.linalg.norm(np.diff(line, axis=0), axis=1).max() < 8.0


def test_marks_and_strokes_are_of_what_is_seen(name: str) -> None:
    """Against rays, where the drawings are made with a depth buffer."""
    car = in_gallery(name)
    sides = [patch.edges for patch in car.template.patches]
    nets = coons_nets(car.network.control_points, sides)
    wheels = set(car.template.wheels.ravel().tolist())
    for picture in car.pictures:
        nodes = [node for node in map(car.template.node.get, picture.marks) if node not in wheels]
        assert shown(nets, picture.camera, car.positions[nodes]).mean() > 0.9
        for edge in picture.strokes:
            own = car.network.control_points[edge_called(car.template, edge)]
            assert shown(nets, picture.camera, seen_line_in_space(own)[::2]).mean() > 0.8


def shown(nets: Array, camera: Camera, points: Array) -> NDArray[np.bool_]:
    """Which places no surface hides, or hardly, as on an outline, (k,)."""
    places, depth = camera.project(points)
    seen = np.zeros(len(points), bool)
    for beside in ((0.0, 0.0), (2.0, 0.0), (-2.0, 0.0), (0.0, 2.0), (0.0, -2.0)):
        left = np.flatnonzero(~seen)
        rays = camera.rays(places[left] + beside)
        _, hit = ray_hits(nets, *rays)
        seen[left] = depth[left] < hit * (rays.directions @ camera.axes[2]) + 40.0
    return seen


def seen_line_in_space(control_points: Array) -> Array:
    at = np.linspace(0.0, 1.0, 12)[:, None]
    a, b, c, d = control_points
    return (1 - at) ** 3 * a + 3 * (1 - at) ** 2 * at * b + 3 * (1 - at) * at**2 * c + at**3 * d


def test_styling_lines_lie_on_the_body(name: str) -> None:
    car = in_gallery(name)
    sides = [patch.edges for patch in car.template.patches]
    nets = coons_nets(car.network.control_points, sides)
    lines = marks_in(name)["styling"]
    names = [line["name"] for line in lines]
    assert len(set(names)) == len(names) >= 10
    for line in lines:
        camera = car.pictures[line["view"]].camera
        places, _ = ray_hits(nets, *camera.rays(line["points"]))
        assert np.mean(places.patches >= 0) > 0.98


# -- one view of each of the others ----------------------------------------------------------------

ONE_VIEW = ("coupe", "estate", "suv", "pickup", "van", "city_car", "limousine")
PHOTOS = ("coupe-photo", "estate-photo")

WORSE = 1.02
"""Ratio to the template's own error from which a car counts as worse than the template."""


def in_one_view(stem: str) -> tuple[dict[str, Any], Network, Camera]:
    """The file of a car with one picture, without its lines, and the truth."""
    record, designs = marks_in(stem), in_docs("car_designs")
    template = bundled(record["template"])
    if stem in PHOTOS:
        network, camera = designs.photographed(template)
    else:
        network, (camera,) = designs.truth(template)
    return record | {"styling": []}, network, camera


def test_every_template_has_a_car_and_two_have_a_photograph() -> None:
    told = {marks_in(stem)["template"] for stem in (*GALLERY_CARS, *ONE_VIEW)}
    assert told == set(TEMPLATES)
    assert {marks_in(stem)["template"] for stem in PHOTOS} < told
    for stem in (*ONE_VIEW, *PHOTOS):
        (view,) = marks_in(stem)["views"]
        path = GALLERY / view["image"]["file"]
        assert path.stat().st_size <= LARGEST
        with Image.open(path) as image:
            assert image.size == (view["image"]["width"], view["image"]["height"])


@pytest.mark.parametrize("stem", [*ONE_VIEW, *PHOTOS])
def test_marks_in_one_view_are_where_the_picture_shows_them(stem: str) -> None:
    record, network, camera = in_one_view(stem)
    (view,) = record["views"]
    nodes = [network.template.node[node] for node in view["marks"]]
    off = np.array(list(view["marks"].values())) - camera.project(network.positions[nodes])[0]
    assert len(nodes) >= 20
    assert 1.2 < off.std() < 2.8


def test_one_view_is_never_worse_than_the_template_and_mostly_far_better() -> None:
    """As shapes: where along the road a car stands is not told by a picture."""
    ratios = {}
    for stem in (*ONE_VIEW, *PHOTOS):
        record, network, _ = in_one_view(stem)
        for view in record["views"]:
            del view["strokes"]
        del record["dimensions"]
        solved = solve_car(car_from_facts(record, {}))
        own = rms(apart(network.template.positions, network.positions))
        ratios[stem] = rms(apart(solved.positions, network.positions)) / own
    assert max(ratios.values()) <= WORSE, ratios
    assert np.median(list(ratios.values())) <= 0.6, ratios
    assert ratios["pickup"] <= 0.6
    assert max(ratios[stem] for stem in PHOTOS) <= 0.75, ratios


# -- the designs -----------------------------------------------------------------------------------


def test_designs_are_sound_and_symmetric_and_no_template(name: str) -> None:
    car = in_gallery(name)
    template = car.template
    assert symmetric(car.network)
    slacks = Soundness.of(template).slacks(template.reduced(car.positions))
    assert slacks.min() > 0.0
    assert rms(apart(template.positions, car.positions)) > 60.0
    turned = Network.of(template, car.positions).tangents - car.network.tangents
    assert rms(np.linalg.norm(turned, axis=2)) > 100.0


@pytest.mark.slow
def test_the_same_files_come_out_every_time(tmp_path: Path) -> None:
    in_docs("draw_cars").main(["hatchback"], tmp_path)
    made = json.loads((tmp_path / "hatchback.json").read_text("utf-8"))
    assert made == marks_in("hatchback")
    old, new = (
        np.asarray(Image.open(folder / "hatchback.png").convert("RGB"), int)
        for folder in (GALLERY, tmp_path)
    )
    assert np.mean(np.abs(old - new).max(axis=2) > 8) < 0.001


# -- from the marks back to the car ----------------------------------------------------------------


def test_kinds_of_cameras_are_found(name: str) -> None:
    car = in_gallery(name)
    for view, picture in zip(car.marked(), car.pictures, strict=True):
        assert view.camera.kind == picture.camera.kind


def test_marks_of_the_gallery_are_met(name: str) -> None:
    joint = solved(name)
    assert_allowed(bundled(name), joint, Soundness.of(bundled(name)))
    for missed in joint.residuals:
        assert rms(missed) <= 1.6


def hidden_error(car: Drawn, joint: JointSolution, picture: int) -> float:
    """Root mean square distance of the nodes that are not marked from where they are, px."""
    view = joint.views[picture]
    hidden = np.setdiff1d(np.arange(len(car.positions)), view.nodes)
    found = view.camera.project(car.template.whole(joint.variables))[0]
    return rms(np.linalg.norm((found - car.places(picture))[hidden], axis=1))


@pytest.mark.parametrize(
    ("name", "most_px", "most_mm"),
    [("sedan", 5.0, 22.0), ("hatchback", 20.0, 55.0), ("minivan", 5.0, 15.0)],
)
def test_hidden_nodes_of_the_gallery_are_found(name: str, most_px: float, most_mm: float) -> None:
    """Two sketches tell the car; from one alone its far side is a guess."""
    car, joint = in_gallery(name), solved(name)
    for picture in range(len(car.pictures)):
        assert hidden_error(car, joint, picture) <= most_px
    error = rms(apart(car.template.whole(joint.variables), car.positions))
    assert error <= most_mm
    assert error < 0.6 * rms(apart(car.template.positions, car.positions))


@pytest.mark.parametrize("name", ["sedan", "minivan"])
def test_the_wheelbase_tells_the_size(name: str) -> None:
    """Locked inside the solve, it leaves the marks where they are, and sizes come out right."""
    car, template = in_gallery(name), bundled(name)
    locked = Dimensions(wheelbase=marks_in(name)["dimensions"]["WB"])
    cost, sound = Cost.balanced(), Soundness.of(template)
    joint = solve(template, car.marked(), cost, sound, locked=locked)
    for missed in joint.residuals:
        assert rms(missed) <= 1.6
    found = template.whole(joint.variables)
    assert np.allclose(np.ptp(found, axis=0), np.ptp(car.positions, axis=0), rtol=0.015)


def test_strokes_of_the_gallery_bend_the_edges_that_they_name(name: str) -> None:
    car, joint = in_gallery(name), solved(name)
    network = Network.of(car.template, car.template.whole(joint.variables))
    for picture, view in zip(car.pictures, joint.views, strict=True):
        for edge, line in picture.strokes.items():
            made = trace(network, line, view.camera, nodes_follow=True)
            network = made.network
            assert edge in {car.template.edge_names[max(e, ~e)] for e in made.run.edges}
            assert max(made.deviations) <= 1.5
    assert symmetric(network)
    # Neighbours that were traced later have turned some of them a little.
    off = [
        far
        for picture, view in zip(car.pictures, joint.views, strict=True)
        for far in left(network, view.camera, picture.strokes)
    ]
    assert np.median(off) <= 2.0
    assert np.percentile(off, 90) <= 4.5
    before = Network.of(car.template, car.template.whole(joint.variables))
    assert edges_apart(network, car.network) < edges_apart(before, car.network)


def edges_apart(network: Network, other: Network) -> float:
    """Root mean square distance of edges laid over each other by a similarity, mm."""
    one, two = (
        np.concatenate([seen_line_in_space(own) for own in each.control_points])
        for each in (network, other)
    )
    return rms(apart(one, two))


def left(network: Network, camera: Camera, strokes: dict[str, Array]) -> list[float]:
    """How far each edge is from its stroke, px."""
    return [
        float(
            distances_to_polyline(
                line,
                seen_line(camera, network.control_points[edge_called(network.template, edge)], 200),
            ).max()
        )
        for edge, line in strokes.items()
    ]


# -- drawn cars by chance --------------------------------------------------------------------------


@pytest.mark.parametrize("id", PAPER_TEMPLATES)
def test_a_car_by_chance_is_told_exactly_without_a_hand(id: str) -> None:
    car = drawn(bundled(id), 5, (FRONT_QUARTER, SIDE), hand=0.0)
    assert symmetric(car.network)
    for number, view in enumerate(car.marks_file()["views"]):
        nodes = [car.template.node[node] for node in view["marks"]]
        assert np.allclose(list(view["marks"].values()), car.places(number)[nodes], atol=1e-9)
        assert len(nodes) >= 15
        assert {"C3-C4", "C1-C2"} <= set(car.pictures[0].strokes)
    assert json.loads(json.dumps(car.marks_file())) == car.marks_file()


@pytest.mark.parametrize("id", PAPER_TEMPLATES)
def test_cars_by_chance_are_found_from_two_sketches(id: str) -> None:
    errors, starts = [], []
    for seed in range(4):
        car = drawn(bundled(id), seed, (FRONT_QUARTER, REAR_QUARTER))
        joint = solve(car.template, car.marked(), Cost.balanced(), Soundness.of(car.template))
        errors.append(rms(apart(car.template.whole(joint.variables), car.positions)))
        starts.append(rms(apart(car.template.positions, car.positions)))
    assert np.median(errors) <= 22.0
    assert np.median(errors) <= 0.4 * np.median(starts)
