"""Ink of objects, read by other modelers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document import edit
from bozzetto.document.model import Document
from bozzetto.document.waiting_ink import WaitingStroke
from bozzetto.errors import Cancelled, UserError
from bozzetto.exchange.import_file import read_drawing
from bozzetto.geometry import Placement
from bozzetto.plugin import Context, Job
from bozzetto.plugin.host.registry import Registry
from bozzetto.view import Camera
from bozzetto.workbench.workbench import Workbench

SILHOUETTE, SYMMETRY = "bozzetto.silhouette", "bozzetto.symmetry"


@pytest.fixture(scope="module")
def bench():
    return Workbench(Registry())


def sample(bench, modeler, number=0):
    drawing = read_drawing(bench.registry.info(modeler).samples[number], trusted=True)
    return drawing, bench.sources.from_drawing(modeler, drawing, {})


def test_the_ink_is_that_which_was_drawn_with_its_cameras(bench):
    drawing, model = sample(bench, SILHOUETTE, 1)
    ink = bench.readings.drawing_of([model])
    assert [one.digest for one in ink.strokes] == [one.digest for one in drawing.strokes]
    assert ink.camera == drawing.camera
    assert ink.name == model.name


def test_the_ink_goes_where_its_object_goes(bench):
    """Whatever a ray of the ink meets is moved like the object itself."""
    _, model = sample(bench, SILHOUETTE, 1)
    turn = np.radians(40.0)
    cos, sin = float(np.cos(turn)), float(np.sin(turn))
    rows = (cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
    moved = Placement(rows, 1.5, (30.0, -20.0, 5.0))
    (one, *_), (other, *_) = (
        bench.readings.drawing_of([m]).strokes for m in (model, replace(model, placement=moved))
    )
    on = one.camera.on_plane(one.points, (0, 0, 0), (0, 1, 0))
    there = other.camera.project(moved.points(on))[0]
    assert np.abs(there - other.points).max() < 1e-3


def test_hidden_objects_and_parts_have_no_ink(bench):
    _, model = sample(bench, SILHOUETTE, 1)
    (part,) = model.state.nodes
    hidden = replace(model.state, nodes=(replace(part, visible=False),))
    for gone in (replace(model, visible=False), replace(model, state=hidden)):
        with pytest.raises(UserError, match="no ink"):
            bench.readings.drawing_of([gone])


def test_a_document_without_ink_in_objects_gives_the_ink_that_waits(bench):
    drawing, model = sample(bench, SILHOUETTE, 1)
    waiting = Document(waiting=tuple(map(WaitingStroke, drawing.strokes)))
    assert len(bench.readings.drawing_of_document(waiting).strokes) == len(drawing.strokes)
    both = edit.add_model(waiting, model).document
    assert bench.readings.drawing_of_document(both).name == model.name
    with pytest.raises(UserError, match="no ink"):
        bench.readings.drawing_of_document(Document())


def test_a_reading_is_solved_and_has_a_picture(bench):
    _, model = sample(bench, SILHOUETTE, 1)
    ink = bench.readings.drawing_of([model])
    read = bench.readings.reading(SYMMETRY, ink, Context(camera=Camera()), Job(), side=48)
    assert read.model.modeler == SYMMETRY
    assert bench.result(read.model) is not None
    assert read.picture.shape == (48, 48, 4)
    assert read.picture[..., 3].any()
    assert read.model.name == model.name


def test_modelers_that_take_no_ink_say_so(bench):
    _, model = sample(bench, SILHOUETTE, 1)
    ink = bench.readings.drawing_of([model])
    for modeler in ("bozzetto.mesh", "bozzetto.skin", "bozzetto.car"):
        with pytest.raises(UserError):
            bench.readings.read(modeler, ink, Context(), Job())
    assert "bozzetto.mesh" not in bench.readings.readers()
    assert SYMMETRY not in bench.readings.readers(without=[SYMMETRY])


def test_reading_stops_when_nobody_waits(bench):
    _, model = sample(bench, SILHOUETTE, 2)
    ink = bench.readings.drawing_of([model])
    with pytest.raises(Cancelled):
        bench.readings.read(SYMMETRY, ink, Context(), Job(cancelled=lambda: True))


def sources():
    registry = Registry()
    return [
        (info.id, number) for info in registry.modelers() for number in range(len(info.samples))
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("modeler", "number"), sources())
def test_every_sample_is_read_with_a_shape_or_refused_in_words(bench, modeler, number):
    _, model = sample(bench, modeler, number)
    if not len(bench.guarded(model).ink(model.state)):  # a network of curves
        with pytest.raises(UserError, match="no ink"):
            bench.readings.drawing_of([model])
        return
    ink = bench.readings.drawing_of([model])
    for reader in bench.readings.readers(without=[modeler]):
        try:
            read = bench.readings.read(reader, ink, Context(), Job())
        except UserError:
            continue  # not offered
        assert bench.result(read) is not None
        assert bench.shapes([read], Job())
