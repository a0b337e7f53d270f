"""A shape whose colours change while a stroke is painted on it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Faces, Index
from bozzetto.geometry import Mesh
from bozzetto_silhouette.appearance.brush_cover import Segments, covered
from bozzetto_silhouette.appearance.paint_layer import Track, stroked
from bozzetto_silhouette.appearance.paint_refinement import (
    MOST_FACES,
    boxes_of,
    coarsest,
    halved,
    longest_edges,
    meets,
    with_middles,
    with_mixed,
)
from bozzetto_silhouette.appearance.vertex_colors import Coat
from bozzetto_silhouette.model.paint_stroke import BrushLook

FINEST = 0.25
"""Length of the edges that are left while a stroke is painted, in steps of the mesh."""


class Unpainted(NamedTuple):
    """What a stroke is painted on: all that it does not change, so that many may begin with it.

    Attributes
    ----------
    faces : (f, 3) int32 array
    rest, seen : tuple of (v, 3) float array
        Points and unit normals, where strokes lie and as they are seen; one object where nothing
        is posed.
    under, paint : Coat
        Of the vertices: what is below all paint, and the paint before the stroke.
    colors, cover : (v, 4) and (v,) uint8 array
        Of both together, as a mesh has them.
    boxes : (2, 3, f) float array
        The lowest and highest corners of the triangles.
    lengths : (f,) float array
        Of their longest sides.
    step : float
        Spacing of the body's mesh, mm.
    """

    faces: Faces
    rest: tuple[Array, Array]
    seen: tuple[Array, Array]
    under: Coat
    paint: Coat
    colors: NDArray[np.uint8]
    cover: NDArray[np.uint8]
    boxes: Array
    lengths: Array
    step: float

    @classmethod
    def of(cls, rest: Mesh, seen: Mesh, under: Coat, paint: Coat, step: float) -> Unpainted:
        """Return what two meshes with the same triangles, and the coats of their vertices, tell."""
        here = _columns(rest)
        there = here if seen is rest else _columns(seen)
        boxes, lengths = boxes_of(here[0], rest.faces), longest_edges(here[0], rest.faces)
        seen_paint = paint.over(under).bytes()
        return cls(rest.faces, here, there, under, paint, *seen_paint, boxes, lengths, step)


def _columns(mesh: Mesh) -> tuple[Array, Array]:
    return mesh.vertices.astype(np.float64), mesh.vertex_normals().astype(np.float64)


class Canvas:
    """A mesh that is painted on, at rest and as it is seen; it gets finer where the stroke ends.

    Parameters
    ----------
    start : Unpainted
        Before the stroke.
    """

    def __init__(self, start: Unpainted) -> None:
        self._faces, self._rest, self._seen = start.faces, start.rest, start.seen
        self._is_posed = start.seen is not start.rest
        self._under, self._paint, self._step = start.under, start.paint, start.step
        self._covered = np.zeros(len(self._rest[0]))
        self._colors, self._cover = start.colors.copy(), start.cover.copy()
        self._boxes, self._lengths = start.boxes, start.lengths
        self._longest = coarsest(start.lengths, start.step)
        self._laid: list[Segments] = []

    @property
    def mesh(self) -> Mesh:
        """The mesh as it is painted now."""
        points, normals = (values.astype(np.float32) for values in self._seen)
        return Mesh(points, self._faces, normals, self._colors.copy(), self._cover.copy())

    def lay(self, segments: Segments, look: BrushLook) -> None:
        """Add segments to the stroke, which covers each place once."""
        self._laid.append(segments)
        self._refine(segments, look)
        points, normals = self._rest
        index, cover = covered(segments, look.softness, points, normals, FINEST * self._step)
        more = cover > self._covered[index]
        self._color(index[more], cover[more], look)

    def _color(self, index: Index, cover: Array, look: BrushLook) -> None:
        self._covered[index] = cover
        coat = stroked(self._paint.at(index), look, cover).over(self._under.at(index))
        self._colors[index], self._cover[index] = coat.bytes()

    def _refine(self, segments: Segments, look: BrushLook) -> None:
        """Divide the triangles where what is new of the stroke ends."""
        count = len(self._rest[0])
        drawn = Track(segments, look._replace(color=(255, 255, 255), opacity=1.0))
        low, high = segments.points.min(axis=0), segments.points.max(axis=0)
        detail = self._longest
        while detail > 1.5 * FINEST * self._step:
            # Who shares an edge of this length has one.
            reach = float(segments.radii.max()) + detail
            beside = meets(self._boxes, low - reach, high + reach)
            near = np.flatnonzero(beside & (self._lengths > 0.75 * detail))
            faces, pair = halved(*self._rest, self._faces[near], [drawn], detail)
            if len(self._faces) + len(faces) - len(near) > MOST_FACES:
                break
            detail *= 0.5
            if len(pair):
                self._add(pair)
                self._replace_faces(near, faces)
        if len(self._rest[0]) > count:
            self._color_new(count, look)

    def _replace_faces(self, old: Index, new: Faces) -> None:
        """Put other triangles in the place of some, and at the end."""
        boxes, lengths = boxes_of(self._rest[0], new), longest_edges(self._rest[0], new)
        first, more = new[: len(old)], new[len(old) :]
        self._faces = np.concatenate([self._faces, more])
        self._faces[old] = first
        self._boxes = np.concatenate([self._boxes, boxes[..., len(old) :]], axis=2)
        self._boxes[..., old] = boxes[..., : len(old)]
        self._lengths = np.concatenate([self._lengths, lengths[len(old) :]])
        self._lengths[old] = lengths[: len(old)]

    def _add(self, pair: Index) -> None:
        """Add a vertex between each of some pairs."""
        self._rest = with_middles(*self._rest, pair)
        self._seen = with_middles(*self._seen, pair) if self._is_posed else self._rest
        self._under, self._paint = (with_mixed(coat, pair) for coat in (self._under, self._paint))

    def _color_new(self, count: int, look: BrushLook) -> None:
        """Color the vertices from a number on by all of the stroke so far."""
        points, normals = (values[count:] for values in self._rest)
        new = len(points)
        self._covered = np.concatenate([self._covered, np.zeros(new)])
        colors, cover = np.zeros((new, 4), np.uint8), np.zeros(new, np.uint8)
        self._colors = np.concatenate([self._colors, colors])
        self._cover = np.concatenate([self._cover, cover])
        share = np.zeros(new)
        low, high = points.min(axis=0), points.max(axis=0)
        for laid in self._laid:
            reach = float(laid.radii.max()) + self._step
            if (laid.points.min(axis=0) > high + reach).any():
                continue
            if (laid.points.max(axis=0) < low - reach).any():
                continue
            index, found = covered(laid, look.softness, points, normals, FINEST * self._step)
            share[index] = np.maximum(share[index], found)
        self._color(count + np.arange(new), share, look)
