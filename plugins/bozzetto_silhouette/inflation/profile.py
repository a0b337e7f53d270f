"""Thickness from a profile that was drawn from another view.

Seen from the side a part has a height over every place along it, from left to right of that
view. The profile says what this height shall be. The surface is stretched in depth by the
ratio of the two, so that what is seen from that side is what was drawn, and the silhouette
stays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.view import Camera
from bozzetto_silhouette.model.state import Part
from bozzetto_silhouette.outline.domain_mesh import Plan
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.outline.normalized import Frame

FACE_ON = 0.35
"""Sine of the angle between the line of sight and the sheet's normal below which the part is
seen from the front, and depth cannot be drawn: 20 degrees."""

ASLANT = 0.5
"""A further stroke may be drawn from another view, up to 60 degrees off the first."""

COLUMNS = 256
"""Places along the part at which heights are compared."""

ONE_SIDED = 0.25
"""Where one side is drawn along less than this share of the other, the other stands for it."""

SHORTEST = 0.1
"""Share of the part that has to be drawn along, and height in sizes (a hundredth of it) below
which a line lies in the sheet."""

LEAST, MOST = 0.05, 20.0
"""Bounds of the factor."""

CALM = 0.012
"""Half width over which the factor is averaged along the part, as a share of it: jitter goes."""

FADE = 0.12
"""Beyond the ends of the profile the factor goes back to 1 within this share of the part."""


@dataclass(frozen=True, eq=False)
class Profile:
    """Heights and depths along an axis on the sheet, all in the object frame, mm.

    Attributes
    ----------
    axis : (2,) float array
        Unit vector on the sheet.
    places : (c,) float array
        Coordinates along the axis, evenly spaced over the part.
    front, back : (c,) float array
        Wanted height and depth, NaN where nothing was drawn. The same array twice where only
        one side was drawn.
    """

    axis: Array
    places: Array
    front: Array
    back: Array

    def factors(self, frame: Frame, plan: Plan, front: Array, back: Array) -> tuple[Array, Array]:
        """Return the wanted height over the present one, at every point's place on the axis."""
        along = (plan.points * frame.scale + frame.origin) @ self.axis
        up = self._factor(plan, along, np.sqrt(front) * frame.scale, self.front)
        if self.back is self.front and back is front:
            return up, up
        return up, self._factor(plan, along, np.sqrt(back) * frame.scale, self.back)

    def _factor(self, plan: Plan, along: Array, height: Array, wanted: Array) -> Array:
        from scipy.ndimage import gaussian_filter1d

        t = plan.triangles
        a, b = t.ravel(), np.roll(t, -1, axis=1).ravel()
        own = highest_crossings(along[a], height[a], along[b], height[b], self.places)
        drawn = np.isfinite(wanted)
        known = drawn & (own > 0.0)
        if not known.any():
            return np.ones(len(along))
        ratio = np.ones(len(own))
        ratio[known] = np.clip(wanted[known] / own[known], LEAST, MOST)
        # Where the part is thin the ratio of two small heights has little to say.
        weight = np.where(known, own**2, 0.0)
        total = gaussian_filter1d(weight, CALM * COLUMNS, mode="constant")
        power = gaussian_filter1d(weight * np.log(ratio), CALM * COLUMNS, mode="constant")
        power = np.interp(
            self.places, self.places[known], power[known] / np.maximum(total[known], 1e-300)
        )
        ends = self.places[np.flatnonzero(drawn)[[0, -1]]]
        beyond = np.maximum(np.maximum(ends[0] - along, along - ends[1]), 0.0)
        share = np.clip(beyond / (FADE * (self.places[-1] - self.places[0])), 0.0, 1.0)
        fade = 1.0 - share * share * (3.0 - 2.0 * share)
        factor: Array = np.exp(fade * np.interp(along, self.places, power))
        return factor


