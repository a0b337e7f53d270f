"""A solve, and a file that is read, end soon after nobody waits any more."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import pytest

from bozzetto.errors import Cancelled
from bozzetto.plugin import Job
from bozzetto.plugin.cache import forget_all
from bozzetto.testing.job_checks import TRIES, Watch
from bozzetto.testing.machine_speed import slowness
from bozzetto_car.body.build import body_of
from bozzetto_car.listening import look
from bozzetto_car.marks_file import car_from_facts
from bozzetto_car.modeler import Car
from bozzetto_car.state import CarState
from tests.plugins.car.drawn_cars import GALLERY_CARS, marks_in

LONGEST = 0.1
"""Processor time between two looks, s."""


def read(facts: dict[str, Any], job: Job) -> CarState:
    return car_from_facts(copy.deepcopy(facts), {}, job)


def longest(work: Callable[[Job], object]) -> float:
    """The longest time between two looks, of the best of some tries; nothing is remembered."""
    found = []
    for _ in range(TRIES):
        forget_all()
        watch = Watch()
        work(Job(cancelled=watch.look))
        watch.look()
        found.append(watch.longest / slowness())
        if found[-1] < LONGEST:
            break
    return min(found)


@pytest.mark.parametrize("name", GALLERY_CARS)
def test_work_looks_at_its_job_every_tenth_of_a_second(name: str) -> None:
    facts = marks_in(name)
    state = read(facts, Job())
    assert longest(lambda job: read(facts, job)) < LONGEST
    assert longest(lambda job: Car().solve(state, job)) < LONGEST


def test_a_file_is_stopped_at_every_look_and_read_the_same_afterwards() -> None:
    facts, watch = marks_in("hatchback"), []
    forget_all()
    whole = read(facts, Job(progress=lambda share, step: watch.append(step)))
    assert len(watch) > 20
    for last in (2, len(watch) // 3, len(watch) - 1):
        forget_all()
        looks = 0

        def cancelled(last: int = last) -> bool:
            nonlocal looks
            looks += 1
            return looks >= last

        with pytest.raises(Cancelled):
            read(facts, Job(cancelled=cancelled))
        assert looks == last
        again = read(facts, Job())
        for one, other in zip(again.styling, whole.styling, strict=True):
            assert (one.places == other.places).all()


def test_nobody_listens_after_a_job() -> None:
    with pytest.raises(Cancelled):
        Car().solve(CarState(), Job(cancelled=lambda: True))
    look()
    assert body_of(CarState()).template.id == "sedan"
