"""Symmetric drawings give symmetric plans, meshes and rigs, whatever their ink begins with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from bozzetto.plugin import Job
from bozzetto_silhouette.analysis.fidelity import measure
from bozzetto_silhouette.inflation.manifold_check import topology_of
from bozzetto_silhouette.inflation.solidify import solidify
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.outline.mirror_symmetry import mirrored_coordinate
from bozzetto_silhouette.outline.outline import outline_from_rings
from tests.plugins.silhouette.outlines import COMMITTED, circle, svg_rings
from tests.plugins.silhouette.rigging.characters import dense, fitted, man, state_of_rings

MODELER = Silhouette()
SYMMETRIC = ("heart", "asterisk", "dice-five", "life-ring", "mosquito", "snowflake")


def drawings():
    found = {name: fitted(svg_rings(COMMITTED / f"{name}.svg")) for name in SYMMETRIC}
    lying = [ring[:, ::-1] * [1.0, -1.0] for ring in found["heart"]]
    person = man(25.0, seed=12)
    return {
        **found,
        "heart on its side": lying,
        "person": [person],
        "person begun elsewhere": [np.roll(person, 37, axis=0)],
        "person drawn the other way": [person[::-1]],
    }


DRAWINGS = drawings()


def mirrored(points, axis):
    middle = 0.5 * (points[:, axis].min() + points[:, axis].max())
    turned = np.array(points, float)
    turned[:, axis] = 2.0 * middle - turned[:, axis]
    return turned


@pytest.mark.parametrize("name", DRAWINGS)
def test_every_vertex_joint_and_weight_has_its_mirror_image(name):
    state = state_of_rings(DRAWINGS[name], 48)
    result = MODELER.solve(replace(state, posing=True), Job("final"))
    vertices = result.mesh.vertices.astype(float)
    axis = 2 if name == "heart on its side" else 0
    gaps, partner = cKDTree(vertices).query(mirrored(vertices, axis))
    assert gaps.max() < 1e-4
    faces = {tuple(sorted(face)) for face in result.mesh.faces.tolist()}
    assert {tuple(sorted(partner[list(face)].tolist())) for face in faces} == faces
    found = topology_of(vertices, result.mesh.faces)
    assert found.watertight

    joints = result.skin.rig.joints
    middle = 0.5 * (vertices[:, axis].min() + vertices[:, axis].max())
    image = joints.copy()
    image[:, axis] = 2.0 * middle - image[:, axis]
    gaps, pair = cKDTree(joints).query(image)
    assert gaps.max() < 1e-4
    if name.startswith("person"):  # loops are cut on one side
        weights = dense(result.skin)
        # Which four joints a vertex keeps may hang on rounding.
        assert np.abs(weights[partner][:, pair] - weights).max() < 0.05


def test_names_of_a_symmetric_rig_pair_up():
    result = MODELER.solve(
        replace(state_of_rings(DRAWINGS["person"], 48), posing=True), Job("preview")
    )
    rig = result.skin.rig
    place = dict(zip(rig.names, rig.joints, strict=True))
    for name, joint in place.items():
        if name.endswith(".L"):
            np.testing.assert_allclose(place[name[:-1] + "R"], joint * [-1, 1, 1], atol=1e-4)


def test_what_is_not_symmetric_is_left_alone():
    ring = DRAWINGS["person"][0] / 200.0
    assert mirrored_coordinate((ring,)) == 0
    dented = ring.copy()
    dented[np.argmax(ring[:, 0])] *= 0.97
    assert mirrored_coordinate((dented,)) is None
    assert mirrored_coordinate((ring[:, ::-1],)) == 1


@pytest.mark.parametrize("gap", [0.02, 0.1, 0.5])
def test_what_is_narrow_at_the_axis_stays_as_it_was_drawn(gap):
    """Two pieces that nearly touch stay two, and a slit along the axis stays a hole."""
    across = 20.0 + 0.5 * gap
    pair = [circle(-across, 0.0, 20.0, 90), circle(across, 0.0, 20.0, 90)]
    slit = 0.5 * gap * np.array([[-1, -8], [1, -8], [1, 8], [-1, 8.0]]) * [1.0, 1.0 / gap]
    for rings in (pair, [circle(0.0, 0.0, 30.0, 90), slit[::-1]]):
        solid = solidify(outline_from_rings(rings), resolution=48)
        assert solid.soundness.ok, solid.soundness


def test_a_needle_that_is_only_nearly_symmetric_keeps_its_outline():
    """What a hand draws thin is not made symmetric at the cost of what it drew."""
    x = np.linspace(0.0, 300.0, 120)
    bent = 0.1 * np.sin(x / 300.0 * 2.0 * np.pi)
    upper, lower = 0.007 * x + bent, -0.007 * x + bent
    ring = np.vstack([np.column_stack([x, lower]), np.column_stack([x, upper])[::-1][:-1]])
    outline = outline_from_rings([ring])
    assert measure(solidify(outline, resolution=64)).iou > 0.995
