"""Rigs and skins: what turning joints does, against rotations of SciPy, and hostile input."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bozzetto.geometry import Mesh, Placement, Rig, Skin, Solid

REST = [[0, 0, 0], [10, 0, 0], [20, 0, 0], [10, 8, 0]]
PARENTS = [-1, 0, 1, 1]
NAMES = ("root", "knee", "foot", "ear")


def turned(**about):
    """A rig with some joints turned: name=(axis, degrees)."""
    turns = np.tile([0.0, 0.0, 0.0, 1.0], (4, 1))
    for name, (axis, degrees) in about.items():
        vector = np.radians(degrees) * np.array(axis, float) / np.linalg.norm(axis)
        turns[NAMES.index(name)] = Rotation.from_rotvec(vector).as_quat()
    return Rig(REST, PARENTS, NAMES, turns)


def skin_of(rig, count=200, seed=5):
    """Random vertices that follow random joints."""
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet(np.ones(4) * 0.3, count)
    joints = np.array([rng.permutation(4) for _ in range(count)])
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    mesh = Mesh(rng.normal(size=(count, 3)) * 10, [[0, 1, 2]], normals)
    return Skin(rig, joints, weights), mesh


def chained(rig):
    """Every joint's move as a 4 x 4 matrix, by walking from the root: the plain definition."""
    moves = []
    for joint, parent in enumerate(rig.parents):
        at = rig.joints[joint]
        own = np.eye(4)
        own[:3, :3] = Rotation.from_quat(rig.turns[joint]).as_matrix()
        own[:3, 3] = at - own[:3, :3] @ at
        moves.append(moves[parent] @ own if parent >= 0 else own)
    return np.array(moves)


POSE = turned(root=((0, 1, 2), 20), knee=((1, 0.2, 0), 70), ear=((0, 0, 1), -120))


def test_joints_and_vertices_follow_the_chain_of_rotations_about_joints_at_rest():
    moves = chained(POSE)
    _, places = POSE.posed()
    ones = np.ones((4, 1))
    expected = np.einsum("nij,nj->ni", moves, np.hstack((POSE.joints, ones)))[:, :3]
    np.testing.assert_allclose(places, expected, atol=1e-12)

    skin, mesh = skin_of(POSE)
    seen = skin.posed(mesh)
    for vertex in range(0, 200, 7):
        pairs = zip(skin.joints[vertex], skin.weights[vertex], strict=True)
        mixed = sum(weight * moves[joint] for joint, weight in pairs)
        place = mixed @ np.append(mesh.vertices[vertex], 1.0)
        np.testing.assert_allclose(seen.vertices[vertex], place[:3], atol=2e-5)
        normal = mixed[:3, :3] @ mesh.normals[vertex]
        np.testing.assert_allclose(seen.normals[vertex], normal / np.linalg.norm(normal), atol=2e-5)


def test_a_rig_at_rest_moves_nothing():
    skin, mesh = skin_of(Rig(REST, PARENTS, NAMES))
    assert skin.posed(mesh) is mesh
    skin, mesh = skin_of(turned())
    np.testing.assert_allclose(skin.posed(mesh).vertices, mesh.vertices, atol=1e-5)


def test_turning_the_root_turns_all_rigidly_about_it():
    skin, mesh = skin_of(turned(root=((3, -1, 2), 111)))
    turn = Rotation.from_quat(skin.rig.turns[0])
    np.testing.assert_allclose(
        skin.posed(mesh).vertices, turn.apply(mesh.vertices), rtol=1e-5, atol=1e-5
    )


SPIN = Rotation.from_euler("xyz", [20, 130, -70], degrees=True).as_matrix()
PLACES = {
    "turned": Placement(tuple(SPIN.ravel().tolist()), 1.0, (3.0, -4.0, 5.0)),
    "scaled": Placement(scale=0.01),
    "mirrored": Placement(tuple((SPIN @ np.diag([1.0, 1.0, -1.0])).ravel().tolist()), 7.0),
}


@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
def test_posing_and_placing_may_change_places(place):
    skin, mesh = skin_of(POSE)
    first = skin.posed(mesh).placed(place)
    second = skin.placed(place).posed(mesh.placed(place))
    np.testing.assert_allclose(first.vertices, second.vertices, atol=3e-5 * place.scale + 1e-6)
    np.testing.assert_allclose(first.normals, second.normals, atol=2e-5)
    assert (first.faces == second.faces).all()


