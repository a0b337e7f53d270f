"""Patches whose twists are found at once: smooth where the network is, and of least variation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import hilbert, null_space

from bozzetto.geometry.patches import coons_nets, crease_angles, sides_of
from bozzetto.geometry.patches.coons import boundaries
from bozzetto_car.body.chain_smoothing import lock_ratios
from bozzetto_car.body.fair_lines import fair_network
from bozzetto_car.template.fair_patches import fair_nets, least_varying_nets
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import MIRROR, Template
from bozzetto_car.template.network import Network
from tests.plugins.car.figures_surfaces import VISIBLE, share
from tests.plugins.car.sketched import rubbery, styled

Array = NDArray[np.float64]

SEEDS = range(60, 62)

MONOMIALS = np.array([[1, 0, 0, 0], [-3, 3, 0, 0], [3, -6, 3, 0], [-1, 3, -3, 1]], float)
"""Coefficients of 1, t, t², t³ from the control points of a cubic."""

DIFFERENTIATED = np.diag([1.0, 2.0, 3.0], 1)
"""Coefficients of the derivative from those of a polynomial."""


def cars(template: Template) -> list[Network]:
    """The template, and cars of it that have moved."""
    moved = [make(template, seed) for seed in SEEDS for make in (styled, rubbery)]
    made = [lock_ratios(fair_network(template, places)) for places in moved]
    return [Network.of(template), *made]


def variation() -> Array:
    """The integral of all squared third derivatives of a patch, a form of its control points."""
    own = [np.linalg.matrix_power(DIFFERENTIATED, order) @ MONOMIALS for order in range(4)]
    forms = [rows.T @ hilbert(4) @ rows for rows in own]
    return np.asarray(sum(np.kron(forms[k], forms[3 - k]) for k in range(4)))


def beside(side: int, row: int) -> list[tuple[int, int]]:
    """The control points of a patch in a row inward of a side, in the sense of the side."""
    turned = ([(k, row), (3 - row, k), (3 - k, 3 - row), (row, 3 - k)] for k in range(4))
    return [places[side] for places in turned]


def least_varying(network: Network) -> Array:
    """The same patches by one linear program for the whole car, which knows nothing of twists.

    Unknown are all inner control points; beside a smooth edge those of both patches are where the
    derivatives across it are opposite.
    """
    template, nets = network.template, coons_nets(network.control_points, network.template.sides)
    where = {side: divmod(at, 4) for at, side in enumerate(template.sides.ravel().tolist())}
    number = np.arange(nets[..., 0].size).reshape(nets.shape[:3])
    known = np.ones(nets.shape[:3], bool)
    known[:, 1:3, 1:3] = False
    for which, patch in enumerate(template.patches):  # where four creases meet twists are 0
        for corner, node in enumerate(patch.nodes):
            if template.names[node] in ("S6.R", "S6.L"):
                known[which, (1, 2, 2, 1)[corner], (1, 1, 2, 2)[corner]] = True
    rows, right = [], []
    for edge in np.flatnonzero(template.smooth_edges).tolist():
        (one, side), (two, back) = where[edge], where[~edge]
        line = nets[(one, *np.transpose(beside(side, 0)))]
        inner = [(one, *place) for place in beside(side, 1)]
        other = [(two, *place) for place in beside(back, 1)[::-1]]
        for k in (1, 2):
            end = 0 if k == 1 else 3
            legs = [np.linalg.norm(nets[row[end]] - line[end]) for row in (inner, other)]
            ratio = legs[0] / legs[1]
            row = np.zeros(number.size)
            row[number[inner[k]]], row[number[other[k]]] = 1.0, ratio
            rows.append(row)
            right.append((1.0 + ratio) * line[k])
    free = number[~known]
    matrix, wanted = np.array(rows)[:, free], np.array(right)
    start = np.linalg.lstsq(matrix, wanted, rcond=None)[0]
    ways = null_space(matrix)
    whole = nets.reshape(-1, 3).copy()
    whole[free] = start
    form = np.kron(np.eye(len(nets)), variation())
    bent = ways.T @ form[free] @ whole
    whole[free] -= ways @ np.linalg.solve(ways.T @ form[np.ix_(free, free)] @ ways, bent)
    return np.asarray(whole.reshape(nets.shape))


@pytest.mark.parametrize("name", ["sedan", "hatchback", "minivan"])
def test_patches_vary_least_of_all_that_are_as_smooth(name: str) -> None:
    for network in cars(bundled(name))[:3]:
        assert np.abs(least_varying_nets(network) - least_varying(network)).max() < 1e-6


@pytest.mark.parametrize("name", TEMPLATES)
def test_edges_stay_and_halves_are_mirror_images_bit_for_bit(name: str) -> None:
    template = bundled(name)
    left = {frozenset(patch.nodes): k for k, patch in enumerate(template.patches)}
    for network in cars(template):
        nets = fair_nets(network)
        np.testing.assert_array_equal(
            sides_of(nets), boundaries(network.control_points, template.sides)
        )
        for number, patch in enumerate(template.patches):
            image = nets[left[frozenset(template.mirrored[list(patch.nodes)].tolist())]] * MIRROR
            own = {tuple(point) for point in (nets[number].reshape(-1, 3) + 0.0).tolist()}
            assert own == {tuple(point) for point in (image.reshape(-1, 3) + 0.0).tolist()}


@pytest.mark.parametrize("name", TEMPLATES)
def test_surfaces_are_smooth_over_all_edges_that_are_no_creases(name: str) -> None:
    template = bundled(name)
    for network in cars(template):
        angles = crease_angles(fair_nets(network), template.sides, len(template.edges))
        assert angles[template.smooth_edges].max() < 1e-4


@pytest.mark.parametrize("name", TEMPLATES)
def test_fewer_saddles_are_seen_than_without_twists(name: str) -> None:
    template = bundled(name)
    for network in cars(template):
        plain = coons_nets(network.control_points, template.sides)
        assert share(fair_nets(network), VISIBLE) < share(plain, VISIBLE)


@pytest.mark.parametrize("name", TEMPLATES)
def test_a_seventh_of_what_is_seen_of_a_template_is_saddles_at_most(name: str) -> None:
    assert share(fair_nets(Network.of(bundled(name))), VISIBLE) <= 15.0


def test_a_car_a_thousand_times_as_large_is_the_same_car() -> None:
    network = Network.of(bundled("hatchback"))
    large = replace(
        network, positions=1000.0 * network.positions, tangents=1000.0 * network.tangents
    )
    np.testing.assert_allclose(fair_nets(large), 1000.0 * fair_nets(network), rtol=1e-11, atol=1e-6)


def test_a_car_that_moves_a_little_has_patches_that_move_a_little() -> None:
    template = bundled("sedan")
    network, rng = Network.of(template), np.random.default_rng(60)
    for _ in range(10):
        variables = rng.normal(0.0, 1e-3, len(template.variables))
        moved = replace(network, positions=network.positions + template.whole(variables))
        most = np.abs(moved.positions - network.positions).max()
        assert np.abs(fair_nets(moved) - fair_nets(network)).max() < 20.0 * most


def test_edges_without_tangents_give_patches_that_are_finite() -> None:
    network = Network.of(bundled("minivan"))
    for scale in (0.0, 1e-12):
        assert np.isfinite(fair_nets(replace(network, tangents=scale * network.tangents))).all()


def test_a_crease_that_a_person_declares_ends_the_rows_of_corners() -> None:
    template = bundled("sedan")
    edge = int(np.flatnonzero(template.smooth_edges)[0])
    image = int(template.mirrored_edges[edge])
    more = replace(template, creases=template.creases | {edge, max(image, ~image)})
    network = Network.of(more)
    assert np.abs(least_varying_nets(network) - least_varying(network)).max() < 1e-6
    assert np.abs(fair_nets(network) - fair_nets(Network.of(template))).max() > 0.1
