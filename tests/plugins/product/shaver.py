"""A product of the size of the shaver in Kara & Shimada's chapter (section 13.2.5).

107 curves, of which 70 are drawn: 37 with mirror images, 26 across the plane, 7 in it that bound
nothing. Half of the 50 surfaces are their own mirror images.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.solve.found_patches import with_patches_found

STATIONS = 13
SPINES = 7
EDGE = 0.9
"""Angle from the middle of the top to where it meets the side, radians."""


def shaver(seed: int = 0) -> ProductState:
    """Rings round a long body, rails along its edges, and lines over half of its top."""
    random = np.random.default_rng(seed)
    waist, bend = random.uniform(0.1, 0.2), random.uniform(-8.0, 8.0)

    def place(station: Array, angle: Array, over: float = 0.0) -> Array:
        t = station / (STATIONS - 1)
        x = 60.0 * np.cos(np.pi * (1.0 - (0.08 + 0.84 * t)))
        size = np.sqrt(1.0 - (x / 66.0) ** 2) * (1.0 - waist * np.cos(4.0 * np.pi * t))
        y = 24.0 * size * np.sin(angle)
        z = (18.0 + over) * size * np.cos(angle) + bend * t * t
        return np.column_stack((x, y, z))

    def line(
        name: str,
        stations: tuple[float, float],
        angles: tuple[float, float],
        over: float = 0.0,
    ) -> dict[str, Any]:
        points = place(np.linspace(*stations, 41), np.linspace(*angles, 41), over)
        return {"name": name, "points": points.tolist()}

    low, high = EDGE, np.pi - EDGE
    curves = []
    for k in range(STATIONS):
        curves.append(line(f"side-{k}", (k, k), (low, high)))
        curves.append(line(f"top-{k}", (k, k), (low, -low)))
        curves.append(line(f"bottom-{k}", (k, k), (high, 2 * np.pi - high)))
    for k in range(STATIONS - 1):
        curves.append(line(f"upper-{k}", (k, k + 1), (low, low)))
        curves.append(line(f"lower-{k}", (k, k + 1), (high, high)))
    curves += [line(f"spine-{k}", (k + 0.2, k + 0.8), (0.0, 0.0), 6.0) for k in range(SPINES)]
    state = product_of_network({"network": {"curves": curves}, "unit": "mm"})
    reflection = Reflection(state.symmetry)
    nodes = tuple(
        _symmetric(node, reflection) if isinstance(node, Curve) else node for node in state.nodes
    )
    settled = settled_state(replace(state, nodes=nodes), {})
    return with_patches_found(settled)


def _symmetric(curve: Curve, reflection: Reflection) -> Curve:
    """Return a curve as drawn on one side, or exactly across the plane."""
    if curve.name.startswith(("side", "upper", "lower")):
        return replace(curve, mirrored=True)
    if curve.name.startswith("spine"):
        return curve
    return replace(curve, spline=reflection.symmetric(curve.spline))


def bent(state: ProductState, name: str, by: float) -> ProductState:
    """The product with the inside of a curve moved out; its ends stay."""
    curve = next(each for each in state.of_kind(Curve) if each.name == name)
    assert curve.spline is not None
    points = curve.spline.control_points.copy()
    points[1:-1] *= 1.0 + by
    spline = Spline(curve.spline.knots, points, curve.spline.closed)
    return state.with_node(replace(curve, spline=spline))
