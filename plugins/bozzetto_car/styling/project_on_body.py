"""Project lines of the sheet onto the body, and bridge small gaps.

Every place of a line goes along its ray to the patch that is seen there. The line is cut where
the body ends, and where one part of it hides another. A line along the outline of the body
sometimes leaves it by a pixel: such gaps are bridged on the body.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.geometry.patches import Places, foot_points, normals_at, points_at, ray_hits
from bozzetto.ink import arc_length, distances_to_polyline
from bozzetto.scene import depth_breaks, unbroken_runs
from bozzetto.view import Camera
from bozzetto_car.styling.surface_path import connect_places, join_paths
from bozzetto_car.template.model import Template

FINEST: Final = 0.25
"""Distance, px, to which the rim of the body and its breaks are located."""

EDGE_ON: Final = 1e-6
"""Least cosine between normal and line of sight at which the body counts as seen."""

FAR: Final = 60.0
"""Distance of neighbours, mm, from which places are added between them. Where the body is seen
nearly edge-on, a few px are half a metre of it."""

COARSE: Final = 0.04
"""Step in u or v from which places are added, too: on narrow or sheared patches, as in the corner
of a window, a straight line is a hairpin in u and v."""

NEAR_MISS: Final = 4.0
"""Largest distance, px, of a bridge over a gap from the line."""

STEEPEST: Final = 4.0
"""Difference in depth per distance across the line of sight, from one end of a gap to the other,
beyond which its ends belong to different parts of the body."""


@dataclass(frozen=True, eq=False)
class Seen:
    """The places of the body that are seen at places on the sheet.

    Attributes
    ----------
    places : Places
        Patch −1 where the view shows nothing, or the inside.
    points, normals, sight : (n, 3) float
        mm; 0 where there is nothing. Sight is the unit direction of each ray.
    """

    places: Places
    points: Array
    normals: Array
    sight: Array

    @property
    def hit(self) -> Flags:
        """Whether the body is seen, (n,)."""
        return self.places.patches >= 0

    @property
    def breaks(self) -> Flags:
        """Whether the body cannot lead from one neighbour to the next, (n − 1,)."""
        broken = depth_breaks(self.points, self.normals, self.sight)
        return np.asarray(broken & self.hit[1:] & self.hit[:-1])

    def extended(self, other: Seen) -> Seen:
        """Return these places followed by those of another."""
        return Seen(
            join_paths([self.places, other.places]),
            np.concatenate((self.points, other.points)),
            np.concatenate((self.normals, other.normals)),
            np.concatenate((self.sight, other.sight)),
        )

    def __getitem__(self, which: Index) -> Seen:
        return Seen(self.places[which], self.points[which], self.normals[which], self.sight[which])


class Part(NamedTuple):
    """A part of a line that is on the body: where on the line, px; its places; lines of sight."""

    way: Array
    places: Places
    sight: Array

    @classmethod
    def of(cls, *parts: Part) -> Part:
        """Parts one after the other."""
        way, sight = (np.concatenate([part[k] for part in parts]) for k in (0, 2))
        return cls(way, join_paths([part.places for part in parts]), sight)


def seen_on_body(nets: Array, pixels: Array, camera: Camera) -> Seen:
    """Return the places of the body, (k, 4, 4, 3) mm, that are seen at places (n, 2) px."""
    origins, sight = camera.rays(pixels)
    places = ray_hits(nets, origins, sight)[0]
    points, normals = np.zeros((2, len(sight), 3))
    hit = places.patches >= 0
    normals[hit] = normals_at(nets, places[hit])
    hit &= (normals * sight).sum(axis=1) < -EDGE_ON
    points[hit] = points_at(nets, places[hit])
    normals[~hit] = 0.0
    kept = Places(np.where(hit, places.patches, -1), hit[:, None] * places.parameters)
    return Seen(kept, points, normals, sight)


def project_line(template: Template, nets: Array, line: Array, camera: Camera) -> list[Places]:
    """Project a line onto the visible side of the body.

    Parameters
    ----------
    template : Template
        The template of the body.
    nets : (k, 4, 4, 3) float
        Control nets of the body, mm.
    line : (n, 2) float
        Places that differ, a few px apart.
    camera : Camera
        The view.

    Returns
    -------
    list of Places
        Paths of two places or more, in the order of the line; see `surface_path`.

    Raises
    ------
    UserError
        If the line misses the body.
    """
    from scipy.interpolate import CubicSpline

    way = arc_length(line)
    own, curve = way, CubicSpline(way, line)
    seen = seen_on_body(nets, line, camera)
    while True:
        far = _far(seen)
        open_ = np.flatnonzero((far | _unclear(seen)) & (np.diff(way) > FINEST))
        if not len(open_):
            break
        fresh = 0.5 * (way[open_] + way[open_ + 1])
        own = np.append(own, fresh[far[open_]])
        order = np.argsort(np.concatenate((way, fresh)), kind="stable")
        way = np.concatenate((way, fresh))[order]
        seen = seen.extended(seen_on_body(nets, curve(fresh), camera))[order]
    paths: list[Places] = []
    for part in _bridged(nets, seen, way, line, camera):
        passing = ~np.isin(part.way, own)
        paths += connect_places(template, nets, part.places, part.sight, passing)
    paths = [path for path in paths if len(path) > 1]
    if not paths:
        raise UserError("The stroke misses the body. Draw on the car.")
    return paths


def _unclear(seen: Seen) -> Flags:
    """Whether a break or a rim must be located between neighbours, (n − 1,)."""
    patches = seen.places.patches
    return np.asarray((patches[1:] != patches[:-1]) | seen.breaks)


def _far(seen: Seen) -> Flags:
    """Whether neighbours are far from each other on the body or on their patch, (n − 1,)."""
    patches, both = seen.places.patches, seen.hit[1:] & seen.hit[:-1]
    far = np.linalg.norm(np.diff(seen.points, axis=0), axis=1) > FAR
    step = np.abs(np.diff(seen.places.parameters, axis=0)).max(axis=1)
    return np.asarray(both & (far | ((patches[1:] == patches[:-1]) & (step > COARSE))))


def _bridged(nets: Array, seen: Seen, way: Array, line: Array, camera: Camera) -> list[Part]:
    """Return the unbroken parts of a line, joined over gaps that the body can bridge."""
    parts: list[Part] = []
    last = -1
    for run in unbroken_runs(seen.hit, seen.breaks):
        part = Part(way[run], seen.places[run], seen.sight[run])
        bridge = None if last < 0 else _bridge(nets, seen, (last, int(run[0])), way, line, camera)
        if bridge is None:
            parts.append(part)
        else:
            parts[-1] = Part.of(parts[-1], bridge, part)
        last = int(run[-1])
    return parts


def _bridge(
    nets: Array, seen: Seen, ends: tuple[int, int], way: Array, line: Array, camera: Camera
) -> Part | None:
    """Return the body along a gap between two places, if the line hardly leaves it there."""
    first, last = ends
    if last - first < 2:
        return None  # a part of the body behind another one
    step, sight = seen.points[last] - seen.points[first], seen.sight[first]
    depth = float(step @ sight)
    if abs(depth) > STEEPEST * float(np.linalg.norm(step - depth * sight)):
        return None
    there = way[first + 1 : last]
    share = (there - way[first]) / (way[last] - way[first])
    feet = foot_points(nets, seen.points[first] + share[:, None] * step)
    pixels = camera.project(points_at(nets, feet))[0]
    if not np.isfinite(pixels).all() or distances_to_polyline(pixels, line).max() > NEAR_MISS:
        return None
    return Part(there, feet, np.broadcast_to(sight, (len(feet), 3)))
