"""The patches of the templates as surfaces, by the Coons formula written out here."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.geometry.patches import extent
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import Patch, Template
from bozzetto_car.template.network import Network

Array = NDArray[np.float64]

SAMPLES = 13
STEP = 1e-5
"""For differences of the surface; its own units are patches."""

VISIBLE_BREAK = 0.1
"""Degrees; surface modelling programs call a crease below this smooth."""


def curve(template: Template, edge: int, u: Array) -> Array:
    """Places on an edge, by de Casteljau's scheme."""
    points = template.control_points[max(edge, ~edge)]
    points = (points if edge >= 0 else points[::-1])[:, None] + 0.0 * u[:, None]
    for _ in range(3):
        points = (1.0 - u[:, None]) * points[:-1] + u[:, None] * points[1:]
    return np.asarray(points[0])


def coons(template: Template, patch: Patch, u: Array, v: Array) -> Array:
    """The bicubically blended Coons patch: two lofts minus the corners (Coons 1967)."""
    bottom, right, top, left = patch.edges
    h0, h3 = (1.0 + 2.0 * u) * (1.0 - u) ** 2, u**2 * (3.0 - 2.0 * u)
    g0, g3 = (1.0 + 2.0 * v) * (1.0 - v) ** 2, v**2 * (3.0 - 2.0 * v)
    low, high = curve(template, bottom, u), curve(template, ~top, u)
    west, east = curve(template, ~left, v), curve(template, right, v)
    p0, p1, p2, p3 = template.positions[list(patch.nodes)]
    corners = (
        (h0 * g0)[:, None] * p0
        + (h3 * g0)[:, None] * p1
        + (h3 * g3)[:, None] * p2
        + (h0 * g3)[:, None] * p3
    )
    across = g0[:, None] * low + g3[:, None] * high
    along = h0[:, None] * west + h3[:, None] * east
    return np.asarray(across + along - corners)


def normals(template: Template, patch: Patch, u: Array, v: Array) -> Array:
    """x_u × x_v by central differences, one-sided at the boundary by continuing the cubics."""
    by_u = coons(template, patch, u + STEP, v) - coons(template, patch, u - STEP, v)
    by_v = coons(template, patch, u, v + STEP) - coons(template, patch, u, v - STEP)
    return np.asarray(np.cross(by_u, by_v) / (2.0 * STEP) ** 2)


@pytest.fixture(params=TEMPLATES)
def template(request: pytest.FixtureRequest) -> Template:
    return bundled(request.param)


@lru_cache
def grid() -> tuple[Array, Array]:
    u, v = np.meshgrid(np.linspace(0, 1, SAMPLES), np.linspace(0, 1, SAMPLES), indexing="ij")
    return u.ravel(), v.ravel()


def test_surfaces_have_a_normal_everywhere_that_points_outward(template: Template) -> None:
    front, rear = template.positions[template.wheels[:, 0], 0]
    for patch in template.patches:
        across = normals(template, patch, *grid())
        assert np.linalg.norm(across, axis=1).min() > 5e4  # mm² for the whole patch
        places = coons(template, patch, *grid())
        # Outward of a beam along the car that every part of the body lies around.
        along = np.clip(places[:, 0], front - 180.0, rear - 250.0)
        beam = along, 0.0 * along, np.full(len(places), 600.0)
        assert ((places - np.stack(beam, axis=1)) * across).sum(axis=1).min() > 0.0


def test_surfaces_lie_open_and_do_not_fold(template: Template) -> None:
    """The normal of a patch never turns as far as a right angle from its mean."""
    for patch in template.patches:
        across = normals(template, patch, *grid())
        unit = across / np.linalg.norm(across, axis=1, keepdims=True)
        assert (unit @ unit.mean(axis=0)).min() > 0.5


def test_the_highest_point_of_the_roof_is_the_highest(template: Template) -> None:
    box = extent(fair_nets(Network.of(template)))
    assert "highest point" in template.titles["C4"]
    assert box[1, 2] == pytest.approx(template.positions[template.node["C4"], 2], abs=0.01)


