"""Pieces of a curve as nodes of the list."""

from __future__ import annotations

import pytest

from bozzetto_symmetry.editing.trim import trim
from bozzetto_symmetry.model.state import Curve, SymmetryState, Trim
from bozzetto_symmetry.operations.split import cut_at, replace_by_pieces, without_stretch
from tests.plugins.symmetry.edited_curves import ACROSS, ALL, LOOP, PAIR, RING


@pytest.mark.parametrize(
    ("curve", "shares", "pieces"),
    [
        (PAIR, [0.3], ((0.0, 0.3), (0.3, 1.0))),
        (PAIR, [0.7, 0.3, 0.3], ((0.0, 0.3), (0.3, 0.7), (0.7, 1.0))),
        (LOOP, [0.3], ((0.3, 1.3),)),
        (LOOP, [0.3, 0.8], ((0.3, 0.8), (0.8, 1.3))),
        (ACROSS, [0.4], ((0.0, 0.4), (0.4, 1.0))),
        (RING, [0.4], ((0.0, 0.4), (0.4, 1.0))),
        (PAIR, [], ((0.0, 1.0),)),
    ],
)
def test_cuts_make_pieces(curve, shares, pieces):
    assert cut_at(curve, shares) == pieces


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("gone", [(0.0, 0.3), (0.4, 0.6), (0.7, 1.0)])
def test_what_is_left_and_what_is_cut_out_are_the_curve(name, gone):
    curve = ALL[name]
    left = without_stretch(curve, gone)
    pieces = [trim(curve, *stretch) for stretch in (*left, gone)]
    single = {"pair": 2.0, "plane": 1.0, "self": 1.0}
    length = sum(single[piece.reading] * piece.spline.length for piece in pieces)
    whole = single[curve.reading] * curve.spline.length
    assert length == pytest.approx(whole, rel=1e-9)


def test_a_stretch_over_the_seam_leaves_one_piece():
    ((begin, end),) = without_stretch(LOOP, (0.9, 1.2))
    assert (begin, end) == (pytest.approx(0.2), pytest.approx(0.9))


def test_stubs_go_along():
    assert without_stretch(PAIR, (0.01, 0.5)) == ((0.5, 1.0),)
    assert without_stretch(PAIR, (0.02, 0.99)) == ()


def test_pieces_stand_where_the_curve_stood_and_keep_its_name():
    nodes = tuple(Curve(id=key, name=name) for key, name in (("a", "Roof"), ("b", "Roof c")))
    state = SymmetryState(nodes=nodes)
    made = replace_by_pieces(state, nodes[0], ((0.0, 0.2), (0.2, 0.5), (0.5, 1.0)))
    assert [node.name for node in made.nodes] == ["Roof", "Roof b", "Roof d", "Roof c"]
    assert [node.edits for node in made.curves[:2]] == [(Trim(0.0, 0.2),), (Trim(0.2, 0.5),)]
    assert len({node.id for node in made.nodes}) == 4
    assert made.selected == "a"
    again = replace_by_pieces(made, made.curves[1], ((0.0, 0.5), (0.5, 1.0)))
    assert [node.name for node in again.nodes] == ["Roof", "Roof b", "Roof e", "Roof d", "Roof c"]


def test_a_curve_of_which_nothing_is_left_is_gone():
    node = Curve(id="a", name="Roof")
    assert replace_by_pieces(SymmetryState(nodes=(node,)), node, ()).nodes == ()
