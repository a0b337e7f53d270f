"""The whole shape under the pen: where lines of sight meet it, and which part is met."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.geometry import Mesh
from bozzetto.plugin import remembered
from bozzetto.scene import Hits, Layer, Scene, Shaded, cast_rays
from bozzetto.view import Camera, Rays
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.draft import draft_of
from bozzetto_silhouette.solids.evaluate import tree_body
from bozzetto_silhouette.solids.traversal import without_blends

TOUCHED_CELLS = 64
"""Resolution of the shape that the pen is held against: that of the preview, whose parts have
been worked out before anybody can point at them."""


@dataclass(frozen=True, eq=False)
class Touch:
    """A shape that lines of sight can meet.

    Attributes
    ----------
    body : Body
    scene : Scene
        The same as a mesh; kept as it is, so that the tree of its boxes is built once.
    """

    body: Body
    scene: Scene

    def hits(self, rays: Rays) -> Hits:
        """Return where rays first meet the shape."""
        return cast_rays(self.scene, rays)

    def under(self, pixels: ArrayLike, camera: Camera) -> Hits:
        """Return where lines of sight through canvas positions (n, 2) meet the shape."""
        return self.hits(camera.rays(pixels))


def shape_seen(state: SilhouetteState) -> Touch | None:
    """Return the shape of all nodes that are switched on; None where there is nothing.

    It is put together without blends, which would take longer than a pen may wait: what is
    touched lies under a fillet, not on it.

    Raises
    ------
    UserError
        If a part's ink is no outline.
    """
    return _seen(without_blends(state).nodes)


@remembered(limit=16)
def _seen(nodes: tuple[Any, ...]) -> Touch | None:
    body = tree_body(SilhouetteState(nodes), TOUCHED_CELLS)
    return None if body is None else _touch(body)


def _touch(body: Body) -> Touch:
    mesh = Mesh(body.vertices.astype(np.float32), body.faces)
    return Touch(body, Scene((Layer("shape", (Shaded(mesh),)),)))


def touched_part(state: SilhouetteState, x: float, y: float, camera: Camera) -> Part | None:
    """Return the part that made the surface under a canvas position; None beside the shape.

    The wall of a tunnel belongs to the tunnel.
    """
    touch = _seen_in_draft(without_blends(state).nodes)
    if touch is None:
        return None
    hits = touch.under([(x, y)], camera)
    if not hits.hit[0]:
        return None
    corner = touch.body.faces[hits.faces[0], hits.weights[0].argmax()]
    source = touch.body.sources[touch.body.origins[corner]]
    return next((part for part in state.parts if part.id == source), None)


# Which part lies on top is seen without uniting them.
@remembered(limit=16)
def _seen_in_draft(nodes: tuple[Any, ...]) -> Touch | None:
    draft, _ = draft_of(SilhouetteState(nodes), TOUCHED_CELLS)
    return None if draft is None else _touch(draft.body)
