"""The strokes of paint of all parts on the surface as it is now, and the colours that they give.

Each stroke is carried with its part, and its places go to the nearest of the surface that face the
same way, as far as there is one: after a change of the outline, of the depth or of the resolution
it lies on the new surface. What lies on nothing waits.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.geometry import Mesh, Placement, closest_on_mesh, face_normals
from bozzetto.plugin import Caution, remembered
from bozzetto_silhouette.appearance.brush_cover import Segments, covered
from bozzetto_silhouette.appearance.vertex_colors import Coat, bare
from bozzetto_silhouette.model.paint_stroke import BrushLook, PaintStroke
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.placements import placement_of, shown_parts

ASIDE = 1.0
"""How far along the surface a place may have to go to meet it, in its radii and the mesh's steps:
what is farther lay where a hole is now, or where a limb was."""

DEEPER = 2.0
"""How far along its normal it may have to go, in its radii, or in the body's own radius."""

TORN = 3.0
"""How much farther apart than before two neighbours may come to lie and still be joined."""

ALIKE = 0.5
"""Cosine of the angle between two normals from which they face the same way, 60°."""

TOLD = 0.1
"""Share of a stroke's places off the surface from which it is told."""


class Laid(NamedTuple):
    """A stroke of one part, and where the part stands.

    Attributes
    ----------
    stroke : PaintStroke
    placement : Placement
        From the object frame of the part to the model's.
    depth : float
        By which the heights of the stroke grow: the part's inflation.
    """

    stroke: PaintStroke
    placement: Placement
    depth: float


class Track(NamedTuple):
    """A stroke on a surface, with all its pieces on different parts.

    Attributes
    ----------
    segments : Segments
    look : BrushLook
    """

    segments: Segments
    look: BrushLook


Group = tuple[Laid, ...]
"""The pieces of one stroke."""


def faces_alike(one: Array, other: Array) -> Flags:
    """Return which of two rows of unit normals (n, 3) face the same way."""
    return np.asarray(np.einsum("nd,nd->n", one, other) >= ALIKE)


def depth_of(part: Part) -> float:
    """Return by which factor a part's heights grow with its inflation; 1 where they do not."""
    return 1.0 if part.surface == "straight" else part.inflation


def laid_strokes(state: SilhouetteState) -> tuple[Group, ...]:
    """Return the strokes of paint on all shown parts, the first that was painted first."""
    groups: dict[int, list[Laid]] = {}
    for part in shown_parts(state):
        if part.paint_strokes:
            place, depth = placement_of(state, part), depth_of(part)
            for stroke in part.paint_strokes:
                groups.setdefault(stroke.number, []).append(Laid(stroke, place, depth))
    return tuple(tuple(groups[number]) for number in sorted(groups))


def stroke_in_frame(
    part: Part,
    placement: Placement,
    look: BrushLook,
    points: Array,
    normals: Array,
    radii: Array,
    starts: ArrayLike,
) -> PaintStroke:
    """Return a stroke of a part that is given in the model's frame."""
    back, depth = placement.inverse(), depth_of(part)
    flat = back.directions(normals) * (1.0, 1.0, depth)
    return PaintStroke(
        look.number,
        (back.points(points) / (1.0, 1.0, depth)).astype(np.float32),
        (flat / np.linalg.norm(flat, axis=1, keepdims=True)).astype(np.float32),
        (radii * back.scale).astype(np.float32),
        np.asarray(starts, np.int32),
        look.color,
        look.opacity,
        look.softness,
    )


def paint_in_part(state: SilhouetteState, part: Part, other: Part) -> tuple[PaintStroke, ...]:
    """Return the paint of a part as that of another part, which it becomes a piece of."""
    place = placement_of(state, part)
    strokes = []
    for stroke in other.paint_strokes:
        there = _carried(Laid(stroke, placement_of(state, other), depth_of(other)))
        strokes.append(
            stroke_in_frame(
                part, place, stroke.look, there.points, there.normals, there.radii, stroke.starts
            )
        )
    return tuple(strokes)


def tracks_of(groups: Sequence[Group], body: Body | None) -> list[Track]:
    """Return strokes on the surface of a body; with None where they were painted."""
    return [_track(group, body) for group in groups]


def lost_strokes(state: SilhouetteState, body: Body) -> int:
    """Count the strokes of paint of which a tenth at least lies on nothing now."""
    count = 0
    for group in laid_strokes(state):
        kept = np.concatenate([_settled(laid, body).kept for laid in group])
        count += bool((~kept).mean() >= TOLD)
    return count


def paint_facts(state: SilhouetteState, body: Body) -> dict[str, int] | None:
    """Return how many strokes of paint there are, and off the surface; None without any."""
    strokes = len(laid_strokes(state))
    return {"strokes": strokes, "off_surface": lost_strokes(state, body)} if strokes else None


def lost_paint(state: SilhouetteState, body: Body) -> tuple[Caution, ...]:
    """Return a caution about strokes of paint under which the surface is gone, if there are any."""
    count = lost_strokes(state, body)
    if not count:
        return ()
    strokes = "1 stroke of paint lies" if count == 1 else f"{count} strokes of paint lie"
    return (
        Caution(
            f"{strokes} on nothing now, in whole or in part. Paint is kept and comes back with "
            "the surface; undo, or rub it out where it still shows."
        ),
    )


