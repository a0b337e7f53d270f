"""Figures of cars from one sketch: shape, size and lines of cars beyond the templates' family.

Run ``python -m tests.plugins.car.figures_single_views``; it prints tables. Cars and sketches are of
seeds from 700 on, which neither a test uses nor a constant of the program was chosen with.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bozzetto_car.body.build import body_of
from bozzetto_car.body.default_shape import pull_out_panels
from bozzetto_car.body.fair_lines import double_bends
from bozzetto_car.solver.pipeline import Solved, solve_car
from bozzetto_car.state import CarState
from bozzetto_car.template.network import Network
from tests.plugins.car.held_out import TrueCar, held_out, near_template, outer
from tests.plugins.car.marked_points import Marked, marked
from tests.plugins.car.sketched import FRONT_QUARTER, REAR_QUARTER, SIDE, View
from tests.plugins.car.unseen import WIDE, exaggerated

Array = NDArray[np.float64]

SEED = 700

WORSE = 1.02
"""Ratio to the template's own error from which a case counts as worse than the template."""

BENT_TWICE = 1e-6
"""Product of the sines of the turns at both ends from which an edge bends twice to the eye."""


@dataclass(frozen=True)
class Kind:
    """A kind of sketch: its views, what else `marked` is told, and what is typed."""

    name: str
    views: tuple[View, ...] = (FRONT_QUARTER,)
    told: Mapping[str, Any] = field(default_factory=dict)
    typed: bool = False
    by_hand: bool = False


KINDS = (
    Kind("three-quarter, front"),
    Kind("three-quarter, rear", (REAR_QUARTER,)),
    Kind("ten marks", told={"count": 10}),
    Kind("wide angle", (WIDE,)),
    Kind("wide angle, length typed", (WIDE,), typed=True),
    Kind("orthographic three-quarter", told={"kind": "orthographic"}),
    Kind("orthographic side", (SIDE,), told={"kind": "orthographic"}),
    Kind("5 px of tremor", told={"hand": 5.0}),
    Kind("8 px of tremor", told={"hand": 8.0}),
    Kind("15 px of tremor", told={"hand": 15.0}),
    Kind("exaggerated by hand", by_hand=True),
    Kind("front and rear", (FRONT_QUARTER, REAR_QUARTER)),
)


def sketched_case(car: TrueCar, kind: Kind, seed: int) -> Marked:
    """A sketch of a kind of a car."""
    case = marked(car.template, car.positions, kind.views, seed, **kind.told)
    if kind.by_hand:
        case = exaggerated(case, np.random.default_rng(seed))
    if kind.typed:
        # The dimension is that of the surface, which bulges beyond the outermost nodes.
        own = body_of(replace(case.state, nodes=())).dimensions.length
        assert own is not None
        bulge = own - outer(car.template, car.template.positions)[0]
        length = float(outer(car.template, car.positions)[0] + bulge)
        case = replace(case, state=replace(case.state, length=length, lock=True))
    return case


def measured(cars: list[TrueCar], kind: Kind) -> tuple[Array, list[Solved]]:
    """By car: error of shape over the template's, error with size over the template's, mean error
    of length, width and wheelbase, greatest of them, error of shape in mm; and the cars."""
    rows, answers = [], []
    for number, car in enumerate(cars):
        answer = solve_car(sketched_case(car, kind, SEED + number).state)
        found, own = answer.positions, car.template.positions
        off = np.abs(car.off(found))
        shape = car.shape_error(found)
        ratios = shape / car.shape_error(own), car.error(found) / car.error(own)
        rows.append((*ratios, off.mean(), off.max(), shape))
        answers.append(answer)
    return np.array(rows), answers


def lines_of(cars: list[Solved]) -> Iterator[tuple[int, int, float]]:
    """Yield edges bent twice, of the template and of a car, and the variation of curvature of the
    car over that of the template (total variation, relative to the chord, summed over edges)."""
    for car in cars:
        made = body_of(car_state(car)).network
        own = pull_out_panels(Network.of(car.template))
        bent = [int((double_bends(one) > BENT_TWICE).sum()) for one in (own, made)]
        yield bent[0], bent[1], variation(made) / variation(own)


def car_state(car: Solved) -> CarState:
    """The state that a car of one sketch was solved from."""
    empty = marked(car.template, car.template.positions, (), 0).state
    return replace(empty, nodes=(car.placed["s0"].sketch,))


def variation(network: Network) -> float:
    """Total variation of the curvature along each edge times its chord, summed over edges."""
    along = np.linspace(0.0, 1.0, 41)[:, None, None]
    first = 3.0 * np.diff(network.control_points, axis=1)
    second = 2.0 * np.diff(first, axis=1)
    speed = (1 - along) ** 2 * first[:, 0] + 2 * along * (1 - along) * first[:, 1]
    speed = speed + along**2 * first[:, 2]
    change = (1 - along) * second[:, 0] + along * second[:, 1]
    curvature = np.cross(speed, change) / np.linalg.norm(speed, axis=2)[..., None] ** 3
    chord = np.linalg.norm(network.ends[:, 1] - network.ends[:, 0], axis=1)
    return float((np.linalg.norm(np.diff(curvature, axis=0), axis=2).sum(axis=0) * chord).sum())


def main() -> None:
    sets = {
        "held out": [*held_out(SEED), *held_out(SEED + 1)],
        "48 cars": list(near_template(range(SEED, SEED + 8))),
    }
    own = {
        name: np.median([car.shape_error(car.template.positions) for car in cars])
        for name, cars in sets.items()
    }
    print(
        f"Ratio of the error in shape to the template's own (held out: {len(sets['held out'])} "
        f"cars, {own['held out']:.0f} mm; 48 cars: {own['48 cars']:.0f} mm): median, 95th "
        f"percentile, cases above {WORSE}; errors of size (length, width and wheelbase, mean): "
        "median, worst."
    )
    print()
    print("| sketch | held out: shape | size | mm | 48 cars: shape | size | mm |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    solved: list[Solved] = []
    for kind in KINDS:
        cells = []
        for name, cars in sets.items():
            rows, answers = measured(cars, kind)
            if kind is KINDS[0] and name == "held out":
                solved = answers
            ratios, size = rows[:, 0], 100.0 * rows[:, 2]
            cells += [
                f"{np.median(ratios):.2f}, {np.percentile(ratios, 95):.2f}, "
                f"{100.0 * np.mean(ratios > WORSE):.0f} %",
                f"{np.median(size):.1f}, {size.max():.0f} %",
                f"{np.median(rows[:, 4]):.0f}",
            ]
        print(f"| {kind.name} | " + " | ".join(cells) + " |")
    lines = np.array(list(lines_of(solved)))
    print()
    print(
        f"Edges of {len(lines)} solved cars that bend to both sides: {lines[:, 1].max():.0f} at "
        f"most (templates {lines[:, 0].min():.0f} to {lines[:, 0].max():.0f}); variation of "
        f"curvature over the template's: {np.median(lines[:, 2]):.2f} in the median, "
        f"{np.percentile(lines[:, 2], 95):.2f} at the 95th percentile."
    )


if __name__ == "__main__":
    main()