def highest_crossings(x0: Array, y0: Array, x1: Array, y1: Array, columns: Array) -> Array:
    """Return the highest crossing of segments with each of evenly spaced columns; -inf for none.

    Parameters
    ----------
    x0, y0, x1, y1 : (n,) float arrays
        Ends of the segments.
    columns : (c,) float array
        Increasing.
    """
    step = columns[1] - columns[0]
    low, high = np.minimum(x0, x1), np.maximum(x0, x1)
    first = np.ceil((low - columns[0]) / step - 1e-9)
    last = np.floor((high - columns[0]) / step + 1e-9)
    first = np.clip(first, 0, len(columns)).astype(np.intp)
    last = np.clip(last, -1, len(columns) - 1).astype(np.intp)
    count = np.maximum(last - first + 1, 0)
    segment = np.repeat(np.arange(len(x0)), count)
    column = np.arange(len(segment)) - np.repeat(np.cumsum(count) - count, count) + first[segment]
    span = x1[segment] - x0[segment]
    upright = np.abs(span) < 1e-12 * step
    share = np.clip((columns[column] - x0[segment]) / np.where(upright, 1.0, span), 0.0, 1.0)
    y = y0[segment] + share * (y1[segment] - y0[segment])
    y = np.where(upright, np.maximum(y0[segment], y1[segment]), y)
    best = np.full(len(columns), -np.inf)
    np.maximum.at(best, column, y)
    return best


def understood(part: Part) -> None:
    """Check that a part's profile can be read.

    Raises
    ------
    UserError
        If it cannot; says what to do instead.
    """
    profile_of(part)


def profile_of(part: Part) -> Profile:
    """Read the profile that a part's ink describes.

    The cameras of the strokes see the part where it was drawn, before its pose: ink that was
    drawn over a part that had been moved is moved back first (`Stroke.moved`).

    Raises
    ------
    UserError
        If it was drawn from the front, beside the part, or along the sheet itself.
    """
    outline = outline_of(part)
    low, high = outline.bounds
    middle = part.sheet.to_world(0.5 * (low + high)[None])[0]
    first = part.profile[0]
    across = _line_of_sight(part, first.camera, middle)[:2]
    if float(np.hypot(*across)) < FACE_ON:
        raise UserError(
            "From here the part is seen face-on. Turn the view to its side, then draw how thick "
            "it is."
        )
    across /= np.hypot(*across)
    axis = np.array([-across[1], across[0]])
    segments = []
    for stroke in part.profile:
        view_rays = _line_of_sight(part, stroke.camera, middle)
        if float(view_rays[:2] @ across) < ASLANT * FACE_ON:
            raise UserError(
                "This line was drawn from another side than the profile so far. Draw the whole "
                "profile from one view."
            )
        facing = part.sheet.turn(np.array([[*across, 0.0]]))[0]
        away = stroke.camera.on_plane(stroke.points, middle, facing) - part.sheet.origin
        if not np.isfinite(away).all():
            raise UserError(
                "The profile runs out of sight. Draw it within the view, beside the part."
            )
        along = away @ part.sheet.turn(np.array([[*axis, 0.0]]))[0]
        depth = away @ part.sheet.normal
        segments.append(np.stack([along[:-1], depth[:-1], along[1:], depth[1:]]))
    x0, z0, x1, z1 = np.concatenate(segments, axis=1)
    extent = np.concatenate([ring @ axis for ring in outline.rings])
    places = np.linspace(extent.min(), extent.max(), COLUMNS)
    sides = []
    for sign in (1.0, -1.0):
        side = highest_crossings(x0, sign * z0, x1, sign * z1, places)
        sides.append(np.where(side > 0.0, side, np.nan))
    drawn = [int(np.isfinite(side).sum()) for side in sides]
    if max(drawn) < SHORTEST * COLUMNS:
        raise UserError(
            "The profile is not over the part. Draw it along the part as it is seen from here."
        )
    if max(float(np.nanmax(s, initial=0.0)) for s in sides) < 0.01 * SHORTEST * outline.size:
        raise UserError(
            "The profile lies in the part's own plane. Draw it as far above as the part shall "
            "be thick."
        )
    front, back = (_without_gaps(side) for side in sides)
    if drawn[1] < ONE_SIDED * drawn[0]:
        back = front
    elif drawn[0] < ONE_SIDED * drawn[1]:
        front = back
    return Profile(axis, places, front, back)


def _line_of_sight(part: Part, camera: Camera, middle: Array) -> Array:
    """Return the unit vector away from the eye at a world point, in the object frame."""
    ahead = camera.axes[2]
    if camera.kind == "perspective":
        ahead = middle - camera.eye
        ahead = ahead / max(float(np.linalg.norm(ahead)), 1e-300)
    sheet = part.sheet
    return np.array([ahead @ sheet.right, ahead @ sheet.up, ahead @ sheet.normal])


def _without_gaps(side: Array) -> Array:
    """Fill in missing values between drawn ones, from their neighbours."""
    known = np.flatnonzero(np.isfinite(side))
    if not len(known):
        return side
    between = np.arange(known[0], known[-1] + 1)
    filled = side.copy()
    filled[between] = np.interp(between, known, side[known])
    return filled
