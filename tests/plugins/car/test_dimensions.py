"""Dimensions: how they are measured, and as equations over a car's variables."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto_car.dimensions import Dimensions, Locks, Overlap, measure_dimensions
from bozzetto_car.template.model import Template


def of_nodes(template: Template, positions: np.ndarray) -> Dimensions:
    body = np.delete(positions, template.wheels.ravel(), axis=0)
    front, rear = positions[template.wheels[:, 0], 0]
    return measure_dimensions(np.array([body.min(axis=0), body.max(axis=0)]), front, rear)


def test_measures_of_a_box() -> None:
    box = np.array([[-20.0, -900.0, 150.0], [4480.0, 900.0, 1460.0]])
    assert measure_dimensions(box, 880.0, 3580.0) == Dimensions(
        4500.0, 1800.0, 1460.0, 900.0, 2700.0
    )


def test_locks_measure_the_nodes(template: Template) -> None:
    """Their rows, applied to a car, are its dimensions; of the template and of others."""
    rng = np.random.default_rng(0)
    wanted = Dimensions(4700.0, 1850.0, 1500.0, 900.0, 2750.0)
    for _ in range(10):
        car = template.variables + rng.normal(0.0, 20.0, len(template.variables))
        locks = Locks.of(template, wanted, car)
        found = of_nodes(template, template.whole(car))
        order = ("length", "front_overhang", "wheelbase", "width", "height")
        given = found.given()
        assert locks.rows @ car == pytest.approx([given[name] for name in order])
        assert locks.values == pytest.approx([wanted.given()[name] for name in order])
        assert (locks.bounds @ car).min() >= 0.0


def test_bounds_forbid_nodes_beyond_the_outermost(template: Template) -> None:
    locks = Locks.of(template, Dimensions(length=4700.0, height=1500.0), template.variables)
    for half, move in (("S2", [-3000.0, 0, 0]), ("S3", [3000.0, 0, 0]), ("C2", [0, 0, 900.0])):
        car = template.positions.copy()
        name = half if half.startswith("C") else f"{half}.R"
        car[template.node[name]] += move
        assert (locks.bounds @ template.reduced(car)).min() < 0.0
    wide = template.positions * [1.0, 3.0, 1.0]
    assert (locks.bounds @ template.reduced(wide)).min() >= 0.0  # the width is not locked


def test_nothing_wanted_is_nothing_locked(template: Template) -> None:
    locks = Locks.of(template, Dimensions(), template.variables)
    assert locks.rows.shape == (0, len(template.variables))
    assert locks.bounds.shape == (0, len(template.variables))


def test_the_surface_may_bulge_beyond_the_nodes(template: Template) -> None:
    body = np.delete(template.positions, template.wheels.ravel(), axis=0)
    more = np.array([[-40.0, -12.0, 0.0], [30.0, 12.0, 5.0]])
    box = more + np.array([body.min(axis=0), body.max(axis=0)])
    overlap = Overlap.of(template, template.positions, box)
    assert overlap == Overlap(40.0, 30.0, 12.0, 5.0)
    front, rear = template.positions[template.wheels[:, 0], 0]
    wanted = measure_dimensions(box, front, rear)
    locks = Locks.of(template, wanted, template.variables, overlap)
    assert locks.rows @ template.variables == pytest.approx(locks.values)


def test_a_node_level_with_the_outermost_is_told(template: Template) -> None:
    wanted = Dimensions(length=4700.0)
    locks = Locks.of(template, wanted, template.variables)
    assert locks.tied(template, template.variables) is None
    car = template.positions.copy()
    rearmost = locks.outermost[1]
    other = template.node["C8" if template.names[rearmost] != "C8" else "C7"]
    car[other, 0] = car[rearmost, 0]
    tied = locks.tied(template, template.reduced(car))
    assert tied is not None
    assert tied[1] == other


@pytest.mark.parametrize("value", [0.0, -4500.0, 4.5, 1e9, np.nan, np.inf])
def test_no_car_has_such_a_length(template: Template, value: float) -> None:
    with pytest.raises(UserError, match="length"):
        Locks.of(template, Dimensions(length=value), template.variables)
