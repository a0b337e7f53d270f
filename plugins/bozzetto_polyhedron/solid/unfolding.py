"""Faces laid flat at true size: one by one, and unfolded into nets with tabs for paper models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Color, Curve
from bozzetto_polyhedron.solid.face_rings import flat_rings, sides_of, tangents
from bozzetto_polyhedron.solid.planar_body import PlanarBody

if TYPE_CHECKING:
    from manifold3d import CrossSection

OVERLAP: Final = 1e-6
"""Share of the smaller one's area above which two flat pieces overlap."""

TRIES: Final = 12
"""Faces from which nets are begun, the largest first; twice as many nets are compared."""

SLANT: Final = 0.6
"""How far the ends of a tab are cut back, in widths of the tab."""

GAP: Final = 0.04
"""Space between pieces on the page, as share of the size of the largest."""

FOLD_COLOR: Final = (30, 110, 200)
"""Folds, so that they are told from cuts."""

Where = Literal["ground", "front"]
"""Plane of the page: x and y, as laser cutters read DXF, or x and z, as SVG is written."""


@dataclass(frozen=True, eq=False)
class Net:
    """Faces unfolded into a plane, none over another; all coordinates in mm.

    Parameters
    ----------
    faces : tuple of int
        Numbers of the faces, in the order in which they were added.
    rings : tuple of tuple of (n, 2) float64
        Of each face, seen from outside.
    folds : (k, 2, 2) float64
        Edges over which the net is folded.
    valleys : (k,) bool
        Folds towards the outside; the others are folded away from it.
    cuts : (c, 2, 2) float64
        Edges along which it is cut.
    tabs : tuple of (4, 2) float64
        Trapezoids along cuts to glue on; of each edge that is cut, one side has one where there
        is room.
    """

    faces: tuple[int, ...]
    rings: tuple[tuple[Array, ...], ...]
    folds: Array
    valleys: Array
    cuts: Array
    tabs: tuple[Array, ...]


@dataclass(frozen=True, eq=False)
class _Laid:
    """A face in the plane: corner v of space is at ``turn @ flat[v] + shift``."""

    corners: dict[int, Array]
    rings: tuple[Array, ...]
    section: CrossSection
    area: float


def laid_faces(body: PlanarBody) -> tuple[tuple[Array, ...], ...]:
    """Return the rings of every face at true size, side by side without overlap, (n, 2) each."""
    faces = []
    for face, normal in zip(body.faces, body.normals, strict=True):
        rings = flat_rings(body.vertices, face, normal)
        turn = _level(rings[0])
        faces.append(tuple(ring @ turn.T for ring in rings))
    return _side_by_side(faces)


def _level(ring: Array) -> Array:
    """Return the turn that lays the longest side of a ring along x, (2, 2)."""
    steps = np.roll(ring, -1, axis=0) - ring
    x, y = steps[int(np.argmax((steps**2).sum(axis=1)))]
    return np.asarray(np.array(((x, y), (-y, x))) / np.hypot(x, y))


def nets(body: PlanarBody, tab: float = 0.0) -> tuple[Net, ...]:
    """Unfold a body into as few nets as are found.

    A net grows face by face over its longest free edge (or in the order in which edges became
    free), as long as the new face overlaps none; it is begun from several faces, and the way of
    fewest pieces is taken.

    Parameters
    ----------
    body : PlanarBody
        A solid or a sheet.
    tab : float
        Width of tabs, mm; 0 for none.
    """
    sides = _sides(body)
    areas = [float(np.linalg.norm(np.ptp(body.vertices[list(f[0])], axis=0))) for f in body.faces]
    order = sorted(range(len(body.faces)), key=lambda k: (-areas[k], k))
    best: list[tuple[dict[int, _Laid], list[tuple[int, int]]]] = []
    for start in order[:TRIES]:
        for longest_first in (True, False):
            found = _pieces(body, sides, [start, *order], longest_first)
            if not best or len(found) < len(best):
                best = found
        if len(best) == 1:
            break
    tabbed: set[tuple[int, int]] = set()
    return tuple(_net(body, laid, folds, tab, tabbed) for laid, folds in best)


def _sides(body: PlanarBody) -> dict[tuple[int, int], list[int]]:
    """Return the faces at every edge; the edge has the smaller number first."""
    found: dict[tuple[int, int], list[int]] = {}
    for number, face in enumerate(body.faces):
        for ring in face:
            for one, two in sides_of(ring):
                found.setdefault((min(one, two), max(one, two)), []).append(number)
    return found


