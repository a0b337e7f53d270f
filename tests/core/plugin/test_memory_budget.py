"""The budget: never above its bound, the least recently used first, shared parts counted once."""

from __future__ import annotations

import hypothesis.strategies as st
from hypothesis import given

from bozzetto.plugin.memory_budget import Entry, MemoryBudget
from bozzetto.plugin.memory_size import Size

MOST = 1000
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


@given(STEPS, st.integers(0, 1500))
def test_it_is_a_list_by_age_that_is_cut_at_the_bound(steps, last_bound):
    """Against a plain list, oldest first, that is added up anew at each step."""
    budget, model, made = MemoryBudget(MOST), [], []

    def cut(bound):
        while taken(model) > bound:
            model.pop(0)

    for step, number, size in steps:
        entry = made[number % len(made)] if made else None
        if step == "keep" or entry is None:
            entry = LevelCache(size)
            made.append(entry)
            budget.keep(entry)
            if size.total <= MOST:
                model.append(entry)
                cut(MOST)
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
                cut(MOST)
        assert [entry for entry in made if not entry.dropped] == [
            entry for entry in made if entry in model
        ]
        assert budget.held == taken(model) <= MOST
    # The bound goes down by steps: what goes at each tells the order by age.
    for bound in range(MOST, last_bound, -50):
        budget.limit_to(bound)
        cut(bound)
        assert all((entry in model) is not entry.dropped for entry in made)
    budget.limit_to(last_bound)
    cut(last_bound)
    assert budget.held == taken(model) <= last_bound
    before = [entry.forgotten for entry in model]
    budget.forget_all()
    assert not any(before)
    assert all(entry.forgotten for entry in model)
    assert budget.held == 0
    budget.limit_to(10 * MOST)
    for _, size in PARTS:  # nothing is held of the parts of those that are forgotten
        entry = LevelCache(Size(tuple(PARTS[:1]), size))
        budget.keep(entry)
    assert budget.held == PARTS[0][1] + sum(size for _, size in PARTS)


def test_what_was_dropped_before_it_was_kept_stays_away():
    budget, entry = MemoryBudget(MOST), LevelCache(Size((), 10))
    budget.drop([entry])
    budget.keep(entry)
    assert (budget.held, entry.forgotten) == (0, False)
