"""The marks on the sketch: handles to drag, what each is missed by, and what is asked for next."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.scene import Handle, Item, Label, Layer, Lines, Points
from bozzetto_car.asking import Asked, asked_of
from bozzetto_car.body import Body
from bozzetto_car.solving import Placed
from bozzetto_car.stand import Stand
from bozzetto_car.state import CarState

__all__ = ["MARK", "MARK_TOOL", "mark_layers"]

Array = NDArray[np.float64]

MARK_TOOL: Final = "mark"

MARK: Final = "mark "
"""What the ids of marks' handles begin with; the name of the node follows."""

TOLD: Final = 1.0
"""Distance of a mark from its node, px, from which a line between them is drawn."""

ROUND: Final = 48
"""Corners of an ellipse."""


def mark_layers(state: CarState, body: Body) -> tuple[Layer, ...]:
    """The marks of the sketch in work, and where the next one is expected."""
    sketch = state.sketch
    placed = None if sketch is None else body.solved.placed.get(sketch.id)
    if placed is None:
        return ()
    stand = body.stands[placed.sketch.id]
    items = [*_marks(placed, stand, body)]
    asked = asked_of(state, body.solved)
    if asked is not None:
        items += [*_expected(asked, stand, body)]
    return (Layer("marks", tuple(items), tool=MARK_TOOL),)


def _marks(placed: Placed, stand: Stand, body: Body) -> Iterator[Item]:
    template, marks = body.template, placed.sketch.marks
    if not marks:
        return
    places = stand.lifted([(mark.u, mark.v) for mark in marks])
    missed, others = placed.missed or {}, placed.left_out or {}
    pairs = []
    for mark, place in zip(marks, places, strict=True):
        x, y, z = place.tolist()
        wrong = mark.node in placed.disagreeing
        unknown = mark.node not in template.node
        title = template.titles.get(mark.node, mark.node)
        tip = title if mark.node not in missed else f"{title}: {missed[mark.node]:.1f} px off"
        color = "ghost" if unknown else "warning" if wrong else "accent"
        yield Handle(f"{MARK}{mark.node}", (x, y, z), color=color, tip=tip)
        if wrong:
            off = others.get(mark.node, 0.0)
            yield Label((x, y, z), f"{title}: this mark disagrees by {off:.0f} px", color="warning")
        if missed.get(mark.node, 0.0) > TOLD:
            seen = stand.pixels(body.network.positions[[template.node[mark.node]]])
            pairs.append(np.vstack((place, stand.lifted(seen))))
    if pairs:
        points = np.concatenate(pairs).astype(np.float32)
        starts = np.arange(0, len(points), 2, dtype=np.int32)
        yield Lines(points, starts, color="second", width=1.2, hidden="show")


def _expected(asked: Asked, stand: Stand, body: Body) -> Iterator[Item]:
    """A ring where the next mark is expected, and the region in which it lies."""
    if asked.place is None or asked.ellipse is None:
        return
    at = stand.lifted(asked.place[None])
    yield Points(at.astype(np.float32), color="second", size=9.0, hidden="show")
    x, y, z = at[0].tolist()
    yield Label((x, y, z), body.template.titles.get(asked.node, asked.node), color="second")
    turn = np.linspace(0.0, 2.0 * np.pi, ROUND + 1)
    ring = asked.place + np.stack((np.cos(turn), np.sin(turn)), axis=1) @ asked.ellipse
    yield Lines(
        stand.lifted(ring).astype(np.float32), color="second", width=1.2, opacity=0.7, hidden="show"
    )
