"""Gestures on a product that follows another model: they mean what is seen, before and after."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto.document.model import Placement
from bozzetto.ink import distances_to_polyline
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing import Pen, Shell
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch
from tests.plugins.product.pen_strokes import FRONT

PEN = Pen(tremor=0.3, seed=2026).but(camera=FRONT)

CORNERS = ((470.0, 415.0), (730.0, 415.0), (730.0, 495.0), (470.0, 495.0))
"""Of an area that bulges towards the person, with sides that bow outward, px."""

BOWS = ((600.0, 385.0), (742.0, 455.0), (600.0, 530.0), (458.0, 455.0))
"""The middles of its sides, px."""

ASIDE = (0.0, 0.0, 25.0)
"""By which the followed model is moved, mm."""

FELT = 1.5
"""Distance from the ink, px, that no eye sees."""


@pytest.fixture
def shell(tmp_path: Path) -> Shell:
    """A product of four curves and a surface on a silhouette that is a lens."""
    made = Shell(Registry(), tmp_path)
    made.open("bozzetto.silhouette")
    made.camera = FRONT
    turn = np.linspace(0.0, 2.0 * np.pi, 120)
    lens = np.column_stack((600.0 + 220.0 * np.cos(turn), 455.0 + 120.0 * np.sin(turn)))
    made.draw(PEN.along([(float(x), float(y)) for x, y in lens]))
    made.use("bozzetto.product")
    for (a, b), bow in zip(itertools.pairwise((*CORNERS, CORNERS[0])), BOWS, strict=True):
        made.draw(PEN.along([a, bow, b]), tool="draw")
    assert len(made.state.of_kind(Curve)) == 4
    assert len(made.state.of_kind(Patch)) == 1
    return made


def moved_aside(shell: Shell) -> None:
    """Move what the product follows."""
    source = next(model for model in shell.document if model.id != shell.model.id)
    shell.history.apply(
        "move", shell.document.with_model(replace(source, placement=Placement(offset=ASIDE)))
    )
    shell.solve()


def as_seen(shell: Shell, name: str) -> np.ndarray:
    (curve,) = (one for one in shell.solve().curves if one.name == name)
    return np.asarray(FRONT.project(curve.spline.sampled(40))[0])


@pytest.mark.parametrize("move", [False, True])
@pytest.mark.parametrize("at", [(670.0, 470.0), (540.0, 440.0)])
def test_a_detail_lies_where_it_was_drawn(
    shell: Shell, at: tuple[float, float], move: bool
) -> None:
    lift = 0.0
    if move:
        before = as_seen(shell, "Curve 1").mean(axis=0)
        moved_aside(shell)
        lift = float((as_seen(shell, "Curve 1").mean(axis=0) - before)[1])
        assert abs(lift) > 20.0
    ring = PEN.circle(at[0], at[1] + lift, 18.0)
    shell.draw(ring, tool="detail")
    (one,) = shell.solve().detailed.details
    assert one.problem == ""
    seen = FRONT.project(one.outlines[0])[0]
    assert distances_to_polyline(seen, np.asarray(ring.points, float)).max() < FELT


def test_a_text_stands_upright_on_the_sheet(shell: Shell) -> None:
    shell.tap(600.0, 455.0, tool="text")
    (one,) = shell.solve().detailed.details
    seen = np.concatenate([FRONT.project(outline)[0] for outline in one.outlines])
    width, height = np.ptp(seen, axis=0)
    assert width > 1.5 * height
    assert np.abs(seen.mean(axis=0) - (600.0, 455.0)).max() < 0.25 * width


def test_the_eraser_means_a_curve_where_it_has_gone(shell: Shell) -> None:
    moved_aside(shell)
    shell.draw(
        PEN.along([(float(x), float(y)) for x, y in as_seen(shell, "Curve 1")]), tool="erase"
    )
    assert [curve.name for curve in shell.state.of_kind(Curve)] == ["Curve 2", "Curve 3", "Curve 4"]


def test_a_new_curve_meets_one_that_has_gone_elsewhere(shell: Shell) -> None:
    moved_aside(shell)
    top, bottom = as_seen(shell, "Curve 1"), as_seen(shell, "Curve 3")
    ends = (top[len(top) // 2], bottom[len(bottom) // 2])
    shell.draw(PEN.along([(float(x), float(y)) for x, y in ends]), tool="draw")
    assert len(shell.state.joints) == 6
    assert len(shell.solve().filled) == 2


def test_what_a_gesture_did_not_touch_goes_on_following(shell: Shell) -> None:
    """Moved, changed, and moved back: all curves are where they were but the one that went."""
    before = {name: as_seen(shell, name) for name in ("Curve 2", "Curve 4")}
    moved_aside(shell)
    shell.draw(
        PEN.along([(float(x), float(y)) for x, y in as_seen(shell, "Curve 1")]), tool="erase"
    )
    source = next(model for model in shell.document if model.id != shell.model.id)
    shell.history.apply("move", shell.document.with_model(replace(source, placement=Placement())))
    for name, line in before.items():
        assert np.abs(as_seen(shell, name) - line).max() < 0.05


def test_commands_act_on_curves_where_they_have_gone(shell: Shell) -> None:
    moved_aside(shell)
    line = as_seen(shell, "Curve 1")
    (curve,) = (one for one in shell.state.of_kind(Curve) if one.name == "Curve 1")
    shell.put(replace(shell.state, selected=curve.id))
    shell.run("straighten")
    assert np.abs(as_seen(shell, "Curve 1")[[0, -1]] - line[[0, -1]]).max() < 0.5
