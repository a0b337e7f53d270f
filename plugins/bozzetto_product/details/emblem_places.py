"""Where the outlines of an emblem lie on surfaces: let down on to them from a plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_product.details.ground import Ground, followed_outline, kept_places
from bozzetto_product.details.outline_places import laid_flat, placed_flat
from bozzetto_product.model.details import OutlinePlaces
from bozzetto_product.model.emblems import Emblem

UNWRITTEN: Final = "it has no outline. Type a text, in letters of Latin, Greek or Cyrillic."
LOST: Final = "its surface is gone. Switch the surface on again, or delete the detail."
STEP: Final = 1e-3
"""Distance of the place above an emblem's middle, as share of the size of all surfaces."""


def anchored(grounds: Sequence[Ground], at: Array, up: Array) -> OutlinePlaces:
    """Return the places of an emblem at a point, with a direction that is up for it; mm."""
    boxes = np.array([ground.fill.mesh.bounds for ground in grounds], float)
    size = float(np.linalg.norm(boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)))
    above = at + STEP * size * up / max(float(np.linalg.norm(up)), 1e-300)
    return kept_places(grounds, np.stack((at, above)), np.zeros(2, bool), [0])


def emblem_outlines(emblem: Emblem, grounds: Sequence[Ground]) -> list[Array]:
    """Return the outlines of an emblem on surfaces, (n, 3) mm each.

    Raises
    ------
    UserError
        If there are none, or a part of them is beside the surfaces.
    """
    rows, at, up, width, turn = _written(emblem, grounds)
    return laid_flat(rows, at, up, width, grounds, turn)


def hanging_outlines(emblem: Emblem, grounds: Sequence[Ground]) -> list[Array]:
    """Return the outlines of an emblem in its tangent plane, (n, 3) mm each, closed.

    So it is seen where it is, though a part of it is beside the surfaces. None without a text or
    without a place.
    """
    try:
        rows, at, up, width, turn = _written(emblem, grounds)
    except UserError:
        return []
    placed = placed_flat(rows, at, up, width, grounds, turn)
    return [np.vstack((row, row[:1])) for row in placed]


def _written(
    emblem: Emblem, grounds: Sequence[Ground]
) -> tuple[list[Array], Array, Array, float, float]:
    """Return flat outlines, their middle, what is up, their width, mm, and turn, radians.

    Raises
    ------
    UserError
        If there is no text, or its surface is gone.
    """
    flat = emblem.flat
    if flat is None or not len(flat.starts):
        raise UserError(UNWRITTEN)
    followed = None if emblem.places is None else followed_outline(grounds, emblem.places)
    if followed is None:
        raise UserError(LOST)
    at, above = followed.points[:2]
    extent = np.ptp(flat.points, axis=0)
    width = float(extent[0]) * emblem.height / (1.0 if flat.text else float(extent[1]))
    return list(flat.rows), at, above - at, width, float(np.radians(emblem.turn))
