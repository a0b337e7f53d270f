"""Meshes for tests, with closed forms."""

from __future__ import annotations

import numpy as np

from bozzetto.geometry.mesh import Mesh
from bozzetto.scene import Layer, Scene

BOX_FACES = [
    (0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4),
    (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7),
]  # fmt: skip


def box(size=(2.0, 2.0, 2.0), center=(0.0, 0.0, 0.0)):
    ring = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    unit = np.array([(x, y, z) for z in (-1, 1) for x, y in ring], float)
    return Mesh((unit * np.array(size) / 2 + center).astype(np.float32), BOX_FACES)


def sphere(radius=1.0, fineness=64, center=(0.0, 0.0, 0.0), *, normals=False):
    u, v = np.meshgrid(
        np.linspace(0, np.pi, fineness + 1),
        np.linspace(0, 2 * np.pi, 2 * fineness + 1),
        indexing="ij",
    )
    unit = np.stack((np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)), -1).reshape(-1, 3)
    width = 2 * fineness + 1
    i = (np.arange(fineness)[:, None] * width + np.arange(2 * fineness)).ravel()
    faces = np.concatenate(
        (np.stack((i, i + width, i + 1), 1), np.stack((i + 1, i + width, i + width + 1), 1))
    )
    return Mesh(
        (radius * unit + center).astype(np.float32),
        faces,
        unit.astype(np.float32) if normals else None,
    )


def soup(seed, count):
    random = np.random.default_rng(seed)
    center = random.uniform(-10, 10, (count, 1, 3))
    corners = center + random.normal(0, 2, (count, 3, 3))
    return Mesh(corners.reshape(-1, 3).astype(np.float32), np.arange(3 * count).reshape(-1, 3))


def scene_of(*items, owner="m"):
    return Scene((Layer("l", tuple(items), owner),))