def painted_over(layer: Coat, track: Track, points: Array, normals: Array, detail: float) -> Coat:
    """Lay a stroke over a layer of paint on n places; see `covered`."""
    over = Coat(layer.rgb.copy(), layer.cover.copy())
    _lay(over, track, points, normals, detail)
    return over


def stroked(layer: Coat, look: BrushLook, cover: Array) -> Coat:
    """Lay a stroke over a layer of paint, given how much it covers of each place, (n,)."""
    share = look.opacity * cover
    if look.color is None:
        return Coat(layer.rgb * (1.0 - share)[:, None], layer.cover * (1.0 - share))
    return Coat(share[:, None] * np.array(look.color, np.float64), share).over(layer)


def paint_at(tracks: Sequence[Track], points: Array, normals: Array, detail: float) -> Coat:
    """Return the paint of strokes, later ones over earlier ones, at n places of a surface.

    Parameters
    ----------
    tracks : sequence of Track
        In the order painted.
    points, normals : (n, 3) float array
        Places, mm, and unit normals.
    detail : float
        Distance between them, mm.
    """
    layer = bare(len(points))
    for track in tracks:
        _lay(layer, track, points, normals, detail)
    return layer


def _lay(layer: Coat, track: Track, points: Array, normals: Array, detail: float) -> None:
    """Lay a stroke over a layer of paint in place."""
    index, cover = covered(track.segments, track.look.softness, points, normals, detail)
    if len(index):
        here = stroked(layer.at(index), track.look, cover)
        layer.rgb[index], layer.cover[index] = here.rgb, here.cover


# By the mesh: after one more stroke only that one is laid.
@remembered(limit=8, key=lambda groups, mesh, body, detail: (groups, mesh))
def paint_on_mesh(groups: tuple[Group, ...], mesh: Mesh, body: Body | None, detail: float) -> Coat:
    """Return the paint at the vertices of a mesh of a body; see `tracks_of` and `paint_at`."""
    before = paint_on_mesh.known(groups[:-1], mesh, body, detail) if len(groups) > 1 else None
    points = mesh.vertices.astype(np.float64)
    normals = mesh.vertex_normals().astype(np.float64)
    if before is not None:
        return painted_over(before, _track(groups[-1], body), points, normals, detail)
    return paint_at(tracks_of(groups, body), points, normals, detail)


class _Places(NamedTuple):
    """Places of a stroke on a surface, and which of them lie on it."""

    points: Array
    normals: Array
    radii: Array
    joined: Flags
    kept: Flags


def _track(group: Group, body: Body | None) -> Track:
    found = [_carried(laid) if body is None else _settled(laid, body) for laid in group]
    joined = np.concatenate([flags for place in found for flags in (place.joined, [False])])[:-1]
    kept = np.concatenate([place.kept for place in found])
    points, normals, radii = (
        np.concatenate([place[column] for place in found]) for column in range(3)
    )
    segments = Segments.through(points, normals, radii, joined & kept[1:] & kept[:-1])
    lies = kept[segments.ends].all(axis=1)
    return Track(segments._replace(ends=segments.ends[lies]), group[0].stroke.look)


def _carried(laid: Laid) -> _Places:
    """Return the places of a stroke where its part stands."""
    stroke, place, depth = laid
    points = stroke.points.astype(np.float64) * (1.0, 1.0, depth)
    normals = stroke.normals.astype(np.float64) * (depth, depth, 1.0)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    joined = np.ones(len(points) - 1, bool)
    joined[stroke.starts[1:] - 1] = False
    return _Places(
        place.points(points),
        place.directions(normals),
        stroke.radii.astype(np.float64) * place.scale,
        joined,
        np.ones(len(points), bool),
    )


@remembered(limit=2048, key=lambda laid, body: (laid, body.mark))
def _settled(laid: Laid, body: Body) -> _Places:
    """Return the places of a stroke on the surface of a body."""
    points, normals, radii, joined, _ = _carried(laid)
    mesh = _mesh_of(body)
    found = closest_on_mesh(mesh, points, normals)
    there = found.points(mesh)
    away = there - points
    along = np.einsum("nd,nd->n", away, normals)
    aside = np.linalg.norm(away - along[:, None] * normals, axis=1)
    kept = (
        faces_alike(normals, face_normals(mesh, found.faces))
        & (aside <= ASIDE * (radii + body.step))
        & (np.abs(along) <= np.maximum(DEEPER * radii, body.radius))
    )
    smooth = np.einsum("nk,nkd->nd", found.weights, body.normals[body.faces[found.faces]])
    smooth /= np.maximum(np.linalg.norm(smooth, axis=1, keepdims=True), 1e-300)
    before, after = (np.linalg.norm(np.diff(line, axis=0), axis=1) for line in (points, there))
    whole = after <= TORN * before + radii[1:]
    return _Places(there, smooth, radii, joined & whole, kept)


@remembered(limit=4, key=lambda body: body.mark)
def _mesh_of(body: Body) -> Mesh:
    return Mesh(body.vertices.astype(np.float32), body.faces)
