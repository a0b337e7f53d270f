"""The budget: never above its bound, of the least recent the largest first, shared parts once."""

from __future__ import annotations

import hypothesis.strategies as st
import pytest
from hypothesis import example, given

from bozzetto.plugin import memory_budget
from bozzetto.plugin.memory_budget import Entry, MemoryBudget
from bozzetto.plugin.memory_size import Size

MOST, OLDEST = 1000, 4
PARTS = [(object(), size) for size in (100, 250, 400, 700, 1200)]


class LevelCache(Entry):
    """An entry that notes that it was forgotten."""

    __slots__ = ("forgotten",)

    def __init__(self, size):
        super().__init__(size)
        self.forgotten = False

    def forget(self):
        self.forgotten = True


SIZES = st.builds(
    lambda parts, small: Size(tuple(parts), small),
    st.lists(st.sampled_from(PARTS), unique_by=id, max_size=3),
    st.integers(0, 1300),
)
STEPS = st.lists(
    st.tuples(st.sampled_from(["keep", "use", "drop", "resize"]), st.integers(0, 30), SIZES),
    max_size=40,
)


def taken(entries):
    """What entries take together, by adding up."""
    parts = {id(thing): count for entry in entries for thing, count in entry.size.large}
    return sum(parts.values()) + sum(entry.size.small for entry in entries)


def cut(entries, bound):
    """Let that of the oldest go without which least is taken, until the others fit."""
    while taken(entries) > bound:
        without = [taken([*entries[:k], *entries[k + 1 :]]) for k in range(len(entries[:OLDEST]))]
        entries.pop(without.index(min(without)))


@pytest.fixture(autouse=True)
def few_oldest(monkeypatch):
    """So few that a run of forty steps has more."""
    monkeypatch.setattr(memory_budget, "OLDEST", OLDEST)


def taken_steps(steps):
    """A budget after some steps, all entries, and a plain list of those that it keeps.

    The list has the oldest first and is added up anew at each step.
    """
    budget, model, made = MemoryBudget(MOST), [], []
    for step, number, size in steps:
        entry = made[number % len(made)] if made else None
        if step == "keep" or entry is None:
            entry = LevelCache(size)
            made.append(entry)
            budget.keep(entry)
            if size.total <= MOST:
                model.append(entry)
                cut(model, MOST)
        elif step == "use":
            budget.use(entry)
            if entry in model:
                model.append(model.pop(model.index(entry)))
        elif step == "drop":
            budget.drop([entry])
            model[:] = [one for one in model if one is not entry]
        else:
            budget.resize(entry, size)
            if entry in model and size.total > MOST:
                model.remove(entry)
            elif entry in model:
                cut(model, MOST)
        assert all(one.dropped is not (one in model) for one in made)
        assert budget.held == taken(model) <= MOST
    return budget, made, model


@given(STEPS, st.integers(0, 1500))
def test_what_does_not_fit_goes_and_all_is_counted(steps, last_bound):
    budget, _, model = taken_steps(steps)
    budget.limit_to(last_bound)
    cut(model, last_bound)
    assert budget.held == taken(model) <= last_bound
    before = [entry.forgotten for entry in model]
    budget.forget_all()
    assert not any(before)
    assert all(entry.forgotten for entry in model)
    assert budget.held == 0
    budget.limit_to(10 * MOST)
    for _, size in PARTS:  # nothing is held of the parts of those that are forgotten
        budget.keep(LevelCache(Size(tuple(PARTS[:1]), size)))
    assert budget.held == PARTS[0][1] + sum(size for _, size in PARTS)


@given(STEPS)
@example([("keep", 0, Size((), 9)), ("keep", 0, Size((), 9)), ("use", 0, Size((), 9))])
def test_of_those_not_used_for_longest_the_one_goes_first_that_makes_most_room(steps):
    budget, made, model = taken_steps(steps)
    for bound in range(MOST, -1, -5):
        budget.limit_to(bound)
        cut(model, bound)
        assert all(one.dropped is not (one in model) for one in made)


def test_what_was_dropped_before_it_was_kept_stays_away():
    budget, entry = MemoryBudget(MOST), LevelCache(Size((), 10))
    budget.drop([entry])
    budget.keep(entry)
    assert (budget.held, entry.forgotten) == (0, False)
