"""A curve across the centre plane as a flat one, where the ink does not contradict that.

The plane of a flat curve that is its own mirror image contains the normal of the centre plane:
two figures say which it is, and the whole of the ink tells them. Every place is where its ray
meets the plane, also where the epipolar lines run along the curve.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.ink import resample
from bozzetto_symmetry.ink.polyline import length_of
from bozzetto_symmetry.interpretation.folding import Folding
from bozzetto_symmetry.interpretation.simple_form import SimpleForm
from bozzetto_symmetry.interpretation.triangulation import HalfInSpace
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import image_slopes

ROUNDS: Final = 15
"""Most Gauss–Newton steps for the plane."""

SETTLED: Final = 1e-6
"""Change of the plane, radians and shares of the curve's size, at which it counts as found."""

FEWEST: Final = 8
"""Least matched places that say in which plane a curve lies."""

FINE: Final = 480
"""Places of the ink among which the nearest one is looked for."""

REACH: Final = 6
"""Of these, to either side over which the direction of the ink is taken."""

SHOWN: Final = 0.8
"""Least share of a half whose mirror image is not beyond the ends of the ink."""

OFF: Final = (2.5, 0.01)
"""Distance of the mirror image from the ink (rms, px; as a share of the ink's length) up to which a
curve may be flat. Curves that are not are off by 20 px and more, or could not be told by hand."""

BENT: Final = (0.15, 5.0)
"""A curve is bent if its mirror image is farther than this from the ink (rms, px), and this many
times as far as that of a curve bent along and across its plane. Hands of 1 px reach 3."""

HALVES: Final = float(np.sqrt(0.5))
"""Share of this distance that counts: the hand errs in either half."""

TURNS: Final = 12
"""Angles of a plane that are tried where a line may cross the centre plane."""

BEST: Final = 2
"""Of these, how many the search begins at."""

SPARSE: Final = 4
"""Every which place of a half is looked at while planes are tried."""

ASLANT: Final = 0.01
"""Standard deviation, radians, from the box's ways of a plane that is meant to be level or
upright."""

ODDS: Final = 3.0
"""Odds above which a plane is taken to be level or upright."""

LOST: Final = 0.3
"""Distance from the ink, px, that a plane may lose by being so."""

WORST: Final = 1e8
"""Condition of the equations from which the ink does not say in which plane a curve lies."""

MEASURES: Final = 3.5
"""Independent measurements along half a stroke: a tremor stays alike over a 25th of it."""

STEEP: Final = 0.05
"""Least sine of the angle between rays and the plane of a flat curve."""

ALIKE: Final = 1e-3
"""Share of the length within which a place counts as the crossing itself."""


def flattened(
    stereo: Stereo, folding: Folding, half: HalfInSpace, pixels: Array, ring: bool
) -> tuple[Folding, HalfInSpace, SimpleForm] | None:
    """Return a folded line as a flat curve: its places, its half in space, and its plane.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    folding : Folding
        How its halves belong together.
    half : HalfInSpace
        What the matching alone gives.
    pixels : (n, 2) float
        The line as drawn, px; a ring does not repeat its first point.
    ring : bool
        The line is closed.

    Returns
    -------
    tuple or None
        None where the ink says that the curve is not flat, or does not say in which plane.
    """
    near, ink = folding.pairing.near, _Ink.of(pixels, ring)
    if len(near) < FEWEST:
        return None
    size = float(np.linalg.norm(np.ptp(half.points, axis=0)))
    most = max(OFF[0], OFF[1] * length_of(pixels))
    best = None
    for angle, away in _starts(stereo, folding, half, ink):
        fitted = _settled(stereo, near, ink, size, (angle, away, None))
        if fitted is not None and (best is None or fitted.off < best.off):
            best = fitted
    if best is None or not best.off <= most or _is_bent(best.rest, best.columns):
        return None
    best = _aligned(stereo, near, ink, size, best)
    information = best.information
    if not np.linalg.cond(information * np.outer((1.0, size), (1.0, size))) < WORST:
        return None
    normal = np.array((np.cos(best.angle), 0.0, np.sin(best.angle)))
    form = SimpleForm(np.append(normal, best.away)[None], np.asarray(np.linalg.inv(information)))
    return _on_plane(stereo, folding, half, pixels, ring, form, best.off * HALVES)


@dataclass(frozen=True, eq=False)
class _Plane:
    """A plane in which a line may lie, and what the ink says of it.

    Attributes
    ----------
    angle, away : float
        Of its normal, radians, and its distance, mm.
    rest : (m,) float
        How far the mirror image is from the ink, px.
    columns : (m, 4) float
        Derivatives of that; see `_equations`.
    axis : float or None
        Angle that it is drawn to.
    """

    angle: float
    away: float
    rest: Array
    columns: Array
    axis: float | None = None

    @property
    def off(self) -> float:
        """Root mean square of the distance from the ink, px."""
        return float(np.sqrt(np.mean(self.rest**2)))

    @property
    def information(self) -> Array:
        """What a hand of 1 px and the axis say of angle and distance, (2, 2)."""
        moves = self.columns[:, :2]
        told = moves.T @ moves * (MEASURES / len(self.rest)) / 2.0
        if self.axis is not None:
            told[0, 0] += 1.0 / ASLANT**2
        return np.asarray(told)


