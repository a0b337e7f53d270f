"""Marks without sense: a sound car or a sentence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto_car.camera.marked_view import MarkedView
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.solver.bundle_adjustment import solve
from bozzetto_car.solver.prior import Cost
from bozzetto_car.template.model import Template
from bozzetto_car.template.shape_constraints import Soundness
from tests.plugins.car.sketched import (
    PICTURE,
    looking,
)
from tests.plugins.car.solved import assert_allowed, of_nodes
from tests.sizes import sized


def garbage(template: Template, rng: np.random.Generator) -> Sequence[MarkedView]:
    """One or two sketches with marks that make no sense, from cameras that do not either."""
    count = len(template.names)
    views = []
    for _ in range(rng.integers(1, 3)):
        around = rng.uniform(-180.0, 180.0)
        view = ((around, around), (-20.0, 60.0), (4.0, 20.0))
        kind = "orthographic" if rng.random() < 0.3 else "perspective"
        camera = looking(template.positions, view, rng, kind)
        size = int(rng.integers(4, count + 1))
        nodes = rng.choice(count, size, replace=False)
        places = camera.project(template.positions)[0]
        match rng.integers(4):
            case 0:
                marks = rng.uniform(0.0, 1.0, (size, 2)) * PICTURE
            case 1:
                marks = places[nodes] + rng.normal(0.0, rng.choice([50, 150, 1000]), (size, 2))
            case 2:
                marks = rng.uniform(0.0, 800.0, 2) + rng.normal(0.0, rng.integers(2), (size, 2))
            case _:
                marks = places[rng.permutation(count)[:size]]
        views.append(MarkedView(camera, nodes, marks, cropped=bool(rng.integers(2))))
    return views


RANGES = {
    "length": (3500.0, 6000.0),
    "width": (1500.0, 2200.0),
    "height": (1200.0, 2200.0),
    "front_overhang": (500.0, 1300.0),
    "wheelbase": (1400.0, 3600.0),
}


def survive_garbage(template: Template, seed: int, count: int) -> int:
    """Solve so many marks without sense; how many came out as a car."""
    rng = np.random.default_rng(seed)
    names = Soundness.of(template).names
    cars = 0
    for _ in range(count):
        off = rng.choice(names, rng.integers(0, 20)) if rng.random() < 0.2 else ()
        sound = Soundness.of(template, without=[str(name) for name in off])
        cost = Cost.paper(template) if rng.random() < 0.1 else Cost.balanced(rng.random())
        locked = Dimensions(
            **{
                name: float(rng.uniform(*ends))
                for name, ends in RANGES.items()
                if rng.random() < 0.15
            }
        )
        try:
            joint = solve(template, garbage(template, rng), cost, sound, locked=locked)
        except UserError as told:
            if not locked.given():
                raise AssertionError("nothing stood in the way") from told
            continue
        assert_allowed(template, joint, sound)
        found = of_nodes(template, joint)
        for name, value in locked.given().items():
            assert abs(found[name] - value) <= 1e-6
        cars += 1
    return cars


def test_garbage_gives_a_sound_car_or_a_sentence(template: Template) -> None:
    assert survive_garbage(template, 0, 4) >= 2


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(1, 1 + sized(1, 13)))
def test_ten_thousand_sets_of_garbage(template: Template, seed: int) -> None:
    count = sized(65, 257)
    assert survive_garbage(template, seed, count) >= 200 / 257 * count
