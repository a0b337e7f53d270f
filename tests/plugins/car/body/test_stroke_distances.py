"""How far strokes are from the finished body: as the report of a file tells it."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bozzetto.ink import distances_to_polyline
from bozzetto.plugin import Job
from bozzetto_car.body.build import body_of
from bozzetto_car.body.stroke_distances import stroke_distances
from bozzetto_car.marks_file import car_from_facts
from bozzetto_car.report import report_of
from bozzetto_car.state import CarState, MovedNode, TracedEdges
from bozzetto_car.template.loader import PAPER_TEMPLATES
from bozzetto_car.template.network import edge_called
from tests.plugins.car.drawn_cars import GALLERY
from tests.plugins.car.test_drawn_cars import seen_line


def of_gallery(name: str) -> tuple[dict[str, Any], CarState]:
    facts = json.loads((GALLERY / f"{name}.json").read_text("utf-8"))
    for part in (facts, *facts["views"]):
        part.get("image", {}).pop("file", None)
    return facts, car_from_facts(facts, {})


@pytest.mark.slow
@pytest.mark.parametrize("name", PAPER_TEMPLATES)
def test_the_report_tells_of_every_stroke_of_a_file(name: str) -> None:
    facts, state = of_gallery(name)
    views = report_of(body_of(state), state.edits, Job())["views"]
    off = [view["stroke_px"] for view in views]
    assert [{*told} for told in off] == [{*view["strokes"]} for view in facts["views"]]
    every = np.concatenate([[*told.values()] for told in off])
    assert np.median(every) <= 1.0
    assert every.max() <= 2.5


def test_it_is_the_distance_on_the_sketch_and_grows_when_a_node_is_moved() -> None:
    _, state = of_gallery("sedan")
    first = state.edits[0]
    assert isinstance(first, TracedEdges)
    (edge,), sketch = first.edges, first.sketch
    told = []
    for by in (0.0, 60.0, 120.0):
        moved = MovedNode(node=edge.split("-")[0], by=(0.0, 0.0, by))
        edited = replace(state, edits=(first, moved) if by else (first,))
        body = body_of(edited)
        (off,) = stroke_distances(body, edited.edits, sketch).values()
        through = body.sketch_cameras[sketch]
        line = seen_line(
            through.camera, body.network.control_points[edge_called(body.template, edge)], 400
        )
        stroke = first.strokes[0].points - through.shift
        assert (
            off
            <= max(
                distances_to_polyline(stroke, line).max(), distances_to_polyline(line, stroke).max()
            )
            + 0.05
        )
        told.append(off)
    assert told[0] <= 1.0
    assert told[1] >= told[0] + 3.0
    assert told[2] >= told[1] + 3.0


def test_no_strokes_and_strokes_of_another_sketch_are_told_nothing_of() -> None:
    _, state = of_gallery("minivan")
    body = body_of(state)
    assert stroke_distances(body, (), state.sketches[0].id) == {}
    assert stroke_distances(body, state.edits, "nobody") == {}
    views = report_of(replace(body), (), Job())["views"]
    assert all(view["stroke_px"] == {} for view in views)
