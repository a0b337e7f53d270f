"""The ink of one view beside the image of a curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index
from bozzetto.ink import FEET_LAPS, arc_length, ordered_feet, resample
from bozzetto_symmetry.fitting.symmetric_basis import SymmetricBasis
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import image_slopes

TREMOR: Final = (12.0, 0.04)
"""How far along the ink a hand's deviation stays alike, px, or as a share of the ink's
length, whichever is more: it is white noise smoothed by a Gaussian of this width. Samples
that are closer say the same thing again."""

INDEPENDENT: Final = 2.0 * float(np.sqrt(np.pi))
"""Length of ink, in widths of the tremor, that counts as one measurement: the integral of
the correlation."""

LEAST_NOISE: Final = 0.5
"""Standard deviation, px, that every hand has at least. Most of a hand's noise is slow and
does not show in the ink; a curve that trusts its ink more is bent where it is known least."""

END_NOISE: Final = 2.0
"""How much worse a hand is at ending in the right place than at keeping on the curve."""

SPACING: Final = 4.0
"""Distance of the samples of ink, px: a third of the least tremor."""

MOST_SAMPLES: Final = 300
"""Most samples of one piece of ink; on longer ink they are further apart."""

CLOSED: Final = 0.05
"""Gap between the ends of a piece of ink, as a share of its length, below which it goes round a
closed curve once."""

FIRST_STEPS: Final = 3
"""Steps to the nearest places from where ink was first matched."""

MATCHED: Final = 60
"""Samples of one piece of ink, and twice as many of the curve, when they are first matched."""

AT_END: Final = (6.0, 0.04)
"""An end of ink that is this close to the image of an end of the curve (px, or as a share of
the ink's length, whichever is more) shows that end."""


COLUMNS: Final = ("pixels", "factors", "share", "along", "piece", "held", "parameters")
"""Fields of `Ink` with a value for every sample."""


@dataclass(frozen=True, eq=False)
class Ink:
    """Samples of all the ink of one view, and where on the curve they are.

    Attributes
    ----------
    stereo : Stereo
    pixels : (n, 2) float
    factors : (n, 3) float
        Factors of the coordinates of the curve: the mirror, for the far side.
    noise : float
        Standard deviation of the hand across the ink, px, not below `LEAST_NOISE`.
    share : (n,) float
        How many measurements each sample is.
    along : (n,) float
        Length of ink up to each sample, px.
    piece : (n,) int
        Which piece of ink each sample is of.
    held : (n,) bool
        Samples that show an end of the curve.
    parameters : (n,) float
        Parameters of the nearest places of the curve's image.
    """

    stereo: Stereo
    pixels: Array
    factors: Array
    noise: float
    share: Array
    along: Array
    piece: Index
    held: Flags
    parameters: Array

    @classmethod
    def of(
        cls,
        stereo: Stereo,
        pixels: ArrayLike,
        factors: Array,
        noise: float,
        piece: int,
        closed: bool,
    ) -> Ink | None:
        """Return samples of one piece of ink, not yet matched to a curve; None if it is a dot."""
        drawn = np.reshape(np.asarray(pixels, float), (-1, 2))
        length = float(arc_length(drawn)[-1]) if len(drawn) > 1 else 0.0
        if not length > 0:
            return None
        gap = float(np.linalg.norm(drawn[0] - drawn[-1]))
        closed = closed and len(drawn) > 2 and gap < CLOSED * length
        length += gap if closed else 0.0
        place = resample(drawn, spacing=max(SPACING, length / MOST_SAMPLES), closed=closed)
        count = len(place)
        tremor = max(TREMOR[0], TREMOR[1] * length)
        return cls(
            stereo,
            place,
            np.broadcast_to(factors, (count, 3)),
            max(noise, LEAST_NOISE),
            np.full(count, min(1.0, length / count / (INDEPENDENT * tremor))),
            np.linspace(0.0, length, count, endpoint=not closed),
            np.full(count, piece),
            np.zeros(count, bool),
            np.zeros(count),
        )

    def deviation(self, basis: SymmetricBasis, points: Array) -> Deviation:
        """Return how far the ink is from the image of a curve at its present parameters."""
        values = basis.values(self.parameters)
        place = basis.at(values, points) * self.factors
        tangent = basis.at(basis.values(self.parameters, 1), points) * self.factors
        slopes = image_slopes(self.stereo, place)
        return Deviation(
            values,
            slopes * self.factors[:, None],
            self.pixels - self.stereo.project(place),
            np.einsum("nij,nj->ni", slopes, tangent),
        )

    def settled(self, basis: SymmetricBasis, points: Array, *, steps: int = 1) -> Ink:
        """Return the ink with its parameters moved towards the closest points of the curve's image.

        A Gauss–Newton step of Hoschek's (1988) parameter correction; ends that are held stay,
        and samples keep their order: in a hairpin the nearest place may be on the other leg.
        """
        ink = self
        reach = (basis.half[1] - basis.half[0]) / basis.count
        for _ in range(steps):
            ink = ink._in_order(basis)
            off = ink.deviation(basis, points)
            speed = (off.tangent**2).sum(axis=1)
            step = np.zeros(len(speed))
            np.divide((off.offset * off.tangent).sum(axis=1), speed, out=step, where=speed > 0)
            step = np.where(ink.held | ~np.isfinite(step), 0.0, np.clip(step, -reach, reach))
            ink = replace(ink, parameters=basis.whole.within(ink.parameters + step))
        return ink

    def _in_order(self, basis: SymmetricBasis) -> Ink:
        """Return the ink in its order: a parameter that turned back goes between its neighbours."""
        ways = np.diff(self.parameters)
        if basis.periodic:
            ways = np.mod(ways + 0.5, 1.0) - 0.5
        inner = (self.piece[2:] == self.piece[:-2]) & ~self.held[1:-1]
        turned = 1 + np.flatnonzero(inner & (ways[:-1] * ways[1:] < 0.0))
        if not len(turned):
            return self
        parameters = self.parameters.copy()
        parameters[turned] = self.parameters[turned - 1] + 0.5 * (ways[turned - 1] + ways[turned])
        return replace(self, parameters=parameters)


@dataclass(frozen=True, eq=False)
class Deviation:
    """Distances of samples of ink from the image of a curve.

    Attributes
    ----------
    values : (n, 3, k) float
        Basis functions at the parameters of the samples.
    slopes : (n, 2, 3) float
        Derivatives of the image by the place on the curve, px/mm.
    offset : (n, 2) float
        From the image of the closest point to the ink, px; NaN where that point is not seen.
    tangent : (n, 2) float
        Derivative of the image by the parameter, px.
    """

    values: Array
    slopes: Array
    offset: Array
    tangent: Array

    @property
    def along(self) -> Array:
        """Unit tangents of the image, (n, 2); any direction where it has none."""
        length = np.linalg.norm(self.tangent, axis=1, keepdims=True)
        out = np.broadcast_to((1.0, 0.0), self.tangent.shape).copy()
        return np.asarray(np.divide(self.tangent, length, out=out, where=length > 0))

    @property
    def normal(self) -> Array:
        """Unit normals of the image, (n, 2)."""
        along = self.along
        return np.column_stack((-along[:, 1], along[:, 0]))

    @property
    def across(self) -> Array:
        """Distances of the ink across the image, (n,) px, with their signs."""
        return np.asarray((self.offset * self.normal).sum(axis=1))


def match_ink(
    stereo: Stereo,
    near: Sequence[ArrayLike],
    far: Sequence[ArrayLike],
    noise: float,
    basis: SymmetricBasis,
    points: Array,
    whole: bool = False,
) -> Ink | None:
    """Match the ink of one view to the image of a curve that is roughly right.

    Ink beyond the ends of the curve is left out: nothing is known about its partner.

    Parameters
    ----------
    basis : SymmetricBasis
        The curves among which the curve is one.
    stereo : Stereo
        The camera of the view and its mirror image.
    near, far : sequence of (n, 2) float
        Pieces of ink that show the half, and its mirror image, px; in any sense.
    noise : float
        px.
    points : (k, 3) float
        Control points of the half.
    whole : bool
        Every piece ends where the curve does, however far off that is.

    Returns
    -------
    Ink or None
        None where the curve is not in front of the eye, or there is no ink.
    """
    low, high = basis.half
    at = np.linspace(low, high, 2 * MATCHED, endpoint=not basis.closed)
    half = basis.at(basis.values(at), points)
    pieces: list[Ink] = []
    for side, factors in ((near, np.ones(3)), (far, MIRROR)):
        image = stereo.project(half * factors)
        if not np.isfinite(image).all():
            return None
        for pixels in side:
            ink = Ink.of(stereo, pixels, factors, noise, len(pieces), basis.closed)
            if ink is not None:
                pieces.append(_matched(ink, image, at, basis, whole))
    if not pieces:
        return None
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(ink, name) for ink in pieces]) for name in COLUMNS
    }
    matched = replace(pieces[0], **columns).settled(basis, points, steps=FIRST_STEPS)
    return matched if basis.periodic else _without_beyond(matched, basis, points)


