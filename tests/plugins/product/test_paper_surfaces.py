"""Surfaces as in the paper: triangulation, V-spring, pressed membrane, groups, and what is told."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.plugin import Job
from bozzetto_product import modeler
from bozzetto_product.fill.fill_mesh import corner_ratios
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.model.details import Detail
from bozzetto_product.model.patches import CurveGroup, Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.paper.group_spring import evened_group
from bozzetto_product.paper.membrane import pressed, voronoi_areas
from bozzetto_product.paper.neighbours import edges_of
from bozzetto_product.paper.network_surfaces import paper_surfaces
from bozzetto_product.paper.triangulation import Triangles, inner_edges, triangulated
from bozzetto_product.paper.v_spring import relaxed, vertex_normals
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.solve.solver import loops_of_patch, net_of_state
from bozzetto_product.tools.detail import with_detail_drawn
from bozzetto_product.tools.pull import with_pull
from tests.plugins.product.known_surfaces import analytic_loops
from tests.plugins.product.noisy_sheets import sheets
from tests.plugins.product.shaver import shaver

SAMPLE = Path(modeler.__file__).parent / "samples" / "mouse.json"
LOOPS = analytic_loops()


def boundary_of(known, count=13):
    return np.concatenate([edge.spline.sampled(count)[:-1] for edge in known.net.edges])


def disc(count=72, radius=1.0):
    turn = 2 * np.pi * np.arange(count) / count
    ring = radius * np.column_stack((np.cos(turn), np.sin(turn), 0 * turn))
    return triangulated(ring, 2 * np.pi * radius / count)


@pytest.mark.parametrize("known", LOOPS, ids=lambda known: known.name)
def test_triangles_go_through_the_boundary_and_are_sound(known) -> None:
    ring = boundary_of(known)
    made = triangulated(ring, float(np.linalg.norm(np.diff(ring, axis=0), axis=1).max()))
    assert np.array_equal(made.points[: made.border], ring)
    assert len(made.points) - len(edges_of(made.faces)) + len(made.faces) == 1
    assert len(inner_edges(made.faces).ends) == len(edges_of(made.faces)) - made.border
    assert len(np.unique(made.faces)) == len(made.points)
    assert corner_ratios(made.points[made.faces]).min() > 0.3


def test_triangles_do_not_depend_on_the_unit() -> None:
    ring = boundary_of(LOOPS[3])
    one, other = triangulated(ring, 0.1), triangulated(1024.0 * ring, 102.4)
    assert np.array_equal(one.faces, other.faces)
    assert np.array_equal(1024.0 * one.points, other.points)


def cap(noise: float, seed: int) -> tuple[Triangles, np.ndarray]:
    """Part of the unit ball over a disc, and the same with noise on its inner points."""
    flat = disc(radius=0.8)
    true = flat.points.copy()
    true[:, 2] = np.sqrt(1.0 - (true[:, :2] ** 2).sum(axis=1))
    rough = true.copy()
    inner = slice(flat.border, None)
    size = noise * 2 * np.pi * 0.8 / flat.border
    random = np.random.default_rng(seed)
    rough[inner] *= 1.0 + size * random.normal(size=(len(rough) - flat.border, 1))
    return replace(flat, points=rough), true


@pytest.mark.parametrize("seed", [7001, 7002, 7003])
def test_the_v_spring_leaves_a_ball_of_a_rough_one(seed: int) -> None:
    rough, true = cap(0.3, seed)
    freedom = np.ones(len(true))
    freedom[: rough.border] = 0.0
    found = relaxed(rough.points, rough.faces, freedom)
    assert np.array_equal(found.points[: rough.border], rough.points[: rough.border])

    def off(points):
        return float(np.abs(np.linalg.norm(points, axis=1) - 1.0)[rough.border :].mean())

    assert off(found.points) < 0.3 * off(rough.points)
    # A Laplacian smoothing would flatten it.
    assert found.points[:, 2].max() > 0.97


def test_the_v_spring_does_not_depend_on_the_unit_and_leaves_planes_plane() -> None:
    rough, _ = cap(0.3, 7004)
    freedom = np.ones(len(rough.points))
    freedom[: rough.border] = 0.0
    one = relaxed(rough.points, rough.faces, freedom)
    other = relaxed(1024.0 * rough.points, rough.faces, freedom)
    assert other.iterations == one.iterations
    assert np.abs(other.points / 1024.0 - one.points).max() < 1e-12
    flat = disc()
    level = relaxed(flat.points, flat.faces, np.ones(len(flat.points)))
    assert np.abs(level.points[:, 2]).max() == 0.0


def cap_volume(height: float) -> float:
    return np.pi * height * (3 + height**2) / 6


@pytest.mark.parametrize("height", [1 / 3, 1.0, 1.4])
def test_pressure_makes_caps_of_a_disc_through_the_half_ball(height: float) -> None:
    flat = disc()
    found = pressed(flat, cap_volume(height))
    assert not found.limited
    assert abs(found.points[:, 2].max() / height - 1) < 0.01
    assert np.array_equal(found.points[: flat.border], flat.points[: flat.border])
    sunk = pressed(flat, -cap_volume(height))
    assert np.abs(sunk.points * (1, 1, -1) - found.points).max() < 1e-6


def test_pressed_vertices_are_at_rest_as_the_paper_says() -> None:
    """Pressure on each vertex equals what its neighbours hold it back with."""
    ring = boundary_of(LOOPS[1])
    start = triangulated(ring, 0.1)
    found = pressed(start, 0.05)
    places, way = found.points, found.points - start.points
    neighbours: dict[int, list[int]] = {}
    for one, other in edges_of(start.faces).tolist():
        neighbours.setdefault(one, []).append(other)
        neighbours.setdefault(other, []).append(one)
    push = found.pressure * (
        voronoi_areas(places, start.faces)[:, None] * vertex_normals(places, start.faces)
    )
    for vertex in range(start.border, len(places)):
        back = way[vertex] - way[neighbours[vertex]].mean(axis=0)
        assert np.linalg.norm(push[vertex] - back) < 1e-3 * np.linalg.norm(push[vertex])


def test_voronoi_areas_fill_the_surface() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0.1, 0.2, 0.0], [0.5, 1.0, 0.4]])
    faces = np.array([[0, 1, 2], [2, 1, 3]])
    sides = points[faces]
    whole = 0.5 * np.linalg.norm(
        np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0]), axis=1
    )
    assert abs(voronoi_areas(points, faces).sum() - whole.sum()) < 1e-12
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    quarters = voronoi_areas(square, np.array([[0, 1, 2], [0, 2, 3]]))
    assert np.abs(quarters - 0.25).max() < 1e-12


def joint_angles(net, surfaces, between) -> np.ndarray:
    """Degrees between the normals of two surfaces at the points of edges between them."""
    found = []
    for edge in between:
        rows = [
            one.normals[one.border_of(place)]
            for one in surfaces
            for place, (number, _) in enumerate(one.loop)
            if number == edge
        ]
        cosine = (rows[0] * rows[1]).sum(axis=1)
        found.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return np.concatenate(found)


def test_the_v_spring_takes_angles_out_of_a_group_whether_curves_are_held_or_not() -> None:
    sheet = next(sheets(0.02, 7100))
    surfaces = paper_surfaces(sheet.net, sheet.loops)
    inner = sorted(
        set.intersection(
            *[
                {edge for number in row for edge, _ in sheet.loops[number]}
                for row in (list(sheet.members)[:2], list(sheet.members)[2:])
            ]
        )
    )
    before = joint_angles(sheet.net, surfaces, inner)
    plane = Reflection(ProductState().symmetry)
    held = evened_group(sheet.net, surfaces, sheet.members, 1.0, 0.0, plane)
    free = evened_group(sheet.net, surfaces, sheet.members, 1.0, 1.0, plane)
    assert np.median(joint_angles(held.net, held.surfaces, inner)) < 0.6 * np.median(before)
    assert np.median(joint_angles(free.net, free.surfaces, inner)) < 0.6 * np.median(before)
    assert held.net is sheet.net
    assert set(inner) <= free.moved
    for number, (one, other) in enumerate(zip(surfaces, held.surfaces, strict=True)):
        border = slice(0, one.triangles.border)
        assert np.array_equal(one.triangles.points[border], other.triangles.points[border])
        assert (number in sheet.members) != (one is other)
    for one in free.surfaces:
        for place, (edge, _) in enumerate(one.loop):
            spline, rows = free.net.edges[edge].spline, one.triangles.points[one.border_of(place)]
            gaps = np.linalg.norm(spline.value(spline.foot_points(rows)) - rows, axis=1)
            assert gaps.max() < 1e-9 * sheet.diagonal


def test_half_the_weight_goes_half_the_way() -> None:
    sheet = next(sheets(0.02, 7101))
    surfaces = paper_surfaces(sheet.net, sheet.loops)
    plane = Reflection(ProductState().symmetry)
    half, whole = (
        evened_group(sheet.net, surfaces, sheet.members, weight, 0.0, plane).surfaces
        for weight in (0.5, 1.0)
    )
    for one, middle, other in zip(surfaces, half, whole, strict=True):
        mean = 0.5 * (one.triangles.points + other.triangles.points)
        assert np.abs(middle.triangles.points - mean).max() < 1e-12


def mouse(**changes) -> ProductState:
    return replace(product_of_network(json.loads(SAMPLE.read_text())), surfaces="paper", **changes)


def solved(state: ProductState) -> ProductResult:
    return modeler.ProductModeler().solve(state, Job())


def test_a_product_closes_with_surfaces_as_in_the_paper_and_tells_what_files_hold() -> None:
    product, state = modeler.ProductModeler(), mouse()
    result = solved(state)
    (body,) = product.shapes(state, result).solids
    assert body.exact is None
    sides = np.concatenate([body.mesh.faces[:, [k, (k + 1) % 3]] for k in range(3)])
    keys = {tuple(row) for row in sides.tolist()}
    assert len(keys) == len(sides)
    assert all((b, a) in keys for a, b in keys)
    told = " ".join(caution.message for caution in product.cautions(state, result))
    assert "STEP, IGES and 3DM get the curves" in told
    fair = replace(state, surfaces="fair")
    assert product.shapes(fair, solved(fair)).solids[0].exact is not None


def test_mirror_images_are_exact() -> None:
    state = shaver()
    net = net_of_state(state)
    twins = [patch for patch in state.of_kind(Patch) if patch.mirrored][:4]
    pairs = [loops_of_patch(net, patch) for patch in twins]
    loops = orient_loops(net, [loop for pair in pairs for loop in pair]).loops
    made = paper_surfaces(net, loops)
    for one, other in zip(made[::2], made[1::2], strict=True):
        there = {tuple(row) for row in (one.mesh.vertices * np.float32((1, -1, 1))).tolist()}
        assert there == {tuple(row) for row in other.mesh.vertices.tolist()}
        assert one.folded == other.folded
        up = one.normals.sum(axis=0) * (1, -1, 1)
        assert up @ other.normals.sum(axis=0) > 0


def test_a_group_is_evened_and_its_curves_give_way_by_their_share() -> None:
    state = mouse()
    inside = tuple(
        replace(node, within="g", pressure=0.1) if isinstance(node, Patch) else node
        for node in state.nodes
    )
    product = modeler.ProductModeler()

    def angles_and_curves(**shares):
        group = CurveGroup("g", "Group", **shares)
        changed = replace(state, nodes=(*inside, group))
        result = solved(changed)
        report = product.report(changed, result, Job())
        smooth = [edge["angle_deg"] for edge in report["edges"] if edge["smooth"]]
        off = max(patch["boundary_error_mm"] for patch in report["patches"])
        return float(np.median(smooth)), off, result

    plain, _, _ = angles_and_curves()
    held, off_held, kept = angles_and_curves(v_spring=1.0)
    free, off_free, gone = angles_and_curves(v_spring=1.0, let_go=1.0)
    assert held < plain
    assert free < plain
    assert not kept.let_go
    assert gone.let_go
    assert max(off_held, off_free) < 1e-4
    assert gone.is_closed


def test_pulls_and_details_are_refused_with_a_way_out(stroke) -> None:
    for change in (
        lambda state: with_pull(state, stroke),
        lambda state: with_detail_drawn(state, [stroke]),
    ):
        with pytest.raises(UserError, match="“Fair”"):
            change(mouse())


def test_details_of_a_recipe_are_kept_and_told() -> None:
    state = mouse()
    state = replace(state, nodes=(*state.nodes, Detail("d", "Badge")))
    told = " ".join(c.message for c in modeler.ProductModeler().cautions(state, solved(state)))
    assert "leave details out" in told
    assert state.of_kind(Detail)


@pytest.fixture
def stroke():
    from bozzetto.ink import Stroke
    from bozzetto.view import Camera

    return Stroke(np.array([100.0, 120.0, 140.0]), np.array([100.0, 110.0, 100.0]), Camera())
