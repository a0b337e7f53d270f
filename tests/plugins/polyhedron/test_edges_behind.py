"""Edges behind the solid: faint, dashed or not at all, judged by rays and by pixels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.plugin import Job
from bozzetto.scene import LIGHT, Lines, Scene, Shaded, cast_rays, render
from bozzetto.view import Camera, fit_points
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solve.pipeline import solved
from tests.plugins.polyhedron.figures_open_boxes import lidded_box
from tests.plugins.polyhedron.linkages import played
from tests.plugins.polyhedron.objects import OBJECTS
from tests.plugins.polyhedron.test_folds import folds, hinged, read

MODELER = PolyhedronModeler()
SIZE = (480, 360)
HOLES = ("hole", "five stairs", "U")


def scene(state, behind: str) -> Scene:
    state = replace(state, behind=behind)
    return MODELER.scene(state, MODELER.solve(state, Job()))


def only(scene: Scene, kinds) -> Scene:
    """Return the solid of a scene: its faces alone, or with its edges."""
    layers = [
        replace(layer, items=tuple(item for item in layer.items if isinstance(item, kinds)))
        for layer in scene.layers
        if layer.name == "solid"
    ]
    return Scene(tuple(layers))


def picture(scene: Scene, camera: Camera) -> np.ndarray:
    return render(scene, camera, LIGHT, size=SIZE).astype(int)


def near(changed: np.ndarray, pixel: np.ndarray, reach: int = 1) -> bool:
    x, y = np.round(pixel - 0.5).astype(int)
    return bool(changed[max(y - reach, 0) : y + reach + 1, max(x - reach, 0) : x + reach + 1].any())


@pytest.mark.parametrize("turn", [0.4, 1.9, 3.3])
@pytest.mark.parametrize("name", HOLES)
def test_hidden_edges_are_gone_and_what_is_seen_through_a_hole_is_not(name, turn):
    state = read(OBJECTS[name])
    body = solved(state.nodes[0], state).body
    eye = 900.0 * np.array([np.cos(turn), np.sin(turn), 0.6])
    view = Camera(eye=tuple(eye), viewport=SIZE)
    view = fit_points(view, body.vertices)
    drawn = {
        how: picture(only(scene(state, how), (Shaded, Lines)), view) for how in ("faint", "hide")
    }
    bare = picture(only(scene(state, "hide"), Shaded), view)
    changed = {how: (np.abs(each - bare) > 12).any(axis=2) for how, each in drawn.items()}
    samples = np.concatenate(
        [
            body.vertices[one]
            + np.linspace(0.03, 0.97, 60)[:, None] * (body.vertices[two] - body.vertices[one])
            for one, two in edges_of(body.faces)
        ]
    )
    pixels = view.project(samples)[0]
    rays = view.rays(pixels)
    away = np.einsum("ij,ij->i", samples - rays.origins, rays.directions)
    hits = cast_rays(only(scene(state, "hide"), Shaded), rays)
    seen = ~hits.hit | (hits.distance > away - 0.5)
    apart = np.linalg.norm(pixels[~seen][:, None] - pixels[seen], axis=2).min(axis=1) > 5.0
    clear = ~hits.hit | (hits.distance > away - 1e-3) & (hits.distance > 0.0)
    assert seen.sum() > 100
    assert apart.sum() > 20
    hidden = pixels[~seen][apart]
    assert not any(near(changed["hide"], pixel) for pixel in hidden)
    assert np.mean([near(changed["faint"], pixel) for pixel in hidden]) > 0.95
    assert np.mean([near(changed["hide"], pixel) for pixel in pixels[seen & clear]]) > 0.97


def test_what_has_moved_hides_its_edges_as_well():
    state = read(lidded_box(80_100))
    (fold,) = folds(state)
    state = played(replace(hinged(state, fold), gravity=True), 0.2)
    for how in ("faint", "dashed", "hide"):
        lines = [
            item
            for layer in scene(state, how).layers
            if layer.name == "solid"
            for item in layer.items
            if isinstance(item, Lines)
        ]
        assert {line.hidden for line in lines} == {how}
