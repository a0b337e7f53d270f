"""The body: dimensions, edits in the world in which they were made, smooth surfaces, memory."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry.patches.patch import grid
from bozzetto.plugin import Context, Ink
from bozzetto_car.body import deformed, edit_row, reshaped
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import body_of
from bozzetto_car.body.drag_preview import body_at_rest_of, preview_of
from bozzetto_car.marks_file import car_from_facts
from bozzetto_car.solver import pipeline as pipeline_module
from bozzetto_car.state import BentEdge, CarState, MovedNode, Treatment
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.network import edge_called, junctions
from bozzetto_car.tools.trace_edges import TraceEdges
from bozzetto_car.view.scene import scene_of
from tests.plugins.car.drawn_cars import drawn
from tests.plugins.car.marked_car import (
    another,
    apart,
    locked_creases,
    marked,
    pen,
    with_mark_moved,
)
from tests.plugins.car.traced_car import symmetric, view

CAMERA = view(50.0, 10.0)

WISHES = {
    "length": 4710.0,
    "width": 1822.0,
    "height": 1431.0,
    "front_overhang": 871.0,
    "wheelbase": 2788.0,
}


def traced(state: CarState, name: str, seed: int = 1, share: float = 0.06) -> CarState:
    stroke = pen(CAMERA, another(body_of(state), name, seed, share))
    return TraceEdges().apply(state, Ink((stroke,)), Context())


def points_of(body: Body, name: str) -> np.ndarray:
    return body.network.control_points[edge_called(body.template, name)]


def sampled(body: Body) -> dict[str, float]:
    """Dimensions from many places on the surface: never more than the true ones."""
    at = np.linspace(0.0, 1.0, 161)
    places = grid(body.nets, at, at).reshape(-1, 3)
    front, rear = body.network.positions[body.template.wheels[:, 0], 0]
    low, high = places.min(axis=0), places.max(axis=0)
    return {
        "length": high[0] - low[0],
        "width": high[1] - low[1],
        "height": high[2],
        "front_overhang": front - low[0],
        "wheelbase": rear - front,
    }


def unsmooth(body: Body) -> float:
    """The largest angle, rad, between the tangents in a joint of a chain."""
    worst, tangents = 0.0, body.network.tangents
    for joint in junctions(body.template):
        one, other = (
            sense * tangents[place]
            for sense, place in zip(joint.senses, (joint.before, joint.after), strict=True)
        )
        sine = np.linalg.norm(np.cross(one, other))
        worst = max(worst, float(np.arctan2(sine, one @ other)))
    return worst


# -- dimensions ------------------------------------------------------------------------------------


@pytest.mark.parametrize("locked", [False, True])
@pytest.mark.parametrize("name", ["sedan", "hatchback", "minivan"])
def test_dimensions_are_those_of_the_surface(name: str, locked: bool) -> None:
    state = marked(4, name)
    state = traced(state, "S3.R-S2.R")
    own = body_of(state).dimensions.given()
    wanted = {word: value * (1.02 if word != "height" else 0.97) for word, value in own.items()}
    body = body_of(replace(state, lock=locked, **wanted))
    assert body.dimensions_problem == ""
    for word, value in body.dimensions.given().items():
        assert abs(value - wanted[word]) <= 1e-6
    for word, value in sampled(body).items():
        assert wanted[word] - 0.5 < value < wanted[word] + 1e-6 or word == "front_overhang"
    assert symmetric(body.network)
    assert unsmooth(body) < 1e-9
    assert locked_creases(body).max() <= 0.1


def test_the_order_of_typing_makes_no_difference_and_twice_is_once() -> None:
    start = traced(marked(5), "C1-C2")
    found = []
    for row in [*permutations(WISHES)][::17]:
        state = start
        for word in row:
            state = replace(state, **{word: WISHES[word]})
            body_of(state)
        found.append(body_of(state).network)
    for network in found:
        assert np.array_equal(network.control_points, found[0].control_points)
    again = body_of(replace(start, **WISHES, lock=False))
    same = body_of(replace(start, **again.dimensions.given()))
    assert np.abs(same.network.control_points - found[0].control_points).max() < 1e-5


def test_a_body_that_has_its_dimensions_is_left_alone() -> None:
    state = traced(marked(5), "C1-C2")
    own = body_of(state)
    kept = body_of(replace(state, **own.dimensions.given()))
    assert np.array_equal(kept.network.control_points, own.network.control_points)


def test_wheels_keep_their_radius() -> None:
    state = marked(6)
    before = body_of(state)
    after = body_of(replace(state, **{**WISHES, "height": 1700.0}))
    wheels = before.template.wheels.ravel()
    assert np.array_equal(after.network.positions[wheels, 2], before.network.positions[wheels, 2])


@pytest.mark.parametrize("locked", [False, True])
def test_what_would_fold_the_body_is_told_and_it_stays(locked: bool) -> None:
    state = marked(6)
    plain = body_of(state)
    wrong = replace(state, length=4600.0, front_overhang=300.0, wheelbase=4000.0, lock=locked)
    body = body_of(wrong)
    assert body.dimensions_problem
    assert np.array_equal(body.network.control_points, plain.network.control_points)
    if not locked:
        assert "Choose" in body.dimensions_problem
        # The range that is told can be had.
        most = float(body.dimensions_problem.split("wheelbase from")[1].split(" to ")[1].split()[0])
        assert body_of(replace(wrong, wheelbase=most)).dimensions_problem == ""


def test_locked_the_solve_itself_has_them() -> None:
    state = replace(marked(7), lock=True, length=4700.0, wheelbase=2800.0)
    solved = body_of(state).solved
    loose = body_of(replace(state, lock=False)).solved
    front, rear = solved.positions[solved.template.wheels[:, 0], 0]
    assert rear - front == pytest.approx(2800.0, abs=1e-6)
    front, rear = loose.positions[loose.template.wheels[:, 0], 0]
    assert abs(rear - front - 2800.0) > 1.0


# -- edits in their world --------------------------------------------------------------------------


def _lift(points: np.ndarray) -> np.ndarray:
    """How high the handles of an edge stand over its chord."""
    return np.asarray((points - np.linspace(points[0], points[3], 4))[1:3, 2])


def test_traced_then_stretched_then_stretched_again() -> None:
    """An edge keeps its place between its nodes, whatever the length."""
    start = marked(8)
    drawn_ = traced(start, "C1-C2", share=0.15)
    for length in (0.0, 4400.0, 4900.0):
        with_, without = (body_of(replace(one, length=length)) for one in (drawn_, start))
        gap = with_.network.positions - without.network.positions
        assert np.abs(gap).max() < 1e-6 or length  # nodes stay where they are as drawn
        lifts = [_lift(points_of(body, "C1-C2")) for body in (with_, without)]
        assert np.abs(lifts[0] - lifts[1]).max() > 10.0
        if not length:
            plain = lifts[0]
        assert np.allclose(lifts[0], plain, atol=1e-6)  # a length changes no height


@pytest.mark.parametrize("name", ["C1-C2", "S3.R-S2.R", "S3.R-B3.R", "R2.R-R1.R"])
def test_traced_under_dimensions_an_edge_is_where_it_was_drawn(name: str) -> None:
    start = replace(marked(8), **WISHES)
    aim = another(body_of(start), name, 3)
    state = TraceEdges().apply(start, Ink((pen(CAMERA, aim),)), Context())
    assert state.edits[-1].dimensions == start.dimensions
    body = body_of(state)
    for word, value in body.dimensions.given().items():
        assert abs(value - WISHES[word]) <= 1e-6
    assert apart(CAMERA, points_of(body, name), aim) < 2.0
    assert locked_creases(body).max() <= 0.1
    assert unsmooth(body) < 1e-9
    # Back as drawn: nothing is left of the dimensions but on what was traced.
    plain = replace(state, **dict.fromkeys(WISHES, 0.0))
    one, other = body_of(plain), body_of(replace(plain, edits=()))
    assert np.array_equal(one.network.positions, other.network.positions)
    near = [joint.node for joint in junctions(one.template)]
    assert near
    same = (one.network.tangents == other.network.tangents).all(axis=(1, 2))
    assert same.mean() > 0.4
    assert unsmooth(one) < 1e-9
    # And to the same dimensions again: the same body.
    again = body_of(replace(plain, **WISHES))
    assert np.array_equal(again.network.control_points, body.network.control_points)


def test_edits_of_several_worlds_do_not_wear_the_body_out() -> None:
    """Forty edits that say nothing, under dimensions that come and go, change nothing."""
    state = marked(9)
    start = body_of(state).network
    edits = []
    for number in range(40):
        wanted = replace(state, **WISHES).dimensions if number % 2 else state.dimensions
        edits.append(MovedNode(wanted, "S3.R", (0.0, 0.0, 0.0)))
    made = body_of(replace(state, edits=tuple(edits))).network
    assert np.array_equal(made.control_points, start.control_points)


def test_moves_of_nodes_and_wheels_in_another_world_are_taken_back_exactly() -> None:
    state = replace(marked(9), **WISHES)
    before = body_of(state)
    for node in ("R2.R", "C2", "WR.R"):  # none of them is the highest: the height is given
        by = (12.0, 0.0 if node == "C2" else 7.0, 5.0)
        moved = body_of(replace(state, edits=(MovedNode(state.dimensions, node, by),)))
        number = before.template.node[node]
        way = moved.network.positions[number] - before.network.positions[number]
        if node == "WR.R":  # the wheelbase is given: the body gives way, and the wheel is lifted
            assert way[2] == pytest.approx(5.0)
        else:
            assert np.abs(way - by).max() < 1e-6
        assert symmetric(moved.network)


def test_dimensions_of_an_edit_that_cannot_be_any_more_are_told() -> None:
    impossible = replace(CarState(), length=4600.0, wheelbase=4400.0).dimensions
    state = replace(marked(), edits=(Treatment(impossible, "anneal"),))
    (trouble,) = body_of(state).troubles
    assert "Choose" in trouble.message


# -- smooth surfaces -------------------------------------------------------------------------------


def test_surfaces_stay_smooth_through_every_kind_of_edit() -> None:
    state = marked(10)
    edits = (
        Treatment(kind="reduce"),
        BentEdge(edge="S3.R-S2.R", end=0, tangent=(-400.0, -60.0, 90.0)),
        Treatment(kind="pull out"),
        MovedNode(node="R2.R", by=(40.0, 10.0, -15.0)),
        Treatment(kind="anneal"),
        BentEdge(edge="B3.R-B2.R", end=1, tangent=(-700.0, 30.0, 20.0)),
        Treatment(kind="reduce"),
    )
    for count in range(len(edits) + 1):
        body = body_of(replace(state, edits=edits[:count]))
        assert not body.troubles
        assert locked_creases(body).max() <= 0.1
        assert unsmooth(body) < 1e-9
        assert symmetric(body.network)
    loose = [
        locked_creases(body_of(replace(state, edits=edits[:count], smooth=False))).max()
        for count in range(1, len(edits) + 1)
    ]
    assert max(loose) > 0.5  # without the lock they would not be


def test_a_bent_edge_keeps_its_tangent_and_its_neighbour_gives_way() -> None:
    tangent = (-420.0, -70.0, 110.0)
    body = body_of(replace(CarState(), edits=(BentEdge(edge="S3.R-S2.R", end=0, tangent=tangent),)))
    found = body.network.tangents[edge_called(body.template, "S3.R-S2.R"), 0]
    assert np.linalg.norm(found - tangent) < 1e-3 * np.linalg.norm(tangent)


def test_edits_that_name_what_there_is_not_are_told() -> None:
    edits = (MovedNode(node="Q7"), BentEdge(edge="A-B"), MovedNode(node="C3", by=(0.0, 0.0, 9.0)))
    body = body_of(replace(CarState(), edits=edits))
    assert [trouble.number for trouble in body.troubles] == [0, 1]
    assert body.network.positions[body.template.node["C3"], 2] == pytest.approx(
        body.template.positions[body.template.node["C3"], 2] + 9.0
    )


# -- memory ----------------------------------------------------------------------------------------


def test_a_look_computes_nothing_again(monkeypatch: pytest.MonkeyPatch) -> None:
    state = traced(replace(marked(11), **WISHES), "C1-C2")
    body = body_of(state)
    first = {layer.name: layer for layer in scene_of(state, body).layers}

    def never(*_: object, **__: object) -> None:
        raise AssertionError("computed again")

    for module, name in (
        (edit_row, "trace_all"),
        (edit_row, "lock_ratios"),
        (reshaped, "reshaping_of"),
        (deformed, "lock_ratios"),
    ):
        monkeypatch.setattr(module, name, never)
    for look in (
        {"shading": "zebra"}, {"creases": True}, {"network": False}, {"revealed": "C3"},
        {"asked": "C4"}, {"wheels": False}, {"body": False},
    ):  # fmt: skip
        assert body_of(replace(state, **look)) is body
    again = {layer.name: layer for layer in scene_of(replace(state, creases=True), body).layers}
    for name in ("body", "wheels"):
        assert again[name].revision == first[name].revision


def test_while_a_mark_is_dragged_edits_are_carried_along() -> None:
    state = marked(12)
    side = "L" if state.sketches[0].mark_of("S1.L") else "R"
    for number, name in enumerate(("C1-C2", f"S3.{side}-S2.{side}", f"B3.{side}-B2.{side}")):
        body = body_of(state)
        stroke = pen(body.sketch_cameras["1"].view((1200.0, 800.0)), another(body, name, number))
        state = TraceEdges().apply(state, Ink((stroke,)), Context())
    later = with_mark_moved(state, f"S1.{side}", (2.0, 1.0))
    carried, exact = body_of(later, state), body_of(later)
    gap = carried.network.control_points - exact.network.control_points
    plain = body_of(replace(later, edits=()))
    change = exact.network.control_points - plain.network.control_points
    assert symmetric(carried.network)
    assert 0.0 < np.sqrt((gap**2).mean()) < 0.5 * np.sqrt((change**2).mean())


@pytest.mark.parametrize(("share", "left"), [(0.25, 0.5), (0.6, 1.0)])
def test_while_a_share_of_templates_is_dragged_edits_are_carried_along(
    share: float, left: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = replace(traced(marked(13), "C1-C2"), blend="limousine", share=0.2)
    preview_of(state)
    later = replace(state, share=share)
    plain = body_of(replace(later, edits=()))
    with monkeypatch.context() as context:
        context.setattr(edit_row, "trace_all", None)
        carried = preview_of(later)
    exact = body_of(later)
    assert carried.template is exact.template
    assert symmetric(carried.network)
    gap, change = (
        exact.network.control_points - one.network.control_points for one in (carried, plain)
    )
    assert 0.0 < np.sqrt((gap**2).mean()) < left * np.sqrt((change**2).mean())


@pytest.mark.parametrize("field", ["trace", "share"])
def test_a_kept_dimension_is_solved_for_while_something_else_is_dragged(field: str) -> None:
    """What is shown at the release is what was shown before it."""
    template = bundled("hatchback")
    start = replace(
        traced(marked(14, "hatchback"), "C1-C2"),
        blend="minivan", share=0.3, lock=True,
        wheelbase=0.94 * float(np.ptp(template.positions[template.wheels[:, 0], 0])),
    )  # fmt: skip
    body_at_rest_of(start)
    later = replace(start, **{field: 0.5})
    shown, exact = preview_of(later), body_of(later)
    stretched = body_of(replace(later, lock=False))
    gap, jump = (
        float(np.abs(one.network.positions - exact.network.positions).max())
        for one in (shown, stretched)
    )
    assert gap < 0.1 * jump
    assert shown.dimensions.wheelbase == pytest.approx(start.wheelbase, abs=1e-6)


def test_a_kept_dimension_that_is_dragged_is_stretched_to(monkeypatch: pytest.MonkeyPatch) -> None:
    start = replace(traced(marked(15), "C1-C2"), lock=True, length=4600.0)
    body_at_rest_of(start)
    preview_of(replace(start, length=4610.0))
    with monkeypatch.context() as context:
        context.setattr(pipeline_module, "solve", None)
        shown = preview_of(replace(start, length=4700.0))
    assert shown.dimensions.length == pytest.approx(4700.0, abs=1e-6)


def test_strokes_are_fitted_once_while_a_dimension_is_dragged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A body that is only stretched to its dimensions is the same before it is stretched."""
    state = marked(16)
    body = body_of(state)
    stroke = pen(body.sketch_cameras["1"].view((1200.0, 800.0)), another(body, "C1-C2", 3))
    start = TraceEdges().apply(state, Ink((stroke,)), Context())
    at_rest = body_at_rest_of(start)
    with monkeypatch.context() as context:
        context.setattr(edit_row, "trace_all", None)
        shown = preview_of(replace(start, length=4700.0))
        exact = body_at_rest_of(replace(start, length=4700.0))
    assert shown.dimensions.length == pytest.approx(4700.0, abs=1e-6)
    assert (shown.network.control_points == exact.network.control_points).all()
    layers = {
        body: {layer.name for layer in scene_of(start, body).layers}
        for body in (at_rest, shown, exact)
    }
    assert "strokes" in layers[at_rest] & layers[exact]
    assert layers[at_rest] - layers[shown] == {"strokes"}


