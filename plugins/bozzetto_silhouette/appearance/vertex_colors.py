"""The colours of the parts, carried through the tree to the surface that they make together.

The function of space that a body carries remembers how it was put together. Along a crease
the colours part as the bodies do; across a blend they pass into each other over its reach.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index
from bozzetto_silhouette.implicit.composite import Composite, box_distance
from bozzetto_silhouette.implicit.implicit_solid import Implicit, Placed
from bozzetto_silhouette.model.paint_stroke import Color
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.solids.body import Body

TIE = 0.02
"""Share of the mesh's step by which the later of two parts wins where both surfaces coincide:
what is drawn later lies on top, and rounding does not decide."""

CONTRAST = 12.0
"""Difference of colours, of 255, below which an edge between them is not seen."""

PULL = 0.5
"""How far the corners of a face are moved towards its middle, to tell on which side of a crease
they are: well off the crease, and near enough not to see a blend."""

_FALL = 0.5
"""Outside its box the value of every implicit solid falls at least at this rate."""


@dataclass(frozen=True, eq=False)
class Coat:
    """The colours of n points of a surface.

    Attributes
    ----------
    rgb : (n, 3) float array
        sRGB, 0 to 255, multiplied by the cover.
    cover : (n,) float array
        0 to 1: how much of its colour a point has of its own; the rest is the object's.
    """

    rgb: Array
    cover: Array

    def over(self, under: Coat) -> Coat:
        """Lay the coat on another one."""
        bare_share = 1.0 - self.cover
        return Coat(
            self.rgb + bare_share[:, None] * under.rgb, self.cover + bare_share * under.cover
        )

    def mixed(self, other: Coat, share: Array) -> Coat:
        """Mix in another coat, with a share (n,) from 0 to 1."""
        kept = 1.0 - share
        return Coat(
            kept[:, None] * self.rgb + share[:, None] * other.rgb,
            kept * self.cover + share * other.cover,
        )

    def at(self, index: Index) -> Coat:
        """Return the coat of some of the points."""
        return Coat(self.rgb[index], self.cover[index])

    def joined(self, more: Coat) -> Coat:
        """Append the coat of more points."""
        return Coat(np.concatenate([self.rgb, more.rgb]), np.concatenate([self.cover, more.cover]))

    def bytes(self) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """Return RGBA (n, 4) and cover (n,) as bytes, as meshes have them."""
        rgba = np.full((len(self.cover), 4), 255, np.uint8)
        own = self.rgb / np.maximum(self.cover, 1e-9)[:, None]
        rgba[:, :3] = np.rint(np.clip(own, 0.0, 255.0))
        return rgba, np.asarray(np.rint(255.0 * np.clip(self.cover, 0.0, 1.0)), np.uint8)


@dataclass(frozen=True, eq=False)
class Creases:
    """Corners of faces whose colour is not that of their vertex, because a crease runs there.

    Attributes
    ----------
    face, corner : (k,) int arrays
    coat : Coat
        Of the corners.
    """

    face: Index
    corner: Index
    coat: Coat


def bare(count: int) -> Coat:
    """Return a coat without colour."""
    return Coat(np.zeros((count, 3)), np.zeros(count))


def color_of(part: Part) -> Color | None:
    """Return a part's own colour, else that of its ink, else None."""
    if part.color is not None:
        return part.color
    return next((stroke.color for stroke in part.strokes if stroke.color is not None), None)


def part_coat(state: SilhouetteState, body: Body, points: Array | None = None) -> Coat | None:
    """Return the colours of a body's vertices, or of other points on it; None without colours.

    A part that carves or intersects gives its colour to the walls that it makes; without a
    colour it leaves them that of what it acts on.
    """
    colors = {part.id: color_of(part) for part in state.parts}
    if all(colors.get(source) is None for source in body.sources):
        return None
    counted = sum(1 for _ in _leaves(body.implicit))
    if counted != len(body.sources):  # several parts solved as one
        return None if points is not None else coat_of_origins(state, body)
    painted = _Painted([colors.get(source) for source in body.sources], TIE * body.step)
    return painted.at(body.implicit, body.vertices if points is None else points, body.step)[1]


def coat_of_origins(state: SilhouetteState, body: Body) -> Coat | None:
    """Return for a body's vertices the colours of the parts they came from; None without colours.

    Nothing passes from one colour into another.
    """
    colors = {part.id: color_of(part) for part in state.parts}
    if all(colors.get(source) is None for source in body.sources):
        return None
    table = bare(len(body.sources))
    for index, source in enumerate(body.sources):
        color = colors.get(source)
        if color is not None:
            table.rgb[index], table.cover[index] = color, 1.0
    return Coat(table.rgb[body.origins], table.cover[body.origins])


