"""The pen's other end: whatever the tool, it takes away what it rubs over."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto_silhouette.model.state import Cut, Part, Removal, SilhouetteState
from bozzetto_silhouette.outline.from_ink import rings_of
from bozzetto_silhouette.solids.placements import (
    distances_under,
    drawn_profile,
    on_sheet,
    outlined_parts,
    placement_of,
    shown_parts,
)

LOOKS = 9
"""Samples of the eraser's path that are looked at."""

MOST = 0.5
"""Share of them that must lie over a thing."""

PROFILE_REACH = 8.0
"""How near a profile's line the eraser must pass, px."""


def erased(state: SilhouetteState, eraser: Stroke) -> SilhouetteState:
    """Remove what most of the eraser's path lies over.

    That is a cut or the profile of the chosen part, if the path runs along it; else the newest part
    whose surface is under it; else the hole that it is in. What is switched off stays.

    Raises
    ------
    UserError
        If there is nothing under the eraser.
    """
    places = np.linspace(0, len(eraser) - 1, min(len(eraser), LOOKS)).round().astype(int)
    path = Stroke(eraser.x[places], eraser.y[places], eraser.camera)
    for part in reversed(shown_parts(state)):
        if isinstance(part, Cut) and _runs_along(path, _line_of(state, part)):
            return without(state, {part.id})
    parts = outlined_parts(state)
    for part in parts:
        if part.id == state.selected and _along_profile(state, part, path):
            return state.with_node(replace(part, profile=Strokes()))
    for part in reversed(parts):
        under = np.isfinite(distances_under(state, part, path.points, path.camera))
        if under.mean() >= MOST:
            return without(state, {part.id})
    for part in reversed(parts):
        hole = _hole_around(state, part, path)
        if hole is not None:
            return state.with_node(replace(part, edits=(*part.edits, Removal(hole))))
    raise UserError(
        "There is no part under the eraser. Rub across the part or the hole to take it away."
    )


def without(state: SilhouetteState, gone: set[str]) -> SilhouetteState:
    """Remove some nodes; what was chosen stays chosen unless it is among them."""
    nodes = tuple(node for node in state.nodes if node.id not in gone)
    chosen = "" if state.selected in gone else state.selected
    return replace(state, nodes=nodes, selected=chosen)


def _along_profile(state: SilhouetteState, part: Part, path: Stroke) -> bool:
    """Whether a path runs along the line of a part's profile, as it is shown now."""
    try:
        lines = drawn_profile(state, part)
    except UserError:
        return False
    return _runs_along(path, lines)


def _line_of(state: SilhouetteState, cut: Part) -> list[Array]:
    """Return the strokes of a cut where it stands now; (n, 3) each."""
    place = placement_of(state, cut)
    flat = [cut.sheet.from_pixels(stroke.points, stroke.camera) for stroke in cut.strokes]
    return [place.points(np.column_stack([line, np.zeros(len(line))])) for line in flat]


def _runs_along(path: Stroke, lines: list[Array]) -> bool:
    """Whether most of a path lies by one of some lines (n, 3), as they are seen."""
    import shapely

    for line in lines:
        pixels, _ = path.camera.project(line)
        if len(pixels) < 2 or not np.isfinite(pixels).all():
            continue
        away = shapely.distance(shapely.LineString(pixels), shapely.points(path.points))
        if (away <= PROFILE_REACH).mean() >= MOST:
            return True
    return False


def _hole_around(state: SilhouetteState, part: Part, path: Stroke) -> int | None:
    """Return the number of the ring, inside another, that most of a path lies in."""
    import shapely

    points = on_sheet(state, part, path)
    if not np.isfinite(points).all():
        return None
    try:
        rings = rings_of(part)
    except UserError:
        return None
    regions = {k: shapely.Polygon(ring) for k, ring in enumerate(rings) if ring is not None}
    around = [
        (region.area, number)
        for number, region in regions.items()
        if shapely.contains_xy(region, points[:, 0], points[:, 1]).mean() >= MOST
    ]
    if not around:
        return None
    _, inmost = min(around)
    probe = regions[inmost].representative_point()
    depth = sum(region.contains(probe) for k, region in regions.items() if k != inmost)
    return inmost if depth % 2 else None
