"""The modeler of rough skins: curves in, a closed mesh out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.geometry import (
    SHRINK_WRAP_LEVELS,
    Mesh,
    Shapes,
    Solid,
    curve_distances,
    frozen,
    shrink_wrap,
)
from bozzetto.plugin import Figure, Job, Modeler, Parameter, override
from bozzetto.scene import Layer, Lines, Scene, Shaded
from bozzetto_skin.reading import polylines

PREVIEW_LEVEL: Final = 4
"""Finest level of a preview: 2562 vertices, a tenth of a second."""

FOLLOWING_LEVEL: Final = 3
"""The same of a skin that follows: 642 vertices, half as long, for its source is solved as well."""


def _no_points() -> Array:
    return np.zeros((0, 3))


def _no_starts() -> NDArray[np.int32]:
    return np.zeros(0, np.int32)


@dataclass(frozen=True, eq=False)
class SkinState:
    """Curves, and how tightly a skin is drawn over them.

    Parameters
    ----------
    points : (n, 3) float64
        All polylines, one after the other, mm.
    starts : (k,) int32
        The first point of each.
    detail : int
        How often the triangles of the sphere are subdivided.
    tightness : float
        Percent.
    smoothing : float
        Percent.
    sources : tuple of str
        Ids of the models whose curves they are; then it holds none itself.
    """

    points: Array = field(default_factory=_no_points)
    starts: NDArray[np.int32] = field(default_factory=_no_starts)
    detail: Annotated[
        int,
        Parameter(
            "Detail",
            *SHRINK_WRAP_LEVELS,
            1,
            help="How fine the skin is; each step has four times as many faces.",
        ),
    ] = 5
    tightness: Annotated[
        float,
        Parameter("Tightness", 0, 100, 1, "%", "How far the skin is drawn into hollow places."),
    ] = 100.0
    smoothing: Annotated[
        float,
        Parameter("Smoothing", 0, 100, 1, "%", "From taut with sharp edges to round and full."),
    ] = 20.0
    sources: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", frozen(self.points, np.float64, 3))
        object.__setattr__(self, "starts", frozen(self.starts, np.int32))
        ends = np.append(self.starts, len(self.points))
        begun = self.starts[0] == 0 if len(self.starts) else not len(self.points)
        if not begun or (np.diff(ends) < 1).any():
            raise ValueError("the curves of a skin are rows of points, one after the other")

    @property
    def curves(self) -> tuple[Array, ...]:
        """The polylines."""
        return tuple(np.split(self.points, self.starts[1:])) if len(self.starts) else ()


FIGURES: Final[Mapping[str, Figure]] = {
    "distance": Figure("Curves off the skin", "How far places along the curves are from the skin"),
    "median": Figure("Half of them within", "Median of the distances", "mm", digits=3),
    "95_percent": Figure("95 % within", "95th percentile of the distances", "mm", digits=3),
    "greatest": Figure("All within", "Greatest of the distances", "mm", digits=3),
    "greatest_distance_percent_of_size": Figure(
        "Greatest by size",
        "The greatest distance, as a part of the curves’ diagonal",
        "%",
        digits=2,
    ),
}
"""The words of the report; `Modeler.figures`."""


@dataclass(frozen=True, eq=False)
class Skin:
    """A skin, if there are curves.

    Attributes
    ----------
    mesh : Mesh or None
    distances : (n,) float
        Of places along the curves from it, mm.
    curves : tuple of (n, 3) float64
        Those that it is drawn over, mm.
    """

    mesh: Mesh | None
    distances: Array
    curves: tuple[Array, ...] = ()


class RoughSkin(Modeler[SkinState, Skin]):
    """A sphere shrunk onto curves. There is nothing to draw: the curves come from elsewhere."""

    id = "bozzetto.skin"
    state_type = SkinState
    state_version = 2
    first_parameters = ("detail", "tightness", "smoothing")
    figures = FIGURES

    @override
    def read_shapes(self, shapes: Shapes) -> SkinState:
        """Return a state with the curves and patches of another model, or of a file."""
        lines = polylines(shapes)
        lengths = [0, *(len(line) for line in lines[:-1])]
        starts = np.cumsum(lengths).astype(np.int32)
        return SkinState(np.vstack(lines), starts)

    @override
    def follow(self, sources: Mapping[str, Shapes]) -> SkinState:
        """Return a state that is drawn over whatever curves other models have."""
        polylines(sum(sources.values(), Shapes()))  # refuses what has none
        return SkinState(sources=tuple(sources))

    @override
    def sources(self, state: SkinState) -> Sequence[str]:
        """Return the models whose curves they are."""
        return state.sources

    @override
    def with_sources(self, state: SkinState, sources: Sequence[str]) -> SkinState:
        """Return the same skin over other models."""
        return replace(state, sources=tuple(sources))

    @override
    def upgrade(self, state: dict[str, Any], version: int) -> dict[str, Any]:
        """Read version 1 as well: all skins held their curves."""
        return {"sources": [], **state}

    @override
    def solve(self, state: SkinState, job: Job) -> Skin:
        """Shrink the sphere."""
        curves = state.curves
        if state.sources:
            curves = polylines(sum(job.sources.values(), Shapes()))
        if not curves:
            return Skin(None, np.zeros(0))
        level = state.detail
        if job.quality == "preview":
            level = min(level, FOLLOWING_LEVEL if state.sources else PREVIEW_LEVEL)
        mesh = shrink_wrap(
            curves,
            level=level,
            tightness=state.tightness / 100.0,
            smoothing=state.smoothing / 100.0,
            checkpoint=job.checkpoint,
        )
        if job.quality == "preview":
            return Skin(mesh, np.zeros(0), curves)
        return Skin(mesh, curve_distances(curves, mesh), curves)

    @override
    def scene(self, state: SkinState, result: Skin | None) -> Scene:
        """Return the skin, shaded in clay, and the curves on it."""
        curves = state.curves if result is None else result.curves
        if not curves:
            return Scene()
        points = np.vstack(curves).astype(np.float32)
        starts = np.cumsum([0, *map(len, curves[:-1])]).astype(np.int32)
        layers = [Layer("curves", (Lines(points, starts, color="ghost", width=1.0),))]
        if result is not None and result.mesh is not None:
            layers.insert(0, Layer("skin", (Shaded(result.mesh),)))
        return Scene(tuple(layers))

    @override
    def shapes(self, state: SkinState, result: Skin) -> Shapes:
        """Return the skin as a solid."""
        if result.mesh is None:
            return Shapes()
        return Shapes(solids=(Solid(result.mesh, name="skin"),))

    @override
    def report(self, state: SkinState, result: Skin, job: Job) -> Mapping[str, Any]:
        """Report how far the curves are from the skin."""
        if result.mesh is None:
            return {"curves": 0}
        told: dict[str, Any] = {
            "curves": len(result.curves),
            "vertices": len(result.mesh.vertices),
            "faces": len(result.mesh.faces),
        }
        if len(result.distances):
            size = float(np.linalg.norm(np.ptp(np.vstack(result.curves), axis=0)))
            median, most, greatest = np.quantile(result.distances, [0.5, 0.95, 1.0])
            told["distance_mm"] = {
                "median": float(median),
                "95_percent": float(most),
                "greatest": float(greatest),
            }
            told["greatest_distance_percent_of_size"] = 100.0 * float(greatest) / size
        return told
