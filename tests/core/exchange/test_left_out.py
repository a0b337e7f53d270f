"""Whatever a format has no place for is named, for every format and every kind of part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.exchange.export import prepare_export
from bozzetto.exchange.formats import writers
from bozzetto.geometry import Curve, Mesh, Shapes, Skeleton, Solid, Surface
from tests.core.exchange.skinned import skinned
from tests.core.exchange.test_surfaces import CAR

TETRA = Mesh(
    [[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
)
LINE = Curve(1, [0, 0, 1, 1], [[0, 0, 0], [10, 0, 5]], name="Line")
SOLIDS = (Solid(TETRA, "Head"), Solid(TETRA, "Tail"))
ALL = Shapes(
    solids=SOLIDS,
    surfaces=(Surface(Mesh(TETRA.vertices, TETRA.faces[:2]), "Leaf"),),
    curves=(LINE,),
    skeletons=(Skeleton([[0, 0, 0]], [1.0], np.zeros((0, 2), np.int32), "Axis"),),
    patchworks=(CAR,),
)
NAMES = {"Head", "Tail", "Leaf", "Line", "Axis", CAR.name}
FORMATS = [one for one in writers("mesh", "surfaces", "curves")]


def needs(one):
    library = {"dxf": "ezdxf", "rhino": "rhino3dm"}.get(one.id)
    if library:
        pytest.importorskip(library)


@pytest.mark.parametrize("one", FORMATS, ids=lambda one: one.id)
def test_every_part_is_in_the_file_or_named_as_left_out(one):
    needs(one)
    made = prepare_export(ALL, f"a{one.endings[0]}")
    told = made.as_values()
    written = {n for k in ("solids", "surfaces", "exact_surfaces", "curves") for n in told[k]}
    missing = {name for part in told["left_out"] for name in part["names"]}
    assert written | missing == NAMES
    assert not written & missing
    assert told["bytes"] == len(made.data)
    for said in made.warnings():
        assert said.startswith(f"Left out of the {one.short} file: ")
        assert said.endswith(".")


def test_the_sentence_is_the_one_that_was_promised():
    made = prepare_export(Shapes(solids=SOLIDS, curves=(LINE,)), "a.step")
    assert made.warnings() == (
        "Left out of the STEP file: 2 solids (they have no exact surfaces); save them as 3MF or "
        "STL.",
    )
    one = prepare_export(Shapes(solids=SOLIDS[:1], curves=(LINE,)), "a.stp")
    assert "1 solid (it has no exact surfaces); save it as" in one.warnings()[0]


def test_nothing_is_said_where_nothing_is_missing():
    assert prepare_export(Shapes(solids=SOLIDS), "a.stl").warnings() == ()
    assert prepare_export(Shapes(patchworks=(CAR,), curves=(LINE,)), "a.step").warnings() == ()
    assert prepare_export(Shapes(patchworks=(CAR,)), "a.3mf").warnings() == ()


def test_painted_colours_are_missed_where_a_format_has_none():
    colors = np.full((4, 4), 200, np.uint8)
    painted = Solid(Mesh(TETRA.vertices, TETRA.faces, colors=colors), "Painted")
    (said,) = prepare_export(Shapes(solids=(painted,)), "a.stl").warnings()
    assert "the colours of 1 solid" in said
    for ending in ("3mf", "glb", "obj", "ply"):
        assert prepare_export(Shapes(solids=(painted,)), f"a.{ending}").warnings() == ()


def test_bones_are_missed_once_somebody_has_bent_them():
    posed, rest = skinned(7, 60.0), skinned(7)
    assert "the bones of 1 solid" in " ".join(
        prepare_export(Shapes(solids=(posed,)), "a.stl").warnings()
    )
    assert prepare_export(Shapes(solids=(posed,)), "a.glb").warnings() == ()
    assert prepare_export(Shapes(solids=(rest,)), "a.stl").warnings() == ()


def test_empty_surfaces_are_named():
    empty = Surface(Mesh(np.zeros((0, 3)), np.zeros((0, 3))), "Nothing yet")
    made = prepare_export(Shapes(solids=SOLIDS, surfaces=(empty,)), "a.obj")
    assert "1 open surface (it has no triangles)" in made.warnings()[0]


def test_what_is_not_sound_is_refused_only_where_it_would_be_written():
    broken = replace(SOLIDS[0], mesh=Mesh(TETRA.vertices, TETRA.faces[:3]))
    shapes = Shapes(solids=(broken,), curves=(LINE,))
    assert prepare_export(shapes, "a.step").warnings()
    with pytest.raises(UserError, match="not closed"):
        prepare_export(shapes, "a.stl")
