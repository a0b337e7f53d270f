"""Drawings of open boxes: flaps are faces of a sheet, and what they hang at is open."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document import Document
from bozzetto.exchange.ink.ink_json import read_drawing
from bozzetto.plugin import Context
from bozzetto.plugin.host.registry import Registry
from bozzetto.workbench.films import frames
from bozzetto.workbench.play_steps import run_steps
from bozzetto.workbench.workbench import Workbench
from bozzetto_polyhedron.graph.line_graph import Finding
from bozzetto_polyhedron.mechanism.analysis import mobility_of
from bozzetto_polyhedron.model.fittings import Hinge
from bozzetto_polyhedron.model.state import Body
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.reconstruction.flaps import without_findings_at_flaps
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.solve.pipeline import solved
from tests.plugins.polyhedron.figures_open_boxes import (
    SIDES,
    face_sets,
    lidded_box,
    open_box,
)
from tests.plugins.polyhedron.objects import (
    CAMERA,
    OBJECTS,
    graph_of,
    in_eye_frame,
    is_right,
    view,
)
from tests.plugins.polyhedron.write_samples import FOLDER


@pytest.mark.parametrize("sides", SIDES)
def test_flaps_are_faces_and_the_rim_is_open(sides):
    for seed in range(80_000, 80_004):
        solid = open_box(seed, sides)
        seen = view(solid, seed)
        graph, _ = graph_of(seen, 0.0, seed)
        first = answers_of(graph, CAMERA)[0]
        assert face_sets(first.faces) == solid.face_sets()
        assert is_right(seen, in_eye_frame(first.vertices, CAMERA), 0.0)
        assert not first.closed


def test_an_unsteady_hand_gets_the_same_faces_and_mostly_the_same_shape():
    """A flap that is seen nearly edge-on is turned about its fold by what the hand is off."""
    right = []
    for seed in range(80_020, 80_032):
        solid = open_box(seed, SIDES[seed % len(SIDES)])
        seen = view(solid, seed)
        graph, _ = graph_of(seen, 0.01, seed)
        first = answers_of(graph, CAMERA)[0]
        assert face_sets(first.faces) == solid.face_sets()
        right.append(is_right(seen, in_eye_frame(first.vertices, CAMERA), 0.01))
    assert np.mean(right) >= 0.75


def test_a_lid_leaves_the_face_open_that_it_covers():
    for seed in range(80_010, 80_014):
        solid = lidded_box(seed)
        graph, _ = graph_of(view(solid, seed), 0.0, seed)
        assert face_sets(answers_of(graph, CAMERA)[0].faces) == solid.face_sets()


def test_what_is_no_box_with_flaps_is_read_as_before():
    """A line that was forgotten makes corners of two lines, too; no flap hangs at them."""
    seen = view(OBJECTS["box"], 7)
    graph, _ = graph_of(seen, 0.0, 7)
    less = replace(graph, lines=graph.lines[1:], light=graph.light[1:], strokes=graph.strokes[1:])
    assert np.isfinite(answers_of(less, CAMERA)[0].vertices).all()
    whole = answers_of(graph, CAMERA)[0]
    assert whole.closed
    assert len(whole.faces) == 6


def test_health_asks_for_lines_that_are_missing_and_not_at_flaps():
    solid = open_box(80_040, (0, 2))
    graph, _ = graph_of(view(solid, 80_040), 0.0, 80_040)
    flap, wall = np.flatnonzero(np.bincount(graph.lines.ravel()) == 2)[:1], graph.lines[0, :1]
    places = [tuple(graph.places[corner].tolist()) for corner in (*flap, *wall)]
    health = tuple(Finding(place, "corner of two lines", "Draw it.") for place in places)
    found = without_findings_at_flaps(replace(graph, health=health))
    assert found.health == health[1:]
    box, _ = graph_of(view(OBJECTS["box"], 7), 0.0, 7)
    asked = replace(box, health=health)
    assert without_findings_at_flaps(asked).health == health


def test_motors_at_the_folds_of_the_sample_shut_its_flaps_while_its_walls_stand():
    bench = Workbench(Registry())
    sample = FOLDER / "folding-box.json"
    drawing = read_drawing(sample.read_bytes(), sample.name)
    model = bench.create("bozzetto.polyhedron", Context())
    model = run_steps(bench, model, drawing, Context(camera=drawing.camera))
    state = model.state
    (body,) = state.of_kind(Body)
    assert solved(body, state).graph.health == ()
    assert body.moves == "plates"
    assert {(each.begin.body, each.second) for each in state.of_kind(Hinge)} == {(body.id, body.id)}
    made = moving(state)
    assert mobility_of(made.machine.assembly, made.machine.rest).degrees == 0
    without = replace(state, nodes=(body,))
    free = moving(without).machine
    assert mobility_of(free.assembly, free.rest).degrees == 4
    *_, end = frames(bench, Document((model,)), 1.0, 30.0)
    (shut,) = end
    motion = made.motion(shut.state.moved)
    cosines = 0.5 * (np.trace(motion.turns, axis1=1, axis2=2) - 1.0)
    angles = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
    assert np.sort(angles) == pytest.approx([0.0] * 5 + [65.0] * 4, abs=0.05)
    assert made.stepper.largest_gap(motion) < 1e-5
    flaps = np.argsort(angles)[5:]
    middle = made.machine.rest.places[np.argsort(angles)[:5]].mean(axis=0)
    before, after = (
        np.linalg.norm((each.places[flaps] - middle)[:, :2], axis=1)
        for each in (made.machine.rest, motion)
    )
    assert (after < before).all()


def test_a_solid_that_is_read_from_a_file_stays_where_the_next_steps_touch_it():
    """On an empty sheet it is set on the ground, which no step of a file knows of."""
    bench = Workbench(Registry())
    sample = FOLDER / "folding-box.json"
    drawing = read_drawing(sample.read_bytes(), sample.name)
    drawing = replace(drawing, steps=drawing.steps[:4])
    states = [
        run_steps(bench, bench.create("bozzetto.polyhedron", Context()), drawing, context).state
        for context in (
            Context(camera=drawing.camera),
            Context(camera=drawing.camera, alone=True),
        )
    ]
    assert states[0] == states[1]
