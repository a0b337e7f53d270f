"""A skin over curves in space: a sphere that is shrunk and subdivided onto them.

After the last pages of Kara and Shimada's slides (CAD 2008), which show a sphere round a wireframe
being shrunk, subdivided and *anchored* in concave places, and Kobbelt et al., *A shrink wrapping
approach to remeshing polygonal surfaces* (1999), from which the alternation of attraction,
relaxation and subdivision comes. What is drawn over is no surface here but curves with nothing
between them, so the curves pull at the skin and not the skin at the curves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import UserError
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.mesh_places import closest_on_mesh
from bozzetto.geometry.wrap.anchors import choose_anchors, flip_to_links
from bozzetto.geometry.wrap.closest_on_icosphere import closest_on_icosphere
from bozzetto.geometry.wrap.icosphere import Icosphere, icosphere
from bozzetto.geometry.wrap.thin_plate import even_energy, hold_at, pull_towards, true_energy
from bozzetto.geometry.wrap.wireframe import MIRROR, Wireframe, wireframe

if TYPE_CHECKING:
    from bozzetto.arrays import Array

Checkpoint = Callable[[float, str], None]

SHRINK_WRAP_LEVELS: Final = (3, 6)
"""Fewest and most subdivisions of the icosahedron that can be asked for: 642 to 40,962 vertices."""

START: Final = 3
"""Level at which the sphere begins to shrink: 642 vertices get anywhere in a few rounds. The
coarsest skins begin one level below."""

FINE: Final = 5
"""Level for which places along curves lie close enough; one below can do with every other."""

FIRST_ROUNDS: Final = 8
"""Searches for nearest places on the first level; deeper ones each time."""

NEXT_ROUNDS: Final = 2
"""Searches for nearest places on each of the next levels."""

ANCHOR_ROUNDS: Final = 2
"""Rounds in which vertices are chosen that are fixed to curves."""

SLACK: Final = 1e-2
"""Tension of the skin while it is shrunk, per pull of a curve at a vertex."""

GIVE: Final = 1e-3
"""Bending of the skin on the first level while it is shrunk, per pull of a curve at a vertex."""

STIFFER: Final = 4.0
"""Ratio of the bending on a level to that before: the same bend takes up twice as many edges."""

HOLD: Final = 16.0
"""Bending per tension while curves are made edges of the skin: over four edges."""

DEEPEST: Final = 0.5
"""Depth within the hull, per diagonal of the box about all curves, that no place exceeds."""

REACHED: Final = 1.2
"""Distance, per usual edge, within which a curve counts as reached by the skin."""

EDGE: Final = 0.56
"""Usual length of an edge of the icosahedron about curves, per diagonal of their box; on each
level it is half of that before."""


def _nobody(fraction: float, step: str) -> None:
    """Ignore progress that no one watches."""


def shrink_wrap(
    curves: Sequence[ArrayLike],
    *,
    level: int = 5,
    tightness: float = 1.0,
    smoothing: float = 0.2,
    checkpoint: Checkpoint = _nobody,
) -> Mesh:
    """Draw a closed skin over curves.

    Where curves can be reached they become edges of the skin, and their ends and corners vertices
    of it. Curves that are symmetric about the plane y = 0, to 10⁻⁴ of their extent, have a skin
    that is symmetric to the last bit.

    Parameters
    ----------
    curves : sequence of (n, 3) array_like
        Polylines, mm.
    level : int
        Subdivisions of the icosahedron, within `SHRINK_WRAP_LEVELS`; a skin has
        ``10 · 4^level + 2`` vertices.
    tightness : float
        0 … 1: how far into concave places the skin is anchored, as a share of half the diagonal
        of the box about the curves. With 0 it only wraps what stands out.
    smoothing : float
        0 … 1: the square root of the distance, per diagonal of the box about the curves, over
        which the skin bends. With 0 it is taut as a soap film and breaks over the curves;
        with 1 it goes over them smoothly and bulges between.
    checkpoint : callable
        Called with the fraction done and a word between steps; may raise, to stop.

    Returns
    -------
    Mesh
        Closed, of genus 0, seen from outside counter-clockwise, without normals.

    Raises
    ------
    UserError
        If there is nothing to wrap (see `wireframe`), or no skin with an inside was found.
    ValueError
        If a parameter is out of range.
    """
    if not (
        SHRINK_WRAP_LEVELS[0] <= level <= SHRINK_WRAP_LEVELS[1]
        and 0 <= tightness <= 1
        and 0 <= smoothing <= 1
    ):
        raise ValueError("a level, a tightness or a smoothing that there is not")
    checkpoint(0.0, "Reading the curves")
    frame = wireframe(curves).every(2 ** max(0, FINE - level))
    vertices = _shrunk(frame, level, tightness, checkpoint)
    vertices, faces = _anchored(frame, level, vertices, smoothing, checkpoint)
    checkpoint(1.0, "Skin")
    mesh = Mesh((vertices * frame.size + frame.centre).astype(np.float32), faces)
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    if not np.einsum("ij,ij->", a, np.cross(b, c)) > 0:
        raise UserError(
            "No skin with an inside was found for these curves. "
            "Ask for more detail, or add curves that lead round the shape."
        )
    return mesh


def curve_distances(curves: Sequence[ArrayLike], mesh: Mesh) -> Array:
    """Return how far places at even steps along curves are from a surface.

    Parameters
    ----------
    curves : sequence of (n, 3) array_like
        As for `shrink_wrap`, mm.
    mesh : Mesh
        With at least one face.

    Returns
    -------
    (n,) float
        mm; of symmetric curves for one side.
    """
    frame = wireframe(curves)
    return closest_on_mesh(mesh, frame.places * frame.size + frame.centre).distances


def _shrunk(frame: Wireframe, level: int, tightness: float, checkpoint: Checkpoint) -> Array:
    """Return a surface of the wanted level near the curves, shrunk towards them level by level."""
    start = START if level > START + 1 else START - 1
    vertices = _around(icosphere(start), frame)
    bending = GIVE
    for now in range(start, level):
        sphere = icosphere(now)
        points = frame.every(2 ** max(0, level - now)).both_sides()
        energy = even_energy(now, SLACK, bending)
        rounds = FIRST_ROUNDS if now == start else NEXT_ROUNDS
        for done in range(1, rounds + 1):
            checkpoint(0.5 * (now - start + done / rounds) / (level - start), "Shrinking")
            feet = closest_on_icosphere(sphere, vertices, points)
            share = done / rounds if now == start else 1.0
            limit = _edge(now) + share * tightness * DEEPEST
            pulling = (feet.distances <= limit) | feet.outside(vertices, points)
            feet = feet.taken(pulling)
            near = feet.vertices
            weights = 1.0 / np.bincount(near, minlength=len(vertices))[near]
            vertices = _evened(sphere, pull_towards(energy, feet, points[pulling], weights), frame)
        vertices = icosphere(now + 1).refined(vertices)
        bending *= STIFFER
    return vertices


def _anchored(
    frame: Wireframe, level: int, vertices: Array, smoothing: float, checkpoint: Checkpoint
) -> tuple[Array, NDArray[np.int32]]:
    """Return the surface with the curves that it has reached as its edges, and smooth between."""
    sphere = icosphere(level)
    energy = even_energy(level, 1.0, HOLD)
    for done in range(ANCHOR_ROUNDS):
        checkpoint(0.55 + 0.1 * done, "Anchoring")
        reached = closest_on_icosphere(sphere, vertices, frame.places).distances < REACHED * _edge(
            level
        )
        anchors = choose_anchors(sphere, vertices, frame, reached)
        held = hold_at(energy, anchors.vertices, anchors.places)
        vertices = _evened(sphere, held, frame)
    checkpoint(0.8, "Smoothing")
    faces = flip_to_links(sphere.faces, anchors.links)
    energy = true_energy(faces, vertices, smoothing**2)
    held = hold_at(energy, anchors.vertices, anchors.places)
    return _evened(sphere, held, frame), faces.astype(np.int32)


def _edge(level: int) -> float:
    return EDGE * 0.5**level


def _around(sphere: Icosphere, frame: Wireframe) -> Array:
    """Return the sphere shrunk until its tangent planes touch a curve: nearly the hull."""
    points = frame.both_sides()
    half = 0.5 * np.ptp(points, axis=0)
    centre = points.mean(axis=0)
    if frame.symmetric:
        centre[1] = 0.0
    support = ((points - centre) / half @ sphere.directions.T).max(axis=0)
    facing = sphere.directions @ sphere.directions.T
    ahead = facing > 0
    radius = np.where(ahead, support / np.where(ahead, facing, 1.0), np.inf).min(axis=1)
    return np.asarray(centre + sphere.directions * radius[:, None] * half)


def _evened(sphere: Icosphere, vertices: Array, frame: Wireframe) -> Array:
    """Return the mean of a surface and its mirror image, if it should be symmetric."""
    if not frame.symmetric:
        return vertices
    return np.asarray(0.5 * (vertices + vertices[sphere.mirrored] * MIRROR))
