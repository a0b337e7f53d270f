"""From an answer to a body whose faces lie exactly in planes.

Regularities are put on the normals of faces. If they would fuse corners or turn faces over, fewer
of them are taken, until the body keeps its shape; the planes are exact in every case.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.errors import UserError
from bozzetto.view import Camera
from bozzetto_polyhedron.model.state import Dimension
from bozzetto_polyhedron.reconstruction.answer import Answer, Rings
from bozzetto_polyhedron.solid.face_rings import (
    are_simple,
    area_vectors,
    bounds_volume,
    edges_of,
    flat_rings,
    signed_volume,
    turned_over,
)
from bozzetto_polyhedron.solid.planar_body import PlanarBody, on_axis_planes
from bozzetto_polyhedron.solid.plane_fit import (
    ACCEPTED,
    PlaneFit,
    Relations,
    fitted_planes,
    incidences,
)
from bozzetto_polyhedron.solid.regularities import (
    Regularities,
    principal_frame,
    regularities,
    rounded_frame,
)
from bozzetto_polyhedron.solid.typed_lengths import moved_planes

SNAPS: Final = (3.0, 1.5, 0.7)
"""Tolerances that are tried one after another, in standard deviations of a corner."""

SHORTEST: Final = 0.3
"""Share of its drawn length that every edge keeps."""

MOST_MOVE: Final = (5.0, 0.005)
"""A corner moves less than so many standard deviations and such a share of the size, across the
line of sight."""

MOVE_IN_SPACE: Final = 3.0
"""How much farther it may move where the line of sight is not known: depth is found less well."""

WORLD_ANGLE: Final = np.radians(3.0)
"""Angle from the world's axes within which a frame is rounded to them."""

PARALLEL_TYPED: Final = np.radians(12.0)
"""Angle within which two faces whose distance was typed are made parallel."""

SAME_DIRECTION: Final = 1e-12
"""Cosine from 1 within which two normals are parallel up to rounding."""

LEAST_AREA: Final = 1e-6
"""Area of a face as share of the square of the size, below which it has no plane."""


@dataclass(frozen=True)
class EqualLengths:
    """Two distances between parallel faces that are to be the same.

    Parameters
    ----------
    first, second : (int, int)
        Numbers of faces in the order of the answer.
    """

    first: tuple[int, int]
    second: tuple[int, int]


@dataclass(frozen=True, eq=False)
class _Drawn:
    """An answer in units of its own size, about its middle."""

    vertices: Array
    faces: tuple[Rings, ...]
    edges: Index
    pairs: Index
    areas: Array
    normals: Array
    closed: bool
    middle: Array
    size: float
    sight: Array | None
    noise: float


def exact_body(
    answer: Answer,
    *,
    noise: float,
    right_angles: bool = True,
    dimensions: Sequence[Dimension] = (),
    equal: Sequence[EqualLengths] = (),
    slanted: Sequence[int] = (),
    camera: Camera | None = None,
    up: Sequence[float] = (0.0, 0.0, 1.0),
) -> PlanarBody:
    """Return the nearest body with exact planes.

    Parameters
    ----------
    answer : Answer
        Corners in mm, in the world of the drawing's camera.
    noise : float
        Standard deviation of a corner, mm: that on the sheet over `camera.pixels_per_mm`.
    right_angles : bool
        Whether angles that are nearly right become right. Nearly parallel faces become parallel
        in any case.
    dimensions : sequence of Dimension
        Distances that hold to the last digits.
    equal : sequence of EqualLengths
        Distances that are the same, see `equal_lengths`.
    slanted : sequence of int
        Faces that keep the angles that were drawn, in the order of the answer.
    camera : Camera, optional
        Through which the drawing was made: what is seen of it is kept more strictly than depth.
    up : (x, y, z)
        Where the ground is not: of two faces whose distance is typed the lower one stays.

    Returns
    -------
    PlanarBody
        Faces in the order of the answer. Where the answer was inside out, rings are turned over.

    Raises
    ------
    UserError
        If the answer is no body, or dimensions contradict one another or turn a face over.
    """
    drawn = _checked(answer, noise, camera)
    typed = _typed_pairs(drawn, dimensions, equal)
    kept = [face for face in slanted if 0 <= face < len(drawn.faces)]
    fit, regular, told = _most_regular(drawn, right_angles, typed, kept)
    if typed:
        _refuse_slanted(fit.normals, typed)
        relations = _relations(drawn, fit.normals, dimensions, equal)
        fit = _with_lengths(drawn, fit, regular, relations, _directions(camera, up))
    return _in_world(drawn, fit, regular, told)


