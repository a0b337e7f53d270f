"""Faces that share edges: what is refused, and what placements and turning over keep."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

from bozzetto.document.storage.state_codec import decode_state, encode_state
from bozzetto.geometry import (
    Brep,
    BSplineSurface,
    Curve,
    Face,
    GapError,
    ParameterCurve,
    Patchwork,
    Placement,
    Shapes,
    Trim,
    brep_mesh,
    plane_face,
    sewn,
)
from bozzetto.geometry.brep.patchwork_brep import brep_of_patchwork
from bozzetto.testing.deep_equal import same
from tests.core.geometry.body_kit import body
from tests.core.geometry.brep.exact_shapes import KNOWN, bent_net, box
from tests.core.geometry.patches.test_patchwork import ball

PLACES = (
    Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 250.0, (3.0, -7.0, 1100.0)),
    Placement((1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0), 1e-4, (0.0, 40.0, 1.0)),
)
SQUARE = np.array([(0, 0, 0), (9, 0, 0), (9, 9, 0), (0, 9, 0)], float)
HOLE = SQUARE / 3 + np.array((1.0, 1.0, 0.0))
FACE = plane_face([SQUARE])
BALL = brep_of_patchwork(ball())


def volume(brep):
    mesh = brep_mesh(brep, 3e-3 * brep.faces[0].surface.size)
    return float(np.linalg.det(mesh.vertices[mesh.faces].astype(float)).sum() / 6)


def changed(loop):
    """The square's face with another loop."""
    return Face(FACE.faces[0].surface, (tuple(loop),))


LOOP = FACE.faces[0].loops[0]


@pytest.mark.parametrize(
    ("loop", "said"),
    [
        ((), "outer loop"),
        (LOOP[:3], "follow one another"),
        ((LOOP[0], LOOP[2], LOOP[1], LOOP[3]), "follow one another"),
        (tuple(replace(t, forward=False) for t in reversed(LOOP)), "counter-clockwise"),
    ],
)
def test_loops_that_bound_no_face_are_refused(loop, said):
    with pytest.raises(ValueError, match=said):
        changed(loop)


def test_a_surface_that_is_a_point_is_no_face():
    with pytest.raises(ValueError, match="at least one edge"):
        Brep.of_surface(replace(FACE.faces[0].surface, control_points=np.ones((2, 2, 3))))


def test_a_loop_stays_on_its_surface():
    wide = tuple(
        replace(t, curve=replace(t.curve, control_points=1.1 * t.curve.control_points))
        for t in LOOP
    )
    with pytest.raises(ValueError, match="leaves its surface"):
        changed(wide)


@pytest.mark.parametrize(
    ("edges", "faces", "said"),
    [
        (FACE.edges, (), "needs a face"),
        (FACE.edges[:3], FACE.faces, "do not exist"),
        ((*FACE.edges, FACE.edges[0]), FACE.faces, "leave one out"),
        (FACE.edges, FACE.faces * 2, "same sense"),
        ((FACE.edges[0].reversed(), *FACE.edges[1:]), FACE.faces, "mm beside a face"),
        ((replace(FACE.edges[0], knots=(0, 0, 2, 2)), *FACE.edges[1:]), FACE.faces, "range"),
        ((replace(FACE.edges[0], knots=(-1, 0, 1, 2)), *FACE.edges[1:]), FACE.faces, "begin and"),
    ],
)  # fmt: skip
def test_edges_that_do_not_belong_to_faces_are_refused(edges, faces, said):
    with pytest.raises(ValueError, match=said):
        Brep(edges, faces)


@pytest.mark.parametrize("off", [1e-5, -1e-6])
def test_an_edge_may_not_lie_beside_its_face(off):
    bent = replace(
        FACE.edges[1], control_points=FACE.edges[1].control_points + np.array((0, 0, off))
    )
    with pytest.raises(ValueError, match="mm beside a face"):
        Brep((FACE.edges[0], bent, *FACE.edges[2:]), FACE.faces)


@pytest.mark.parametrize("name", KNOWN)
@pytest.mark.parametrize("place", PLACES)
def test_placed_solids_stay_closed_exact_and_outward(name, place):
    brep = KNOWN[name].brep
    moved = brep.placed(place)
    assert moved.is_closed
    assert moved.largest_gap() <= moved.tolerance
    assert volume(moved) == pytest.approx(KNOWN[name].volume * place.scale**3, rel=0.03)
    back = moved.placed(place.inverse())
    for one, two in zip(brep.edges, back.edges, strict=True):
        np.testing.assert_allclose(one.control_points, two.control_points, atol=1e-7)


def test_turned_over_looks_inward():
    made = KNOWN["torus"].brep.turned_over()
    assert made.is_closed
    assert volume(made) == pytest.approx(-KNOWN["torus"].volume, rel=0.03)


@pytest.mark.parametrize("name", KNOWN)
def test_euler_and_poincare(name):
    """V − E + F − H = 2 − 2 g, where H are loops round holes."""
    brep = KNOWN[name].brep
    holes = sum(len(face.loops) - 1 for face in brep.faces)
    count = len(brep.vertices[0]) - len(brep.edges) + len(brep.faces) - holes
    assert count == 2 - 2 * KNOWN[name].genus


@pytest.mark.parametrize("name", KNOWN)
def test_sides_of_a_loop_meet_in_vertices(name):
    brep = KNOWN[name].brep
    places, ends, poles = brep.vertices
    for f, face in enumerate(brep.faces):
        for k, loop in enumerate(face.loops):
            run = []
            for i, trim in enumerate(loop):
                both = (poles[f, k, i],) * 2 if trim.edge is None else ends[trim.edge].tolist()
                run.append(tuple(both if trim.forward else both[::-1]))
            assert all(a[1] == b[0] for a, b in pairwise(run + run[:1]))
    for edge, (start, end) in zip(brep.edges, ends, strict=True):
        np.testing.assert_allclose(edge.control_points[[0, -1]], places[[start, end]], atol=1e-13)


