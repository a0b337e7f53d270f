"""What the tests of the symmetry modeler draw: known curves, views, hands, and recorded ink.

Everything is in the frame of the centre plane (y = 0, mm), in a box of 200 × 100 × 100.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import cKDTree

from bozzetto.ink.curves.resample import resample
from bozzetto.ink.curves.smooth import smooth
from bozzetto.view import Camera
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

Array = NDArray[np.float64]

DIAGONAL = float(np.linalg.norm((200.0, 100.0, 100.0)))
INK = Path(__file__).parents[4] / "shared/data/ink"
SHORTEST = 40.0
"""Recorded strokes below this length (px) are dots and ticks, no curves."""

S = np.linspace(0.0, 1.0, 300)
TURN = 2.0 * np.pi * np.arange(300) / 300.0


def _curve(x: Array, y: Array, z: Array) -> Array:
    return np.column_stack(np.broadcast_arrays(x, y, z)) * 100.0


def _whole(half: Array) -> Array:
    return np.vstack([(half * MIRROR)[:0:-1], half])


PAIRS = {
    "roof rail": _curve(
        -0.9 + 1.8 * S, 0.25 + 0.2 * np.sin(np.pi * S), -0.3 + 0.7 * np.sin(np.pi * S)
    ),
    "S-wave": _curve(
        -0.9 + 1.8 * S, 0.3 + 0.15 * np.cos(3 * np.pi * S), 0.35 * np.sin(2.5 * np.pi * S)
    ),
    "hook": _curve(0.8 * np.cos(1.5 * np.pi * S), 0.3 + 0.1 * S, 0.4 * np.sin(1.5 * np.pi * S)),
    "wheel arch": _curve(
        0.5 + 0.3 * np.cos(1.9 * np.pi * S),
        0.45 * np.ones(300),
        -0.2 + 0.3 * np.sin(1.9 * np.pi * S),
    ),
}
"""Sides of open pairs, (300, 3)."""

LOOPS = {
    "wheel": _curve(0.5 + 0.3 * np.cos(TURN), 0.45 * np.ones(300), -0.2 + 0.3 * np.sin(TURN)),
    "headlight": _curve(
        0.8 + 0.05 * np.cos(TURN),
        0.3 + 0.12 * np.cos(TURN),
        0.1 * np.sin(TURN) * (1 + 0.3 * np.cos(TURN)),
    ),
    "bean": _curve(
        0.5 * np.cos(TURN),
        0.3 + 0.1 * np.cos(TURN - 1),
        (0.2 + 0.1 * np.cos(TURN)) * np.sin(TURN) + 0.1 * np.cos(2 * TURN),
    ),
}
"""One loop of a closed pair, (300, 3), the first point not repeated."""

HALVES = {
    "windscreen base": _curve(0.5 - 0.35 * S**2, 0.48 * np.sin(np.pi / 2 * S), 0.1 + 0.05 * S**2),
    "hood U": _curve(
        0.9 - 2.4 * np.maximum(0, S - 0.35) ** 1.5,
        0.4 * np.sin(np.pi / 2 * np.minimum(1, 1.3 * S)),
        0.1 * S**2,
    ),
    "wavy bumper": _curve(0.9 - 0.2 * S**2, 0.45 * S, -0.1 + 0.12 * (1 - np.cos(2 * np.pi * S))),
}
"""Curves across the plane: the half from the plane outwards, (300, 3)."""

ACROSS = {name: _whole(half) for name, half in HALVES.items()}
"""The same whole, (599, 3)."""

RINGS = {
    "bonnet": _curve(0.3 + 0.5 * np.cos(TURN), 0.4 * np.sin(TURN), 0.15 * np.cos(TURN) ** 2),
    "grille": _curve(0.9 - 0.2 * np.sin(TURN) ** 2, 0.4 * np.sin(TURN), -0.1 + 0.15 * np.cos(TURN)),
}
"""Closed curves across the plane, (300, 3), the first point not repeated, and on the plane."""

FLAT = {
    "roof line": _curve(-0.9 + 1.8 * S, 0.0 * S, 0.4 * np.sin(np.pi * S)),
    "bonnet line": _curve(0.9 * S, 0.0 * S, 0.2 - 0.3 * S**2),
}
"""Curves in the plane, (300, 3)."""


def camera(
    azimuth: float,
    elevation: float,
    kind: Literal["perspective", "orthographic"] = "perspective",
    *,
    pixels: float = 400.0,
) -> Camera:
    """A view at an angle, degrees, from the centre plane, three diagonals away.

    Parameters
    ----------
    pixels : float
        How long the diagonal of the box is on the sheet.
    """
    a, e = np.radians((azimuth, elevation))
    eye = 3.0 * DIAGONAL * np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    opening = float(np.degrees(2.0 * np.arctan(450.0 / (3.0 * pixels))))
    return Camera(kind=kind, eye=tuple(eye), fov_y=opening, height=900.0 / pixels * DIAGONAL)


def tremor(count: int, size: float, random: np.random.Generator, *, closed: bool = False) -> Array:
    """What a hand adds: noise that is alike over a 25th of the curve, (count, 2) px."""
    reach = count / 25.0
    raw = random.standard_normal((count, 2))
    slow = gaussian_filter1d(raw, reach, axis=0, mode="wrap" if closed else "reflect")
    return np.asarray(size * slow / slow.std())


def drawn(
    curve: Array,
    view: Camera,
    *,
    noise: float = 0.0,
    sense: int = 1,
    trimmed: float = 0.0,
    random: np.random.Generator | None = None,
    closed: bool = False,
) -> Array:
    """A curve as somebody draws it.

    Parameters
    ----------
    curve : (n, 3) float
    noise : float
        Standard deviation of the hand, px.
    sense : {1, -1}
        −1 draws it from its end to its beginning.
    trimmed : float
        Share of the curve's points that is missing at the end where the pen begins.

    Returns
    -------
    (m, 2) float
        px.
    """
    pixels = view.project(curve)[0]
    if noise > 0.0:
        made = random if random is not None else np.random.default_rng(0)
        pixels = pixels + tremor(len(pixels), noise, made, closed=closed)
    return np.asarray(pixels[::sense][round(trimmed * len(pixels)) :])


def densely(curve: Array, *, closed: bool = False) -> Array:
    """The curve with 20 points in the place of each, (20 n, 3)."""
    ring = np.vstack([curve, curve[:1]]) if closed else curve
    fine = np.linspace(0.0, len(ring) - 1.0, 20 * len(curve))
    return np.column_stack([np.interp(fine, np.arange(len(ring)), c) for c in ring.T])


def distances(points: Array, curve: Array, *, closed: bool = False) -> Array:
    """How far points are from the true curve, mm."""
    return np.asarray(cKDTree(densely(curve, closed=closed)).query(points)[0])


# -- recorded ink ------------------------------------------------------------------------------


def _strokestrip() -> Iterator[Array]:
    for path in sorted((INK / "strokestrip/examples").rglob("*.scap")):
        for body in re.findall(r"\{([^}]*)\}", path.read_text()):
            rows = [row.split() for row in body.strip().splitlines() if row.strip()]
            ink = [[float(x) for x in row[:2]] for row in rows[1:] if row[0][0] not in "@#"]
            if len(ink) > 8:
                yield np.array(ink)


def _libmypaint() -> Iterator[Array]:
    path = INK / "libmypaint/painting30sec.dat"
    if path.exists():
        _, x, y, pressure = np.loadtxt(path).T
        down = np.flatnonzero(np.diff(np.concatenate(([0], pressure > 0, [0]))))
        for begin, end in down.reshape(-1, 2):
            yield np.column_stack((x, y))[begin:end]


def _perfect_freehand() -> Iterator[Array]:
    path = INK / "perfect-freehand/packages/perfect-freehand/src/test/inputs.json"
    if path.exists():
        for ink in json.loads(path.read_text()).values():
            if len(ink) > 8:
                yield np.array([point[:2] for point in ink], float)


def length_of(ink: Array) -> float:
    return float(np.linalg.norm(np.diff(ink, axis=0), axis=1).sum())


@cache
def real_ink() -> tuple[Array, ...]:
    """Strokes that people drew, px; none where the recordings are absent."""
    strokes = [*_perfect_freehand(), *_libmypaint(), *_strokestrip()]
    return tuple(ink for ink in strokes if length_of(ink) > SHORTEST)


def lifted(ink: Array, depth: Array) -> Array:
    """A stroke as a space curve on one side of the plane.

    The stroke is what is seen from the side, as large as the box; a second one, smoothed
    until only its sweep is left, says how far from the plane it is: 10 to 45 mm.

    Returns
    -------
    (300, 3) float
    """
    place = resample(smooth(ink, 0.01 * length_of(ink)), count=300)
    place = place - 0.5 * (place.min(0) + place.max(0))
    place = place / max(np.ptp(place, axis=0) / (180.0, 90.0))
    sweep = resample(smooth(depth, 0.15 * length_of(depth)), count=300)[:, 1]
    sweep = (sweep - sweep.min()) / max(float(np.ptp(sweep)), 1e-9)
    return np.column_stack((place[:, 0], 10.0 + 35.0 * sweep, -place[:, 1]))


def winds(ink: Array) -> bool:
    """Whether a stroke is much longer than it is wide: no plain arc, and no scribble either."""
    return 1.25 < length_of(ink) / float(np.linalg.norm(np.ptp(ink, axis=0))) < 5.0


def real_curves(count: int, seed: int = 0) -> list[Array]:
    """Space curves from recorded ink, (300, 3) each; an empty list where there is none.

    Every other one winds; left to chance nearly all would be plain arcs.
    """
    strokes = real_ink()
    if not strokes:
        return []
    random = np.random.default_rng(seed)
    winding = np.array([winds(ink) for ink in strokes])
    kinds = [random.permutation(np.flatnonzero(kind)) for kind in (winding, ~winding)]
    chosen = np.concatenate([kinds[0][: count // 2], kinds[1][: count - count // 2]])
    return [lifted(strokes[k], strokes[random.integers(len(strokes))]) for k in chosen]
