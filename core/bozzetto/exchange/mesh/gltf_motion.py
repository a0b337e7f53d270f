"""Motion as glTF animations: of the nodes of rigid parts, and of the joints of skins."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.exchange.mesh.gltf_skin import local_places, local_turns
from bozzetto.exchange.mesh.polygons import without_degenerate
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.rig import Clip, Rig
from bozzetto.geometry.shapes import Shapes, Solid, Surface

RIGID: Final = 1e-4
"""Distance, in the extent of a part, by which its vertices may miss the nearest rigid motion."""

STILL: Final = 1e-7
"""Motion, in the extent of a part or rad, below which it counts as standing still."""

Put = Callable[..., int]
"""Adds an accessor of values, kind and component type, and gives its number."""


def filmed(
    frames: Sequence[Shapes], seconds: Sequence[float]
) -> tuple[Shapes, list[list[Placement]]]:
    """Return the first frame, with a clip of each skin, and where its parts are in each frame.

    Raises
    ------
    UserError
        If parts come, go, or change their shape.
    """
    drawn = [drawn_parts(frame) for frame in frames]
    return filmed_skins(drawn, seconds), rigid_motions(drawn)


def drawn_parts(shapes: Shapes) -> Shapes:
    """Return the parts of which there is anything to write."""
    parts = [part for part in shapes.meshes() if len(without_degenerate(part.mesh.faces))]
    return Shapes(
        solids=tuple(part for part in parts if isinstance(part, Solid)),
        surfaces=tuple(part for part in parts if isinstance(part, Surface)),
    )


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
            if start.skin is not None:
                known.append(Placement())  # its joints move: see `filmed_skins`
                continue
            before, after = start.mesh.vertices, part.mesh.vertices
            found = _nearest_motion(before, after) if len(before) == len(after) else None
            if found is None:
                raise UserError(
                    f"“{part.name}” changes its shape while it moves, which cannot be "
                    "written here. A film of it can be a GIF."
                )
            known.append(found)
    return motions


def filmed_skins(frames: Sequence[Shapes], seconds: Sequence[float]) -> Shapes:
    """Return the first frame with the poses of all frames as a clip of each skin.

    Raises
    ------
    UserError
        If a skin has other joints in a later frame.
    """
    rows = [list(frame.meshes()) for frame in frames]
    found: list[Solid | Surface] = []
    for number, part in enumerate(rows[0]):
        skin = part.skin
        if skin is not None:
            skins = [row[number].skin for row in rows]
            rigs = [one.rig for one in skins if one is not None and one.rig.names == skin.rig.names]
            if len(rigs) < len(frames):
                raise UserError(f"The joints of “{part.name}” change while it moves.")
            still = np.tile([0.0, 0.0, 0.0, 1.0], (len(skin.rig.joints), 1))
            turns = [still if rig.turns is None else rig.turns for rig in rigs]
            shifts = [np.zeros_like(rig.joints) if rig.shifts is None else rig.shifts
                      for rig in rigs]  # fmt: skip
            moved = any(rig.shifts is not None for rig in rigs)
            clip = Clip(
                "motion",
                np.asarray(seconds, float),
                np.array(turns),
                np.array(shifts) if moved else None,
            )
            part = replace(part, skin=replace(skin, clips=(clip,)))
        found.append(part)
    return replace(
        frames[0],
        solids=tuple(part for part in found if isinstance(part, Solid)),
        surfaces=tuple(part for part in found if isinstance(part, Surface)),
    )


def add_clip(
    animations: dict[str, dict[str, Any]],
    clip: Clip,
    rig: Rig,
    first: int,
    put: Put,
    component: int,
) -> None:
    """Add the rotations and shifts of a rig's joints to the animation of their clip's name.

    Parameters
    ----------
    animations : dict of str to dict
        By name; a new one is added where there is none.
    clip, rig : Clip, Rig
        In the file's axes and unit.
    first : int
        Number of the first joint's node.
    put : callable
        Adds an accessor of values to the file.
    component : int
        The file's number of single precision.
    """
    none = np.tile([0.0, 0.0, 0.0, 1.0], (len(rig.joints), 1))
    still, turns = (np.array(local_turns(rig, rows)) for rows in (none, clip.turns))
    rows = [("rotation", "VEC4", turns, (turns != still).any(axis=(0, 2)))]
    if clip.shifts is not None:
        places = local_places(rig, clip.shifts)
        away = (places != local_places(rig, None)).any(axis=(0, 2))
        rows.insert(0, ("translation", "VEC3", places, away))
    turns = nearest(turns)
    if not any(moving.any() for *_, moving in rows):
        return
    times = clip.seconds.astype("<f4").reshape(-1, 1)
    keys = put(times, "SCALAR", component, min=times[0].tolist(), max=times[-1].tolist())
    known = animations.setdefault(clip.name, {"name": clip.name, "samplers": [], "channels": []})
    for path, kind, values, moving in rows:
        for joint in np.flatnonzero(moving).tolist():
            target = {"node": first + joint, "path": path}
            known["channels"].append({"sampler": len(known["samplers"]), "target": target})
            output = put(values[:, joint].astype("<f4"), kind, component)
            known["samplers"].append({"input": keys, "output": output, "interpolation": "LINEAR"})


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
        if all(is_still(pose) for pose in poses):
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

    return nearest(np.asarray(Rotation.from_matrix(turns).as_quat()))


def nearest(turns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return quaternions, (t, …, 4), each the one of its rotation that is near the one before."""
    flips = np.where((turns[1:] * turns[:-1]).sum(axis=-1) < 0.0, -1.0, 1.0)
    return np.concatenate((turns[:1], turns[1:] * np.cumprod(flips, axis=0)[..., None]))


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


def is_still(pose: Placement) -> bool:
    """Whether a pose is where its part began."""
    turned = float(np.abs(np.subtract(pose.rotation, np.eye(3).ravel())).max())
    return turned < STILL and float(np.abs(pose.offset).max()) < STILL
