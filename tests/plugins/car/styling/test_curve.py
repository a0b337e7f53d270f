"""Styling curves laid on the body, and what becomes of them when it changes."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from bozzetto.errors import UserError
from bozzetto.geometry import frozen
from bozzetto.geometry.patches.patch import extent
from bozzetto.geometry.patches.tessellation import shaded
from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.ink.curves.resample import arc_length
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto.scene.picking import cast_rays
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import body_of
from bozzetto_car.state import CarState, StylingCurve
from bozzetto_car.styling.curve import curve_paths, mirror_curve, project_stroke
from bozzetto_car.styling.stroke_line import smooth_line
from bozzetto_car.template.loader import PAPER_TEMPLATES
from bozzetto_car.template.network import with_positions
from tests.plugins.car.styled_body import (
    ABOVE,
    QUARTER,
    assert_sound,
    curve_points,
    dense,
    off_surface,
    styled,
    template_body,
    through,
)
from tests.plugins.car.traced_car import view

Array = NDArray[np.float64]

MIRROR = np.array([1.0, -1.0, 1.0])


def line_of(stroke: Array) -> Array:
    """The smoothed stroke, as a smooth line laid out in small steps, px."""
    line = smooth_line(stroke)
    along = arc_length(line)
    return np.asarray(CubicSpline(along, line)(np.linspace(0.0, along[-1], 4000)))


def kept(body: Body, stroke: Array, camera: Camera) -> StylingCurve:
    return StylingCurve("n1", "Line", True, "", *project_stroke(body, stroke, camera))


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("name", PAPER_TEMPLATES)
def test_it_is_seen_where_it_was_drawn_and_lies_on_the_body(name: str, kind: str) -> None:
    body, camera = template_body(name), view(50.0, 15.0, kind)  # type: ignore[arg-type]
    rng = np.random.default_rng(1)
    stroke = through(camera, [[450, 850, 640], [2300, 890, 600], [3800, 850, 730]])
    stroke += rng.normal(0.0, 0.4, stroke.shape)
    curve = kept(body, stroke, camera)
    assert_sound(curve, body)
    assert len(curve.patches) >= 3
    line = line_of(stroke)
    seen = camera.project(dense(curve, body))[0]
    assert distances_to_polyline(seen, line).max() < 0.05
    assert distances_to_polyline(line, seen).max() < 0.3  # the ends, too


def test_it_lies_on_the_side_that_is_seen() -> None:
    body = template_body()
    scene = Scene((Layer("body", (Shaded(shaded(body.patchwork, 24)),)),))
    for azimuth, elevation in ((50.0, 15.0), (-130.0, 30.0), (170.0, 60.0)):
        camera = view(azimuth, elevation)
        stroke = np.column_stack((np.linspace(150, 1050, 200), np.linspace(520, 300, 200)))
        points = dense(kept(body, stroke, camera), body, 300)
        hits = cast_rays(scene, camera.rays(camera.project(points)[0]))
        seen = np.linalg.norm(points - camera.eye, axis=1)
        # The mesh is up to some mm off, more along the line of sight.
        assert np.median(np.abs(hits.distance[hits.hit] - seen[hits.hit])) < 2.0
        assert (hits.distance > seen - 60.0).mean() > 0.99


def test_a_stroke_over_the_middle_is_one_curve() -> None:
    body = template_body()
    curve = styled(body, ABOVE, [[700, 600, 900], [500, 0, 900], [700, -600, 900]])
    assert set(curve.patches) == {"hood.R", "hood.L"}
    assert_sound(curve, body)
    points = dense(curve, body)
    assert points[0, 1] > 500.0
    assert points[-1, 1] < -500.0
    # Both places where it goes over the middle are one point of the middle.
    (path,) = curve_paths(curve, body.nets, body.template)
    (change,) = np.flatnonzero(np.diff(path.patches))
    pair = curve_points(curve, body.nets, body.template)[change : change + 2]
    assert np.abs(pair[0] - pair[1]).max() < 1e-9
    assert np.abs(pair[:, 1]).max() < 1e-9


def test_a_stroke_that_leads_behind_the_roof_is_cut_there() -> None:
    body = template_body()
    camera = view(90.0, 12.0)
    # Up the door, over the roof's outline, into the air.
    stroke = camera.project([[2300, 850, 500], [2300, 600, 1400], [2300, 0, 2200]])[0]
    stroke = np.concatenate([np.linspace(a, b, 80) for a, b in pairwise(stroke)])
    points = dense(kept(body, stroke, camera), body)
    assert_sound(kept(body, stroke, camera), body)
    assert points[:, 2].max() > 1300.0
    seen = camera.project(points)[0]
    assert seen[:, 1].min() > stroke[:, 1].min() + 20.0


def test_it_does_not_jump_from_the_roof_to_what_lies_behind() -> None:
    body = template_body()
    camera = view(-3.0, 8.0)  # from the front, low: the roof hides the tail
    a, b = camera.project([[800.0, 200.0, 950.0], [2600.0, 250.0, 1440.0]])[0]
    stroke = np.linspace(a, b, 200)
    curve = kept(body, stroke, camera)
    assert_sound(curve, body)
    steps = np.linalg.norm(np.diff(curve_points(curve, body.nets, body.template), axis=0), axis=1)
    assert steps.max() < 100.0


def test_a_short_gap_beside_the_outline_is_bridged_and_a_long_one_is_not() -> None:
    body, camera = template_body(), view(90.0, 0.0, "orthographic")
    # The foremost line of the roof, as the camera sees it.
    top = dense(
        styled(body, view(90.0, 60.0), [[1900, 300, 1430], [2500, 300, 1440], [3000, 300, 1430]]),
        body,
    )
    x = np.linspace(np.quantile(top[:, 0], 0.1), np.quantile(top[:, 0], 0.9), 200)
    columns = np.stack(
        [
            np.column_stack((np.full(300, at), np.zeros(300), np.linspace(1300, 1500, 300)))
            for at in x
        ]
    )
    scene = Scene((Layer("body", (Shaded(shaded(body.patchwork, 24)),)),))
    pixels = camera.project(columns.reshape(-1, 3))[0]
    hit = cast_rays(scene, camera.rays(pixels)).hit.reshape(200, 300)
    outline = np.array([camera.project(c[h][-1:])[0][0] for c, h in zip(columns, hit, strict=True)])
    inside, beside = outline + np.array([0.0, 6.0]), outline.copy()
    wave = 4.0 * np.sin(np.linspace(0.0, np.pi, 60)) ** 2
    beside[:, 1] += 2.0
    beside[70:130, 1] -= wave  # up to 2 px outside
    far = beside.copy()
    far[70:130, 1] -= 10.0 * wave
    lengths = [
        float(arc_length(camera.project(dense(kept(body, stroke, camera), body))[0])[-1])
        for stroke in (inside, beside, far)
    ]
    assert lengths[1] > 0.95 * lengths[0]
    assert lengths[2] < 0.5 * lengths[0]


# -- when the body changes -------------------------------------------------------------------------


def test_it_follows_the_body() -> None:
    body = template_body()
    curve = styled(body)
    rng = np.random.default_rng(5)
    network = body.network
    for _ in range(3):
        moves = rng.normal(0.0, 40.0, (len(network.positions), 3))
        moves[network.template.centre, 1] = 0.0
        moved = {
            int(node): network.positions[node] + moves[node]
            for node in rng.choice(network.template.pairs[:, 0], 6, replace=False)
        }
        other = replace(body, network=with_positions(network, moved))
        assert extent(other.nets).shape == (2, 3)
        assert_sound(curve, other)
        assert off_surface(dense(curve, other, 100), body).max() > 5.0  # it did move


def test_it_follows_other_dimensions() -> None:
    body = template_body()
    curve = styled(body)
    longer = body_of(CarState(length=5200.0, width=1900.0))
    assert_sound(curve, longer)
    points = curve_points(curve, longer.nets, longer.template)
    ratio = np.ptp(points[:, 0]) / np.ptp(curve_points(curve, body.nets, body.template)[:, 0])
    assert abs(ratio - 5200.0 / body.dimensions.given()["length"]) < 0.02


def test_patches_that_another_template_lacks_are_left_out() -> None:
    sedan, hatchback = template_body("sedan"), template_body("hatchback")
    curve = styled(
        sedan, view(130.0, 35.0), [[3300, 500, 1300], [3800, 500, 1100], [4300, 500, 1000]]
    )
    known = {patch.name for patch in hatchback.template.patches}
    assert not known.issuperset(curve.patches)
    points = curve_points(curve, hatchback.nets, hatchback.template)
    there = sum(curve.patches[number] in known for number in curve.on)
    assert len(points) == there
    alone = replace(curve, patches=tuple(f"none {k}" for k in range(len(curve.patches))))
    assert curve_points(alone, hatchback.nets, hatchback.template).shape == (0, 3)
    empty = StylingCurve("n2", "Empty")
    assert curve_points(empty, sedan.nets, sedan.template).shape == (0, 3)


@pytest.mark.parametrize("name", PAPER_TEMPLATES)
def test_the_mirror_image_is_the_mirror_image(name: str) -> None:
    body = template_body(name)
    for curve in (
        styled(body),
        styled(body, ABOVE, [[700, 600, 900], [500, 0, 900], [700, -600, 900]]),
        styled(body, view(150.0, 40.0), [[3300, 400, 1300], [3900, 300, 1100], [4300, 500, 1000]]),
    ):
        own = curve_points(curve, body.nets, body.template)
        image = curve_points(mirror_curve(curve), body.nets, body.template)
        assert np.abs(image - own * MIRROR).max() < 1e-9
        assert np.array_equal(
            mirror_curve(mirror_curve(curve)).places, frozen(curve.places, np.float64)
        )


# -- hostile ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "stroke",
    [
        [[600.0, 400.0]],
        [[5.0, 5.0], [300.0, 8.0]],
        [[1e8, 400.0], [2e8, 400.0]],
        [[np.inf, 400.0], [0.0, 400.0]],
    ],
)
def test_what_cannot_be_laid_is_refused_in_words(stroke: list[list[float]]) -> None:
    with pytest.raises(UserError):
        project_stroke(template_body(), stroke, QUARTER)


def test_from_inside_the_body_there_is_nothing_to_draw_on() -> None:
    camera = Camera(eye=(2300.0, 0.0, 900.0), target=(0.0, 0.0, 700.0))
    with pytest.raises(UserError, match="misses"):
        project_stroke(template_body(), [[300.0, 450.0], [900.0, 450.0]], camera)


@pytest.mark.parametrize("trials", [9, pytest.param(90, marks=pytest.mark.slow)])
def test_any_stroke_is_one_sound_curve_seen_where_it_was_drawn_or_refused(trials: int) -> None:
    rng = np.random.default_rng(8)
    bodies = [template_body(name) for name in PAPER_TEMPLATES]
    refused = 0
    for trial in range(trials):
        body = bodies[trial % 3]
        kind = ("perspective", "orthographic")[trial % 2]
        camera = view(rng.uniform(-180, 180), rng.uniform(-10, 80), kind)  # type: ignore[arg-type]
        ends = rng.uniform([150.0, 150.0], [1050.0, 650.0], (2, 2))
        bend = rng.normal(0.0, 60.0, 2)
        s = np.linspace(0.0, 1.0, 150)[:, None]
        stroke = (1 - s) * ends[0] + s * ends[1] + 4 * s * (1 - s) * bend
        try:
            curve = kept(body, stroke, camera)
        except UserError:
            refused += 1
            continue
        assert_sound(curve, body)
        seen = camera.project(dense(curve, body))[0]
        assert distances_to_polyline(seen, line_of(stroke)).max() < 0.2
    assert refused < 0.4 * trials
