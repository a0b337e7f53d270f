"""Rough shapes: closed, of the size asked for, and the same triangles at any size."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.plugin import Job
from bozzetto.view import Camera
from bozzetto_product.model.rough_shapes import RoughKind, RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.rough_shapes.shapes import rough_mesh

KINDS = get_args(RoughKind)
SIZE = np.array((120.0, 80.0, 60.0))


def _shape(kind: str, scale: float = 1.0, **more: object) -> RoughShape:
    length, width, height = (scale * SIZE).tolist()
    return RoughShape(kind=kind, length=length, width=width, height=height, **more)


@pytest.mark.parametrize("kind", KINDS)
def test_a_shape_bounds_one_volume(kind: str) -> None:
    """An independent kernel takes it as one closed body without handles."""
    import manifold3d

    mesh = rough_mesh(_shape(kind))
    body = manifold3d.Manifold(
        manifold3d.Mesh(np.array(mesh.vertices), np.array(mesh.faces, np.uint32))
    )
    assert body.status() == manifold3d.Error.NoError
    assert body.genus() == 0
    assert 0.3 * SIZE.prod() < body.volume() <= SIZE.prod() * (1.0 + 1e-6)
    assert 500 <= len(mesh.faces) <= 5000


@pytest.mark.parametrize("kind", KINDS)
def test_a_shape_fills_its_box(kind: str) -> None:
    """Length is along x, width along y, height along z, about the centre."""
    mesh = rough_mesh(_shape(kind, centre=(5.0, -7.0, 9.0)))
    assert np.allclose(mesh.bounds.mean(axis=0), (5.0, -7.0, 9.0), atol=1e-3)
    assert np.allclose(np.ptp(mesh.bounds, axis=0), SIZE, rtol=1e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_what_lies_on_a_shape_goes_along_when_it_is_sized(kind: str) -> None:
    """A thousand times the size has the same triangles, each a thousand times as large."""
    small, large = rough_mesh(_shape(kind)), rough_mesh(_shape(kind, 1000.0))
    assert (small.faces == large.faces).all()
    assert np.allclose(large.vertices, 1000.0 * small.vertices, rtol=1e-5, atol=1e-2)


@pytest.mark.parametrize("kind", ["cylinder", "sphere", "bottle"])
def test_a_turned_shape_is_round(kind: str) -> None:
    """With equal length and width every point of the widest ring is at the radius."""
    mesh = rough_mesh(RoughShape(kind=kind, length=80.0, width=80.0, height=100.0))
    reach = np.hypot(mesh.vertices[:, 0], mesh.vertices[:, 1])
    assert np.isclose(reach.max(), 40.0, rtol=1e-5)
    assert (reach > 39.999).sum() % 64 == 0


@pytest.mark.parametrize("size", [0.0, -1.0, np.nan, np.inf])
def test_a_size_that_is_none_is_refused(size: float) -> None:
    with pytest.raises(UserError):
        rough_mesh(RoughShape(kind="box", length=size))


def test_a_rough_shape_out_of_sight_offers_a_view_of_all_of_it() -> None:
    """A bottle in the place of a box is higher than the view of that box."""
    modeler = ProductModeler()
    tall = RoughShape(id="r", kind="bottle", length=70.0, width=70.0, height=900.0)
    camera = Camera(eye=(220.0, -260.0, 160.0), target=(0.0, 0.0, 30.0))
    for shape, offered in ((_shape("box"), False), (tall, True)):
        state = ProductState().with_node(shape)
        advice = modeler.view_advice(state, camera, Job())
        assert advice is not None
        assert (advice.better is not None) == offered
    assert advice.better is not None
    seen, depths = advice.better.project(rough_mesh(tall).vertices)
    assert ((seen >= 0.0) & (seen <= advice.better.viewport)).all()
    assert (depths > 0.0).all()
