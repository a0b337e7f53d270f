"""What a touch and a rub mean: nodes before edges, what is seen before what is hidden."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto_car.template.loader import bundled
from bozzetto_car.template.network import Network, edge_called
from bozzetto_car.view.picking import edges_under, touched
from tests.plugins.car.traced_car import SEEN, drawn, view

NETWORK = Network.of(bundled("sedan"))
CAMERA = view(50.0, 12.0)


def at(name: str) -> np.ndarray:
    return CAMERA.project(NETWORK.positions[NETWORK.template.node[name]])[0][0]


def test_nodes_and_edges_are_met_within_their_reach() -> None:
    assert touched(NETWORK, at("S3.R") + 9.0, CAMERA) == "S3.R"
    for name in SEEN:
        path = drawn(CAMERA, NETWORK.control_points[edge_called(NETWORK.template, name)], 81)
        middle, way = path[40], path[41] - path[40]
        across = np.array([-way[1], way[0]]) / np.linalg.norm(way)
        assert touched(NETWORK, middle + 3.0 * across, CAMERA) == name
    assert touched(NETWORK, (5.0, 5.0), CAMERA) == ""
    assert touched(NETWORK, (1e9, -1e9), CAMERA) == ""


def test_from_the_side_the_near_node_is_meant() -> None:
    for azimuth, side in ((90.0, "R"), (-90.0, "L")):
        camera = view(azimuth, 0.0, "orthographic")
        for name in ("S2", "S3", "R2"):
            number = NETWORK.template.node[f"{name}.R"]
            place = camera.project(NETWORK.positions[number])[0][0]
            assert touched(NETWORK, place, camera) == f"{name}.{side}"


def test_a_rub_means_what_it_runs_along_and_not_what_it_crosses() -> None:
    for name in SEEN:
        edge = edge_called(NETWORK.template, name)
        path = drawn(CAMERA, NETWORK.control_points[edge])
        assert edge in edges_under(NETWORK, path, CAMERA)
    post = drawn(CAMERA, NETWORK.control_points[edge_called(NETWORK.template, "S3.R-B3.R")])
    crossing = np.linspace(post[40] - (140.0, 20.0), post[40] + (140.0, 20.0), 30)
    names = [NETWORK.template.edge_names[e] for e in edges_under(NETWORK, post, CAMERA)]
    assert "S3.R-S2.R" not in names
    assert len(edges_under(NETWORK, crossing + np.array([0.0, 3000.0]), CAMERA)) == 0


def test_a_car_behind_the_eye_is_not_met() -> None:
    eye = np.array(CAMERA.eye)
    away = tuple((2.0 * eye - np.array(CAMERA.target)).tolist())
    camera = replace(CAMERA, target=away)
    assert touched(NETWORK, (600.0, 400.0), camera) == ""
    assert edges_under(NETWORK, [[0.0, 0.0], [900.0, 500.0]], camera) == []
