"""A model that came of waiting ink takes its place in the history."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bozzetto.document.applied_ink import take
from bozzetto.document.history import History
from bozzetto.document.model import Document, Model
from bozzetto.document.waiting_ink import WaitingStroke, marked, strokes_of
from bozzetto.ink.stroke import Strokes
from tests.document_kit import Ink, documents_of, stroke


def lifted(count):
    """A history in which some strokes were lifted, one after the other."""
    history, waiting = History(Document()), ()
    for number in range(count):
        waiting = (*waiting, WaitingStroke(stroke(number), "test.ink", "draw"))
        history.apply("Stroke", history.document.with_waiting(waiting), drawn=True)
    return history, strokes_of(waiting)


def model_of(*strokes, name="m"):
    return Model(name, name, "test.ink", Ink(Strokes(strokes)))


def row(history):
    """For every step its label, the strokes of its models, and how many wait."""
    return [
        (label, [len(m.state.strokes) for m in document], len(document.waiting))
        for label, document in zip(history.entries, documents_of(history), strict=True)
    ]


def test_strokes_that_are_taken_in_turn_are_as_many_steps_as_strokes():
    history, strokes = lifted(3)
    for number in range(3):
        take(history, "Draw", model_of(*strokes[: number + 1]), strokes[number : number + 1])
    assert row(history) == [("Start", [], 0), ("Draw", [1], 0), ("Draw", [2], 0), ("Draw", [3], 0)]
    assert history.position == 3


def test_a_later_stroke_that_is_undone_waits_where_redo_brings_it_back():
    history, strokes = lifted(2)
    history.undo()
    take(history, "Draw", model_of(strokes[0]), strokes[:1])
    assert row(history) == [("Start", [], 0), ("Draw", [1], 0), ("Stroke", [1], 1)]
    assert history.redo().waiting[0].stroke is strokes[1]


def test_ink_of_several_strokes_is_taken_in_the_step_of_the_last():
    history, strokes = lifted(2)
    take(history, "Draw", model_of(*strokes), strokes)
    assert row(history) == [("Start", [], 0), ("Stroke", [], 1), ("Draw", [2], 0)]


@pytest.mark.parametrize("status", ["unfinished", "refused", "failed"])
def test_ink_that_had_an_answer_is_taken_in_a_step_of_its_own(status):
    history, strokes = lifted(1)
    history.revise(
        lambda d: d.with_waiting(marked(d.waiting, strokes, status, modeler="m", tool="t"))
    )
    take(history, "Draw", model_of(*strokes), strokes)
    assert row(history) == [("Start", [], 0), ("Stroke", [], 1), ("Draw", [1], 0)]


def test_shapes_that_changed_meanwhile_are_not_changed_in_the_past():
    history, strokes = lifted(1)
    other = model_of(name="other")
    history.apply("Add", history.document.with_model(other))
    take(history, "Draw", model_of(*strokes), strokes)
    assert row(history) == [
        ("Start", [], 0),
        ("Stroke", [], 1),
        ("Add", [0], 1),
        ("Draw", [0, 1], 0),
    ]


def test_what_uses_no_ink_is_a_step_and_can_be_forgotten():
    history, strokes = lifted(1)
    take(history, "Import", model_of())
    assert row(history)[-1] == ("Import", [0], 1)
    history.undo()
    history.apply("Other", replace(history.document, views=()))
    assert [label for label, _, _ in row(history)] == ["Start", "Stroke", "Other"]
    assert history.document.waiting[0].stroke is strokes[0]
