"""The curve that a stroke is meant for: curves as they are seen in one view."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import FARTHEST, distances_to_polyline, nearest_curve
from bozzetto.plugin import cached_property, remembered
from bozzetto.view import Camera
from bozzetto_symmetry.fitting.half_curve import halves_of
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.solve.curve_solver import solve_curve
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

PIECES: Final = 24
"""Segments of a picture for each span of the spline: within a tenth of a pixel of it."""

FAITHFUL: Final = 0.6
"""The chosen curve seems nearer than it is by this factor: a person goes on with it."""

REACH: Final = 120.0
"""Mean distance, px, beyond which a stroke is meant for no curve."""

Picture = tuple[bool, Array, Array]
"""Whether it is of the mirror image, parameters, and where these are seen."""


@dataclass(frozen=True, eq=False)
class Seen:
    """A side of a curve as it is seen.

    Attributes
    ----------
    node : Curve
    curve : SpaceCurve
    mirrored : bool
        It is the mirror image of one of a pair.
    stereo : Stereo
        Through which it is seen.
    parameters : (n,) float
        Of places along the spline.
    pixels : (n, 2) float
        Where they are seen; NaN behind the eye.
    """

    node: Curve
    curve: SpaceCurve
    mirrored: bool
    stereo: Stereo
    parameters: Array
    pixels: Array

    @cached_property
    def visible(self) -> tuple[Array, Array]:
        """Parameters and pixels of the places that are seen on the sheet."""
        kept = (np.abs(self.pixels) <= FARTHEST).all(axis=1)
        return self.parameters[kept], self.pixels[kept]

    @property
    def ends(self) -> Array:
        """Parameters of the free ends."""
        return np.array([] if self.curve.closed else self.curve.spline.range)

    @property
    def crossings(self) -> Array:
        """Parameters at which the curve crosses the centre plane as its own mirror image."""
        if self.curve.reading != "self":
            return np.array([])
        halves = halves_of(self.curve.spline)
        return np.array([halves.middle, halves.end] if halves.ring else [halves.middle])

    def place(self, parameters: ArrayLike) -> Array:
        """Return places of this side in space, (n, 3) mm, in the frame of the centre plane."""
        points = self.curve.spline.value(np.atleast_1d(np.asarray(parameters, float)))
        return points * MIRROR if self.mirrored else points

    def seen_at(self, parameters: ArrayLike) -> Array:
        """Return where places of this side are seen, (n, 2) px; NaN behind the eye."""
        return self.stereo.project(self.place(parameters))

    def nearest(self, pixel: ArrayLike) -> float:
        """Return the parameter of the place that is seen nearest to a place on the sheet."""
        at, path = self.visible
        begin, step = path[:-1], np.diff(path, axis=0)
        square = np.einsum("ij,ij->i", step, step)
        share = np.einsum("ij,ij->i", np.asarray(pixel, float) - begin, step)
        share = np.clip(share / np.where(square > 0, square, 1.0), 0.0, 1.0)
        away = np.linalg.norm(begin + share[:, None] * step - pixel, axis=1)
        best = int(np.argmin(away))
        return float(at[best] + share[best] * (at[best + 1] - at[best]))

    def distances(self, places: ArrayLike) -> Array:
        """Return how far places (m, 2) on the sheet are from it, px; inf where it is not seen."""
        path, at = self.visible[1], np.asarray(places, float)
        return distances_to_polyline(at, path) if len(path) > 1 else np.full(len(at), np.inf)


def solved_curves(state: SymmetryState) -> list[tuple[Curve, SpaceCurve]]:
    """Return the curves shown that are in space already, in the order of the list."""
    found = []
    for node in state.shown_curves:
        try:
            curve = solve_curve(node, state)
        except UserError:
            continue
        if curve is not None:
            found.append((node, curve))
    return found


def seen_curves(state: SymmetryState, camera: Camera) -> list[Seen]:
    """Return all sides of all curves shown, through a camera of the model's frame."""
    stereo = Stereo.of(camera, state.plane)
    return [
        Seen(node, curve, mirrored, stereo, at, pixels)
        for node, curve in solved_curves(state)
        for mirrored, at, pixels in _pictures_of(curve, stereo)
    ]


@remembered(limit=512)
def _pictures_of(curve: SpaceCurve, stereo: Stereo) -> tuple[Picture, ...]:
    spline = curve.spline
    at = np.linspace(*spline.range, len(np.unique(spline.knots)) * PIECES + 1)
    return tuple(
        (number == 1, at, stereo.project(side.value(at)))
        for number, side in enumerate(curve.curves())
    )


def target_of(seen: Sequence[Seen], ink: ArrayLike, chosen: str) -> Seen | None:
    """Return the side that a stroke is drawn over: the nearest on average (Kara & Shimada).

    Parameters
    ----------
    seen : sequence of Seen
        The sides to choose from.
    ink : (n, 2) array_like
        px.
    chosen : str
        Id of the curve that is preferred to others about as near.
    """
    paths = [side.visible[1] for side in seen]
    best = nearest_curve(paths, ink)
    if best is None or best.distance > REACH:
        return None
    own = [number for number, side in enumerate(seen) if side.node.id == chosen]
    mine = nearest_curve([paths[number] for number in own], ink)
    if mine is not None and FAITHFUL * mine.distance <= best.distance:
        return seen[own[mine.index]]
    return seen[best.index]
