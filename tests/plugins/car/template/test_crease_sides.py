"""Creases bulge, or are hollow, all along: in templates, in solved cars, and between their ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.geometry.patches.patch import grid_normals
from bozzetto_car.body.build import body_of
from bozzetto_car.body.fair_lines import fair_network, with_creases_of_one_side
from bozzetto_car.template.crease_sides import LEAST, end_angles, one_sided, turning_creases
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import MIRROR, Template
from bozzetto_car.template.network import Network, edge_called, with_tangents
from tests.plugins.car.marked_points import marked
from tests.plugins.car.sketched import FRONT_QUARTER, REAR_QUARTER, rubbery, styled

Array = NDArray[np.float64]

ALONG = np.linspace(0.0, 1.0, 17)

SMOOTH_ENDS = {"C3-R1.R", "C5-R3.R"}
"""Heads of screens: lines run on smoothly in the middle of the car, where the angle is nought."""

TANGENTIAL = {"van": 2.0}
"""Degrees up to which Open CASCADE takes an edge as tangential by its middle: 2.3. The van's
waistline does not reach that beside the door (2.1), and its closed body cannot be offset."""

ROUNDING = np.radians(0.02)


def angles(network: Network) -> dict[str, Array]:
    """The angle along each crease of the right half, above 0 where the body bulges, degrees.

    By the normals of both patches, without the network's formulas.
    """
    template, nets = network.template, fair_nets(network)
    rows = (
        grid_normals(nets, ALONG, [0.0])[:, :, 0],
        grid_normals(nets, [1.0], ALONG)[:, 0],
        grid_normals(nets, ALONG, [1.0])[:, ::-1, 0],
        grid_normals(nets, [0.0], ALONG)[:, 0, ::-1],
    )
    where = {side: divmod(at, 4) for at, side in enumerate(template.sides.ravel().tolist())}
    found = {}
    for edge in sorted(template.creases):
        name = template.edge_names[edge]
        if ".L" in name:
            continue
        (one, side), (two, back) = where[edge], where[~edge]
        normals = rows[side][one], rows[back][two][::-1]
        points = network.control_points[edge]
        ways = np.diff(points, axis=0)
        t = ALONG[:, None]
        way = (1 - t) ** 2 * ways[0] + 2 * t * (1 - t) * ways[1] + t**2 * ways[2]
        sine = (np.cross(*normals) * way).sum(axis=1) / np.linalg.norm(way, axis=1)
        found[name] = np.degrees(np.arctan2(sine, (normals[0] * normals[1]).sum(axis=1)))
    return found


def solved(template: Template, seed: int) -> Network:
    make, view = ((styled, FRONT_QUARTER), (rubbery, REAR_QUARTER))[seed % 2]
    return body_of(marked(template, make(template, seed), (view,), seed).state).network


@pytest.mark.parametrize("name", TEMPLATES)
def test_creases_of_a_template_are_on_one_side_all_along(name: str) -> None:
    for edge, found in angles(Network.of(bundled(name))).items():
        sign = 1.0 if found.sum() > 0.0 else -1.0
        least = (sign * found).min()
        assert least > (-0.1 if edge in SMOOTH_ENDS else TANGENTIAL.get(name, 2.3)), edge


@pytest.mark.parametrize("name", TEMPLATES)
def test_creases_of_solved_cars_are_on_one_side_in_their_ends_as_the_templates_are(
    name: str,
) -> None:
    template = bundled(name)
    own = end_angles(Network.of(template))
    for seed in (62, 63):
        network = solved(template, seed)
        found = np.sign(own) * end_angles(network)
        assert (found >= np.minimum(np.abs(own), LEAST) - ROUNDING).all()
        assert not turning_creases(network)


@pytest.mark.parametrize("name", ["sedan", "hatchback", "van"])
def test_the_angles_in_the_ends_are_those_of_the_patches(name: str) -> None:
    network = solved(bundled(name), 62)
    by_patches = angles(network)
    ends = np.concatenate([found[[0, -1]] for found in by_patches.values()])
    kept = [angle for angle in ends.tolist() if abs(angle) > 1e-6]
    np.testing.assert_allclose(np.degrees(end_angles(network)), kept, atol=1e-6)


def test_what_is_on_one_side_stays_bit_for_bit() -> None:
    for name in TEMPLATES:
        network = Network.of(bundled(name))
        assert np.array_equal(one_sided(network).tangents, network.tangents)


def test_a_car_a_thousand_times_as_large_has_the_same_creases() -> None:
    network = Network.of(bundled("suv"), rubbery(bundled("suv"), 64))
    large = replace(
        network, positions=1000.0 * network.positions, tangents=1000.0 * network.tangents
    )
    np.testing.assert_allclose(
        one_sided(large).tangents, 1000.0 * one_sided(network).tangents, rtol=1e-9, atol=1e-6
    )


def test_both_halves_turn_alike() -> None:
    template = bundled("van")
    made = with_creases_of_one_side(Network.of(template, rubbery(template, 65)))
    for edge, twin in enumerate(template.mirrored_edges.tolist()):
        other = made.tangents[twin] if twin >= 0 else -made.tangents[~twin, ::-1]
        assert np.array_equal(made.tangents[edge] + 0.0, other * MIRROR + 0.0)


def test_lines_that_cross_creases_smoothly_stay_smooth() -> None:
    template = bundled("estate")
    places = rubbery(template, 66)
    made = fair_network(template, places)
    again = one_sided(made)
    for name in ("C3-C4", "R2.R-R3.R", "S2.R-S3.R"):
        edge = edge_called(template, name)
        assert np.array_equal(again.tangents[edge], made.tangents[edge])


def test_a_crease_that_turns_from_one_side_to_the_other_is_named() -> None:
    network = Network.of(bundled("suv"))
    glass = edge_called(network.template, "C5-C6")
    turned = with_tangents(network, {(glass, 1): (-60.0, 0.0, -500.0)})
    assert [network.template.edge_names[edge] for edge in turning_creases(turned)] == ["C6-S5.R"]
    assert not turning_creases(one_sided(turned))


def test_edges_without_tangents_turn_nowhere() -> None:
    network = Network.of(bundled("minivan"))
    bare = replace(network, tangents=0.0 * network.tangents)
    assert np.array_equal(one_sided(bare).tangents, bare.tangents)
