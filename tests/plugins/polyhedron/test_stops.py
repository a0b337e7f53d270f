"""Hinges turn until bodies meet: closed forms, laws, and boxes with lids as they are drawn."""

from __future__ import annotations

from dataclasses import replace
from time import process_time

import numpy as np
import pytest
from scipy.optimize import nnls

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag
from bozzetto_polyhedron.mechanism import stops
from bozzetto_polyhedron.mechanism.convex_parts import Polytope, polytope_of
from bozzetto_polyhedron.mechanism.distance import distance_between
from bozzetto_polyhedron.mechanism.rotations import rotations_by
from bozzetto_polyhedron.mechanism.stops import free_turn
from bozzetto_polyhedron.model.fittings import Hinge
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.solve.plates import plate_parts
from bozzetto_polyhedron.tools.move import Move
from tests.plugins.polyhedron.drawn_bodies import VIEW
from tests.plugins.polyhedron.figures_open_boxes import lidded_box, open_box
from tests.plugins.polyhedron.linkages import played
from tests.plugins.polyhedron.test_folds import folds, hinged, pulled, read, seen

UP = np.array([0.0, 1.0, 0.0])
EDGE = np.array([1.0, 0.0, 1.0])
SEEDS = (82_300, 82_301, 82_302)


def block(low, high) -> Polytope:
    low, high = np.array(low, float), np.array(high, float)
    made = polytope_of(np.array([np.where(pick, high, low) for pick in np.ndindex(2, 2, 2)]))
    assert made is not None
    return made


def moved(part: Polytope, turn: np.ndarray) -> Polytope:
    made = polytope_of(part.corners @ turn.T)
    assert made is not None
    return made


CUBE = block((0, 0, 0), (1, 1, 1))


@pytest.mark.parametrize("seed", range(4))
def test_a_cube_at_the_edge_of_another_one_turns_by_half_a_round(seed):
    """They touch at rest; whichever way the world is turned, one way is shut, the other 180°."""
    vector = np.random.default_rng((9, seed)).normal(size=3)
    turn = rotations_by(vector[None])[0]
    beside = block((1, 0, 0), (2, 1, 1))
    found = free_turn((moved(beside, turn),), (moved(CUBE, turn),), turn @ EDGE, turn @ UP)
    assert np.degrees(np.sort(np.abs(found))) == pytest.approx([0.0, 180.0], abs=0.1)
    back = free_turn((moved(CUBE, turn),), (moved(beside, turn),), turn @ EDGE, turn @ UP)
    assert back == pytest.approx([-found[1], -found[0]], abs=1e-3)


@pytest.mark.parametrize("lean", [10.0, 30.0, 45.0])
def test_a_door_stops_at_a_wall_that_leans(lean):
    """A wall through the axis, turned by an angle from a door that is thin."""
    door, wall = block((0, 0, -1e-4), (1, 2, 1e-4)), block((0.05, 0, -1e-4), (1, 2, 1e-4))
    turned = moved(wall, rotations_by(np.radians(lean) * UP[None])[0])
    found = free_turn((door,), (turned,), np.zeros(3), UP)
    assert np.degrees(found[1]) == pytest.approx(lean, abs=1.0)
    assert np.degrees(found[0]) == pytest.approx(lean - 360.0, abs=1.0)


def test_a_wheel_on_an_axle_and_what_never_meets_have_no_stops():
    axle = block((0.4, -1, 0.4), (0.6, 2, 0.6))
    assert free_turn((CUBE,), (axle,), np.array([0.5, 0.0, 0.5]), UP) is None
    far = block((5, 0, 5), (6, 1, 6))
    assert free_turn((CUBE,), (far,), np.zeros(3), UP) is None
    inside = block((0.3, 0.3, 0.3), (0.9, 0.9, 0.9))
    assert free_turn((CUBE,), (inside,), np.zeros(3), UP) is None


def test_plates_are_of_their_faces_with_holes_and_notches():
    square = np.array([(0, 0), (90, 0), (90, 60), (0, 60)], float)
    hole = np.array([(20, 20), (20, 40), (70, 40), (70, 20)], float)
    vertices = np.column_stack((np.vstack((square, hole)), np.zeros(8)))
    parts, numbers = plate_parts(vertices, [((0, 1, 2, 3), (4, 5, 6, 7))], 2.0)
    assert set(numbers) == {0}
    middle = np.array([45.0, 30.0, 0.0])
    assert all((part.normals @ middle - part.offsets).max() > 0.0 for part in parts)
    solid = np.array([10.0, 30.0, 0.5])
    assert any((part.normals @ solid - part.offsets).max() < 0.0 for part in parts)


