"""A modeler of boxes that follow others: each hands over its own box and its sources', grown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Shapes, Solid
from bozzetto.plugin import Command, Context, Ink, Job, Modeler, Parameter, Tool, override
from bozzetto.scene import Layer, Scene, Shaded
from tests import plugin_package

MODELER = "linked.boxes"

MANIFEST = f"""
id = "linked.plugin"
title = "Linked"
version = "1.0"
api = ">=2,<3"

[[modeler]]
id = "{MODELER}"
title = "Boxes"
icon = "icon.svg"
hint = "Use an object as input."
order = 96
abilities = ["follow"]
"""

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float32)
FACES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ],
    np.int32,
)  # fmt: skip


CODE = """
from bozzetto.plugin import hookimpl

given = []

@hookimpl
def bozzetto_modelers():
    from tests.linked_boxes import Boxes

    return given or [Boxes()]
"""


def write_package(folder: Path, name: str) -> None:
    plugin_package.write(folder, name, MANIFEST, CODE)


@dataclass(frozen=True)
class BoxState:
    """A cube of an edge (mm; none where it is 0) and the sources, grown about their middles."""

    edge: Annotated[float, Parameter("Edge", 0.0, 100.0, 1.0, "mm")] = 0.0
    growth: Annotated[float, Parameter("Growth", 0.0, 10.0)] = 1.5
    wrong: Annotated[bool, Parameter("Wrong")] = False
    sources: tuple[str, ...] = ()


class FollowAll(Tool[BoxState]):
    """Any stroke makes a box follow whatever is seen."""

    id, title, hint, gesture = "follow", "Follow", "Draw anything.", "ink"

    @override
    def draw(self, state: BoxState, ink: Ink, context: Context) -> BoxState:
        return _follow_all(state, context)


class Boxes(Modeler[BoxState, tuple[Mesh, ...]]):
    """Counts what is asked of it; `fails` makes wrong states a fault instead of an error."""

    id = MODELER
    state_type = BoxState

    def __init__(self) -> None:
        self.solved: list[tuple[BoxState, str]] = []
        self.fails = False

    @override
    def follow(self, sources: Mapping[str, Shapes]) -> BoxState:
        if not any(shapes.solids for shapes in sources.values()):
            raise UserError("There is no solid to grow. Choose another object.")
        return BoxState(sources=tuple(sources))

    @override
    def sources(self, state: BoxState) -> Sequence[str]:
        return state.sources

    @override
    def with_sources(self, state: BoxState, sources: Sequence[str]) -> BoxState:
        return replace(state, sources=tuple(sources))

    @override
    def solve(self, state: BoxState, job: Job) -> tuple[Mesh, ...]:
        self.solved.append((state, job.quality))
        if state.wrong and self.fails:
            raise ZeroDivisionError
        if state.wrong:
            raise UserError("This box is wrong. Make it right.")
        own = (Mesh(CORNERS * np.float32(state.edge), FACES),) if state.edge else ()
        assert tuple(job.sources) == state.sources
        grown = (
            _grown(part.mesh, state.growth)
            for shapes in job.sources.values()
            for part in shapes.solids
        )
        return (*own, *grown)

    @override
    def scene(self, state: BoxState, result: tuple[Mesh, ...] | None) -> Scene:
        return Scene((Layer("boxes", tuple(Shaded(mesh) for mesh in result or ())),))

    @override
    def shapes(self, state: BoxState, result: tuple[Mesh, ...]) -> Shapes:
        return Shapes(solids=tuple(Solid(mesh) for mesh in result))

    @override
    def tools(self) -> Sequence[Tool[BoxState]]:
        return (FollowAll(),)

    @override
    def commands(self) -> Sequence[Command]:
        return (Command("follow_all", "Follow all", run=_follow_all, help="Follows all there is."),)


def _grown(mesh: Mesh, growth: float) -> Mesh:
    middle = mesh.vertices.mean(axis=0)
    return Mesh(middle + (mesh.vertices - middle) * np.float32(growth), mesh.faces)


def _follow_all(state: BoxState, context: Context) -> BoxState:
    """Follow whatever is seen: a way to make circles."""
    owners = dict.fromkeys(layer.owner for layer in context.scene.layers if layer.owner)
    return replace(state, sources=tuple(owners))
