"""Edges fitted to strokes: what they follow, what stays, and the paper's cubic beside them."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.ink import arc_length, lift_curve
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.view import Camera
from bozzetto_car.body.foot_points import Sighting
from bozzetto_car.body.joint_fit import JointFit
from bozzetto_car.camera.rational_projection import camera_matrix
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import MIRROR
from bozzetto_car.template.network import Network, edge_called, with_positions, with_tangents
from tests.plugins.car.traced_car import curve, drawn, view

Array = NDArray[np.float64]
Kind = Literal["perspective", "orthographic"]

EDGE = np.array([[1200.0, 700, 900], [1600, 760, 960], [2100, 800, 950], [2500, 830, 930]])
KINDS: tuple[Kind, ...] = ("perspective", "orthographic")


def off(camera: Camera, points: Array, stroke: Array) -> float:
    """Largest distance between the picture of a cubic and a stroke, either way, px."""
    own = drawn(camera, points, 400)
    return float(
        max(distances_to_polyline(own, stroke).max(), distances_to_polyline(stroke, own).max())
    )


def standing(points: Array, name: str) -> Network:
    """A sedan in which one edge has these Bézier points."""
    network = Network.of(bundled("sedan"))
    edge = edge_called(network.template, name)
    start, end = network.template.edges[edge].tolist()
    network = with_positions(network, {start: points[0], end: points[3]})
    legs = 3.0 * (points[[1, 3]] - points[[0, 2]])
    return with_tangents(network, {(edge, end): legs[end] for end in (0, 1)})


def seen(stroke: Array, camera: Camera, edge: int, flip: Array) -> Sighting:
    """A stroke whose samples count alike, twenty in all."""
    matrices = np.repeat((camera_matrix(camera) * np.append(flip, 1.0))[None], 4, axis=0)
    return Sighting(edge, stroke, np.full(len(stroke), 20.0 / len(stroke)), matrices)


def fitted(
    points: Array,
    *strokes: Array,
    camera: Camera,
    name: str = "S3.R-S2.R",
    image: Array | None = None,
) -> Array:
    """The edge after strokes along it, and one along its image on the other side."""
    network = standing(points, name)
    edge = edge_called(network.template, name)
    assert np.allclose(network.control_points[edge], points)
    sightings = [seen(stroke, camera, edge, np.ones(3)) for stroke in strokes]
    sightings += [] if image is None else [seen(image, camera, edge, MIRROR)]
    found = JointFit(network, sightings, (), (), np.zeros((0, 0))).solved()
    made = network.control_points[edge].copy()
    if found is not None:
        made[1] = made[0] + found[1][0, 0] / 3.0
        made[2] = made[3] - found[1][0, 1] / 3.0
    return made


def paper_cubic(old: Array, stroke: Array, camera: Camera) -> Array:
    """The edge as Kara and Shimada trace it: through two points of the stroke, where the old edge
    has its thirds, lifted to the places on their rays nearest to it, and both ends."""
    along = arc_length(drawn(camera, old, 301))
    share = along[[100, 200]] / along[-1]
    length = arc_length(stroke)
    goals = [np.interp(share * length[-1], length, stroke[:, axis]) for axis in (0, 1)]
    first, last = lift_curve(curve(old, 4)[1:3], camera, np.column_stack(goals))
    return np.stack((
        old[0],
        (-5.0 * old[0] + 18.0 * first - 9.0 * last + 2.0 * old[3]) / 6.0,
        (2.0 * old[0] - 9.0 * first + 18.0 * last - 5.0 * old[3]) / 6.0,
        old[3],
    ))  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_the_paper_traces_two_points_of_the_stroke(kind: Kind) -> None:
    camera = view(60.0, 15.0, kind)
    aim = EDGE + np.array([[0, 0, 0], [0, 0, 120], [0, 0, 90], [0, 0, 0]])
    stroke = drawn(camera, aim, 300)
    traced = paper_cubic(EDGE, stroke, camera)
    assert np.array_equal(traced[[0, 3]], EDGE[[0, 3]])
    inner = camera.project(curve(traced, 4)[1:3])[0]
    assert distances_to_polyline(inner, stroke).max() < 1e-3
    # Each went the shortest way to its ray: at a right angle to it.
    for old, new in zip(curve(EDGE, 4)[1:3], curve(traced, 4)[1:3], strict=True):
        ray = camera.rays(camera.project(new[None])[0]).directions[0]
        assert abs((new - old) @ ray) < 1e-6 * np.linalg.norm(new - old) + 1e-9


@pytest.mark.parametrize("kind", KINDS)
def test_its_own_picture_changes_nothing(kind: Kind) -> None:
    for azimuth in (30.0, 75.0, 120.0):
        camera = view(azimuth, 12.0, kind)
        stroke = drawn(camera, EDGE, 70)
        for way in (stroke, stroke[::-1], stroke[20:50], stroke[::9]):
            made = fitted(EDGE, way, camera=camera)
            assert np.abs(made - EDGE).max() < 1e-6


@pytest.mark.parametrize("kind", KINDS)
def test_the_whole_edge_follows_and_does_so_better_than_the_paper(kind: Kind) -> None:
    rng = np.random.default_rng(2)
    ours, papers = [], []
    for _ in range(25):
        camera = view(rng.uniform(35, 145), rng.uniform(3, 30), kind)
        aim = EDGE.copy()
        aim[1:3] += rng.normal(0, 120, (2, 3))
        stroke = drawn(camera, aim, 150)
        start = paper_cubic(EDGE, stroke, camera)
        made = fitted(EDGE, stroke, camera=camera)
        ours.append(off(camera, made, stroke))
        papers.append(off(camera, start, stroke))
        assert np.array_equal(made[[0, 3]], EDGE[[0, 3]])
    assert max(ours) <= 2.0
    assert np.median(ours) < 0.5 * np.median(papers)


@pytest.mark.parametrize("kind", KINDS)
def test_what_the_view_does_not_see_stays(kind: Kind) -> None:
    camera = view(70.0, 10.0, kind)
    aim = EDGE + np.array([[0, 0, 0], [0, 0, 150], [0, 0, 100], [0, 0, 0]])
    made = fitted(EDGE, drawn(camera, aim), camera=camera)
    for old, new, node in zip(EDGE[1:3], made[1:3], EDGE[[0, 3]], strict=True):
        ray = camera.rays(camera.project(old[None])[0]).directions[0]
        tangent = (old - node) / np.linalg.norm(old - node)
        across = (new - old) - ((new - old) @ tangent) * tangent
        assert np.linalg.norm(across) > 50.0
        assert abs(across @ ray) < 1e-9 * np.linalg.norm(across) + 1e-9


@pytest.mark.parametrize("kind", KINDS)
def test_a_tremor_does_not_push_an_edge_off_its_line(kind: Kind) -> None:
    """The edge runs into the depth here, at 40 degrees to the rays; a pixel is 4 to 6 mm."""
    rng = np.random.default_rng(7)
    camera = view(40.0, 10.0, kind)
    at = np.linspace(0.0, np.pi, 80)[:, None]
    for _ in range(15):
        waves = np.cos(at * np.arange(4)) @ rng.normal(0, 1, (4, 2))
        stroke = drawn(camera, EDGE, 80) + 2.0 * waves / np.sqrt((waves**2).mean())
        made = fitted(EDGE, stroke, camera=camera)
        assert distances_to_polyline(curve(made), curve(EDGE, 400)).max() < 50.0


def test_a_plane_seen_edge_on_gives_no_depth() -> None:
    """From the front, a stroke cannot tell how far back a profile of the middle bulges."""
    edge = EDGE * [1.0, 0.0, 1.0]
    camera = view(1.0, 8.0)
    stroke = drawn(camera, edge) + np.array([3.0, 0.0])
    made = fitted(edge, stroke, camera=camera, name="C1-C2")
    assert np.abs(made - edge)[:, 1].max() == 0.0
    for old, new in zip(edge[1:3], made[1:3], strict=True):
        ray = camera.rays(camera.project(old[None])[0]).directions[0]
        assert abs((new - old) @ ray) < 0.05 * np.linalg.norm(new - old)


def test_handles_move_only_where_they_may() -> None:
    """An edge that crosses the middle smoothly leaves it at a right angle."""
    camera, arch = view(30.0, 25.0), EDGE.copy()
    arch[0] = (1150.0, 0.0, 950.0)
    arch[1] = (1150.0, 300.0, 950.0)
    aim = arch + np.array([[0, 0, 0], [80, 50, 150], [0, 40, 100], [0, 0, 0]])
    made = fitted(arch, drawn(camera, aim), camera=camera, name="C2-S2.R")
    assert np.array_equal(made[1, [0, 2]], arch[1, [0, 2]])
    assert made[1, 1] != arch[1, 1]
    assert (made[2] != arch[2]).all()


def test_two_sides_of_a_car_tell_the_depth() -> None:
    """An edge and its mirror image in one view are two views of one edge."""
    aim = EDGE.copy()
    aim[1:3] += [[60.0, -70.0, 80.0], [-40.0, 60.0, 50.0]]
    camera = view(20.0, 35.0)
    right, left = drawn(camera, aim), drawn(camera, aim * MIRROR)
    one = fitted(EDGE, right, camera=camera)
    both = fitted(EDGE, right, camera=camera, image=left)
    assert off(camera, both, right) < 1.0
    assert off(camera, both * MIRROR, left) < 1.0

    def missed(points: Array) -> float:
        return float(np.linalg.norm(curve(points) - curve(aim), axis=1).max())

    assert missed(both) < 0.5 * missed(one)


@pytest.mark.parametrize(
    "stroke",
    [
        np.array([[600.0, 400.0]]),
        np.array([[600.0, 400.0], [600.0, 400.0]]),
        np.array([[-1e6, 3e5], [1e6, -2e5]]),
        np.random.default_rng(3).uniform(0, 1200, (3000, 2)),
    ],
    ids=("point", "rest", "far", "scribble"),
)
def test_any_ink_gives_a_finite_edge(stroke: Array) -> None:
    for kind in KINDS:
        assert np.isfinite(fitted(EDGE, stroke, camera=view(60.0, 10.0, kind))).all()
    still = np.repeat(EDGE[:1], 4, axis=0)
    assert np.isfinite(fitted(still, stroke, camera=view(60.0, 10.0))).all()
