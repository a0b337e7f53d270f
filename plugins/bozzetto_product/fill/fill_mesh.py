"""A fill as triangles, with the same vertices on an edge as every other fill that has it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import BSplineSurface, Mesh
from bozzetto.plugin import remembered
from bozzetto_product.fill.domain import Domain, cross, domain_of
from bozzetto_product.fill.domain_mesh import DomainMesh, mesh_over
from bozzetto_product.fill.edge_pieces import EdgePiece
from bozzetto_product.fill.half_sides import Side
from bozzetto_product.fill.quintic import DEGREE

FEWEST_SEGMENTS: Final = 3
"""Segments of a piece of an edge at least."""

MOST_SEGMENTS: Final = 64
"""Segments of a piece of an edge at most."""


ANGLE_STEP: Final = 0.35
"""Steps of the angles of the domain over which triangles are made, radians."""

STEP: Final = 1 / 24
"""Steps of the quarters of a half in that domain."""

FLAT: Final = 1e-6
"""Area that parameters span, as share of the largest of a patch, at which it has no normal yet."""


@remembered(limit=8000)
def piece_samples(piece: EdgePiece, segments: int) -> tuple[Array, Array]:
    """Return shares of a piece's range at about equal lengths, and the places there.

    Returns
    -------
    shares : (segments + 1,) float
        0 … 1, in the sense of the edge.
    places : (segments + 1, 3) float
        mm; the ends are the very control points.
    """
    begin, end = piece.curve.range
    fine = np.linspace(0.0, 1.0, 129)
    steps = np.linalg.norm(np.diff(piece.curve.value(begin + fine * (end - begin)), axis=0), axis=1)
    arc = np.concatenate(((0.0,), np.cumsum(steps)))
    even = np.linspace(0.0, 1.0, segments + 1)
    shares = np.interp(even * arc[-1], arc, fine) if arc[-1] > 0 else even
    shares[[0, -1]] = 0.0, 1.0
    places = piece.curve.value(begin + shares * (end - begin))
    places[[0, -1]] = piece.curve.control_points[[0, -1]]
    return shares, places


def segments_of(piece: EdgePiece, spacing: float) -> int:
    """Return into how many segments a piece is cut."""
    return int(np.clip(np.ceil(piece.length / spacing), FEWEST_SEGMENTS, MOST_SEGMENTS))


def mesh_of(
    sides: Sequence[Side],
    domain: Domain,
    patches: Sequence[BSplineSurface],
    spacing: float,
) -> Mesh:
    """Triangulate a fill.

    Parameters
    ----------
    sides : sequence of Side
        Head to tail.
    domain : Domain
        Of these sides.
    patches : sequence of BSplineSurface
        Of each corner.
    spacing : float
        Length of the segments of edges, mm.
    """
    steps, places, owners, parameters = boundary_samples(sides, spacing)
    flat = _flat_mesh(domain, steps)
    owners = np.concatenate((owners, flat.patches))
    parameters = np.concatenate((parameters, flat.parameters))
    vertices = np.empty((len(owners), 3))
    normals = np.empty((len(owners), 3))
    for number, patch in enumerate(patches):
        own = owners == number
        vertices[own], normals[own] = places_and_normals(patch, parameters[own])
    vertices[: len(places)] = places
    return Mesh(
        vertices.astype(np.float32), flat.triangles.astype(np.int32), normals.astype(np.float32)
    )


def _flat_mesh(domain: Domain, steps: Sequence[tuple[Array, Array]]) -> DomainMesh:
    """Return triangles over a domain, with the boundary vertices at steps along its halves.

    They are made over a domain like it, with sides as long as they have segments and with angles
    and steps rounded: it is the very same while a curve is dragged, and so are the triangles.
    Where that would turn one over, they are made over the domain itself.
    """
    counts = np.array([[len(half) - 1 for half in side] for side in steps], float)
    at, middles = domain.corners, domain.middles
    inner = _angles(np.roll(middles, 1, axis=0) - at, middles - at)
    outer = np.pi - _angles(at - middles, np.roll(at, -1, axis=0) - middles)
    angles, bends = (ANGLE_STEP * np.round(each / ANGLE_STEP) for each in (inner, outer))
    like = domain_of(counts, angles, bends)
    rounded = [(_rounded(first), _rounded(second)) for first, second in steps]
    made = mesh_over(like, _ring(like, rounded))
    ring = _ring(domain, steps)
    spots = np.einsum("nk,nkd->nd", *_shares(domain, made))
    a, b, c = (np.concatenate((ring, spots))[made.triangles[:, k]] for k in range(3))
    return made if cross(b - a, c - a).min(initial=np.inf) > 0.0 else mesh_over(domain, ring)


def _shares(domain: Domain, mesh: DomainMesh) -> tuple[Array, Array]:
    """Return the shares (n, 4) of the corners of quadrangles (n, 4, 2) in inner vertices."""
    u, v = mesh.parameters.T
    shares = np.stack(((1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v), axis=1)
    return shares, domain.quads[mesh.patches]


def _angles(one: Array, other: Array) -> Array:
    """Return the angles between vectors in the plane, (n,), 0 … π."""
    return np.asarray(np.abs(np.arctan2(cross(one, other), (one * other).sum(axis=1))))


def _rounded(steps: Array) -> Array:
    """Return rising steps, 0 … 1, of which the quarters are rounded."""
    even, quarters = np.linspace(0.0, 1.0, len(steps)), np.linspace(0.0, 1.0, 5)
    found = np.round(np.interp(quarters, even, steps) / STEP) * STEP
    return np.interp(even, quarters, found) if (np.diff(found) > 0.0).all() else steps


def _ring(domain: Domain, steps: Sequence[tuple[Array, Array]]) -> Array:
    """Return the boundary vertices once round a domain, (b, 2)."""
    after = np.roll(domain.corners, -1, axis=0)
    rows = []
    for number, (first, second) in enumerate(steps):
        middle = domain.middles[number]
        rows.append(domain.corners[number] + first[:-1, None] * (middle - domain.corners[number]))
        rows.append(after[number] + second[:0:-1, None] * (middle - after[number]))
    return np.concatenate(rows)


def places_and_normals(patch: BSplineSurface, parameters: Array) -> tuple[Array, Array]:
    """Return places, and unit normals, of a patch at parameters u and v, (n, 2)."""
    along_u = _basis_rows(patch.knots_u, parameters[:, 0])
    along_v = _basis_rows(patch.knots_v, parameters[:, 1])
    count = len(parameters)
    net = patch.control_points
    rows, slopes = ((rows @ net.reshape(len(net), -1)).reshape(count, -1, 3) for rows in along_u)
    values, by_v = (each[:, None] for each in along_v)
    across = cross_product((values @ slopes)[:, 0], (by_v @ rows)[:, 0])
    length = np.linalg.norm(across, axis=1)
    flat = length <= FLAT * length.max(initial=0.0)
    across /= np.where(flat, 1.0, length)[:, None]
    if flat.any():
        across[flat] = patch.normals(*parameters[flat].T)
    return (values @ rows)[:, 0], across


@remembered(limit=1000, key=lambda knots, at: (knots.tobytes(), at.tobytes()))
def _basis_rows(knots: Array, at: Array) -> tuple[Array, Array]:
    """Return values and slopes of all basis functions at parameters, (n, m) each."""
    from scipy.interpolate import BSpline

    spline = BSpline(knots, np.eye(len(knots) - DEGREE - 1), DEGREE)
    return np.asarray(spline(at)), np.asarray(spline(at, 1))


def boundary_samples(
    sides: Sequence[Side], spacing: float
) -> tuple[list[tuple[Array, Array]], Array, Array, Array]:
    """Return the boundary vertices once round.

    Returns
    -------
    steps : list of (Array, Array)
        Parameters along both halves of each side, from its corners to its middle.
    places : (b, 3) float
        mm.
    owners : (b,) int
        Patches.
    parameters : (b, 2) float
        In those patches.
    """
    places, owners, parameters = [], [], []
    count = len(sides)
    steps: list[Array] = []
    for number, side in enumerate(sides):
        for half, part in enumerate(side.halves):
            at, found = [], []
            for index, piece in enumerate(part.pieces):
                shares, here = piece_samples(piece.piece, segments_of(piece.piece, spacing))
                if piece.forward != part.onward:
                    shares, here = 1.0 - shares[::-1], here[::-1]
                low, high = part.breaks[index : index + 2]
                at.append(low + (high - low) * shares[:-1])
                found.append(here[:-1])
            last = part.pieces[-1]
            end = last.piece.curve.control_points[-1 if last.forward == part.onward else 0]
            along = np.append(np.concatenate(at), 1.0)
            rows = np.vstack((*found, end))
            steps.append(along)
            pair = np.column_stack((along, np.zeros(len(along))))
            if half:
                rows, pair = rows[::-1], pair[::-1, ::-1]
            places.append(rows[:-1])
            owners.append(np.full(len(rows) - 1, (number + half) % count))
            parameters.append(pair[:-1])
    return (
        list(zip(steps[::2], steps[1::2], strict=True)),
        np.concatenate(places),
        np.concatenate(owners),
        np.concatenate(parameters),
    )


def radius_ratios(mesh: Mesh) -> Array:
    """Return twice the inner over the outer radius of each triangle, 0 … 1."""
    return corner_ratios(mesh.vertices.astype(np.float64)[mesh.faces])


def corner_ratios(corners: Array) -> Array:
    """Return twice the inner over the outer radius of triangles by their corners, (n, 3, 3)."""
    a, b, c = (
        np.linalg.norm(corners[:, (k + 1) % 3] - corners[:, (k + 2) % 3], axis=1) for k in range(3)
    )
    product = a * b * c
    ratio = (b + c - a) * (c + a - b) * (a + b - c) / np.where(product > 0, product, 1.0)
    return np.clip(np.where(product > 0, ratio, 0.0), 0.0, 1.0)
