"""Posed shapes while a slider is dragged: drafts that follow their joints, and nothing united."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from bozzetto.geometry import Mesh
from bozzetto.ink import Strokes
from bozzetto.plugin import Drag, Job
from bozzetto.plugin.cache import forget_all
from bozzetto.scene import DARK, LIGHT, Layer, Lines, Palette, Scene, Shaded, cast_rays
from bozzetto.scene.renderer import render
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto.view.navigation import fit
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.rigging.armature import armature_of
from bozzetto_silhouette.rigging.posing import joints_layer, posed_scene, turns_of
from bozzetto_silhouette.solids import boolean

MODELER = Silhouette()


def creature(limbs: int = 4, **changes) -> SilhouetteState:
    """A ball with fingers that lie across its rim."""
    pen = Pen()
    nodes = [Part(id="n0", name="Body", strokes=Strokes((pen.circle(600.0, 450.0, 150.0),)))]
    for k in range(limbs):
        turn = 2.0 * np.pi * k / limbs + 0.3
        x, y = np.cos(turn), np.sin(turn)
        along = np.linspace(110.0, 330.0, 20)
        side = np.concatenate([np.full(20, 22.0), np.full(20, -22.0)])
        far = np.concatenate([along, along[::-1]])
        ring = np.column_stack([600.0 + far * x - side * y, 450.0 + far * y + side * x])
        stroke = pen.along([*map(tuple, ring), tuple(ring[0])])
        nodes.append(Part(id=f"n{k + 1}", name=f"Limb {k + 1}", strokes=Strokes((stroke,))))
    return SilhouetteState(tuple(nodes), resolution=48, **changes)


def turned(state: SilhouetteState, angle: float, seed: int) -> SilhouetteState:
    """The state with half of its joints turned about any axes."""
    armature = armature_of(state)
    assert armature is not None
    random = np.random.default_rng(seed)
    axes = random.normal(size=(len(armature.rig.joints), 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    angles = np.where(random.random(len(axes)) < 0.5, angle, 0.0)
    angles[armature.rig.parents < 0] = 0.0
    halves = 0.5 * angles[:, None]
    return replace(state, turns=turns_of(armature, np.hstack([np.sin(halves) * axes,
                                                              np.cos(halves)])))  # fmt: skip


def points(state, quality):
    mesh = MODELER.solve(state, Job(quality)).shown
    return np.asarray(mesh.vertices, np.float64)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_posed_draft_lies_where_the_posed_solid_does(seed: int) -> None:
    state = turned(creature(), 0.7, seed)
    solid, draft = points(state, "final"), points(state, "preview")
    rest = points(replace(state, turns=()), "final")
    size = float(np.ptp(rest, axis=0).max())
    assert np.linalg.norm(solid - rest, axis=1).max() > 0.1 * size  # it did move
    gap = cKDTree(draft).query(solid)[0] / size
    assert np.quantile(gap, 0.99) < 0.02
    assert np.median(gap) < 0.005


def test_a_slider_of_a_posed_shape_unites_nothing(monkeypatch):
    state = turned(creature(), 0.5, 4)

    def meshed(*_):
        raise AssertionError("the tree was united")

    monkeypatch.setattr(boolean, "union_mesh", meshed)
    first = points(state, "preview")
    changed = points(state.with_node(replace(state.nodes[0], inflation=1.3)), "preview")
    assert np.ptp(changed[:, 1]) > np.ptp(first[:, 1]) + 1.0


def test_while_joints_turn_the_shape_is_what_was_made_of_its_parts():
    """A motion that plays must not lose its fillets, nor wait for a union."""
    state = replace(turned(creature(), 0.5, 5), selected="n0")
    forget_all()
    slid = points(state, "preview")
    points(state, "final")
    played = replace(turned(state, 0.6, 5), selected="n1")
    assert len(points(played, "preview")) != len(slid)
    assert np.allclose(points(played, "preview"), points(played, "final"), atol=1e-4)
    changed = state.with_node(replace(state.nodes[0], inflation=1.2))
    assert len(points(changed, "preview")) == len(slid)


def test_a_joint_is_dragged_on_the_draft():
    state = replace(turned(creature(), 0.3, 6), posing=True)
    MODELER.solve(state, Job("preview"))
    handle = joints_layer(state).items[-1]
    camera = Camera()
    (start,), _ = camera.project(np.array([handle.point]))
    path = Pen(camera).along([tuple(start), (start[0] + 60.0, start[1] - 40.0)])
    scene = posed_scene(state, Drag(handle.id, path))
    (shape,) = [item for layer in scene.layers for item in layer.items if isinstance(item, Shaded)]
    before = MODELER.solve(state, Job("preview")).shown
    moved = np.linalg.norm(shape.mesh.vertices - before.vertices, axis=1)
    assert len(before.faces) == len(shape.mesh.faces)
    assert 0.02 < (moved > 1.0).mean() < 0.6  # a limb, and not the others


def test_nothing_is_left_out_of_what_ink_files_draw_on():
    """Where pens land on it they land on the solid, fillets of the chosen part included."""
    state = replace(creature(), selected="n0")
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(300, 900, 7), np.arange(150, 750, 7)))
    rays = Camera().rays(np.column_stack([x, y]))
    hits = [
        cast_rays(MODELER.scene(state, MODELER.solve(state, job)), rays)
        for job in (Job("preview"), Job("preview", drawn_on=True), Job())
    ]
    solid = hits[-1]
    misses = []
    for some in hits[:-1]:
        both = some.hit & solid.hit
        assert both.mean() > 0.1
        misses.append(np.linalg.norm(some.points[both] - solid.points[both], axis=1))
    slid, drawn_on = misses
    assert slid.max() > 1.0  # mm: creases are sharp while a value is dragged
    assert drawn_on.max() < 1e-3


@pytest.mark.parametrize("palette", [LIGHT, DARK], ids=["light", "dark"])
@pytest.mark.parametrize("role", ["accent", "clay", "ink", "paper"])
def test_bones_are_seen_on_shapes_of_any_colour(role: str, palette: Palette) -> None:
    """Across each bone something stands out from the shape behind it."""
    state = creature(limbs=5)
    bones = joints_layer(state)
    mesh = MODELER.solve(state, Job("preview")).shown
    shape = Layer("shape", (Shaded(Mesh(mesh.vertices, mesh.faces, mesh.normals), color=role),))
    camera = fit(Camera().with_viewport(900, 700), Scene((shape,)).bounds())
    drawn, bare = (
        render(Scene(layers), camera, palette, size=(900, 700)).astype(float)[..., :3]
        for layers in ((shape, bones), (shape,))
    )
    lines = next(item for item in bones.items if isinstance(item, Lines))
    ends = camera.project(lines.points)[0].reshape(-1, 2, 2)
    ends = ends[np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) > 40.0]
    assert len(ends) >= 5
    for x, y in ends.mean(axis=1).astype(int):
        near = np.s_[y - 4 : y + 5, x - 4 : x + 5]
        assert np.abs(drawn[near] - bare[near]).max() > 80.0
