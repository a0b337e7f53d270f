"""The camera of a sketch as the template gives it: found, resumed, or why there is none.

The solve of camera and shape starts from it. Left and right of the car are easily exchanged, and
then no camera fits well; this module detects that, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.view.calibration import Resection, resect
from bozzetto_car.camera.marked_view import MarkedView
from bozzetto_car.camera.sketch_camera import SketchCamera, upright_camera
from bozzetto_car.solver.hyperparameters import evidence_of
from bozzetto_car.state import Sketch
from bozzetto_car.template.model import Template

FEWEST: Final = 6
"""Fewest marks from which the camera of a sketch can be found."""

EXCHANGED: Final = 7.0
"""Gain in probability with left and right exchanged, as a natural logarithm, that is beyond doubt.
A side view or an orthographic sketch cannot tell the sides."""

UNLIKE: Final = 0.85
"""Spread from which an exchange is tested at all: marks with left and right exchanged give a car
that is very unlike the template."""

PLAUSIBLE: Final = 1.25
"""Largest spread of a plausible car. Marks that give no plausible car on either side are wrong in
another way."""

NO_CAR: Final = 0.04
"""Distance by which marks are missed, rms, in diagonals of their box, from which they are those of
no car. Of 696 sketches of unseen cars with six and eight marks, steady, trembling by 15 px and
exaggerated, the worst has 0.03; of 231 with six marks, of which two or more are at the places of
other points, 96 in a hundred have more."""

NEAR_EYE: Final = 0.05
"""Depth of a node in front of the eye, in mean depths of the car, that no sketch shows."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A sketch with its camera.

    Attributes
    ----------
    sketch : Sketch
    stand : Stand
        Where it stands in space; upright beside the car while its camera is not known.
    resection : Resection or None
        The camera that sees the template at the marks; None where it cannot be found.
    missed : mapping of str to float
        By node: distance of its mark from where it is seen, px; without nodes behind the eye.
    left_out : mapping of str to float
        By node: distance of its mark from where the other marks expect it, px.
    disagreeing : tuple of str
        Nodes whose marks were set aside, the worst first.
    exchanged : bool
        Whether the marks fit a mirrored car: left and right are exchanged.
    problem : str
        Why the camera is not known, and what to do; "" if it is known.
    told : Sketch or None
        The sketch with the marks that the camera was found from, where strokes have sharpened
        those that a person has set.
    """

    sketch: Sketch
    sketch_camera: SketchCamera
    resection: Resection | None = None
    missed: Mapping[str, float] | None = None
    left_out: Mapping[str, float] | None = None
    disagreeing: tuple[str, ...] = ()
    exchanged: bool = False
    problem: str = ""
    told: Sketch | None = None

    @property
    def as_told(self) -> Placed:
        """The same with the marks that its camera was found from: where the next solve starts."""
        return self if self.told is None else replace(self, sketch=self.told, told=None)

    @property
    def is_known(self) -> bool:
        """Whether the camera is known."""
        return self.resection is not None

    @property
    def mean_miss(self) -> float | None:
        """Distance of the marks that count from where the car has them, rms, px."""
        px = [off for node, off in (self.missed or {}).items() if node not in self.disagreeing]
        return float(np.sqrt(np.mean(np.square(px)))) if px else None

    @property
    def misfit(self) -> float | None:
        """The same, if it is so great that some marks must be those of other points; else None."""
        places = np.array([(mark.u, mark.v) for mark in self.sketch.marks]).reshape(-1, 2)
        if self.mean_miss is None or not len(places):
            return None
        is_no_car = self.mean_miss > NO_CAR * float(np.hypot(*np.ptp(places, axis=0)))
        return self.mean_miss if is_no_car else None


def place_sketch(template: Template, sketch: Sketch, resumed: Placed | None = None) -> Placed:
    """Place a sketch by the camera that sees the template at its marks.

    Parameters
    ----------
    template : Template
        The template of the car.
    sketch : Sketch
        The sketch.
    resumed : Placed, optional
        The same sketch before one of its marks was dragged: where to start from.
    """
    nodes, places = counted_marks(Placed(sketch, upright_camera(sketch.size)), template)
    try:
        found = _camera_of(sketch, template, nodes, places, resumed)
    except UserError as problem:
        return Placed(sketch, upright_camera(sketch.size), problem=problem.message)
    unseen = nodes[_too_near(template, nodes, found)].tolist()
    aside = tuple(template.names[node] for node in unseen)
    sketch_camera = SketchCamera.behind(found.camera, found.shift, template.positions)
    placed = Placed(sketch, sketch_camera, found, disagreeing=aside)
    exchanged = _is_exchanged(placed, template) if resumed is None else resumed.exchanged
    return replace(placed, exchanged=exchanged)


def seen_as(template: Template, placed: Placed) -> MarkedView | None:
    """Return a sketch as one of a car like another template; None if no camera sees that so.

    The search begins at the camera that is known, and the kind of the camera stays.
    """
    sketch, known = placed.sketch, placed.resection
    assert known is not None
    nodes, places = counted_marks(placed, template)
    try:
        found = resect(
            template.positions[nodes], places, sketch.size, kind=known.camera.kind,
            cropped=sketch.cropped, before=replace(known, disagreeing=()),
        )  # fmt: skip
    except UserError:
        return None
    if _too_near(template, nodes, found).any():
        return None
    return MarkedView(found.camera, nodes, places, found.shift, sketch.cropped)


def _camera_of(
    sketch: Sketch,
    template: Template,
    nodes: Index,
    places: Array,
    resumed: Placed | None,
) -> Resection:
    """Find the camera that sees the template at the marks; keep the last if no mark has moved."""
    last = None if resumed is None else resumed.resection
    if last is not None and resumed is not None and marks_of(resumed.sketch) == marks_of(sketch):
        return last
    marked = {template.names[node] for node in nodes}
    further = {
        name: place
        for name, place in zip(template.names, template.positions, strict=True)
        if name not in marked and name not in sketch.skipped
    }
    return resect(
        template.positions[nodes], places, sketch.size, kind=sketch.kind,
        cropped=sketch.cropped, further=further, before=last,
    )  # fmt: skip


def _is_exchanged(placed: Placed, template: Template) -> bool:
    """Whether the marks are more probable as those of the other side."""
    view, sketch = view_of(placed, template), placed.sketch
    others = template.mirrored[view.nodes]
    right = evidence_of(template, view)
    if right.spread < UNLIKE or (others == view.nodes).all():
        return False
    try:
        found = resect(
            template.positions[others], view.marks, sketch.size, kind=sketch.kind,
            cropped=sketch.cropped,
        )  # fmt: skip
    except UserError:
        return False
    if _too_near(template, others, found).any():
        return False
    other = replace(view, camera=found.camera, shift=found.shift, nodes=others)
    left = evidence_of(template, other)
    return left.spread < PLAUSIBLE and left.total > right.total + EXCHANGED


def _too_near(template: Template, nodes: Index, found: Resection) -> Flags:
    """Which nodes (k,) a camera has so near its eye, or behind it, that it cannot show them."""
    depth = found.camera.view_space(template.positions)[:, 2]
    return np.asarray(depth[nodes] < NEAR_EYE * depth.mean())


def view_of(placed: Placed, template: Template) -> MarkedView:
    """Return a sketch with all of its marks and the camera that the template gives."""
    found = placed.resection
    assert found is not None
    nodes, marks = counted_marks(placed, template)
    return MarkedView(found.camera, nodes, marks, found.shift, placed.sketch.cropped)


def counted_marks(placed: Placed, template: Template) -> tuple[Index, Array]:
    """Return nodes (k,) and marks (k, 2), px, of a sketch without those that were set aside."""
    marks = [
        mark
        for mark in placed.sketch.marks
        if mark.node in template.node and mark.node not in placed.disagreeing
    ]
    nodes = np.array([template.node[mark.node] for mark in marks], np.intp)
    return nodes, np.array([(mark.u, mark.v) for mark in marks], float).reshape(-1, 2)


def marks_of(sketch: Sketch) -> tuple[object, ...]:
    """Return all that a sketch tells a solve: its size, marks and kind of camera."""
    return sketch.size, sketch.marks, sketch.kind, sketch.cropped
