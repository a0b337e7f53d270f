"""Layers that depend on the view: grids of the back walls, and lines to the vanishing points."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.scene import Item, Label, Layer, Lines, Paint, Scene
from bozzetto.view import Camera
from bozzetto_symmetry.model.axes import AXES, AXIS_PAINTS, receding
from bozzetto_symmetry.model.box_geometry import box_edges
from bozzetto_symmetry.model.box_grid import Grid, grid_in_box, grid_step
from bozzetto_symmetry.model.perspective import vanishing_point
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.view.box import (
    EDGE_WIDTH,
    FINE_WIDTH,
    HEAVY_WIDTH,
    box_layers,
    grid_lines,
    segments,
)

NEAR_CANVAS: Final = 3.0
"""Distance from the middle of the canvas, in its widths, beyond which a vanishing point is not
shown."""

ARM: Final = 7.0
"""Length of the arms of a mark, px."""

MARK_WIDTH: Final = 1.6
"""Width of the lines of a mark, px."""

CONVERGED: Final = 0.97
"""Share of the way to the vanishing point that lengthened edges go, on the sheet."""

PIECES: Final = 16
"""Pieces of a lengthened edge, over which it fades."""

LINE_WIDTH, LINE_END_WIDTH = 1.0, 0.25
"""Widths of lengthened edges where they leave the box and at their ends, px."""

LINE_OPACITY: Final = 0.6
"""Opacity of lengthened edges."""

GRID_OPACITY: Final = 0.24
"""Opacity of grids: as faint on the sheet as the colour of grids; curves under them stay clear."""

WIDER: Final = 2.5
"""How much longer than the box's own grids those are that show the perspective."""


def seen_from(state: SymmetryState, camera: Camera) -> Scene:
    """Return all that is shown of the box in one view beside the model's own scene.

    A model that holds nothing yet is not in any document: there the box itself is part of
    it, so that it is there before the first stroke.

    Parameters
    ----------
    state : SymmetryState
        The box, and whether anything is drawn in it.
    camera : Camera
        In the model's frame.
    """
    hanging = view_dependent_scene(state, camera)
    if state.nodes:
        return hanging
    return Scene(tuple(layer for layer in box_layers(state) if not layer.tool)) + hanging


def view_dependent_scene(state: SymmetryState, camera: Camera) -> Scene:
    """Return what belongs to the box in one view; it is shown over the box itself.

    The edges in front are firmer, the walls behind bear grids, and where vanishing lines are
    asked for, these grids go on as a room, and the edges to the points at which they meet.
    """
    layers = [Layer("front edges", (segments(front_edges(state, camera), "ghost", EDGE_WIDTH),))]
    if state.grid and not state.vanishing:
        layers.append(Layer("back walls", tuple(_walls(state, camera))))
    if state.vanishing:
        lines = (*_lengthened(state, camera), *_room(state, camera))
        layers.append(Layer("vanishing lines", lines))
        return Scene(tuple(layers)) + vanishing_marks(state, camera)
    return Scene(tuple(layers))


def back_faces(state: SymmetryState, camera: Camera) -> list[tuple[int, int]]:
    """Return axis and sense (1, -1) of the faces that one looks at from inside the box."""
    centre, half = np.asarray(state.centre), 0.5 * np.asarray(state.size)
    found = []
    for axis in range(3):
        for sense in (1, -1):
            outwards = sense * AXES[axis]
            if camera.kind == "orthographic":
                facing = float(camera.axes[2] @ outwards)
            else:
                facing = float((centre + half[axis] * outwards - camera.eye) @ outwards)
            if facing > 0.0:
                found.append((axis, sense))
    return found