def _starts(
    stereo: Stereo, folding: Folding, half: HalfInSpace, ink: _Ink
) -> list[tuple[float, float]]:
    """Return planes from which the search begins, as angles and distances.

    One fits the matched places best. Where these are badly known, others contain the place where
    the line crosses the centre plane; the best of all angles are taken.
    """
    through = _plane_through(half)
    starts = [] if through is None else [through]
    foot = stereo.on_plane(folding.crossings[:1])[0]
    tried = []
    for angle in np.arange(TURNS) * np.pi / TURNS:
        away = float(foot[0] * np.cos(angle) + foot[2] * np.sin(angle))
        points = _met(stereo, folding.pairing.near[::SPARSE], float(angle), away)[0]
        images = stereo.project(points * MIRROR)
        if np.isfinite(images).all():
            apart = images - ink.pixels[ink.nearest(images)]
            tried.append((float((apart**2).sum()), float(angle), away))
    return starts + [(angle, away) for _, angle, away in sorted(tried)[:BEST]]


def _settled(
    stereo: Stereo,
    near: Array,
    ink: _Ink,
    size: float,
    start: tuple[float, float, float | None],
) -> _Plane | None:
    """Return the plane nearest to a start (angle, distance, axis) that explains the ink best."""
    angle, away, axis = start
    made = _equations(stereo, near, ink, None, angle, away)
    for _ in range(ROUNDS):
        if made is None:
            return None
        rest, columns, images = made
        rows, off = columns[:, :2] * (1.0, size), -rest
        if axis is not None:
            weight = float(np.sqrt(2.0 * len(rest) / MEASURES)) / ASLANT
            rows = np.vstack((rows, (weight, 0.0)))
            off = np.append(off, weight * (axis - angle))
        step = np.linalg.lstsq(rows, off, rcond=None)[0]
        angle, away = angle + float(step[0]), away + float(step[1]) * size
        made = _equations(stereo, near, ink, ink.nearest(images), angle, away)
        if np.abs(step).max() < SETTLED:
            break
    return None if made is None else _Plane(angle, away, made[0], made[1], axis)


def _aligned(stereo: Stereo, near: Array, ink: _Ink, size: float, plane: _Plane) -> _Plane:
    """Return a plane that is level or upright where the ink may well mean that, else itself.

    Of a plane that is not, any angle is as likely as any other; so the odds are those of a normal
    density about the axis to an even one (Bayes factor).
    """
    spread = float(np.linalg.inv(plane.information)[0, 0]) + ASLANT**2
    axis = 0.5 * np.pi * round(plane.angle / (0.5 * np.pi))
    density = np.exp(-0.5 * (plane.angle - axis) ** 2 / spread) / np.sqrt(2.0 * np.pi * spread)
    if not density * 0.5 * np.pi > ODDS:
        return plane
    made = _settled(stereo, near, ink, size, (axis, plane.away, axis))
    return plane if made is None or made.off > plane.off + LOST else made


def _plane_through(half: HalfInSpace) -> tuple[float, float] | None:
    """Return the angle and the distance of the plane that fits the places of a half best."""
    place = half.points[:, [0, 2]]
    middle = half.trust @ place
    apart = (place - middle) * np.sqrt(half.trust)[:, None]
    sizes, ways = np.linalg.svd(apart, full_matrices=False)[1:]
    if not sizes[0] > 0.0:
        return None
    normal = ways[-1]
    return float(np.arctan2(normal[1], normal[0])), float(normal @ middle)


@dataclass(frozen=True, eq=False)
class _Ink:
    """A line as places close to one another, with its normals.

    Attributes
    ----------
    pixels, normals : (n, 2) float
    ring : bool
    """

    pixels: Array
    normals: Array
    ring: bool

    @classmethod
    def of(cls, pixels: Array, ring: bool) -> _Ink:
        fine = resample(pixels, count=FINE, closed=ring)
        way = np.roll(fine, -REACH, axis=0) - np.roll(fine, REACH, axis=0)
        if not ring:
            index = np.arange(FINE)
            way = fine[np.minimum(index + REACH, FINE - 1)] - fine[np.maximum(index - REACH, 0)]
        length = np.linalg.norm(way, axis=1, keepdims=True)
        normals = np.column_stack((-way[:, 1], way[:, 0])) / np.maximum(length, 1e-12)
        return cls(fine, normals, ring)

    def nearest(self, places: Array) -> Index:
        """Return the numbers of the nearest places of the line."""
        apart = ((places[:, None] - self.pixels) ** 2).sum(axis=2)
        return np.asarray(apart.argmin(axis=1))

    def shown(self, feet: Index) -> Flags:
        """Return which feet are not beyond an end of the line."""
        if self.ring:
            return np.ones(len(feet), bool)
        return np.asarray((feet > 0) & (feet < len(self.pixels) - 1))


