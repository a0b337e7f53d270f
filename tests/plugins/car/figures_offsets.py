"""How many bodies Open CASCADE offsets by 2 mm: templates moved a little, and solved cars.

Run ``python -m tests.plugins.car.figures_offsets`` with the variable BOZZETTO_CAD_READERS; it
prints a table, in about a quarter of an hour. A single answer of Open CASCADE turns on almost
nothing, so each template is asked of with nodes moved by a tenth of a millimetre, in several ways.
Seeds from 1,300 on are used by nothing else, and no constant of the program was chosen with them.
"""

from __future__ import annotations

import os
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto_car.body.build import body_of
from bozzetto_car.parts.closed_body import closed_body
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import MIRROR
from bozzetto_car.template.network import Network
from tests.plugins.car.marked_points import marked
from tests.plugins.car.offsets import Offset, offset_by_open_cascade
from tests.plugins.car.sketched import FRONT_QUARTER, rubbery, styled

Array = NDArray[np.float64]

SEED = 1300

WAYS = 5
"""How many times each template is moved."""

MOVED = 0.1
"""Standard deviation of each coordinate of a node, mm."""


def moved_templates(name: str, seed: int = SEED) -> Iterator[Network]:
    """Yield a template with its nodes moved a little, both halves alike."""
    template = bundled(name)
    for number in range(seed, seed + WAYS):
        rng = np.random.default_rng((number, TEMPLATES.index(name)))
        by = rng.normal(0.0, MOVED, template.positions.shape)
        by[template.centre, 1] = 0.0
        by[template.pairs[:, 1]] = by[template.pairs[:, 0]] * MIRROR
        yield Network.of(template, template.positions + by)


def solved_cars(name: str, seed: int = SEED) -> Iterator[Network]:
    """Yield two cars, each solved from one three-quarter sketch."""
    template = bundled(name)
    for number, make in enumerate((styled, rubbery), start=seed + 2 * TEMPLATES.index(name)):
        state = marked(template, make(template, number), (FRONT_QUARTER,), number).state
        yield body_of(state).network


def offset_of(network: Network, python: str) -> Offset:
    """Return what comes of the closed body of a car."""
    try:
        closed = closed_body(network, fair_nets(network))
    except UserError:
        return Offset(False, False, 0.0)
    return offset_by_open_cascade(closed, python)


def main() -> None:
    python = os.environ["BOZZETTO_CAD_READERS"]
    print(f"| template | moved by {MOVED:g} mm | solved from one sketch |")
    print("| --- | --- | --- |")
    sums = np.zeros((2, 2), int)
    for name in TEMPLATES:
        cells = []
        for column, cars in enumerate((moved_templates(name), solved_cars(name))):
            sound = [offset_of(car, python).is_sound for car in cars]
            sums[column] += sum(sound), len(sound)
            cells.append(f"{sum(sound)} of {len(sound)}")
        print("| " + " | ".join([bundled(name).title, *cells]) + " |", flush=True)
    print("| all | " + " | ".join(f"{sound} of {count}" for sound, count in sums.tolist()) + " |")


if __name__ == "__main__":
    main()
