"""Marks without sense through the whole way from marks to the car: a sound car or a sentence."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto_car.solver.pipeline import solve_car, template_of
from bozzetto_car.state import CarState, Mark, Sketch
from bozzetto_car.template.loader import PAPER_TEMPLATES, bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.shape_constraints import Soundness
from tests.plugins.car.sketched import PICTURE, looking
from tests.sizes import sized

pytestmark = pytest.mark.slow

Name = Literal["sedan", "hatchback", "minivan"]


def senseless(template: Template, rng: np.random.Generator, number: int) -> Sketch:
    """A sketch with marks that make no sense, of one of many kinds."""
    around = rng.uniform(-180.0, 180.0)
    view = ((around, around), (-20.0, 60.0), (3.0, 20.0))
    camera = looking(template.positions, view, rng)
    places = camera.project(template.positions)[0]
    count = len(template.names)
    nodes = rng.choice(count, int(rng.integers(0, count + 1)), replace=False)
    size = (len(nodes), 2)
    match rng.integers(6):
        case 0:
            marks = rng.uniform(0.0, 1.0, size) * PICTURE
        case 1:
            marks = places[nodes] + rng.normal(0.0, rng.choice([20.0, 80.0, 1000.0]), size)
        case 2:
            marks = rng.uniform(0.0, 800.0, 2) + rng.normal(0.0, rng.choice([0.0, 2.0, 20.0]), size)
        case 3:
            marks = places[rng.permutation(count)[: len(nodes)]]
        case 4:
            marks = places[nodes] * [rng.choice([-1.0, 0.2, 5.0]), rng.choice([-1.0, 0.01, 1.0])]
        case _:
            marks = rng.uniform(0.0, 1.0, (len(nodes), 1)) * PICTURE
    named = [(template.names[n], u, v) for n, (u, v) in zip(nodes, marks.tolist(), strict=True)]
    return Sketch(
        id=f"s{number}",
        width=PICTURE[0],
        height=PICTURE[1],
        marks=tuple(Mark(*one) for one in named),
        kind=rng.choice(["auto", "perspective", "orthographic"]),
        cropped=bool(rng.random() < 0.2),
    )


def dragged(state: CarState, rng: np.random.Generator) -> CarState:
    """The car with one of its marks somewhere else."""
    sketch = state.sketches[0]
    if not sketch.marks:
        return state
    which = int(rng.integers(len(sketch.marks)))
    off = rng.normal(0.0, rng.choice([5.0, 300.0]), 2).tolist()
    moved = tuple(
        Mark(mark.node, mark.u + off[0], mark.v + off[1]) if number == which else mark
        for number, mark in enumerate(sketch.marks)
    )
    return state.with_node(Sketch(**{**vars(sketch), "marks": moved}))


def survive(name: Name, seed: int, count: int) -> int:
    """Solve so many sets of marks without sense, half of them dragged; how many were solved."""
    template = bundled(name)
    rng = np.random.default_rng(seed)
    cars = 0
    for _ in range(count):
        sketches = tuple(senseless(template, rng, n) for n in range(rng.integers(1, 4)))
        state = CarState(
            nodes=sketches,
            template=name,
            trace=float(rng.choice([0.0, 0.6, 1.0])),
            cost="paper" if rng.random() < 0.1 else "balanced",
            length=float(rng.uniform(3500.0, 6000.0)) if rng.random() < 0.1 else 0.0,
            wheelbase=float(rng.uniform(1400.0, 3600.0)) if rng.random() < 0.1 else 0.0,
            lock=True,
        )
        drags = rng.random() < 0.5
        try:
            car = solve_car(dragged(state, rng), before=state) if drags else solve_car(state)
        except UserError:
            assert state.dimensions.given(), "nothing stood in the way"
            continue
        assert np.isfinite(car.positions).all()
        assert np.array_equal(car.positions[template.mirrored], car.positions * [1.0, -1.0, 1.0])
        slacks = Soundness.of(template_of(state)).slacks(template.reduced(car.positions))
        assert slacks.min() >= -1e-9
        for placed in car.placed.values():
            assert placed.is_known or placed.problem
            for told in (placed.missed or {}, placed.left_out or {}):
                assert np.isfinite(list(told.values())).all()
        cars += bool(car.solid)
    return cars


@pytest.mark.parametrize("name", PAPER_TEMPLATES)
def test_marks_without_sense_give_a_sound_car_or_a_sentence(name: Name) -> None:
    assert survive(name, 0, 5) >= 2


@pytest.mark.parametrize("name", PAPER_TEMPLATES)
@pytest.mark.parametrize("seed", range(1, 1 + sized(1, 33)))
def test_many_sets_of_marks_without_sense(name: Name, seed: int) -> None:
    assert survive(name, seed, sized(50, 102)) >= 25
