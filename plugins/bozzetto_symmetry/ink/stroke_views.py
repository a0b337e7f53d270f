"""Strokes by the view that they were drawn in."""

from __future__ import annotations

from collections.abc import Iterable

from bozzetto.ink import Stroke, is_one_view, on_canvas


def by_view(strokes: Iterable[Stroke]) -> tuple[tuple[Stroke, ...], ...]:
    """Return the strokes of each view, on the canvas of the first of them, in the order drawn."""
    views: list[list[Stroke]] = []
    for stroke in strokes:
        for drawn in views:
            if is_one_view(stroke.camera, drawn[0].camera):
                drawn.append(on_canvas(stroke, drawn[0].camera))
                break
        else:
            views.append([stroke])
    return tuple(tuple(drawn) for drawn in views)
