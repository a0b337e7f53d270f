"""Strokes on the sketch as scene items, and how far the body is from each.

They lie on the plane of the picture and are there while edges are traced: a stroke that is drawn
again along its edge takes the place of the one before.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import remembered
from bozzetto.scene import Item, Label, Layer, Lines
from bozzetto.view import triple
from bozzetto_car.body.body import Body
from bozzetto_car.body.stroke_distances import Miss, misses_of
from bozzetto_car.marking.next_mark import in_work
from bozzetto_car.state import CarState

TRACE_TOOL: Final = "trace"

OFF: Final = 2.5
"""Distance of a body from a stroke, px, from which the stroke stands out as one to look at."""

TOLD_FROM: Final = 0.5
"""Distance, px, from which it is written beside the stroke: below, a hand draws no better."""

LABEL_ROOM: Final = (0.036, 0.016)
"""Width and height of the space that a number keeps free, in diagonals of the picture."""

REMEMBERED: Final = 16
"""Number of layers that are remembered."""


def stroke_layers(state: CarState, body: Body) -> tuple[Layer, ...]:
    """Return the layer with the strokes of the sketch in work; none while a drag is previewed."""
    placed = in_work(state, body.solved)
    if placed is None or not placed.is_known or body.is_dragged or not state.edits:
        return ()
    return (_layer(body, state, placed.sketch.id),)


@remembered(limit=REMEMBERED, key=lambda body, state, sketch: (body, sketch))
def _layer(body: Body, state: CarState, sketch: str) -> Layer:
    return Layer("strokes", tuple(_items(body, state, sketch)), tool=TRACE_TOOL)


def _items(body: Body, state: CarState, sketch: str) -> Iterator[Item]:
    """Yield strokes as lines, and the largest distances beside them, the worst first."""
    through = body.sketch_cameras[sketch]
    misses = sorted(misses_of(body, state.edits, sketch), key=lambda miss: -miss.px)
    for color, chosen in (
        ("second", [miss for miss in misses if miss.px <= OFF]),
        ("warning", [miss for miss in misses if miss.px > OFF]),
    ):
        if chosen:
            rows = [through.lifted(miss.points + through.shift) for miss in chosen]
            starts = np.cumsum([0, *(len(row) for row in rows[:-1])]).astype(np.int32)
            places = np.concatenate(rows).astype(np.float32)
            yield Lines(places, starts, color=color, width=1.4, hidden="show")
    room = np.array(LABEL_ROOM) * float(np.hypot(*through.camera.viewport))
    taken: list[Array] = []
    for miss in misses:
        if miss.px < TOLD_FROM:
            return
        if all((np.abs(miss.place - other) >= room).any() for other in taken):
            taken.append(miss.place)
            yield _label(miss, through.lifted((miss.place + through.shift)[None])[0])


def _label(miss: Miss, place: Array) -> Label:
    return Label(triple(place), f"{miss.px:.1f} px", color="warning" if miss.px > OFF else "second")