@pytest.mark.parametrize("name", ["sedan", "suv", "van"])
@pytest.mark.parametrize("node", ["C3", "S4"])
def test_what_was_traced_on_a_sketch_stays_on_it_while_a_mark_is_dragged(
    name: str, node: str
) -> None:
    """The camera moves with the marks; an edge on a stroke is seen where the stroke is."""
    state = car_from_facts(drawn(bundled(name), 41, hand=1.0).marks_file(), {})
    sketch = state.sketches[0]
    (moved, *_) = [mark.node for mark in sketch.marks if mark.node.partition(".")[0] == node]
    later = with_mark_moved(state, moved, (-5.0, 7.0))
    carried, exact, still = body_of(later, state), body_of(later), body_of(state)
    assert carried.network is not exact.network
    assert symmetric(carried.network)
    pixels = carried.sketch_cameras[sketch.id].pixels
    gaps = [
        np.linalg.norm(
            pixels(body.network.control_points.reshape(-1, 3))
            - pixels(exact.network.control_points.reshape(-1, 3)),
            axis=1,
        )
        for body in (carried, still)
    ]
    frame, standing = (float(np.sqrt((gap**2).mean())) for gap in gaps)
    assert frame <= 1.0
    assert frame < 0.5 * standing


def handles_per_chord(body: Body) -> np.ndarray:
    points = body.network.control_points
    legs = np.linalg.norm(points[:, [1, 2]] - points[:, [0, 3]], axis=2).max(axis=1)
    return np.asarray(legs / np.linalg.norm(points[:, 3] - points[:, 0], axis=1))


