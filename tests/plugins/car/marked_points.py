"""Sketches of cars as states of the modeler, with marks that may be wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bozzetto.view import Camera
from bozzetto_car.camera.visibility import facing
from bozzetto_car.solver.pipeline import Solved
from bozzetto_car.state import CarState, Mark, Sketch
from bozzetto_car.template.model import Template
from tests.plugins.car.sketched import PICTURE, View, looking, rms

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Marked:
    """A state, and what it keeps to itself.

    Attributes
    ----------
    state : CarState
        With sketches "s0", "s1" …
    cameras : tuple of Camera
    places : tuple of (n, 2) float
        Where all nodes are in each sketch, px.
    wrong : tuple of str
        Nodes whose marks in the first sketch are wrong.
    """

    state: CarState
    cameras: tuple[Camera, ...]
    places: tuple[Array, ...]
    wrong: tuple[str, ...]

    def hidden(self, solved: Solved, number: int = 0) -> float:
        """Error in a sketch of the nodes that have no mark, rms, px."""
        marked = {mark.node for mark in self.state.sketches[number].marks}
        template = solved.template
        rest = [n for n, name in enumerate(template.names) if name not in marked]
        seen = solved.placed[f"s{number}"].sketch_camera.pixels(solved.positions[rest])
        return rms(np.linalg.norm(seen - self.places[number][rest], axis=1))

    def turned(self, solved: Solved, number: int = 0) -> float:
        """By how much the camera of a sketch is turned, degrees."""
        axes = solved.placed[f"s{number}"].sketch_camera.camera.axes @ self.cameras[number].axes.T
        return float(np.degrees(np.arccos(np.clip((np.trace(axes) - 1.0) / 2.0, -1.0, 1.0))))


def marked(
    template: Template,
    car: Array,
    views: Sequence[View],
    seed: int,
    hand: float = 2.0,
    count: int = 99,
    wrong: int = 0,
    off: float = 120.0,
    kind: str = "perspective",
) -> Marked:
    """Mark the nodes that each view shows, `count` at most; some in the first one go astray."""
    rng = np.random.default_rng(seed)
    sketches, cameras, seen = [], [], []
    astray: tuple[str, ...] = ()
    for number, view in enumerate(views):
        camera = looking(car, view, rng, kind)
        nodes = np.flatnonzero(facing(template, car, camera))
        if len(nodes) > count:
            nodes = np.sort(rng.choice(nodes, count, replace=False))
        places = camera.project(car)[0]
        marks = places[nodes] + rng.normal(0.0, 1.0, (len(nodes), 2)) * hand
        names = [template.names[node] for node in nodes]
        if wrong and not number:
            which = rng.choice(len(nodes), wrong, replace=False)
            around = rng.uniform(0.0, 2.0 * np.pi, wrong)
            marks[which] += off * np.stack((np.cos(around), np.sin(around)), axis=1)
            astray = tuple(names[one] for one in which)
        pairs = zip(names, marks.tolist(), strict=True)
        sketches.append(
            Sketch(
                id=f"s{number}",
                width=PICTURE[0],
                height=PICTURE[1],
                marks=tuple(Mark(name, u, v) for name, (u, v) in pairs),
            )
        )
        cameras.append(camera)
        seen.append(places)

    state = replace(CarState(nodes=tuple(sketches)), template=template.id)  # type: ignore[arg-type]
    return Marked(state, tuple(cameras), tuple(seen), astray)


def with_marks(state: CarState, places: dict[str, tuple[float, float]]) -> CarState:
    """The state with some marks of its first sketch in other places."""
    sketch = state.sketches[0]
    marks = tuple(Mark(m.node, *places.get(m.node, (m.u, m.v))) for m in sketch.marks)
    return state.with_node(replace(sketch, marks=marks))


def aside(solved: Solved) -> set[str]:
    """All nodes whose marks were set aside, in any sketch."""
    return {name for placed in solved.placed.values() for name in placed.disagreeing}
