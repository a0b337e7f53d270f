"""Angles that the report tells are those that can be measured on the surfaces handed over."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from bozzetto.plugin import Job
from bozzetto_product import modeler
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.operations.curve_edits import move_joint
from bozzetto_product.operations.meetings import meeting_place, splines_of

SAMPLE = Path(modeler.__file__).parent / "samples" / "mouse.json"
STEP = 1e-6


@pytest.fixture(scope="module")
def mouse():
    return product_of_network(json.loads(SAMPLE.read_text()))


def bent(state):
    """The mouse with a joint moved, so that tangents there lie in no plane."""
    joint = state.joints[0]
    place = meeting_place(splines_of(state), joint.meetings[0], state.symmetry)
    return move_joint(state, joint.id, place + np.array((0.0, 2.0, 4.0)))


def border(face):
    """Places on the border of a face and normals there, by differences of places only."""
    surface = face.surface
    at = np.linspace(0.0, 1.0, 257)
    rows = [(at, 0 * at), (0 * at, at)]
    places, normals = [], []
    for u, v in rows:
        sense_u, sense_v = (np.where(x < 0.5, STEP, -STEP) for x in (u, v))
        here = surface.value(u, v)
        by_u = (surface.value(u + sense_u, v) - here) / sense_u[:, None]
        by_v = (surface.value(u, v + sense_v) - here) / sense_v[:, None]
        across = np.cross(by_u, by_v)
        places.append(here)
        normals.append(across / np.linalg.norm(across, axis=1, keepdims=True))
    return np.concatenate(places), np.concatenate(normals)


@pytest.mark.parametrize("change", [lambda state: state, bent], ids=["sound", "bent"])
def test_told_angles_are_those_measured_on_the_exact_faces(mouse, change):
    state = change(mouse)
    product = modeler.ProductModeler()
    result = product.solve(state, Job())
    told = {}
    for edge in product.report(state, result, Job())["edges"]:
        pair = frozenset(edge["patches"])
        if not edge["smooth"]:
            continue
        told[pair] = max(edge["angle_deg"], told.get(pair, 0.0))
    borders = {}
    for one in result.filled:
        rows = [border(face) for face in one.fill.brep.faces]
        borders[one.name] = tuple(np.concatenate(part) for part in zip(*rows, strict=True))
    for pair, angle in told.items():
        (here, first), (there, second) = (borders[name] for name in pair)
        distance, near = cKDTree(there).query(here)
        met = distance < 1e-7 * result.size
        assert met.sum() > 100
        sine = np.linalg.norm(np.cross(first[met], second[near[met]]), axis=1)
        measured = np.degrees(np.arctan2(sine, (first[met] * second[near[met]]).sum(axis=1)))
        assert angle == pytest.approx(float(measured.max()), abs=0.05)


def test_smooth_edges_of_a_sound_network_are_smooth(mouse):
    product = modeler.ProductModeler()
    edges = product.report(mouse, product.solve(mouse, Job()), Job())["edges"]
    smooth = [edge["angle_deg"] for edge in edges if edge["smooth"]]
    assert len(smooth) == 17
    assert max(smooth) < 0.05