def _pieces(
    body: PlanarBody,
    sides: dict[tuple[int, int], list[int]],
    starts: Sequence[int],
    longest_first: bool,
) -> list[tuple[dict[int, _Laid], list[tuple[int, int]]]]:
    """Unfold all faces, each piece as far as it goes; return pieces with the edges they fold."""
    todo = set(range(len(body.faces)))
    pieces = []
    for start in starts:
        if start not in todo:
            continue
        laid = {start: _first(body, start)}
        folds: list[tuple[int, int]] = []
        todo.discard(start)
        frontier = _edges_of_face(body, start)
        while frontier:
            if longest_first:
                frontier.sort(key=lambda edge: (_length(body, edge), edge))
                edge = frontier.pop()
            else:
                edge = frontier.pop(0)
            known = [face for face in sides[edge] if face in laid]
            for face in sides[edge]:
                if face not in todo or len(sides[edge]) != 2:
                    continue
                added = _over(body, laid[known[0]], face, edge)
                if all(_apart(added, other) for other in laid.values()):
                    laid[face] = added
                    folds.append(edge)
                    todo.discard(face)
                    frontier += _edges_of_face(body, face)
        pieces.append((laid, folds))
    return pieces


def _edges_of_face(body: PlanarBody, face: int) -> list[tuple[int, int]]:
    return [(min(s), max(s)) for ring in body.faces[face] for s in sides_of(ring)]


def _length(body: PlanarBody, edge: tuple[int, int]) -> float:
    return round(float(np.linalg.norm(body.vertices[edge[1]] - body.vertices[edge[0]])), 9)


def _first(body: PlanarBody, face: int) -> _Laid:
    ring = flat_rings(body.vertices, body.faces[face], body.normals[face])[0]
    return _laid(body, face, _level(ring), np.zeros(2))


def _flat(body: PlanarBody, face: int) -> dict[int, Array]:
    """Return the corners of a face in the coordinates of its plane."""
    axes = tangents(body.normals[face])
    return {v: axes @ body.vertices[v] for ring in body.faces[face] for v in ring}


def _laid(body: PlanarBody, face: int, turn: Array, shift: Array) -> _Laid:
    import manifold3d

    corners = {v: turn @ at + shift for v, at in _flat(body, face).items()}
    rings = tuple(np.array([corners[v] for v in ring]) for ring in body.faces[face])
    section = manifold3d.CrossSection(list(rings), manifold3d.FillRule.EvenOdd)
    return _Laid(corners, rings, section, float(section.area()))


def _over(body: PlanarBody, known: _Laid, face: int, edge: tuple[int, int]) -> _Laid:
    """Lay a face beside a known one, over the edge that they share."""
    flat = _flat(body, face)
    one, two = edge
    own = complex(*(flat[two] - flat[one]))
    wanted = complex(*(known.corners[two] - known.corners[one]))
    ratio = wanted / own
    ratio /= abs(ratio)
    turn = np.array(((ratio.real, -ratio.imag), (ratio.imag, ratio.real)))
    middle = (known.corners[one] + known.corners[two]) / 2
    return _laid(body, face, turn, middle - turn @ (flat[one] + flat[two]) / 2)


def _apart(one: _Laid, two: _Laid) -> bool:
    common = float((one.section ^ two.section).area())
    return common <= OVERLAP * min(one.area, two.area)


def _net(
    body: PlanarBody,
    laid: dict[int, _Laid],
    folded: list[tuple[int, int]],
    tab: float,
    tabbed: set[tuple[int, int]],
) -> Net:
    """Return a piece with its folds, cuts and tabs."""
    faces = tuple(laid)
    folds, valleys, cuts = [], [], []
    taken = [piece.section for piece in laid.values()]
    tabs: list[Array] = []
    owners: dict[tuple[int, int], list[int]] = {}
    for face in faces:
        for edge in _edges_of_face(body, face):
            owners.setdefault(edge, []).append(face)
    every = _sides(body)
    for edge, own in owners.items():
        if edge in folded:
            piece = laid[own[0]].corners
            folds.append((piece[edge[0]], piece[edge[1]]))
            valleys.append(_is_valley(body, own[0], own[1], edge))
            continue
        for face in own:
            corners = laid[face].corners
            ring = next(
                r for r in body.faces[face] if edge in sides_of(r) or edge[::-1] in sides_of(r)
            )
            start, end = edge if edge in sides_of(ring) else edge[::-1]
            cuts.append((corners[start], corners[end]))
            if tab > 0 and edge not in tabbed and len(every[edge]) == 2:
                made = _tab(corners[start], corners[end], tab, taken)
                if made is not None:
                    tabs.append(made)
                    tabbed.add(edge)
    return Net(
        faces,
        tuple(laid[face].rings for face in faces),
        np.array(folds, float).reshape(-1, 2, 2),
        np.array(valleys, bool),
        np.array(cuts, float).reshape(-1, 2, 2),
        tuple(tabs),
    )


