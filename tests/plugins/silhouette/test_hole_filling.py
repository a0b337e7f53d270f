"""A larger outline around an earlier body: a hole that is told, and filled on demand."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Ink
from bozzetto.testing import Pen
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.solids.evaluate import tree_body
from bozzetto_silhouette.tools import DrawOutline
from bozzetto_silhouette.tools.hole_filling import fill
from tests.plugins.silhouette import bodies as b

PEN, TOOL, CONTEXT, MODELER = Pen(), DrawOutline(), Context(), Silhouette()
SMALL, LARGE = PEN.circle(600, 450, 60), PEN.circle(610, 455, 200)


def drawn(*strokes: Stroke) -> SilhouetteState:
    state = SilhouetteState()
    for stroke in strokes:
        state = TOOL.apply(state, Ink((stroke,), True), CONTEXT)
    return state


def halves(x: float, y: float, radius: float) -> tuple[Stroke, Stroke]:
    turn = np.linspace(0.0, np.pi, 40)
    return tuple(  # type: ignore[return-value]
        PEN.along([(x + radius * np.cos(a), y + radius * np.sin(a)) for a in turns])
        for turns in (turn, turn + np.pi)
    )


def test_it_is_told_and_the_drawing_stays_as_it_was_read() -> None:
    state = drawn(SMALL, LARGE)
    assert [outline_of(part).genus for part in state.parts] == [1]
    assert "Fill hole (Shift+F)" in MODELER.next_step(state, TOOL).sentence
    assert "fill" in [command.id for command in MODELER.commands()]


def test_filled_both_are_bodies_and_no_ink_is_lost() -> None:
    state = drawn(SMALL, LARGE)
    whole = fill(state, CONTEXT)
    assert [outline_of(part).genus for part in whole.parts] == [0, 0]
    assert [tuple(part.strokes) for part in whole.parts] == [(SMALL,), (LARGE,)]
    assert whole.selected == whole.parts[1].id
    assert len({part.name for part in whole.parts}) == 2
    alone = tree_body(drawn(LARGE), 48)
    body = tree_body(whole, 48)
    assert body is not None
    b.assert_sound(body)
    assert b.genus(body) == 0
    assert b.volume(body) == pytest.approx(b.volume(alone), rel=0.01)
    assert "Fill hole" not in MODELER.next_step(whole, TOOL).sentence


def test_a_hole_that_was_drawn_inside_is_no_question() -> None:
    state = drawn(LARGE, SMALL)
    assert [outline_of(part).genus for part in state.parts] == [1]
    assert "Fill hole" not in MODELER.next_step(state, TOOL).sentence
    with pytest.raises(UserError, match="not drawn around"):
        fill(state, CONTEXT)


def test_several_earlier_ones_and_outlines_of_several_strokes() -> None:
    other = PEN.circle(700, 450, 25)
    state = drawn(SMALL, other)
    state = TOOL.apply(state, Ink(halves(640.0, 450.0, 220.0), True), CONTEXT)
    assert [outline_of(part).genus for part in state.parts] == [2]
    whole = fill(state, CONTEXT)
    assert [len(outline_of(part).rings) for part in whole.parts] == [2, 1]
    assert [len(part.strokes) for part in whole.parts] == [2, 2]


def test_what_is_drawn_around_parts_that_overlap_each_other_is_a_part() -> None:
    neck, leg = PEN.circle(600, 380, 40), PEN.circle(640, 500, 30)
    before = drawn(SMALL, neck, leg)
    assert len(before.parts) == 3
    state = TOOL.apply(before, Ink((LARGE,), True), CONTEXT)
    assert state.parts[:3] == before.parts
    assert [outline_of(part).genus for part in state.parts] == [0, 0, 0, 0]
    assert tuple(state.parts[3].strokes) == (LARGE,)


def test_what_came_before_and_after_keeps_its_place() -> None:
    first, last = PEN.circle(200, 150, 50), PEN.circle(1000, 150, 50)
    state = drawn(first, SMALL, LARGE, last)
    assert "Fill hole" not in MODELER.next_step(state, TOOL).sentence  # the last one is chosen
    ringed = state.parts[1]
    whole = fill(state.with_node(ringed), CONTEXT)
    assert [tuple(part.strokes) for part in whole.parts] == [(first,), (SMALL,), (LARGE,), (last,)]
    assert [part.id for part in whole.parts if part.id in {p.id for p in state.parts}] == [
        part.id for part in state.parts
    ]


def test_nothing_chosen_says_what_is_missing() -> None:
    with pytest.raises(UserError, match="no hole to fill"):
        fill(SilhouetteState(), CONTEXT)
