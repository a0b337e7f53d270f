"""Characters in the hands of three.js: what walks and sways there goes where it goes here."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image, ImageDraw

from bozzetto.exchange.export import encode_shapes
from bozzetto.geometry import Shapes
from tests.plugins.silhouette.rigging.characters import solid_of
from tests.plugins.silhouette.rigging.test_motion import HORSE, PERSON, later, ran
from tests.threejs import SIDE, asked

pytestmark = pytest.mark.interop

TIMES = (0.0, 0.13, 0.37, 0.71, 0.94)


def in_file(places):
    """Places in metres with Y up, as the browser has them."""
    return places[..., [0, 2, 1]] * (1.0, 1.0, -1.0) / 1000.0


def shadow(mesh, seen):
    """The mesh from the front, in the frame of a picture of the browser."""
    low, high = np.array(seen["low"]), np.array(seen["high"])
    corners = in_file(mesh.vertices)[mesh.faces][..., :2]
    scale = 0.5 * SIDE / seen["half"]
    flat = 0.5 * SIDE + (corners - 0.5 * (low + high)[:2]) * (scale, -scale) - 0.5
    image = Image.new("1", (SIDE, SIDE))
    draw = ImageDraw.Draw(image)
    for triangle in flat:
        draw.polygon([tuple(place) for place in triangle], fill=1)
    return np.asarray(image)


def overlap(one, two):
    return (one & two).sum() / (one | two).sum()


@pytest.mark.parametrize("motion", ["walk", "sway"])
@pytest.mark.parametrize("state", [PERSON, HORSE], ids=["person", "horse"])
def test_skinned_vertices_go_where_ours_go(state, motion):
    moving = ran(state, motion)
    data = encode_shapes(Shapes(solids=(solid_of(moving),)), "a.glb")
    seen = asked(data, TIMES)
    assert seen["clips"] == 1
    now = moving
    first = None
    for time, places in zip(TIMES, seen["frames"], strict=True):
        now = later(now, time - now.time) if time > now.time else now
        expected = in_file(solid_of(now).mesh.vertices)
        assert places.shape == expected.shape
        assert np.abs(places - expected).max() < 5e-6  # metres: 0.005 mm
        first = places if first is None else first
    height = np.ptp(first, axis=0).max()
    assert np.abs(places - first).max() > 0.002 * height, "nothing moved"


def test_a_horse_in_mid_walk_is_drawn_as_it_walks():
    walk = ran(HORSE, "walk")
    data = encode_shapes(Shapes(solids=(solid_of(walk),)), "a.glb")
    seen = asked(data, (0.37,), picture=True)
    now = shadow(solid_of(later(walk, 0.37)).mesh, seen)
    rest = shadow(solid_of(HORSE).mesh, seen)
    assert overlap(seen["picture"], now) > 0.97
    assert overlap(seen["picture"], rest) < 0.95
