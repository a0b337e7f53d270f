"""All triangles of several meshes as one soup in the frame of the view, clipped."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Flags, Floats
from bozzetto.scene.renderer.normals import corner_normals

if TYPE_CHECKING:
    from bozzetto.geometry.mesh import Mesh
    from bozzetto.geometry.texture import Texture
    from bozzetto.scene.renderer.view_transform import ViewTransform

Triples = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Soup:
    """Triangles on the sheet.

    Attributes
    ----------
    places : (v, 3) float
        x, y (px) and nearness of each vertex.
    faces : (t, 3) int32
        Into `places` and `colors`.
    normals : (n, 3) float32
        In the frame of the view: right, up, towards the eye.
    corners : (t, 3) int32
        Into `normals`.
    colors : (v, 4) float32
        RGBA 0 … 255 of vertices that have a colour of their own; else zeros.
    part : (t,) int32
        Which mesh each triangle comes from.
    texels : (t, 3, 2) float32 or None
        Places of the corners in the mesh's texture, 0 to 1; None if no mesh has one.
    """

    places: Array
    faces: Triples
    normals: Floats
    corners: Triples
    colors: Floats
    part: Triples
    texels: Floats | None = None

    def only(self, keep: Flags) -> Soup:
        """Return the soup without some of its triangles."""
        return Soup(
            self.places,
            self.faces[keep],
            self.normals,
            self.corners[keep],
            self.colors,
            self.part[keep],
            None if self.texels is None else self.texels[keep],
        )

    def doubled_areas(self) -> Array:
        """Return twice the signed area of each triangle, px²; positive where it shows its front."""
        x, y = (self.places[:, axis][self.faces] for axis in (0, 1))
        return np.asarray(
            (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0]) - (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0])
        )


def gather(
    meshes: Sequence[Mesh],
    colors: Sequence[NDArray[np.generic] | None],
    sight: ViewTransform,
    textures: Sequence[Texture | None] = (),
) -> Soup:
    """Bring meshes onto the sheet.

    Parameters
    ----------
    meshes : sequence of Mesh
        The meshes, in the world.
    colors : sequence of (v, 4) array or None
        RGBA 0 … 255 of each mesh's vertices, where they have any.
    sight : ViewTransform
        The transform of the window.
    textures : sequence of Texture or None, optional
        That of each mesh, where it has one.
    """
    prepared = [corner_normals(mesh) for mesh in meshes]
    sizes = [len(mesh.vertices) for mesh in meshes]
    kinds = [len(one.vectors) for one in prepared]
    vertex_shift = np.cumsum([0, *sizes])
    normal_shift = np.cumsum([0, *kinds])
    faces = [mesh.faces + vertex_shift[k] for k, mesh in enumerate(meshes)]
    corners = [one.corners + normal_shift[k] for k, one in enumerate(prepared)]
    tints = [
        np.zeros((size, 4), np.float32) if own is None else own.astype(np.float32)
        for size, own in zip(sizes, colors, strict=True)
    ]
    towards = sight.axes.T.astype(np.float32) * np.array((1, 1, -1), np.float32)
    seen = sight.seen(_joined([mesh.vertices for mesh in meshes], np.float64, 3))
    soup = Soup(
        seen,
        _joined(faces, np.int32, 3),
        _joined([one.vectors for one in prepared], np.float32, 3) @ towards,
        _joined(corners, np.int32, 3),
        _joined(tints, np.float32, 4),
        np.repeat(np.arange(len(meshes), dtype=np.int32), [len(mesh.faces) for mesh in meshes]),
        _texels(meshes, textures),
    )
    if sight.perspective:
        soup = _clipped(soup, sight.near)
    return replace(soup, places=sight.placed(soup.places))


def _texels(meshes: Sequence[Mesh], textures: Sequence[Texture | None]) -> Floats | None:
    if all(texture is None for texture in textures):
        return None
    return np.concatenate(
        [
            np.zeros((len(mesh.faces), 3, 2), np.float32) if texture is None else texture.corners
            for mesh, texture in zip(meshes, textures, strict=True)
        ]
    )


def _joined(arrays: Sequence[NDArray[np.generic]], dtype: type, columns: int) -> NDArray:  # type: ignore[type-arg]
    return np.concatenate([np.zeros((0, columns), dtype), *arrays]).astype(dtype, copy=False)


def _clipped(soup: Soup, near: float) -> Soup:
    """Return the part of the triangles that lies beyond the near plane."""
    shown = (soup.places[:, 2] >= near)[soup.faces]
    count = shown.sum(1)
    if (count == 3).all():
        return soup
    whole = soup.only(count == 3)
    pieces = [whole]
    for corners_shown in (1, 2):
        cut = soup.only(count == corners_shown)
        if not len(cut.faces):
            continue
        # Turn each triangle so that the odd corner comes first.
        odd = np.argmax(shown[count == corners_shown] == (corners_shown == 1), axis=1)
        turned = (odd[:, None] + np.arange(3)) % 3
        cut = replace(
            cut,
            faces=np.take_along_axis(cut.faces, turned, 1),
            corners=np.take_along_axis(cut.corners, turned, 1),
            texels=None
            if cut.texels is None
            else np.take_along_axis(cut.texels, turned[..., None], 1),
        )
        pieces.append(_cut(cut, near, keep_first=corners_shown == 1))
    return _merged(pieces)


def _cut(soup: Soup, near: float, *, keep_first: bool) -> Soup:
    """Return one or two triangles for each whose first corner lies alone on its side."""
    faces, corners, texels = soup.faces, soup.corners, soup.texels
    a, depth = faces[:, 0], soup.places[:, 2]
    count = len(faces)
    places, normals, colors, ends = [], [], [], []
    for k in (1, 2):
        b = faces[:, k]
        t = ((near - depth[a]) / (depth[b] - depth[a]))[:, None]
        cut = soup.places[a] + t * (soup.places[b] - soup.places[a])
        cut[:, 2] = near
        places.append(cut)
        n_a, n_b = soup.normals[corners[:, 0]], soup.normals[corners[:, k]]
        normals.append((n_a + t * (n_b - n_a)).astype(np.float32))
        colors.append((soup.colors[a] + t * (soup.colors[b] - soup.colors[a])).astype(np.float32))
        if texels is not None:
            ends.append((texels[:, 0] + t * (texels[:, k] - texels[:, 0])).astype(np.float32))
    two = np.arange(count, dtype=np.int32)
    on_ab, on_ac = len(soup.places) + two, len(soup.places) + count + two
    n_ab, n_ac = len(soup.normals) + two, len(soup.normals) + count + two
    if keep_first:
        new_faces = np.stack((a, on_ab, on_ac), 1)
        new_corners = np.stack((corners[:, 0], n_ab, n_ac), 1)
        part = soup.part
        if texels is not None:
            texels = np.stack((texels[:, 0], *ends), 1)
    else:
        b, c = faces[:, 1], faces[:, 2]
        at_b, at_c = corners[:, 1], corners[:, 2]
        new_faces = np.concatenate((np.stack((on_ab, b, c), 1), np.stack((on_ab, c, on_ac), 1)))
        new_corners = np.concatenate(
            (np.stack((n_ab, at_b, at_c), 1), np.stack((n_ab, at_c, n_ac), 1))
        )
        part = np.concatenate((soup.part, soup.part))
        if texels is not None:
            at_ab, at_ac = ends
            texels = np.concatenate(
                (
                    np.stack((at_ab, texels[:, 1], texels[:, 2]), 1),
                    np.stack((at_ab, texels[:, 2], at_ac), 1),
                )
            )
    return Soup(
        np.concatenate((soup.places, *places)),
        new_faces.astype(np.int32),
        np.concatenate((soup.normals, *normals)),
        new_corners.astype(np.int32),
        np.concatenate((soup.colors, *colors)),
        part,
        texels,
    )


def _merged(soups: Sequence[Soup]) -> Soup:
    vertex_shift = np.cumsum([0, *(len(s.places) for s in soups)])
    normal_shift = np.cumsum([0, *(len(s.normals) for s in soups)])
    return Soup(
        np.concatenate([s.places for s in soups]),
        np.concatenate([s.faces + vertex_shift[k] for k, s in enumerate(soups)]).astype(np.int32),
        np.concatenate([s.normals for s in soups]),
        np.concatenate([s.corners + normal_shift[k] for k, s in enumerate(soups)]).astype(np.int32),
        np.concatenate([s.colors for s in soups]),
        np.concatenate([s.part for s in soups]),
        None
        if soups[0].texels is None
        else np.concatenate([s.texels for s in soups if s.texels is not None]),
    )
