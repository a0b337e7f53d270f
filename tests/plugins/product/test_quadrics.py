"""Loops whose curves lie on a quadric: it is found, and nothing else is taken for one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Spline
from bozzetto.plugin import Job
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.quadric import Quadric, quadric_through
from bozzetto_product.fill.quadric_normals import quadric_turns
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.network.net import Net
from tests.plugins.product.detail_kit import solved
from tests.plugins.product.known_surfaces import (
    KnownLoop,
    ellipsoid,
    error_percent,
    estimated_normals,
    filled,
    graph,
    loop_on,
    polygon,
    random_loop,
    torus,
    true_normals,
)


def found(known: KnownLoop) -> Quadric | None:
    splines = [edge.spline for edge in known.net.edges]
    weights = np.concatenate([np.full(60, spline.length) for spline in splines])
    return quadric_through(np.concatenate([spline.sampled(60) for spline in splines]), weights)


@pytest.mark.parametrize("seed", range(602_000, 602_012, 2))
def test_fills_with_normals_of_a_quadric_are_that_quadric(seed: int) -> None:
    """Both kinds of even seeds, ellipsoids and graphs of second order, are quadrics."""
    known = random_loop(seed)
    quadric = found(known)
    assert quadric is not None
    places = np.concatenate([edge.spline.sampled(30) for edge in known.net.edges])
    cosines = np.abs((quadric.normals(places) * known.surface.normal(places)).sum(axis=1))
    assert np.degrees(np.arccos(np.minimum(cosines, 1.0))).max() < 0.2
    fill = filled(known, true_normals(known))
    assert not fill.folded
    assert error_percent(known, fill) < 0.004


def test_a_surface_on_a_ball_stands_across_its_radii() -> None:
    """What is made of normals, such as walls with a draft, depends on them, not on places."""
    unit = lambda x: x / np.linalg.norm(x, axis=1, keepdims=True)  # noqa: E731
    known = loop_on("octant", ellipsoid(1.0, 1.0, 1.0), np.eye(3), unit)
    at = np.linspace(0.0, 1.0, 21)
    u, v = (x.ravel() for x in np.meshgrid(at, at))
    for normals in (true_normals(known), estimated_normals(known)):
        for patch in filled(known, normals).patches:
            radii = unit(patch.value(u, v))
            sine = np.linalg.norm(np.cross(patch.normals(u, v), radii), axis=1)
            assert np.degrees(np.arcsin(sine)).max() < 0.06


@pytest.mark.parametrize("seed", [170_048, 170_100, 230_050, 913_144])
def test_a_surface_on_a_quadric_keeps_to_normals_that_curves_contradict(seed: int) -> None:
    """Curves of seven control points near a rim miss it, and true normals are not theirs."""
    known = random_loop(seed)
    normals = true_normals(known)
    fill = filled(known, normals)
    assert error_percent(known, fill) < 0.3
    assert np.nanmax(fill.g1_degrees) < 3.0


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_where_and_how_large_curves_are_does_not_matter(scale: float) -> None:
    random = np.random.default_rng(5)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    shift = np.array((40.0, -7.0, 300.0))
    known = random_loop(604_000)
    places = np.concatenate([edge.spline.sampled(30) for edge in known.net.edges])
    weights = random.uniform(0.5, 2.0, len(places))
    one = quadric_through(places, weights)
    other = quadric_through(scale * (places @ turn.T + shift), 7.0 * weights)
    assert one is not None
    assert other is not None
    normals = other.normals(scale * (places @ turn.T + shift)) @ turn
    assert np.abs((normals * one.normals(places)).sum(axis=1)).min() > 1.0 - 1e-9
    assert other.off == pytest.approx(scale * one.off, rel=1e-3, abs=1e-7 * scale)


@pytest.mark.parametrize("seed", range(602_001, 602_013, 2))
def test_a_torus_and_a_wave_are_no_quadrics(seed: int) -> None:
    assert found(random_loop(seed)) is None


def test_curves_through_which_many_quadrics_go_tell_none() -> None:
    """A circle in a plane, and a shallow cap of which the hand trembles more than it is high."""
    flat = graph(lambda x, y: 0.0 * x)
    assert found(loop_on("plane", flat, polygon(5, 0.3))) is None
    random = np.random.default_rng(3)
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    places = np.column_stack((np.cos(turn), np.sin(turn), 0.05 * np.cos(2.0 * turn)))
    places += 1e-3 * random.normal(size=places.shape)
    assert quadric_through(places, np.ones(len(places))) is None
    assert quadric_through(np.zeros((9, 3)), np.ones(9)) is None


def test_the_nearest_place_is_along_the_gradient_or_there_is_none() -> None:
    ball = ellipsoid(1.0, 1.0, 1.0)
    cap = np.array([[1, -0.6, -0.6], [1, 0.6, -0.6], [1, 0.6, 0.6], [1, -0.6, 0.6]])
    known = loop_on("cap", ball, cap, lambda x: x / np.linalg.norm(x, axis=1, keepdims=True), 12)
    quadric = found(known)
    assert quadric is not None
    near = quadric.nearest(np.array([(1.05, 0.02, 0.1)]))
    assert near is not None
    assert np.linalg.norm(near) == pytest.approx(1.0, abs=1e-4)
    assert quadric.nearest(np.array([(0.01, 0.0, 0.0)])) is None


@pytest.mark.parametrize("seed", [8_000_056, 8_000_144, 8_000_528, 8_000_030])
def test_the_quadric_through_a_loop_tells_the_normals_along_its_edges(seed: int) -> None:
    """Corners alone left them 4° to 14° off in the middle of edges, all to the same side."""
    known = random_loop(seed)
    normals = estimated_normals(known)
    for edge, field in zip(known.net.edges, normals.fields, strict=True):
        assert field is not None
        at = np.linspace(*edge.spline.range, 33)[8:25]
        cosine = (field.value(at) * known.surface.normal(edge.spline.value(at))).sum(axis=1)
        assert np.degrees(np.arccos(np.minimum(np.abs(cosine), 1.0))).max() < 1.5
    assert error_percent(known, filled(known, normals)) < 0.02


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_what_a_quadric_tells_of_normals_does_not_hang_on_size_or_place(scale: float) -> None:
    known = random_loop(8_000_144)
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    net = known.net
    moved = Net(
        scale * (net.nodes @ turn.T + 5.0),
        tuple(
            replace(
                edge,
                spline=Spline(
                    edge.spline.knots, scale * (edge.spline.control_points @ turn.T + 5.0)
                ),
            )
            for edge in net.edges
        ),
    )
    one = estimated_normals(known).fields
    other = estimated_normals(replace(known, net=moved)).fields
    for mine, theirs in zip(one, other, strict=True):
        assert mine is not None
        assert theirs is not None
        cosine = (mine.normals @ turn.T * theirs.normals).sum(axis=1)
        assert np.degrees(np.arccos(np.minimum(cosine, 1.0))).max() < 0.1


def test_a_crease_in_a_loop_or_normals_far_from_the_quadric_tell_nothing() -> None:
    known = random_loop(8_000_144)
    fields = dict(enumerate(estimated_normals(known).fields))
    smooth = {edge: [(0, edge, True)] for edge in fields}
    told = quadric_turns(known.net, [known.loop], smooth, fields)
    assert set(told) == set(fields)
    assert max(float(np.abs(turn).max()) for turn in told.values()) < np.radians(1.5)
    del smooth[0]
    assert quadric_turns(known.net, [known.loop], smooth, fields) == {}
    smooth[0] = [(0, 0, True)]
    leant = {edge: field.turned(lambda share: 0.3 + 0.0 * share) for edge, field in fields.items()}
    assert quadric_turns(known.net, [known.loop], smooth, leant) == {}


def test_the_torus_s_own_normals_do_not_make_it_a_quadric() -> None:
    chart = np.array([[0.0, -0.5], [0.7, -0.5], [0.7, 0.5], [0.0, 0.5]])
    known = loop_on("torus", torus(1.0, 0.4), chart)
    assert error_percent(known, filled(known, true_normals(known))) < 0.1


def _fill_of(**curves: np.ndarray) -> Fill:
    """Return the surface of the one loop of a network."""
    rows = [{"name": name, "points": points.tolist()} for name, points in curves.items()]
    result = solved(product_of_network({"network": {"curves": rows}, "unit": "mm"}))
    (patch,) = result.filled
    assert patch.surface is not None
    return patch.surface


def test_an_octant_that_stands_alone_is_the_ball_and_no_sweep() -> None:
    quarter = np.linspace(0.0, np.pi / 2, 25)[:, None]
    axes = 50.0 * np.linalg.qr(np.random.default_rng(81).normal(size=(3, 3)))[0]
    fill = _fill_of(
        **{
            f"c{k}": np.cos(quarter) * axes[k] + np.sin(quarter) * axes[(k + 1) % 3]
            for k in range(3)
        }
    )
    away = np.abs(np.linalg.norm(fill.mesh.vertices, axis=1) - 50.0)
    assert away.max() < 2e-4 * 50.0  # of the sweep it is 8e-3


def _cut_cylinder(notch: float, noise: float = 0.0) -> Fill:
    """Return the surface of half a cylinder of radius 25 with an uneven side, standing alone."""
    turn, height = np.linspace(0.0, np.pi, 41), np.linspace(0.0, 80.0, 41)

    def on(angle: np.ndarray, z: np.ndarray, seed: int) -> np.ndarray:
        places = np.column_stack((25 * np.cos(angle), 25 * np.sin(angle), z))
        shake = noise * np.random.default_rng(seed).normal(size=3) * np.sin(turn)[:, None] ** 2
        return places + shake

    low, high = on(turn, 0 * turn, 1), on(turn, 80 + 0 * turn, 2)
    uneven = on(notch * np.sin(np.pi * height / 80.0) ** 2, height, 3)
    return _fill_of(low=low, high=high, line=on(np.pi + 0 * turn, height, 4), uneven=uneven)


@pytest.mark.parametrize("notch", [0.2, 0.5, -0.4])
def test_creases_that_lie_exactly_on_one_quadric_have_that_for_a_surface(notch: float) -> None:
    """As faces of CAD do: they were up to 10 mm off."""
    places = _cut_cylinder(notch).mesh.vertices
    assert np.abs(np.hypot(places[:, 0], places[:, 1]) - 25.0).max() < 0.05


def test_creases_that_a_hand_drew_near_a_quadric_are_not_laid_on_it() -> None:
    assert _cut_cylinder(0.2).solution.loop.quadric is not None
    assert _cut_cylinder(0.2, noise=0.3).solution.loop.quadric is None


@pytest.mark.parametrize("slope", [5.0, 15.0])
def test_planes_that_meet_at_a_small_angle_stay_planes(slope: float) -> None:
    """A flat roof: below 35° its ridge was smooth, and both its sides bulged."""
    rise = 30.0 * np.tan(np.radians(slope))
    at = dict(zip("abcd", ((0, 0, 0), (60, 0, 0), (60, 90, 0), (0, 90, 0)), strict=True))
    at |= {high: np.add(at[low], (0, 0, 40)) for high, low in zip("efgh", "abcd", strict=True)}
    at |= {"r": np.array((30, 0, 40 + rise)), "s": np.array((30, 90, 40 + rise))}
    ways = (
        "ab",
        "bc",
        "cd",
        "da",
        "ae",
        "bf",
        "cg",
        "dh",
        "fg",
        "he",
        "er",
        "rf",
        "gs",
        "sh",
        "rs",
    )
    rows = [{"name": way, "points": [list(map(float, at[end])) for end in way]} for way in ways]
    state = product_of_network({"network": {"curves": rows}, "unit": "mm"})
    told = ProductModeler().report(state, solved(state), Job())
    assert told["closed"]
    assert not any(edge["smooth"] for edge in told["edges"])
    roof = 90.0 * np.hypot(30.0, rise)
    areas = [patch["area_mm2"] for patch in told["patches"] if "rs" in patch["curves"]]
    np.testing.assert_allclose(areas, roof, rtol=1e-6)
    smooth = product_of_network({"network": {"curves": rows, "creases": {"rs": 0}}, "unit": "mm"})
    told = ProductModeler().report(smooth, solved(smooth), Job())
    assert [edge["curve"] for edge in told["edges"] if edge["smooth"]] == ["rs"]
