"""The mesh of a car and the points on it as scene items."""

from __future__ import annotations

from bozzetto.scene import Handle, Layer, Shaded
from bozzetto.view import triple
from bozzetto_car.solver.pipeline import template_of
from bozzetto_car.state import CarState
from bozzetto_car.view.mark_items import MARK, MARK_TOOL


def mesh_layers(state: CarState) -> tuple[Layer, ...]:
    """Return the mesh, and its points with handles; of a pair, both have one."""
    car = state.mesh
    if car is None:
        return ()
    template = template_of(state)
    shown = Layer("mesh", (Shaded(car.mesh, opacity=car.opacity),) if car.opacity else ())
    handles = tuple(
        Handle(f"{MARK}{node}", triple(place), tip=template.titles.get(point.node, point.node))
        for point in car.points
        for node, place in point.on_both_sides()
    )
    return (shown, Layer("mesh points", handles, tool=MARK_TOOL))