def creases_between(state: SilhouetteState, body: Body, coat: Coat) -> Creases | None:
    """Find where the colours of vertices would run over a sharp edge; None where they do not.

    Parameters
    ----------
    state : SilhouetteState
        What was drawn.
    body : Body
        The whole shape.
    coat : Coat
        Of the body's vertices.
    """
    if not _has_crease(body.implicit):
        return None
    at_vertices = np.column_stack([coat.rgb, 255.0 * coat.cover])
    of_corners = at_vertices[body.faces]
    crossed = np.flatnonzero(np.ptp(of_corners, axis=1).max(axis=1) > CONTRAST)
    corners = body.vertices[body.faces[crossed]]
    inside = corners + PULL * (corners.mean(axis=1, keepdims=True) - corners)
    own = part_coat(state, body, inside.reshape(-1, 3)) if len(crossed) else None
    if own is None:
        return None
    there = np.column_stack([own.rgb, 255.0 * own.cover]).reshape(-1, 3, 4)
    wrong = np.abs(there - of_corners[crossed]).max(axis=2) > CONTRAST
    if not wrong.any():
        return None
    row, corner = np.nonzero(wrong)
    chosen = 3 * row + corner
    return Creases(crossed[row], corner, own.at(chosen))


def _leaves(solid: Implicit) -> Iterator[Implicit]:
    """Return the solids that a solid was combined from, in the order of its sources."""
    if isinstance(solid, Placed):
        yield from _leaves(solid.inner)
    elif isinstance(solid, Composite):
        yield from _leaves(solid.first)
        yield from _leaves(solid.second)
    else:
        yield solid


def _has_crease(solid: Implicit) -> bool:
    if isinstance(solid, Placed):
        return _has_crease(solid.inner)
    if not isinstance(solid, Composite):
        return False
    return solid.reach <= 0.0 or _has_crease(solid.first) or _has_crease(solid.second)


class _Painted:
    """A walk through the solids that a solid was put together from.

    Parameters
    ----------
    colors : list of (r, g, b) or None
        Of the leaves, in order.
    tie : float
        Difference of values up to which the later solid wins.
    """

    def __init__(self, colors: list[Color | None], tie: float) -> None:
        self._colors = iter(colors)
        self._tie = tie

    def at(self, solid: Implicit, points: Array, slack: float) -> tuple[Array, Coat]:
        """Return values and colours at points (n, 3).

        Parameters
        ----------
        solid : Implicit
            The solid, or one that it was combined from.
        points : (n, 3) float array
            Places in the frame of the solid.
        slack : float
            How far outside a solid it may still matter. Beyond, the value is only a bound.
        """
        if isinstance(solid, Placed):
            scale = solid.placement.scale
            back = solid.placement.inverse().points(points)
            value, coat = self.at(solid.inner, back, slack / scale)
            return value * scale, coat
        if isinstance(solid, Composite):
            return self._combined(solid, points, slack + 2.0 * solid.reach)
        color = next(self._colors)
        coat = bare(len(points))
        if color is not None:
            coat.rgb[:], coat.cover[:] = color, 1.0
        value = -_FALL * box_distance(points, solid.bounds)
        near = np.flatnonzero(value > -slack)
        value[near] = solid.value(points[near])
        return value, coat

    def _combined(self, solid: Composite, points: Array, slack: float) -> tuple[Array, Coat]:
        first, under = self.at(solid.first, points, slack)
        second, coat = self.at(solid.second, points, slack)
        if solid.operation in ("add", "merge"):
            return np.maximum(first, second), under.mixed(coat, self._share(first, second, solid))
        if solid.operation == "carve":
            second = -second
        wall = self._share(second, first, solid)
        whole = Coat(coat.rgb * wall[:, None], coat.cover * wall).over(under)
        return np.minimum(first, second), whole

    def _share(self, first: Array, second: Array, solid: Composite) -> Array:
        """Return the share of the second of two solids, by how far it exceeds the first."""
        if solid.reach <= 0.0:
            return np.asarray(second - first >= -self._tie, np.float64)
        t = np.clip(0.5 + 0.5 * (second - first) / solid.reach, 0.0, 1.0)
        return np.asarray(t * t * (3.0 - 2.0 * t), np.float64)