def _matched(ink: Ink, image: Array, at: Array, basis: SymmetricBasis, whole: bool) -> Ink:
    """Return one piece of ink with its parameters, and which of its ends show ends of the curve."""
    length = float(ink.along[-1])
    parameters = _passed_parameters(ink.pixels, length, image, at, closed=basis.closed)
    held = ink.held.copy()
    if not basis.periodic:
        close = np.inf if whole else max(AT_END[0], AT_END[1] * length)
        for end in (1,) if basis.reading == "self" else (0, 1):
            tip = -int(np.argmin(np.abs(parameters[[0, -1]] - basis.half[end])))
            if np.linalg.norm(ink.pixels[tip] - image[-end]) <= close:
                held[tip], parameters[tip] = True, basis.half[end]
    return replace(ink, parameters=parameters, held=held)


def _passed_parameters(
    place: Array, length: float, image: Array, at: Array, *, closed: bool
) -> Array:
    """Return the parameters of the places of the image that ink passes, in order."""
    count = min(len(place), MATCHED)
    chosen = np.linspace(0, len(place) - 1, count).round().astype(int)
    steps = np.linalg.norm(np.diff(image, axis=0, append=image[:1]), axis=1)
    if not closed:
        steps[-1] = 0.0
    lengths = 0.5 * (steps + np.roll(steps, 1))
    nodes = ordered_feet(place[chosen], length / count, image, lengths, closed=closed)
    step = float(at[1] - at[0])
    numbered = at[0] + step * np.arange(len(at) * (FEET_LAPS if closed else 1))
    return np.asarray(np.interp(np.arange(len(place)), chosen, numbered[nodes]))


def _without_beyond(ink: Ink, basis: SymmetricBasis, points: Array) -> Ink | None:
    """Return the ink beside the curve, without what runs on beyond its ends."""
    low, high = basis.whole.range
    off = ink.deviation(basis, points)
    slid = np.abs((off.offset * off.along).sum(axis=1))
    clamped = (ink.parameters <= low) | (ink.parameters >= high)
    kept = ink.held | ~(clamped & (slid > SPACING))
    if not kept.any():
        return None
    columns: dict[str, Any] = {name: getattr(ink, name)[kept] for name in COLUMNS}
    return replace(ink, **columns)
