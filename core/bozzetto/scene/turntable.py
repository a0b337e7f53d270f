"""Turntables: a scene that turns once around its upright axis, as a row of pictures.

One may begin with the sketch: the ink is drawn anew and the pictures below it stand still, then the
shapes take their place in the same view, and turn from there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import cross_product
from bozzetto.errors import UserError
from bozzetto.ink.curves.resample import arc_length
from bozzetto.ink.same_view import is_one_view, on_canvas
from bozzetto.scene.display_list import Image, Label, Layer, Lines, Points, Scene, Shaded
from bozzetto.scene.palette import LIGHT, Palette
from bozzetto.scene.renderer import Shading, render
from bozzetto.scene.snapshot import framed, without_handles
from bozzetto.scene.thickness_view import thickness_view
from bozzetto.view.camera import Camera
from bozzetto.view.navigation import fit_points
from bozzetto.view.page_views import MARGIN, framing
from bozzetto.view.rotations import triple

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.ink.stroke import Stroke

MOST_PICTURES: Final = 720
"""Pictures of one turn: two for each degree."""

RIM: Final = 32
"""Points on the rims of the cylinder that is framed."""

DRAWN: Final = 0.6
"""Share of the pictures before a turn in which the sketch is drawn; in the others it fades."""

WIDENED: Final = 0.25
"""Share of a turn after which all that turns is in the picture."""

STEEP: Final = float(np.sin(np.radians(60.0)))
"""Sine of the angle to the horizon from which a view is steep."""

LOW: Final = float(np.radians(25.0))
"""Angle to the horizon of the view in its place, radians."""

INK_WIDTH: Final = 2.0
"""Of the ink of a sketch, px."""


def turned_pictures(
    scene: Scene,
    count: int,
    *,
    view: str = "three-quarter",
    palette: Palette = LIGHT,
    size: tuple[int, int] = (1200, 900),
    shading: Shading = "clay",
) -> Iterator[NDArray[np.uint8]]:
    """Yield pictures of a scene from all around; all of it lies in each of them.

    Parameters
    ----------
    scene : Scene
        What turns, without its handles; its axis is upright, through the middle.
    count : int
        How many pictures: after so many more the first one would come again.
    view : str
        Name of the standard view of the first one.
    palette, size, shading
        As in `scene.picture`.

    Raises
    ------
    UserError
        If there are too many pictures, or the view has no such name.
    """
    _check_counts(count)
    scene = without_handles(scene)
    middle, around = _cylinder_around(scene)
    camera = framing(around, view, _page(size)) if len(around) else framed(scene, view, size)
    if shading == "thickness":
        scene = thickness_view(scene, palette).scene
    for number in range(count):
        seen = turned(camera, 2.0 * np.pi * number / count, middle)
        yield render(scene, seen, palette, size=size, shading=shading)


def pictures_from_sketch(
    scene: Scene,
    strokes: Sequence[Stroke],
    camera: Camera | None,
    count: int,
    lead: int,
    *,
    palette: Palette = LIGHT,
    size: tuple[int, int] = (1200, 900),
    shading: Shading = "clay",
) -> Iterator[NDArray[np.uint8]]:
    """Yield pictures of a sketch that is drawn and becomes a scene, which turns once around.

    Parameters
    ----------
    scene : Scene
        What turns; its images are the sketch's.
    strokes : sequence of Stroke
        In the order drawn. Those of other views than the one that is shown are left out.
    camera : Camera, optional
        The view of the sketch. Where nothing of it is there, the view in which most of it was drawn
        is shown.
    count : int
        How many pictures of the turn.
    lead : int
        How many before it, at least 2.
    palette, size, shading
        As in `scene.picture`.

    Raises
    ------
    UserError
        If there are too many pictures, or there is nothing of a sketch.
    """
    _check_counts(count, lead)
    scene = without_handles(scene)
    images = scene.of_kinds(Image)
    seen = _view_of_sketch(strokes, camera, images, _page(size))
    ink = [on_canvas(one, seen).points for one in strokes if is_one_view(one.camera, seen)]
    shapes = scene.of_kinds(Shaded, Lines, Points, Label)
    if shading == "thickness":
        shapes = thickness_view(shapes, palette).scene
    drawn = max(1, round(DRAWN * lead))
    sketch = np.zeros((size[1], size[0], 4), np.uint8)
    for number in range(drawn):
        so_far = images + Scene((_ink_layer(ink, seen, (number + 1) / drawn),))
        sketch = render(so_far, seen, palette, size=size)
        yield sketch
    shown = render(shapes, seen, palette, size=size, shading=shading)
    for number in range(lead - drawn):
        share = _eased((number + 1) / (lead - drawn + 1))
        yield np.round(sketch + share * (shown.astype(float) - sketch)).astype(np.uint8)
    middle, around = _cylinder_around(shapes)
    wide = fit_points(_lowered(seen), around, MARGIN) if len(around) else seen
    for number in range(count):
        between = _between(seen, wide, _eased(min(1.0, number / (WIDENED * count))))
        view = turned(between, 2.0 * np.pi * number / count, middle)
        yield render(shapes, view, palette, size=size, shading=shading)


def _check_counts(count: int, lead: int = 2) -> None:
    """Raise `UserError` if there are too many pictures of a turn, or before it, or too few."""
    if not 1 <= count <= MOST_PICTURES or not 2 <= lead <= MOST_PICTURES:
        raise UserError(f"A turntable has 1 to {MOST_PICTURES} pictures.")


def _page(size: tuple[int, int]) -> tuple[float, float]:
    return float(max(size[0], 1)), float(max(size[1], 1))


def _view_of_sketch(
    strokes: Sequence[Stroke], own: Camera | None, images: Scene, page: tuple[float, float]
) -> Camera:
    """Return the view of a sketch on a page.

    It is a person's own if something of the sketch is there, or the one of most strokes, or else
    that which faces its first picture.
    """
    placed = [item for _, item in images.items() if isinstance(item, Image)]
    if own is not None and (placed or any(is_one_view(one.camera, own) for one in strokes)):
        return own.with_viewport(*page)
    views: list[tuple[Camera, int]] = []
    for stroke in strokes:
        at = next((k for k, (one, _) in enumerate(views) if is_one_view(stroke.camera, one)), None)
        if at is None:
            views.append((stroke.camera, 1))
        else:
            views[at] = views[at][0], views[at][1] + 1
    if views:
        return max(views, key=lambda view: view[1])[0].with_viewport(*page)
    if placed:
        return _facing(placed[0], page)
    raise UserError(
        "There is no sketch to begin with: nothing of it was drawn with a pen, and no picture "
        "lies below. Make the turntable without it."
    )


def _facing(image: Image, page: tuple[float, float]) -> Camera:
    """Return a view that faces a picture and shows all of it."""
    corner, across, down = (np.array(row) for row in (image.corner, image.across, image.down))
    corners = corner + np.array([0.0 * across, across, down, across + down])
    middle = corners.mean(axis=0)
    camera = Camera(
        eye=triple(middle - cross_product(across, down)), target=triple(middle), up=triple(-down)
    )
    return fit_points(camera.with_viewport(*page), corners, MARGIN)


def _ink_layer(ink: Sequence[Array], camera: Camera, share: float) -> Layer:
    """Return a share of the ink, px, by its length, on a plane that faces a view."""
    left = share * sum(float(arc_length(points)[-1]) for points in ink)
    lines = []
    for points in ink:
        along = arc_length(points)
        count = int(np.searchsorted(along, left, side="right"))
        left -= float(along[-1])
        part = points[:count]
        if len(part) > 1:
            places = camera.on_plane(part, camera.target, camera.axes[2])
            lines.append(Lines(places.astype(np.float32), width=INK_WIDTH, hidden="show"))
    return Layer("sketch", tuple(lines))


def _eased(share: float) -> float:
    """Return a share of a way that begins and ends slowly."""
    return share * share * (3.0 - 2.0 * share)


def _lowered(camera: Camera) -> Camera:
    """Return a view from the side in place of a steep one: what turns there only spins."""
    ahead, up = camera.axes[2], camera.axes[1]
    if abs(ahead[2]) < STEEP:
        return camera
    heading = -np.sign(ahead[2]) * np.array((up[0], up[1], 0.0)) / np.hypot(up[0], up[1])
    way = np.cos(LOW) * heading + np.sin(LOW) * np.array((0.0, 0.0, np.sign(ahead[2])))
    eye = np.asarray(camera.target) - camera.distance * way
    return replace(camera, eye=triple(eye), up=(0.0, 0.0, 1.0))


def _between(one: Camera, other: Camera, share: float) -> Camera:
    """Return a camera on the way to another one of the same kind, by the shortest turn."""
    from scipy.spatial.transform import Rotation

    if share == 0.0:
        return one
    turn = Rotation.from_matrix(other.axes.T @ one.axes)
    axes = one.axes @ Rotation.from_rotvec(share * turn.as_rotvec()).as_matrix().T
    target = np.asarray(one.target) + share * np.subtract(other.target, one.target)
    distance = one.distance + share * (other.distance - one.distance)
    return replace(
        one,
        eye=triple(target - distance * axes[2]),
        target=triple(target),
        up=triple(axes[1]),
        height=one.height + share * (other.height - one.height),
    )


def turned(camera: Camera, angle: float, middle: Array) -> Camera:
    """Return a camera carried around the upright axis through a point; to the right, radians."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def carried(values: Array) -> tuple[float, float, float]:
        x, y, z = (float(value) for value in turn @ values)
        return x, y, z

    eye, target = (
        carried(np.asarray(one) - middle) + middle for one in (camera.eye, camera.target)
    )
    return replace(
        camera,
        eye=(float(eye[0]), float(eye[1]), float(eye[2])),
        target=(float(target[0]), float(target[1]), float(target[2])),
        up=carried(np.asarray(camera.up)),
    )


def _cylinder_around(scene: Scene) -> tuple[Array, Array]:
    """Return the middle of a scene, (3,), and points on the rims of the cylinder around it, (n, 3).

    The cylinder is upright; of an empty scene there are no points.
    """
    points = np.asarray(scene.points(), float)
    if not len(points):
        return np.zeros(3), points.reshape(0, 3)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    radius = float(np.hypot(*(points[:, :2] - middle[:2]).T).max())
    angles = np.linspace(0.0, 2.0 * np.pi, RIM, endpoint=False)
    ring = middle[:2] + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    rims = [
        np.column_stack([ring, np.full(RIM, z)]) for z in (points[:, 2].min(), points[:, 2].max())
    ]
    return middle, np.concatenate(rims)
