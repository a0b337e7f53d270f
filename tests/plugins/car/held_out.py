"""Cars beyond the family of the templates, of the sizes of cars that were built.

Outer dimensions are the published ones of `docs/car.md`, which no table of the program was made
from; what is between lies part of the way to another template, was changed as a designer would,
and bulges by chance. So no car is drawn from the prior that it is solved with.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto_car.template.loader import PAPER_TEMPLATES, bundled
from bozzetto_car.template.model import MIRROR, Template
from bozzetto_car.template.shape_constraints import Soundness
from tests.plugins.car.sketched import apart, rms, rubbery, styled
from tests.plugins.car.template.test_proportions import published

Array = NDArray[np.float64]

TOWARD = (0.3, 0.7)
"""How far a car is from its template toward another one, once both have its dimensions."""

BULGE, REACH = 25.0, 500.0
"""Smooth bulges and their reach, mm."""

APART = 12.0
"""Deviation of each node by itself, mm."""

TRIES = 80
"""Draws until a car is sound; most are at once."""


@dataclass(frozen=True)
class TrueCar:
    """A car to be found from sketches.

    Attributes
    ----------
    name : str
    template : Template
        The one that it is marked with.
    positions : (n, 3) float
        The true nodes, mm.
    """

    name: str
    template: Template
    positions: Array

    def shape_error(self, positions: Array) -> float:
        """Distance of the nodes of a car laid over this one by a similarity, rms, mm."""
        return rms(apart(positions, self.positions))

    def error(self, positions: Array) -> float:
        """Distance of the nodes of a car laid over this one by a motion, size counts; rms, mm."""
        mine, theirs = (car - car.mean(axis=0) for car in (positions, self.positions))
        left, _, right = np.linalg.svd(theirs.T @ mine)
        signs = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
        return rms(np.linalg.norm(mine @ (left * signs @ right).T - theirs, axis=1))

    def off(self, positions: Array) -> Array:
        """By what share length, width and wheelbase of a car are wrong, (3,)."""
        return outer(self.template, positions)[:3] / outer(self.template, self.positions)[:3] - 1.0


def outer(template: Template, positions: Array) -> Array:
    """Length, width, wheelbase and height of the nodes, mm, (4,)."""
    body = np.delete(positions, template.wheels.ravel(), axis=0)
    front, rear = positions[template.wheels[:, 0], 0]
    return np.array([*np.ptp(body[:, :2], axis=0), rear - front, body[:, 2].max()])


def held_out(seed: int = 0) -> Iterator[TrueCar]:
    """Yield a car for each one in the table of published dimensions."""
    for kind in PAPER_TEMPLATES:
        for number, told in enumerate(published(kind)):
            rng = np.random.default_rng((seed, PAPER_TEMPLATES.index(kind), number))
            yield TrueCar(f"{kind} {number}", bundled(kind), _sound_car(kind, told, rng))


def near_template(seeds: range) -> Iterator[TrueCar]:
    """Yield the styled and the rubbery cars of each template."""
    for kind in PAPER_TEMPLATES:
        template = bundled(kind)
        for seed in seeds:
            yield TrueCar(f"{kind} styled {seed}", template, styled(template, seed))
            yield TrueCar(f"{kind} rubbery {seed}", template, rubbery(template, seed))


def _sound_car(kind: str, told: dict[str, float], rng: np.random.Generator) -> Array:
    template = bundled(kind)
    soundness = Soundness.of(template)
    for _ in range(TRIES):
        car = _car(template, told, rng)
        if soundness.slacks(template.reduced(car)).min() >= 0.0:
            return car
    raise ValueError(f"no sound {kind} of these dimensions was drawn")


def _car(template: Template, told: dict[str, float], rng: np.random.Generator) -> Array:
    others = [bundled(kind) for kind in PAPER_TEMPLATES if kind != template.id]
    other = others[rng.integers(len(others))]
    own = outer(template, template.positions)
    length = told["length"]
    wheelbase = told.get("wheelbase", own[2] * length / own[0])
    size = np.array([length, told["width"], wheelbase, told.get("height", own[3])])
    start = _of_size(template, template.positions, size)
    goal = _of_size(other, other.positions, size)
    change = np.zeros_like(start)
    for name, node in template.node.items():
        like = name if name in other.node else name.replace("S6", "S5")
        own_place = start[template.node[like]]
        change[node] = goal[other.node[like]] - own_place
    car = start + rng.uniform(*TOWARD) * change
    car += styled(template, int(rng.integers(1 << 30))) - template.positions
    near = np.exp(-(((car[:, None] - car) / REACH) ** 2).sum(axis=2))
    bulges = near @ rng.normal(0.0, BULGE, car.shape) / np.sqrt((near**2).sum(axis=1))[:, None]
    bulges += rng.normal(0.0, APART, car.shape)
    bulges[template.wheels.ravel()] = 0.0
    car += 0.5 * (bulges + bulges[template.mirrored] * MIRROR) * np.sqrt(2.0)
    car[template.centre, 1] = 0.0
    car[template.wheels[1], 2] = car[template.wheels[0], 2]
    return _of_size(template, car, size)


def _of_size(template: Template, positions: Array, size: Array) -> Array:
    """The nodes of a car with other outer dimensions (`outer`), the nose at x = 0."""
    length, width, wheelbase, height = size
    was = outer(template, positions)
    car = positions.copy()
    body = np.delete(positions, template.wheels.ravel(), axis=0)
    front, rear = positions[template.wheels[:, 0], 0]
    low, high = body[:, 0].min(), body[:, 0].max()
    overhang = (length - wheelbase) * (front - low) / (was[0] - was[2])
    knots = [low, front, rear, high]
    car[:, 0] = np.interp(car[:, 0], knots, [0.0, overhang, overhang + wheelbase, length])
    car[:, 1] *= width / was[1]
    car[:, 2] *= height / was[3]
    return car
