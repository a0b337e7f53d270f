"""Which edges a stroke means, and where it is split."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.ink.curves.nearest import distances_to_polyline
from bozzetto.view import Camera
from bozzetto_car.body.edge_runs import find_run
from bozzetto_car.body.trace_edges import trace
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.network import Network
from tests.plugins.car.traced_car import SEEN, path, view

Array = NDArray[np.float64]
Kind = Literal["perspective", "orthographic"]
KINDS: tuple[Kind, ...] = ("perspective", "orthographic")


def run_names(network: Network, stroke: Array, camera: Camera) -> list[str]:
    run = find_run(network, stroke, camera)
    return [network.template.edge_names[max(edge, ~edge)] for edge in run.edges]


@pytest.mark.parametrize("kind", KINDS)
def test_the_edge_meant_is_found_under_an_unsteady_hand(kind: Kind) -> None:
    rng = np.random.default_rng(1)
    network, camera = Network.of(bundled("sedan")), view(48.0, 14.0, kind)
    for name in SEEN:
        stroke = path(camera, network, [name])
        along = np.linspace(0, np.pi, len(stroke))
        shaken = stroke + 3.0 * np.column_stack(
            [np.cos(k * along + rng.uniform(0, 6)) for k in (1, 2)]
        )
        assert run_names(network, shaken, camera) == [name]


@pytest.mark.parametrize("kind", KINDS)
def test_strokes_over_chains_are_split_at_nodes(kind: Kind) -> None:
    network, camera = Network.of(bundled("sedan")), view(60.0, 14.0, kind)
    for names in (
        ["S1.R-S2.R", "S2.R-S3.R"],
        ["S4.R-S3.R", "S3.R-S2.R", "S2.R-S1.R"],
        ["C1-C2", "C2-C3", "C3-C4"],
        ["B2.R-B3.R", "B3.R-B4.R"],
    ):
        stroke = path(camera, network, names)
        run = find_run(network, stroke, camera)
        tell = network.template.names
        assert [tell[node] for node in run.nodes] == (
            [name.split("-")[0] for name in names] + [names[-1].split("-")[1]]
        )
        for part, name in zip(run.parts, names, strict=True):
            own = path(camera, network, [name])
            assert distances_to_polyline(part, own).max() < 1e-9
            assert np.abs(part[[0, -1]] - own[[0, -1]]).max() < 1e-9
        made = trace(network, stroke, camera)
        assert np.abs(made.network.control_points - network.control_points).max() < 1e-6


def test_hidden_edges_are_not_meant_where_shown_ones_lie_beside_them() -> None:
    network, camera = Network.of(bundled("sedan")), view(90.0, 0.0, "orthographic")
    for name in ("S3.R-S2.R", "B3.R-B2.R"):
        assert run_names(network, path(camera, network, [name]), camera) == [name]
