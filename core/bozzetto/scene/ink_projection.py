"""The projection of ink onto surfaces: every sample goes to the front-most place under it.

The stroke is cut into runs, each on one unbroken surface. Where it is cut, and why, is told; over
a short way beside its surface it can be continued in the tangent plane.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.ink.checked_points import places_on_sheet
from bozzetto.ink.curves.resample import arc_length, distinct, points_along
from bozzetto.scene.display_list import Scene, Shaded
from bozzetto.scene.picking import Hits, cast_rays
from bozzetto.scene.surface_places import SurfacePlaces
from bozzetto.scene.surface_runs import depth_breaks, unbroken_runs
from bozzetto.scene.tangent_bridge import bridged
from bozzetto.view.camera import Camera, Rays

if TYPE_CHECKING:
    from bozzetto.ink.stroke import Stroke

STEP: Final = 1.0
"""Longest way between two samples, px: what is narrower than a pixel is not seen either."""

MOST_SAMPLES: Final = 20_000
"""Most samples before subdivision; a longer stroke has them farther apart."""

FINEST: Final = 1.0 / 32.0
"""Way, px, down to which the rims of surfaces and their creases are located."""

CREASE: Final = 0.9
"""Cosine of the angle between two faces that touch below which there is a crease: 26°."""


class InkBreak(NamedTuple):
    """A part of the stroke that is on no run, and why.

    Attributes
    ----------
    begin, end : float
        Sample numbers of the stroke with shares, as in `InkRun.at`. They are nearly equal
        where the ink steps from one surface to another one.
    pixels : float
        Length on the sheet, px.
    kind : {"silhouette", "depth", "surface"}
        Beside every surface, having left a silhouette; a jump in depth from one sheet to another
        before or behind it; or over to another surface that touches the first.
    """

    begin: float
    end: float
    pixels: float
    kind: Literal["silhouette", "depth", "surface"]


@dataclass(frozen=True, eq=False)
class InkRun:
    """Ink on one unbroken surface.

    Attributes
    ----------
    points : (n, 3) float
        mm.
    normals : (n, 3) float
        Unit face normals turned towards the eye.
    at : (n,) float
        Where on the stroke: sample number with share, increasing. With it pressure and time
        can be read off the stroke's columns.
    on_surface : (n,) bool
        False where the ink is beside the surface and was continued in its tangent plane.
    places : SurfacePlaces
        What each point lies on; beside the surface the nearer end of what lies on it.
    item : Shaded
        The surface, as it is in the scene.
    creases : (k,) float
        Where on the stroke it crosses a crease of the surface, as in `at`.
    """

    points: Array
    normals: Array
    at: Array
    on_surface: Flags
    places: SurfacePlaces
    item: Shaded
    creases: Array


@dataclass(frozen=True, eq=False)
class ProjectedInk:
    """A stroke on surfaces.

    Attributes
    ----------
    runs : tuple of InkRun
        In the order of the stroke; empty where it meets nothing.
    breaks : tuple of InkBreak
        What lies before, between and after the runs.
    """

    runs: tuple[InkRun, ...]
    breaks: tuple[InkBreak, ...]


def project_stroke(
    stroke: Stroke,
    scene: Scene,
    *,
    models: Collection[str] | None = None,
    bridge: float = 0.0,
) -> ProjectedInk:
    """Project a stroke on whatever surface is seen under it.

    All samples of the stroke are kept; others are put between them, at most `STEP` apart,
    and down to `FINEST` where the surface ends, breaks, bends sharply or gives way to
    another.

    Parameters
    ----------
    stroke : Stroke
        Drawn through its own camera.
    scene : Scene
        See `cast_rays` for what counts as a surface.
    models : collection of str, optional
        Ids of the models whose surfaces count; those of others are looked through. Default all.
    bridge : float
        Longest way beside the surface, px, over which the ink is continued: between two runs on
        one surface, and where the stroke begins or ends beside it. Default none.

    Returns
    -------
    ProjectedInk

    Raises
    ------
    UserError
        If the stroke leaves the sheet beyond all bounds.
    """
    ink = places_on_sheet(stroke.points, "stroke")
    if models is not None:
        scene = Scene(tuple(layer for layer in scene.layers if layer.owner in models))
    path = _Path.of(ink)
    samples = _samples(path, scene, stroke.camera, _stations(path.along))
    while len(between := _to_subdivide(samples)):
        middle = 0.5 * (samples.way[between] + samples.way[between + 1])
        samples = samples.merged(_samples(path, scene, stroke.camera, middle))
    return _in_runs(samples, path, bridge)


class _Path(NamedTuple):
    """The stroke's way over the sheet, by arc length (px)."""

    points: Array
    number: Array
    along: Array

    @classmethod
    def of(cls, ink: Array) -> _Path:
        kept = distinct(ink)
        return cls(ink[kept], kept.astype(float), arc_length(ink[kept]))

    def numbers(self, way: Array) -> Array:
        return np.interp(way, self.along, self.number)


