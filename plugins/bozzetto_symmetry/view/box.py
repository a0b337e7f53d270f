"""The see-through box: its edges, its grids, and the centre plane."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Mesh
from bozzetto.plugin import remembered
from bozzetto.scene import Handle, Item, Label, Layer, Lines, Paint, Shaded
from bozzetto_symmetry.model.axes import AXES, AXIS_PAINTS
from bozzetto_symmetry.model.box_geometry import box_edges, plane_foot, plane_outline
from bozzetto_symmetry.model.box_grid import Grid, grid_in_box, grid_step
from bozzetto_symmetry.model.state import SymmetryState

BOX_TOOL: Final = "box"
"""Id of the tool that shows handles: to any other pen they would only be in the way."""

CENTRE: Final = "centre"
"""Id of the handle in the middle of the box."""

FACES: Final[dict[str, tuple[int, int]]] = {
    f"{letter}{sign}": (axis, 1 if sign == "+" else -1)
    for axis, letter in enumerate("xyz")
    for sign in "+-"
}
"""Axis and sense of the face that each of the other handles holds, by the handle's id."""

DIMENSIONS: Final = ("Length", "Width", "Height")

EDGE_WIDTH: Final = 1.3
"""Width of the box's edges and of the centre plane's outline, px."""

FINE_WIDTH, HEAVY_WIDTH = 0.6, 1.1
"""Widths of the grid's lines, px. Below one pixel thinner is fainter."""

PLANE_OPACITY: Final = 0.09
"""Opacity of the centre plane: visible in both themes, and curves behind it stay clear."""

PLANE_GRID_OPACITY: Final = 0.45
"""Opacity of the centre plane's grid."""


@remembered(limit=32, key=lambda state: (state.centre, state.size, state.plane, state.grid))
def box_layers(state: SymmetryState) -> tuple[Layer, ...]:
    """Return the box in the frame of the model: edges, floor, centre plane, and handles."""
    layers = [Layer("box", (segments(box_edges(state), "faint", EDGE_WIDTH),))]
    if state.grid:
        layers.append(Layer("grid", grid_lines(floor_grid(state), "grid")))
    layers.append(Layer("plane", tuple(_plane_items(state))))
    layers.append(Layer("box handles", tuple(_held(state)), tool=BOX_TOOL))
    return tuple(layers)


def segments(pairs: Array, color: Paint, width: float, opacity: float = 1.0) -> Lines:
    """Return straight pieces (n, 2, 3), mm, as one item."""
    return Lines(
        pairs.reshape(-1, 3).astype(np.float32),
        np.arange(len(pairs), dtype=np.int32) * 2,
        color=color,
        width=width,
        opacity=opacity,
    )


def grid_lines(grid: Grid, color: Paint, opacity: float = 1.0) -> tuple[Lines, ...]:
    """Return a grid as it is shown; nothing where it has no lines."""
    if not len(grid.heavy):
        return ()
    pairs = np.stack((grid.begins, grid.ends), axis=1)
    widths = np.repeat(np.where(grid.heavy, HEAVY_WIDTH, FINE_WIDTH), 2)
    return (
        Lines(
            pairs.reshape(-1, 3).astype(np.float32),
            np.arange(len(pairs), dtype=np.int32) * 2,
            color=color,
            width=widths.astype(np.float32),
            opacity=opacity,
            hidden="hide",
        ),
    )


def floor_grid(state: SymmetryState) -> Grid:
    """Return the grid of the box's lower face."""
    low = np.asarray(state.centre) - (0.0, 0.0, 0.5 * state.height)
    return grid_in_box(
        low, AXES[0], AXES[1], grid_step(max(state.size)), centre=state.centre, size=state.size
    )


# -- the centre plane ------------------------------------------------------------------------


def _plane_items(state: SymmetryState) -> Iterator[Item]:
    outline = plane_outline(state)
    count = len(outline)
    fan = [(0, k, k + 1) for k in range(1, count - 1)]
    mesh = Mesh(outline.astype(np.float32), np.array(fan, np.int32))
    yield Shaded(mesh, "second", PLANE_OPACITY, pickable=False)
    ring = np.vstack((outline, outline[:1])).astype(np.float32)
    yield Lines(ring, color="second", width=EDGE_WIDTH)
    if state.grid:
        across, up = state.plane.placement.directions(AXES[[0, 2]])
        grid = grid_in_box(
            plane_foot(state),
            across,
            up,
            grid_step(max(state.size)),
            centre=state.centre,
            size=state.size,
        )
        yield from grid_lines(grid, "second", PLANE_GRID_OPACITY)


# -- what the box tool holds -----------------------------------------------------------------


def _held(state: SymmetryState) -> Iterator[Item]:
    """Yield handles on the faces and in the middle, and the dimensions beside three edges."""
    centre, half = np.asarray(state.centre), 0.5 * np.asarray(state.size)
    for name, (axis, sense) in FACES.items():
        x, y, z = (centre + sense * half[axis] * AXES[axis]).tolist()
        yield Handle(name, (x, y, z), AXIS_PAINTS[axis], DIMENSIONS[axis])
    x, y, z = state.centre
    yield Handle(CENTRE, (x, y, z), "ink", "Move along the centre plane")
    for axis, corner in enumerate(_LABELLED):
        x, y, z = (centre + half * corner).tolist()
        yield Label((x, y, z), f"{state.size[axis]:.6g} mm", AXIS_PAINTS[axis])


_LABELLED: Final = np.array([(0.0, -1.0, -1.0), (1.0, 0.0, -1.0), (1.0, -1.0, 0.0)])
"""Middles of the edges that stand for length, width and height, as shares of half the size."""
