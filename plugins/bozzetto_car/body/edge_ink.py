"""The strokes along a car's edges, as drawn on the sheet."""

from __future__ import annotations

from collections.abc import Iterator

from bozzetto.ink import Stroke, Strokes
from bozzetto_car.body.build import sketch_cameras_of
from bozzetto_car.state import CarState, TracedEdges


def ink_of(state: CarState) -> Strokes:
    """Return all strokes along edges; what was drawn on a hidden sketch is left out.

    Raises
    ------
    UserError
        As `sketch_cameras_of` does.
    """
    return Strokes(_strokes(state))


def _strokes(state: CarState) -> Iterator[Stroke]:
    cameras = sketch_cameras_of(state)
    for edit in state.edits:
        if not isinstance(edit, TracedEdges):
            continue
        if not edit.sketch:
            yield from edit.strokes
        elif edit.sketch in cameras:
            through = cameras[edit.sketch]
            for stroke in edit.strokes:
                yield Stroke(
                    stroke.x - through.shift[0],
                    stroke.y - through.shift[1],
                    through.camera,
                    pressure=stroke.pressure if stroke.has_pressure else None,
                    t=stroke.t if stroke.has_time else None,
                    tool=stroke.tool,
                )
