"""Meshes of the wheels: tyre, rim and spokes, and the gap below the arch in the body.

A template has no wheel arches: its panels run down to the sill, and wheels stand inside them. So
the outer face of a wheel is set just outside the panel beside it, and the gap below the arch is a
dark band on the panel around it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any, Final, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.arrays import Array
from bozzetto.geometry import Mesh
from bozzetto.geometry.patches import bernstein, grid
from bozzetto.plugin import remembered
from bozzetto_car.template.network import Network
from bozzetto_car.tyre_size import TyreSize, tyre_size

Color = tuple[int, int, int, int]
Piece = tuple[Array, Array, NDArray[np.integer[Any]], Array]

RUBBER: Final = (46, 45, 44, 255)
METAL: Final = (198, 196, 192, 255)
SHADED_METAL: Final = (122, 120, 117, 255)
DARK: Final = (30, 29, 28, 255)

TURNED: Final[tuple[tuple[Color, tuple[tuple[float, float], ...]], ...]] = (
    (RUBBER, ((0.700, -0.020), (0.725, -0.004), (0.80, 0.0), (0.90, -0.012), (0.965, -0.045),
              (0.99, -0.09), (1.0, -0.16), (1.0, -0.46), (0.99, -0.53), (0.93, -0.60),
              (0.70, -0.62))),
    (METAL, ((0.645, -0.030), (0.665, -0.012), (0.69, -0.008), (0.705, -0.020))),
    (SHADED_METAL, ((0.63, -0.052), (0.645, -0.030))),
    (DARK, ((0.0, -0.052), (0.63, -0.052))),
    (METAL, ((0.0, -0.012), (0.09, -0.016), (0.125, -0.028), (0.135, -0.050))),
)  # fmt: skip
"""Parts turned about the axle: colour and section, as distances from the axle and places along
it, per radius of the wheel. The outermost place is 0, inward is below."""

RIM: Final = 0.70
"""Where a tyre begins in these sections: radius of the rim per radius of the wheel."""

WIDTH: Final = 0.62
"""Width of the tyre in these sections, per radius of the wheel."""

SPOKES: Final = 10

SPOKE: Final = ((0.10, 0.050, -0.030), (0.38, 0.030, -0.026), (0.655, 0.036, -0.016))
"""Of a spoke from the hub to the rim: distance from the axle, half width, and place along it."""

SPOKE_DEPTH: Final = 0.028
"""Depth of the flanks of a spoke, per radius."""

STEPS: Final = 56
"""Steps around the axle."""

DEEPEST: Final = 0.055
"""Depth of a rim, per radius: the panel beside the wheel lies behind it."""

FELT: Final = (0.05, 0.36, 0.68)
"""Circles, per radius, on which the place of the panel beside a wheel is measured."""

GAP: Final = (0.88, 0.98, 1.075)
"""Circles, per radius, of the band that shows the gap below the arch."""

LAID: Final = 4.0
"""Distance of the band outside the panel, mm: more than triangles of the body differ from it."""

GUESSES: Final = 7
"""Places along each side of a patch from which the search for a place seen from the side starts."""

REFINED: Final = 5
"""Steps of Newton's method in this search."""

MET: Final = 0.1
"""Distance, mm, at which the search has found the place."""

OVER_EDGE: Final = 1e-3
"""How far beyond its border a patch counts, in u and v, so that there is no slit between two."""

REMEMBERED: Final = 8
"""Number of cars on tyres, and of sizes of wheels, that are remembered."""

NO_ARCHES: Final[Mapping[int, float]] = MappingProxyType({})
"""Of a car whose arches are not cut."""

OVER_HULL: Final = 0.05
"""How far a patch may reach beyond its control points there, as a share of their box: more than
six times `OVER_EDGE` on each axis, for the weights of control points are within −3 and 1 + 3
times it."""


def on_tyres(network: Network, tyre: str) -> Network:
    """Return a car that stands on tyres of a size (`tyre_size`): its axles are as high as these.

    Parameters
    ----------
    network : Network
        The car; its wheels stand on the ground, so that their height is their radius.
    tyre : str
        "" for the wheels as they are.
    """
    size = tyre_size(tyre)
    return network if size is None else _on_tyres(network, size)


@remembered(limit=REMEMBERED)
def _on_tyres(network: Network, size: TyreSize) -> Network:
    positions = network.positions.copy()
    positions[network.template.wheels.ravel(), 2] = 0.5 * size.diameter
    return replace(network, positions=positions)