def _directions(camera: Camera | None, up: Sequence[float]) -> Array:
    """Return up, to the right and away from the eye, as rows: of planes, these give way first."""
    if camera is None:
        return np.array((up, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)))
    right, _, away = camera.axes
    return np.array((up, right, away))


def _with_lengths(
    drawn: _Drawn,
    fit: PlaneFit,
    regular: Regularities,
    relations: Relations,
    directions: Array,
) -> PlaneFit:
    """Return the fit with lengths that were typed; nothing else changes if that can be."""
    changes = relations.coefficients, relations.values - relations.coefficients @ fit.offsets
    moved = moved_planes(
        fit.vertices, drawn.pairs, drawn.edges, fit.normals, changes, directions, drawn.noise
    )
    if moved is not None:
        vertices, offsets = fit.vertices + moved[0], fit.offsets + moved[1]
        found = PlaneFit(vertices, fit.normals, offsets, fit.violation)
        if _keeps_shape(drawn, found, by_hand=False):
            return found
    found = fitted_planes(drawn.vertices, drawn.pairs, regular, relations, drawn.sight)
    if not found.violation <= ACCEPTED:
        raise UserError("These dimensions contradict one another. Change or take away one.")
    if not _keeps_shape(drawn, found, by_hand=False):
        raise UserError(
            "With this dimension faces would turn over or run into one another. Type another one."
        )
    return found


def _checked(answer: Answer, noise: float, camera: Camera | None) -> _Drawn:
    """Return what was drawn, refusing what is no body."""
    vertices = np.asarray(answer.vertices, float).reshape(-1, 3)
    if not np.isfinite(vertices).all() or not np.isfinite(noise) or noise < 0:
        raise UserError("This answer has corners that are nowhere. Choose another answer.")
    if not answer.faces or not all(answer.faces):
        raise UserError("This drawing has no faces yet. Draw lines until some close.")
    for face in answer.faces:
        for ring in face:
            if len(ring) < 3 or len(set(ring)) < len(ring):
                raise UserError("A face runs over a corner twice. Choose another answer.")
            if min(ring) < 0 or max(ring) >= len(vertices):
                raise UserError("A face has corners that were not drawn. Choose another answer.")
    used = np.unique([v for face in answer.faces for ring in face for v in ring])
    middle = vertices[used].mean(axis=0)
    with np.errstate(over="ignore"):
        size = 2.0 * float(np.linalg.norm(vertices[used] - middle, axis=1).max())
    if not 1e-150 < size < 1e75:
        raise UserError("This answer has no size. Choose another answer.")
    local = (vertices - middle) / size
    faces, closed = answer.faces, bounds_volume(answer.faces)
    if closed and signed_volume(local, faces) < 0:
        faces = turned_over(faces)
    areas = area_vectors(local, faces)
    lengths = np.linalg.norm(areas, axis=1)
    if (lengths < LEAST_AREA).any():
        raise UserError("A face of this answer has no area. Choose another answer.")
    sight = None
    if camera is not None:
        sight = (
            np.tile(camera.axes[2], (len(vertices), 1))
            if camera.kind == "orthographic"
            else _unit(vertices - np.asarray(camera.eye))
        )
    return _Drawn(
        local, faces, edges_of(faces), incidences(faces), lengths, areas / lengths[:, None],
        closed, middle, size, sight, noise / size,
    )  # fmt: skip


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _rings_are_simple(vertices: Array, faces: Sequence[Rings], normals: Array) -> bool:
    return all(
        are_simple(flat_rings(vertices, face, normal))
        for face, normal in zip(faces, normals, strict=True)
    )


