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
from bozzetto_product.model.rough_shapes import FollowedShape
from tests.plugins.polyhedron.drawn_bodies import VIEW, strokes_of
from tests.plugins.product.pen_strokes import FRONT, draw_along, straight

PEN = Pen(tremor=0.3, seed=2026).but(camera=FRONT)

CORNERS = ((470.0, 415.0), (730.0, 415.0), (730.0, 495.0), (470.0, 495.0))
"""Of an area that bulges towards the person, with sides that bow outward, px."""

BOWS = ((600.0, 385.0), (742.0, 455.0), (600.0, 530.0), (458.0, 455.0))
"""The middles of its sides, px."""

ASIDE = (0.0, 0.0, 25.0)
"""By which the followed model is moved, mm."""

FELT = 1.5
"""Distance from the ink, px, that no eye sees."""

ROUNDED = 9.0
"""Distance, px, by which seven control points round the corners of a drawn quadrangle."""


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


def begun_on_silhouette(shell: Shell) -> Shell:
    """An empty product beside a silhouette, as whoever takes the modeler has it."""
    shell.open("bozzetto.silhouette")
    shell.camera = FRONT
    shell.draw(PEN.circle(600.0, 455.0, 150.0))
    shell.open("bozzetto.product")
    return shell


def test_the_first_curve_on_another_object_makes_the_product_follow_it(tmp_path: Path) -> None:
    made = begun_on_silhouette(Shell(Registry(), tmp_path))
    source = next(model for model in made.document if model.id != made.model.id)
    made.draw(PEN.along([(530.0, 440.0), (600.0, 420.0), (670.0, 440.0)]), tool="draw")
    assert [part.source for part in made.state.of_kind(FollowedShape)] == [source.id]
    assert made.model.followed == (source.id,)
    made.draw(PEN.along([(530.0, 480.0), (600.0, 500.0), (670.0, 480.0)]), tool="draw")
    assert len(made.state.of_kind(FollowedShape)) == 1
    before = [as_seen(made, name).mean(axis=0) for name in ("Curve 1", "Curve 2")]
    moved_aside(made)
    after = [as_seen(made, name).mean(axis=0) for name in ("Curve 1", "Curve 2")]
    assert all(below[1] - above[1] > 20.0 for below, above in zip(before, after, strict=True))
    assert made.undo()
    assert made.undo()
    assert made.undo()
    assert made.model.followed == ()


@pytest.mark.parametrize("axis", range(3))
def test_a_first_curve_on_a_drawn_box_lies_under_its_ink(tmp_path: Path, axis: int) -> None:
    """A box is handed over with as many triangles as it is shown with, in another order."""
    made = Shell(Registry(), tmp_path)
    made.open("bozzetto.polyhedron")
    made.camera = VIEW
    half = np.array((60.0, 40.0, 30.0))
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    ends = list(itertools.combinations(range(8), 2))
    edges = [pair for pair in ends if np.abs(np.subtract(*signs[list(pair)])).sum() == 2.0]
    middle = np.array((0.0, 0.0, 40.0))
    for stroke in strokes_of(middle + half * signs, np.array(edges)):
        made.draw(stroke)
    made.solve()
    made.open("bozzetto.product")
    ring = np.zeros((5, 3))
    ring[:, axis] = (1.0, -1.0, 1.0)[axis]  # the faces that are seen
    for other, row in zip(
        [k for k in range(3) if k != axis], np.array(((-1, 1, 1, -1, -1), (-1, -1, 1, 1, -1))),
        strict=True,
    ):  # fmt: skip
        ring[:, other] = 0.6 * row
    drawn = VIEW.project(middle + half * ring)[0]
    pen = PEN.but(camera=VIEW)
    made.draw(pen.along([(float(x), float(y)) for x, y in densified(drawn)]), tool="draw")
    assert made.model.followed
    (curve,) = made.solve().curves
    seen = VIEW.project(curve.spline.sampled(200))[0]
    assert distances_to_polyline(seen, drawn).max() < ROUNDED
    assert distances_to_polyline(densified(drawn), seen).max() < 2.0 * ROUNDED


def densified(line: np.ndarray) -> np.ndarray:
    """Return a polyline with eight places on each side."""
    share = np.linspace(0.0, 1.0, 8, endpoint=False)[:, None]
    sides = [a + share * (b - a) for a, b in itertools.pairwise(line)]
    return np.vstack((*sides, line[-1:]))


def test_a_curve_beside_all_objects_follows_none(tmp_path: Path) -> None:
    made = begun_on_silhouette(Shell(Registry(), tmp_path))
    made.draw(PEN.along([(100.0, 120.0), (180.0, 140.0), (260.0, 120.0)]), tool="draw")
    assert made.model.followed == ()
    assert not made.state.of_kind(FollowedShape)


def test_a_product_begun_on_the_rough_shape_of_another_one_follows_nothing(tmp_path: Path) -> None:
    made = Shell(Registry(), tmp_path)
    made.open("bozzetto.product")
    draw_along(made, PEN, straight((-20.0, -10.0, 60.0), (20.0, -10.0, 60.0)))
    made.open("bozzetto.product")
    draw_along(made, PEN, straight((-20.0, 10.0, 60.0), (20.0, 10.0, 60.0)))
    assert made.model.followed == ()


def test_who_hides_what_a_product_was_drawn_on_is_told_where_curves_lie_now(shell: Shell) -> None:
    shell.put(replace(shell.state, selected=""))
    (draw, *_) = shell.tools()
    before = shell.workbench.next_step(shell.model, draw).sentence
    shell.run("hide-rough")
    after = shell.workbench.next_step(shell.model, draw).sentence
    assert after != before
    assert "on the surfaces now" in after
    shell.run("hide-rough")
    assert shell.workbench.next_step(shell.model, draw).sentence == before
