"""Turning, moving and framing the view: pure functions from camera to camera."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.view.camera import Camera
from bozzetto.view.eye_fixed_motion import aimed, enlarged
from bozzetto.view.rotations import POLE, slerp, steepness, triple, upright

if TYPE_CHECKING:
    from bozzetto.arrays import Array

TURN_PER_PIXEL = 0.4
"""Degrees of orbit for a pixel of drag: 450 px turn the view half round."""

MIN_VISIBLE = 1e-5
"""Least world height on the canvas, mm: ten nanometres, far below any drawing."""

MAX_VISIBLE = 1e8
"""Greatest world height on the canvas, mm: a hundred kilometres."""

DEFAULT_VISIBLE = 200.0
"""World height on the canvas where there is nothing to frame, mm."""

FIT_MARGIN = 0.08
"""Part of the canvas left free on each side when framing."""

STANDOFF = 20.0
"""An orthographic eye stands at least this many canvas heights before its target, so that
what is seen lies in front of it and can be hit by rays; the picture does not change."""

END_ON = 1e-3
"""A box this thin for its depth is seen end on, like a point: the scale is kept."""

CLEARANCE = 0.01
"""Least way from the eye to the nearest point framed, as share of half their depth: a wide view
along the diagonal of a box would have its corner in the eye."""

NARROW = 0.5
"""Opening angle (degrees) that passes for orthographic while one kind turns into the other."""


def orbit(
    camera: Camera,
    dx: float,
    dy: float,
    pivot: ArrayLike | None = None,
    *,
    turntable: bool = True,
) -> Camera:
    """Turn the view by a drag of so many pixels; see `turn`."""
    return turn(camera, -TURN_PER_PIXEL * dx, TURN_PER_PIXEL * dy, pivot, turntable=turntable)


def turn(
    camera: Camera,
    azimuth: float,
    elevation: float,
    pivot: ArrayLike | None = None,
    *,
    turntable: bool = True,
) -> Camera:
    """Turn the view about a point, which stays where it is on the canvas.

    Parameters
    ----------
    camera : Camera
        The view before.
    azimuth, elevation : float
        Degrees by which the eye moves counter-clockwise (seen from above) and upwards.
    pivot : (3,) array_like, optional
        mm; the camera's target if absent.
    turntable : bool
        Keep Z upright and stop at the poles; otherwise turn freely about the axes of
        the sheet.

    Returns
    -------
    Camera
        At the same distance from the pivot and from its target.
    """
    old = camera.axes
    if turntable:
        around, above = steepness(camera)
        around += np.radians(azimuth)
        above = float(np.clip(above + np.radians(elevation), -np.pi / 2.0, np.pi / 2.0))
        new = upright(around, above)
        up = new[1] if np.cos(above) < POLE else np.array((0.0, 0.0, 1.0))
    else:
        new = _about(old, old[1], np.radians(azimuth))
        new = _about(new, new[0], -np.radians(elevation))
        up = new[1]
    fixed = np.asarray(camera.target if pivot is None else pivot, float)
    # The rigid motion that takes the old frame to the new one, about the pivot.
    motion = new.T @ old
    eye = fixed + motion @ (np.asarray(camera.eye) - fixed)
    target = eye + camera.distance * new[2]
    return replace(camera, eye=triple(eye), target=triple(target), up=triple(up))


def pan(
    camera: Camera,
    dx: float,
    dy: float,
    at: ArrayLike | None = None,
    *,
    eye_fixed: bool = False,
) -> Camera:
    """Move the view so that the world follows the pen.

    Parameters
    ----------
    camera : Camera
        The view before.
    dx, dy : float
        Drag in pixels, right and down.
    at : (3,) array_like, optional
        The point (mm) that follows the pen exactly; the target if absent.
    eye_fixed : bool
        In perspective, turn the camera about its eye instead of moving it; see `aimed`.
    """
    if eye_fixed and camera.kind == "perspective":
        seen, pixel = _from_eye(camera, camera.target if at is None else at)
        return aimed(camera, seen, (pixel[0] + dx, pixel[1] + dy))
    scale = 1.0 / camera.pixels_per_mm
    if at is not None and camera.kind == "perspective":
        depth = float(camera.view_space(at)[0, 2])
        if depth > 0:
            scale *= depth / camera.distance
    right, up, _ = camera.axes
    shift = scale * (-dx * right + dy * up)
    return replace(
        camera,
        eye=triple(np.asarray(camera.eye) + shift),
        target=triple(np.asarray(camera.target) + shift),
    )


def clamp_scale(camera: Camera, factor: float) -> float:
    """Return the factor by which the view may be enlarged without leaving the limits."""
    seen = camera.visible_height
    least, most = min(seen / MAX_VISIBLE, 1.0), max(seen / MIN_VISIBLE, 1.0)
    return float(np.clip(factor, least, most))


def zoom(
    camera: Camera,
    factor: float,
    pixel: tuple[float, float] | None = None,
    at: ArrayLike | None = None,
    *,
    eye_fixed: bool = False,
) -> Camera:
    """Enlarge the view about a place, which stays where it is on the canvas.

    Parameters
    ----------
    camera : Camera
        The view before.
    factor : float
        Above 1 comes closer, below 1 goes away; held within the limits of scale.
    pixel : (x, y), optional
        The place on the canvas; its centre if absent. It is taken at the depth of the
        target.
    at : (3,) array_like, optional
        A point of the world (mm), for example on a surface under the pen, instead.
    eye_fixed : bool
        In perspective, change the opening angle instead of moving the eye.

    Notes
    -----
    In perspective the eye is moved towards the place and the target with it: scaling the
    camera about a point leaves the directions from the eye to that point unchanged.
    """
    if not np.isfinite(factor) or factor <= 0:
        return camera
    forward = camera.axes[2]
    if at is not None:
        place = np.asarray(at, float)
    elif pixel is not None:
        place = camera.on_plane(pixel, camera.target, forward)[0]
    else:
        place = np.asarray(camera.target)
    if eye_fixed and camera.kind == "perspective":
        return aimed(enlarged(camera, factor), *_from_eye(camera, place))
    factor = clamp_scale(camera, factor)
    eye, target = np.asarray(camera.eye), np.asarray(camera.target)
    if camera.kind == "perspective":
        eye, target = place + (eye - place) / factor, place + (target - place) / factor
        return replace(camera, eye=triple(eye), target=triple(target))
    shift = (1.0 - 1.0 / factor) * (place - target)
    shift -= (shift @ forward) * forward
    return replace(
        camera,
        eye=triple(eye + shift),
        target=triple(target + shift),
        height=camera.height / factor,
    )


def fit(camera: Camera, bounds: ArrayLike, margin: float = FIT_MARGIN) -> Camera:
    """Frame a box, keeping the direction of the view.

    Parameters
    ----------
    camera : Camera
        The view before.
    bounds : (2, 3) array_like
        Corners of the box, mm. Not finite: the world's origin is framed at a default
        size. A single point: it is centred and the scale is kept.
    margin : float
        Part of the canvas, 0 … 0.49, left free on each side.

    Returns
    -------
    Camera
        Its target is the middle of the box; the box touches the margin on at least one
        side and crosses it on none.
    """
    box = np.asarray(bounds, float).reshape(2, 3)
    if not np.isfinite(box).all():
        half = DEFAULT_VISIBLE / 2.0
        return fit(camera, ((-half,) * 3, (half,) * 3), margin)
    middle = box.mean(0)
    corners = np.array([(x, y, z) for x in box[:, 0] for y in box[:, 1] for z in box[:, 2]])
    seen = (corners - middle) @ camera.axes.T
    share = 1.0 - 2.0 * min(max(margin, 0.0), 0.49)
    width, height = camera.viewport
    across = np.abs(seen[:, :2]) / (share * np.array((width / height, 1.0)))
    half_depth = float(np.abs(seen[:, 2]).max())
    if camera.kind == "orthographic":
        visible = _framing_height(camera, 2.0 * float(across.max()), half_depth)
        return _stood(replace(camera, height=visible), middle, half_depth + STANDOFF * visible)
    slope = np.tan(np.radians(camera.fov_y) / 2.0)
    distance = float((across.max(1) / slope - seen[:, 2]).max())
    distance = _framing_distance(camera, distance, across.max(), half_depth)
    limits = np.array((MIN_VISIBLE, MAX_VISIBLE)) / (2.0 * slope)
    return _stood(camera, middle, float(np.clip(distance, *limits)))


def _framing_height(camera: Camera, visible: float, half_depth: float) -> float:
    """Return what of the world an orthographic canvas shows from top to bottom (mm)."""
    if visible <= 2.0 * END_ON * half_depth:
        visible = max(visible, camera.height)
    return float(np.clip(visible, MIN_VISIBLE, MAX_VISIBLE))


def _framing_distance(
    camera: Camera, distance: float, half_width: float, half_depth: float
) -> float:
    """Return how far to stand from the middle of what is framed from a distance (mm)."""
    if half_width <= END_ON * half_depth:
        return half_depth + camera.distance
    return max(distance, (1.0 + CLEARANCE) * half_depth)


def fit_points(camera: Camera, points: ArrayLike, margin: float = FIT_MARGIN) -> Camera:
    """Frame points as tightly as the canvas allows, keeping the direction of the view.

    Parameters
    ----------
    camera : Camera
        The view before.
    points : (n, 3) array_like
        mm; those that are not finite are ignored. None at all: the world's origin is
        framed at a default size. A single one: it is centred and the scale is kept.
    margin : float
        Part of the canvas, 0 … 0.49, left free on each side.

    Returns
    -------
    Camera
        The points touch the margin on two opposite sides and cross it on none; between the
        other two sides they leave as much room on the one as on the other. Its target lies
        halfway between the nearest and the farthest.

    Notes
    -----
    Seen along the view's axes, a point (x, y, z) is right of the left margin while the eye
    satisfies e_x + s e_z ≤ x + s z, and left of the right one while e_x − s e_z ≥ x − s z,
    where s is the slope of the margin. The least right side and the greatest left side over
    all points bound e_z from above, and so do those of y: the smaller bound is the nearest
    place for the eye.
    """
    places = np.asarray(points, float).reshape(-1, 3)
    places = places[np.isfinite(places).all(1)]
    if not len(places):
        return fit(camera, np.full((2, 3), np.nan), margin)
    axes = camera.axes
    middle = 0.5 * (places.min(0) + places.max(0))
    seen = (places - middle) @ axes.T
    low, high = seen.min(0), seen.max(0)
    centre, half_depth = 0.5 * (low + high), 0.5 * float(high[2] - low[2])
    share = 1.0 - 2.0 * min(max(margin, 0.0), 0.49)
    width, height = camera.viewport
    room = share * np.array((width / height, 1.0))
    if camera.kind == "orthographic":
        visible = _framing_height(camera, float(((high - low)[:2] / room).max()), half_depth)
        flat = replace(camera, height=visible)
        return _stood(flat, middle + centre @ axes, half_depth + STANDOFF * visible)
    opening = np.tan(np.radians(camera.fov_y) / 2.0)
    slope = opening * room
    inner = (seen[:, :2] + slope * seen[:, 2:]).min(0)
    outer = (seen[:, :2] - slope * seen[:, 2:]).max(0)
    distance = float(centre[2] - ((inner - outer) / (2.0 * slope)).min())
    distance = _framing_distance(
        camera, distance, 0.5 * ((high - low)[:2] / room).max(), half_depth
    )
    limits = np.array((MIN_VISIBLE, MAX_VISIBLE)) / (2.0 * opening)
    target = middle + np.array((*(0.5 * (inner + outer)), centre[2])) @ axes
    return _stood(camera, target, float(np.clip(distance, *limits)))


def with_kind(camera: Camera, kind: Literal["perspective", "orthographic"]) -> Camera:
    """Return the same view as the other kind of camera; the scale at the target stays."""
    if kind == camera.kind:
        return camera
    visible = camera.visible_height
    if kind == "orthographic":
        distance = max(camera.distance, STANDOFF * visible)
    else:
        distance = visible / (2.0 * np.tan(np.radians(camera.fov_y) / 2.0))
    flat = replace(camera, kind=kind, height=visible)
    return _stood(flat, np.asarray(camera.target), distance)


def interpolate(begin: Camera, end: Camera, t: float) -> Camera:
    """Return the view on the way from one camera to another.

    Parameters
    ----------
    begin, end : Camera
        The views at 0 and at 1.
    t : float
        0 … 1; the motion eases in and out. Exactly `begin` at 0 and `end` at 1.

    Notes
    -----
    The frame turns on the shortest arc, the target moves on a line, the visible height
    changes by equal ratios. Between the two kinds of camera the opening angle narrows
    while the eye backs away, which tends to the orthographic view.
    """
    if t <= 0:
        return begin
    if t >= 1:
        return end
    s = t * t * (3.0 - 2.0 * t)
    frame = slerp(begin.axes, end.axes, s)
    target = (1 - s) * np.asarray(begin.target) + s * np.asarray(end.target)
    visible = begin.visible_height ** (1 - s) * end.visible_height**s
    width, height = ((1 - s) * a + s * b for a, b in zip(begin.viewport, end.viewport, strict=True))
    kind: Literal["perspective", "orthographic"] = "perspective"
    if begin.kind == end.kind == "orthographic":
        kind = "orthographic"
        fov = begin.fov_y
        distance = begin.distance ** (1 - s) * end.distance**s
    else:
        a, b = (NARROW if c.kind == "orthographic" else c.fov_y for c in (begin, end))
        fov = (1 - s) * a + s * b
        distance = visible / (2.0 * np.tan(np.radians(fov) / 2.0))
    return Camera(
        kind,
        triple(target - distance * frame[2]),
        triple(target),
        triple(frame[1]),
        fov,
        visible,
        (width, height),
    )


def _from_eye(camera: Camera, place: ArrayLike) -> tuple[Array, tuple[float, float]]:
    """Return the direction to a place and its pixel; those of the target if it is not seen."""
    (pixel,), (depth,) = camera.project(place)
    if not depth > 0.0 or not np.isfinite(pixel).all():
        (pixel,), _ = camera.project(camera.target)
        place = camera.target
    x, y = pixel.tolist()
    return np.asarray(place, float) - camera.eye, (x, y)


def _stood(camera: Camera, target: Array, distance: float) -> Camera:
    """Return the camera on its line of sight at a distance before a target."""
    eye = target - distance * camera.axes[2]
    return replace(camera, eye=triple(eye), target=triple(target))


def _about(frame: Array, axis: Array, angle: float) -> Array:
    """Return a frame turned about a unit axis (Rodrigues' formula)."""
    along = (frame @ axis)[:, None] * axis
    return np.asarray(
        along + np.cos(angle) * (frame - along) + np.sin(angle) * np.cross(axis, frame), np.float64
    )
