"""Strokes by the view that they were drawn in."""

from __future__ import annotations

from collections.abc import Iterable

from bozzetto.ink import Stroke, is_one_view, on_canvas


def by_view(strokes: Iterable[Stroke]) -> tuple[dict[int, Stroke], ...]:
    """Return the strokes of each view by their numbers, on the canvas of the first of them."""
    views: list[dict[int, Stroke]] = []
    for number, stroke in enumerate(strokes):
        for drawn in views:
            canvas = next(iter(drawn.values())).camera
            if is_one_view(stroke.camera, canvas):
                drawn[number] = on_canvas(stroke, canvas)
                break
        else:
            views.append({number: stroke})
    return tuple(views)
