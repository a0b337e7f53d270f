"""Lines turn a little so that patches bend one way, and nothing else of a car changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry.patches import coons_nets, crease_angles
from bozzetto_car.body.chain_smoothing import lock_ratios, smooth_chains
from bozzetto_car.body.default_shape import pull_out_panels
from bozzetto_car.body.fair_lines import double_bends, fair_network
from bozzetto_car.body.turned_lines import with_fewer_saddles
from bozzetto_car.template.crease_angles import end_angles_between
from bozzetto_car.template.crease_sides import end_angles, turning_creases
from bozzetto_car.template.fair_patches import corners_of, fair_nets
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import MIRROR, Template
from bozzetto_car.template.network import Network, with_tangents
from tests.plugins.car.body.test_fair_lines import trembling
from tests.plugins.car.figures_surfaces import VISIBLE, share
from tests.plugins.car.sketched import rubbery, styled

SEEDS = range(8100, 8102)
"""Seeds with which no constant was chosen."""


def fair(template: Template, positions: np.ndarray) -> Network:
    """The lines of a car before they are turned."""
    return lock_ratios(pull_out_panels(fair_network(template, positions)))


@pytest.mark.parametrize("name", TEMPLATES)
def test_cars_have_fewer_saddles(name: str) -> None:
    template = bundled(name)
    shares = []
    for seed in SEEDS:
        for car in (styled(template, seed), rubbery(template, seed), trembling(template, seed)):
            before = fair(template, car)
            shares.append(
                [share(fair_nets(one), VISIBLE) for one in (before, with_fewer_saddles(before))]
            )
    before, after = np.mean(shares, axis=0)
    assert after < 0.8 * before
    assert max(own - was for was, own in shares) < 2.5


@pytest.mark.parametrize("name", TEMPLATES)
def test_lines_turn_and_nothing_else_changes(name: str) -> None:
    template = bundled(name)
    for seed in SEEDS:
        before = fair(template, trembling(template, seed))
        made = with_fewer_saddles(before)
        assert np.array_equal(made.positions, before.positions)
        assert np.linalg.norm(made.tangents, axis=2) == pytest.approx(
            np.linalg.norm(before.tangents, axis=2), rel=1e-9
        )
        assert not (made.tangents[~made.free_axes] != before.tangents[~made.free_axes]).any()
        # Surfaces stay smooth where they were, and lines have one direction in their joints.
        angles = crease_angles(fair_nets(made), template.sides, len(template.edges))
        assert angles[template.smooth_edges].max() < 1e-6
        assert smooth_chains(made).tangents == pytest.approx(made.tangents, abs=1e-6)
        assert double_bends(made).max() < 0.01
        assert not turning_creases(made)


def test_both_sides_stay_mirror_images(template: Template) -> None:
    made = with_fewer_saddles(fair(template, trembling(template, 8104)))
    for edge, twin in enumerate(template.mirrored_edges.tolist()):
        own = made.tangents[edge]
        other = made.tangents[twin] if twin >= 0 else -made.tangents[~twin, ::-1]
        assert np.array_equal(own, other * MIRROR)


@pytest.mark.parametrize("name", TEMPLATES)
def test_lines_hardly_leap_while_nodes_move(name: str) -> None:
    """While nodes move by a quarter of a millimetre no line moves by 8 mm: some two pixels of a
    sketch. Lines are in the middle where three eighths of both handles are."""
    template = bundled(name)
    one, other = styled(template, 8105), rubbery(template, 8106)
    before, moves = None, []
    for at in np.linspace(0.45, 0.55, 41):
        car = (1.0 - at) * one + at * other
        made = with_fewer_saddles(fair(template, car))
        middles = np.einsum("mkx,k->mx", made.control_points, (0.125, 0.375, 0.375, 0.125))
        if before is not None:
            moves.append(np.linalg.norm(middles - before, axis=1).max())
        before = middles
    assert np.median(moves) < 1.0
    assert max(moves) < 8.0


def test_a_car_without_tangents_and_one_with_two_nodes_in_one_place(template: Template) -> None:
    """Tangents without a length have no way to turn, and chords without one none to keep."""
    places = trembling(template, 8107)
    door = [template.node["S3.R"], template.node["S3.L"]]
    places[door] = places[[template.node["S2.R"], template.node["S2.L"]]]
    bare = Network(template, template.positions, np.zeros_like(template.tangents))
    for network in (bare, Network.of(template, places)):
        assert np.isfinite(with_fewer_saddles(network).tangents).all()


def test_slopes_of_angles_are_those_of_differences(template: Template) -> None:
    """Of the angles that `crease_sides` finds from tangents; lengths count as fixed."""
    rng = np.random.default_rng(8107)
    patches = corners_of(template).patches
    ends = end_angles_between(template, tuple(patches.tolist()))
    by = {(edge, end): rng.normal(size=3) for edge in range(len(template.edges)) for end in (0, 1)}

    def moved(step: float) -> Network:
        own = Network.of(template)
        return with_tangents(own, {at: own.tangents[at] + step * way for at, way in by.items()})

    def nets(network: Network) -> np.ndarray:
        return coons_nets(network.control_points, template.sides)[patches].reshape(-1, 16, 3)

    step = 1e-3
    ways = (nets(moved(step)) - nets(moved(-step)))[:, :, None] / (2.0 * step)
    wanted = [replace(ends, least=np.full(len(ends.signs), want)) for want in (1e6, 2e6)]
    (low, slopes), (high, _) = (one.missing(nets(moved(0.0)), ways) for one in wanted)
    turned = (end_angles(moved(step)) - end_angles(moved(-step))) / (2.0 * step)
    assert len(turned) == len(ends.signs) >= 25
    scale = (high - low) / 1e6
    assert slopes[:, 0] == pytest.approx(-scale * ends.signs * turned, rel=1e-3, abs=1e-4)
