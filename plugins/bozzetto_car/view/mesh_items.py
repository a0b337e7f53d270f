"""The mesh of a car and the points on it as scene items."""

from __future__ import annotations

import numpy as np

from bozzetto.scene import Handle, Item, Layer, Points, Shaded
from bozzetto_car.solver.pipeline import template_of
from bozzetto_car.state import CarState
from bozzetto_car.template.model import MIRROR
from bozzetto_car.view.mark_items import MARK, MARK_TOOL


def mesh_layers(state: CarState) -> tuple[Layer, ...]:
    """Return the mesh, and its points with handles; of a pair, the right one has it."""
    car = state.mesh
    if car is None:
        return ()
    template = template_of(state)
    shown = Layer("mesh", (Shaded(car.mesh, opacity=car.opacity),) if car.opacity else ())
    items: list[Item] = [
        Handle(
            f"{MARK}{point.node}",
            (point.x, point.y, point.z),
            tip=template.titles.get(point.node, point.node),
        )
        for point in car.points
    ]
    images = np.array([point.place * MIRROR for point in car.points if point.y > 0.0])
    if len(images):
        items.append(Points(images.astype(np.float32), size=5.0))
    return (shown, Layer("mesh points", tuple(items), tool=MARK_TOOL))
