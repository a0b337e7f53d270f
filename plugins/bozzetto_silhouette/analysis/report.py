"""Figures of a shape for people: how true it is, how sound, and whether it can be printed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from bozzetto.plugin import Caution, Job, remembered
from bozzetto.scene import Walls, walls_of
from bozzetto_silhouette.analysis.fidelity import Fidelity, area_of, measure
from bozzetto_silhouette.inflation.manifold_check import topology_of
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid
from bozzetto_silhouette.ink.rings_from_strokes import specks
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of, points_on_sheet
from bozzetto_silhouette.outline.outline import Outline
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.placements import placement_of, shown_parts

PRINTABLE_WALL = 0.8
"""Thinnest wall that common printers hold, mm: two lines of a 0.4 mm nozzle."""

PRINTABLE_DETAIL = 0.4
"""Smallest detail that common printers show, mm: one line."""

UNLIKE = 0.01
"""Deviation from the drawing, as a share of its diagonal, that is worth a warning."""


RESAMPLED = (
    "The surfaces of the parts could not be put together exactly, so the shape was made anew on a "
    "grid: its edges are coarser. Move one of the parts a little."
)
"""What is said of a body that was made from its function."""


@remembered(limit=256)
def fidelity_of(solid: SilhouetteSolid, outline: Outline) -> Fidelity:
    """Compare a part's solid with its outline; remembered."""
    return measure(solid, outline)


@remembered(limit=64)
def _walls(solid: SilhouetteSolid | Body) -> Walls:
    return walls_of(solid.vertices, solid.faces)


def report_of(
    state: SilhouetteState,
    body: Body | None,
    solids: Mapping[str, SilhouetteSolid],
    job: Job,
    floating: Callable[[], Sequence[str]],
) -> dict[str, Any]:
    """Return the figures of the whole, then of every part, in mm, and warnings; plain JSON values.

    Parameters
    ----------
    state : SilhouetteState
        What was drawn.
    body : Body or None
        The whole shape; None where nothing is left.
    solids : mapping of str to SilhouetteSolid
        By the id of the part, in its object frame.
    job : Job
        Looked at between the parts.
    floating : callable
        Returns what to do with parts that touch nothing, a sentence each; asked only where the
        shape falls into pieces.
    """
    warnings: list[str] = []
    shown = [part for part in shown_parts(state) if part.id in solids]
    parts = []
    for number, part in enumerate(shown):
        job.checkpoint(number / (len(shown) + 1), part.name)
        parts.append(_of_part(state, part, solids[part.id], warnings))
    job.checkpoint(len(shown) / (len(shown) + 1), "")
    report: dict[str, Any] = {}
    if body is not None:
        whole = _of_whole(body)
        problems = _print_problems(whole)
        if whole["components"] > 1:
            problems += floating()
        report["whole"] = whole
        report["print"] = {
            "ready": not problems,
            "size_mm": [round(float(v), 2) for v in np.ptp(body.bounds, axis=0)],
        }
        if problems:
            report["print"]["problems"] = problems
    if len(parts) == 1:
        parts[0].pop("name")
    report["parts"] = parts
    if warnings:
        report["warnings"] = warnings
    return report


def cautions_of(state: SilhouetteState, body: Body | None) -> tuple[Caution, ...]:
    """Return a caution for each part with strokes too small for an outline, and for a coarse body.

    Parameters
    ----------
    state : SilhouetteState
        What was drawn.
    body : Body or None
        The whole shape; None where nothing is left.
    """
    found = [] if body is None or not body.resampled else [Caution(RESAMPLED)]
    for part in shown_parts(state):
        unused = specks(points_on_sheet(tuple(part.strokes), part.sheet)) if part.strokes else 0
        if unused:
            strokes, are = _counted(unused, "stroke"), "is" if unused == 1 else "are"
            found.append(Caution(f"{strokes} of “{part.name}” {are} too small and {are} not used."))
    return tuple(found)


def _of_part(
    state: SilhouetteState, part: Part, solid: SilhouetteSolid, warnings: list[str]
) -> dict[str, Any]:
    """Return the figures of a part where it stands now, and extend the warnings."""
    outline = outline_of(part)
    found = fidelity_of(solid, outline)
    place = placement_of(state, part)
    scale = place.scale
    worst = place.points([(*found.worst_place, 0.0)])[0]
    if found.genus != found.expected_genus or found.components != found.expected_components:
        warnings.append(
            f"“{part.name}” has {_counted(found.genus, 'hole')} in "
            f"{_counted(found.components, 'piece')}; its drawing has "
            f"{_counted(found.expected_genus, 'hole')} in "
            f"{_counted(found.expected_components, 'piece')}. Raise the resolution, or draw "
            "narrow gaps wider."
        )
    if found.hausdorff_share > UNLIKE:
        warnings.append(
            f"“{part.name}” leaves its outline by {found.hausdorff * scale:.1f} mm at the worst "
            "place. Raise the resolution."
        )
    figures: dict[str, Any] = {
        "name": part.name,
        **asdict(found),
        "hausdorff": found.hausdorff * scale,
        "worst_place": [float(v) for v in worst],
        "volume": found.volume * scale**3,
        "area": found.area * scale**2,
    }
    if part.id == state.selected:
        walls = _walls(solid)
        figures["thinnest_wall"] = walls.thinnest * scale
        figures["thinnest_place"] = [float(v) for v in place.points([walls.place])[0]]
    return figures


def _of_whole(body: Body) -> dict[str, Any]:
    """Return the figures of the whole shape."""
    sound = topology_of(body.vertices, body.faces)
    walls = _walls(body)
    return {
        "status": sound.status,
        "watertight": sound.watertight,
        "volume": sound.volume,
        "area": area_of(body.vertices, body.faces),
        "genus": sound.genus,
        "components": sound.bodies,
        "thinnest_wall": walls.thinnest,
        "thinnest_place": list(walls.place),
        "smallest_detail": walls.detail,
    }


def _print_problems(whole: dict[str, Any]) -> list[str]:
    """Return what prevents printing, one sentence each."""
    found = []
    if not whole["watertight"] or whole["volume"] <= 0.0:
        found.append("The surface is not closed. Undo the last step.")
    if whole["components"] > 1:
        found.append(
            f"It falls into {whole['components']} pieces. Move the parts together, or print them "
            "one by one."
        )
    if whole["thinnest_wall"] < PRINTABLE_WALL:
        found.append(
            f"Its thinnest wall is {whole['thinnest_wall']:.2f} mm; common printers need "
            f"{PRINTABLE_WALL} mm. Make that place thicker, or the whole larger."
        )
    elif whole["smallest_detail"] < PRINTABLE_DETAIL:
        found.append(
            f"Details of {whole['smallest_detail']:.2f} mm will be lost; common printers show "
            f"{PRINTABLE_DETAIL} mm. Make it larger."
        )
    return found


def _counted(count: int, word: str) -> str:
    return f"{count or 'no'} {word}{'' if count == 1 else 's'}"