def _typed_pairs(
    drawn: _Drawn, dimensions: Sequence[Dimension], equal: Sequence[EqualLengths]
) -> list[tuple[int, int]]:
    """Return the pairs of faces that lengths are measured between, checked."""
    pairs = [tuple(each.faces) for each in dimensions]
    pairs += [pair for each in equal for pair in (each.first, each.second)]
    for one, two in pairs:
        if not (0 <= one < len(drawn.faces) and 0 <= two < len(drawn.faces)) or one == two:
            raise UserError("A dimension needs two faces of this solid. Take it away.")
    for each in dimensions:
        if not (np.isfinite(each.length) and each.length > 0):
            raise UserError("A dimension needs a length above zero.")
    return [(one, two) for one, two in pairs]


def _refuse_slanted(normals: Array, pairs: Sequence[tuple[int, int]]) -> None:
    """Refuse lengths between faces that did not become parallel."""
    for one, two in pairs:
        if abs(normals[one] @ normals[two]) < 1.0 - SAME_DIRECTION:
            raise UserError("A dimension needs two parallel faces. Choose others.")


def _most_regular(
    drawn: _Drawn,
    right_angles: bool,
    typed: Sequence[tuple[int, int]],
    slanted: Sequence[int],
) -> tuple[PlaneFit, Regularities, tuple[str, ...]]:
    """Return the most regular fit that keeps the shape, and what to tell of it."""
    for regular, factor in _attempts(drawn, right_angles, typed, slanted):
        fit = fitted_planes(drawn.vertices, drawn.pairs, regular, _none(drawn), drawn.sight)
        if fit.violation <= ACCEPTED and _keeps_shape(drawn, fit, by_hand=True):
            return fit, regular, _told(regular, factor, right_angles, len(slanted))
    if not _rings_are_simple(drawn.vertices, drawn.faces, drawn.normals):
        raise UserError("Lines of a face cross one another. Choose another answer.")
    raise UserError(
        "The faces of this answer cannot be made plane. Choose another answer, or draw the"
        " corners again that are farthest off."
    )


def _attempts(
    drawn: _Drawn,
    right_angles: bool,
    typed: Sequence[tuple[int, int]],
    slanted: Sequence[int],
) -> Iterator[tuple[Regularities, float | None]]:
    """Give regularities to try, the most regular ones first."""
    near = [
        (one, two)
        for one, two in typed
        if abs(drawn.normals[one] @ drawn.normals[two]) > np.cos(PARALLEL_TYPED)
    ]
    frame = principal_frame(drawn.normals, drawn.areas) if right_angles else None
    roundings = ["none"]
    if frame is not None:
        ordered = rounded_frame(frame, "none")
        if (np.diag(ordered) > np.cos(2 * WORLD_ANGLE)).all():
            roundings = ["world", "none"]
        elif ordered[2, 2] > np.cos(2 * WORLD_ANGLE):
            roundings = ["vertical", "none"]
    for factor in (*SNAPS, None):
        tolerance = None if factor is None else factor * drawn.noise
        for rounding in roundings if tolerance is not None else ("none",):
            made = regularities(
                drawn.normals,
                drawn.areas,
                tolerance,
                right_angles=right_angles,
                rounding=rounding,
                parallel=near,
                slanted=slanted,
            )
            yield made, factor


def _none(drawn: _Drawn) -> Relations:
    return Relations(np.zeros((0, len(drawn.faces))), np.zeros(0))