# -- as drawn --


def with_lid(seed: int):
    state = read(lidded_box(seed))
    (fold,) = folds(state)
    return hinged(state, fold)


def angle(state) -> tuple[float, float]:
    """Return how far the lid is turned from the middle of its way, and how far it can be, °."""
    made = moving(state)
    stops = made.machine.assembly.stops
    ((now,), (reach,)) = stops.angles(made.motion(state.moved)), stops.reach
    return float(np.degrees(now)), float(np.degrees(reach))


def normals(state) -> np.ndarray:
    """Return unit normals of all faces where they are now."""
    made = moving(state)
    places = made.machine.moved(0, made.motion(state.moved))
    rings = [places[list(face[0])] for face in made.machine.shapes[0].faces]
    areas = [np.cross(r - r[0], np.roll(r, -1, axis=0) - r[0]).sum(axis=0) for r in rings]
    return np.array([area / np.linalg.norm(area) for area in areas])


def lid_of(state) -> int:
    plates = moving(state).machine.plates[0]
    return int(np.flatnonzero(np.bincount(plates)[plates] == 1)[0])


@pytest.mark.parametrize("seed", SEEDS)
def test_a_lid_turns_from_its_box_to_the_wall_behind_it(seed):
    """Three quarters of a round, but for the thickness of what is folded."""
    state = with_lid(seed)
    assert 2.0 * angle(state)[1] == pytest.approx(270.0, abs=2.0)
    folded = state.with_node(replace(state.nodes[0], wall=2.0))
    assert 2.0 * angle(folded)[1] < 2.0 * angle(state)[1]


@pytest.mark.parametrize("seed", SEEDS)
def test_a_heavy_lid_falls_until_it_lies_and_gains_no_energy(seed):
    """It went through its box, and on."""
    state = replace(with_lid(seed), gravity=True, damping=0.0)
    made = moving(state)
    energies = [made.stepper.energy(made.motion(None))]
    for _ in range(150):
        state = Move().step(state, None, 1 / 60, Context())
        energies.append(made.stepper.energy(made.motion(state.moved)))
        assert made.stepper.beyond_stops(made.motion(state.moved)) < 1e-4
    assert max(np.diff(energies)) < 1e-3 * (max(energies) - min(energies))
    now, reach = angle(state)
    assert abs(now) == pytest.approx(reach, abs=0.01)
    assert np.abs(state.moved.velocities).max() < 1e-6
    cosines = np.abs(normals(state) @ normals(state)[lid_of(state)])
    assert np.degrees(np.arccos(np.sort(cosines)[-2])) < 1.0


@pytest.mark.parametrize("seed", SEEDS)
def test_the_pen_shuts_a_lid_and_no_further(seed):
    state = with_lid(seed)
    made = moving(state)
    corner = max(
        set(made.machine.shapes[0].faces[lid_of(state)][0]) - set(*folds(read(lidded_box(seed)))),
        key=lambda k: made.machine.shapes[0].vertices[k][2],
    )
    place = seen(made.machine.shapes[0].vertices[corner])[0]
    for way in ([0.0, 600.0], [0.0, -600.0], [600.0, 0.0], [-600.0, 0.0]):
        shut = pulled(state, place, np.array(way))
        now, reach = angle(shut)
        assert abs(now) <= reach + 1e-3
    ends = [pulled_at(state, place, rate) for rate in (30, 120)]
    assert angle(ends[0])[0] == pytest.approx(angle(ends[1])[0], abs=0.5)


def pulled_at(state, place: np.ndarray, rate: int):
    for frame in range(rate):
        path = place + np.linspace(0.0, 1.0, frame + 2)[:, None] * [0.0, 400.0]
        state = Move().step(state, Drag("", Stroke(*path.T, VIEW)), 1 / rate, Context())
    return state


def test_a_motor_that_presses_the_lid_into_its_box_says_so():
    state = with_lid(SEEDS[0])
    (hinge,) = state.of_kind(Hinge)
    reach = angle(state)[1]
    for end in (2.0 * reach, -2.0 * reach):
        shut = state.with_node(
            replace(hinge, drive="curve", curve=f"0: 0, 1: {end}", repeats="once")
        )
        with pytest.raises(UserError, match="presses one body against another"):
            played(shut, 1.5)
        assert played(replace(shut, contact=False), 1.5).moved.seconds == pytest.approx(1.5)