def crease(template: Template, edge: int) -> float:
    """Largest angle, degrees, of the normals of the two patches along an edge."""
    at = np.linspace(0.0, 1.0, SAMPLES)
    still = np.zeros(SAMPLES)
    found = []
    for patch in template.patches:
        for number, its in enumerate(patch.edges):
            if its in (edge, ~edge):
                run = at if its >= 0 else 1.0 - at
                u, v = [
                    (run, still),
                    (still + 1.0, run),
                    (1.0 - run, still + 1.0),
                    (still, 1.0 - run),
                ][number]
                across = normals(template, patch, u, v)
                found.append(across / np.linalg.norm(across, axis=1, keepdims=True))
    one, other = found
    sine = np.linalg.norm(np.cross(one, other), axis=1)
    return float(np.degrees(np.arctan2(sine, (one * other).sum(axis=1))).max())


def smooth_across(template: Template) -> list[int]:
    """Edges that smooth chains cross at both ends."""
    inner = [
        (node, frozenset(max(edge, ~edge) for edge in chain.edges[at - 1 : at + 1]))
        for chain in template.chains
        for node in chain.smooth
        for at in [chain.nodes.index(node)]
    ]
    found = []
    for number, ends in enumerate(template.edges.tolist()):
        beside = [
            {max(edge, ~edge) for edge in patch.edges}
            for patch in template.patches
            if number in patch.edges or ~number in patch.edges
        ]
        if len(beside) == 2 and all(
            any(
                node == end
                and number not in crossing
                and len(crossing & beside[0]) == len(crossing & beside[1]) == 1
                for node, crossing in inner
            )
            for end in ends
        ):
            found.append(number)
    return found


def test_surfaces_are_smooth_across_every_edge_that_smooth_chains_cross(
    template: Template,
) -> None:
    """Parallel tangents at both ends are not enough: their ratios must agree, too."""
    edges = smooth_across(template)
    names = {template.edge_names[edge] for edge in edges}
    middle = {"C0-C1", "C1-C2", "C2-C3", "C3-C4", "C4-C5", "C5-C6", "C6-C7", "C7-C8"}
    assert middle | {"C4-R2.R", "S2.R-B2.R", "S3.R-B3.R", "S4.R-B4.R"} <= names
    for edge in edges:
        assert crease(template, edge) < VISIBLE_BREAK, template.edge_names[edge]


def test_a_car_has_edges_where_cars_have_them(template: Template) -> None:
    """The bonnet's front, the cowl, the waistline and the roof rail are meant to be seen."""
    for name in ("C1-S1.R", "C2-S2.R", "S3.R-S2.R", "R2.R-R1.R"):
        assert crease(template, template.edge_names.index(name)) > 10.0, name


def test_pictures_show_their_nodes(template: Template) -> None:
    """A ray from the node to the eye of its picture meets no other part of the body."""
    u, v = grid()
    rows = np.arange(SAMPLES * SAMPLES).reshape(SAMPLES, SAMPLES)
    a, b, c, d = (
        part.ravel() for part in (rows[:-1, :-1], rows[1:, :-1], rows[1:, 1:], rows[:-1, 1:])
    )
    faces = np.concatenate((np.stack((a, b, c), 1), np.stack((a, c, d), 1)))
    triangles = np.concatenate([coons(template, patch, u, v)[faces] for patch in template.patches])
    corner, one, two = triangles[:, 0], *(triangles[:, i] - triangles[:, 0] for i in (1, 2))
    wheels = set(template.wheels.ravel().tolist())  # their centres lie within the body
    for number, name in enumerate(template.names):
        if number in wheels:
            continue
        eye = template.pictures[name].toward_eye
        # Möller & Trumbore (1997), from 3 cm before the node: patches at it do not count.
        start = template.positions[number] + 30.0 * eye
        p = np.cross(eye, two)
        det = (one * p).sum(axis=1)
        det = np.where(np.abs(det) < 1e-9, np.inf, det)
        s = ((start - corner) * p).sum(axis=1) / det
        q = np.cross(start - corner, one)
        t = q @ eye / det
        way = (two * q).sum(axis=1) / det
        assert not ((s >= 0) & (t >= 0) & (s + t <= 1) & (way > 0)).any(), name
