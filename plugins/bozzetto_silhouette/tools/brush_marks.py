"""What the brush leaves under the pen: places on the surface with radii by pressure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry import Mesh, closest_on_mesh, face_normals, mesh_points
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, remembered
from bozzetto.scene import Layer, Scene, Shaded, cast_rays, depth_breaks
from bozzetto.view import Camera
from bozzetto_silhouette.appearance.paint_layer import faces_alike, stroke_in_frame
from bozzetto_silhouette.model.paint_stroke import BrushLook
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.rigging.posing import bent
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.evaluate import tree_body
from bozzetto_silhouette.solids.placements import placement_of
from bozzetto_silhouette.tools.reflection import reflection_of

LIGHTEST = 0.15
"""Share of its size that the brush has where the pen is not pressed at all."""

STEP = 0.25
"""Longest way between two marks, in radii: what a round brush leaves looks even."""

FINEST = 1.0
"""Least way between two marks, px: what is finer is not seen either."""

MOST_MARKS = 20_000
"""Marks of one stroke at most; a longer one has them farther apart."""

OFF_LINE, OFF_RADIUS, OFF_NORMAL = 0.02, 0.03, 0.15
"""How far a mark that is left out may lie beside the line of its neighbours, in radii; how far its
radius may differ from theirs; how far its normal."""

LONGEST = 3.0
"""Longest way between two marks that are kept, in radii: they follow a surface that changes."""


class BrushSurface(NamedTuple):
    """The shape as it is seen, and at rest.

    Attributes
    ----------
    body : Body
        At rest.
    rest, seen : Mesh
        Its mesh, and the same as its joints are turned.
    """

    body: Body
    rest: Mesh
    seen: Mesh

    @property
    def scene(self) -> Scene:
        """The shape as the pen meets it."""
        return Scene((Layer("shape", (Shaded(self.seen),)),))


@dataclass(frozen=True, eq=False)
class Marks:
    """What the brush left, in the model's frame, at rest.

    Attributes
    ----------
    points, normals : (n, 3) float array
        On the surface, mm; unit, outwards.
    radii : (n,) float array
        mm.
    joined : (n − 1,) bool array
        Whether a mark and the next are one line on one surface.
    sources : (n,) int array
        Index in the body's sources of the part that each lies on.
    """

    points: Array
    normals: Array
    radii: Array
    joined: Flags
    sources: Index

    def taken(self, rows: Index) -> Marks:
        """Return some of the marks, in order."""
        joined = np.zeros(max(len(rows) - 1, 0), bool)
        if len(rows) > 1:
            apart = np.concatenate([[0], np.cumsum(~self.joined)])
            joined = apart[rows[1:]] == apart[rows[:-1]]
        return Marks(
            self.points[rows], self.normals[rows], self.radii[rows], joined, self.sources[rows]
        )

    def followed_by(self, other: Marks) -> Marks:
        """Return the marks of both, not joined to each other."""
        between = [False] if len(self.points) and len(other.points) else []
        return Marks(
            np.concatenate([self.points, other.points]),
            np.concatenate([self.normals, other.normals]),
            np.concatenate([self.radii, other.radii]),
            np.concatenate([self.joined, np.array(between, bool), other.joined]),
            np.concatenate([self.sources, other.sources]),
        )


def brush_surface(state: SilhouetteState) -> BrushSurface | None:
    """Return the shape that is painted on; None where there is nothing.

    Raises
    ------
    UserError
        If a part's ink is no outline.
    """
    body = tree_body(state, state.resolution)
    return None if body is None else _surface(state, body)


# Kept as they are, so that the tree of boxes in each is built once.
@remembered(limit=4, key=lambda state, body: (state.unpainted, state.turns, body.mark))
def _surface(state: SilhouetteState, body: Body) -> BrushSurface:
    rest = Mesh(body.vertices.astype(np.float32), body.faces)
    return BrushSurface(body, rest, bent(state, body, rest))


def path_of(stroke: Stroke, size: float, first: int = 0) -> tuple[Array, Array]:
    """Return places of the brush along a stroke, (n, 2), px, and its radii there, (n,), px.

    Parameters
    ----------
    stroke : Stroke
        Of the pen.
    size : float
        Width of the brush where the pen is pressed hard, px; a device that does not tell how hard
        always presses so.
    first : int
        Sample of the stroke to begin with.
    """
    points = stroke.points[first:]
    told = stroke.pressure[first:].astype(np.float64)
    pressure = told if stroke.has_pressure else np.ones(len(points))
    radii = 0.5 * size * (LIGHTEST + (1.0 - LIGHTEST) * np.clip(pressure, 0.0, 1.0))
    spans = np.linalg.norm(np.diff(points, axis=0), axis=1)
    step = np.maximum(STEP * np.minimum(radii[1:], radii[:-1]), FINEST)
    parts = np.maximum(np.ceil(spans / step), 1.0)
    if parts.sum() > MOST_MARKS:
        step = np.maximum(step, spans.sum() / MOST_MARKS)
        parts = np.maximum(np.ceil(spans / step), 1.0)
    number = np.repeat(np.arange(len(parts)), parts.astype(np.intp))
    inner = np.arange(len(number)) - np.repeat(np.cumsum(parts) - parts, parts.astype(np.intp))
    at = np.append(number + inner / np.repeat(parts, parts.astype(np.intp)), len(points) - 1.0)
    known = np.arange(len(points), dtype=np.float64)
    columns = (points[:, 0], points[:, 1], radii)
    x, y, wide = (np.interp(at, known, column) for column in columns)
    return np.column_stack([x, y]), wide


def marks_under(surface: BrushSurface, pixels: Array, radii: Array, camera: Camera) -> Marks:
    """Return the marks of a brush at canvas positions (n, 2), px, with radii (n,), px."""
    rays = camera.rays(pixels)
    hits = cast_rays(surface.scene, rays)
    broken = depth_breaks(hits.points, hits.normals, rays.directions)
    met = np.flatnonzero(hits.hit)
    faces, weights = hits.faces[met], hits.weights[met]
    corners = surface.body.faces[faces]
    normals = np.einsum("nk,nkd->nd", weights, surface.body.normals[corners])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    apart = np.concatenate([[0], np.cumsum(broken | ~hits.hit[1:] | ~hits.hit[:-1])])
    depth = camera.view_space(hits.points[met])[:, 2]
    scale = 1.0 if camera.kind == "orthographic" else depth / camera.distance
    largest = corners[np.arange(len(met)), weights.argmax(axis=1)]
    return Marks(
        mesh_points(surface.rest, faces, weights),
        normals,
        radii[met] * scale / camera.pixels_per_mm,
        apart[met[1:]] == apart[met[:-1]],
        surface.body.origins[largest].astype(np.intp),
    )


def mirrored_marks(
    marks: Marks, surface: BrushSurface, state: SilhouetteState, context: Context
) -> Marks:
    """Return the mirror image of marks, as far as the surface is there, too.

    The plane is that of the part which each lies on: what was drawn from the front has its left
    and its right.
    """
    parts = {part.id: part for part in state.parts}
    images = [
        reflection_of(parts[source].sheet, context) if source in parts else None
        for source in surface.body.sources
    ]
    points, normals = marks.points.copy(), marks.normals.copy()
    has_image = np.zeros(len(marks.points), bool)
    for number, image in enumerate(images):
        rows = np.flatnonzero(marks.sources == number)
        if image is not None and len(rows):
            points[rows] = image.points(points[rows])
            normals[rows] = image.directions(normals[rows])
            has_image[rows] = True
    if not has_image.any():
        return marks.taken(np.zeros(0, np.intp))
    found = closest_on_mesh(surface.rest, points, normals)
    lies = faces_alike(normals, face_normals(surface.rest, found.faces))
    kept = np.flatnonzero(has_image & lies & (found.distances <= marks.radii + surface.body.step))
    corner = surface.body.faces[found.faces, found.weights.argmax(axis=1)]
    sources = surface.body.origins[corner].astype(np.intp)
    return replace(marks, points=points, normals=normals, sources=sources).taken(kept)


def with_marks(
    state: SilhouetteState, body: Body, marks: Marks, look: BrushLook
) -> SilhouetteState:
    """Return a state of which the parts under some marks have a stroke of paint more.

    Parameters
    ----------
    state : SilhouetteState
        What was drawn and painted.
    body : Body
        The shape that the marks lie on.
    marks : Marks
        What the brush left.
    look : BrushLook
        Of the stroke.
    """
    changed: dict[str, Part] = {}
    whole = replace(marks, radii=_filled_radii(marks, look.softness))
    for part in state.parts:
        if part.id not in body.sources:
            continue
        runs = _runs_on(whole, marks.sources == body.sources.index(part.id))
        if not runs:
            continue
        rows = np.concatenate(runs)
        starts = np.cumsum([0, *(len(run) for run in runs[:-1])])
        stroke = stroke_in_frame(
            part,
            placement_of(state, part),
            look,
            marks.points[rows],
            marks.normals[rows],
            whole.radii[rows],
            starts,
        )
        changed[part.id] = replace(part, paint_strokes=(*part.paint_strokes, stroke))
    return replace(state, nodes=tuple(changed.get(node.id, node) for node in state.nodes))


def _filled_radii(marks: Marks, softness: float) -> Array:
    """Return the radii of marks, those of marks that lie in others as large as these allow, mm.

    What a mark covers fully its neighbours need not tell: a hand that presses unevenly leaves a
    narrow mark within wide ones, and the stroke covers what it did.
    """
    steps = np.linalg.norm(np.diff(marks.points, axis=0), axis=1)
    core = (1.0 - softness) * marks.radii
    radii = marks.radii.copy()
    for run in np.split(np.arange(len(radii)), np.flatnonzero(~marks.joined) + 1):
        along = np.concatenate([[0.0], np.cumsum(steps[run[:-1]])])
        before = np.maximum.accumulate(core[run] + along) - along
        behind = np.maximum.accumulate((core[run] - along)[::-1])[::-1] + along
        radii[run] = np.maximum(radii[run], np.maximum(before, behind))
    return radii


def _runs_on(marks: Marks, own: Flags) -> list[Index]:
    """Return the runs of marks on one part, thinned out, each with its neighbours on others."""
    joined = np.concatenate([[False], marks.joined, [False]])
    beside = (np.append(own[1:], False) & joined[1:]) | (np.append(False, own[:-1]) & joined[:-1])
    rows = np.flatnonzero(own | beside)
    if not len(rows):
        return []
    # Between two neighbours on another part nothing is drawn twice: a run ends there.
    linked = (np.diff(rows) == 1) & marks.joined[rows[:-1]] & (own[rows[:-1]] | own[rows[1:]])
    runs = np.split(rows, np.flatnonzero(~linked) + 1)
    return [run[_kept(marks, run)] for run in runs]


def _kept(marks: Marks, run: Index) -> Index:
    """Return the places in a run of marks that tell what the others would (Douglas, Peucker)."""
    points, normals, radii = marks.points[run], marks.normals[run], marks.radii[run]
    kept = np.zeros(len(run), bool)
    kept[[0, -1]] = True
    ahead = [(0, len(run) - 1)]
    while ahead:
        first, last = ahead.pop()
        if last - first < 2:
            continue
        inner = slice(first + 1, last)
        chord = points[last] - points[first]
        away = points[inner] - points[first]
        share = np.clip(away @ chord / max(float(chord @ chord), 1e-300), 0.0, 1.0)
        radius = np.maximum(radii[inner], 1e-300)
        off = np.linalg.norm(away - share[:, None] * chord, axis=1) / (OFF_LINE * radius)
        wide = radii[first] + share * (radii[last] - radii[first])
        look = normals[first] + share[:, None] * (normals[last] - normals[first])
        worst = np.maximum(off, np.abs(radii[inner] - wide) / (OFF_RADIUS * radius))
        turned = np.linalg.norm(normals[inner] - look, axis=1) / OFF_NORMAL
        worst = np.maximum(worst, turned)
        at = first + 1 + int(worst.argmax())
        if worst.max() <= 1.0:
            if float(np.linalg.norm(chord)) <= LONGEST * float(radius.mean()):
                continue
            at = (first + last) // 2
        kept[at] = True
        ahead += [(first, at), (at, last)]
    return np.flatnonzero(kept)
