"""Undo and redo; what they hold, and what an edit costs."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from bozzetto.document.edit import change_state
from bozzetto.document.history import STEP_BYTES, History
from bozzetto.document.model import Document, Model, OpaqueState
from bozzetto.document.shared_bytes import difference
from bozzetto.document.waiting_ink import WaitingStroke
from bozzetto.ink.stroke import Strokes
from bozzetto.view.camera import Camera
from tests.document_kit import (
    Ink,
    documents_of,
    full_stroke,
    rich_document,
    stroke,
    underlay,
    waiting_ink,
)


def documents(count: int) -> list[Document]:
    return [Document((Model(f"m{n}", f"Model {n}", "test.ink", Ink()),)) for n in range(count)]


def test_undo_and_redo_walk_the_snapshots():
    first, second, third = documents(3)
    history = History(first)
    history.apply("Two", second)
    history.apply("Three", third)
    assert history.entries == ("Start", "Two", "Three")
    assert (history.undo_label, history.redo_label) == ("Three", None)
    assert history.undo() is second
    assert history.undo() is first
    assert history.undo() is first
    assert (history.undo_label, history.redo_label) == (None, "Two")
    assert history.redo() is second
    assert history.redo() is third
    assert history.redo() is third
    assert history.go_to(0) is first
    assert history.go_to(99) is third
    assert history.go_to(-99) is first


def test_a_new_step_ends_what_could_be_redone():
    first, second, third = documents(3)
    history = History(first)
    history.apply("Two", second)
    history.undo()
    history.apply("Three", third)
    assert history.entries == ("Start", "Three")
    assert history.redo_label is None
    assert history.undo() is first


def test_the_drag_of_a_slider_is_one_step():
    start, *drag = documents(5)
    history = History(start)
    for document in drag:
        history.apply("Softness", document, "m/softness")
    assert history.entries == ("Start", "Softness")
    assert history.document is drag[-1]
    assert history.undo() is start
    assert history.redo() is drag[-1]


@pytest.mark.parametrize("between", ["end_merge", "mark_saved", "other", "unkeyed", "undo"])
def test_a_drag_ends(between):
    start, first, second, other = documents(4)
    history = History(start)
    history.apply("A", first, "a")
    if between == "end_merge":
        history.end_merge()
    elif between == "mark_saved":
        history.mark_saved()
    elif between == "other":
        history.apply("B", other, "b")
    elif between == "unkeyed":
        history.apply("B", other)
    else:
        history.undo()
        history.redo()
    history.apply("A", second, "a")
    assert history.document is second
    assert history.undo() is (other if between in ("other", "unkeyed") else first)


def test_a_drag_that_ends_where_it_began_is_no_step():
    first, second, third, fourth = documents(4)
    history = History(first)
    history.apply("Made", second)
    history.mark_saved()
    held = history.held_bytes
    for round_ in range(2):
        history.apply("Size", third, "size")
        assert history.before_merge("size") is second
        assert history.before_merge("other") is None
        history.apply("Size", fourth, "size")
        assert history.is_modified
        history.apply("Size", second, "size")
        assert (history.entries, history.document) == (("Start", "Made"), second), round_
        assert not history.is_modified
        assert history.held_bytes == held
        assert history.before_merge("size") is None
    history.apply("Size", third, "size")
    assert history.entries == ("Start", "Made", "Size")


def test_nothing_done_is_no_step():
    (first,) = documents(1)
    history = History(first)
    history.apply("Nothing", first)
    assert history.entries == ("Start",)
    assert not history.is_modified


def test_modified_means_different_from_the_file():
    first, second, third = documents(3)
    history = History(first)
    assert not history.is_modified
    history.apply("Two", second)
    assert history.is_modified
    history.undo()
    assert not history.is_modified
    history.redo()
    history.mark_saved()
    assert not history.is_modified
    history.undo()
    assert history.is_modified
    history.apply("Three", third)
    assert history.is_modified
    history.undo()
    assert history.is_modified  # the saved snapshot is gone for good


def test_a_save_in_another_thread_marks_what_it_wrote():
    first, second, third = documents(3)
    history = History(first)
    history.apply("Two", second)
    history.apply("Three", third)
    history.mark_saved(second)
    assert history.is_modified
    history.undo()
    assert not history.is_modified
    history.mark_saved(Document())  # forgotten meanwhile: nothing happens
    assert not history.is_modified


def ink_document(strokes: Strokes) -> Document:
    return Document((Model("ink", "Ink", "test.ink", Ink(strokes)),))


def test_the_history_is_bounded_by_bytes_and_keeps_the_present():
    size = stroke(count=10_000).nbytes
    history = History(ink_document(Strokes()), byte_limit=5 * size)
    for number in range(20):
        history.apply(f"Stroke {number}", ink_document(Strokes([stroke(number, 10_000)])))
    assert history.document.models[0].state.strokes[0] == stroke(19, 10_000)
    assert 3 <= len(history.entries) <= 6
    assert history.held_bytes <= 5 * size
    while history.position:
        history.undo()
    assert history.document.models[0].state.strokes[0] == stroke(20 - len(history.entries), 10_000)


def test_a_step_larger_than_the_bound_leaves_the_present_alone():
    history = History(ink_document(Strokes([stroke(count=1000)])), byte_limit=10)
    history.apply("Gone", ink_document(Strokes()))
    assert history.entries == ("Gone",)
    assert history.undo_label is None
    history.apply("Slide", ink_document(Strokes([stroke(1)])), "key")
    history.apply("Slide", ink_document(Strokes([stroke(2)])), "key")
    assert history.document.models[0].state.strokes[0] == stroke(2)


def test_adding_and_undoing_hold_the_bytes_of_the_stroke():
    drawn = stroke(count=5_000)
    history = History(ink_document(Strokes()))
    history.apply("Draw", ink_document(Strokes([drawn])))
    assert history.held_bytes < 2 * STEP_BYTES  # the present holds the stroke itself
    history.undo()
    assert history.held_bytes >= drawn.nbytes
    history.redo()
    assert history.held_bytes < 2 * STEP_BYTES


def test_difference_counts_what_is_not_shared():
    before = rich_document()
    assert difference(before, before) == (0, 0)
    body = before.model("m1")
    new = full_stroke(3, 100)
    after = before.with_model(
        replace(body, state=replace(body.state, strokes=body.state.strokes.extended([new])))
    )
    removed, added = difference(before, after)
    assert removed < 2000
    assert new.nbytes <= added < new.nbytes + 2000
    swapped = replace(before, underlays=(replace(underlay(), pixels=np.ones((50, 60, 4))),))
    removed, added = difference(before, swapped)
    assert added >= 50 * 60 * 4
    assert removed >= before.underlays[0].pixels.nbytes
    hidden = replace(before, underlays=(replace(before.underlays[0], visible=True),))
    assert sum(difference(before, hidden)) < 1000
    gone = before.without_model("m2")
    closed = before.model("m2").state
    assert isinstance(closed, OpaqueState)
    assert difference(before, gone)[0] >= closed.strokes[0].nbytes
    assert difference(before, gone)[1] < 1000


@pytest.mark.parametrize("spread", [False, True], ids=["one model", "a thousand models"])
def test_an_edit_of_a_large_document_costs_less_than_8_kilobytes(spread):
    """Beyond the new stroke itself; measured by the allocator, not by our own count."""
    ink = [stroke(n, 2) for n in range(5_000)]
    if spread:
        models = [
            Model(f"m{n}", f"{n}", "test.ink", Ink(Strokes(ink[n::1000]))) for n in range(1000)
        ]
    else:
        models = [Model("m0", "All", "test.ink", Ink(Strokes(ink)))]
    history = History(Document(models))
    new = [stroke(10_000 + n, 2) for n in range(200)]
    tracemalloc.start()
    start = tracemalloc.get_traced_memory()[0]
    for number, drawn in enumerate(new):
        model = history.document.models[number * 7 % len(models)]
        state = replace(model.state, strokes=model.state.strokes.extended([drawn]))
        edit = change_state(history.document, model.id, state, "Draw")
        history.apply(edit.label, edit.document)
    used = tracemalloc.get_traced_memory()[0] - start
    tracemalloc.stop()
    assert len(history.entries) == 201
    assert used / len(new) < 8_000


def test_a_snapshot_is_amended_without_a_step():
    first, second, third, other = (Document(camera=Camera(height=h)) for h in (1.0, 2.0, 3.0, 4.0))
    history = History(first)
    history.apply("a", second)
    history.apply("b", third)
    history.mark_saved()
    history.undo()
    history.amend(other)
    assert history.document is other
    assert history.entries == ("Start", "a", "b")
    assert history.redo() is third, "what was undone is still there"
    assert not history.is_modified
    assert history.undo() is other
    assert history.undo() is first


def test_what_is_chosen_is_no_unsaved_work():
    history = History(Document())
    history.amend(Document())
    assert not history.is_modified
    history.apply("a", Document())
    saving = history.document
    history.amend(Document())
    history.amend(Document())
    history.mark_saved(saving)
    assert not history.is_modified, "the save began before the choice and ended after it"


def test_an_amended_step_is_not_merged_with_the_next():
    history = History(Document())
    history.apply("slide", Document(), "slider")
    history.amend(Document())
    history.apply("slide", Document(), "slider")
    assert history.entries == ("Start", "slide", "slide")


# -- what was drawn, and what came of it ---------------------------------------------------------


def test_what_was_drawn_and_undone_stays_in_the_row_when_a_new_step_comes():
    start, drawn, tuned, other = documents(4)
    history = History(start)
    history.apply("Stroke", drawn, drawn=True)
    history.apply("Softness", tuned)
    history.go_to(0)
    history.mark_saved()
    history.apply("Other", other)
    assert history.entries == ("Start", "Stroke", "Softness", "Undo", "Other")
    assert history.document is other
    assert [history.undo() for _ in range(4)] == [start, tuned, drawn, start]
    assert not history.is_modified
    history.go_to(3)
    assert not history.is_modified  # the way back leads to what was saved


def test_a_merged_drag_after_undone_ink_is_one_step():
    start, drawn, first, second = documents(4)
    history = History(start)
    history.apply("Stroke", drawn, drawn=True)
    history.undo()
    history.apply("Softness", first, "key")
    history.apply("Softness", second, "key")
    assert history.entries == ("Start", "Stroke", "Undo", "Softness")
    assert history.document is second


def waiting(*numbers: int) -> tuple[WaitingStroke, ...]:
    return tuple(WAITING[number] for number in numbers)


WAITING = waiting_ink()


def test_an_outcome_takes_the_place_of_the_stroke_and_of_those_that_follow():
    start = Document()
    one, two = start.with_waiting(waiting(0)), start.with_waiting(waiting(0, 1))
    history = History(start)
    history.apply("Stroke", one, drawn=True)
    history.mark_saved()
    history.apply("Stroke", two, drawn=True)
    model = Model("m", "M", "test.ink", Ink())
    models = start.with_model(model).models

    def completed(document: Document) -> Document:
        return replace(document, models=models, waiting=document.waiting[1:])

    first = history.place_where(lambda d: any(w is WAITING[0] for w in d.waiting))
    assert first == 1
    history.complete(first, "Draw", completed)
    assert history.entries == ("Start", "Draw", "Stroke")
    assert (len(history.document), history.document.waiting) == (1, waiting(1))
    history.undo()
    assert (len(history.document), history.document.waiting) == (1, ())
    assert history.is_modified  # what was saved was the ink, not what came of it
    history.mark_saved(one)
    assert history.is_modified
    assert history.undo() is start


def test_a_revised_snapshot_still_counts_as_the_one_that_was_saved():
    start = Document()
    history = History(start)
    lifted = start.with_waiting(waiting(0))
    history.apply("Stroke", lifted, drawn=True)
    other = waiting(3)
    history.revise(lambda d: d.with_waiting(other) if d.waiting else d)
    assert history.document.waiting == other
    assert history.entries == ("Start", "Stroke")
    history.mark_saved(lifted)
    assert not history.is_modified


@pytest.mark.parametrize("seed", range(6))
def test_what_is_held_is_reckoned_the_same_however_snapshots_came_about(seed):
    rng = np.random.default_rng(seed)
    history = History(Document())
    for number in range(40):
        act = rng.integers(5)
        ink = tuple(WaitingStroke(stroke(number * 9 + k, 50)) for k in range(rng.integers(1, 4)))
        if act < 2:
            history.apply("Stroke", history.document.with_waiting(ink), drawn=bool(act))
        elif act == 2:
            history.go_to(int(rng.integers(len(history.entries))))
        elif act == 3:
            history.revise(lambda d, ink=ink: d.with_waiting(ink) if len(d.waiting) == 2 else d)
        elif history.position:
            history.complete(
                history.position, "Done", lambda d, ink=ink: d.with_waiting((*d.waiting, *ink))
            )
        held = 0
        for place, (one, other) in enumerate(pairwise(documents_of(history)), 1):
            pair = difference(one, other)
            held += STEP_BYTES + pair[0 if place <= history.position else 1]
        assert history.held_bytes == held
