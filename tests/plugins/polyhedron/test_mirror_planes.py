"""Measures of many shapes at once are those of each alone."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from bozzetto_polyhedron.reconstruction.mirror_planes import mirror_normals, mirror_planes
from bozzetto_polyhedron.reconstruction.parallel_classes import parallel_classes
from bozzetto_polyhedron.reconstruction.regularity import MEASURES, all_measures, relief_of
from tests.plugins.polyhedron.objects import OBJECTS, View, graph_of, made, view

SCALE = 0.08


def fits(corners: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return how well each plane mirrors corners, the best first, from the images themselves."""
    centred = corners - corners.mean(0)
    centred = centred / np.sqrt((centred**2).sum(1).mean())
    found = []
    for normal in normals:
        images = centred - 2.0 * np.outer(centred @ normal, normal)
        nearest = ((images[:, None] - centred) ** 2).sum(2).min(1)
        found.append(float((1.0 / (1.0 + nearest / SCALE**2)).mean()))
    return np.sort(found)[::-1]


def test_planes_of_many_shapes_fit_as_their_images_say() -> None:
    rng = np.random.default_rng(4)
    corners = rng.normal(size=(5, 9, 3))
    normals = rng.normal(size=(5, 6, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    normals[1, 4] = -normals[1, 2]
    normals[2, 3] = 0.0
    normals[3, 1:] = 0.0
    found = mirror_planes(corners, normals, SCALE)
    for number in range(5):
        tried = [each for each in normals[number] if each.any()]
        if number == 1:
            del tried[4]
        expected = fits(corners[number], np.array(tried))
        assert found[number, 0] == pytest.approx(expected[0])
        further = expected[1:3].mean() if len(expected) > 1 else 0.0
        assert found[number, 1] == pytest.approx(further)


def test_a_box_has_three_planes_and_a_sheared_one_none() -> None:
    box = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], float)
    sheared = box + np.outer(box[:, 2], (0.4, 0.7, 0.0))
    edges = np.tile(np.eye(3), (2, 1, 1))
    edges[1, 2] = (0.4, 0.7, 1.0)
    edges /= np.linalg.norm(edges, axis=2, keepdims=True)
    normals = mirror_normals(edges, np.zeros((2, 0, 3)))
    found = mirror_planes(np.stack((box, sheared)), normals, SCALE)
    assert found[0] == pytest.approx((1.0, 1.0))
    assert (found[1] < 0.5).all()


@pytest.mark.parametrize("name", ["box", "house", "wedge step", "hexagonal prism"])
def test_what_stands_upright_does_so_until_the_sheet_is_turned(name: str) -> None:
    solid, upright = OBJECTS[name], MEASURES.index("stands upright")
    azimuth, elevation = 0.6, 0.5
    about = np.array(
        [(np.cos(azimuth), np.sin(azimuth), 0), (-np.sin(azimuth), np.cos(azimuth), 0), (0, 0, 1)]
    )
    sine, cosine = np.sin(elevation), np.cos(elevation)
    seen = (solid.vertices - solid.vertices.mean(0)) @ about.T
    seen = seen @ np.array([(1, 0, 0), (0, sine, cosine), (0, cosine, -sine)]).T
    found = []
    for turned in np.radians((0.0, 2.0, 30.0)):
        c, s = np.cos(turned), np.sin(turned)
        space = seen @ np.array([(c, -s, 0), (s, c, 0), (0, 0, 1)]).T
        plane = space / np.linalg.norm(np.ptp(space[:, :2], axis=0))
        graph, _ = graph_of(View(solid, plane, plane[:, :2]), 0.0, 1)
        drawing = drawing_of(graph)
        classes = parallel_classes(drawing)
        relief = relief_of(
            drawing.points,
            plane[:, 2:],
            drawing.lines,
            classes.labels,
            classes.directions,
            solid.faces,
            drawing.noise,
        )
        found.append(float(all_measures(relief, np.array([(1.0, 0.0, 0.0)]))[0, upright]))
    assert found[0] > 0.99
    assert found[1] > 0.7
    assert found[2] < 0.3


@pytest.mark.parametrize("seed", [1000, 1001, 1003])
def test_measures_of_many_maps_are_those_of_each_alone(seed: int) -> None:
    seen = view(made(seed), seed)
    assert seen is not None
    drawing = drawing_of(graph_of(seen, 0.01, seed)[0])
    classes = parallel_classes(drawing)
    relief = relief_of(
        drawing.points,
        seen.space[:, 2:] + 0.01 * np.sin(np.arange(len(seen.space)))[:, None],
        drawing.lines,
        classes.labels,
        classes.directions,
        seen.solid.faces,
        drawing.noise,
    )
    maps = np.random.default_rng(seed).normal((1.0, 0.0, 0.0), 0.4, (7, 3))
    found = all_measures(relief, maps)
    assert found.shape == (7, len(MEASURES))
    assert all_measures(relief, maps[:0]).shape == (0, len(MEASURES))
    for each, row in zip(maps, found, strict=True):
        assert all_measures(relief, each[None])[0] == pytest.approx(row)
