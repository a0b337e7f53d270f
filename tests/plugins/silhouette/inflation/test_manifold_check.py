"""The check that runs while a person waits, against manifold3d's and against broken meshes."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_silhouette.inflation.manifold_check import as_manifold, soundness_of
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid, solidify
from bozzetto_silhouette.outline.outline import outline_from_rings
from tests.plugins.silhouette import outlines as o


@pytest.fixture(scope="module")
def rings() -> SilhouetteSolid:
    """Two bodies, one with two holes."""
    drawn = [o.circle(0, 0, 40), o.circle(-15, 0, 6), o.circle(15, 0, 6), o.circle(90, 0, 30)]
    return solidify(outline_from_rings(drawn), resolution=48)


def test_agrees_with_manifold3d(rings: SilhouetteSolid) -> None:
    found = soundness_of(rings.vertices + 1e5, rings.faces, rings.outline)
    other = as_manifold(rings.vertices, rings.faces)
    assert found.status == other.status().name == "NoError"
    assert found.volume == pytest.approx(other.volume(), rel=1e-9)
    assert found.components == len(other.decompose()) == 2
    assert found.genus == sum(piece.genus() for piece in other.decompose()) == 2
    assert found.ok


@pytest.mark.parametrize(
    "broken",
    [
        lambda v, f: (v, f[1:]),
        lambda v, f: (v, np.vstack([f[:1, ::-1], f[1:]])),
        lambda v, f: (v, np.vstack([f, f[:1]])),
        lambda v, f: (np.where(v == v.max(), np.nan, v), f),
        lambda v, f: (v, f[:, ::-1]),
        lambda v, f: (v, f[:0]),
    ],
    ids=["a hole", "a face turned", "a face twice", "not a number", "inside out", "nothing"],
)
def test_refuses_broken_meshes(rings: SilhouetteSolid, broken) -> None:
    vertices, faces = broken(rings.vertices, rings.faces)
    assert not soundness_of(vertices, faces, rings.outline).ok


def test_unused_vertices_are_no_bodies(rings: SilhouetteSolid) -> None:
    more = np.vstack([rings.vertices, [[0.0, 0.0, 0.0]]])
    assert soundness_of(more, rings.faces, rings.outline).ok