def test_pieces_hang_together_by_edges_only():
    far = box().placed(Placement(offset=(7.0, 5.0, 3.0)))  # touches in one corner
    both = sewn([box(), far])
    assert [piece.tolist() for piece in both.pieces] == [list(range(6)), list(range(6, 12))]
    assert both.is_closed


def test_all_of_a_surface_is_whole_and_a_trimmed_part_is_not():
    whole = Brep.of_surface(bent_net(4))
    assert whole.faces[0].is_whole
    assert FACE.faces[0].is_whole  # a rectangle
    assert not plane_face([SQUARE[:3]]).faces[0].is_whole
    assert not plane_face([SQUARE, HOLE]).faces[0].is_whole


def test_a_patchwork_as_faces_has_the_very_numbers():
    edges, sides, names, _ = body(2, 0.3)
    skin = Patchwork.of_edges(edges, sides, "Car", (200, 30, 20), names)
    brep = brep_of_patchwork(skin)
    assert brep.largest_gap() < 1e-9
    assert (brep.name, brep.color) == ("Car", skin.color)
    assert tuple(face.name for face in brep.faces) == names
    for face, net in zip(brep.faces, skin.nets, strict=True):
        np.testing.assert_array_equal(face.surface.control_points, net)
    np.testing.assert_array_equal(brep.rim, skin.rim)
    assert BALL.is_closed
    assert volume(BALL) > 0


def test_edges_of_a_patchwork_that_no_patch_has_are_left_out():
    skin = ball()
    loose = np.vstack((skin.edges[:1] + 1.0, skin.edges))
    shifted = np.where(skin.sides < 0, skin.sides - 1, skin.sides + 1)
    brep = brep_of_patchwork(replace(skin, edges=loose, sides=shifted))
    assert (len(brep.edges), brep.is_closed) == (len(skin.edges), True)


def test_shapes_add_up_and_are_placed_with_breps():
    one = Shapes(breps=(FACE,)) + Shapes(breps=(box(),))
    assert [b.name for b in one.breps] == ["brep", "box"]
    assert one
    moved = one.placed(PLACES[0])
    np.testing.assert_array_equal(
        moved.breps[1].edges[0].control_points, box().placed(PLACES[0]).edges[0].control_points
    )
    assert one.placed(Placement()) is one


def test_trims_say_where_their_edge_is_at_every_parameter():
    """The law by which everything else holds, for a rational arc on a plane and on a lathe."""
    for name in ("cone", "tube", "torus"):
        brep = KNOWN[name].brep
        for face in brep.faces:
            for trim in face.trims:
                if trim.edge is None:
                    continue
                t = np.linspace(*trim.curve.range, 77)
                found = face.surface.value(*trim.curve.value(t).T)
                assert np.abs(found - brep.edges[trim.edge].value(t)).max() < 1e-12


def test_numbers_of_parameter_curves_are_checked():
    with pytest.raises(ValueError, match="finite"):
        ParameterCurve.line((0, np.nan), (1, 1), (0, 1))
    with pytest.raises(ValueError, match="weight"):
        ParameterCurve(1, (0, 0, 1, 1), np.zeros((2, 2)), np.array((1.0, 0.0)))
    assert Trim(0, True, ParameterCurve.line((0, 1), (2, 3), (0, 1))).ends.tolist() == [
        [0, 1],
        [2, 3],
    ]
    assert Curve(1, (0, 0, 1, 1), SQUARE[:2]).is_clamped


@dataclass(frozen=True)
class Held:
    """A state that keeps exact shapes."""

    brep: Brep | None = None
    others: tuple[Brep, ...] = ()


def test_documents_keep_breps_in_states():
    state = Held(KNOWN["tube"].brep, (FACE, BALL))
    again = decode_state(Held, encode_state(state))
    assert same(state, again)
    assert again.brep.is_closed


def test_what_only_gets_another_name_is_not_measured_again(monkeypatch):
    def values(make):
        asked = []
        monkeypatch.setattr(
            BSplineSurface, "value", lambda *args: asked.append(args) or value(*args)
        )
        made = make()
        monkeypatch.setattr(BSplineSurface, "value", value)
        return made, len(asked)

    value = BSplineSurface.value
    ball = replace(BALL, faces=tuple(replace(face) for face in BALL.faces))
    named, measured = values(
        lambda: replace(
            ball, name="Ball", faces=tuple(replace(face, name="Skin") for face in ball.faces)
        )
    )
    assert measured == 0
    assert named.largest_gap() == BALL.largest_gap()
    # Elsewhere it is as it was, and an edge that has moved alone is found.
    for place in PLACES:
        moved, measured = values(partial(ball.placed, place))
        assert measured == 0
        anew = tuple(replace(face, surface=replace(face.surface)) for face in moved.faces)
        gap, measured = values(lambda edges=moved.edges, anew=anew: Brep(edges, anew).largest_gap())
        assert measured >= len(anew)
        assert moved.largest_gap() == pytest.approx(gap, rel=0.1, abs=moved.tolerance / 10)
    edge = ball.edges[0]
    off = replace(edge, control_points=edge.control_points + np.array((0.0, 0.0, 0.1)))
    for faces in (ball.faces, named.faces):
        with pytest.raises(GapError):
            Brep((off, *ball.edges[1:]), faces)