def test_every_flap_stops_by_itself_in_any_order():
    state = read(open_box(80_112, (0, 1, 2, 3)))
    edges = folds(state)
    one, other = state, state
    for edge in edges:
        one = hinged(one, edge)
    for edge in reversed(edges):
        other = hinged(other, edge)
    reaches = [np.sort(moving(each).machine.assembly.stops.reach).tolist() for each in (one, other)]
    assert len(reaches[0]) == 4
    assert reaches[0] == pytest.approx(reaches[1], abs=1e-3)


def ball(center, radius: float, seed: int = 0, count: int = 64) -> Polytope:
    """Return a polytope of corners on a sphere, turned by chance."""
    points = np.random.default_rng((82_310, seed)).normal(size=(count, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    made = polytope_of(radius * points + np.array(center, float))
    assert made is not None
    return made


def rod(radius: float, length: float, count: int) -> Polytope:
    """Return an upright prism of many sides about the middle of a place at x = 1."""
    turn = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    ring = np.column_stack((1.0 + radius * np.cos(turn), radius * np.sin(turn)))
    ends = [np.column_stack((ring[:, 0], np.full(count, y), ring[:, 1])) for y in (0.0, length)]
    made = polytope_of(np.concatenate(ends))
    assert made is not None
    return made


def test_round_rods_stop_where_circles_touch():
    """Prisms of 32 sides about parallel axes: 2 R sin(θ/2) = 2 r, r to a corner or to a side."""
    one, other = rod(0.3, 1.0, 32), rod(0.3, 1.0, 32)
    apart = moved(other, rotations_by(np.radians(90.0) * UP[None])[0])
    low, high = np.degrees(free_turn((one,), (apart,), np.zeros(3), UP))
    at_sides, at_corners = 2.0 * np.degrees(np.arcsin(0.3 * np.array((np.cos(np.pi / 32), 1.0))))
    assert at_sides - 0.01 < 90.0 - high < at_corners + 0.01
    assert at_sides - 0.01 < 270.0 + low < at_corners + 0.01


@pytest.mark.parametrize("seed", range(3))
def test_round_limbs_stop_where_separating_axes_say(seed, monkeypatch):
    own, other = ball((0.7, 0.0, 0.0), 0.4, seed, 24), ball((-0.5, 0.1, 0.3), 0.35, seed + 9, 24)
    begun = process_time()
    by_corners = free_turn((own,), (other,), np.zeros(3), UP)
    assert process_time() - begun < 5.0
    monkeypatch.setattr(stops, "MOST_AXES", 10**6)
    again = ball((0.7, 0.0, 1e-8), 0.4, seed, 24)
    by_axes = free_turn((again,), (other,), np.zeros(3), UP)
    assert by_corners == pytest.approx(by_axes, abs=2e-4)


def test_round_limbs_that_touch_at_rest_turn_apart_alone():
    """One way is shut; the other one ends where they meet from the other side."""
    one, across = rod(0.3, 1.0, 32), 2.0 * np.arcsin(0.3)
    beside = moved(one, rotations_by(across * UP[None])[0])
    shut, free = np.sort(np.abs(free_turn((one,), (beside,), np.zeros(3), UP)))
    assert shut < np.radians(0.3)
    assert free == pytest.approx(2.0 * np.pi - 2.0 * across, abs=np.radians(0.4))


def test_limbs_of_too_many_round_parts_are_not_asked():
    balls = tuple(ball((1.0, 0.1 * k, 0.0), 0.4, k) for k in range(3))
    others = tuple(ball((-1.0, 0.1 * k, 0.0), 0.4, k) for k in range(3))
    begun = process_time()
    assert free_turn(balls, others, np.zeros(3), UP) is None
    assert process_time() - begun < 0.2


@pytest.mark.parametrize("seed", range(8))
def test_distances_of_hulls_are_those_of_a_least_squares_solver(seed):
    """Shares of corners that are not negative and add up to one, by Lawson and Hanson's method."""
    rng = np.random.default_rng((5, seed))
    one = rng.normal(size=(int(rng.integers(4, 60)), 3))
    other = rng.normal(size=(int(rng.integers(4, 60)), 3)) + rng.normal(size=3) * seed
    weight = 1e4
    sums = np.zeros((2, len(one) + len(other)))
    sums[0, : len(one)], sums[1, len(one) :] = weight, weight
    rows = np.vstack((np.hstack((one.T, -other.T)), sums))
    shares, _ = nnls(rows, np.array([0.0, 0.0, 0.0, weight, weight]), maxiter=5000)
    a, b = shares[: len(one)], shares[len(one) :]
    wanted = float(np.linalg.norm(a @ one / a.sum() - b @ other / b.sum()))
    assert distance_between(one, other) == pytest.approx(wanted, abs=1e-6)
