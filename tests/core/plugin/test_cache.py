"""A memory for dear answers: asked from many threads, with failures, and forgetting."""

from __future__ import annotations

import threading
import time

import pytest

from bozzetto.plugin import Memory


def in_threads(count, ask):
    """What each of some threads got, or what it failed with."""
    got = [None] * count

    def run(number):
        try:
            got[number] = ask(number)
        except ValueError as problem:
            got[number] = problem

    threads = [threading.Thread(target=run, args=(number,)) for number in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10.0)
        assert not thread.is_alive()
    return got


def test_a_question_asked_by_many_at_once_is_worked_on_once():
    memory, worked = Memory(4), []

    def work():
        worked.append(1)
        time.sleep(0.05)
        return "answer"

    assert in_threads(8, lambda number: memory.recall("question", work)) == ["answer"] * 8
    assert len(worked) == 1


def test_other_questions_do_not_wait():
    memory, gate = Memory(4), threading.Event()

    def slow():
        assert gate.wait(5.0)
        return "slow"

    def ask(number):
        if number == 0:
            return memory.recall("slow", slow)
        answer = memory.recall("quick", lambda: "quick")
        gate.set()
        return answer

    assert in_threads(2, ask) == ["slow", "quick"]


def test_who_waited_for_one_that_failed_works_itself():
    memory, begun = Memory(4), []

    def work():
        begun.append(1)
        time.sleep(0.03)
        if len(begun) == 1:
            raise ValueError("once")
        return "answer"

    got = in_threads(4, lambda number: memory.recall("question", work))
    assert sum(isinstance(one, ValueError) for one in got) == 1
    assert got.count("answer") == 3
    assert len(begun) == 2


def test_questions_within_a_question():
    memory = Memory(4)
    assert memory.recall("outer", lambda: memory.recall("inner", lambda: 1) + 1) == 2
    assert memory.known("inner") == 1


def test_what_was_asked_last_is_kept():
    memory = Memory(2)
    for question in ("a", "b", "a", "c"):
        memory.recall(question, lambda question=question: question)
    assert (memory.known("a"), memory.known("b"), memory.known("c")) == ("a", None, "c")


@pytest.mark.parametrize("size", [5, 50])
def test_what_is_too_large_is_answered_and_not_kept(size):
    memory = Memory(10, weight=lambda answer: size, most=20)
    for question in range(6):
        assert memory.recall(question, lambda question=question: question) == question
    kept = [question for question in range(6) if memory.known(question) is not None]
    assert len(kept) == 20 // size
