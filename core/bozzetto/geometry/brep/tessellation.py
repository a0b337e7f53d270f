"""Triangles for exact shapes: for the viewport, and for files that hold meshes only.

Every edge is sampled once, for both of its faces, so what is closed stays closed. Each face is
triangulated in its parameters: whole cells of a grid inside, and between them and the trimming
loops a constrained Delaunay triangulation that adds no corner.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, Index, frozen
from bozzetto.errors import UserError
from bozzetto.geometry.basis import span_parameters
from bozzetto.geometry.brep.shared_sides import FaceTriangles, with_single_sides
from bozzetto.geometry.brep.triangulation import triangulated
from bozzetto.geometry.kept_answers import kept
from bozzetto.geometry.mesh import Mesh

if TYPE_CHECKING:
    from bozzetto.geometry.brep.brep import Brep, Face, Trim
    from bozzetto.geometry.brep.surface import BSplineSurface
    from bozzetto.geometry.curve import Curve

TOLERANCE: Final = 1e-4
"""Usual distance of triangles from the surface, per diagonal of what is shown."""

MOST_DIVISIONS: Final = 256
"""Most steps in a span of a surface or an edge, whatever the tolerance asks for."""

LEAST_STEPS: Final = 4
"""Steps of a curved edge, at least: so a loop of one or two edges is no line."""

MOST_CELLS: Final = 1 << 20
"""Most cells of a face's grid, whatever the tolerance asks for."""

PROBES: Final = 4
"""Places in every span at which second derivatives are looked at."""

ROUNDS: Final = 3
"""How often faces that turn out to be too coarse are divided further."""

PLACES: Final = frozen(
    [[1 / 3, 1 / 3, 1 / 3], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5]], np.float64
)
"""Places in a triangle at which it is compared with the surface, as shares of its corners."""

STRAIGHT: Final = 1e-9
"""Bend of a span, as share of the size, that counts as none."""


def brep_mesh(brep: Brep, tolerance: float | None = None) -> Mesh:
    """Triangulate within a distance of the surfaces, closed wherever faces share an edge.

    Parameters
    ----------
    brep : Brep
        The faces.
    tolerance : float, optional
        mm, above 0; by default `TOLERANCE` of the size. Kept unless a span would need more than
        `MOST_DIVISIONS` steps, or a face more than `MOST_CELLS`.

    Returns
    -------
    Mesh
        Without normals, so that vertices on creases are shared as well.

    Raises
    ------
    UserError
        If the tolerance is not above 0.
    """
    mesh, _ = counted_mesh(brep, tolerance)
    return mesh


def counted_mesh(brep: Brep, tolerance: float | None = None) -> tuple[Mesh, tuple[int, ...]]:
    """Triangulate as `brep_mesh`, and tell how many triangles each face has, in their order."""
    vertices, faces = _triangles(brep, _tolerance(brep, tolerance))
    rows = np.concatenate([face.vertices[face.triangles] for face in faces])
    mesh = Mesh(vertices.astype(np.float32), rows.astype(np.int32))
    return mesh, tuple(len(face.triangles) for face in faces)


def shaded_brep(brep: Brep, tolerance: float | None = None) -> Mesh:
    """Triangulate for display: every face by itself with exact normals, so that creases show.

    The triangles are those of `brep_mesh`; parameters as there.
    """
    rows = shaded_faces(brep, tolerance)
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in rows[:-1])])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in rows]),
        np.concatenate([m.faces + start for m, start in zip(rows, starts, strict=True)]),
        np.concatenate([mesh.vertex_normals() for mesh in rows]),
    )


def shaded_faces(brep: Brep, tolerance: float | None = None) -> tuple[Mesh, ...]:
    """Triangulate for display: a mesh with exact normals for each face, in their order.

    Parameters as in `brep_mesh`.
    """
    vertices, faces = _triangles(brep, _tolerance(brep, tolerance))
    return tuple(
        Mesh(
            vertices[made.vertices].astype(np.float32),
            made.triangles.astype(np.int32),
            _normals(face, made).astype(np.float32),
        )
        for face, made in zip(brep.faces, faces, strict=True)
    )


