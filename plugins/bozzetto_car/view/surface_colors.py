"""Colours that show how a body bends, and how well it is known."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry.patches import grid, grid_curvatures, shaded_parameters
from bozzetto_car.solver.uncertainty import Source
from bozzetto_car.template.model import Template

Colors = NDArray[np.uint8]

LOUDEST: Final = 95.0
"""Share of the area of a body, %, that bends less than what gets the full colour. Scaled to the
largest curvature, such as that of the corner of a bumper, all the rest would be grey."""

GENTLE: Final = 6.0
"""The scale is linear below a sixth of its end, and logarithmic above."""

FLAT: Final = 1e-9
"""Curvature, 1/mm, that counts as rounding: a radius of a thousand kilometres."""

BENDS: Final = np.array(
    [
        (28, 84, 150), (58, 134, 188), (134, 188, 216), (190, 212, 224),
        (214, 213, 210),
        (234, 196, 174), (236, 157, 122), (206, 88, 70), (164, 24, 42),
    ],
    float,
)  # fmt: skip
"""Colours from hollow over flat to bulging: Brewer's RdBu, safe for all kinds of colour vision,
with a middle that stands out from light paper. Both arms darken evenly, so that grey prints show
how much a place bends, though not to which side."""

SOURCE_COLORS: Final[dict[Source, tuple[int, int, int]]] = {
    "seen": (52, 146, 136),
    "mirrored": (142, 174, 208),
    "guessed": (212, 186, 142),
}
"""Colours of nodes that have a mark, those whose mirror image has one, and the others: lighter
and greyer the less is known."""


def curvature_colors(nets: ArrayLike, divisions: int = 12) -> Colors:
    """Return the mean curvature as a colour at every vertex of `patches.tessellation.shaded`.

    Hollows are blue, flat places grey, bulges red. The scale ends where `LOUDEST` percent
    of the body's area bend less; on the way there it is linear first, and then logarithmic
    (inverse hyperbolic sine): between the crown of a door and the corner of a bumper lie three
    powers of ten.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        Control nets of the body, mm.
    divisions : int
        As given to `shaded`.

    Returns
    -------
    (k (divisions + 1)², 4) uint8
        RGBA, opaque.
    """
    at = shaded_parameters(divisions)
    mean = grid_curvatures(nets, at, at).mean.ravel()
    scale = _loudest(np.abs(mean), nets, at)
    share = np.clip(mean / scale, -1.0, 1.0) if scale > FLAT else np.zeros(len(mean))
    level = np.arcsinh(GENTLE * share) / np.arcsinh(GENTLE)
    stops = np.linspace(-1.0, 1.0, len(BENDS))
    return _opaque(np.stack([np.interp(level, stops, part) for part in BENDS.T], axis=1))


def _loudest(bends: Array, nets: ArrayLike, at: Array) -> float:
    """Return the curvature up to which `LOUDEST` percent of the area of patches bend, 1/mm."""
    if not len(bends):
        return 0.0
    areas = np.linalg.norm(
        cross_product(grid(nets, at, at, du=1), grid(nets, at, at, dv=1)), axis=-1
    )
    order = np.argsort(bends)
    below = np.cumsum(areas.ravel()[order])
    return float(bends[order[np.searchsorted(below, 0.01 * LOUDEST * below[-1])]])


def certainty_colors(template: Template, sources: Sequence[Source], divisions: int = 12) -> Colors:
    """Return how well a body is known as a colour at every vertex of `shaded`.

    A patch blends the colours of its four nodes (bilinear).

    Parameters
    ----------
    template : Template
        The template of the body.
    sources : sequence of {"seen", "mirrored", "guessed"}, length n
        Source of each node, as in `Certainty`.
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
