"""The shadow against manifold3d's projection, and against a solid that overhangs itself."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_silhouette.analysis.projected_outline import shadow_of
from bozzetto_silhouette.inflation.solidify import solidify
from bozzetto_silhouette.outline.outline import outline_from_rings
from tests.plugins.silhouette import outlines as o


def projected(solid) -> float:
    """Area within manifold3d's rings: outer ones run one way, holes the other."""
    rings = [ring.T for ring in solid.project().to_polygons()]
    return abs(sum(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) for x, y in rings)) / 2


def test_a_disc_with_a_hole_casts_what_manifold3d_says() -> None:
    from bozzetto_silhouette.inflation.manifold_check import as_manifold

    solid = solidify(outline_from_rings([o.circle(0, 0, 40), o.circle(-15, 0, 6)]), resolution=48)
    shadow = shadow_of(solid.vertices, solid.faces)
    assert len(shadow.interiors) == 1
    assert shadow.area == pytest.approx(
        projected(as_manifold(solid.vertices, solid.faces)), rel=1e-9
    )


def test_what_overhangs_counts_once() -> None:
    import manifold3d

    tower = manifold3d.Manifold.cube((10, 10, 2))
    tower += manifold3d.Manifold.cube((4, 4, 20)).translate((3, 3, 0))
    tower += manifold3d.Manifold.cube((20, 6, 2)).translate((2, 2, 18))
    mesh = tower.to_mesh()
    vertices = np.asarray(mesh.vert_properties, float)[:, :3]
    shadow = shadow_of(vertices, np.asarray(mesh.tri_verts, np.int32))
    assert shadow.area == pytest.approx(100 + 20 * 6 - 8 * 6, rel=1e-6)
