"""Strokes refuse what no document could keep, before anybody draws on."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.ink.stroke import COLUMNS, Stroke
from bozzetto.view.camera import Camera


@pytest.mark.parametrize(
    "facts",
    [
        {"tool": "axe"},
        {"color": (0, 0, 256)},
        {"color": (0, -1, 0)},
        {"color": (0, 0)},
        {"group": "x" * 1001},
        {"group": "\ud800"},
    ],
)
def test_facts_that_cannot_be_kept_are_refused(facts):
    with pytest.raises(UserError):
        Stroke([1.0], [2.0], Camera(), **facts)
    assert Stroke([1.0], [2.0], Camera(), tool="mouse", color=(0, 255, 9), group="rim ✎\x01")


@pytest.mark.parametrize("far", [1.1e9, -3.1e9, 1e30])
def test_places_that_nothing_can_be_reckoned_with_are_refused(far):
    for x, y in ([0.0, far], [0.0, 0.0]), ([0.0, 0.0], [far, 0.0]):
        with pytest.raises(UserError, match=r"1,000,000,000 pixels away\. Scale"):
            Stroke(x, y, Camera())
    assert Stroke([1e9], [-1e9], Camera())


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_rays_of_ink_move_with_the_world(side):
    camera = Camera(eye=(30.0, -400.0, 120.0), target=(5.0, 10.0, -20.0))
    stroke = Stroke(
        [100.0, 700.25, 1100.5], [50.0, 400.0, 800.0], camera,
        pressure=[0.1, 0.5, 0.9], tilt_x=[10.0, 20.0, 30.0], twist=[1.0, 2.0, 3.0], group="rim",
    )  # fmt: skip
    placement = Placement((0, side, 0, -1, 0, 0, 0, 0, 1), 2.5, (7.0, -8.0, 9.0))
    moved = stroke.moved(placement)
    before, after = camera.rays(stroke.points), moved.camera.rays(moved.points)
    np.testing.assert_allclose(after.origins, placement.points(before.origins), atol=1e-9)
    np.testing.assert_allclose(after.directions, placement.directions(before.directions), atol=1e-9)
    assert np.array_equal(moved.pressure, stroke.pressure)
    assert np.array_equal(moved.tilt_x, side * stroke.tilt_x)
    assert moved.group == "rim"
    assert moved.has_pressure
    assert not moved.has_time
    assert without_camera(moved.moved(placement.inverse())) == without_camera(stroke)


def without_camera(stroke):
    """A stroke without its camera, which comes back up to rounding only."""
    return [getattr(stroke, name).tolist() for name in COLUMNS]


def test_the_name_of_a_strokes_content_hangs_on_its_content_alone():
    """It is kept once it was asked for: what was made otherwise, or asked earlier, has the same."""
    one = Stroke([1.0, 2.0], [3.0, 4.0], Camera(), group="rim", pressure=[0.1, 0.2])
    asked = one.digest
    copies = [
        Stroke([1.0, 2.0], [3.0, 4.0], Camera(), group="rim", pressure=[0.1, 0.2]),
        Stroke.from_columns(
            [getattr(one, name) for name in COLUMNS],
            one.camera, one.tool, one.color, one.group, one.has_pressure, one.has_time,
        ),
        one.moved(Placement()),
    ]  # fmt: skip
    for copy in copies:
        assert copy.digest == copy.digest == asked == one.digest
        assert hash(copy) == hash(one)
        assert copy == one
    others = [
        Stroke([1.0, 2.5], [3.0, 4.0], Camera(), group="rim", pressure=[0.1, 0.2]),
        Stroke([1.0, 2.0], [3.0, 4.0], Camera(), group="arm", pressure=[0.1, 0.2]),
        Stroke([1.0, 2.0], [3.0, 4.0], Camera(eye=(0.0, -9.0, 1.0)), group="rim"),
        one.moved(Placement((1, 0, 0, 0, 1, 0, 0, 0, 1), 1.0, (1.0, 0.0, 0.0))),
    ]
    assert asked not in {other.digest for other in others}