@dataclass(frozen=True, eq=False)
class _Samples:
    """Samples along the stroke: arc length (px), lines of sight, and what they met."""

    way: Array
    rays: Rays
    hits: Hits

    def merged(self, other: _Samples) -> _Samples:
        """Return the samples of both, in order."""
        way = np.concatenate((self.way, other.way))
        order = np.argsort(way, kind="stable")
        rays = (np.concatenate(pair)[order] for pair in zip(self.rays, other.rays, strict=True))
        return _Samples(way[order], Rays(*rays), self.hits.joined(other.hits).taken(order))

    @property
    def breaks(self) -> Flags:
        """Whether one surface cannot lead from a sample to the next."""
        return depth_breaks(self.hits.points, self.hits.normals, self.rays.directions)


def _samples(path: _Path, scene: Scene, camera: Camera, way: Array) -> _Samples:
    rays = camera.rays(points_along(path.points, path.along, way))
    return _Samples(way, rays, cast_rays(scene, rays))


def _stations(along: Array) -> Array:
    """Return arc lengths of the stroke's own samples and of those between them."""
    step = max(STEP, float(along[-1]) / MOST_SAMPLES)
    spans = np.diff(along)
    parts = np.maximum(np.ceil(spans / step), 1.0).astype(np.intp)
    first = np.repeat(np.cumsum(parts) - parts, parts)
    share = (np.arange(len(first)) - first) / np.repeat(parts, parts)
    inner = np.repeat(along[:-1], parts) + share * np.repeat(spans, parts)
    return np.append(inner, along[-1])


def _to_subdivide(samples: _Samples) -> Index:
    """Return the samples after which something happens that is not yet located."""
    hits = samples.hits
    change = hits.on[1:] != hits.on[:-1]  # a rim, too
    events = change | _turns(hits) | samples.breaks
    return np.flatnonzero(events & (np.diff(samples.way) > FINEST))


def _turns(hits: Hits) -> Flags:
    """Whether the surface turns by the angle of a crease from a sample to the next."""
    return np.asarray(np.einsum("nk,nk->n", hits.normals[1:], hits.normals[:-1]) < CREASE)


def _creases(hits: Hits, run: Index) -> Index:
    """Return the samples of a run after which it crosses a crease.

    The two faces touch there. On a round surface that is seen edge-on a step leads over many
    faces, and the first and the last of them are turned, but do not touch.
    """
    sharp = run[:-1][_turns(hits.taken(run))]
    if not len(sharp):
        return sharp
    mesh = hits.surfaces[hits.on[run[0]]].item.mesh
    here, there = (mesh.vertices[mesh.faces[hits.faces[k]]] for k in (sharp, sharp + 1))
    shared = (here[:, :, None] == there[:, None]).all(axis=3)
    return np.asarray(sharp[shared.any(axis=(1, 2))])


