"""Textures in glTF: vertices with one place in the picture each, and the picture as PNG."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Bytes
from bozzetto.exchange.mesh.polygons import is_degenerate
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.texture import Texture
from bozzetto.images.png import png_bytes

LINEAR: Final = 9729
LINEAR_MIPMAP_LINEAR: Final = 9987
CLAMP_TO_EDGE: Final = 33071

SAMPLER: Final = {
    "magFilter": LINEAR,
    "minFilter": LINEAR_MIPMAP_LINEAR,
    "wrapS": CLAMP_TO_EDGE,
    "wrapT": CLAMP_TO_EDGE,
}


class Corners(NamedTuple):
    """Vertices of the file, made of those of a mesh.

    Attributes
    ----------
    vertex : (n,) int array
        The mesh's vertex that each of the file's is a copy of.
    faces : (f, 3) int array
        Into the file's vertices; without degenerate ones.
    places : (n, 2) float32 array or None
        Where each lies in the picture.
    before : (n,) int array or None
        The vertex before it was split there.
    """

    vertex: NDArray[np.intp]
    faces: NDArray[np.int64]
    places: NDArray[np.float32] | None
    before: NDArray[np.intp] | None = None


def corners_of(mesh: Mesh, texture: Texture | None) -> Corners:
    """Return the vertices of a mesh, split where the texture has a seam."""
    proper = ~is_degenerate(mesh.faces)
    faces = mesh.faces[proper].astype(np.int64)
    if texture is None:
        return Corners(np.arange(len(mesh.vertices)), faces, None)
    return _split(np.arange(len(mesh.vertices)), faces, texture.corners[proper])


def laid_out(corners: Corners, places: NDArray[np.float32]) -> Corners:
    """Return the file's vertices with places for a picture to come, split at its seams.

    Parameters
    ----------
    corners : Corners
        Without places.
    places : (f, 3, 2) float32 array
        Of the corners of its faces.
    """
    return _split(corners.vertex, corners.faces, places)


def _split(
    known: NDArray[np.intp], faces: NDArray[np.int64], corners: NDArray[np.float32]
) -> Corners:
    """Divide vertices such that each has one place; `known` are those of the mesh."""
    # + 0.0 makes the two zeros one, so that equal places have equal bits.
    places = np.ascontiguousarray(corners + np.float32(0.0)).reshape(-1, 2)
    _, first, place = np.unique(places.view(np.int64), return_index=True, return_inverse=True)
    pairs = faces.ravel() * len(first) + place.ravel()
    found, corner = np.unique(pairs, return_inverse=True)
    vertex, kind = np.divmod(found, len(first))
    return Corners(known[vertex], corner.reshape(-1, 3), places[first[kind]], vertex)


def flat_pixels(texture: Texture, base: tuple[int, int, int]) -> Bytes:
    """Return the pixels of a texture, blended over the base colour of the part."""
    share = texture.pixels[..., 3:].astype(np.float32) / np.float32(255)
    under = np.array(base, np.float32)
    flat = np.full_like(texture.pixels, 255)
    flat[..., :3] = np.rint(under + share * (texture.pixels[..., :3] - under))
    return flat


def picture_file(texture: Texture, base: tuple[int, int, int]) -> bytes:
    """Return a PNG of the texture, blended over the base colour of the part."""
    return png_bytes(flat_pixels(texture, base))
