"""The modeler: state in; ribbons, picture and shapes out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry import Curve, Mesh, Shapes, Surface
from bozzetto.plugin import Figure, Job, Modeler, Tool, override
from bozzetto.scene import Handle, Layer, Lines, Scene, Shaded
from bozzetto_ribbon.band import Strip, middle_line, strip, triangles
from bozzetto_ribbon.state import RibbonState
from bozzetto_ribbon.tools import DrawRibbon, MoveRibbon, TakeAway, point

PLACES = {"preview": 40, "final": 200}
"""Places along each ribbon."""


class Ribbon(Modeler[RibbonState, tuple[Strip, ...]]):
    """A stroke becomes a ribbon."""

    id = "example.ribbon"
    state_type = RibbonState
    state_version = 2
    first_parameters = ("width",)
    figures = {
        "length": Figure("Length", "Length of the middle line.", "mm", spread=True),
        "widest": Figure("Widest place", "From edge to edge.", "mm", digits=1, spread=True),
    }

    @override
    def tools(self) -> Sequence[Tool[RibbonState]]:
        """Drawing comes first."""
        return (DrawRibbon(), MoveRibbon(), TakeAway())

    @override
    def solve(self, state: RibbonState, job: Job) -> tuple[Strip, ...]:
        """One strip for every band."""
        strips = []
        for number, band in enumerate(state.bands):
            job.checkpoint(number / len(state.bands), "Ribbons")
            count = PLACES[job.quality]
            strips.append(strip(band, count, state.width, state.influence, state.twist))
        return tuple(strips)

    @override
    def scene(self, state: RibbonState, result: tuple[Strip, ...] | None) -> Scene:
        """The ribbons, their ink as a ghost, and a handle at the beginning of each."""
        ink, handles = [], []
        for number, band in enumerate(state.bands):
            places, _ = middle_line(band)
            ink.append(Lines(places.astype(np.float32), color="ghost"))
            handles.append(Handle(str(number), point(places[0]), tip="Move this ribbon"))
        layers = [Layer("ink", tuple(ink)), Layer("handles", tuple(handles))]
        if result is not None:
            layers.insert(0, Layer("ribbons", tuple(Shaded(mesh(s)) for s in result)))
        return Scene(tuple(layers))

    @override
    def shapes(self, state: RibbonState, result: tuple[Strip, ...]) -> Shapes:
        """Every ribbon as a surface, and its middle line as a curve."""
        return Shapes(
            surfaces=tuple(Surface(mesh(s), name="ribbon") for s in result),
            curves=tuple(polyline(s.centre) for s in result),
        )

    @override
    def report(self, state: RibbonState, result: tuple[Strip, ...], job: Job) -> Mapping[str, Any]:
        """Length and widest place of every ribbon."""
        lengths, widest = [], []
        for number, ribbon in enumerate(result):
            job.checkpoint(number / len(result), "Ribbons")
            steps = np.linalg.norm(np.diff(ribbon.centre, axis=0), axis=1)
            lengths.append(float(steps.sum()))
            across = np.linalg.norm(ribbon.right - ribbon.left, axis=1)
            widest.append(float(across.max()))
        return {"length_mm": lengths, "widest_mm": widest}

    @override
    def upgrade(self, state: dict[str, Any], version: int) -> dict[str, Any]:
        """Version 1 had no twist, and called the influence of pressure "pressure"."""
        if version < 2:
            state = {**state, "influence": state.get("pressure", 0.7), "twist": 0.0}
            state.pop("pressure", None)
        return state


def mesh(ribbon: Strip) -> Mesh:
    """A ribbon as triangles."""
    vertices = np.concatenate((ribbon.left, ribbon.right))
    return Mesh(vertices.astype(np.float32), triangles(len(ribbon.centre)))


def polyline(places: NDArray[np.float64]) -> Curve:
    """A curve of degree 1 through places."""
    count = len(places)
    knots = np.concatenate(([0.0], np.arange(count), [count - 1.0]))
    return Curve(1, knots, places, name="middle")