class _Segment(NamedTuple):
    """A part of a run: what is on the surface, or continued beside it."""

    way: Array
    points: Array
    normals: Array
    sources: Index
    """Samples that met what each point lies on."""
    on_surface: Flags


def _in_runs(samples: _Samples, path: _Path, bridge: float) -> ProjectedInk:
    """Cut what was hit into runs, and tell what lies between them."""
    hits, way, broken = samples.hits, samples.way, samples.breaks
    pieces = unbroken_runs(hits.hit, (hits.on[1:] != hits.on[:-1]) | broken)
    runs: list[list[_Segment]] = []
    breaks: list[InkBreak] = []
    for number in range(len(pieces) + 1):
        before = int(pieces[number - 1][-1]) if number else None
        after = int(pieces[number][0]) if number < len(pieces) else None
        over = _beside(samples, before, after, bridge)
        if over is not None and before is None:
            runs.append([over])
        elif over is not None:
            runs[-1].append(over)
        else:
            begin = 0.0 if before is None else float(way[before])
            end = float(way[-1] if after is None else way[after])
            if end > begin or not pieces:
                first, last = path.numbers(np.array([begin, end])).tolist()
                kind = _kind(before, after, broken)
                breaks.append(InkBreak(first, last, end - begin, kind))
        if after is not None:
            if over is None:
                runs.append([])
            runs[-1].append(_segment(samples, pieces[number]))
    return ProjectedInk(tuple(_run(samples, path, run) for run in runs), tuple(breaks))


def _kind(
    before: int | None, after: int | None, broken: Flags
) -> Literal["silhouette", "depth", "surface"]:
    """Return why the ink is cut between two samples; None stands for an end of the stroke."""
    if before is None or after is None or after - before > 1:
        return "silhouette"
    return "depth" if broken[before] else "surface"


def _segment(samples: _Samples, piece: Index) -> _Segment:
    hits, on = samples.hits, np.ones(len(piece), bool)
    return _Segment(samples.way[piece], hits.points[piece], hits.normals[piece], piece, on)


def _beside(
    samples: _Samples, before: int | None, after: int | None, bridge: float
) -> _Segment | None:
    """Continue the ink where it is beside a surface; None if it is there for too long."""
    ends = [end for end in (before, after) if end is not None]
    first = 0 if before is None else before + 1
    last = len(samples.way) if after is None else after
    if not ends or last <= first or len(set(samples.hits.on[ends].tolist())) > 1:
        return None
    way = samples.way[first:last]
    begin = way[0] if before is None else samples.way[before]
    end = way[-1] if after is None else samples.way[after]
    if end - begin > bridge:
        return None
    both = np.array([ends[0], ends[-1]])
    rays = Rays(samples.rays.origins[first:last], samples.rays.directions[first:last])
    share = (way - begin) / (end - begin) if end > begin else np.zeros(len(way))
    hits, sight = samples.hits, samples.rays.directions
    made = bridged(rays, share, hits.points[both], hits.normals[both], sight[both])
    if made is None:
        return None
    sources = both[(share > 0.5).astype(np.intp)]
    return _Segment(way, *made, sources, np.zeros(len(way), bool))


def _run(samples: _Samples, path: _Path, segments: list[_Segment]) -> InkRun:
    """Join the segments of a run."""
    hits = samples.hits
    columns = zip(*segments, strict=True)
    way, points, normals, sources, on_surface = (np.concatenate(column) for column in columns)
    item = hits.surfaces[hits.on[sources[0]]].item
    creases = [_creases(hits, part.sources) for part in segments if part.on_surface.all()]
    sharp = np.concatenate(creases)
    crossed = 0.5 * (samples.way[sharp] + samples.way[sharp + 1])
    places = hits.places(sources)
    return InkRun(
        points, normals, path.numbers(way), on_surface, places, item, path.numbers(crossed)
    )
