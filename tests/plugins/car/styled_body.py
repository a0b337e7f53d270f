"""Bodies, views and strokes for styling curves, and what holds of every such curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.geometry.patches.closest_points import foot_points
from bozzetto.geometry.patches.patch import Places, points_at
from bozzetto.ink import Stroke
from bozzetto.plugin import Ink
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import body_of
from bozzetto_car.state import CarState, StylingCurve
from bozzetto_car.styling.curve import curve_paths, project_stroke
from bozzetto_car.styling.curve_fit import Course, courses_on
from bozzetto_car.styling.surface_path import join_paths
from bozzetto_car.template.model import Template
from tests.plugins.car.traced_car import view

Array = NDArray[np.float64]

SHOULDER = [[450.0, 850.0, 640.0], [2300.0, 890.0, 600.0], [4000.0, 850.0, 730.0]]
"""Near the right side of a sedan, from wing to rear wing; mm."""

QUARTER: Camera = view(50.0, 15.0)
ABOVE: Camera = view(10.0, 45.0)


def curve_points(curve: StylingCurve, nets: Array, template: Template) -> Array:
    """The places of a styling curve on a body, (n, 3) mm, without those on patches it has not."""
    path = join_paths(curve_paths(curve, nets, template))
    return points_at(nets, path) if len(path) else np.zeros((0, 3))


def template_body(name: str = "sedan") -> Body:
    return body_of(CarState(template=name))  # type: ignore[arg-type]


def through(camera: Camera, points: ArrayLike, count: int = 240) -> Array:
    """A stroke that is a parabola through the pictures of three points in space."""
    a, b, c = camera.project(points)[0]
    s = np.linspace(0.0, 1.0, count)[:, None]
    return np.asarray(
        a * (1 - s) * (1 - 2 * s) + 4 * b * s * (1 - s) + c * s * (2 * s - 1), np.float64
    )


def styled(
    body: Body, camera: Camera = QUARTER, points: ArrayLike = SHOULDER, number: str = "n1"
) -> StylingCurve:
    """A curve along a stroke without tremor."""
    return StylingCurve(
        number, f"Line {number}", True, "", *project_stroke(body, through(camera, points), camera)
    )


def ink(points: ArrayLike, camera: Camera, tool: str = "pen") -> Ink:
    place = np.asarray(points, float)
    return Ink((Stroke(place[:, 0], place[:, 1], camera, tool=tool),))  # type: ignore[arg-type]


def whole(curve: StylingCurve, body: Body) -> Course:
    """The one line that a curve is on a body."""
    (course,) = courses_on(curve, body.nets, body.template)
    return course


def dense(curve: StylingCurve, body: Body, count: int = 1500) -> Array:
    """Many places of a curve in space, (count, 3) mm."""
    course = whole(curve, body)
    return points_at(body.nets, course.places(np.linspace(0.0, course.length, count)))


def assert_sound(curve: StylingCurve, body: Body) -> None:
    """One unbroken line on the surface that jumps nowhere."""
    assert len(curve_paths(curve, body.nets, body.template)) == 1
    assert np.isfinite(curve.places).all()
    assert curve.places.min() >= 0.0
    assert curve.places.max() <= 1.0
    points = dense(curve, body)
    assert off_surface(points[::15], body).max() < 1e-6
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.max() < 12.0 * steps.mean()


def off_surface(points: Array, body: Body) -> Array:
    """Distances of points from the body, mm."""
    feet: Places = foot_points(body.nets, points)
    return np.asarray(np.linalg.norm(points_at(body.nets, feet) - points, axis=1))
