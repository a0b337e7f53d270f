"""Colours that a body is looked at with: how it bends, and how well it is known."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.geometry.curvature import grid_curvatures
from bozzetto.geometry.tessellation import shaded_parameters
from bozzetto_car.certainty import Source
from bozzetto_car.template import Template

__all__ = ["SOURCE_COLORS", "certainty_colors", "curvature_colors"]

Array = NDArray[np.float64]
Colors = NDArray[np.uint8]

LOUDEST: Final = 95.0
"""Percentile of the absolute curvatures of a body that gets the full colour. What bends more, as
the corner of a bumper, would leave nothing but grey for the rest."""

HOLLOW: Final = (38, 98, 172)
EVEN: Final = (205, 204, 200)
BULGE: Final = (190, 52, 44)
"""Colours of hollow, flat and bulging surfaces. Blue and red differ for all kinds of colour
vision, and both are darker than the grey between them."""

SOURCE_COLORS: Final[dict[Source, tuple[int, int, int]]] = {
    "seen": (0, 140, 130),
    "mirrored": (112, 160, 190),
    "guessed": (196, 168, 118),
}
"""Colours of nodes that have a mark, those whose mirror image has one, and the others."""


def curvature_colors(nets: ArrayLike, divisions: int = 12) -> Colors:
    """Mean curvature as a colour at every vertex of `bozzetto.geometry.tessellation.shaded`.

    Hollows are blue, what is flat grey, bulges red; the scale ends at the `LOUDEST` percentile
    of the body's own curvatures.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        mm.
    divisions : int
        As given to `shaded`.

    Returns
    -------
    (k (divisions + 1)², 4) uint8
        RGBA, opaque.
    """
    at = shaded_parameters(divisions)
    mean = grid_curvatures(nets, at, at).mean.ravel()
    scale = float(np.percentile(np.abs(mean), LOUDEST)) if len(mean) else 0.0
    level = np.clip(mean / (scale or 1.0), -1.0, 1.0)[:, None]
    hollow, even, bulge = (np.array(color, float) for color in (HOLLOW, EVEN, BULGE))
    end = np.where(level > 0.0, bulge, hollow)
    return _opaque(even + np.abs(level) * (end - even))


def certainty_colors(template: Template, sources: Sequence[Source], divisions: int = 12) -> Colors:
    """How well a body is known, as a colour at every vertex of `shaded`.

    A patch blends the colours of its four nodes (bilinear).

    Parameters
    ----------
    template : Template
    sources : sequence of {"seen", "mirrored", "guessed"}, length n
        Of each node, as in `Certainty`.
    divisions : int
        As given to `shaded`.

    Returns
    -------
    (k (divisions + 1)², 4) uint8
        RGBA, opaque; patches in the order of the template.
    """
    corners = np.array([patch.nodes for patch in template.patches])
    nodes = np.array([SOURCE_COLORS[source] for source in sources], float)[corners]
    at = shaded_parameters(divisions)
    u, v = at[:, None, None], at[None, :, None]
    a, b, c, d = (nodes[:, k, None, None] for k in range(4))
    mixed = (1.0 - v) * ((1.0 - u) * a + u * b) + v * ((1.0 - u) * d + u * c)
    return _opaque(mixed.reshape(-1, 3))


def _opaque(rgb: Array) -> Colors:
    colors = np.full((len(rgb), 4), 255, np.uint8)
    colors[:, :3] = np.rint(rgb)
    return colors
