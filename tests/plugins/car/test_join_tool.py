"""Lines made sharp and smooth by a touch, and lines with one curvature."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Ink, Tap
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import body_of
from bozzetto_car.commands import car_as_template
from bozzetto_car.modeler import Car
from bozzetto_car.state import CarState
from bozzetto_car.template.line_joints import is_smooth, lines_at, with_joints
from bozzetto_car.template.loader import TEMPLATES, bundled, read_template
from bozzetto_car.template.network import edge_called
from bozzetto_car.tools.join_lines import JoinLines
from bozzetto_car.tools.trace_edges import TraceEdges
from bozzetto_car.view.joint_items import joint_layer
from tests.plugins.car.marked_car import another, marked, pen, with_mark_moved
from tests.plugins.car.traced_car import curve, symmetric, view

Array = NDArray[np.float64]

TOOL = JoinLines()
CAMERA = view(55.0, 14.0)


def touched(state: CarState, name: str, camera: Camera = CAMERA) -> CarState:
    """A touch on a node, or on the middle of an edge."""
    body = body_of(state)
    if "-" in name:
        edge = edge_called(body.template, name)
        place = curve(body.network.control_points[edge], 3)[1]
    else:
        place = body.network.positions[body.template.node[name]]
    x, y = camera.project(place[None])[0][0].tolist()
    return TOOL.apply(state, Tap(x, y, camera), Context())


def turn(body: Body, before: str, node: str, after: str) -> float:
    """Angle, degrees, by which a line turns at a node."""
    template, points = body.template, body.network.control_points
    legs = []
    for other in (before, after):
        edge = edge_called(template, f"{node}-{other}")
        own = points[edge] if template.edge_names[edge].startswith(f"{node}-") else (
            points[edge][::-1]
        )  # fmt: skip
        legs.append(own[1] - own[0])
    back, ahead = -legs[0], legs[1]
    return float(np.degrees(np.arctan2(np.linalg.norm(np.cross(back, ahead)), back @ ahead)))


def bends(body: Body, before: str, node: str, after: str) -> tuple[Array, Array]:
    """Curvature vectors, 1/mm, on both sides of a node of a line."""
    found = []
    for other in (before, after):
        edge = edge_called(body.template, f"{node}-{other}")
        own = body.network.control_points[edge]
        if not body.template.edge_names[edge].startswith(f"{node}-"):
            own = own[::-1]
        speed, second = 3.0 * (own[1] - own[0]), 6.0 * (own[2] - 2.0 * own[1] + own[0])
        pace = np.linalg.norm(speed)
        found.append((second - (second @ speed) / pace**2 * speed) / pace**2)
    return found[0], found[1]


@pytest.mark.parametrize("name", TEMPLATES)
def test_touches_on_a_node_go_through_all_ways_and_come_back(name: str) -> None:
    template, state = bundled(name), CarState(template=name)
    for node in (*template.centre.tolist(), *template.pairs[:, 0].tolist()):
        lines = lines_at(template, node)
        seen = set()
        for _ in range(2 ** len(lines) if lines else 0):
            hint = template.pictures[template.names[node]]
            state = touched(state, template.names[node], view(hint.azimuth, hint.elevation))
            seen.add(tuple(is_smooth(with_joints(template, state.joints), line) for line in lines))
        assert len(seen) == (2 ** len(lines) if lines else 0)
        assert state.joints == ()


def test_at_a_sharp_joint_the_neighbour_of_a_traced_edge_stays() -> None:
    plain = marked(4)
    for state, is_sharp in ((plain, False), (touched(plain, "S3.R"), True)):
        body = body_of(state)
        stroke = pen(CAMERA, another(body, "S3.R-S2.R", 3))
        made = body_of(TraceEdges().apply(state, Ink((stroke,)), Context()))
        turns = turn(made, "S2.R", "S3.R", "S4.R")
        other = edge_called(body.template, "S4.R-S3.R")
        way = [b.network.tangents[other, 1] / np.linalg.norm(b.network.tangents[other, 1])
               for b in (body, made)]  # fmt: skip
        assert (turns > 0.5) == is_sharp
        assert np.allclose(way[0], way[1], atol=1e-12) == is_sharp
        assert symmetric(made.network)


def test_a_joint_that_was_made_smooth_stays_so_when_lines_are_traced_and_marks_moved() -> None:
    state = marked(4)
    assert turn(body_of(state), "C0", "C1", "C2") > 10.0
    state = touched(state, "C1")
    assert turn(body_of(state), "C0", "C1", "C2") < 1e-6
    camera = view(50.0, 10.0)
    for seed, edge in enumerate(("C1-C2", "C0-C1")):
        stroke = pen(camera, another(body_of(state), edge, seed))
        state = TraceEdges().apply(state, Ink((stroke,)), Context())
        assert turn(body_of(state), "C0", "C1", "C2") < 1e-6
    node = state.sketches[0].marks[2].node
    assert turn(body_of(with_mark_moved(state, node, (6.0, -4.0))), "C0", "C1", "C2") < 1e-6
    assert turn(body_of(replace(state, edits=())), "C0", "C1", "C2") < 1e-6


def test_the_other_side_of_the_car_is_touched_alike() -> None:
    state = CarState()
    assert touched(state, "S3.R").joints == touched(state, "S3.L", view(-55.0, 14.0)).joints


def test_a_line_along_a_touched_edge_has_one_curvature_and_keeps_it() -> None:
    state = marked(6)
    names = ("S1.R", "S2.R", "S3.R", "S4.R", "S5.R")
    triples = [*zip(names, names[1:], names[2:], strict=False)]

    def jump(of: CarState) -> float:
        body = body_of(of)
        ratios = []
        for triple in triples:
            one, other = bends(body, *triple)
            whole = np.linalg.norm(one) + np.linalg.norm(other)
            ratios.append(float(np.linalg.norm(one - other) / whole))
        return max(ratios)

    even = touched(state, "S3.R-S2.R")
    assert len(even.flowing) == 1
    assert jump(even) < 1e-3
    camera = view(60.0, 12.0)
    stroke = pen(camera, another(body_of(even), "S4.R-S3.R", 2))
    assert jump(TraceEdges().apply(even, Ink((stroke,)), Context())) < 1e-3
    node = state.sketches[0].marks[3].node
    assert jump(with_mark_moved(even, node, (5.0, 5.0))) < 1e-3
    assert jump(replace(even, length=4900.0)) < 1e-3
    assert symmetric(body_of(even).network)
    back = touched(even, "S4.R-S3.R")
    assert back.flowing == ()
    assert np.array_equal(body_of(back).network.tangents, body_of(state).network.tangents)


def test_what_cannot_be_is_told() -> None:
    with pytest.raises(UserError, match="Nothing is touched"):
        TOOL.apply(CarState(), Tap(3.0, 3.0, CAMERA), Context())
    with pytest.raises(UserError, match="A-pillar, head: no line runs"):
        touched(CarState(), "R1.R")
    with pytest.raises(UserError, match="smoothly at neither end"):
        touched(CarState(), "S2.R-B2.R")


def test_wishes_of_another_template_are_left_out_and_come_back() -> None:
    state = touched(CarState(template="hatchback"), "S4.R")
    other = replace(state, template="sedan")
    assert body_of(other).template.chains == bundled("sedan").chains
    assert body_of(replace(other, template="hatchback")).template.chains != (
        bundled("hatchback").chains
    )


@pytest.mark.parametrize("name", ["sedan", "hatchback", "van"])
def test_a_car_with_other_joints_can_be_saved_as_a_template(name: str) -> None:
    template = bundled(name)
    for node in ("C1", "C4", "S3.R", "B3.R"):
        state = touched(CarState(template=name), node)
        saved = read_template(car_as_template(state, "Mine"))
        wished = with_joints(template, state.joints)
        for line in lines_at(template, template.node[node]):
            assert is_smooth(saved, line) == is_smooth(wished, line)


def test_the_sheet_shows_every_line_where_it_passes_a_node() -> None:
    state = CarState()
    template = bundled("sedan")
    right = (*template.centre.tolist(), *template.pairs[:, 0].tolist())
    count = sum(len(lines_at(template, node)) for node in right)
    before, after = (joint_layer(one, body_of(one)) for one in (state, touched(state, "S3.R")))
    for layer, sharp in ((before, 4), (after, 5)):
        shown = {item.color: len([*item.pieces()]) for item in layer.items}
        assert shown == {"accent": 2 * (count - sharp), "warning": 2 * sharp}
    assert before.tool == TOOL.id
    assert TOOL.id in {tool.id for tool in Car().tools()}
    flowing = touched(state, "S3.R-S2.R")
    words = [item.text for item in joint_layer(flowing, body_of(flowing)).items
             if hasattr(item, "text")]  # fmt: skip
    assert words == ["G2"]


def test_all_edits_are_taken_back_with_the_joints() -> None:
    state = touched(touched(marked(4), "C1"), "S3.R-S2.R")
    command = next(own for own in Car().commands() if own.id == "undo-edits")
    assert command.enabled(state)
    back = command.run(state, Context())
    assert (back.edits, back.joints, back.flowing) == ((), (), ())
    assert not command.enabled(back)
