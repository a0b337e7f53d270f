"""Edges, creases, angles and handles as they are shown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.scene import Handle, Lines
from bozzetto_car.body.build import body_of
from bozzetto_car.camera.visibility import facing
from bozzetto_car.state import BentEdge, CarState
from bozzetto_car.template.network import edge_called
from bozzetto_car.view.edge_items import (
    CREASE_COLORS,
    crease_labels,
    edge_items,
    handle_layer,
    network_lines,
    sources_of,
)
from bozzetto_car.view.scene import view_dependent_scene
from tests.plugins.car.marked_car import locked_creases, marked
from tests.plugins.car.traced_car import curve, view

STATE = marked(1)
BODY = body_of(STATE)


def test_lines_run_along_the_edges() -> None:
    lines = network_lines(BODY.network.control_points, "ink", 1.0)
    pieces = [lines.points[piece] for piece in lines.pieces()]
    assert len(pieces) == len(BODY.template.edges)
    for piece, points in zip(pieces, BODY.network.control_points, strict=True):
        assert np.abs(piece - curve(points, len(piece))).max() < 1e-3


def test_edges_are_sorted_by_how_the_surface_goes_over_them() -> None:
    state = replace(STATE, creases=True, smooth=False)
    rough = replace(state, edits=(BentEdge(edge="S3.R-S2.R", end=1, tangent=(-1900, -90.0, 40.0)),))
    for one, creased in ((replace(state, smooth=True), False), (rough, True)):
        body = body_of(one)
        assert (locked_creases(body).max() > 0.1) == creased
        kinds = {item.color: item for item in edge_items(one, body) if isinstance(item, Lines)}
        assert (CREASE_COLORS["creased"] in kinds) == creased
        shown = sum(len([*item.pieces()]) for item in kinds.values())
        assert shown == len(body.template.edges)
        smooth = len([*kinds[CREASE_COLORS["smooth"]].pieces()])
        assert smooth == int((body.creases < 0.1).sum())


def test_angles_stand_apart_on_the_side_that_is_seen() -> None:
    rim = np.isnan(BODY.creases)
    for azimuth in range(-180, 180, 30):
        camera = view(float(azimuth), 12.0)
        labels = [*crease_labels(BODY, camera)]
        assert labels
        places = camera.project([label.point for label in labels])[0]
        gaps = np.abs(places[:, None] - places)
        close = (gaps[..., 0] < 46.0) & (gaps[..., 1] < 16.0)
        assert close.sum() == len(labels)
        toward = facing(BODY.template, BODY.network.positions, camera)
        middles = np.array([curve(points, 3)[1] for points in BODY.network.control_points])
        for label in labels:
            edge = int(np.linalg.norm(middles - label.point, axis=1).argmin())
            assert not rim[edge]
            assert toward[BODY.template.edges[edge]].all()
            assert float(label.text[:-1]) >= 0.1
            assert abs(float(label.text[:-1]) - BODY.creases[edge]) <= 0.05 + 1e-9


def test_angles_hang_on_the_view_and_are_there_only_if_wanted() -> None:
    camera = view(50.0, 12.0)
    for wanted in (False, True):
        layers = view_dependent_scene(replace(STATE, creases=wanted), BODY, camera).layers
        assert ("angles" in [layer.name for layer in layers]) == wanted


def test_handles_are_those_of_the_side_that_is_seen_in_the_colours_of_nodes() -> None:
    camera = view(50.0, 12.0)
    toward = facing(BODY.template, BODY.network.positions, camera)
    layer = handle_layer(replace(STATE, revealed="C3"), BODY, camera)
    nodes = [i for i in layer.items if isinstance(i, Handle) and i.id.startswith("node ")]
    names = {handle.id.removeprefix("node ") for handle in nodes}
    assert names == {BODY.template.names[n] for n in np.flatnonzero(toward)}
    colors = {handle.id.removeprefix("node "): handle.color for handle in nodes}
    assert colors["C3"] == "accent"
    sources = sources_of(BODY)
    by_source = {
        sources[BODY.template.node[name]]: color for name, color in colors.items() if name != "C3"
    }
    assert len({*by_source.values()}) == len(by_source)


def test_of_an_edge_both_ends_are_revealed() -> None:
    state = CarState(revealed="S3.R-S2.R")
    body = body_of(state)
    layer = handle_layer(state, body)
    ends = [i for i in layer.items if isinstance(i, Handle) and i.id.startswith("tangent ")]
    points = body.network.control_points[edge_called(body.template, "S3.R-S2.R")]
    assert np.array_equal([handle.point for handle in ends], points[1:3])
    assert not [
        i for i in handle_layer(replace(state, revealed="Q-Z"), body).items
        if isinstance(i, Lines)
    ]  # fmt: skip
