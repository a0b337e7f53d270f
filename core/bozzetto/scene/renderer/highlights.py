"""Highlights: what surfaces of gloss, rubber and metal send back besides the light of clay.

One long soft lamp stands above the sheet, tied to the camera as the key light is, and the paper
lights what is seen at a grazing angle, by the fifth power of one minus the cosine (Schlick 1994,
"An inexpensive BRDF model for physically based rendering"). Where surfaces share their curvature
the lamp's image flows from one to the next, as a designer looks for it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from bozzetto.arrays import Floats
    from bozzetto.scene.display_list import Finish
    from bozzetto.scene.renderer.shading import Fragments

LAMP: Final = (-0.30, 0.80, 0.52)
"""Towards the middle of the lamp, in the frame of the view."""

HALF_LENGTH: Final = 0.85
HALF_HEIGHT: Final = 0.13
"""Halves of the lamp's sides, as sines."""

SOFT: Final = 0.10
"""Width of its edge, as a sine."""


class Sheen(NamedTuple):
    """Highlight of a finish, shares of white.

    Attributes
    ----------
    body : float
        Share of the colour that clay would have.
    lamp : float
        Of the lamp's image.
    grazing : float
        Of the paper, seen at a grazing angle.
    tinted : float
        How much of that has the colour of the body, as metals have it.
    """

    body: float
    lamp: float
    grazing: float
    tinted: float


SHEENS: Final[dict[Finish, Sheen]] = {
    "gloss": Sheen(0.96, 0.62, 0.40, 0.0),
    "rubber": Sheen(0.88, 0.05, 0.22, 0.0),
    "metal": Sheen(0.72, 0.85, 0.55, 0.55),
}
"""Finishes with a sheen."""

NO_SHEEN: Final = Sheen(1.0, 0.0, 0.0, 0.0)
"""That of clay."""


def with_highlights(colors: Floats, seen: Fragments, sheen: NDArray[np.float32]) -> Floats:
    """Return colours with the light that is mirrored.

    Parameters
    ----------
    colors : (n, 3) float32
        As clay, 0 … 255.
    seen : Fragments
        The visible surface.
    sheen : (n, 4) float32
        The `Sheen` at each pixel; (1, 0, 0, 0) is clay.

    Returns
    -------
    (n, 3) float32
        0 … 255.
    """
    body, lamp, grazing, tinted = sheen.T
    light = lamp * lamp_light(seen.normal) + grazing * (np.float32(1) - seen.facing) ** 5
    light[seen.inside] = 0.0
    white = np.float32(255) + tinted[:, None] * (colors - np.float32(255))
    base = colors * body[:, None]
    return np.asarray(base + np.clip(light, 0, 1)[:, None] * (white - base), np.float32)


def lamp_light(normal: Floats) -> Floats:
    """Return how much of the lamp is mirrored by normals (3, n) in the frame of the view, 0 … 1."""
    across, up, near = normal
    mirrored = np.stack((2 * near * across, 2 * near * up, 2 * near * near - 1))
    along, over, way = (np.array(row, np.float32) @ mirrored for row in lamp_frame().values())
    return np.asarray(_within(along, HALF_LENGTH) * _within(over, HALF_HEIGHT) * (way > 0))


def lamp_frame() -> dict[str, tuple[float, ...]]:
    """Return unit vectors along the lamp, over it, and towards it, in the frame of the view."""
    way = np.array(LAMP) / np.linalg.norm(LAMP)
    along = np.cross((0.0, 1.0, 0.0), way)
    along /= np.linalg.norm(along)
    rows = {"ALONG": along, "OVER": np.cross(way, along), "LAMP": way}
    return {name: tuple(row.tolist()) for name, row in rows.items()}


def _within(sine: Floats, half: float) -> Floats:
    share = np.clip((half + SOFT - np.abs(sine)) / (2 * SOFT), 0, 1)
    return np.asarray(share * share * (3 - 2 * share), np.float32)