def _relations(
    drawn: _Drawn, normals: Array, dimensions: Sequence[Dimension], equal: Sequence[EqualLengths]
) -> Relations:
    """Return dimensions and equal lengths as equations between offsets."""

    def difference(pair: tuple[int, int]) -> Array:
        one, two = pair
        row = np.zeros(len(drawn.faces))
        row[one], row[two] = 1.0, -np.sign(normals[one] @ normals[two])
        height = drawn.vertices[drawn.faces[one][0][0]] - drawn.vertices[drawn.faces[two][0][0]]
        return row if height @ normals[one] >= 0 else -row

    rows = [difference(each.faces) for each in dimensions]
    values = [each.length / drawn.size for each in dimensions]
    rows += [difference(each.first) - difference(each.second) for each in equal]
    values += [0.0] * len(equal)
    return Relations(np.array(rows), np.array(values))


def _keeps_shape(drawn: _Drawn, fit: PlaneFit, *, by_hand: bool) -> bool:
    """Whether no corners fused, no edge or face turned round, and no rings cross.

    Parameters
    ----------
    drawn : _Drawn
        The answer.
    fit : PlaneFit
        What became of it.
    by_hand : bool
        Whether corners have to stay near where the hand drew them; otherwise a person asked for
        other lengths.
    """
    before = drawn.vertices[drawn.edges[:, 1]] - drawn.vertices[drawn.edges[:, 0]]
    after = fit.vertices[drawn.edges[:, 1]] - fit.vertices[drawn.edges[:, 0]]
    if not ((before * after).sum(axis=1) > 0).all():
        return False
    turned = (area_vectors(fit.vertices, drawn.faces) * drawn.normals).sum(axis=1)
    if not (turned > 0).all():
        return False
    if by_hand:
        lengths = np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1)
        if not (lengths[1] >= SHORTEST * lengths[0]).all() or not _stays(drawn, fit):
            return False
    return _rings_are_simple(fit.vertices, drawn.faces, fit.normals)


def _stays(drawn: _Drawn, fit: PlaneFit) -> bool:
    """Whether all corners stay within what the hand may have missed."""
    moved = fit.vertices - drawn.vertices
    limit = MOST_MOVE[0] * drawn.noise + MOST_MOVE[1]
    if drawn.sight is None:
        limit *= MOVE_IN_SPACE
    else:
        moved = moved - (moved * drawn.sight).sum(axis=1, keepdims=True) * drawn.sight
    return bool((np.linalg.norm(moved, axis=1) < limit).all())


def _in_world(
    drawn: _Drawn, fit: PlaneFit, regular: Regularities, told: tuple[str, ...]
) -> PlanarBody:
    """Return the body in mm; corners take the coordinates of axis planes to the last digit."""
    vertices = fit.vertices * drawn.size + drawn.middle
    offsets = fit.offsets * drawn.size + fit.normals @ drawn.middle
    body = PlanarBody(
        vertices, drawn.faces, fit.normals, offsets, drawn.closed, regular.frame, told
    )
    return on_axis_planes(body)


def _told(
    regular: Regularities, factor: float | None, right_angles: bool, slanted: int
) -> tuple[str, ...]:
    """Tell what was made exact, and what had to be left."""
    count = len(regular.normals)
    said = []
    if regular.frame is not None:
        on = int((regular.freedom[regular.leader] == 0).sum())
        said.append(
            "All angles were made right."
            if on == count
            else f"Right angles were made between {on} of {count} faces; the others keep their"
            " slant."
        )
        if slanted:
            said.append(f"{slanted} of them because they were told to.")
        if (regular.frame == np.eye(3)).all():
            said.append("It stands along the axes of the world.")
    elif right_angles:
        said.append("No right angles were found.")
    if right_angles and factor != SNAPS[0]:
        said.append(
            "Some angles that are nearly right were left: corners would have moved too far."
        )
    return tuple(said)
