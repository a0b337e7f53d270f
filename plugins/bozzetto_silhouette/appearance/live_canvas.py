"""A shape whose colours change while a stroke is painted on it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.geometry import Mesh
from bozzetto_silhouette.appearance.brush_cover import Segments, covered
from bozzetto_silhouette.appearance.paint_layer import stroked
from bozzetto_silhouette.appearance.vertex_colors import Coat
from bozzetto_silhouette.model.paint_stroke import BrushLook


class Canvas:
    """A mesh that is painted on, at rest and as it is seen.

    Parameters
    ----------
    rest, seen : Mesh
        With the same triangles; `rest` is where strokes lie.
    under, paint : Coat
        Of their vertices: what is below all paint, and the paint before this stroke.
    detail : float
        Distance between the vertices, mm.
    """

    def __init__(self, rest: Mesh, seen: Mesh, under: Coat, paint: Coat, detail: float) -> None:
        self._points = rest.vertices.astype(np.float64)
        self._normals = rest.vertex_normals().astype(np.float64)
        self._under, self._paint, self._detail = under, paint, detail
        self._covered = np.zeros(len(self._points))
        self._colors, self._cover = paint.over(under).bytes()
        self._seen = seen

    @property
    def mesh(self) -> Mesh:
        """The mesh as it is painted now."""
        return replace(self._seen, colors=self._colors.copy(), cover=self._cover.copy())

    def lay(self, segments: Segments, look: BrushLook) -> None:
        """Add segments to the stroke, which covers each place once."""
        index, cover = covered(segments, look.softness, self._points, self._normals, self._detail)
        more = cover > self._covered[index]
        index, cover = index[more], cover[more]
        self._covered[index] = cover
        coat = stroked(self._paint.at(index), look, cover).over(self._under.at(index))
        self._colors[index], self._cover[index] = coat.bytes()
