"""GLB of our own comes back as it left: written again it has the same bytes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bozzetto.exchange.export import encode_shapes
from bozzetto.exchange.import_file import read_mesh
from bozzetto.geometry import Clip, FaceGroup, Mesh, Shapes, Solid, Surface
from tests.core.exchange.skinned import skinned, tube
from tests.core.exchange.test_skins import opened
from tests.core.exchange.test_texture import painted_box


def written_again(shapes, tmp_path, *, trusted=True):
    """The bytes of shapes, and those of what is read of them."""
    data = encode_shapes(shapes, "a.glb")
    (tmp_path / "a.glb").write_bytes(data)
    back = read_mesh(tmp_path / "a.glb", trusted=trusted)
    return data, encode_shapes(back, "a.glb"), back


def differs(first, again):
    """In words what of a file is not the same in another one; nothing if they are the same."""
    if again == first:
        return ""
    (one, _), (other, _) = opened(first), opened(again)
    for key in one.keys() | other.keys():
        if one.get(key) != other.get(key):
            return f"{key}: {str(one.get(key))[:900]} / {str(other.get(key))[:900]}"
    at = next(k for k, (a, b) in enumerate(zip(first, again, strict=True)) if a != b)
    begin = at - (len(first) - one["buffers"][0]["byteLength"])
    views = enumerate(one["bufferViews"])
    return f"view {max(k for k, v in views if v['byteOffset'] <= begin)}: {one['accessors']}"


def moving(solid, seed=0, keys=9, shifts=False):
    """The solid with two motions, of some of its joints."""
    chance = np.random.default_rng(seed)
    count = len(solid.skin.rig.joints)
    clips = []
    for name in ("walk", "sway"):
        angles = chance.normal(0.0, 0.4, (keys, count, 3))
        angles[:, ::3] = 0.0
        turns = Rotation.from_rotvec(angles.reshape(-1, 3)).as_quat().reshape(keys, count, 4)
        moved = chance.normal(0.0, 3.0, (keys, count, 3)) if shifts else None
        clips.append(Clip(name, np.sort(chance.random(keys)) * 3.0, turns, moved))
    return replace(solid, skin=replace(solid.skin, clips=tuple(clips)))


def in_groups(solid, count=3):
    """The solid with its triangles in groups of their own colours and finishes."""
    size = len(solid.mesh.faces) // count
    rest = len(solid.mesh.faces) - size * (count - 1)
    finishes = ("metal", "glass", "matt", "rubber")
    groups = tuple(
        FaceGroup(f"group {k}", rest if k == count - 1 else size, (40 * k, 9, 255), finishes[k % 4])
        for k in range(count)
    )
    return replace(solid, groups=groups)


CASES = {
    "rest": lambda: skinned(7),
    "posed": lambda: skinned(7, 70.0),
    "axes": lambda: skinned(9, turned=True),
    "posed with axes": lambda: skinned(9, 50.0, turned=True),
    "many joints": lambda: skinned(300, 20.0, turned=True),
    "motions": lambda: moving(skinned(7, turned=True)),
    "motions of what is posed": lambda: moving(skinned(7, 40.0, turned=True), 3),
    "motions that shift": lambda: moving(skinned(5, turned=True), 4, shifts=True),
    "texture": lambda: replace(painted_box((90, 120, 40)), path=("a", "b")),
    "skin and texture": lambda: moving(skinned(7, 40.0, texture=True, turned=True), 5),
    "groups": lambda: in_groups(skinned(7, 30.0), 4),
    "one group": lambda: in_groups(painted_box(), 1),
    "colours": lambda: replace(
        skinned(4),
        mesh=replace(
            tube(),
            colors=np.random.default_rng(2).integers(0, 256, (len(tube().vertices), 4), np.uint8),
        ),
    ),
    "white": lambda: replace(skinned(4), color=(255, 255, 255)),
    "no colour": lambda: replace(skinned(4), color=None),
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("trusted", [True, False])
def test_what_is_written_again_has_the_same_bytes(tmp_path, case, trusted):
    solid = CASES[case]()
    first, again, _ = written_again(Shapes(solids=(solid,)), tmp_path, trusted=trusted)
    assert differs(first, again) == ""


@pytest.mark.parametrize("case", ["posed with axes", "motions", "skin and texture"])
@pytest.mark.parametrize("seed", range(4))
def test_places_of_any_size_keep_their_bytes(tmp_path, case, seed):
    """Coordinates without any pattern, in sizes from a grain to a house."""
    chance = np.random.default_rng(seed)
    solid = CASES[case]()
    size = 10.0 ** chance.uniform(-2, 3)
    turn = Rotation.random(random_state=seed).as_matrix()
    from bozzetto.geometry import Placement

    placed = solid.placed(Placement(tuple(turn.ravel().tolist()), size, (size, -3 * size, 7.0)))
    first, again, back = written_again(Shapes(solids=(placed,)), tmp_path)
    assert differs(first, again) == ""
    reach = np.ptp(placed.mesh.vertices, axis=0).max()
    np.testing.assert_allclose(
        back.solids[0].mesh.vertices, placed.mesh.vertices, atol=1e-5 * max(reach, 10 * size)
    )


def test_names_hierarchy_and_pictures_come_back(tmp_path):
    faces = tube().faces[:50]
    shapes = Shapes(
        solids=(
            replace(painted_box(), name="door", path=("car", "body")),
            Solid(tube(), "hinge", (20, 40, 60), path=("car", "body", "door")),
        ),
        surfaces=(Surface(Mesh(tube().vertices[: faces.max() + 1], faces), "foil", path=("car",)),),
    )
    first, again, back = written_again(shapes, tmp_path, trusted=False)
    assert differs(first, again) == ""
    assert [(p.name, p.path) for p in back.meshes()] == [(p.name, p.path) for p in shapes.meshes()]
    one, other = shapes.solids[0].texture, back.solids[0].texture
    np.testing.assert_array_equal(one.pixels, other.pixels)
    np.testing.assert_array_equal(one.corners, other.corners)
    assert len(back.solids[0].mesh.vertices) == 8


def test_a_rig_comes_back_as_it_is_posed_and_moves(tmp_path):
    solid = moving(skinned(7, 70.0, turned=True))
    (back,) = written_again(Shapes(solids=(solid,)), tmp_path)[2].solids
    rig, found = solid.skin.rig, back.skin.rig
    assert found.names == rig.names
    np.testing.assert_array_equal(found.parents, rig.parents)
    np.testing.assert_array_equal(found.cuts, rig.cuts)
    np.testing.assert_allclose(found.joints, rig.joints, atol=1e-4)
    np.testing.assert_allclose(found.axes, rig.axes, atol=1e-6)
    one, other = (Rotation.from_quat(r.turns) for r in (rig, found))
    assert (one.inv() * other).magnitude().max() < 1e-6
    np.testing.assert_allclose(back.skin.weights, solid.skin.weights, atol=1e-6)
    np.testing.assert_allclose(back.mesh.vertices, solid.mesh.vertices, atol=1e-4)
    np.testing.assert_allclose(back.skin.rest.vertices, solid.skin.rest.vertices, atol=1e-5)
    assert [clip.name for clip in back.skin.clips] == ["walk", "sway"]
    for clip, again in zip(solid.skin.clips, back.skin.clips, strict=True):
        np.testing.assert_allclose(again.seconds, clip.seconds, atol=1e-6)
        turned = (Rotation.from_quat(c.turns.reshape(-1, 4)) for c in (clip, again))
        first, second = turned
        assert (first.inv() * second).magnitude().max() < 1e-6


def test_parts_on_one_rig_share_it(tmp_path):
    one = moving(skinned(5, name="a"))
    other = replace(one, name="b")
    first, again, back = written_again(Shapes(solids=(one, other)), tmp_path, trusted=False)
    assert differs(first, again) == ""
    assert first.count(b'"inverseBindMatrices"') == 1
    a, b = back.solids
    assert a.skin.rig.joints is b.skin.rig.joints or np.array_equal(
        a.skin.rig.joints, b.skin.rig.joints
    )