@dataclass(frozen=True)
class Proportions:
    """Sizes of a wheel relative to those of the sections.

    Parameters
    ----------
    rim : float
        Radius of the rim per `RIM` radii of the wheel.
    width : float
        Width of the tyre per `WIDTH` radii of the wheel.
    """

    rim: float = 1.0
    width: float = 1.0

    @classmethod
    def of(cls, tyre: str) -> Self:
        """Return those of a size of tyres; of the sections themselves where it is ""."""
        size = tyre_size(tyre)
        if size is None:
            return cls()
        return cls(size.rim / (RIM * size.diameter), 2.0 * size.width / (WIDTH * size.diameter))

    def section(self, places: ArrayLike) -> Array:
        """Return places of a section, distance from the axle and way along it, (k, 2)."""
        away, along = np.asarray(places, float).T
        beyond = (1.0 - RIM * self.rim) / (1.0 - RIM) * (away - RIM) + RIM * self.rim
        sized = np.where(away <= RIM, self.rim * away, beyond)
        return np.stack((away if self.rim == 1.0 else sized, self.width * along), axis=1)

    @property
    def spokes(self) -> Array:
        """Rows of a spoke as in `SPOKE`, (k, 3)."""
        return np.asarray(np.array(SPOKE) * (self.rim, self.rim, self.width))


class WheelMeshes(NamedTuple):
    """A right wheel as it is seen.

    Attributes
    ----------
    tyre : Mesh
        With the gap below its arch.
    rim : Mesh
    centre : (3,) float
        mm.
    radius : float
        mm.
    reach : float
        How far right the panel beside it reaches, mm.
    """

    tyre: Mesh
    rim: Mesh
    centre: Array
    radius: float
    reach: float


def wheel_meshes(
    network: Network, nets: Array, tyre: str = "", arches: Mapping[int, float] = NO_ARCHES
) -> list[WheelMeshes]:
    """Return the meshes of the right wheels that are above the ground, front first.

    Parameters
    ----------
    network : Network
        The car; its wheels stand on the ground, so that their height is their radius.
    nets : (k, 4, 4, 3) array_like
        The patches of the body, mm.
    tyre : str
        Size of its tyres; "" for those of the sections.
    arches : mapping of int to float
        Radius of the arch, mm, that the gap of the front (0) and the rear wheel (1) reaches to.
    """
    sizes = Proportions.of(tyre)
    wheels, made = _wheels(network), []
    gaps = np.tile(GAP, (len(wheels), 1))
    for row, (number, _, radius) in zip(gaps, wheels, strict=True):
        row[-1] = arches.get(number, row[-1] * radius) / radius
    for (_, centre, radius), (reach, band) in zip(wheels, _beside(nets, wheels, gaps), strict=True):
        face = reach + DEEPEST * sizes.width * radius
        to = (centre[0], face, centre[2])
        rubber, metal = (
            (vertices * radius + to, normals, faces, colors)
            for vertices, normals, faces, colors in _unit_wheel(sizes)
        )
        seen = (_as_mesh(_joined([rubber, *_gap(band)])), _as_mesh(metal))
        made.append(WheelMeshes(*seen, centre, radius, reach - LAID))
    return made


def _wheels(network: Network) -> list[tuple[int, Array, float]]:
    """Return number, centre and radius, mm, of the right wheels that are above the ground."""
    centres = network.positions[network.template.wheels[:, 0]]
    return [(at, own, float(own[2])) for at, own in enumerate(centres) if own[2] > 0.0]


# -- the body beside a wheel -----------------------------------------------------------------------


def _beside(
    nets: Array, wheels: list[tuple[int, Array, float]], gaps: Array
) -> list[tuple[float, Array]]:
    """Return how far the panel beside each wheel reaches, mm, and the circles (c, n, 3) of its gap.

    Their radii, per radius of the wheel, are the rows of `gaps`. Both are `LAID` outside the panel.
    Places on the circles where there is no panel are NaN.
    """
    if not wheels:
        return []
    centres = np.array([centre for _, centre, _ in wheels])
    radii = np.array([radius for _, _, radius in wheels])
    ring = np.linspace(0.0, 2.0 * np.pi, STEPS, endpoint=False) - 0.5 * np.pi
    shares = np.concatenate((np.tile(FELT, (len(wheels), 1)), gaps), axis=1)
    circles = radii[:, None, None] * shares[..., None]
    x = centres[:, 0, None, None] + circles * np.cos(ring)
    z = centres[:, 2, None, None] + circles * np.sin(ring)
    y = _panel(nets, np.stack((x.ravel(), z.ravel()), axis=1)).reshape(x.shape) + LAID
    places, found = np.stack((x, y, z), axis=-1), []
    for (_, centre, _), felt, own in zip(wheels, y[:, :-1], places, strict=True):
        reach = float(np.max(felt[np.isfinite(felt)], initial=float(centre[1])))
        found.append((reach, own[len(FELT) :]))
    return found


