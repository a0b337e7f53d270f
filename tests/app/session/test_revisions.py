"""What is shown never goes back, ends with the last value, and never starves."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from hypothesis import example, given, settings
from hypothesis import strategies as st

from bozzetto.document.model import Model
from bozzetto_app.session.revisions import MOST_AHEAD, Revisions, Stage, Task


class Value:
    """A state that knows its number."""

    def __init__(self, number: int) -> None:
        self.number = number


def model(name: str, number: int) -> Model:
    return Model(name, name, "any.modeler", Value(number))


class Bench:
    """A worker and a window around the rules, without threads: every turn is a step.

    Answers travel through a row, as from one thread to another, and are taken in order.
    """

    def __init__(self) -> None:
        self.rules = Revisions()
        self.models: dict[str, Model] = {}
        self.working: tuple[Task, int] | None = None
        self.underway: list[Task] = []
        self.shown: dict[str, list[tuple[int, Stage]]] = {}
        self.number = 0
        self.abandoned: list[Task] = []
        self.dragging = False

    def ask(self, name: str, *, dragging: bool = False) -> None:
        self.number += 1
        self.models[name] = model(name, self.number)
        self.tell(dragging=dragging)

    def tell(self, *, dragging: bool = False) -> None:
        self.dragging = dragging
        if self.rules.ask(self.models.values(), "a", dragging=dragging):
            assert self.working is not None
            self.abandoned.append(self.working[0])
            self.working = None

    def work(self, cost: int = 1) -> None:
        """One step of the worker, which needs `cost` of them for a task."""
        if self.working is None:
            task = self.rules.next()
            if task is None:
                return
            self.working = task, cost
        task, left = self.working
        if left > 1:
            self.working = task, left - 1
            return
        self.working = None
        self.rules.made(task)
        self.underway.append(task)

    def take(self) -> bool:
        """One step of the window; whether something else is on the sheet."""
        if not self.underway:
            return False
        task = self.underway.pop(0)
        if not self.rules.show(task):
            return False
        row = self.shown.setdefault(task.model.id, [])
        row.append((task.model.state.number, task.stage))
        return True

    def settle(self) -> None:
        self.rules.let_go()
        for _ in range(1000):
            self.work()
            self.take()
        assert self.working is None
        assert not self.underway


STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("ask"), st.sampled_from("abc")),
        st.tuples(st.just("drag"), st.sampled_from("abc")),
        st.tuples(st.just("work"), st.integers(1, 4)),
        st.tuples(st.just("take"), st.just(0)),
        st.tuples(st.just("drop"), st.sampled_from("abc")),
        st.tuples(st.just("rest"), st.just(0)),
        st.tuples(st.just("undo"), st.sampled_from("abc")),
    ),
    max_size=80,
)


def play(steps: list[tuple[str, Any]]) -> Bench:
    bench = Bench()
    earlier: dict[str, Model] = {}
    for what, which in steps:
        if what in ("ask", "drag"):
            if which in bench.models:
                earlier[which] = bench.models[which]
            bench.ask(which, dragging=what == "drag")
        elif what == "work":
            bench.work(which)
        elif what == "take":
            bench.take()
        elif what == "rest":
            bench.rules.let_go()
        elif what == "drop":
            bench.models.pop(which, None)
            bench.tell()
        elif which in earlier and which in bench.models:
            bench.number += 1
            # What was taken back is another model, with a state that counts as new.
            bench.models[which] = replace(earlier[which], state=Value(bench.number))
            bench.tell()
    return bench


@given(STEPS)
@settings(max_examples=300, deadline=None)
def test_the_last_value_is_shown_last_and_nothing_older_after_newer(steps):
    bench = play(steps)
    bench.settle()
    for name, row in bench.shown.items():
        assert row == sorted(row), name
    for name, last in bench.models.items():
        number, stage = bench.shown[name][-1]
        assert number == last.state.number
        assert stage is (Stage.REPORT if name == "a" else Stage.FINAL)


@given(st.integers(1, 12), st.integers(1, 4), st.integers(60, 200))
@settings(max_examples=60, deadline=None)
def test_a_drag_shows_a_frame_for_each_preview_that_the_worker_can_make(cost, others, ticks):
    bench = Bench()
    for name in "abcd"[:others]:
        bench.ask(name)
    bench.settle()
    before = len(bench.shown["a"])
    for _ in range(ticks):
        bench.ask("a", dragging=True)
        bench.work(cost)
        bench.take()
    assert len(bench.shown["a"]) - before >= ticks // cost - 1
    assert not bench.abandoned
    bench.settle()
    assert bench.shown["a"][-1][0] == bench.number


def test_a_final_of_an_outdated_state_is_abandoned_and_a_preview_is_not():
    bench = Bench()
    bench.ask("a")
    bench.work(3)
    bench.ask("a")
    assert bench.abandoned == []
    bench.work()
    bench.work()
    bench.work()  # the preview of the second
    bench.work(3)
    (final,) = [bench.working[0]]
    assert final.stage is Stage.FINAL
    bench.ask("a")
    assert bench.abandoned == [final]


def test_no_final_is_begun_while_a_drag_goes_on():
    bench = Bench()
    bench.ask("a", dragging=True)
    bench.work()
    assert bench.rules.next() is None
    assert bench.rules.let_go()
    assert bench.rules.next().stage is Stage.FINAL


def test_a_model_without_a_picture_goes_before_a_slow_preview_of_another():
    bench = Bench()
    bench.ask("a")
    bench.settle()
    bench.ask("a")
    bench.work(100)
    bench.ask("b")
    (given_up,) = bench.abandoned
    assert given_up.model.id == "a"
    assert bench.rules.next().model.id == "b"


def test_a_drag_of_one_model_does_not_starve_another():
    bench = Bench()
    for name in "abc":
        bench.ask(name)
    bench.settle()
    bench.ask("b")
    for _ in range(4):
        bench.ask("a", dragging=True)
        bench.work()
        bench.take()
    assert bench.shown["b"][-1][0] == bench.models["b"].state.number


def test_what_has_no_solution_is_not_tried_again_until_it_is_another():
    bench = Bench()
    bench.ask("a")
    task = bench.rules.next()
    bench.rules.give_up(task.model)
    assert bench.rules.next() is None
    bench.models["a"] = replace(bench.models["a"], name="another name")
    bench.tell()
    assert bench.rules.next() is None
    bench.ask("a")
    assert bench.rules.next() is not None


def test_figures_are_told_again_when_a_model_is_chosen_again():
    bench = Bench()
    bench.ask("a")
    bench.settle()
    bench.rules.ask(bench.models.values(), "")
    assert bench.rules.next() is None
    bench.rules.ask(bench.models.values(), "a")
    task = bench.rules.next()
    assert task.stage is Stage.REPORT
    bench.rules.made(task)
    assert bench.rules.show(task)


def test_answers_of_a_document_that_was_left_are_not_shown():
    bench = Bench()
    bench.ask("a")
    bench.work()
    bench.rules.forget()
    bench.models.clear()
    assert not bench.take()
    bench.ask("a")
    bench.settle()
    assert bench.shown["a"][-1][0] == bench.number


class Painter:
    """A viewport that paints one scene at a time, and then the newest that it was given."""

    def __init__(self) -> None:
        self.given = self.begun = self.done = 0

    def begin(self) -> None:
        if self.begun == self.done:
            self.begun = self.given

    def end(self) -> int:
        """What is told when a frame is painted: how many newer scenes there are."""
        self.done = self.begun
        return self.given - self.done


@given(st.lists(st.sampled_from(["value", "work", "take", "begin", "end"]), max_size=100))
@example(["value", "work", "work", "take", "begin"] * 3)
def test_in_a_drag_one_preview_is_made_while_the_last_is_painted_and_no_more(acts):
    bench, painter = Bench(), Painter()
    bench.rules.expect_paint(True)
    bench.ask("a")
    bench.settle()
    made = 0
    for act in acts:
        if act == "value":
            bench.ask("a", dragging=True)
        elif act == "take":
            painter.given += bench.take()
        elif act == "begin":
            painter.begin()
        elif act == "end":
            bench.rules.painted(painter.end())
        else:
            unpainted = made - painter.done
            was_idle, before = bench.working is None, len(bench.underway)
            bench.work(cost=2)
            if was_idle and bench.working is not None:
                assert unpainted < MOST_AHEAD, "nobody would see it for long"
            made += len(bench.underway) - before
    # In whatever state this stopped: once all is painted, the newest value is worked on.
    bench.ask("a", dragging=True)
    for _ in range(4):
        bench.work()
        painter.given += bench.take()
        painter.begin()
        bench.rules.painted(painter.end())
    assert bench.shown["a"][-1][0] == bench.number
    bench.rules.let_go()
    bench.tell()
    bench.settle()
    assert bench.shown["a"][-1][0] == bench.number, "the last value is shown all the same"


def test_a_preview_is_made_while_the_one_before_is_painted():
    bench = Bench()
    bench.rules.expect_paint(True)
    for _ in range(MOST_AHEAD):
        bench.ask("a", dragging=True)
        bench.work()
        assert bench.take()
    bench.ask("a", dragging=True)
    assert bench.rules.next() is None
    assert not bench.rules.painted(MOST_AHEAD), "a frame of what was shown before"
    assert bench.rules.next() is None
    assert bench.rules.painted(1), "the older of both is on the screen"
    assert bench.rules.next() is not None


def test_a_model_without_a_picture_waits_for_no_paint():
    bench = Bench()
    bench.rules.expect_paint(True)
    bench.ask("a", dragging=True)
    bench.work()
    bench.ask("a", dragging=True)
    bench.work()
    bench.ask("b", dragging=True)
    bench.ask("a", dragging=True)
    task = bench.rules.next()
    assert task is not None
    assert task.model.id == "b"
