"""Networks of edges: two forms of one thing, and symmetry to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from bozzetto.errors import UserError
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import (
    Network,
    as_bezier,
    as_hermite,
    edge_called,
    junctions,
    node_called,
    with_positions,
    with_tangents,
)
from tests.plugins.car.traced_car import curve, symmetric


def test_bezier_points_and_tangents_are_the_same_curve() -> None:
    rng = np.random.default_rng(1)
    ends, tangents = rng.normal(0, 1e3, (2, 50, 2, 3))
    points = as_bezier(ends, tangents)
    for number in range(50):
        other = CubicHermiteSpline([0, 1], ends[number], tangents[number])
        assert np.abs(curve(points[number], 33) - other(np.linspace(0, 1, 33))).max() < 1e-10


def test_forms_are_exchanged_without_loss(template: Template) -> None:
    network = Network.of(template)
    points = network.control_points
    ends, tangents = as_hermite(points)
    assert np.array_equal(ends, network.positions[template.edges])
    assert np.abs(tangents - network.tangents).max() < 1e-11
    assert np.abs(points - template.control_points).max() < 1e-11


def test_networks_are_frozen_and_sound(template: Template) -> None:
    network = Network.of(template)
    with pytest.raises(ValueError, match="read-only"):
        network.tangents[0, 0, 0] = 1.0
    with pytest.raises(ValueError, match="template"):
        Network(template, template.positions[:-1], template.tangents)
    broken = np.array(template.tangents)
    broken[0, 0, 0] = np.nan
    with pytest.raises(ValueError, match="finite"):
        Network(template, template.positions, broken)


def test_the_other_side_follows_any_change(template: Template) -> None:
    rng = np.random.default_rng(2)
    for _ in range(40):
        edge, end = int(rng.integers(len(template.edges))), int(rng.integers(2))
        node = int(rng.integers(len(template.names)))
        changed = with_tangents(Network.of(template), {(edge, end): rng.normal(0, 500, 3)})
        changed = with_positions(changed, {node: rng.normal(0, 500, 3)})
        assert symmetric(changed)


def test_edges_of_the_middle_stay_and_cross_edges_leave_it_at_a_right_angle() -> None:
    sedan = bundled("sedan")
    middle, cross = edge_called(sedan, "C3-C2"), edge_called(sedan, "C1-S1.R")
    wish = np.array([100.0, 200.0, 300.0])
    changed = with_tangents(Network.of(sedan), {(middle, 0): wish, (cross, 0): wish})
    assert changed.tangents[middle, 0].tolist() == [100.0, 0.0, 300.0]
    assert changed.tangents[cross, 0].tolist() == [0.0, 200.0, 0.0]
    assert changed.tangents[cross, 1].tolist() == sedan.tangents[cross, 1].tolist()


def test_joints_are_where_two_edges_run_on(template: Template) -> None:
    network = Network.of(template)
    found = list(junctions(template))
    assert len(found) == sum(len(chain.smooth) for chain in template.chains)
    for joint in found:
        (one, other), senses = (joint.before, joint.after), joint.senses
        assert template.edges[one] == template.edges[other] == joint.node
        a, b = senses[0] * network.tangents[one], senses[1] * network.tangents[other]
        assert a @ b > 0.999 * np.linalg.norm(a) * np.linalg.norm(b)
        assert joint.crosses == (template.names[joint.node][0] == "C" and abs(a[1]) > 1.0)


def test_names_in_messages() -> None:
    sedan = bundled("sedan")
    assert sedan.edge_names[edge_called(sedan, "S1.R-C1")] == "C1-S1.R"
    assert sedan.names[node_called(sedan, "S4.L")] == "S4.L"
    for name in ("C1-C8", "", "C1", "S1.R-", "x" * 500):
        with pytest.raises(UserError, match="Name the nodes at both"):
            edge_called(sedan, name)
    with pytest.raises(UserError, match="no node “Q1”"):
        node_called(sedan, "Q1")
