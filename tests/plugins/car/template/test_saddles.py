"""Inner control points move until a patch bends one way, where its lines let it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry.patches import coons_nets, grid_curvatures
from bozzetto_car.template.fair_patches import INNER, fair_nets, least_varying_nets
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.network import Network
from bozzetto_car.template.saddles import bent_one_way
from bozzetto_car.template.weak_creases import Creases
from tests.plugins.car.figures_surfaces import VISIBLE, saddles, share

Array = NDArray[np.float64]

NUMBERS = tuple(4 * i + j for i, j in zip(*INNER, strict=True))

NO_CREASES = Creases(*(np.zeros((2, 0, *rest), np.intp) for rest in ((), (4,), (4,), (2,))))

UPWARD = np.eye(4)[None, :, :, None] * (0.0, 0.0, 1.0)
"""Each inner control point of one patch is an unknown of its own, and moves along z."""


def dome(pressed: float, size: float = 1000.0) -> Array:
    """A patch of a dome whose inner control points are pressed down by a share of its rise."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, 4), np.linspace(0.0, 1.0, 4), indexing="ij")
    rise = 0.4 * size * (u * (1.0 - u) + v * (1.0 - v))
    rise[1:3, 1:3] -= pressed * 0.1 * size
    return np.stack((size * u, size * v, rise), axis=-1)[None]


def moved(net: Array, form: float = 1.0) -> Array:
    way = bent_one_way(net, NUMBERS, UPWARD, form * np.eye(4), NO_CREASES)
    made = net.copy()
    made[:, *INNER, 2] += way
    return made


def test_a_patch_that_bends_one_way_stays_bit_for_bit() -> None:
    assert (moved(dome(0.0)) == dome(0.0)).all()


def test_a_patch_that_is_pressed_in_comes_out_again() -> None:
    pressed = dome(2.0)
    before = saddles(pressed, VISIBLE).mean()
    assert before > 0.3
    after = saddles(moved(pressed, 1e-3), VISIBLE).mean()
    assert after < 0.5 * before


def test_the_stiffer_it_is_the_less_it_moves() -> None:
    pressed = dome(2.0)
    ways = [np.abs(moved(pressed, form) - pressed).max() for form in (1e-2, 1.0, 1e2, 1e6)]
    assert ways == sorted(ways, reverse=True)
    assert ways[-1] < 0.5


def test_what_lines_force_stays() -> None:
    """Between two lines that bulge and two that are hollow every patch is a saddle."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, 4), np.linspace(0.0, 1.0, 4), indexing="ij")
    net = np.stack((1e3 * u, 1e3 * v, 400.0 * (u * (1.0 - u) - v * (1.0 - v))), axis=-1)[None]
    made = moved(net)
    assert saddles(made, VISIBLE).mean() > 0.5
    assert np.abs(made - net).max() < 100.0
    bent = grid_curvatures(made, [0.5], [0.5])
    assert bent.most[0, 0, 0] > 0.0 > bent.least[0, 0, 0]


def test_a_patch_a_thousand_times_as_large_moves_a_thousand_times_as_far() -> None:
    np.testing.assert_allclose(moved(dome(2.0, 1e6)), 1e3 * moved(dome(2.0)), rtol=1e-9, atol=1e-6)


def test_saddles_of_all_templates_are_fewer_by_a_fifth_than_without() -> None:
    networks = [Network.of(bundled(name)) for name in TEMPLATES]
    plain, steady, fair = (
        np.array([share(nets(network), VISIBLE) for network in networks])
        for nets in (
            lambda network: coons_nets(network.control_points, network.template.sides),
            least_varying_nets,
            fair_nets,
        )
    )
    assert (fair < steady).all()
    assert (steady < plain).all()
    assert fair.mean() < 0.8 * steady.mean()
