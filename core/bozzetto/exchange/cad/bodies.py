"""Which pieces of a brep are solids, which are hollows in them, and which are open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Index
from bozzetto.errors import UserError
from bozzetto.exchange.mesh.manifold_check import signed_volume
from bozzetto.geometry.brep.brep import Brep
from bozzetto.geometry.brep.tessellation import face_meshes
from bozzetto.geometry.mesh import Mesh

COARSE: Final = 0.01
"""Distance of the triangles that tell inside from outside, as share of the size."""


@dataclass(frozen=True)
class Bodies:
    """The pieces of a brep, each the numbers of its faces.

    Attributes
    ----------
    solids : tuple of (piece, tuple of pieces)
        Closed ones that look outward, each with the hollows inside it, which look inward.
    sheets : tuple of pieces
        Open ones.
    """

    solids: tuple[tuple[Index, tuple[Index, ...]], ...]
    sheets: tuple[Index, ...]


def bodies_of(brep: Brep) -> Bodies:
    """Return the solids and sheets of a brep.

    Raises
    ------
    UserError
        If a closed piece is inside out and lies in no other one.
    """
    closed = [piece for piece in brep.pieces if not _is_open(brep, piece)]
    sheets = tuple(piece for piece in brep.pieces if _is_open(brep, piece))
    if not closed:
        return Bodies((), sheets)
    points = np.concatenate([f.surface.control_points.reshape(-1, 3) for f in brep.faces])
    faces = face_meshes(brep, COARSE * float(np.linalg.norm(np.ptp(points, axis=0))))
    volumes = [sum(signed_volume(faces[k], points[0]) for k in piece) for piece in closed]
    hollows: dict[int, list[Index]] = {n: [] for n, v in enumerate(volumes) if v > 0}
    for piece, volume in zip(closed, volumes, strict=True):
        if volume > 0:
            continue
        around = [n for n in hollows if _surrounds(faces, closed[n], piece)]
        if not around:
            raise UserError(
                f"“{brep.name}” is inside out or flat. Turn it over, or draw its outline again."
            )
        hollows[min(around, key=lambda n: volumes[n])].append(piece)
    return Bodies(tuple((closed[n], tuple(inner)) for n, inner in hollows.items()), sheets)


def _is_open(brep: Brep, piece: Index) -> bool:
    rim = set(brep.rim.tolist())
    return any(trim.edge in rim for number in piece for trim in brep.faces[number].trims)


def _surrounds(faces: tuple[Mesh, ...], outer: Index, inner: Index) -> bool:
    """Whether the box around some faces holds that around others."""
    (low, high), (least, most) = (
        (np.min([faces[k].bounds[0] for k in piece], axis=0),
         np.max([faces[k].bounds[1] for k in piece], axis=0))
        for piece in (outer, inner)
    )  # fmt: skip
    return bool((low <= least).all() and (most <= high).all())
