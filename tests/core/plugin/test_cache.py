"""A memory for dear answers: asked from many threads, with failures, and forgetting."""

from __future__ import annotations

import threading
import time
import weakref

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.plugin import remembered
from bozzetto.plugin.cache import ALL, Memory, forget_all
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.memory_budget import MOST_BYTES, MemoryBudget
from bozzetto.plugin.memory_size import size_of
from bozzetto.workbench.workbench import Workbench


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


def array_of(size):
    return np.zeros(size, np.uint8)


def test_what_is_too_large_is_answered_and_not_kept():
    budget = MemoryBudget(100_000)
    memory = Memory(10, budget)
    small = memory.recall("small", lambda: array_of(10_000))
    assert memory.recall("large", lambda: array_of(100_000)).nbytes == 100_000
    assert memory.known("large") is None
    assert memory.known("small") is small  # it had not to go for what cannot stay


def test_the_oldest_of_all_memories_goes_first():
    budget = MemoryBudget(100_000)
    one, other = Memory(10, budget), Memory(10, budget)
    one.put("a", array_of(30_000))
    other.put("b", array_of(30_000))
    one.put("c", array_of(30_000))
    one.recall("a", lambda: pytest.fail("is remembered"))
    other.put("d", array_of(30_000))
    assert other.known("b") is None
    assert one.known("a") is not None
    assert one.known("c") is not None
    assert other.known("d") is not None


def test_what_goes_is_freed():
    budget = MemoryBudget(100_000)
    memory = Memory(10, budget)
    alive = []
    for question in range(50):
        answer = array_of(30_000)
        alive.append(weakref.ref(answer))
        memory.put(question, answer)
        del answer
    kept = [question for question in range(50) if memory.known(question) is not None]
    assert kept == [47, 48, 49]
    assert [question for question in range(50) if alive[question]() is not None] == kept


def test_an_answer_that_grows_is_measured_again():
    budget = MemoryBudget(100_000)
    memory = Memory(10, budget)
    answer = memory.recall("grows", lambda: [])
    answer.append(array_of(60_000))
    memory.recall("grows", lambda: pytest.fail("is remembered"))
    assert budget.held > 60_000
    answer.append(array_of(60_000))
    for _ in range(7):
        assert memory.recall("grows", lambda: pytest.fail("is remembered")) is answer
    assert memory.known("grows") is None
    assert budget.held == 0


def test_nothing_is_counted_for_what_was_replaced_or_went_by_number():
    budget = MemoryBudget(100_000)
    memory = Memory(2, budget)
    for question in ("a", "a", "b", "c"):
        memory.put(question, array_of(20_000))
    assert 40_000 <= budget.held < 42_000
    budget.forget_all()
    assert budget.held == 0
    assert memory.known("c") is None


def test_all_memories_share_one_budget_and_forget_together():
    one, other = Memory(4), Memory(4)
    one.put("a", 1)
    other.put("b", 2)
    forget_all()
    assert (one.known("a"), other.known("b"), ALL.held) == (None, None, 0)
    assert ALL.most == MOST_BYTES


def test_a_closed_documents_answers_are_forgotten():
    memory = Memory(4)
    memory.put("a", 1)
    Workbench(Registry()).forget_results()
    assert memory.known("a") is None


def test_without_room_answers_are_the_same_and_nobody_waits_for_ever():
    memory = Memory(4, MemoryBudget(0))
    assert (
        in_threads(6, lambda number: memory.recall("question", lambda: "answer")) == ["answer"] * 6
    )
    assert memory.known("question") is None


def test_who_asks_for_its_own_answer_is_told():
    memory = Memory(4)

    def work():
        return memory.recall("question", work)

    with pytest.raises(RuntimeError, match="asks for itself"):
        memory.recall("question", work)
    assert memory.recall("question", lambda: "answer") == "answer"


def test_many_threads_leave_the_count_right():
    budget = MemoryBudget(200_000)
    memories = [Memory(8, budget) for _ in range(3)]

    def run(number):
        chance = np.random.default_rng(number)
        for _ in range(400):
            memory, question = memories[chance.integers(3)], int(chance.integers(12))
            answer = memory.recall(question, lambda q=question: array_of(5_000 * (q + 1)))
            if answer.nbytes != 5_000 * (question + 1):
                raise ValueError(question)
            if chance.random() < 0.02:
                budget.forget_all()
        return budget.held <= 200_000

    assert in_threads(6, run) == [True] * 6

    def kept():
        known = (
            (question, memory.known(question)) for memory in memories for question in range(12)
        )
        return [(question, answer) for question, answer in known if answer is not None]

    assert kept()
    assert budget.held == sum(size_of(*one).total for one in kept())
    budget.forget_all()
    assert budget.held == 0
    assert not kept()


# -- functions that are remembered -------------------------------------------------------------


def counted(**options):
    """A function that tells how often it was asked, and what it was asked."""
    asked = []

    @remembered(**{"limit": 8} | options)
    def total(one, other=2, *, factor=1):
        """Return a sum."""
        asked.append((one, other, factor))
        return factor * (one + other)

    return total, asked


def test_the_same_question_is_answered_once_however_it_is_written():
    total, asked = counted()
    assert {total(1), total(1, 2), total(one=1), total(other=2, one=1), total(1, factor=1)} == {3}
    assert asked == [(1, 2, 1)]
    assert (total(1, 3), total(1, factor=2), total(1)) == (4, 6, 3)
    assert len(asked) == 3


def test_a_key_says_what_an_answer_depends_on():
    total, asked = counted(key=lambda one, other, factor: (len(one), factor))
    rows = ([1], [2]), ([3], [4, 5])
    assert [total(*row) for row in rows] == [[1, 2]] * 2
    assert total([6], factor=1, other=[7]) == [1, 2]
    assert total([6, 7], [8]) == [6, 7, 8]
    assert len(asked) == 2


def test_what_cannot_be_hashed_needs_a_key():
    total, asked = counted()
    with pytest.raises(TypeError, match="unhashable"):
        total([1], [2])
    assert not asked


def test_a_function_forgets_the_oldest_and_everything_with_the_host():
    total, asked = counted(limit=2)
    for one in (1, 2, 1, 3, 1, 2):
        total(one)
    assert [one for one, *_ in asked] == [1, 2, 3, 2]
    forget_all()
    assert total.known(1) is None
    assert total(1) == total.known(1) == total.known(one=1, other=2) == 3


def test_failures_are_not_remembered():
    tries = []

    @remembered(limit=4)
    def fails(number):
        tries.append(number)
        raise UserError("Not now.")

    for _ in range(2):
        with pytest.raises(UserError):
            fails(1)
    assert tries == [1, 1]
    assert fails.known(1) is None


def test_what_was_found_elsewhere_is_remembered():
    total, asked = counted()
    total.put(100, 1)
    assert (total(1), total(one=1), asked) == (100, 100, [])


def test_a_wrong_argument_fails_as_without_memory():
    total, asked = counted()
    for wrong in ({"three": 1}, {}):
        with pytest.raises(TypeError):
            total(**wrong)
    with pytest.raises(TypeError):
        total(1, 2, 3)
    assert not asked


def test_a_remembered_function_keeps_its_name_and_words():
    total, _ = counted()
    assert (total.__name__, total.__doc__) == ("total", "Return a sum.")
    assert total.__wrapped__(1) == 3


def test_functions_do_not_share_answers():
    one, other = counted()[0], counted()[0]
    one.put(100, 1)
    assert other(1) == 3
