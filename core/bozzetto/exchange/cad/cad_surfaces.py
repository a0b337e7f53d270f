"""Patchworks as every reader takes them, and the names of their patches."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import frozen
from bozzetto.errors import UserError
from bozzetto.exchange.cad.cad_curves import RESOLUTION, readable
from bozzetto.exchange.limits import MAX_CONTROL_POINTS, MAX_COORDINATE
from bozzetto.geometry.patches.patchwork import Patchwork
from bozzetto.geometry.patches.tessellation import tessellated
from bozzetto.geometry.shapes import Shapes, Surface

CUBIC_KNOTS: Final = frozen((0.0,) * 4 + (1.0,) * 4, np.float64)
"""Knots with which a cubic B-spline of four control points is a Bézier curve."""


def checked_patchworks(shapes: Shapes) -> tuple[Patchwork, ...]:
    """Return the patchworks of shapes as they can be written.

    Returns
    -------
    tuple of Patchwork
        Without control characters in names; the geometry is untouched.

    Raises
    ------
    UserError
        If they have too many control points together, or one has an edge without length, or
        numbers that are not finite or too large.
    """
    count = sum(16 * len(p.nets) + 4 * len(p.edges) for p in shapes.patchworks)
    if count > MAX_CONTROL_POINTS:
        raise UserError(
            f"The surfaces have {count:,} control points together, more than the "
            f"{MAX_CONTROL_POINTS:,} that can be written. Export fewer objects at once."
        )
    for patchwork in shapes.patchworks:
        _refuse_unwritable(patchwork)
    return tuple(
        replace(p, name=readable(p.name), patch_names=tuple(map(readable, p.patch_names)))
        for p in shapes.patchworks
    )


def _refuse_unwritable(patchwork: Patchwork) -> None:
    name = patchwork.name
    if not (np.isfinite(patchwork.nets).all() and np.isfinite(patchwork.edges).all()):
        raise UserError(f"The surface “{name}” holds a number that is not finite. Draw it again.")
    if max(np.abs(patchwork.nets).max(), np.abs(patchwork.edges).max()) > MAX_COORDINATE:
        raise UserError(
            f"The surface “{name}” reaches further than {MAX_COORDINATE:.0g} mm. "
            "Make its object smaller or move it nearer."
        )
    if np.ptp(patchwork.edges, axis=1).max(axis=1).min() <= RESOLUTION:
        raise UserError(
            f"An edge of the surface “{name}” has no length. Draw its ends apart, then export."
        )


def names_of_patches(patchwork: Patchwork) -> tuple[str, ...]:
    """Return a name for each patch: its own, or that of the whole."""
    return patchwork.patch_names or (patchwork.name,) * len(patchwork.nets)


def with_meshes(shapes: Shapes) -> Shapes:
    """Return shapes for formats that hold triangles only: patchworks become surfaces."""
    meshes = tuple(Surface(tessellated(p), p.name, p.color) for p in shapes.patchworks)
    return replace(shapes, surfaces=shapes.surfaces + meshes, patchworks=())
