"""Construction lines by hand."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Curve as ShapeCurve
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Ink, Tap
from bozzetto.scene import Lines
from bozzetto.view import Camera
from bozzetto_symmetry.model.axes import AXIS_PAINTS
from bozzetto_symmetry.model.state import Line, SymmetryState
from bozzetto_symmetry.tools.draw_line import DrawLine
from tests.previews import preview_of

STATE = SymmetryState()
TOOL = DrawLine()
CAMERA = Camera(eye=(400.0, -500.0, 250.0))


def stroke(begin: tuple[float, ...], end: tuple[float, ...], tool: str = "pen") -> Stroke:
    points, _ = CAMERA.project(np.linspace(begin, end, 30))
    return Stroke(*points.T, CAMERA, tool=tool)  # type: ignore[arg-type]


UP = stroke((100, -50, -50), (100, -50, 20))
ON = stroke((100, -50, 20), (40, -50, 20))


def test_a_stroke_is_a_line_and_the_next_begins_at_its_end() -> None:
    one = TOOL.apply(STATE, Ink((UP,)), Context())
    assert [node.name for node in one.nodes] == ["Line 1"]
    assert one.selected == one.nodes[0].id
    both = TOOL.apply(one, Ink((ON,)), Context())
    first, second = both.nodes
    assert isinstance(first, Line)
    assert isinstance(second, Line)
    assert first.begin == (100.0, -50.0, -50.0)
    assert first.end == pytest.approx((100.0, -50.0, 20.0), abs=1e-3)
    assert second.begin == first.end
    assert second.end == pytest.approx((40.0, -50.0, 20.0), abs=1e-3)
    assert second.name == "Line 2"
    assert TOOL.apply(STATE, Ink((UP, ON)), Context()) == both


def test_the_preview_has_the_colour_of_the_axis() -> None:
    for drawn, axis in ((UP, 2), (ON, 0)):
        state = TOOL.apply(STATE, Ink((UP,)), Context())
        ((_, item),) = preview_of(TOOL, state, Ink((drawn,)), Context()).items()
        assert isinstance(item, Lines)
        assert item.color == AXIS_PAINTS[axis]
    dot = Stroke([5.0], [5.0], CAMERA)
    assert not preview_of(TOOL, STATE, Ink((dot,)), Context()).layers
    assert not preview_of(TOOL, STATE, Tap(1.0, 2.0, CAMERA), Context()).layers


def test_a_line_begins_on_a_curve_of_another_model() -> None:
    rail = ShapeCurve(
        1, np.array([0, 0, 1, 1.0]), np.array([[-40.0, -20.0, 12.0], [60.0, -20.0, 12.0]])
    )
    drawn = stroke((10, -20, 12), (10, 15, 12))
    (line,) = TOOL.apply(STATE, Ink((drawn,)), Context(curves=(rail,))).nodes
    assert isinstance(line, Line)
    assert line.begin == pytest.approx((10.0, -20.0, 12.0), abs=1e-3)
    assert line.end == pytest.approx((10.0, 15.0, 12.0), abs=1e-3)


def test_the_eraser_takes_a_line_away() -> None:
    one = TOOL.apply(STATE, Ink((UP,)), Context())
    rubbed = stroke((100, -50, -48), (100, -50, 18), tool="eraser")
    assert TOOL.apply(one, Ink((rubbed,)), Context()).nodes == ()
    with pytest.raises(UserError):
        TOOL.apply(STATE, Ink((rubbed,)), Context())
    assert not preview_of(TOOL, one, Ink((rubbed,)), Context()).layers


def test_what_is_no_ink_is_refused() -> None:
    with pytest.raises(UserError, match=TOOL.hint):
        TOOL.apply(STATE, Tap(1.0, 2.0, CAMERA), Context())
