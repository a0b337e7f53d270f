"""The nodes of a car that a camera sees, judged by the directions of the patches."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.view import Camera
from bozzetto_car.template.model import Template

GRAZING: Final = 0.08
"""Least cosine between a patch's normal and the ray to the eye: at less than five degrees a
patch is too narrow in the sketch for anybody to tell where it ends."""

SAME_SIDE: Final = 0.1
"""Least cosine in plan between the direction to the eye and that from which a node is seen best:
the rear end of a roof may face an eye ahead of the car, but nobody can tell it there."""


def facing(template: Template, positions: Array, camera: Camera) -> Flags:
    """Whether nodes are in front of the camera and face it, and wheels are on its side, (n,).

    A node with any patch that faces the camera faces it. A node that another part of the car
    hides counts as seen: on a nearly convex car these are few.

    Parameters
    ----------
    template : Template
        The template of the car.
    positions : (n, 3) float
        Nodes of the car, mm.
    camera : Camera
        The view.
    """
    if camera.kind == "orthographic":
        toward = np.broadcast_to(-camera.axes[2], positions.shape)
    else:
        toward = np.asarray(camera.eye) - positions
        lengths = np.linalg.norm(toward, axis=1, keepdims=True)
        toward = toward / np.where(lengths > 0.0, lengths, 1.0)
    loops = np.array([patch.nodes for patch in template.patches])
    corners = positions[loops]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    sizes = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.where(sizes > 0.0, sizes, 1.0)
    seen = np.zeros(len(positions), bool)
    cosines = np.einsum("kij,kj->ki", toward[loops], normals)
    seen[loops[cosines > GRAZING]] = True
    wheels = template.wheels.ravel()
    seen[wheels] = toward[wheels, 1] * np.sign(positions[wheels, 1]) > GRAZING
    in_front = camera.view_space(positions)[:, 2] > 0.0
    return seen & (in_front | (camera.kind == "orthographic"))


def on_their_side(template: Template, positions: Array, camera: Camera) -> Flags:
    """Whether a camera is on the side from which nodes are seen best, whether it sees them or not.

    Parameters
    ----------
    template : Template
        The template of the car; its pictures tell from where each is seen best.
    positions : (n, 3) float
        Nodes of the car, mm.
    camera : Camera
        The view.

    Returns
    -------
    (n,) bool
    """
    toward = np.asarray(camera.eye) - positions.mean(axis=0)
    if camera.kind == "orthographic":
        toward = -camera.axes[2]
    best = np.array([template.pictures[name].toward_eye for name in template.names])[:, :2]
    size = np.linalg.norm(best, axis=1) * np.linalg.norm(toward[:2])
    along = best * toward[:2]
    # The picture of a node in the middle is from one side, and the other side shows as much.
    along[template.centre, 1] = np.abs(along[template.centre, 1])
    return np.asarray(along.sum(axis=1) >= SAME_SIDE * size)
