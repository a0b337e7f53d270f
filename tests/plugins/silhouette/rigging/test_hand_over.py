"""Rigs that animators get: bones with axes and names, each of which moves skin and tears none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.exchange.export import encode_shapes
from bozzetto.geometry import Shapes
from bozzetto.plugin import Job
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.rigging.bone_names import bone_names
from bozzetto_silhouette.rigging.posing import rig_of
from tests.core.exchange.test_skins import opened, shown
from tests.plugins.silhouette.outlines import COMMITTED, svg_rings
from tests.plugins.silhouette.rigging.characters import (
    dense,
    fitted,
    followers,
    man,
    state_of_rings,
    stretches,
)
from tests.plugins.silhouette.rigging.test_armature import turned

MODELER = Silhouette()
OUTLINES = ("hand-paper", "horse_skimage", "spider", "leaf", "key", "mosquito")


STATES = {
    "man": state_of_rings([man()]),
    "man, arms up": state_of_rings([man(35.0, seed=3)]),
    **{name: state_of_rings(fitted(svg_rings(COMMITTED / f"{name}.svg"))) for name in OUTLINES},
}
EVERY = pytest.mark.parametrize("state", STATES.values(), ids=STATES)


def solid_of(state):
    return MODELER.shapes(state, MODELER.solve(state, Job("final"))).solids[0]


@EVERY
def test_every_bone_moves_skin_and_no_turn_of_one_tears_it(state):
    solid = solid_of(state)
    assert (dense(solid.skin).sum(axis=0) > 0.0).all()
    assert stretches(solid.mesh, solid.skin).max() <= 1.8


@EVERY
def test_a_bone_points_to_the_next_and_its_third_axis_to_who_draws(state):
    rig = solid_of(state).skin.rig
    whole = rig_of(state)
    place = dict(zip(whole.names, whole.joints, strict=True))
    for joint, name in enumerate(rig.names):
        ends = whole.joints[whole.parents == whole.names.index(name)]
        np.testing.assert_allclose(rig.joints[joint], place[name])
        np.testing.assert_allclose(rig.axes[joint][:, 2], [0, -1, 0], atol=1e-9)
        if len(ends) == 1:
            way = ends[0] - rig.joints[joint]
            np.testing.assert_allclose(rig.axes[joint][:, 1], way / np.linalg.norm(way), atol=1e-9)


@pytest.mark.parametrize("name", ["man", "horse_skimage", "spider"])
def test_a_bone_moves_the_skin_around_its_middle(name):
    rings = [man()] if name == "man" else fitted(svg_rings(COMMITTED / f"{name}.svg"))
    solid = solid_of(state_of_rings(rings))
    rig, vertices = solid.skin.rig, solid.mesh.vertices.astype(float)
    moved = followers(solid.skin)
    shares = {}
    for joint in np.flatnonzero(np.bincount(rig.parents[rig.parents >= 0]) == 1):
        (child,) = np.flatnonzero(rig.parents == joint)
        middle = 0.5 * (rig.joints[joint] + rig.joints[child])
        near = np.argsort(np.linalg.norm(vertices - middle, axis=1))[:8]
        shares[rig.names[joint]] = moved[near, joint].mean()
    assert np.median(list(shares.values())) > 0.9
    # The first bone of a limb lies where the body gives way; all others have skin of their own.
    assert min(share for name, share in shares.items() if "-" in name) > 0.5


def test_a_person_has_a_spine_a_head_and_limbs_with_sides():
    rig = solid_of(state_of_rings([man(20.0, seed=8)])).skin.rig
    stems = {name.split(".")[0].split("-")[0] for name in rig.names}
    assert stems == {"Spine", "Head", "Arm", "Leg"}
    for name, place, parent in zip(rig.names, rig.joints, rig.parents, strict=True):
        assert name.count(".") <= 1
        assert (name[-2:] == ".L") == (place[0] > 3.0), "the left of who looks at us"
        assert (name[-2:] == ".R") == (place[0] < -3.0)
        assert name.startswith("Spine") or rig.joints[parent][2] != place[2]
    left = {name[:-2] for name in rig.names if name.endswith(".L")}
    assert left == {name[:-2] for name in rig.names if name.endswith(".R")}


def test_names_have_dots_for_sides_only_and_are_never_the_same():
    places = np.array([[0, 0, 0], [9, 0, 1], [-9, 0, 1], [0, 0, 9], [0, 0, -9]], float)
    parts = ["Body", "Arm.001", "Arm.001", "Part 4", "x" * 90]
    names = bone_names(places, [-1, 0, 0, 0, 0], parts)
    assert names == ("Body", "Arm 001.L", "Arm 001.R", "Head", "x" * 40)
    assert bone_names(places[:2] * [1, 0, 0], [-1, -1], ["", "Part 2"]) == ("Body", "Limb 1")
    many = bone_names(places, [-1, 0, 0, 0, 0], [".."] * 5)
    assert len(set(many)) == 5
    assert not any("." in name.removesuffix(".L").removesuffix(".R") for name in many)


def test_the_file_shows_a_pose_as_the_window_does():
    state = state_of_rings([man()])
    posed = turned(turned(state, 1, (0, 1, 0), 35), 8, (1, 0, 0), 20)
    solid = solid_of(posed)
    data = encode_shapes(Shapes(solids=(solid,)), "a.glb")
    np.testing.assert_allclose(shown(data, 0), solid.mesh.vertices, atol=1e-3)
    gltf, _ = opened(data)
    assert {gltf["nodes"][k]["name"] for k in gltf["skins"][0]["joints"]} == set(
        solid.skin.rig.names
    )


def test_what_was_drawn_from_the_front_looks_along_the_files_z():
    """+Z of glTF is what Blender calls front, -Y there."""
    gltf, values = opened(
        encode_shapes(Shapes(solids=(solid_of(state_of_rings([man()])),)), "a.glb")
    )
    binds = values(gltf["skins"][0]["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
    np.testing.assert_allclose(np.linalg.inv(binds)[:, :3, 2], [[0, 0, 1]] * len(binds), atol=1e-6)


def test_a_ball_keeps_its_one_joint():
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    ball = 20 * np.column_stack([np.cos(angle), np.sin(angle)])
    skin = solid_of(state_of_rings([ball])).skin
    assert len(skin.rig.joints) == 1
    assert (skin.weights[:, 0] == 1.0).all()
    assert replace(skin).rig.axes.shape == (1, 3, 3)
