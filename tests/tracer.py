"""A modeler of sketches: it takes pictures, has a place for each mark, and knows its view."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Shapes, Surface
from bozzetto.plugin import Modeler, Parameter, Tool, ViewAdvice
from bozzetto.scene import Handle, Image, Layer, Lines, Picture, Points, Scene
from bozzetto.view import Camera

MODELER = "tracer.sketches"

MANIFEST = f"""
id = "tracer.plugin"
title = "Tracer"
version = "1.0"
api = ">=2,<3"

[[modeler]]
id = "{MODELER}"
title = "Sketches"
icon = "icon.svg"
hint = "Drop a sketch."
facts = "template"
abilities = ["add_picture"]
order = 96
"""

STAND = Camera(eye=(-300.0, -700.0, 260.0), target=(0.0, 0.0, 60.0), fov_y=30.0)
"""Where every sketch was drawn from."""

DEPTH = 900.0
"""How far from the eye it hangs, mm."""

MOST = 3


@dataclass(frozen=True)
class Tracing:
    """Sketches, and marks as pixels of the newest one."""

    pictures: tuple[Picture, ...] = ()
    marks: tuple[tuple[float, float], ...] = ()
    length: Annotated[float, Parameter("Length", 0.0, 6000.0, unit="mm", zero="as drawn")] = 0.0
    template: str = ""


def sheet(picture):
    """Corner, across and down of where a picture hangs, and its camera."""
    camera = STAND.with_viewport(picture.width, picture.height)
    forward = camera.axes[2]
    place = np.asarray(camera.eye) + DEPTH * forward
    size = (picture.width, picture.height)
    at = camera.on_plane([(0, 0), (size[0], 0), (0, size[1])], place, forward)
    return at[0], at[1] - at[0], at[2] - at[0]


def pixel_at(picture, camera, x, y):
    """Which pixel of a picture is seen at a place of another view."""
    own = STAND.with_viewport(picture.width, picture.height)
    forward = own.axes[2]
    place = camera.on_plane([(x, y)], np.asarray(own.eye) + DEPTH * forward, forward)
    return own.project(place)[0][0]


class Mark(Tool[Tracing]):
    id, title, icon, gesture = "mark", "Mark", "", "drag"
    hint = "Touch a point of the sketch."
    aims = True

    def preview(self, state, gesture, context):
        return scene_of(self.apply(state, gesture, context))

    def tap(self, state, tap, context):
        return replace(state, marks=(*state.marks, mark_at(state, tap.camera, tap.x, tap.y)))

    def drag(self, state, drag, context):
        mark = mark_at(state, drag.camera, *drag.path.points[-1])
        if not (drag.handle.isdigit() and int(drag.handle) < len(state.marks)):
            raise UserError("There is no such mark. Take another.")
        marks = list(state.marks)
        marks[int(drag.handle)] = mark
        return replace(state, marks=tuple(marks))


def mark_at(state, camera, x, y):
    if not state.pictures:
        raise UserError("There is no sketch. Drop one first.")
    pixel = pixel_at(state.pictures[-1], camera, x, y)
    if not np.isfinite(pixel).all() or np.abs(pixel).max() > 1e6:
        raise UserError("This is not on the sketch. Touch it.")
    return float(pixel[0]), float(pixel[1])


def places_of(state):
    if not state.pictures or not state.marks:
        return np.zeros((0, 3))
    picture = state.pictures[-1]
    corner, across, down = sheet(picture)
    share = np.array(state.marks) / (picture.width, picture.height)
    return corner + share[:, :1] * across + share[:, 1:] * down


def scene_of(state):
    places = places_of(state)
    handles = tuple(Handle(str(k), tuple(map(float, p))) for k, p in enumerate(places))
    lines = (Lines(places.astype(np.float32), color="second", hidden="show"),)
    return Scene((Layer("marks", (*lines, *handles) if len(places) > 1 else handles),))


class Sketches(Modeler[Tracing, Tracing]):
    id, state_type = MODELER, Tracing

    def __init__(self) -> None:
        self.take = self._take
        self.pinned = True

    def create(self, context):
        pictures = tuple(context.pictures.values())[:MOST]
        return Tracing(pictures, template=str(context.facts.get("template", "")))

    def read_drawing(self, drawing, context, job):
        if not drawing.facts.get("template"):
            raise UserError("The file names no template. Write one.")
        return self.create(context)

    def tools(self):
        return (Mark(),)

    def add_picture(self, state, picture, context):
        return self.take(state, picture)

    def _take(self, state, picture):
        if len(state.pictures) == MOST:
            raise UserError("Three sketches are enough. Take one away first.")
        return replace(state, pictures=(*state.pictures, picture), marks=())

    def solve(self, state, job):
        return places_of(state)

    def scene(self, state, result):
        return scene_of(state)

    def shapes(self, state, result):
        if not state.pictures:
            return Shapes()
        corner, across, down = sheet(state.pictures[-1])
        vertices = np.array([corner, corner + down, corner + across]).astype(np.float32)
        return Shapes(surfaces=(Surface(Mesh(vertices, [[0, 1, 2]])),))

    def view_advice(self, state, camera, job):
        if not state.pictures:
            return ViewAdvice("good", "No sketch")
        picture = state.pictures[-1]
        image = Image(picture.pixels, *(tuple(map(float, v)) for v in sheet(picture)), 0.9)
        layers = (Layer("sketch", (image,)), Layer("cross", (Points(places_of(state)[:0]),)))
        if camera.eye == STAND.eye and camera.kind == "perspective":
            return ViewAdvice("good", "From where it was drawn", None, Scene(layers), self.pinned)
        better = STAND.with_viewport(*camera.viewport)
        return ViewAdvice("warn", "From elsewhere", better)

    def upgrade(self, state, version):
        return state


def drawn_car(width: int = 900, height: int = 600) -> np.ndarray:
    """A line drawing on paper, something like a car."""
    from PIL import Image as Picture_
    from PIL import ImageDraw

    page = Picture_.new("RGBA", (2 * width, 2 * height), (249, 246, 238, 255))
    pen = ImageDraw.Draw(page)
    body = [
        (0.08, 0.66),
        (0.1, 0.52),
        (0.28, 0.47),
        (0.4, 0.32),
        (0.66, 0.31),
        (0.82, 0.46),
        (0.93, 0.5),
        (0.94, 0.66),
    ]
    for shift in (0.0, 0.003, -0.002):
        line = [(2 * width * (x + shift), 2 * height * (y - shift)) for x, y in body]
        pen.line([*line, line[0]], fill=(52, 50, 60, 255), width=5, joint="curve")
    for x in (0.25, 0.76):
        cx, cy, r = 2 * width * x, 2 * height * 0.66, 2 * height * 0.11
        for k in (1.0, 0.62):
            pen.ellipse(
                (cx - k * r, cy - k * r, cx + k * r, cy + k * r), outline=(40, 40, 48, 255), width=6
            )
    return np.asarray(page.resize((width, height), Picture_.Resampling.LANCZOS))
