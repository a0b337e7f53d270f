"""Exact surfaces as every reader takes them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.exchange.cad.cad_curves import (
    MAX_DEGREE,
    MAX_WEIGHT_RATIO,
    RESOLUTION,
    readable,
)
from bozzetto.exchange.cad.knot_removal import without_idle_knots
from bozzetto.exchange.limits import MAX_CONTROL_POINTS, MAX_COORDINATE
from bozzetto.geometry.brep.brep import Brep
from bozzetto.geometry.brep.patchwork_brep import brep_of_patchwork
from bozzetto.geometry.curve import Curve
from bozzetto.geometry.shapes import Shapes


def checked_breps(shapes: Shapes) -> tuple[Brep, ...]:
    """Return the patchworks, then the breps of shapes as they can be written.

    Returns
    -------
    tuple of Brep
        Without control characters in names and idle knots; the shape is untouched.

    Raises
    ------
    UserError
        If they have too many control points together, or one has an edge without length, too
        high a degree, or numbers that are not finite or too large.
    """
    count = sum(16 * len(p.nets) + 4 * len(p.edges) for p in shapes.patchworks)
    count += sum(map(control_points_of, shapes.breps))
    if count > MAX_CONTROL_POINTS:
        raise UserError(
            f"The surfaces have {count:,} control points together, more than the "
            f"{MAX_CONTROL_POINTS:,} that can be written. Export fewer objects at once."
        )
    for patchwork in shapes.patchworks:
        _refuse_arrays(patchwork.name, (patchwork.nets, patchwork.edges))
        _refuse_short(patchwork.name, patchwork.edges)
    for brep in shapes.breps:
        _refuse_unwritable(brep)
    return tuple(
        replace(
            brep,
            name=readable(brep.name),
            faces=tuple(replace(face, name=readable(face.name)) for face in brep.faces),
        )
        for one in (*map(brep_of_patchwork, shapes.patchworks), *shapes.breps)
        for brep in (without_idle_knots(one),)
    )


def control_points_of(brep: Brep) -> int:
    """Return how many control points surfaces, edges and trims have together."""
    nets = sum(face.surface.control_points.size // 3 for face in brep.faces)
    trims = sum(len(trim.curve.control_points) for face in brep.faces for trim in face.trims)
    return nets + trims + sum(len(edge.control_points) for edge in brep.edges)


def _refuse_unwritable(brep: Brep) -> None:
    nets = [face.surface for face in brep.faces]
    _refuse_arrays(
        brep.name, [s.control_points for s in nets] + [e.control_points for e in brep.edges]
    )
    _refuse_short(brep.name, [edge.control_points for edge in brep.edges])
    weights = [w for w in (*(s.weights for s in nets), *(e.weights for e in brep.edges))
               if w is not None]  # fmt: skip
    if any(w.max() > MAX_WEIGHT_RATIO * w.min() for w in weights):
        raise UserError(
            f"The weights of the surface “{brep.name}” are too far apart. Draw it again."
        )
    highest = max(max(surface.degrees) for surface in nets)
    if highest > MAX_DEGREE:
        raise UserError(
            f"The surface “{brep.name}” is of degree {highest}; other programs read up to "
            f"{MAX_DEGREE}. Fit it again with a lower degree."
        )


def _refuse_arrays(name: str, arrays: Iterable[Array]) -> None:
    for points in arrays:
        if not np.isfinite(points).all():
            raise UserError(
                f"The surface “{name}” holds a number that is not finite. Draw it again."
            )
        if np.abs(points).max() > MAX_COORDINATE:
            raise UserError(
                f"The surface “{name}” reaches further than {MAX_COORDINATE:.0g} mm. "
                "Make its object smaller or move it nearer."
            )


def _refuse_short(name: str, edges: Iterable[Array]) -> None:
    if any(np.ptp(points, axis=0).max() <= RESOLUTION for points in edges):
        raise UserError(
            f"An edge of the surface “{name}” has no length. Draw its ends apart, then export."
        )


def is_line(curve: Curve) -> bool:
    """Whether a curve is one straight line, evenly run."""
    return curve.degree == 1 and len(curve.control_points) == 2 and curve.weights is None
