"""Every format in every unit, with every axis up and at every scale: as asked for, or told.

What an independent reader finds in the numbers of a file is where the things are, in the unit and
the axes that were asked for. A format that keeps its own says so, in the file and in a sentence.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from bozzetto.exchange.export import WRITERS, prepare_export
from bozzetto.exchange.handover import Handover
from bozzetto.geometry import Curve, Mesh, Shapes, Solid
from bozzetto.view import Camera
from tests.core.exchange.frame_readers import READERS

LOW, HIGH = np.array([5.0, -3.0, 7.0]), np.array([15.0, 17.0, 37.0])
"""Corners of a box that no exchange of axes leaves as it is, mm."""

MM = {None: None, "mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
UPS = (None, "y", "z")
SCALES = (1.0, 0.1, 3.0)
CHOICES = list(itertools.product(MM, UPS, SCALES))

ENDINGS = tuple(one.endings[0].removeprefix(".") for one in WRITERS)


def things():
    """A box as a mesh, and a line through its corners as a curve."""
    corners = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
             [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]  # fmt: skip
    mesh = Mesh(LOW + (HIGH - LOW) * corners, faces)
    line = Curve(1, np.array([0.0, 0.0, 1.0, 1.0]), np.stack([LOW, HIGH]))
    return Shapes(solids=(Solid(mesh, "box"),), curves=(line,))


def in_axes(low, high, up):
    """Corners of a box in axes of which the second or the third points up."""
    if up == "z":
        return low, high
    return np.array([low[0], low[2], -high[1]]), np.array([high[0], high[2], -low[1]])


def test_there_is_a_reader_for_every_format():
    assert set(READERS) == set(ENDINGS)


@pytest.mark.parametrize("ending", ENDINGS)
def test_the_frame_is_as_asked_for_or_told(ending):
    if ending == "dxf":
        pytest.importorskip("ezdxf")
    if ending == "3dm":
        pytest.importorskip("rhino3dm")
    own = READERS[ending](prepare_export(things(), f"a.{ending}").data)
    for unit, up, scale in CHOICES:
        wanted = Handover(unit=unit, up=up, scale=scale)
        made = prepare_export(things(), f"a.{ending}", handover=wanted)
        seen = READERS[ending](made.data)
        said_unit = any("always in" in note for note in made.notes)
        said_up = any(" up." in note or "up is" in note for note in made.notes)
        # What is not told is as asked for; what the file says of itself is true.
        if said_unit:
            assert seen.unit == own.unit != MM[unit], (unit, up)
        elif unit is not None and seen.unit is not None:
            assert seen.unit == pytest.approx(MM[unit]), (unit, up)
        if up is not None and seen.up is not None:
            assert said_up == (seen.up != up or ending == "svg"), (unit, up)
        usual = {"obj": "y"}.get(ending, "z")
        size = seen.unit or MM[unit] or 1.0
        expected = in_axes(scale * LOW, scale * HIGH, seen.up or up or usual)
        for found, corner in zip((seen.low, seen.high), expected, strict=True):
            there = ~np.isnan(found)
            np.testing.assert_allclose(
                (found * size)[there], corner[there], atol=2e-5 * scale * 37, err_msg=str(wanted)
            )
            assert there.sum() == (2 if ending == "svg" else 3)


@pytest.mark.parametrize("unit", MM)
@pytest.mark.parametrize("ending", ["svg", "dxf"])
def test_outlines_are_in_the_unit_or_say_that_they_are_not(ending, unit):
    if ending == "dxf":
        pytest.importorskip("ezdxf")
    wanted = Handover(unit=unit, lines="outlines", scale=3.0)
    made = prepare_export(things(), f"a.{ending}", handover=wanted)
    seen = READERS[ending](made.data)
    for found, corner in ((seen.low, 3.0 * LOW), (seen.high, 3.0 * HIGH)):
        np.testing.assert_allclose((found * seen.unit)[[0, 2]], corner[[0, 2]], atol=1e-4)
    if unit is not None:
        assert (seen.unit == MM[unit]) != bool(made.notes), made.notes


@pytest.mark.parametrize("lines", [None, "outlines", "blueprint"])
@pytest.mark.parametrize("ending", ["svg", "dxf"])
def test_no_wish_about_a_drawing_is_passed_over(ending, lines):
    if ending == "dxf":
        pytest.importorskip("ezdxf")

    def made(**wishes):
        handover = Handover(lines=lines, **wishes)
        return prepare_export(things(), f"a.{ending}", handover=handover).notes

    assert made() == ()
    assert made(unit="mm") == ()
    if not (ending == "dxf" and lines is None):
        assert "up is where" in made(up="y")[0]
    assert "level of detail" in made(levels=True)[0]
    assert "UVs" in made(uvs=True)[0]


@pytest.mark.parametrize("lines", [None, "outlines"])
def test_a_view_in_perspective_has_no_unit_and_says_so(lines):
    seen = Camera("perspective", (0.0, -200.0, 20.0), (0.0, 0.0, 20.0), (0.0, 0.0, 1.0))
    wanted = Handover(unit="cm", lines=lines)
    made = prepare_export(things(), "a.svg", camera=seen, handover=wanted)
    assert "pixels" in made.notes[0]
