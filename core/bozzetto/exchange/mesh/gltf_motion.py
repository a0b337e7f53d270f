"""Motion of rigid parts as a glTF animation: translation and rotation of each part's node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.shapes import Shapes

RIGID: Final = 1e-4
"""Distance, in the extent of a part, by which its vertices may miss the nearest rigid motion."""

STILL: Final = 1e-7
"""Motion, in the extent of a part or rad, below which it counts as standing still."""

Put = Callable[..., int]
"""Adds an accessor of values, kind and component type, and gives its number."""


def rigid_motions(frames: Sequence[Shapes]) -> list[list[Placement]]:
    """Return where each part is in each frame, as seen from the first, part by part.

    Parameters
    ----------
    frames : sequence of Shapes
        The same parts in the same order, with the same vertices.

    Raises
    ------
    UserError
        If parts come, go, or change their shape.
    """
    first = tuple(frames[0].meshes())
    motions: list[list[Placement]] = [[] for _ in first]
    for frame in frames:
        parts = tuple(frame.meshes())
        if [part.name for part in parts] != [part.name for part in first]:
            raise UserError("Parts come or go while it moves. A film of them can be a GIF.")
        for part, start, known in zip(parts, first, motions, strict=True):
            before, after = start.mesh.vertices, part.mesh.vertices
            found = _nearest_motion(before, after) if len(before) == len(after) else None
            if found is None:
                raise UserError(
                    f"“{part.name}” changes its shape while it moves, which cannot be "
                    "written here. A film of it can be a GIF."
                )
            known.append(found)
    return motions


def animation(
    motions: Sequence[Sequence[Placement]],
    seconds: Sequence[float],
    change: Placement,
    put: Put,
    component: int,
) -> dict[str, Any] | None:
    """Return the animation of nodes 0, 1, …; None where none of them moves.

    Parameters
    ----------
    motions : sequence of sequence of Placement
        For each node where it is at each time.
    seconds : sequence of float
        Times, growing.
    change : Placement
        From our axes and units to the file's.
    put : callable
        Adds an accessor of values to the file.
    component : int
        The file's number of single precision.
    """
    samplers: list[dict[str, Any]] = []
    channels: list[dict[str, Any]] = []
    back = change.inverse()
    times = np.asarray(seconds, "<f4").reshape(-1, 1)
    keys: int | None = None
    for node, motion in enumerate(motions):
        poses = [change.after(pose).after(back) for pose in motion]
        if all(_is_still(pose) for pose in poses):
            continue
        if keys is None:
            keys = put(times, "SCALAR", component, min=times[0].tolist(), max=times[-1].tolist())
        places = np.array([pose.offset for pose in poses], "<f4")
        turns = quaternions(np.array([pose.rotation for pose in poses]).reshape(-1, 3, 3))
        for path, kind, values in (
            ("translation", "VEC3", places),
            ("rotation", "VEC4", turns.astype("<f4")),
        ):
            channels.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
            samplers.append(
                {"input": keys, "output": put(values, kind, component), "interpolation": "LINEAR"}
            )
    if not channels:
        return None
    return {"name": "motion", "samplers": samplers, "channels": channels}


def quaternions(turns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return unit quaternions (t, 4), x y z w, of rotations (t, 3, 3), each near the one before."""
    from scipy.spatial.transform import Rotation

    made = Rotation.from_matrix(turns).as_quat()
    flips = np.where(np.einsum("ti,ti->t", made[1:], made[:-1]) < 0.0, -1.0, 1.0)
    made[1:] *= np.cumprod(flips)[:, None]
    return np.asarray(made)


def _nearest_motion(before: NDArray[Any], after: NDArray[Any]) -> Placement | None:
    """Return the rigid motion that takes vertices to others (Kabsch 1976); None where none does."""
    one, other = np.asarray(before, float), np.asarray(after, float)
    if np.array_equal(one, other):
        return Placement()
    middle, there = one.mean(axis=0), other.mean(axis=0)
    left, _, right = np.linalg.svd((other - there).T @ (one - middle))
    turn = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    offset = there - turn @ middle
    extent = float(np.ptp(one, axis=0).max())
    if float(np.abs(one @ turn.T + offset - other).max()) > RIGID * extent:
        return None
    x, y, z = (float(value) for value in offset)
    return Placement(tuple(float(value) for value in turn.ravel()), 1.0, (x, y, z))


def _is_still(pose: Placement) -> bool:
    turned = float(np.abs(np.subtract(pose.rotation, np.eye(3).ravel())).max())
    return turned < STILL and float(np.abs(pose.offset).max()) < STILL
