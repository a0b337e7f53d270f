"""The drawing plane, as it is shown: where it cuts the box, with a handle in its middle."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.geometry import Mesh
from bozzetto.scene import Handle, Layer, Lines, Shaded
from bozzetto.view import triple
from bozzetto_symmetry.model.box_geometry import plane_outline
from bozzetto_symmetry.model.state import SymmetryState

PLANE_TOOL: Final = "plane"
"""Id of the tool that shows the handle."""

PLANE_HANDLE: Final = "drawing plane"
"""Id of the handle that moves the plane along its normal."""

EDGE_WIDTH, OPACITY = 1.6, 0.10
"""Width of the outline, px, and opacity of the plane."""


def plane_layers(state: SymmetryState) -> tuple[Layer, ...]:
    """Return the plane that new curves lie in, and its handle; nothing where they do not."""
    plane = state.drawing_plane
    if plane is None or state.lay != "plane":
        return ()
    outline = plane_outline(state, plane)
    fan = [(0, k, k + 1) for k in range(1, len(outline) - 1)]
    mesh = Mesh(outline.astype(np.float32), np.array(fan, np.int32))
    ring = np.vstack((outline, outline[:1])).astype(np.float32)
    shown = Shaded(mesh, "accent", OPACITY, pickable=False)
    handle = Handle(PLANE_HANDLE, triple(outline.mean(axis=0)), "accent", "Move the drawing plane")
    return (
        Layer("drawing plane", (shown, Lines(ring, color="accent", width=EDGE_WIDTH))),
        Layer("drawing plane handle", (handle,), tool=PLANE_TOOL),
    )
