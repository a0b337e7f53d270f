"""Sizes of answers: arrays wherever they hide, once, and an end to every walk."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import pytest

from bozzetto.plugin.memory_size import MOST_OBJECTS, size_of

ARRAY = np.zeros(100_000)


@dataclass(frozen=True, eq=False)
class Answer:
    array: object

    @cached_property
    def derived(self):
        return np.ones(50_000)


@dataclass(frozen=True, slots=True)
class Slotted:
    array: object


class Native:
    def __sizeof__(self):
        return 123_456


@pytest.mark.parametrize(
    "wrap",
    [
        lambda array: array,
        lambda array: (1, (array, "x"), array),
        lambda array: {"a": [array]},
        lambda array: {1: {2: array[::2]}, 3: array[5:]},
        Answer,
        Slotted,
        lambda array: partial(print, array),
        lambda array: Answer(Slotted((array, array.reshape(10, -1)))),
    ],
)
def test_an_array_counts_once_and_wholly_wherever_it_is(wrap):
    size = size_of(wrap(ARRAY))
    assert [id(thing) for thing, _ in size.large] == [id(ARRAY)]
    assert ARRAY.nbytes <= size.total < ARRAY.nbytes + 4096


def test_what_was_worked_out_later_counts_when_measured_again():
    answer = Answer(None)
    before = size_of(answer).total
    assert size_of(answer, answer.derived).total >= before + 400_000
    assert size_of(answer).total >= before + 400_000


def test_what_a_native_library_holds_counts_as_its_class_says():
    assert size_of([Native()]).total >= 123_456


def test_circles_and_long_rows_come_to_an_end():
    circle = [ARRAY]
    circle.append(circle)
    assert size_of(circle).total < ARRAY.nbytes + 4096
    row = [(float(number), str(number)) for number in range(10 * MOST_OBJECTS)]
    size = size_of(row).total
    exact = (56 + 24 + 55) * len(row) + 8 * len(row)
    assert 0.3 * exact < size < 3.0 * exact


def test_the_program_itself_is_not_counted():
    assert size_of(np, Answer, size_of, len).total == 0
    with pytest.raises(ZeroDivisionError) as caught:
        1 / 0  # noqa: B018
    assert size_of(caught.value).total < 4096  # its frames refer to whole modules
