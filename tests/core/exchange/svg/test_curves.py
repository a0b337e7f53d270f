"""Curves as a camera sees them, in SVG: against SciPy's values and the camera's own projection."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from bozzetto.errors import UserError
from bozzetto.exchange.cad.cad_curves import checked_curves
from bozzetto.exchange.export import encode_shapes
from bozzetto.exchange.svg.curves import camera_matrix, picture
from bozzetto.exchange.svg.path_data import parse_path
from bozzetto.exchange.svg.reader import read_drawing
from bozzetto.geometry import Curve, Shapes
from bozzetto.view import Camera
from tests.core.exchange.curve_kit import BROKEN, CIRCLE, CURVES, domain, points, ring, values

SIDE = Camera(eye=(300, -400, 250), target=(0, 0, 0), viewport=(800, 600))
PARALLEL = Camera(kind="orthographic", eye=(300, -400, 250), height=300, viewport=(800, 600))
NEAR = 1e-3
"""What is asked of the pictures of curves, px."""
SIZED = [curve for curve in CURVES if curve.name not in ("five", "polyline")]
"""Neither smaller than a pixel, nor straight, for which there is a test of its own."""


def texts(camera, *curves):
    """The path data, one for every stretch of every curve."""
    data = encode_shapes(Shapes(curves=curves), "a.svg", camera=camera).decode()
    return re.findall(r'<path d="([^"]*)"', data)


def cubics(camera, *curves):
    """What is seen of curves before the page cuts it off."""
    if camera is None:
        return [parse_path(text)[0].cubics for text in texts(camera, *curves)]
    matrix = camera_matrix(camera)
    whole = checked_curves(Shapes(curves=curves))
    return [path.cubics for curve in whole for path in picture(curve, matrix, NEAR)]


def along(pieces, count=20):
    """Points on cubics, shape (n, 2)."""
    u = np.linspace(0, 1, count)[:, None]
    a, b, c, d = (pieces[:, None, k] for k in range(4))
    on = (1 - u) ** 3 * a + 3 * (1 - u) ** 2 * u * b + 3 * (1 - u) * u**2 * c + u**3 * d
    return on.reshape(-1, 2)


def seen(curve, camera, count=30_001):
    """What the camera says of points on the curve; NaN behind it."""
    begin, end = domain(curve)
    corners = curve.knots[(curve.knots > begin) & (curve.knots < end)]
    u = np.sort(np.append(np.linspace(begin, end, count), corners))
    return camera.project(values(curve, u))[0]


def away(places, line):
    """Distance of points from a line of many points, by the chords at the nearest ones.

    They are several: where the line crosses itself the nearest may be on the other branch.
    """
    line = line[np.isfinite(line).all(axis=1)]
    _, nearest = cKDTree(line).query(places, k=8)
    found = [to_chord(places, line, np.clip(at + k, 0, len(line) - 2))
             for at in nearest.T for k in (-1, 0)]  # fmt: skip
    return np.min(found, axis=0)


def to_chord(places, line, at):
    begin, side = line[at], line[at + 1] - line[at]
    square = np.maximum((side**2).sum(1), 1e-300)
    share = np.clip(((places - begin) * side).sum(1) / square, 0, 1)
    return np.linalg.norm(places - begin - share[:, None] * side, axis=1)


@pytest.mark.parametrize("curve", [CURVES[0], CURVES[2], CURVES[3], CURVES[5]],
                         ids=lambda c: c.name)  # fmt: skip
@pytest.mark.parametrize("seed", range(5))
def test_a_parallel_view_is_one_exact_cubic_a_span(curve, seed):
    eye = tuple(np.random.default_rng(seed).normal(size=3) * 400)
    camera = Camera(kind="orthographic", eye=eye, height=250.0, viewport=(1000, 700))
    (pieces,) = cubics(camera, curve)
    begin, end = domain(curve)
    places = np.unique(curve.knots[(curve.knots >= begin) & (curve.knots <= end)])
    assert len(pieces) == len(places) - 1
    share = np.linspace(0, 1, 11)
    for piece, a, b in zip(pieces, places[:-1], places[1:], strict=True):
        u = a + (b - a) * np.clip(share, 1e-12, 1 - 1e-12)
        expected = camera.project(values(curve, u))[0]
        np.testing.assert_allclose(along(piece[None], 11), expected, atol=1e-8)


@pytest.mark.parametrize("camera", [SIDE, PARALLEL, Camera(eye=(30, -150, 20), fov_y=90)])
def test_other_views_stray_by_less_than_a_thousandth_of_a_pixel(camera):
    for curve in SIZED:
        drawn = cubics(camera, curve)
        places = seen(curve, camera)
        near = (np.abs(places) < 3000).all(axis=1)
        on = np.vstack([along(pieces) for pieces in drawn])
        on = on[(np.abs(on) < 2000).all(axis=1)]
        assert away(on, places).max() <= 1e-3, curve.name
        # … and nothing is missing.
        fine = np.vstack([along(pieces, 1000) for pieces in drawn])
        assert away(places[near], fine).max() <= 1e-3, curve.name


def test_a_front_view_is_in_millimetres():
    (pieces,) = cubics(None, CIRCLE)
    np.testing.assert_allclose(np.hypot(*along(pieces).T), 10, atol=2e-5)
    tiny = Curve(CIRCLE.degree, CIRCLE.knots, CIRCLE.control_points * 1e-3, CIRCLE.weights)
    (pieces,) = cubics(None, tiny)
    np.testing.assert_allclose(np.hypot(*along(pieces).T), 0.01, atol=2e-8)


def test_polylines_stay_lines_in_every_view():
    corners = points(6, 30.0)
    line = Curve(1, np.r_[0, np.arange(6.0), 5], corners)
    for camera in (SIDE, PARALLEL):
        (text,) = texts(camera, line)
        assert set(re.findall("[A-Z]", text)) == {"M", "L"}
        (pieces,) = cubics(camera, line)
        ends = np.vstack((pieces[:1, 0], pieces[:, 3]))
        np.testing.assert_allclose(ends, camera.project(corners)[0], atol=1e-9)


def test_closed_curves_are_closed_paths():
    far = Camera(eye=(900, -1200, 750), target=(0, 0, 0), viewport=(800, 600))
    for camera in (far, replace(PARALLEL, height=900), None):
        for curve in (CIRCLE, ring(6, 3), ring(5, 2)):
            (text,) = texts(camera, curve)
            assert text.endswith("Z")
            (path,) = parse_path(text)
            assert path.closed
            np.testing.assert_array_equal(path.cubics[0, 0], path.cubics[-1, 3])


def test_lines_are_cut_where_they_pass_the_eye():
    camera = Camera(eye=(0, -100, 0), target=(0, 0, 0), viewport=(400, 300))
    corners = np.array([[0, 0, 0], [10, 20, 5], [0, -300, 0], [0, -300, 9], [5, 50, 0]])
    there, back = cubics(camera, Curve(1, np.r_[0, np.arange(5.0), 4], corners))
    ends = np.vstack((there[:1, 0], there[:, 3]))
    np.testing.assert_allclose(ends[:2], camera.project(corners[:2])[0], atol=1e-9)
    # The third point lies far out, on the picture of the line that goes on to the eye's plane.
    ahead = corners[1] + 0.3 * (corners[2] - corners[1])
    one, two = camera.project([corners[1], ahead])[0]
    across = np.array([one[1] - two[1], two[0] - one[0]]) / np.linalg.norm(two - one)
    assert abs((ends[2] - one) @ across) < 1e-6
    assert np.linalg.norm(ends[2] - one) > 10 * 300
    np.testing.assert_allclose(back[-1, 3], camera.project(corners[4:])[0][0], atol=1e-9)


def test_curves_are_cut_where_they_pass_the_eye():
    camera = Camera(eye=(0, -10, 0), target=(0, 0, 0), viewport=(400, 300))
    around = Curve(CIRCLE.degree, CIRCLE.knots, CIRCLE.control_points[:, [0, 2, 1]] * (1, 1.5, 1),
                   CIRCLE.weights, closed=True)  # fmt: skip
    stretches = cubics(camera, around)
    assert len(stretches) == 2  # the seam lies in what is seen
    u = np.linspace(*domain(around), 20_000)[:-1]
    places, depth = camera.project(values(around, u))
    shown = places[depth > 0.011]
    near = shown[(np.abs(shown) < 3000).all(axis=1)]
    drawn = np.vstack([along(s, 1000) for s in stretches])
    assert away(near, drawn).max() < 1e-3
    assert all(np.isfinite(s).all() for s in stretches)


def test_what_lies_behind_the_eye_alone_is_refused():
    camera = Camera(eye=(0, -10, 0), target=(0, 0, 0))
    for curve in (Curve(1, [0, 0, 1, 1], [[0, -20, 0], [5, -30, 0]]),
                  Curve(2, [0, 0, 0, 1, 1, 1], points(3, 5.0) - (0, 100, 0))):  # fmt: skip
        with pytest.raises(UserError, match="behind the eye"):
            texts(camera, curve)


def test_curves_seen_end_on_and_far_off_do_no_harm():
    end_on = Curve(3, [0] * 4 + [1] * 4, [[3, y, 4] for y in (0, 10, 20, 30)])
    far = Curve(3, [0] * 4 + [1] * 4, points(4) + 1e8)
    touching = Curve(2, [0, 0, 0, 1, 1, 1], [[-5, 0, 0], [0, -1000, 0], [5, 0, 0]])
    for camera in (None, SIDE, PARALLEL, Camera(eye=(0, -500, 0)), Camera(eye=(0, -500, 1e-9))):
        for curve in (end_on, far, touching, BROKEN):
            shapes = Shapes(curves=(curve, CIRCLE))
            data = encode_shapes(shapes, "a.svg", camera=camera)
            if camera is not None:  # what lies beyond the page is not written
                drawn = np.vstack([along(parse_path(text)[0].cubics) for text in
                                   re.findall(r'<path d="([^"]*)"', data.decode())])  # fmt: skip
                assert (drawn > -1e-3).all()
                assert (drawn < np.add(camera.viewport, 1e-3)).all()
            assert not re.search(rb"nan|inf", data)
            assert len(data) < 100_000
            assert read_drawing(data, "again").strokes


@pytest.mark.parametrize("height", [0.0, 35.0])
def test_curves_in_one_level_plane_are_a_plan_at_true_size(height):
    """A square that lies flat has its size in millimetres; a line up from it takes the front."""
    square = np.array([(0, 0), (30, 0), (30, 20), (0, 20), (0, 0)], float)
    flat = Curve(
        1, np.array([0, 0, 1, 2, 3, 4, 4.0]), np.column_stack((square, np.full(5, height)))
    )
    assert page_extent(flat) == pytest.approx((30.0, 20.0), rel=1e-9)
    up = Curve(1, np.array([0, 0, 1, 1.0]), np.array([(0, 0, height), (0, 0, height + 50.0)]))
    assert page_extent(flat, up) == pytest.approx((30.0, 50.0), rel=1e-9)


def page_extent(*curves):
    """Return width and height of what is written without a camera, mm."""
    numbers = re.findall(r"(-?[0-9.e-]+),(-?[0-9.e-]+)", " ".join(texts(None, *curves)))
    return np.ptp(np.array(numbers, float), axis=0)
