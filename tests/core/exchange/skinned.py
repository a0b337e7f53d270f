"""A tube that hangs on a row of joints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from bozzetto.geometry import Mesh, Rig, Skin, Solid, Texture


def tube(rows=40, round_=16, length=60.0, radius=5.0):
    """A closed tube along x with a point at each end."""
    x = np.linspace(0.0, length, rows)
    angle = np.arange(round_) * 2 * np.pi / round_
    rings = [[(a, radius * np.cos(t), radius * np.sin(t)) for t in angle] for a in x]
    vertices = np.array(rings).reshape(-1, 3)
    faces = []
    for i in range(rows - 1):
        for j in range(round_):
            a, b = i * round_ + j, i * round_ + (j + 1) % round_
            faces += [(a, a + round_, b), (b, a + round_, b + round_)]
    first, last = len(vertices), len(vertices) + 1
    end = (rows - 1) * round_
    for j in range(round_):
        faces += [(first, j, (j + 1) % round_), (last, end + (j + 1) % round_, end + j)]
    mesh = Mesh(np.vstack((vertices, [(-radius, 0, 0), (length + radius, 0, 0)])), faces)
    corners = mesh.vertices[mesh.faces].astype(float)
    if np.linalg.det(corners).sum() < 0:
        mesh = Mesh(mesh.vertices, mesh.faces[:, ::-1])
    return Mesh(mesh.vertices, mesh.faces, mesh.vertex_normals())


def skinned(joints=7, pose=None, name="worm", roots=(0,), texture=False, turned=False):
    """A tube on a row of joints, smoothly weighted; `pose` turns joint 2 about z, degrees.

    `turned` gives every joint axes of its own.
    """
    mesh = tube()
    places = np.column_stack((np.linspace(0, 60, joints), np.zeros((joints, 2))))
    turns = None
    if pose is not None:
        turns = np.tile([0.0, 0, 0, 1], (joints, 1))
        turns[2] = Rotation.from_euler("z", pose, degrees=True).as_quat()
        turns[1] = Rotation.from_euler("x", 33, degrees=True).as_quat()
    parents = [-1 if k in roots else k - 1 for k in range(joints)]
    names = tuple(f"{name} {k}" for k in range(joints))
    rig = Rig(places, parents, names, turns, cuts=[[0, joints - 1]])
    if turned:
        axes = Rotation.random(joints, random_state=5).as_matrix()
        rig = replace(rig, axes=axes)
    at = np.clip(mesh.vertices[:, 0] / 60.0 * (joints - 1), 0, joints - 1 - 1e-6)
    low = at.astype(int)
    share = at - low
    follow = np.column_stack((low, low + 1, 0 * low, 0 * low))
    weights = np.column_stack((1 - share, share, 0 * share, 0 * share))
    follow[weights == 0] = 0
    skin = Skin(rig, follow, weights, rest=None if pose is None else mesh)
    picture = None
    if texture:
        pixels = np.zeros((8, 8, 4), np.uint8)
        pixels[..., 3] = 255
        corners = np.random.default_rng(3).random((len(mesh.faces), 3, 2))
        picture = Texture(pixels, corners.astype(np.float32))
    return Solid(skin.posed(mesh), name, (200, 120, 60), texture=picture, skin=skin)