def in_space(seed: int, name: str, state: CarState) -> CarState:
    """A car with six edges traced in views beside its sketch."""
    rng = np.random.default_rng(seed)
    own = [edge for edge in bundled(name).edge_names if ".L" not in edge]
    while len(state.edits) < 6:
        camera = view(rng.uniform(20.0, 160.0), rng.uniform(3.0, 25.0))
        edge = another(body_of(state), own[rng.integers(len(own))], int(rng.integers(1 << 30)))
        try:
            state = TraceEdges().apply(state, Ink((pen(camera, edge),)), Context())
        except UserError:  # it is seen end-on from there
            continue
    return state


@pytest.mark.slow
@pytest.mark.parametrize("drawn", ["as it is", "kept", "stretched"])
@pytest.mark.parametrize(
    ("seed", "name"), [(8_200, "sedan"), (8_201, "van"), (8_202, "city_car"), (8_203, "minivan")]
)
def test_what_was_drawn_in_space_goes_along_with_a_kept_length(
    seed: int, name: str, drawn: str
) -> None:
    """Strokes stayed in space while the car got another length: they went round in loops of metres,
    and a millionth of a pixel moved the body by up to 70 cm."""
    state = marked(seed, name)
    length = body_of(state).dimensions.length
    assert length is not None
    if drawn != "as it is":
        state = replace(state, lock=drawn == "kept", length=0.97 * length)
    state = in_space(seed, name, state)
    before = handles_per_chord(body_of(state)).max()
    node = state.sketches[0].marks[2].node
    for share, lock in ((0.9, True), (0.95, True), (1.05, True), (1.1, True), (0.95, False)):
        kept = replace(state, lock=lock, length=share * length)
        body = body_of(kept)
        assert not body.troubles
        assert handles_per_chord(body).max() < 1.2 * before
        nudged = body_of(with_mark_moved(kept, node, (1e-6, 0.0)))
        off = np.abs(nudged.network.control_points - body.network.control_points)
        assert off.max() < 1e-3


@pytest.mark.parametrize("name", ["sedan", "suv"])
def test_kept_the_dimensions_that_it_has_a_car_keeps_what_was_drawn_in_space(name: str) -> None:
    state = in_space(8_300, name, marked(8_300, name))
    free = body_of(state)
    bare = replace(state, edits=())
    kept = replace(bare, lock=True, length=body_of(bare).dimensions.length)
    node = MovedNode(node="C3", by=(0.0, 0.0, 40.0))
    moved, still = body_of(replace(kept, edits=(node,))), body_of(kept)
    at = free.template.node["C3"]
    assert moved.network.positions[at, 2] - still.network.positions[at, 2] == pytest.approx(
        40.0, rel=0.02
    )
    same = body_of(replace(kept, edits=state.edits))
    off = np.linalg.norm(same.network.tangents - free.network.tangents, axis=2)
    assert np.median(off) < 10.0
