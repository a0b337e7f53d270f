"""Layers beside the shape: ink, outlines drawn over, profiles, deviations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.plugin import remembered
from bozzetto.scene import Layer, Lines
from bozzetto_silhouette.analysis.fidelity import deviation_along
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.outline.outline import Outline
from bozzetto_silhouette.solids.placements import (
    carried,
    drawn_profile,
    drawn_rings,
    placement_of,
    shown_parts,
)

INK_WIDTH = (1.0, 3.0)
"""Width of ghost ink at no and at full pressure, pixels."""

STEPS = ((0.003, (70, 160, 90)), (0.006, (226, 158, 48)), (0.012, (206, 52, 46)))
"""From which deviation on, as a share of the outline's diagonal, a line is drawn, and how:
from what can just be seen, green, to what nobody would call the same outline, red."""

DEVIATION_WIDTH = 3.0
"""Pixels."""


def ink_layers(state: SilhouetteState) -> tuple[Layer, Layer]:
    """Return the ink of all parts that are shown, where they stand now.

    Of a part whose outline was changed since, the outline takes the place of the ink. The ink and
    the profile of the part that is chosen lie over it in the accent colour, while the object is
    selected: what has that colour is what the next key changes.
    """
    items, accents = [], []
    for part in shown_parts(state):
        items.append(_drawn(state, part, "ghost"))
        if part.id == state.selected:
            accents.append(_drawn(state, part, "accent"))
            if len(part.profile):
                accents.append(_lines(_profile(state, part), "accent", dashed=True))
    seen, chosen = (
        tuple(item for item in each if item is not None and len(item.points))
        for each in (items, accents)
    )
    return Layer("ink", seen), Layer("ink", chosen, chosen=True)


def _drawn(state: SilhouetteState, part: Part, color: str) -> Lines | None:
    """Return what was drawn of a part; None if nothing was."""
    if part.edits:
        return _outline(state, part, color)
    return _ink(part, carried(state, part), color) if len(part.strokes) else None


def deviation_layer(state: SilhouetteState, part: Part, solid: SilhouetteSolid) -> Layer | None:
    """Show where a part's silhouette visibly leaves its outline; None where it does not."""
    outline = outline_of(part)
    place = placement_of(state, part)
    limits = np.array([share for share, _ in STEPS]) * outline.diagonal
    items = []
    for number, (_, color) in enumerate(STEPS):
        runs = [
            place.points(np.column_stack([run, np.zeros(len(run))]))
            for points, distance in _deviations(solid, outline)
            for run in _runs(points, np.searchsorted(limits, distance, side="right") == number + 1)
        ]
        if runs:
            items.append(_joined(runs, color, DEVIATION_WIDTH, "show"))
    return Layer("fidelity", tuple(items), chosen=True) if items else None


@remembered(limit=16)
def _deviations(solid: SilhouetteSolid, outline: Outline) -> list[tuple[Array, Array]]:
    return [deviation_along(solid, ring) for ring in outline.rings]


@remembered(limit=256, key=lambda part, pose, color: (part.strokes, part.sheet, pose, color))
def _ink(part: Part, pose: Placement, color: str) -> Lines:
    """Return a part's ink, as wide as the hand pressed, where it stands now."""
    thin, thick = INK_WIDTH
    lines, widths = [], []
    for stroke in part.strokes:
        on_sheet = part.sheet.from_pixels(stroke.points, stroke.camera)
        lines.append(pose.points(part.sheet.to_world(on_sheet)))
        widths.append(thin + (thick - thin) * np.clip(stroke.pressure, 0.0, 1.0))
    return _joined(lines, color, np.concatenate(widths).astype(np.float32), "faint")


def _outline(state: SilhouetteState, part: Part, color: str) -> Lines:
    try:
        rings = drawn_rings(state, part)
    except UserError:
        return _ink(part, carried(state, part), color)
    return _lines((np.vstack([ring, ring[:1]]) for ring in rings), color)


def _profile(state: SilhouetteState, part: Part) -> Sequence[Array]:
    try:
        return drawn_profile(state, part)
    except UserError:
        return ()


def _lines(lines: Iterable[Array], color: str, *, dashed: bool = False) -> Lines:
    return _joined(list(lines), color, sum(INK_WIDTH) / 2.0, "dashed" if dashed else "faint")


def _joined(
    lines: Sequence[Array],
    color: str | tuple[int, int, int],
    width: float | NDArray[np.float32],
    hidden: Literal["faint", "dashed", "show"],
) -> Lines:
    """Join polylines into one item."""
    starts = np.cumsum([0, *(len(line) for line in lines[:-1])])
    points = np.concatenate([*lines, np.zeros((0, 3))])
    return Lines(points, starts, color=color, width=width, hidden=hidden)


def _runs(points: Array, marked: Flags) -> list[Array]:
    """Return the stretches of a line whose points are marked, each with the point after it."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marked, [False]]).astype(np.int8)))
    return [
        points[first : min(last + 1, len(points))]
        for first, last in edges.reshape(-1, 2)
        if last > first and len(points[first : last + 1]) > 1
    ]