def front_edges(state: SymmetryState, camera: Camera) -> Array:
    """Return the edges of the box that no face of it covers, (n, 2, 3) mm."""
    back = set(back_faces(state, camera))
    edges = box_edges(state)
    aside = np.sign(edges.mean(axis=1) - state.centre).astype(int)
    covered = [
        all((axis, int(s)) in back for axis, s in enumerate(row) if axis != k // 4)
        for k, row in enumerate(aside)
    ]
    return np.asarray(edges[~np.array(covered)])


def _walls(state: SymmetryState, camera: Camera) -> Iterator[Item]:
    step = grid_step(max(state.size))
    for axis, sense in back_faces(state, camera):
        if (axis, sense) == FLOOR:
            continue
        middle = np.asarray(state.centre) + 0.5 * sense * state.size[axis] * AXES[axis]
        first, second = AXES[[(axis + 1) % 3, (axis + 2) % 3]]
        grid = grid_in_box(middle, first, second, step, centre=state.centre, size=state.size)
        yield from grid_lines(grid, "ghost", GRID_OPACITY)


FLOOR: Final = (2, -1)
"""Axis and sense of the lower face, whose grid is always there."""


# -- where edges vanish ------------------------------------------------------------------------


def seen_vanishing_point(camera: Camera, direction: ArrayLike) -> Array | None:
    """Return where lines of a direction meet near the canvas, (2,) px, or None.

    A point further away than `NEAR_CANVAS` counts as none.
    """
    if receding(camera, direction) is None:
        return None
    x, y, w = vanishing_point(camera, direction)
    place = np.array([x, y]) / w
    away = float(np.linalg.norm(place - 0.5 * np.asarray(camera.viewport)))
    return place if away <= NEAR_CANVAS * camera.viewport[0] else None


def vanishing_marks(state: SymmetryState, camera: Camera) -> Scene:
    """Return crosses where the axes of the box vanish, with their letters.

    So does the normal of a centre plane that is not the box's own: mirrored places lie on
    lines towards it. A vanishing point is nowhere in space: each cross stands on its line of
    sight, at the depth of the target, and so large that its arms are `ARM` pixels there.

    Parameters
    ----------
    state : SymmetryState
        The box and its centre plane.
    camera : Camera
        In the model's frame.
    """
    marked = list(zip(AXES, AXIS_PAINTS, "xyz", strict=True))
    if state.symmetry == "free":
        marked.append((np.asarray(state.plane.normal), "ink", "left and right"))
    items: list[Item] = []
    for way, paint, text in marked:
        place = seen_vanishing_point(camera, way)
        if place is not None:
            items += _cross(camera, place, paint, text)
    return Scene((Layer("vanishing points", tuple(items)),)) if items else Scene()


def _cross(camera: Camera, place: Array, paint: Paint, text: str) -> tuple[Item, Item]:
    forward = camera.axes[2]
    on_sheet = np.asarray(camera.target, float)
    arms = ARM * np.array([(-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)])
    ends = camera.on_plane(place + arms, on_sheet, forward)
    ((x, y, z),) = camera.on_plane(place, on_sheet, forward).tolist()
    lines = Lines(
        ends.astype(np.float32),
        np.array([0, 2], np.int32),
        color=paint,
        width=MARK_WIDTH,
        hidden="show",
    )
    return lines, Label((x, y, z), text, paint)


def _lengthened(state: SymmetryState, camera: Camera) -> Iterator[Lines]:
    """Yield the edges extended to where they meet."""
    edges = box_edges(state).reshape(3, 4, 2, 3)
    share = np.linspace(0.0, 1.0, PIECES + 1)
    widths = (LINE_WIDTH + (LINE_END_WIDTH - LINE_WIDTH) * share).astype(np.float32)
    for axis, parallel, paint in zip(AXES, edges, AXIS_PAINTS, strict=True):
        way, lines = receding(camera, axis), []
        for edge in parallel:
            if way is None:
                lines.append(edge[1] + state.diagonal * share[:, None] * axis)
                lines.append(edge[0] - state.diagonal * share[:, None] * axis)
                continue
            far = edge[int(np.argmax(edge @ way))]
            depth = float(camera.axes[2] @ (far - camera.eye))
            if depth > 0.0:
                lines.append(far + _to_horizon(depth, way, camera, share) * way)
        if lines:
            yield Lines(
                np.concatenate(lines).astype(np.float32),
                np.arange(len(lines), dtype=np.int32) * len(share),
                color=paint,
                width=np.tile(widths, len(lines)),
                opacity=LINE_OPACITY,
            )


def _room(state: SymmetryState, camera: Camera) -> Iterator[Lines]:
    """Yield the grids of the faces behind, extended towards the eye as a room."""
    back, step = back_faces(state, camera), grid_step(max(state.size))
    half = 0.5 * np.asarray(state.size)
    low, high = state.centre - half, state.centre + half
    for axis in range(3):
        senses = [sense for other, sense in back if other == axis]
        if senses == [1]:
            low[axis] -= (WIDER - 1.0) * state.size[axis]
        elif senses == [-1]:
            high[axis] += (WIDER - 1.0) * state.size[axis]
    for axis, sense in back:
        middle = np.asarray(state.centre) + sense * half[axis] * AXES[axis]
        first, second = AXES[[(axis + 1) % 3, (axis + 2) % 3]]
        grid = grid_in_box(middle, first, second, step, centre=0.5 * (low + high), size=high - low)
        if len(grid.heavy):
            yield _fading(grid, state)


def _fading(grid: Grid, state: SymmetryState) -> Lines:
    """Return lines of a grid that grow thinner the farther from the box they run."""
    share = np.linspace(0.0, 1.0, PIECES + 1)[:, None]
    points = grid.begins[:, None] + share * (grid.ends - grid.begins)[:, None]
    aside = np.abs(points - state.centre) / np.asarray(state.size) - 0.5
    width = np.where(grid.heavy, HEAVY_WIDTH, FINE_WIDTH)[:, None]
    width = width * np.clip(1.0 - aside.max(axis=2) / (WIDER - 1.0), 0.0, 1.0)
    return Lines(
        points.reshape(-1, 3).astype(np.float32),
        np.arange(len(points), dtype=np.int32) * len(share),
        color="ghost",
        width=width.ravel().astype(np.float32),
        opacity=GRID_OPACITY,
        hidden="hide",
    )


def _to_horizon(depth: float, way: Array, camera: Camera, share: Array) -> Array:
    """Return ways, (n, 1) mm, at equal steps on the sheet from a depth to nearly the horizon."""
    steepness = float(camera.axes[2] @ way)
    seen = CONVERGED * share
    return np.asarray((depth / steepness * seen / (1.0 - seen))[:, None])