def _panel(nets: Array, places: Array) -> Array:
    """Return how far right the body reaches at places (n, 2), x and z; NaN where it does not."""
    flat = nets[..., [0, 2]].reshape(len(nets), -1, 2)
    low, high = flat.min(axis=1), flat.max(axis=1)
    more = MET + OVER_HULL * (high - low)
    inside = (places >= (low - more)[:, None]) & (places <= (high + more)[:, None])
    # No patch is seen at a place outside the box of its control points.
    near = inside.all(axis=2) & (nets[..., 1].max(axis=(1, 2)) > 0.0)[:, None]
    kept = np.flatnonzero(near.any(axis=1))
    own, flat = nets[kept], flat[kept]
    at = np.linspace(0.0, 1.0, GUESSES)
    laid = grid(own, at, at)[..., [0, 2]].reshape(len(own), GUESSES**2, 2)
    patch, place = np.nonzero(near[kept])
    # Squared distances, without the term that is equal for all places of the patches.
    away = (laid**2).sum(axis=2)[:, None] - 2.0 * places @ laid.transpose(0, 2, 1)
    first = away.argmin(axis=2)[patch, place]
    u, v = at[first // GUESSES], at[first % GUESSES]
    patches, goals = own.reshape(-1, 4, 12)[patch], places[place]
    for _ in range(REFINED):
        met, by_u, by_v = _seen_from_side(patches, u, v)
        way = goals - met[:, ::2]
        area = by_u[:, 0] * by_v[:, 1] - by_u[:, 1] * by_v[:, 0]
        area = np.where(np.abs(area) > 1.0, area, np.inf)
        u = u + (way[:, 0] * by_v[:, 1] - way[:, 1] * by_v[:, 0]) / area
        v = v + (by_u[:, 0] * way[:, 1] - by_u[:, 1] * way[:, 0]) / area
        u, v = (np.clip(at, -OVER_EDGE, 1.0 + OVER_EDGE) for at in (u, v))
    met, _, _ = _seen_from_side(patches, u, v)
    good = np.linalg.norm(met[:, ::2] - goals, axis=1) <= MET
    highest = np.full(len(places), -np.inf)
    np.maximum.at(highest, place[good], met[good, 1])
    return np.where(np.isfinite(highest), highest, np.nan)


def _seen_from_side(nets: Array, u: Array, v: Array) -> tuple[Array, Array, Array]:
    """Return places on patches, and their derivatives by u and by v in x and z.

    Parameters
    ----------
    nets : (n, 4, 12) float
        Control points of a patch for each place, mm: along u, and those along v in a row.
    u, v : (n,) float
        The parameters of the places.

    Returns
    -------
    place : (n, 3) float
    by_u, by_v : (n, 2) float
    """
    both_ways = np.concatenate((u, v))
    weights = np.stack((bernstein(both_ways), bernstein(both_ways, 1)), axis=1)
    along, across = weights[: len(u)] @ nets, weights[len(u) :]
    here, ahead = along.reshape(-1, 2, 4, 3).transpose(1, 0, 2, 3)
    both = across @ here
    return both[:, 0], (across[:, :1] @ ahead)[:, 0, ::2], both[:, 1, ::2]


def _gap(band: Array) -> list[Piece]:
    """Return the band of the gap around a wheel, where its circles lie on the panel."""
    rows, count = band.shape[:2]
    at = np.arange(rows * count).reshape(rows, count)
    quads = np.stack(
        (at[:-1], np.roll(at[:-1], -1, axis=1), np.roll(at[1:], -1, axis=1), at[1:]), axis=-1
    ).reshape(-1, 4)
    quads = quads[np.isfinite(band[..., 1]).ravel()[quads].all(axis=1)]
    if not len(quads):
        return []
    used, faces = np.unique(quads[:, [0, 1, 2, 0, 2, 3]], return_inverse=True)
    vertices = band.reshape(-1, 3)[used]
    normals = np.tile((0.0, 1.0, 0.0), (len(vertices), 1))
    return [(vertices, normals, faces.reshape(-1, 3), _paint(DARK, len(vertices)))]


# -- a wheel ---------------------------------------------------------------------------------------


@lru_cache(maxsize=REMEMBERED)
def _unit_wheel(sizes: Proportions) -> tuple[Piece, Piece]:
    """Return tyre and rim of a right wheel of radius 1 whose outer face is at y = 0."""
    tyre, *rim = (_turned(color, sizes.section(line)) for color, line in TURNED)
    spoke = _spoke(sizes)
    turns = np.arange(SPOKES) * 2.0 * np.pi / SPOKES
    return tyre, _joined([*rim, *(_turned_about(spoke, float(turn)) for turn in turns)])


def _turned(color: Color, section: Array) -> Piece:
    """Turn a section (k, 2) about the axle, with smooth normals along it."""
    ring = np.linspace(0.0, 2.0 * np.pi, STEPS + 1)
    away, along = (
        section[:, None, 0],
        np.broadcast_to(section[:, 1, None], (len(section), STEPS + 1)),
    )
    vertices = np.stack((away * np.cos(ring), along, away * np.sin(ring)), axis=-1)
    steps = np.diff(section, axis=0)
    across = np.stack((-steps[:, 1], steps[:, 0]), axis=1)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    tilt = np.concatenate((across[:1], across[:-1] + across[1:], across[-1:]))
    tilt /= np.linalg.norm(tilt, axis=1, keepdims=True)
    out, side = tilt[:, None, 0], np.broadcast_to(tilt[:, 1, None], along.shape)
    normals = np.stack((out * np.cos(ring), side, out * np.sin(ring)), axis=-1)
    at = np.arange(away.shape[0] * (STEPS + 1)).reshape(away.shape[0], -1)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]
    faces = np.stack((np.stack((a, b, c), -1), np.stack((a, c, d), -1)), -2).reshape(-1, 3)
    return vertices.reshape(-1, 3), normals.reshape(-1, 3), faces, _paint(color, vertices.size // 3)


def _spoke(sizes: Proportions) -> Piece:
    """Return a spoke along x: a face and two flanks."""
    away, half, along = sizes.spokes.T
    low, high = np.stack((away, along, -half), 1), np.stack((away, along, half), 1)
    deep = np.array((0.0, -SPOKE_DEPTH * sizes.width, 0.0))
    strips = (
        (METAL, low, high), (SHADED_METAL, high, high + deep), (SHADED_METAL, low + deep, low)
    )  # fmt: skip
    return _joined([_strip(color, one, other) for color, one, other in strips])


def _strip(color: Color, one: Array, other: Array) -> Piece:
    """Return a flat-shaded strip between two polylines (k, 3)."""
    corners = np.stack((one[:-1], one[1:], other[1:], other[:-1]), axis=1)
    normal = np.cross(corners[:, 3] - corners[:, 0], corners[:, 1] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    first = 4 * np.arange(len(corners))[:, None]
    faces = np.concatenate((first + np.array((0, 3, 2)), first + np.array((0, 2, 1))))
    vertices = corners.reshape(-1, 3)
    return vertices, np.repeat(normal, 4, axis=0), faces, _paint(color, len(vertices))


# -- pieces of meshes ------------------------------------------------------------------------------


def _paint(color: Color, count: int) -> Array:
    return np.tile(np.array(color, float), (count, 1))


def _turned_about(piece: Piece, turn: float) -> Piece:
    cos, sin = np.cos(turn), np.sin(turn)
    matrix = np.array([[cos, 0.0, -sin], [0.0, 1.0, 0.0], [sin, 0.0, cos]])
    return piece[0] @ matrix.T, piece[1] @ matrix.T, piece[2], piece[3]


def _joined(pieces: list[Piece]) -> Piece:
    starts = np.cumsum([0, *(len(piece[0]) for piece in pieces)])
    faces = [piece[2] + start for piece, start in zip(pieces, starts, strict=False)]
    vertices, normals, colors = (np.concatenate([p[n] for p in pieces]) for n in (0, 1, 3))
    return vertices, normals, np.concatenate(faces), colors


def _as_mesh(piece: Piece) -> Mesh:
    vertices, normals, faces, colors = piece
    return Mesh(
        vertices.astype(np.float32),
        faces.astype(np.int32),
        normals.astype(np.float32),
        colors.astype(np.uint8),
    )
