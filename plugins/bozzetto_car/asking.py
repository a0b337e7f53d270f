"""Which mark is asked for next, and where the sketch will show it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto.view.calibration import predicted
from bozzetto_car.solving import Placed, Solved
from bozzetto_car.state import CarState
from bozzetto_car.visibility import facing

__all__ = ["Asked", "asked_of"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Asked:
    """The node that is to be marked.

    Attributes
    ----------
    node : str
    place : (2,) float or None
        Where the picture shows it as far as is known, px; None while the camera is not known.
    ellipse : (2, 2) float or None
        Half axes of the region in which it lies nine times of ten, px, as rows.
    hidden : bool
        It is on a side of the car that this sketch does not show.
    """

    node: str
    place: Array | None = None
    ellipse: Array | None = None
    hidden: bool = False


def asked_of(state: CarState, solved: Solved) -> Asked | None:
    """The node that the sketch in work is to be marked with next; None if it has all.

    That is the one that the person chose, or the first in the template's order that is neither
    marked nor skipped. Once the camera is known, nodes that the sketch shows come first.
    """
    sketch = state.sketch
    placed = None if sketch is None else solved.placed.get(sketch.id)
    if sketch is None or placed is None:
        return None
    template = solved.template
    shown = _shown(placed, solved)
    if state.asked in template.node:
        return _described(template.node[state.asked], placed, solved, shown)
    done = {mark.node for mark in sketch.marks} | {*sketch.skipped}
    open_ = [node for node in template.asked(sketch.shows) if template.names[node] not in done]
    if not open_:
        return None
    node = next((node for node in open_ if shown is None or shown[node]), open_[0])
    return _described(node, placed, solved, shown)


def _shown(placed: Placed, solved: Solved) -> NDArray[np.bool_] | None:
    """Which nodes the sketch shows, (n,); None while that is not known."""
    if not placed.is_known:
        return None
    return facing(solved.template, solved.positions, placed.stand.camera)


def _described(node: int, placed: Placed, solved: Solved, shown: NDArray[np.bool_] | None) -> Asked:
    name = solved.template.names[node]
    if shown is None or placed.resection is None:
        return Asked(name)
    point = solved.positions[node]
    place = placed.stand.pixels(point[None])[0]
    if not np.isfinite(place).all():
        return Asked(name, hidden=True)
    axes = predicted(placed.resection, point[None]).ellipses()[0]
    return Asked(name, place, axes, hidden=not bool(shown[node]))
