"""The small picture of the export dialog shows what is handed over."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.exchange.cad.curve_pieces import polyline
from bozzetto.exchange.export import prepare_export
from bozzetto.exchange.export_picture import picture_of_page, picture_of_shapes
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.ready_shapes import Ready
from bozzetto.geometry import Curve, Placement, Shapes, Solid
from bozzetto.scene import DARK, LIGHT
from tests.core.exchange.skinned import tube

SIZE = (200, 100)
WORM = Shapes(solids=(Solid(tube(), "Worm", (200, 30, 30)),))


@pytest.mark.parametrize("scale", [1.0, 2.0])
@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=["light", "dark"])
def test_shapes_are_in_the_picture_and_nothing_behind_them(palette, scale):
    image = picture_of_shapes(WORM, palette, SIZE, scale)
    assert image.shape == (100 * scale, 200 * scale, 4)
    there = image[..., 3] > 0
    assert 0.05 < there.mean() < 0.9
    assert not there[[0, -1]].any()
    red = image[there].mean(axis=0)
    assert red[0] > 1.5 * red[1]


def test_what_lies_flat_is_seen_to_lie_and_what_is_thinned_to_be_thin():
    usual = picture_of_shapes(Ready(WORM).triangles, LIGHT, SIZE)
    turn = Placement((0, 0, -1, 0, 1, 0, 1, 0, 0))
    stood = replace(WORM, solids=tuple(solid.placed(turn) for solid in WORM.solids))
    upright = picture_of_shapes(Ready(stood).triangles, LIGHT, SIZE)
    lying = picture_of_shapes(Ready(stood, Handover(lay_flat=True)).triangles, LIGHT, SIZE)

    def width(image):
        return np.ptp(np.flatnonzero(image[..., 3].any(axis=0)))

    assert width(lying) > 2 * width(upright)
    thin = picture_of_shapes(Ready(WORM, Handover(triangles=40)).triangles, LIGHT, SIZE)
    assert (thin != usual).any()


def test_curves_and_drawings_are_lines():
    places = np.array([[0, 0, 0], [30, 0, 0], [30, 20, 0], [0, 20, 9.0]])
    curve = Curve(3, np.array([0, 0, 0, 0, 1, 1, 1, 1.0]), places)
    two = Shapes(curves=(curve, curve.with_knots([0, 0, 0, 0, 0.4, 0.5, 1, 1, 1, 1])))
    along = polyline(curve.value(np.linspace(0.0, 1.0, 200)))
    seen, expected = (
        picture_of_shapes(shapes, LIGHT, SIZE)[..., 3] > 0
        for shapes in (two, Shapes(curves=(along,)))
    )
    assert (seen & expected).sum() > 0.95 * (seen | expected).sum()
    for lines in ("outlines", "blueprint"):
        made = prepare_export(WORM, "a.svg", handover=Handover(lines=lines))
        assert made.page is not None
        image = picture_of_page(made.page, LIGHT, SIZE)
        seen = image[..., 3] > 0
        assert 0.005 < seen.mean() < 0.4
    ratio = np.ptp(np.flatnonzero(seen.any(axis=0))) / np.ptp(np.flatnonzero(seen.any(axis=1)))
    assert ratio == pytest.approx(made.page.width / made.page.height, rel=0.1)
