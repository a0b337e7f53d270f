"""Networks brought to dimensions and back: derivatives, inverses, smooth lines, symmetry."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.geometry.patches.crease import crease_angles
from bozzetto.geometry.patches.patch import extent
from bozzetto_car.body.dimension_map import Reshaping
from bozzetto_car.body.stretch import reshaping_of, stretch, undo_stretch
from bozzetto_car.dimensions import Dimensions, measure_dimensions
from bozzetto_car.template import fair_patches
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.loader import PAPER_TEMPLATES, bundled
from bozzetto_car.template.network import Network, junctions, with_positions, with_tangents
from bozzetto_car.template.saddles import bent_one_way
from tests.plugins.car.sketched import styled
from tests.plugins.car.traced_car import curve, symmetric

Array = NDArray[np.float64]

MAPS = [
    Reshaping(0.0, 4600.0, (1.05, 0.97, 1.02), (0.30, 0.69)),
    Reshaping(-120.0, 4200.0, (0.93, 1.04, 0.96), (0.38, 0.62)),
    Reshaping(300.0, 5000.0, (1.0, 1.0, 1.0), (1.0 / 3.0, 2.0 / 3.0)),
    Reshaping(0.0, 4600.0, (1.1, 1.1, 0.9), (0.08, 0.80)),
]


def wanted(network: Network, **factors: float) -> Dimensions:
    nets = fair_nets(network)
    now = measure_dimensions(
        extent(nets), *network.positions[network.template.wheels[:, 0], 0]
    ).given()
    return Dimensions(**{name: now[name] * factor for name, factor in factors.items()})


def car(name: str = "sedan", seed: int = 1) -> Network:
    template = bundled(name)
    return Network.of(template, styled(template, seed))


def mapped(network: Network, **factors: float) -> Reshaping:
    map_ = reshaping_of(network, wanted(network, **factors))
    assert map_ is not None
    return map_


@pytest.mark.parametrize("map_", MAPS)
def test_tangents_undergo_the_derivative_of_the_map(map_: Reshaping) -> None:
    rng = np.random.default_rng(0)
    places = rng.uniform((-800, -900, 0), (5800, 900, 1500), (200, 3))
    ways = rng.normal(0.0, 300.0, (200, 3))
    inside = np.abs((places[:, 0] - map_.front) / map_.length - 0.5)
    places = places[np.abs(inside - 0.5) > 1e-3]  # not at the ends, where the slope has a bend
    ways = ways[: len(places)]
    step = 1e-4
    change = map_.points(places + step * ways) - map_.points(places - step * ways)
    assert np.abs(map_.tangents(ways, places) - change / (2 * step)).max() < 1e-4
    assert np.abs(map_.tangents_before(map_.tangents(ways, places), places) - ways).max() < 1e-9


@pytest.mark.parametrize("map_", MAPS)
def test_the_way_back_is_the_inverse(map_: Reshaping) -> None:
    rng = np.random.default_rng(1)
    places = rng.uniform((-4000, -2000, -500), (9000, 2000, 3000), (5000, 3))
    assert np.abs(map_.points_before(map_.points(places)) - places).max() < 1e-8
    assert np.abs(map_.points(map_.points_before(places)) - places).max() < 1e-8


@pytest.mark.parametrize("name", PAPER_TEMPLATES)
def test_what_was_smooth_stays_so_exactly(name: str) -> None:
    network = car(name)
    made = stretch(
        network, mapped(network, length=1.04, front_overhang=0.92, wheelbase=1.07, height=0.96)
    )
    assert symmetric(made)
    sides, edges = network.template.sides, len(network.template.edges)
    for joint in junctions(network.template):
        one, other = (
            sense * made.tangents[place]
            for sense, place in zip(joint.senses, (joint.before, joint.after), strict=True)
        )
        size = np.linalg.norm(one) * np.linalg.norm(other)
        assert np.linalg.norm(np.cross(one, other)) < 1e-9 * size
    before, after = (
        np.nan_to_num(crease_angles(fair_nets(n), sides, edges)) for n in (network, made)
    )
    assert after[before < 1e-6].max() < 1e-5


def test_edges_stay_as_near_to_the_map_as_moved_control_points_do() -> None:
    for name in PAPER_TEMPLATES:
        network = car(name)
        map_ = mapped(network, length=1.04, front_overhang=0.92, wheelbase=1.07)
        made = stretch(network, map_)
        moved = map_.points(network.control_points)
        ours, theirs = [], []
        for old, new, other in zip(network.control_points, made.control_points, moved, strict=True):
            goal = map_.points(curve(old))
            ours.append(np.linalg.norm(curve(new) - goal, axis=1).max())
            theirs.append(np.linalg.norm(curve(other) - goal, axis=1).max())
        assert max(ours) < max(theirs)
        assert max(ours) < 12.0


def test_what_is_done_there_is_done_here_and_nothing_else() -> None:
    network = car()
    map_ = mapped(network, length=1.05, width=0.98, height=1.03, wheelbase=1.04)
    there = stretch(network, map_)
    rng = np.random.default_rng(2)
    moves = {4: there.positions[4] + (30.0, 0.0, -8.0), 20: there.positions[20] + (9.0, 6.0, 3.0)}
    changed = with_tangents(
        with_positions(there, moves), {(9, 0): rng.normal(0, 300, 3), (30, 1): (90, 50, 20)}
    )
    back = undo_stretch(network, there, changed, map_)
    again = stretch(back, map_)
    assert np.abs(again.positions - changed.positions).max() < 1e-8
    assert np.abs(again.tangents - changed.tangents).max() < 1e-8
    assert symmetric(back)
    kept = (changed.positions == there.positions).all(axis=1)
    assert np.array_equal(back.positions[kept], network.positions[kept])
    kept = (changed.tangents == there.tangents).all(axis=2) & kept[network.template.edges]
    assert np.array_equal(back.tangents[kept], network.tangents[kept])


def test_a_wheel_is_lifted_as_far_there_as_here() -> None:
    network = car()
    map_ = mapped(network, height=1.10, wheelbase=1.03)
    there = stretch(network, map_)
    wheel = int(network.template.wheels[1, 0])
    changed = with_positions(there, {wheel: there.positions[wheel] + (0.0, 0.0, 12.0)})
    back = undo_stretch(network, there, changed, map_)
    assert back.positions[wheel, 2] == pytest.approx(network.positions[wheel, 2] + 12.0)
    assert np.abs(back.positions[wheel, :2] - network.positions[wheel, :2]).max() < 1e-8


def test_nothing_is_to_be_done_for_what_is_there() -> None:
    network = car()
    assert reshaping_of(network, Dimensions()) is None
    assert reshaping_of(network, wanted(network, length=1.0, height=1.0)) is None
    with pytest.raises(UserError, match="Choose"):
        reshaping_of(network, wanted(network, front_overhang=0.3, wheelbase=1.4))


def test_patches_are_worked_out_once_for_each_car_that_is_measured(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Neither the car before nor the one that is shown has its patches made again."""
    made: list[bytes] = []

    def counted(nets: Array, *rest: Any) -> Array:
        made.append(nets.tobytes())
        return bent_one_way(nets, *rest)

    monkeypatch.setattr(fair_patches, "bent_one_way", counted)
    network = car(seed=77)
    box = extent(fair_nets(network))
    map_ = mapped(network, wheelbase=1.03, length=1.02)
    shown = fair_nets(stretch(network, map_))
    assert len({*made}) == len(made) > 1
    assert (extent(shown) != box).any()
    np.testing.assert_array_equal(shown, fair_nets.__wrapped__(stretch.__wrapped__(network, map_)))
    assert not shown.flags.writeable
