"""Faces of bodies laid flat on the ground at true size, beside the bodies: for SVG and DXF."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import replace
from typing import Any, Final

import numpy as np

from bozzetto.geometry import Curve
from bozzetto.plugin import remembered
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.unfolding import face_curves, net_curves, nets
from bozzetto_polyhedron.solve.pipeline import Solved

GAP: Final = 0.1
"""Space between bodies and pages, and from page to page, as share of the page."""


def page_curves(state: PolyhedronState, results: Mapping[str, Solved]) -> tuple[Curve, ...]:
    """Return the faces or nets of all bodies that are shown, each body's in a row of its own.

    They lie in z = 0, to the right of all bodies; empty where files get solids.
    """
    if state.files == "solids":
        return ()
    joined = {
        other for found in results.values() if found.changed for other in found.changed.joined
    }
    bodies = [
        (body, results[body.id].body)
        for body in state.shown(Body)
        if body.id in results and body.id not in joined
    ]
    made = [(body, planar) for body, planar in bodies if planar is not None]
    if not made:
        return ()
    right = max(float(planar.vertices[:, 0].max()) for _, planar in made)
    placed: list[Curve] = []
    top = 0.0
    for body, planar in made:
        row = _row(planar, state.files, state.tab)
        points = np.concatenate([curve.control_points for curve in row])
        low, extent = points.min(axis=0), np.ptp(points, axis=0)
        gap = GAP * float(extent.max())
        shift = np.array((right + gap, top, 0.0)) - low
        top += float(extent[1]) + gap
        placed += [
            replace(
                curve,
                control_points=curve.control_points + shift,
                name=f"{body.name}, {curve.name}",
            )
            for curve in row
        ]
    return tuple(placed)


def _by_content(body: PlanarBody, *rest: Any) -> Hashable:
    return (body.vertices.tobytes(), body.faces, *rest)


@remembered(limit=16, key=_by_content)
def _row(body: PlanarBody, what: str, tab: float) -> tuple[Curve, ...]:
    return face_curves(body) if what == "faces" else net_curves(nets(body, tab))