def face_meshes(brep: Brep, tolerance: float | None = None) -> tuple[Mesh, ...]:
    """Triangulate each face by itself; edges have the same places on both sides.

    Parameters as in `brep_mesh`.
    """
    vertices, faces = _triangles(brep, _tolerance(brep, tolerance))
    found = []
    for face in faces:
        used, rows = np.unique(face.vertices[face.triangles], return_inverse=True)
        found.append(Mesh(vertices[used].astype(np.float32), rows.reshape(-1, 3).astype(np.int32)))
    return tuple(found)


def _tolerance(brep: Brep, tolerance: float | None) -> float:
    if tolerance is not None:
        if not tolerance > 0:
            raise UserError("The tolerance of triangles must be above zero.")
        return tolerance
    points = np.concatenate([f.surface.control_points.reshape(-1, 3) for f in brep.faces])
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    return TOLERANCE * size or TOLERANCE


def _triangles(brep: Brep, tolerance: float) -> tuple[Array, list[FaceTriangles]]:
    """Return vertices (n, 3), mm, and the triangles of each face; finer where that turns out."""
    finer = np.ones(len(brep.faces))
    for _ in range(ROUNDS):
        vertices, faces = _divided(brep, tolerance, finer)
        off = [
            _deviation(face, made, vertices) / tolerance
            for face, made in zip(brep.faces, faces, strict=True)
        ]
        if max(off) <= 1.0:
            break
        finer *= np.where(np.array(off) > 1.0, np.sqrt(np.maximum(off, 1.0)) * 1.2, 1.0)
    return vertices, faces


def _normals(face: Face, made: FaceTriangles) -> Array:
    """Return the exact normals at the corners of a face's triangles, (n, 3)."""
    surface, at = face.surface, made.parameters
    return kept(surface, ("normals", at.tobytes()), lambda: surface.normals(*at.T))


def _deviation(face: Face, made: FaceTriangles, vertices: Array) -> float:
    """Return the largest distance of triangles from the surface: of their middles and sides."""
    surface = face.surface
    if surface.is_plane or not len(made.triangles):
        return 0.0
    corners = vertices[made.vertices]

    def largest() -> float:
        at, flat, normals = (
            np.einsum("pk,tkd->ptd", PLACES, values[made.triangles]).reshape(-1, values.shape[1])
            for values in (made.parameters, corners, _normals(face, made))
        )
        off = np.einsum("nk,nk->n", surface.value(*at.T) - flat, normals)
        return float(np.abs(off).max())

    parts = (made.parameters, corners, made.triangles)
    return kept(surface, ("deviation", *(part.tobytes() for part in parts)), largest)


def _divided(brep: Brep, tolerance: float, finer: Array) -> tuple[Array, list[FaceTriangles]]:
    grids = [
        _Grid.of(face, tolerance, float(more)) for face, more in zip(brep.faces, finer, strict=True)
    ]
    at = _edge_parameters(brep, grids, tolerance)
    corners, ends, poles = brep.vertices
    places, count = [corners], len(corners)
    on_edge = []
    for edge, t, (start, end) in zip(brep.edges, at, ends.tolist(), strict=True):
        inner = count + np.arange(len(t) - 2)
        on_edge.append(np.concatenate(([start], inner, [end])))
        places.append(_places(edge, t))
        count += len(inner)
    faces = []
    for f, (face, grid) in enumerate(zip(brep.faces, grids, strict=True)):
        rings, numbers = [], []
        for k, loop in enumerate(face.loops):
            ring, own = [], []
            for i, trim in enumerate(loop):
                if trim.edge is None:
                    t = _pole_parameters(trim.curve.value(np.array(trim.curve.range)), grid)
                    t = trim.curve.range[0] + t * (trim.curve.range[1] - trim.curve.range[0])
                    names = np.full(len(t), poles[f, k, i])
                else:
                    t, names = at[trim.edge], on_edge[trim.edge]
                step = 1 if trim.forward else -1
                ring.append(_run(trim, t)[::step][:-1])
                own.append(names[::step][:-1])
            rings.append(np.concatenate(ring))
            numbers.append(np.concatenate(own))
        inside, found, triangles = _filled(face.surface, rings, grid)
        names = np.concatenate((*numbers, count + np.arange(len(inside))))
        count += len(inside)
        places.append(found)
        known = names[triangles]
        apart = (known != np.roll(known, 1, axis=1)).all(axis=1)  # at poles some are nothing
        faces.append(FaceTriangles(np.concatenate((*rings, inside)), names, triangles[apart]))
    vertices = np.concatenate(places)
    return with_single_sides(vertices, faces, [face.surface for face in brep.faces])


