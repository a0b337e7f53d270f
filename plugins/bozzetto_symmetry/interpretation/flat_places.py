"""The places of a curve across the centre plane on the surface in which it lies."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import resample
from bozzetto_symmetry.interpretation.folding import Folding
from bozzetto_symmetry.interpretation.mirrored_ink import CARELESS, ENDS, InkLine
from bozzetto_symmetry.interpretation.simple_form import SimpleForm
from bozzetto_symmetry.interpretation.stereo_triangulation import HalfInSpace
from bozzetto_symmetry.stereo.bowed_plane import BowedPlane
from bozzetto_symmetry.stereo.correspondence import Pairing
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

FEWEST: Final = 8
"""Least matched places that say in which plane a curve lies."""

PLACES: Final = 120
"""Places along a half of a flat curve."""

ALIKE: Final = 1e-3
"""Share of the length within which a place counts as the crossing itself."""

LEAP: Final = 0.25
"""Share of a half between the nearest places of neighbours from which on it is none's partner."""


Flat = tuple[Folding, HalfInSpace, SimpleForm]
"""A folding whose places lie on a surface, the half that they make, and that surface."""


def on_plane(
    stereo: Stereo,
    folding: Folding,
    half: HalfInSpace,
    pixels: Array,
    ring: bool,
    form: SimpleForm,
    off: float,
) -> Flat | None:
    """Return the folding whose places lie on a surface, and the half that they make.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    folding : Folding
        How the halves of the line belong together by the matching alone.
    half : HalfInSpace
        What that gives.
    pixels : (n, 2) float
        The line as drawn, px; a ring does not repeat its first point.
    ring : bool
        The line is closed.
    form : SimpleForm
        The surface.
    off : float
        What it costs, px.

    Returns
    -------
    tuple or None
        None where rays do not meet the surface, or the line does not cross the plane on it.
    """
    surface = form.surface
    assert surface is not None
    crossings = _crossings(stereo, folding, pixels, ring, surface)
    if crossings is None:
        return None
    pairing = folding.pairing
    if not ring:
        pairing = _of_all(stereo, pairing, folding.first, pixels, crossings[:1], surface)
    points = surface.met(stereo, pairing.near)[0]
    if len(points) < 2 or not np.isfinite(points).all():
        return None
    # The crossing has moved: what is on its other side now belongs to the other half.
    side = np.sign(float(np.median(points[:, 1])))
    keep = side * points[:, 1] > ALIKE * float(np.linalg.norm(np.ptp(points, axis=0)))
    if keep.sum() < 2:
        return None
    pairing = replace(
        pairing, near=pairing.near[keep], far=stereo.project(points[keep] * MIRROR), cost=off,
        stations=pairing.stations[keep], far_stations=pairing.far_stations[keep],
        weak=np.zeros(int(keep.sum()), bool),
    )  # fmt: skip
    tangents = np.gradient(points, axis=0)
    sigma = form.sigmas(stereo, points, tangents)[keep]
    covariances = (sigma**2)[:, None, None] * np.eye(3)
    trust = np.full(len(sigma), 1.0 / len(sigma))
    flat = replace(half, points=points[keep], covariances=covariances, trust=trust, kept=1.0,
                   astride=0.0, reasons=())  # fmt: skip
    return Folding(pairing, crossings, folding.first), flat, form


def _of_all(
    stereo: Stereo,
    pairing: Pairing,
    first: bool,
    pixels: Array,
    foot: Array,
    surface: BowedPlane,
) -> Pairing:
    """Return the pairing with all of the line: on a surface every place has a partner.

    The matching leaves out what the epipolar lines do not tell, as the ends of a shallow bow. Only
    ink beyond the other half's end has none.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    pairing : Pairing
        Of the halves.
    first : bool
        Its `near` is the half that was drawn first.
    pixels : (n, 2) float
        The line, px.
    foot : (1, 2) float
        Where it crosses the centre plane, px.
    surface : BowedPlane
        On which it lies.
    """
    cut = int(np.argmin(np.linalg.norm(pixels - foot, axis=1)))
    halves = np.vstack((foot, pixels[:cut][::-1])), np.vstack((foot, pixels[cut + 1 :]))
    own, other = halves if first else halves[::-1]
    if min(len(own), len(other)) < FEWEST:
        return pairing
    share = np.linspace(0.0, 1.0, PLACES)
    near = resample(own, count=PLACES)
    images = stereo.project(surface.met(stereo, near)[0] * MIRROR)
    if not np.isfinite(images).all():
        return pairing
    line = InkLine.of(other, False)
    feet = line.nearest(images)
    gone = np.linalg.norm(images - line.pixels[feet], axis=1) > CARELESS * ENDS
    kept = ~(gone & (feet == len(line.pixels) - 1))
    kept[0] = False
    near, stations = near[kept], share[kept]
    far_stations = feet[kept] / (len(line.pixels) - 1.0)
    if len(near) < FEWEST:
        return pairing
    return replace(
        pairing, near=near, stations=stations, far_stations=far_stations,
        coverage=(coverage_of(stations), coverage_of(far_stations)),
    )  # fmt: skip


def coverage_of(stations: Array) -> float:
    """Return the share of a half that has partners, from the crossing on.

    Where the nearest place leaps along a half, as where a leg runs back beside it, what lies
    between has none.
    """
    steps = np.diff(np.sort(stations), prepend=0.0)
    return float(steps[steps <= LEAP].sum())


def _crossings(
    stereo: Stereo, folding: Folding, pixels: Array, ring: bool, surface: BowedPlane
) -> Array | None:
    """Return where the flat curve crosses the centre plane, nearest to where it was folded, px."""
    line = np.vstack((pixels, pixels[:1])) if ring else pixels
    heights = surface.met(stereo, line)[0][:, 1]
    if not np.isfinite(heights).all():
        return None
    steps = np.flatnonzero(heights[:-1] * heights[1:] <= 0.0)
    if len(steps) < len(folding.crossings):
        return None
    share = heights[steps] / (heights[steps] - heights[steps + 1] + 1e-300)
    places = line[steps] + share[:, None] * (line[steps + 1] - line[steps])
    chosen = [int(np.linalg.norm(places - old, axis=1).argmin()) for old in folding.crossings]
    return None if len(set(chosen)) < len(chosen) else places[chosen]
