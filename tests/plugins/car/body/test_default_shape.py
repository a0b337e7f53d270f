"""Side panels and corners pulled out."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_car.body.default_shape import posts, pull_out_panels
from bozzetto_car.template.loader import PAPER_TEMPLATES, bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network, edge_called, with_tangents
from tests.plugins.car.traced_car import curve, symmetric


@pytest.fixture(params=PAPER_TEMPLATES)
def flat(request: pytest.FixtureRequest) -> Network:
    """A template all of whose edges are straight."""
    template = bundled(request.param)
    ends = template.positions[template.edges]
    chords = np.repeat((ends[:, 1] - ends[:, 0])[:, None], 2, axis=1)
    return Network(template, template.positions, chords)


def names_of_posts(template: Template) -> list[str]:
    corner = "S5.R" if template.id == "sedan" else "S6.R"
    return ["S1.R-B1.R", f"B5.R-{corner}", "S2.R-B2.R", "S3.R-B3.R", "S4.R-B4.R"]


def test_posts_rise_from_the_sill_to_the_waistline(flat: Network) -> None:
    names = flat.template.edge_names
    assert sorted(names[edge] for edge, _ in posts(flat)) == sorted(names_of_posts(flat.template))


def test_middles_stand_out_by_what_is_asked(flat: Network) -> None:
    made = pull_out_panels(flat, panel=25.0, corner=70.0)
    for number, name in enumerate(names_of_posts(flat.template)):
        edge = edge_called(flat.template, name)
        before, after = (curve(n.control_points[edge], 3)[1] for n in (flat, made))
        out = after - before
        assert np.linalg.norm(out) == pytest.approx(70.0 if number < 2 else 25.0)
        assert abs(out @ (flat.ends[edge, 1] - flat.ends[edge, 0])) < 1e-6
        assert out[1] > 0  # away from the middle of the car
        assert number >= 2 or out[0] * (before[0] - 2300.0) > 0  # and towards nose or tail
    assert np.array_equal(made.positions, flat.positions)
    assert symmetric(made)
    assert np.array_equal(pull_out_panels(made, panel=25.0, corner=70.0).tangents, made.tangents)
    others = [flat.template.edge_names[e] for e in np.flatnonzero(
        (made.tangents != flat.tangents).any(axis=(1, 2)))]  # fmt: skip
    assert {name.replace(".L", ".R") for name in others} == set(names_of_posts(flat.template))


def test_what_stands_out_farther_stays() -> None:
    sedan = bundled("sedan")
    edge = edge_called(sedan, "S3.R-B3.R")
    network = Network.of(sedan)
    way = np.array([0.0, 400.0, 0.0])
    far = with_tangents(
        network,
        {(edge, 0): network.tangents[edge, 0] + way, (edge, 1): network.tangents[edge, 1] - way},
    )
    assert np.array_equal(pull_out_panels(far).tangents[edge], far.tangents[edge])


def test_nodes_in_one_place_do_no_harm() -> None:
    sedan = bundled("sedan")
    positions = np.array(sedan.positions)
    for side in "RL":
        positions[sedan.node[f"B3.{side}"]] = positions[sedan.node[f"S3.{side}"]]
    made = pull_out_panels(Network.of(sedan, positions))
    assert np.isfinite(made.tangents).all()