def _places(edge: Curve, t: Array) -> Array:
    """Return places of an edge without its ends, (n − 2, 3)."""
    return kept(edge, ("places", t.tobytes()), lambda: edge.value(t[1:-1]))


def _run(trim: Trim, t: Array) -> Array:
    """Return u and v of a side at parameters of its edge, (n, 2)."""
    curve = trim.curve
    return kept(curve, ("run", t.tobytes()), lambda: curve.value(np.clip(t, *curve.range)))


def _filled(surface: BSplineSurface, rings: list[Array], grid: _Grid) -> tuple[Array, Array, Index]:
    """Return u, v and places of corners inside of rings, and triangles with these behind them."""

    def filled() -> tuple[Array, Array, Index]:
        inner_at, triangles = triangulated([grid.indexed(ring) for ring in rings], grid.counts)
        inside = grid.parameters(inner_at)
        return inside, surface.value(*inside.T), triangles

    return kept(surface, ("filled", grid, *(ring.tobytes() for ring in rings)), filled)


# -- how finely --------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Grid:
    """Lines of a face's parameters between which the surface is nearly flat.

    Coordinates in the grid count its lines: a cell is a unit square.
    """

    lines: tuple[Array, Array]
    scales: tuple[float, float] | None
    """mm per unit of u and v, for a plane, which needs no lines."""

    @classmethod
    def of(cls, face: Face, tolerance: float, finer: float) -> _Grid:
        """Return the grid of a face.

        A triangle with legs of a and b in u and v is nowhere further from the surface than
        (a² M_uu + 2 a b M_uv + b² M_vv) / 8, where M bound the second derivatives (Filip,
        Magedson & Markot 1986, "Surface algorithms using bounds on derivatives"); and 2 a b is
        at most a² + b². Here they are looked at in some places of each span.
        """
        surface = face.surface
        question = ("grid", tolerance, finer)
        return kept(surface, question, lambda: cls._over(surface, tolerance, finer))

    @classmethod
    def _over(cls, surface: BSplineSurface, tolerance: float, finer: float) -> _Grid:
        breaks = [np.unique(knots) for knots in surface.knots]
        if surface.is_plane:
            net = surface.control_points
            wide = [np.linalg.norm(net[1, 0] - net[0, 0]), np.linalg.norm(net[0, 1] - net[0, 0])]
            scales = [float(w) / float(np.ptp(b)) for w, b in zip(wide, breaks, strict=True)]
            return cls((breaks[0], breaks[1]), (scales[0], scales[1]))
        u, v = (
            span_parameters(degree, knots, PROBES)
            for degree, knots in zip(surface.degrees, surface.knots, strict=True)
        )
        all_u, all_v = (values.ravel() for values in np.meshgrid(u, v, indexing="ij"))
        normals = surface.normals(all_u, all_v)
        bends = {}
        for order in ((2, 0), (1, 1), (0, 2)):
            bent = surface.derivative(all_u, all_v, *order)
            # Along the surface a second derivative only moves parameters.
            across = np.abs(np.einsum("nk,nk->n", bent, normals))
            size = np.where(normals.any(axis=1), across, np.linalg.norm(bent, axis=1))
            bends[order] = size.reshape(len(u), len(v))
        widths = [np.diff(b) for b in breaks]
        every = []
        for axis, (order, width) in enumerate(zip(((2, 0), (0, 2)), widths, strict=True)):
            bent = np.maximum.reduceat(
                bends[order].max(axis=1 - axis), PROBES * np.arange(len(width))
            )
            after = bends[order].max(axis=1 - axis)[PROBES::PROBES]
            twist = float(bends[1, 1].max()) * float(widths[1 - axis].max())
            wanted = (np.maximum(bent, after) * width**2 + twist * width) / (4.0 * tolerance)
            wanted[wanted * 4.0 * tolerance <= STRAIGHT * surface.size] = 0.0
            steps = np.clip(np.ceil(finer * np.sqrt(wanted)), 1, MOST_DIVISIONS).astype(np.intp)
            every.append(steps)
        few = min(1.0, np.sqrt(MOST_CELLS / (float(every[0].sum()) * float(every[1].sum()))))
        lines = [
            _lines(places, np.maximum(1, (few * steps).astype(np.intp)))
            for places, steps in zip(breaks, every, strict=True)
        ]
        return cls((lines[0], lines[1]), None)

    @property
    def counts(self) -> tuple[int, int]:
        """Cells in u and in v; none on a plane."""
        if self.scales is not None:
            return 0, 0
        return len(self.lines[0]) - 1, len(self.lines[1]) - 1

    def indexed(self, parameters: Array) -> Array:
        """Return coordinates in the grid of u and v, (n, 2)."""
        if self.scales is not None:
            return parameters * self.scales
        rows = [
            np.interp(parameters[:, k], lines, np.arange(float(len(lines))))
            for k, lines in enumerate(self.lines)
        ]
        return np.stack(rows, axis=1)

    def parameters(self, indexed: Array) -> Array:
        """Return u and v of crossings of lines, from their numbers (n, 2)."""
        numbers = indexed.astype(np.intp)
        return np.stack([self.lines[k][numbers[:, k]] for k in range(2)], axis=1)


