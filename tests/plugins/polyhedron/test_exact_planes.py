"""Exact planes: what was drawn with noise becomes planes, right angles and typed lengths."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bozzetto.errors import UserError
from bozzetto.exchange.ink.ink_json import read_drawing
from bozzetto.geometry import Placement
from bozzetto.plugin import Context, Job
from bozzetto_polyhedron.model.state import Body, Dimension
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.solid.equal_lengths import equal_lengths, with_equal_lengths
from bozzetto_polyhedron.solid.exact import EqualLengths, exact_body
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solid.triangulation import genus_of, volume_of
from bozzetto_polyhedron.solve.pipeline import placed_body, solved
from bozzetto_polyhedron.solve.standing import foot_of, upright
from tests.plugins.polyhedron.drawn_bodies import VIEW
from tests.plugins.polyhedron.true_bodies import (
    all_bodies,
    cuboid_with_loop,
    drawn,
    face_areas,
    of_prism,
    parallel_camera,
    prism,
)
from tests.plugins.polyhedron.write_samples import FOLDER

BODIES = {body.name: body for body in all_bodies()}
BOX = BODIES["box"]


def off_planes(body):
    """Largest distance of a corner from a plane of its faces, mm."""
    return max(
        float(np.abs(body.vertices[[v for ring in face for v in ring]] @ normal - offset).max())
        for face, normal, offset in zip(body.faces, body.normals, body.offsets, strict=True)
    )


def made(name, seed, share=0.01, **options):
    answer, noise, true = drawn(BODIES[name], share, np.random.default_rng(seed))
    return exact_body(answer, noise=noise, **options), true, noise


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("share", [0.005, 0.02])
def test_planes_are_exact_and_no_corner_fuses(name, share):
    body, true, _ = made(name, 2001, share, camera=parallel_camera())
    assert off_planes(body) < 1e-9
    edges = edges_of(body.faces)
    made_edges, true_edges = (v[edges[:, 0]] - v[edges[:, 1]] for v in (body.vertices, true))
    assert (np.linalg.norm(made_edges, axis=1) > 0.5 * np.linalg.norm(true_edges, axis=1)).all()
    assert ((made_edges * true_edges).sum(axis=1) > 0).all()
    assert np.allclose(np.linalg.norm(body.normals, axis=1), 1.0, atol=1e-14)


@pytest.mark.parametrize("name", [n for n, b in BODIES.items() if b.orthogonal])
def test_right_angles_are_right_to_the_last_digit(name):
    body, _, _ = made(name, 2002)
    cosines = np.abs(body.normals @ body.normals.T)
    assert np.minimum(cosines, np.abs(cosines - 1.0)).max() < 4 * np.finfo(float).eps


@pytest.mark.parametrize("name", BODIES)
def test_the_truth_comes_back_unchanged(name):
    body, true, _ = made(name, 2003, 0.0)
    assert np.abs(body.vertices - true).max() < 1e-10


@pytest.mark.parametrize("name", [n for n, b in BODIES.items() if b.genus is not None])
def test_volume_genus_and_areas(name):
    body, _, _ = made(name, 2004, 0.0)
    true = BODIES[name]
    assert volume_of(body) == pytest.approx(true.volume, rel=1e-12)
    assert genus_of(body) == true.genus
    # the areas of all faces, as vectors, cancel where a body is closed
    assert np.abs(face_areas(body) @ body.normals).max() < 1e-9 * face_areas(body).sum()


def test_an_answer_inside_out_is_turned():
    vertices, faces, volume = prism([(0, 0), (70, 0), (70, 50), (0, 50)], 30.0)
    inside_out = tuple(tuple(ring[::-1] for ring in face) for face in faces)
    body = exact_body(Answer(vertices, inside_out, 1.0, 0.0, True), noise=0.0)
    assert volume_of(body) == pytest.approx(volume)


@pytest.mark.parametrize("seed", range(2010, 2012))
@pytest.mark.parametrize("name", ["L", "house", "hole", "pyramid4"])
def test_turned_moved_and_scaled_drawings_give_turned_moved_and_scaled_bodies(name, seed):
    answer, noise, _ = drawn(BODIES[name], 0.01, np.random.default_rng(seed))
    body = exact_body(answer, noise=noise)
    turn = Rotation.random(random_state=seed).as_matrix()
    moved = replace(answer, vertices=1000.0 * answer.vertices @ turn.T + (3e4, -2e4, 5e3))
    other = exact_body(moved, noise=1000.0 * noise)
    expected = 1000.0 * body.vertices @ turn.T + (3e4, -2e4, 5e3)
    assert np.abs(other.vertices - expected).max() < 1e-9 * 1e5
    assert other.told == body.told


def test_twice_the_same():
    one, two = made("stairs", 2020)[0], made("stairs", 2020)[0]
    assert (one.vertices == two.vertices).all()
    assert (one.normals == two.normals).all()


def test_planes_stay_exact_through_text():
    body, _, _ = made("hole", 2021)
    again = np.array(json.loads(json.dumps(body.vertices.tolist())))
    assert off_planes(replace(body, vertices=again)) < 1e-9


def test_corners_of_more_than_three_faces_stay_one_point():
    body, _, _ = made("pyramid5", 2022, 0.01)
    sides = [k for k, face in enumerate(body.faces) if 5 in face[0]]
    met = np.linalg.lstsq(body.normals[sides], body.offsets[sides], rcond=None)[0]
    assert np.abs(met - body.vertices[5]).max() < 1e-9


# -- dimensions ----------------------------------------------------------------------------------


def between(body, pair):
    """Distance of two parallel faces from the corners alone, mm."""
    one, two = pair
    corner = body.vertices[body.faces[one][0][0]]
    return abs(float((corner - body.vertices[body.faces[two][0][0]]) @ body.normals[two]))


@pytest.mark.parametrize("length", [12.5, 61.0, 240.0])
@pytest.mark.parametrize("name", ["box", "hexagon", "hole", "house"])
def test_a_typed_length_holds(name, length):
    pair = (0, 1)
    answer, noise, _ = drawn(BODIES[name], 0.01, np.random.default_rng(2030))
    body = exact_body(answer, noise=noise, dimensions=[Dimension(pair, length)])
    sign = np.sign(body.normals[0] @ body.normals[1])
    assert abs(body.offsets[0] - sign * body.offsets[1]) == pytest.approx(length, rel=1e-12)
    assert between(body, pair) == pytest.approx(length, rel=1e-12)
    assert off_planes(body) < 1e-9


def test_a_length_typed_and_typed_back_gives_the_body_back():
    answer, noise, _ = drawn(BODIES["L"], 0.01, np.random.default_rng(2031))
    body = exact_body(answer, noise=noise)
    length = between(body, (0, 1))
    changed = exact_body(answer, noise=noise, dimensions=[Dimension((0, 1), 2 * length)])
    back = exact_body(answer, noise=noise, dimensions=[Dimension((0, 1), length)])
    assert np.abs(changed.vertices - body.vertices).max() > 1.0
    assert np.abs(back.vertices - body.vertices).max() < 1e-10


def test_dimensions_that_contradict_one_another_are_told():
    answer, noise, _ = drawn(BOX, 0.01, np.random.default_rng(2032))
    with pytest.raises(UserError, match="contradict"):
        exact_body(
            answer,
            noise=noise,
            dimensions=[Dimension((0, 1), 50.0), Dimension((1, 0), 60.0)],
        )


@pytest.mark.parametrize(
    ("pair", "length"), [((0, 2), 5.0), ((0, 99), 5.0), ((0, 0), 5.0), ((0, 1), -1.0),
                         ((0, 1), float("nan")), ((0, 1), 0.0)]
)  # fmt: skip
def test_dimensions_that_make_no_sense_are_told(pair, length):
    answer, noise, _ = drawn(BOX, 0.01, np.random.default_rng(2033))
    with pytest.raises(UserError):
        exact_body(answer, noise=noise, dimensions=[Dimension(pair, length)])


def test_a_length_that_turns_a_face_over_is_told():
    """The floor of a pocket cannot lie below the block."""
    answer, noise, _ = drawn(cuboid_with_loop(25.0), 0.005, np.random.default_rng(2034))
    with pytest.raises(UserError, match="Type another"):
        exact_body(
            answer, noise=noise, dimensions=[Dimension((0, 1), 50.0), Dimension((0, 10), 55.0)]
        )


def test_equal_lengths_are_equal():
    answer, noise, _ = drawn(BOX, 0.01, np.random.default_rng(2035))
    body = exact_body(answer, noise=noise, equal=[EqualLengths((0, 1), (2, 4))])
    assert between(body, (0, 1)) == pytest.approx(between(body, (2, 4)), rel=1e-12)


# -- frames --------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", BODIES)
def test_bodies_that_are_turned_upright_keep_their_planes_and_come_back(name):
    body, _, _ = made(name, 2040)
    number = foot_of(body)
    assert number is not None
    placement = Placement(upright(body, number, VIEW.axes[2]))
    standing = placed_body(body, placement)
    assert np.abs(placement.points(body.vertices) - standing.vertices).max() < 1e-10
    assert np.ptp(standing.vertices[list(body.faces[number][0]), 2]) == 0.0
    assert off_planes(standing) < 1e-9
    near = np.abs(standing.normals).max(axis=1) > 1 - 1e-9
    assert (np.sort(np.abs(standing.normals[near]), axis=1) == (0.0, 0.0, 1.0)).all()


def test_a_drawing_along_the_axes_of_the_world_gets_exactly_those():
    slightly = Rotation.from_rotvec((0.01, -0.02, 0.015)).as_matrix()
    answer, noise, _ = drawn(BOX, 0.005, np.random.default_rng(2041), turn=slightly)
    body = exact_body(answer, noise=noise)
    assert (np.sort(np.abs(body.normals), axis=1) == (0.0, 0.0, 1.0)).all()
    for axis in range(3):
        assert len(np.unique(body.vertices[:, axis])) == 2  # equal to the last digit


def test_right_angles_can_be_left():
    answer, noise, _ = drawn(BOX, 0.01, np.random.default_rng(2042))
    body = exact_body(answer, noise=noise, right_angles=False)
    assert off_planes(body) < 1e-9
    assert body.frame is None
    cosines = np.abs(body.normals @ body.normals.T)
    assert np.minimum(cosines, np.abs(cosines - 1.0)).max() > 1e-4


def test_a_slope_that_is_meant_is_kept():
    """A wedge that falls by 1 in 3 is no box."""
    wedge = of_prism("slope", [(0, 0), (90, 0), (90, 60), (0, 30)], 60, orthogonal=False)
    answer, noise, true = drawn(wedge, 0.005, np.random.default_rng(2043))
    body = exact_body(answer, noise=noise)
    assert np.abs(body.vertices - true).max() < 5 * noise


# -- hostile -------------------------------------------------------------------------------------

SQUARE = [(0, 0), (50, 0), (50, 40), (0, 40)]


def bad_answers():
    vertices, faces, _ = prism(SQUARE, 30.0)
    nan = vertices.copy()
    nan[3, 1] = np.nan
    far = vertices.copy()
    far[3, 1] = np.inf
    yield "nan", nan, faces
    yield "infinite", far, faces
    yield "no faces", vertices, ()
    yield "no rings", vertices, ((),)
    yield "two corners", vertices, (((0, 1),), *faces[1:])
    yield "twice", vertices, (((0, 1, 2, 0),), *faces[1:])
    yield "foreign", vertices, (((0, 1, 99),), *faces[1:])
    yield "negative", vertices, (((0, 1, -2),), *faces[1:])
    yield "crossing", vertices, (((0, 2, 1, 3),), *faces[1:])
    yield "flat", vertices * (1, 0, 0), faces
    yield "one place", vertices * 0, faces
    yield "hole outside", np.vstack((vertices, np.add(vertices[:3], (100, 0, 0)))), (
        (faces[0][0], (8, 9, 10)), *faces[1:])  # fmt: skip


@pytest.mark.parametrize(("what", "vertices", "faces"), list(bad_answers()))
def test_what_is_no_body_is_told(what, vertices, faces):
    with pytest.raises(UserError):
        exact_body(Answer(np.asarray(vertices, float), faces, 1.0, 0.0, True), noise=0.1)


@pytest.mark.parametrize("noise", [float("nan"), float("inf"), -1.0])
def test_noise_that_is_none_is_told(noise):
    answer, _, _ = drawn(BOX, 0.01, np.random.default_rng(0))
    with pytest.raises(UserError):
        exact_body(answer, noise=noise)


def test_corners_thrown_anywhere_give_a_body_or_a_sentence():
    rng = np.random.default_rng(2050)
    names = list(BODIES)
    for _ in range(40):
        true = BODIES[names[rng.integers(len(names))]]
        vertices = true.vertices + rng.normal(0, rng.choice((3.0, 15.0, 80.0)), true.vertices.shape)
        try:
            body = exact_body(Answer(vertices, true.faces, 0.5, 1.0, True), noise=2.0)
        except UserError:
            continue
        assert off_planes(body) < 1e-9
        assert np.isfinite(body.vertices).all()


# -- equal lengths -------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(2060, 2063))
def test_lengths_that_are_alike_are_proposed_and_can_be_taken(seed):
    stairs = BODIES["stairs"]  # treads and risers of 30 mm
    answer, noise, _ = drawn(stairs, 0.005, np.random.default_rng(seed))
    body = exact_body(answer, noise=noise)
    offered = equal_lengths(body, noise)
    assert offered
    for each in offered:
        assert between(body, each.first) == pytest.approx(between(body, each.second), abs=2 * noise)
    taken = exact_body(answer, noise=noise, equal=offered)
    assert off_planes(taken) < 1e-9
    for each in offered:
        lengths = between(taken, each.first), between(taken, each.second)
        assert lengths[0] == pytest.approx(lengths[1], rel=1e-12)


@pytest.mark.parametrize("seed", range(2070, 2073))
def test_lengths_become_equal_as_far_as_what_was_typed_lets_them(seed):
    stairs = BODIES["stairs"]
    answer, noise, _ = drawn(stairs, 0.005, np.random.default_rng(seed))
    free = exact_body(answer, noise=noise)
    first = equal_lengths(free, noise)[0]
    apart = between(free, first.first), between(free, first.second)
    assert apart[0] != pytest.approx(apart[1], rel=1e-9)
    made = with_equal_lengths(partial(exact_body, answer, noise=noise), noise)
    assert between(made, first.first) == pytest.approx(between(made, first.second), rel=1e-12)
    typed = [Dimension(first.first, 30.0), Dimension(first.second, 30.5)]
    kept = with_equal_lengths(partial(exact_body, answer, noise=noise, dimensions=typed), noise)
    assert between(kept, first.first) == pytest.approx(30.0, rel=1e-12)
    assert between(kept, first.second) == pytest.approx(30.5, rel=1e-12)
    assert off_planes(kept) < 1e-9


def test_a_switch_of_the_model_makes_lengths_equal():
    """Of the same drawing fewer edges differ in length than without it."""
    text = (FOLDER / "stairs.json").read_bytes()
    state = PolyhedronModeler().read_drawing(read_drawing(text, "stairs"), Context(), Job())
    (body,) = state.of_kind(Body)
    lengths = []
    for equal in (False, True):
        found = solved(body, replace(state, equal=equal)).base
        edges = np.diff(found.vertices[edges_of(found.faces)], axis=1)[:, 0]
        lengths.append(len(set(np.round(np.linalg.norm(edges, axis=1), 9).tolist())))
    assert lengths[1] < lengths[0]


def test_lengths_that_differ_are_not_proposed():
    answer, noise, _ = drawn(BOX, 0.005, np.random.default_rng(2063))
    assert equal_lengths(exact_body(answer, noise=noise), noise) == ()


def test_sheets_with_three_faces_at_an_edge_are_exact():
    vertices = np.array(
        [(0, 0, 0), (60, 0, 0), (60, 40, 0), (0, 40, 0), (120, 0, 0), (120, 40, 0), (60, 0, 50),
         (60, 40, 50), (500, 500, 500)], float
    )  # fmt: skip
    faces = (((0, 1, 2, 3),), ((1, 4, 5, 2),), ((1, 2, 7, 6),))
    noisy = vertices + np.random.default_rng(2064).normal(0.0, 1.0, vertices.shape)
    body = exact_body(Answer(noisy, faces, 1.0, 0.0, False), noise=1.0)
    assert not body.closed
    assert off_planes(body) < 1e-9
