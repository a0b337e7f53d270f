"""The templates against cars that were built: the table in docs/car.md is the oracle."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto_car.template.loader import TEMPLATES, bundled
from tests.plugins.car.template.proportions import Proportions

PAGE = Path(__file__).parents[4] / "docs" / "car.md"
ROW = re.compile(r"\| ([^|]+) \| ([^|]*[a-z][^|]*) \|" + r" (\d+|–) \|" * 4)
"""A car that was built: a name has letters. A table of the templates' own figures has none."""
MEASURES = ("length", "width", "height", "wheelbase")


def published(kind: str) -> list[dict[str, float]]:
    """Cars of a kind in the table, mm; what a source does not tell is left out."""
    cars, noun = [], bundled(kind).noun
    for match in ROW.finditer(PAGE.read_text(encoding="utf-8")):
        if match[1] == noun:
            told = zip(MEASURES, match.groups()[2:], strict=True)
            cars.append({name: float(text) for name, text in told if text != "–"})
    return cars


@pytest.mark.parametrize("kind", TEMPLATES)
def test_dimensions_lie_among_those_of_cars_that_were_built(kind: str) -> None:
    cars = published(kind)
    assert len(cars) >= 5
    own = Proportions.of(bundled(kind))
    for name in MEASURES:
        values = [car[name] for car in cars if name in car]
        assert len(values) >= 4
        assert min(values) <= getattr(own, name) <= max(values), name


@pytest.mark.parametrize("kind", TEMPLATES)
def test_ratios_and_overhangs_do_so_too(kind: str) -> None:
    whole = [car for car in published(kind) if len(car) == len(MEASURES)]
    own = Proportions.of(bundled(kind))
    for value, values in (
        (own.wheelbase / own.length, [car["wheelbase"] / car["length"] for car in whole]),
        (own.height / own.width, [car["height"] / car["width"] for car in whole]),
        (
            own.front_overhang + own.rear_overhang,
            [car["length"] - car["wheelbase"] for car in whole],
        ),
    ):
        assert min(values) <= value <= max(values)


@pytest.mark.parametrize("kind", TEMPLATES)
def test_wheels_are_of_sizes_that_are_sold(kind: str) -> None:
    """185/65 R15 to 235/60 R18, of a pickup to 265/65 R17: rim in inches, and twice the share of
    the width."""
    own = Proportions.of(bundled(kind))
    largest = 25.4 * 17 + 2 * 0.65 * 265 if kind == "pickup" else 25.4 * 18 + 2 * 0.60 * 235
    assert 25.4 * 15 + 2 * 0.65 * 185 <= own.tyre <= largest
    front, rear = bundled(kind).positions[bundled(kind).wheels[:, 0]]
    assert front[2] == rear[2]
    assert own.track + 215.0 <= own.width + 50.0  # a tyre hardly stands out of the body


@pytest.mark.parametrize("kind", TEMPLATES)
def test_the_nose_is_where_x_begins(kind: str) -> None:
    template = bundled(kind)
    own = Proportions.of(template)
    assert own.front_overhang == pytest.approx(
        template.positions[template.wheels[0, 0], 0], abs=1.0
    )


@pytest.mark.parametrize("kind", TEMPLATES)
def test_front_and_rear_overhang_and_wheelbase_make_the_length(kind: str) -> None:
    own = Proportions.of(bundled(kind))
    parts = own.front_overhang + own.wheelbase + own.rear_overhang
    assert parts == pytest.approx(own.length, abs=1e-9)


def test_a_car_twice_as_large_has_all_measures_twice_as_large() -> None:
    sedan = bundled("sedan")
    twice = Proportions.of(
        replace(sedan, positions=sedan.positions * 2.0, tangents=sedan.tangents * 2.0)
    )
    own = Proportions.of(sedan)
    for field in fields(own):
        assert getattr(twice, field.name) == pytest.approx(2.0 * getattr(own, field.name))


def test_bulging_edges_count() -> None:
    """The widest place of the sedan lies on its doors, not at a node; against dense sampling."""
    sedan = bundled("sedan")
    u = np.linspace(0.0, 1.0, 20_001)[:, None]
    widest = 0.0
    for a, b, c, d in sedan.control_points:
        place = ((1 - u) ** 3) * a + 3 * u * (1 - u) ** 2 * b + 3 * u**2 * (1 - u) * c + u**3 * d
        widest = max(widest, float(place[:, 1].max()))
    own = Proportions.of(sedan)
    assert own.width == pytest.approx(2.0 * widest, abs=0.1)
    assert own.width > 2.0 * sedan.positions[:, 1].max() + 20.0
