"""A head drawn with Silhouette, for what is worn on one."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from product_hand import Body, Hand

from bozzetto.arrays import Array
from bozzetto.geometry import Mesh
from bozzetto_product.model.rough_shapes import RoughShape

FILE = "drawn-on/head.json"
"""Where it lies, beside the file of what is worn."""

PROFILE = (
    (36, -48), (37, -14), (47, 12), (76, 13), (92, 28), (95, 58), (99, 74), (110, 90), (101, 116),
    (101, 145), (93, 178), (68, 209), (24, 228), (-28, 229), (-74, 208), (-99, 168), (-101, 130),
    (-86, 94), (-68, 58), (-62, 20), (-62, -14), (-63, -48), (-48, -56), (-13, -58), (22, -56),
)  # fmt: skip
"""Places (x, z) of its outline seen from the right, mm."""

INFLATION = 0.84

SIZE = RoughShape(kind="head", length=210.0, width=165.0, height=230.0, centre=(0.0, 0.0, 115.0))
"""About its box, to look at it."""


def head_record() -> dict[str, Any]:
    """The ink file of the head: its outline from the side, inflated."""
    hand = Hand("head", [Body(SIZE)])
    hand.round(_outline(), hand.view(-90.0, 0.0), "draw", inflation=INFLATION)
    hand.steps.append({"rename": "Head"})
    record = hand.record()
    del record["template"]
    return {**record, "modeler": "silhouette", "camera": record["strokes"][0]["camera"]}


def _outline() -> Array:
    """The outline as a smooth closed curve (n, 3), mm."""
    from scipy.interpolate import CubicSpline

    row = np.array((*PROFILE, PROFILE[0]), float)
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(row, axis=0), axis=1))))
    at = np.linspace(0.0, along[-1], 600)
    x, z = CubicSpline(along, row, bc_type="periodic")(at).T
    return np.column_stack((x, np.zeros_like(x), z))


class DrawnHead(Body):
    """The head, known as rough shapes are: by ring, and share of a turn."""

    def __init__(self) -> None:
        self.shape = None
        heights = Body(SIZE).grid[:, :, 2].mean(axis=1)
        self.grid = np.array([self._ring(height) for height in heights])

    @property
    def mesh(self) -> Mesh:
        """Its surface."""
        return _head_mesh()

    def _ring(self, height: float) -> Array:
        """Places (64, 3) all round at a height, mm, where rays to the middle meet the surface."""
        from bozzetto.scene import Layer, Scene, Shaded, cast_rays
        from bozzetto.view import Rays

        scene = Scene((Layer("head", (Shaded(self.mesh),)),))
        points = self.mesh.vertices.astype(float)
        near = points[np.abs(points[:, 2] - height) < 8.0]
        middle = np.array((0.5 * (near[:, 0].min() + near[:, 0].max()), 0.0, height))
        turn = 2.0 * np.pi * np.arange(64) / 64.0
        ways = np.column_stack((np.cos(turn), np.sin(turn), np.zeros(64)))
        hits = cast_rays(scene, Rays(middle + 500.0 * ways, -ways))
        return np.where(hits.hit[:, None], hits.points, middle)


@cache
def _head_mesh() -> Mesh:
    import json
    import tempfile
    from pathlib import Path

    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench

    bench = Workbench(Registry())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "head.json"
        path.write_text(json.dumps(head_record()), "utf-8")
        drawing = read_drawing(path)
    model = bench.sources.from_drawing("bozzetto.silhouette", drawing, {})
    (solid,) = bench.shapes([model], Job()).solids
    return solid.mesh
