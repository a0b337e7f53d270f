"""Key frames of glTF animations, read: where nodes are at each time."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from bozzetto.arrays import Array
from bozzetto.errors import FormatError
from bozzetto.exchange.mesh.gltf_scene import AnimationRecord, Gltf, Node, Place, Sampler, item
from bozzetto.exchange.mesh.gltf_values import Blobs, values_of

WIDTHS: Final = {"translation": 3, "rotation": 4, "scale": 3}

PIECES: Final = 8
"""Straight pieces in the place of a curve between two keys."""


def moved_nodes(animation: AnimationRecord) -> set[int]:
    """Return the nodes whose place an animation changes."""
    return {
        channel.target.node
        for channel in animation.channels
        if channel.target.node is not None and channel.target.path in WIDTHS
    }


def key_times(
    gltf: Gltf, blobs: Blobs, animation: AnimationRecord, nodes: Collection[int]
) -> Array:
    """Return all times at which the motion of some nodes has a key, growing, s.

    Curves get `PIECES` between two keys, and steps a time just before each key.

    Raises
    ------
    FormatError
        If the file is damaged.
    """
    rows = []
    for channel in animation.channels:
        if channel.target.node not in nodes or channel.target.path not in WIDTHS:
            continue
        sampler: Sampler = item(animation.samplers, channel.sampler, "sampler")
        times = _times(gltf, blobs, sampler)
        if sampler.interpolation == "CUBICSPLINE" and len(times) > 1:
            share = np.arange(PIECES) / PIECES
            between = times[:-1, None] + share * np.diff(times)[:, None]
            times = np.append(between.ravel(), times[-1])
        elif sampler.interpolation == "STEP":
            before = np.nextafter(times[1:].astype(np.float32), np.float32(-np.inf))
            times = np.concatenate((times, before.astype(np.float64)))
        rows.append(times)
    return np.unique(np.concatenate(rows))


def node_matrices(
    gltf: Gltf,
    blobs: Blobs,
    animation: AnimationRecord,
    chain: Sequence[int],
    places: Mapping[int, Place],
    times: Array,
) -> dict[int, Array]:
    """Return the matrix of each node at each time, (k, 4, 4), in the axes of the scene.

    Parameters
    ----------
    gltf, blobs, animation
        The file and its motion.
    chain : sequence of int
        Nodes, each after the one that it is in.
    places : mapping of int to Place
        All nodes of the scene.
    times : (k,) array
        s.

    Raises
    ------
    FormatError
        If the file is damaged.
    """
    moved: dict[tuple[int, str], Array] = {}
    for channel in animation.channels:
        node, path = channel.target.node, channel.target.path
        if node in chain and node is not None and path in WIDTHS:
            sampler = item(animation.samplers, channel.sampler, "sampler")
            moved[node, path] = _values_at(gltf, blobs, sampler, path, times)
    found: dict[int, Array] = {}
    for node in chain:
        own = _local(gltf.nodes[node], node, moved, len(times))
        parent = places[node].parent
        found[node] = own if parent < 0 else found[parent] @ own
        if not np.isfinite(found[node]).all():
            raise FormatError("A motion is not finite.")
    return found


def _local(node: Node, number: int, moved: Mapping[tuple[int, str], Array], count: int) -> Array:
    """Return the matrix of a node in its parent at each time, (k, 4, 4)."""
    made = np.tile(np.eye(4), (count, 1, 1))
    if node.matrix is not None:
        made[:] = np.reshape(node.matrix, (4, 4)).T
        return made

    def known(path: str, still: Sequence[float]) -> Array:
        found = moved.get((number, path))
        return np.tile(np.array(still), (count, 1)) if found is None else found

    turns = Rotation.from_quat(known("rotation", node.rotation)).as_matrix()
    made[:, :3, :3] = turns * known("scale", node.scale)[:, None]
    made[:, :3, 3] = known("translation", node.translation)
    return made


def _times(gltf: Gltf, blobs: Blobs, sampler: Sampler) -> Array:
    times = values_of(gltf, blobs, sampler.input, 1)[:, 0]
    if not len(times) or not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
        raise FormatError("The times of a motion do not grow.")
    return times


def _values_at(gltf: Gltf, blobs: Blobs, sampler: Sampler, path: str, times: Array) -> Array:
    """Return the values of a sampler at times, (k, 3 or 4); before and after its keys they stay."""
    keys = _times(gltf, blobs, sampler)
    values = values_of(gltf, blobs, sampler.output, WIDTHS[path])
    curved = sampler.interpolation == "CUBICSPLINE"
    if len(values) != len(keys) * (3 if curved else 1) or not np.isfinite(values).all():
        raise FormatError("A motion has not as many values as times.")
    when = np.clip(times, keys[0], keys[-1])
    if (
        path == "rotation"
        and not (np.linalg.norm(values[1::3] if curved else values, axis=1) > 0).all()
    ):
        raise FormatError("A motion turns a node by nothing.")
    before = np.clip(np.searchsorted(keys, when, side="right") - 1, 0, len(keys) - 1)
    if sampler.interpolation == "STEP":
        return values[before]
    after = np.minimum(before + 1, len(keys) - 1)
    span = keys[after] - keys[before]
    share = np.divide(when - keys[before], span, out=np.zeros(len(when)), where=span > 0.0)
    if curved:
        incoming, points, leaving = values.reshape(len(keys), 3, -1).transpose(1, 0, 2)
        t, d = share[:, None], span[:, None]
        return np.asarray(
            (2 * t**3 - 3 * t**2 + 1) * points[before]
            + d * (t**3 - 2 * t**2 + t) * leaving[before]
            + (-2 * t**3 + 3 * t**2) * points[after]
            + d * (t**3 - t**2) * incoming[after]
        )
    if path == "rotation" and len(keys) > 1:
        return np.asarray(Slerp(keys, Rotation.from_quat(values))(when).as_quat())
    mixed = (1.0 - share[:, None]) * values[before] + share[:, None] * values[after]
    return np.asarray(mixed)
