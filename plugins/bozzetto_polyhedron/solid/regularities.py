"""Regularities of faces: one frame of right angles, pencils about its axes, shared normals.

They belong to the normals of faces and never to vertices, so that none can fuse two corners.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.solid.face_rings import tangents

NEARLY_RIGHT: Final = 0.2
"""Cosine of the angle between two faces below which they may span the frame."""

ON_FRAME: Final = np.radians(8.0)
"""Angle within which a face supports a frame while frames are compared."""

LEAST_ANGLE: Final = np.radians(3.0)
"""Angle from an axis within which even the largest face is snapped: the error of a careful
hand."""

MOST_ANGLE: Final = np.radians(14.0)
"""Angle beyond which no face is snapped, however small: a slope of 1 in 4 is meant."""

MOST_PENCIL_ANGLE: Final = np.radians(10.0)
"""The same for an oblique face that is to stay perpendicular to an axis."""

PARALLEL: Final = np.radians(4.0)
"""Angle within which two large oblique faces are parallel."""

MAJORITY: Final = 0.7
"""Share of the area on the frame from which an object counts as orthogonal throughout."""

ORTHOGONAL_LIMIT: Final = np.radians(18.0)
"""Angle within which every face of such an object is snapped."""

PROCRUSTES_ROUNDS: Final = 5
"""Rounds in which the frame and the faces that it explains settle."""


@dataclass(frozen=True, eq=False)
class Regularities:
    """Which normals are fixed, which may turn, and which are one.

    Parameters
    ----------
    normals : (f, 3) float64
        Unit normals to start from; those without freedom are final.
    turns : (f, 2, 3) float64
        Directions into which a normal may turn; rows beyond its freedom are 0.
    freedom : (f,) intp
        0 on the frame, 1 in the pencil about an axis, 2 free. 0, too, for followers.
    leader : (f,) intp
        Face whose normal it shares; its own number if none.
    sign : (f,) float64
        1 or −1: which way it shares it.
    frame : (3, 3) float64, optional
        Rows are the axes, right-handed.
    """

    normals: Array
    turns: Array
    freedom: Index
    leader: Index
    sign: Array
    frame: Array | None


def principal_frame(normals: Array, areas: Array) -> Array | None:
    """Return the orthonormal frame that explains most area of faces, rows are axes.

    Parameters
    ----------
    normals : (f, 3) float
        Unit normals.
    areas : (f,) float
        mm².

    Returns
    -------
    (3, 3) float or None
        None where no two faces are nearly perpendicular.
    """
    one, two = np.tril_indices(len(normals), -1)
    across = np.abs(np.einsum("pk,pk->p", normals[one], normals[two])) < NEARLY_RIGHT
    one, two = one[across], two[across]
    if not len(one):
        return None
    third = np.cross(normals[one], normals[two])
    third /= np.linalg.norm(third, axis=1, keepdims=True)
    frames = np.stack((normals[one], np.cross(third, normals[one]), third), axis=1)
    nearest = np.abs(np.einsum("fk,pak->pfa", normals, frames)).max(axis=2)
    explained = (nearest > np.cos(ON_FRAME)) @ areas
    best = int((explained > explained.max() * (1.0 - 1e-9)).argmax())
    return np.asarray(frames[best])


def regularities(
    normals: Array,
    areas: Array,
    tolerance: float | None,
    *,
    right_angles: bool,
    rounding: str = "none",
    parallel: Sequence[tuple[int, int]] = (),
    slanted: Sequence[int] = (),
) -> Regularities:
    """Find what is regular about faces.

    Parameters
    ----------
    normals : (f, 3) float
        Unit normals as drawn.
    areas : (f,) float
        Of the faces.
    tolerance : float or None
        Length by which a corner may be wrong, in the root of the unit of `areas`; None leaves all
        normals free.
    right_angles : bool
        Whether a frame is looked for.
    rounding : {"none", "vertical", "world"}
        Whether the frame is rounded to the world's vertical or to all of its axes.
    parallel : sequence of (int, int)
        Faces that share a normal in any case.
    slanted : sequence of int
        Faces that are to keep their angles: they are turned into no frame and no pencil.
    """
    count = len(normals)
    kind = np.full(count, -1)
    made = normals.copy()
    frame = None
    sizes = np.sqrt(areas)
    if tolerance is not None and right_angles:
        frame = principal_frame(normals, areas)
    if frame is not None and tolerance is not None:
        frame, on = _settled_frame(frame, normals, areas, tolerance / sizes)
        on[list(slanted)] = False
        frame = rounded_frame(frame, rounding)
        cosines = normals @ frame.T
        axis = np.abs(cosines).argmax(axis=1)
        kind[on] = axis[on]
        made[on] = (np.sign(cosines[np.arange(count), axis])[:, None] * frame[axis])[on]
        _into_pencils(made, kind, frame, tolerance / sizes, slanted)
    leader, sign = _shared(made, areas, kind, tolerance, sizes, parallel)
    freedom = np.where(kind >= 3, 1, np.where(kind >= 0, 0, 2))
    freedom[leader != np.arange(count)] = 0
    turns = np.zeros((count, 2, 3))
    for face in np.flatnonzero(freedom):
        if freedom[face] == 1 and frame is not None:
            turns[face, 0] = np.cross(frame[kind[face] - 3], made[face])
        else:
            turns[face] = tangents(made[face])
    return Regularities(made, turns, freedom, leader, sign, frame)


def rounded_frame(frame: Array, rounding: str) -> Array:
    """Return a frame with its axes ordered x, y, z by the world, and rounded to it if asked.

    The vertical axis is the one nearest to the world's.
    """
    up = int(np.abs(frame[:, 2]).argmax())
    z = frame[up] * (1.0 if frame[up, 2] >= 0 else -1.0)
    others = np.delete(frame, up, axis=0)
    first = int(np.abs(others[:, 0]).argmax())
    x = others[first] * (1.0 if others[first, 0] >= 0 else -1.0)
    if rounding == "world":
        return np.eye(3)
    if rounding == "vertical":
        z = np.array([0.0, 0.0, 1.0])
        x = np.array([x[0], x[1], 0.0])
        x /= np.linalg.norm(x)
    rows = np.stack((x, np.cross(z, x), z))
    return np.asarray(1.5 * rows - 0.5 * rows @ rows.T @ rows)  # orthonormal to the last digit


def _settled_frame(frame: Array, normals: Array, areas: Array, slack: Array) -> tuple[Array, Flags]:
    """Return the frame by weighted Procrustes over the faces it explains, and which those are."""
    limit = np.cos(np.minimum(MOST_ANGLE, LEAST_ANGLE + slack))
    for _ in range(PROCRUSTES_ROUNDS):
        cosines = normals @ frame.T
        axis = np.abs(cosines).argmax(axis=1)
        nearest = np.abs(cosines).max(axis=1)
        on = nearest > limit
        if areas[on].sum() > MAJORITY * areas.sum() and (nearest > np.cos(ORTHOGONAL_LIMIT)).all():
            on = np.ones(len(normals), bool)
        signs = np.sign(cosines[np.arange(len(normals)), axis])
        moment = np.zeros((3, 3))
        np.add.at(moment, axis[on], (areas * signs)[on, None] * normals[on])
        left, _, right = np.linalg.svd(moment)
        handed = np.sign(np.linalg.det(left @ right))
        frame = left @ np.diag([1.0, 1.0, handed]) @ right
    return frame, on


def _into_pencils(
    made: Array, kind: Index, frame: Array, slack: Array, slanted: Sequence[int]
) -> None:
    """Turn oblique normals that are nearly perpendicular to an axis so that they are."""
    for face in np.setdiff1d(np.flatnonzero(kind < 0), slanted):
        cosines = frame @ made[face]
        axis = int(np.abs(cosines).argmin())
        if abs(cosines[axis]) < np.sin(min(MOST_PENCIL_ANGLE, LEAST_ANGLE + slack[face])):
            turned = made[face] - cosines[axis] * frame[axis]
            made[face] = turned / np.linalg.norm(turned)
            kind[face] = 3 + axis


def _shared(
    made: Array,
    areas: Array,
    kind: Index,
    tolerance: float | None,
    sizes: Array,
    parallel: Sequence[tuple[int, int]],
) -> tuple[Index, Array]:
    """Let parallel oblique faces share one normal; return leaders and signs."""
    count = len(made)
    leader, sign = np.arange(count), np.ones(count)
    asked = {(max(pair), min(pair)) for pair in parallel}
    for pair in asked:
        for face, other in (pair, pair[::-1]):
            if kind[other] in (0, 1, 2) and kind[face] not in (0, 1, 2):
                kind[face] = kind[other]
                made[face] = np.sign(made[face] @ made[other]) * made[other]
    for face in range(count):
        if kind[face] in (0, 1, 2):
            continue
        for other in range(face):
            if leader[face] != face:
                break
            if kind[other] != kind[face] and (face, other) not in asked:
                continue
            near = tolerance is not None and abs(made[face] @ made[other]) > np.cos(
                PARALLEL + tolerance / min(sizes[face], sizes[other])
            )
            if near or (face, other) in asked:
                leader[face] = leader[other]
                sign[face] = np.sign(made[face] @ made[leader[other]])
    for head in np.unique(leader):
        members = np.flatnonzero(leader == head)
        if len(members) > 1 and kind[head] not in (0, 1, 2):
            mean = ((areas * sign)[members, None] * made[members]).sum(axis=0)
            made[head] = mean / np.linalg.norm(mean)
        made[members] = sign[members, None] * made[head]
    return leader, sign