def _is_valley(body: PlanarBody, one: int, two: int, edge: tuple[int, int]) -> bool:
    """Whether two faces fold towards the outside: the edge is a concave one."""
    start, end = _as_run(body, one, edge)
    along = body.vertices[end] - body.vertices[start]
    inward = np.cross(body.normals[one], along)
    return bool(inward @ body.normals[two] > 0)


def _as_run(body: PlanarBody, face: int, edge: tuple[int, int]) -> tuple[int, int]:
    """Return an edge in the direction in which a face runs it."""
    forward = any(edge in sides_of(ring) for ring in body.faces[face])
    return edge if forward else (edge[1], edge[0])


def _tab(start: Array, end: Array, width: float, taken: list[CrossSection]) -> Array | None:
    """Return a trapezoid outside an edge, narrower where there is less room; None if none is."""
    import manifold3d

    along = end - start
    length = float(np.linalg.norm(along))
    along = along / length
    out = np.array((along[1], -along[0]))
    for share in (1.0, 0.5, 0.25):
        deep = min(share * width, 0.4 * length)
        slant = min(SLANT * deep, 0.3 * length)
        made = np.array(
            (start, start + slant * along + deep * out, end - slant * along + deep * out, end)
        )
        section = manifold3d.CrossSection([made], manifold3d.FillRule.EvenOdd)
        if all(float((section ^ other).area()) <= OVERLAP * section.area() for other in taken):
            taken.append(section)
            return made
    return None


def _side_by_side(
    groups: Sequence[tuple[Array, ...]],
) -> tuple[tuple[Array, ...], ...]:
    """Move groups of rings so that they stand in a row, bottoms on one line."""
    sizes = [np.ptp(np.concatenate(rings), axis=0) for rings in groups]
    gap = GAP * max(float(size.max()) for size in sizes)
    at, moved = 0.0, []
    for rings, size in zip(groups, sizes, strict=True):
        low = np.concatenate(rings).min(axis=0)
        moved.append(tuple(ring - low + (at, 0.0) for ring in rings))
        at += float(size[0]) + gap
    return tuple(moved)


def face_curves(
    body: PlanarBody, where: Where = "ground", color: Color | None = None
) -> tuple[Curve, ...]:
    """Return the outlines of every face at true size, for SVG and DXF."""
    return tuple(
        _polyline(np.vstack((ring, ring[:1])), where, f"face {number + 1}", color)
        for number, rings in enumerate(laid_faces(body))
        for ring in rings
    )


def net_curves(
    unfolded: Sequence[Net], where: Where = "ground", color: Color | None = None
) -> tuple[Curve, ...]:
    """Return cuts, folds and tabs of nets side by side, to print and cut at true size."""
    groups = [(*(ring for rings in net.rings for ring in rings), *net.tabs) for net in unfolded]
    placed = _side_by_side(groups)
    curves = []
    for number, (net, group, moved) in enumerate(zip(unfolded, groups, placed, strict=True), 1):
        shift = moved[0][0] - group[0][0]
        name = f"net {number}"
        curves += [_polyline(cut + shift, where, f"{name} cuts", color) for cut in net.cuts]
        curves += [_polyline(tab + shift, where, f"{name} tabs", color) for tab in net.tabs]
        curves += [
            _polyline(fold + shift, where, f"{name} folds", FOLD_COLOR) for fold in net.folds
        ]
    return tuple(curves)


def _polyline(points: Array, where: Where, name: str, color: Color | None) -> Curve:
    """Return straight lines through points of the page as a curve of degree 1."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    knots = np.concatenate(((0.0, 0.0), np.cumsum(steps), (steps.sum(),)))
    space = np.zeros((len(points), 3))
    space[:, 0] = points[:, 0]
    space[:, 1 if where == "ground" else 2] = points[:, 1]
    closed = bool((points[0] == points[-1]).all())
    return Curve(1, knots, space, closed=closed, name=name, color=color)
