"""Bodies to test with, and what is true of all that are put together."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry import Placement
from bozzetto_silhouette.inflation.heightfield import Relief
from bozzetto_silhouette.inflation.manifold_check import as_manifold
from bozzetto_silhouette.inflation.solidify import solidify
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.outline.outline import Outline, outline_from_rings
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.view.picking import shape_seen
from tests.plugins.silhouette import outlines as o

Points = NDArray[np.float64]


def body(outline: Outline, resolution: int = 48, name: str = "a") -> Body:
    solid = solidify(outline, resolution=resolution)
    return Body(
        solid.vertices,
        solid.faces,
        solid.normals,
        np.zeros(len(solid.vertices), np.int32),
        (name,),
        Relief(solid),
        float(solid.skeleton.nodes[:, 2].max()),
        solid.step,
    )


def ball(x: float = 0.0, radius: float = 50.0, resolution: int = 48, name: str = "a") -> Body:
    return body(outline_from_rings([o.circle(x, 0.0, radius, 160)]), resolution, name)


def capsule(half: float, radius: float, resolution: int = 48, name: str = "b") -> Body:
    angle = np.linspace(-np.pi / 2, np.pi / 2, 40)
    end = np.column_stack([half + radius * np.cos(angle), radius * np.sin(angle)])
    return body(outline_from_rings([np.vstack([end, -end])]), resolution, name)


def turn(axis: str, degrees: float, offset: tuple[float, float, float] = (0, 0, 0)) -> Placement:
    c, s = float(np.cos(np.deg2rad(degrees))), float(np.sin(np.deg2rad(degrees)))
    rows = {
        "x": (1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c),
        "y": (c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c),
        "z": (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0),
    }
    return Placement(rows[axis], 1.0, offset)


def volume(shape: Body | None) -> float:
    return 0.0 if shape is None else float(as_manifold(shape.vertices, shape.faces).volume())


def genus(shape: Body) -> int:
    return int(as_manifold(shape.vertices, shape.faces).genus())


def assert_sound(shape: Body) -> None:
    mesh = as_manifold(shape.vertices, shape.faces)
    assert mesh.status().name == "NoError"
    assert mesh.volume() > 0.0
    assert np.isfinite(shape.vertices).all()
    length = np.linalg.norm(shape.normals, axis=1)
    assert np.allclose(length, 1.0, atol=1e-6)
    assert len(shape.origins) == len(shape.vertices)
    assert 0 <= shape.origins.min() <= shape.origins.max() < len(shape.sources)


def reach_along(shape: Body, origin: Points, direction: Points) -> float:
    """Where a ray from inside leaves the mesh for good."""
    start = np.asarray(origin, float)
    away = np.asarray(direction, float)
    length = 4.0 * float(np.ptp(shape.vertices, axis=0).max())
    hits = as_manifold(shape.vertices, shape.faces).ray_cast(
        tuple(start), tuple(start + length * away)
    )
    return max(float(np.linalg.norm(np.subtract(hit.position, start))) for hit in hits)


def solid(state: SilhouetteState) -> Any:
    """What is shown of a state, as a solid of Manifold; it is sound and not empty."""
    shown = shape_seen(state).body
    made = as_manifold(shown.vertices, shown.faces)
    assert made.status().name == "NoError"
    assert made.volume() > 0.0
    return made
