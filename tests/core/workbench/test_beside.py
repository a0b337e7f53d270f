"""Objects that nobody drew in a place, beside what is there; and parts that are told apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document.model import Document
from bozzetto.geometry import Curve, Mesh, Placement, Shapes, Solid
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.workbench.placed import told_apart
from bozzetto.workbench.workbench import Workbench

TETRA = Mesh(
    [[0, 0, 0], [6, 0, 0], [0, 4, 0], [0, 0, 6]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
)


def stone(bench, mesh=TETRA, **changes):
    model = bench.sources.from_shapes("bozzetto.mesh", Shapes(solids=(Solid(mesh, "Rock"),)), "R")
    return replace(model, **changes)


def box_of(bench, model):
    vertices = bench.shapes([model], Job()).solids[0].mesh.vertices
    return np.array([vertices.min(axis=0), vertices.max(axis=0)])


# -- a place beside --------------------------------------------------------------------------------


@pytest.fixture
def bench():
    return Workbench(Registry())


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_every_new_object_stands_beside_all_others_on_their_ground(bench, size):
    grown = Mesh(size * TETRA.vertices.astype(float), TETRA.faces)
    rows = []
    for _ in range(4):
        document = Document(tuple(rows))
        rows.append(bench.sources.beside(stone(bench, grown), document, Job()))
        bench.solve(rows[-1], Job())
    boxes = np.array([box_of(bench, model) for model in rows]) / size
    assert np.allclose(boxes[:, :, [0, 2]], boxes[0, :, [0, 2]].T)
    assert np.allclose(boxes[1:, 0, 1] - boxes[:-1, 1, 1], 0.4 * 4.0, atol=1e-4), "narrower in y"


def test_it_stands_beside_what_was_moved_and_not_beside_what_is_hidden(bench):
    far = stone(bench, placement=Placement(offset=(0.0, 70.0, 0.0)))
    bench.solve(far, Job())
    moved = bench.sources.beside(stone(bench), Document((far,)), Job())
    assert moved.placement.offset[1] == pytest.approx(74.0 + 1.6)
    hidden = Document((replace(far, visible=False),))
    new = stone(bench)
    assert bench.sources.beside(new, hidden, Job()) is new
    assert bench.sources.beside(new, Document(), Job()) is new


# -- names -----------------------------------------------------------------------------------------


def named(*names):
    return Shapes(
        solids=tuple(Solid(TETRA, name) for name in names[:-1]),
        curves=(Curve(1, [0.0, 0.0, 1.0, 1.0], [[0, 0, 0], [1, 0, 0]], name=names[-1]),),
    )


def names_of(shapes):
    return [part.name for part in (*shapes.solids, *shapes.curves)]


def test_what_has_names_of_its_own_keeps_them():
    rows = [("Car", named("Body", "Edge")), ("Vase", named("Pot", "Rim"))]
    for told, (_, shapes) in zip(told_apart(rows), rows, strict=True):
        assert told is shapes


def test_two_of_one_kind_are_named_with_their_object():
    rows = [("Car", named("Body", "Edge")), ("Car", named("Body", "Rim")), ("V", named("P", "Q"))]
    one, two, three = told_apart(rows)
    assert names_of(one) == ["Car: Body", "Car: Edge"]
    assert names_of(two) == ["Car 2: Body", "Car 2: Rim"]
    assert three is rows[2][1]


def test_parts_that_are_called_like_their_object_are_not_named_twice():
    one, two = told_apart([("Rock", named("Rock", "Rock 2")), ("Rock", named("Rock", "Rock 2"))])
    assert names_of(one) == ["Rock", "Rock 2"]
    assert names_of(two) == ["Rock 3", "Rock 3 2"]


@pytest.mark.parametrize("seed", range(20))
def test_no_two_objects_have_a_part_of_one_name(seed):
    rng = np.random.default_rng(seed)
    words = ["a", "b", "a 2", "a: b", "b: a", "a 2: b"]

    def some(count):
        return [words[number] for number in rng.integers(0, len(words), count)]

    rows = [(some(1)[0], named(*some(3))) for _ in range(4)]
    told = told_apart(rows)
    every = [set(names_of(shapes)) for shapes in told]
    assert sum(map(len, every)) == len(set().union(*every))
    for before, after in zip(rows, told, strict=True):
        assert len(set(names_of(before[1]))) == len(set(names_of(after)))
        assert [part.mesh for part in after.solids] == [part.mesh for part in before[1].solids]