def _met(stereo: Stereo, pixels: Array, angle: float, away: float) -> tuple[Array, Array]:
    """Return where rays meet a plane, (n, 3) mm, and their directions; NaN where they do not."""
    rays = stereo.rays(pixels)
    normal = np.array((np.cos(angle), 0.0, np.sin(angle)))
    slope = rays.directions @ normal
    steep = np.abs(slope) > STEEP
    reach = np.divide(
        away - rays.origins @ normal, slope, out=np.full(len(slope), np.nan), where=steep
    )
    if not stereo.parallel:
        reach = np.where(reach > 0.0, reach, np.nan)
    return rays.origins + reach[:, None] * rays.directions, rays.directions


def _equations(
    stereo: Stereo, near: Array, ink: _Ink, feet: Index | None, angle: float, away: float
) -> tuple[Array, Array, Array] | None:
    """Return how far the mirror image is from the ink, and the derivatives of that.

    Without feet the nearest places of the ink are taken.

    Returns
    -------
    rest : (m,) float
        Across the ink, px, of the places whose image is not beyond its ends.
    columns : (m, 4) float
        By the plane's angle and its distance, and by what bends it across and along itself.
    images : (n, 2) float
        Of all places mirrored, px.
    """
    points, rays = _met(stereo, near, angle, away)
    images = stereo.project(points * MIRROR)
    if not np.isfinite(images).all():
        return None
    feet = ink.nearest(images) if feet is None else feet
    shown = ink.shown(feet)
    if shown.mean() < SHOWN:
        return None
    normal = np.array((np.cos(angle), 0.0, np.sin(angle)))
    along = np.array((-normal[2], 0.0, normal[0]))
    slopes = image_slopes(stereo, points * MIRROR) * MIRROR
    normals = ink.normals[feet]
    moved = np.einsum("ni,nij,nj->n", normals, slopes, rays) / (rays @ normal)
    rest = ((images - ink.pixels[feet]) * normals).sum(axis=1)
    inner = points @ along
    bends = points[:, 1] ** 2, (inner - inner.mean()) ** 2
    columns = np.column_stack((-inner, np.ones(len(points)), *bends)) * moved[:, None]
    return rest[shown], columns[shown], images


def _is_bent(rest: Array, columns: Array) -> bool:
    """Return whether a bend explains nearly all of what is off."""
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    left = rest - scaled @ np.linalg.lstsq(scaled, rest, rcond=1e-9)[0]
    least, factor = BENT
    off = float(np.sqrt(np.mean(rest**2)))
    return off > max(least, factor * float(np.sqrt(np.mean(left**2))))


def _on_plane(
    stereo: Stereo,
    folding: Folding,
    half: HalfInSpace,
    pixels: Array,
    ring: bool,
    form: SimpleForm,
    off: float,
) -> tuple[Folding, HalfInSpace, SimpleForm] | None:
    """Return the folding whose places lie in a plane, and the half that they make."""
    normal, away = form.planes[0, :3], float(form.planes[0, 3])
    angle = float(np.arctan2(normal[2], normal[0]))
    crossings = _crossings(stereo, folding, pixels, ring, angle, away)
    points = _met(stereo, folding.pairing.near, angle, away)[0]
    if crossings is None or not np.isfinite(points).all():
        return None
    # The crossing has moved: what is on its other side now belongs to the other half.
    side = np.sign(float(np.median(points[:, 1])))
    keep = side * points[:, 1] > ALIKE * float(np.linalg.norm(np.ptp(points, axis=0)))
    if keep.sum() < 2:
        return None
    pairing = folding.pairing
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


def _crossings(
    stereo: Stereo, folding: Folding, pixels: Array, ring: bool, angle: float, away: float
) -> Array | None:
    """Return where the flat curve crosses the centre plane, nearest to where it was folded, px."""
    line = np.vstack((pixels, pixels[:1])) if ring else pixels
    heights = _met(stereo, line, angle, away)[0][:, 1]
    if not np.isfinite(heights).all():
        return None
    steps = np.flatnonzero(heights[:-1] * heights[1:] <= 0.0)
    if len(steps) < len(folding.crossings):
        return None
    share = heights[steps] / (heights[steps] - heights[steps + 1] + 1e-300)
    places = line[steps] + share[:, None] * (line[steps + 1] - line[steps])
    chosen = [int(np.linalg.norm(places - old, axis=1).argmin()) for old in folding.crossings]
    return None if len(set(chosen)) < len(chosen) else places[chosen]
