"""A hand that marks a sketch of a known car, as the window would let it."""

from __future__ import annotations

from functools import cache

import numpy as np

from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag, Tap
from bozzetto.view import Camera
from bozzetto_car.body.build import body_of
from bozzetto_car.marking.next_mark import asked_of
from bozzetto_car.state import CarState, Sketch
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from bozzetto_car.tools.mark_points import MarkPoints
from bozzetto_car.view.view_advice import view_after
from tests.plugins.car.sketched import PICTURE, looking

CANVAS = (987.0, 727.0)
TOOL = MarkPoints()
CONTEXT = Context()


def view_of(azimuth: float, elevation: float = 12.0, away: float = 8.0) -> Camera:
    """A camera of the sedan as it stands; azimuth 0 looks at the nose, -90 at the left side."""
    exact = ((azimuth, azimuth), (elevation, elevation), (away, away))
    return looking(bundled("sedan").positions, exact, np.random.default_rng(1))


def places_of(camera: Camera, template: Template | None = None) -> dict[str, tuple[float, float]]:
    """Where the picture of a camera shows each node."""
    template = template or bundled("sedan")
    seen = camera.project(template.positions)[0].tolist()
    return {name: (u, v) for name, (u, v) in zip(template.names, seen, strict=True)}


def blank() -> CarState:
    """A car with one sketch and no mark."""
    sketch = Sketch(id="one", name="Sketch", width=PICTURE[0], height=PICTURE[1])
    return CarState().with_node(sketch)


def through(state: CarState) -> Camera:
    """The view with the whole sketch in work in it."""
    return body_of(state).sketch_cameras[state.sketch.id].view(CANVAS)


def on_canvas(state: CarState, camera: Camera, pixel) -> tuple[float, float]:
    """Where a view shows a pixel of the sketch as it stands now."""
    sketch_camera = body_of(state).sketch_cameras[state.sketch.id]
    ((x, y),) = camera.project(sketch_camera.lifted([pixel]))[0].tolist()
    return x, y


def tapped(state: CarState, pixel, camera: Camera | None = None) -> CarState:
    """Touch a pixel of the sketch."""
    camera = camera or through(state)
    return TOOL.apply(state, Tap(*on_canvas(state, camera, pixel), camera), CONTEXT)


def stroke_on(state: CarState, camera: Camera, pixels, tool: str = "pen") -> Stroke:
    """A stroke over pixels of the sketch."""
    path = np.array([on_canvas(state, camera, pixel) for pixel in pixels])
    count = len(path)
    return Stroke(
        x=path[:, 0], y=path[:, 1], pressure=np.full(count, 0.5),
        t=0.01 * np.arange(count), camera=camera, tool=tool,
    )  # fmt: skip


def dragged(state: CarState, node: str, pixels) -> Drag:
    """The drag of a mark over pixels of the sketch."""
    return Drag(f"mark {node}", stroke_on(state, through(state), pixels))


@cache
def guided(camera: Camera, count: int) -> CarState:
    """Return a car that was marked as it asks, `count` times, on a sketch drawn by a camera.

    A person sees which wheel is the front one, and marks what is asked for on the near or far
    side as the sketch shows it, whatever the program calls the sides. Tests share the steps.
    """
    if not count:
        return blank()
    state = guided(camera, count - 1)
    near = "R" if camera.eye[1] > 0.0 else "L"
    node = asked_of(state, body_of(state).solved).node
    stem, _, side = node.partition(".")
    if side:
        meant = near if side == state.sketch.shows else {"L": "R", "R": "L"}[near]
        node = f"{stem}.{meant}"
    return tapped(state, places_of(camera)[node])


def followed(state: CarState, camera: Camera, *seen: CarState) -> Camera:
    """The view after it has gone along with the sketch, as the car was a moment ago."""
    for before in seen:
        found = view_after(before, state, camera)
        if found is not None:
            return found
    return camera
