"""Curves that go along with the surface that they were drawn on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.geometry import Mesh, Spline
from bozzetto.scene import SurfacePlaces, follow
from bozzetto_product.projection.spline_basis import basis, free_controls, with_controls


@dataclass(frozen=True, eq=False)
class Followed:
    """A curve after its surface was changed.

    Attributes
    ----------
    spline : Spline
        mm.
    places : SurfacePlaces
        On the triangles of now: what is to be kept from here on.
    """

    spline: Spline
    places: SurfacePlaces


def follow_surface(spline: Spline, places: SurfacePlaces, before: Mesh, after: Mesh) -> Followed:
    """Move a curve as the surface under it moved.

    Only the displacement of the surface is carried over, so what was modified since, and what
    runs off the surface, keeps its distance from it.

    Parameters
    ----------
    spline : Spline
        In space, mm.
    places : SurfacePlaces
        Of equally spaced points of the curve, on `before`.
    before, after : Mesh
        The surface, in the frame of the curve.

    Returns
    -------
    Followed

    Raises
    ------
    ValueError
        If the places are not on `before`, or `after` has no face.
    """
    here, there = follow(places, before, before), follow(places, before, after)
    if (there.points == here.points).all():
        return Followed(spline, there.places)
    at = np.linspace(*spline.range, len(places))
    # What stands up from the surface turns with it.
    offset = spline.value(at) - here.points
    height = np.einsum("nk,nk->n", offset, here.normals)[:, None]
    way = there.points - here.points + height * (there.normals - here.normals)
    # More control points than places: of all changes the least one is taken.
    change = np.linalg.lstsq(basis(spline, at), way, rcond=1e-9)[0]
    return Followed(with_controls(spline, free_controls(spline) + change), there.places)