def test_a_solid_takes_its_skin_and_its_mesh_at_rest_along():
    skin, mesh = skin_of(POSE)
    skin = Skin(skin.rig, skin.joints, skin.weights, rest=mesh)
    solid = Solid(skin.posed(mesh), skin=skin).placed(PLACES["mirrored"])
    np.testing.assert_allclose(
        solid.skin.posed(solid.skin.rest).vertices, solid.mesh.vertices, atol=3e-4
    )


def test_normals_stay_unit_where_turns_cancel():
    rig = turned(knee=((1, 0, 0), 180))
    mesh = Mesh([[10, 5, 5]] * 3, [[0, 1, 2]], [[0, 0, 1]] * 3)
    skin = Skin(rig, [[0, 1, 0, 0]] * 3, [[0.5, 0.5, 0, 0]] * 3)
    np.testing.assert_allclose(np.linalg.norm(skin.posed(mesh).normals, axis=1), 1.0, atol=1e-6)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"parents": [0, 0, 1, 1]}, "before it"),
        ({"parents": [-1, 2, 0, 1]}, "before it"),
        ({"parents": [-2, 0, 1, 1]}, "before it"),
        ({"parents": [-1, 0, 1]}, "one parent"),
        ({"names": ("a", "a", "b", "c")}, "name of its own"),
        ({"turns": np.zeros((4, 4))}, "unit quaternion"),
        ({"turns": np.tile([0.0, 0, 0, 1], (3, 1))}, "unit quaternion"),
        ({"joints": np.full((4, 3), np.nan)}, "not finite"),
        ({"cuts": [[0, 4]]}, "does not exist"),
    ],
)
def test_what_is_no_rig_is_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        Rig(**{"joints": REST, "parents": PARENTS, "names": NAMES, **wrong})


@pytest.mark.parametrize(
    ("joints", "weights", "said"),
    [
        ([[4, 0, 0, 0]], [[1, 0, 0, 0]], "does not exist"),
        ([[1, 0, 0, 0]], [[0.9, 0, 0, 0]], "sum up"),
        ([[1, 2, 0, 0]], [[1.5, -0.5, 0, 0]], "sum up"),
        ([[1, 1, 0, 0]], [[0.5, 0.5, 0, 0]], "twice"),
        ([[1, 0, 0, 0]] * 2, [[1, 0, 0, 0]], "four weights"),
        ([[1, 0, 0, 0]], [[np.nan, 0, 0, 0]], "not finite"),
    ],
)
def test_what_is_no_skin_is_refused(joints, weights, said):
    with pytest.raises(ValueError, match=said):
        Skin(POSE, joints, weights)


def test_a_skin_of_another_mesh_is_refused():
    skin, mesh = skin_of(POSE)
    with pytest.raises(ValueError, match="as many vertices"):
        Solid(Mesh(mesh.vertices[:50], mesh.faces), skin=skin)
    with pytest.raises(ValueError, match="as many vertices"):
        Skin(POSE, skin.joints, skin.weights, rest=Mesh(mesh.vertices[:50], mesh.faces))


def test_a_mirror_turns_axes_over_and_leaves_them_right_handed():
    axes = Rotation.random(4, random_state=2).as_matrix()
    rig = Rig(REST, PARENTS, NAMES, axes=axes)
    mirror = Placement((-1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0))
    over = rig.placed(mirror)
    np.testing.assert_allclose(np.linalg.det(over.axes), 1.0)
    np.testing.assert_allclose(over.axes[:, :, 1:], np.diag([-1, 1, 1]) @ axes[:, :, 1:])
    np.testing.assert_allclose(over.placed(mirror).axes, axes, atol=1e-12)


@pytest.mark.parametrize(
    "axes", [np.zeros((4, 3, 3)), np.eye(3)[None], -np.tile(np.eye(3), (4, 1, 1))]
)
def test_axes_that_are_no_frames_are_refused(axes):
    with pytest.raises(ValueError, match="frame"):
        Rig(REST, PARENTS, NAMES, axes=axes)