def _lines(breaks: Array, steps: Index) -> Array:
    """Return lines at equal steps of every span, a number of steps for each."""
    rows = [
        np.linspace(low, high, int(count) + 1)[:-1]
        for low, high, count in zip(breaks[:-1], breaks[1:], steps, strict=True)
    ]
    return np.append(np.concatenate(rows), breaks[-1])


def _edge_parameters(brep: Brep, grids: list[_Grid], tolerance: float) -> list[Array]:
    """Return the parameters at which each edge is sampled, its ends among them.

    Fine enough for the chord and for the cells of both faces.
    """
    probes = [_probes(edge) for edge in brep.edges]
    steps = [
        kept(edge, ("steps", tolerance), partial(_chord_steps, edge, t, tolerance)).copy()
        for edge, t in zip(brep.edges, probes, strict=True)
    ]
    for face, grid in zip(brep.faces, grids, strict=True):
        for trim in face.trims:
            if trim.edge is None or grid.scales is not None:
                continue
            own = kept(trim.curve, ("cells", grid), partial(_cell_steps, trim, grid, probes))
            np.maximum(steps[trim.edge], own, out=steps[trim.edge])
    return [
        _lines(np.unique(edge.knots), np.clip(count, 1, MOST_DIVISIONS))
        for edge, count in zip(brep.edges, steps, strict=True)
    ]


def _probes(edge: Curve) -> Array:
    """Return the parameters at which an edge is looked at."""
    return kept(edge, "probes", lambda: span_parameters(edge.degree, edge.knots, 4 * PROBES))


def _cell_steps(trim: Trim, grid: _Grid, probes: list[Array]) -> Index:
    """Return how many cells of a grid every span of an edge goes through."""
    assert trim.edge is not None
    run = grid.indexed(trim.curve.value(np.clip(probes[trim.edge], *trim.curve.range)))
    moved = np.abs(np.diff(run, axis=0)).reshape(-1, 4 * PROBES, 2).sum(axis=1).max(axis=1)
    return np.asarray(np.ceil(moved - 1e-6), np.intp)


def _chord_steps(edge: Curve, at: Array, tolerance: float) -> Index:
    """Return steps for every span of an edge after which chords are near enough."""
    along, bent = edge.derivative(at, 1), edge.derivative(at, 2)
    # Along the curve a second derivative only moves parameters.
    speed = np.linalg.norm(along, axis=1, keepdims=True)
    unit = along / np.where(speed > 0, speed, 1.0)
    bent = np.linalg.norm(bent - (bent * unit).sum(axis=1, keepdims=True) * unit, axis=1)
    spans = np.diff(np.unique(edge.knots))
    each = 4 * PROBES
    most = np.maximum(
        np.maximum.reduceat(bent[:-1], each * np.arange(len(spans))), bent[each::each]
    )
    steps = np.ceil(spans * np.sqrt(most / (8.0 * tolerance)))
    least = np.ceil(LEAST_STEPS / len(spans)) if edge.degree > 1 else 1
    return np.asarray(np.clip(steps, least, MOST_DIVISIONS), np.intp)


def _pole_parameters(ends: Array, grid: _Grid) -> Array:
    """Return shares of the way along a pole's side at which it has corners."""
    moved = np.abs(np.diff(grid.indexed(ends), axis=0)).max()
    return np.linspace(0.0, 1.0, max(1, int(np.ceil(moved - 1e-6))) + 1)
