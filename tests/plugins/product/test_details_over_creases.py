"""Details with floors over creases: one floor on each side, mitred, and walls all round."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bozzetto.geometry import Solid
from bozzetto.ink import Stroke
from bozzetto.plugin import Job
from bozzetto.view import Camera
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.shapes import shapes_of
from bozzetto_product.model.details import Detail
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.solve.solver import solve_product
from bozzetto_product.tools.detail import with_detail_drawn
from tests.plugins.product.detail_kit import manifold
from tests.plugins.product.test_details_over_edges import over_edge, solved, volume
from tests.plugins.product.test_network_file import box

SIZE = np.array((100.0, 60.0, 40.0))
WHOLE = float(SIZE.prod())
CASES = [(kind, draft) for kind in ("in", "raised", "button") for draft in (0.0, 4.0)]


def rectangle(width: float, top: float, front: float, steps: int = 8) -> list[list[float]]:
    """A rectangle over the edge of the box, square to it, so far on the top and on the front."""
    a, b = 50.0 - 0.5 * width, 50.0 + 0.5 * width
    corners = [(a, front), (b, front), (b, -top), (a, -top)]
    share = np.arange(steps)[:, None] / steps
    after = [*corners[1:], corners[0]]
    flat = np.concatenate(
        [
            (1.0 - share) * np.array(p) + share * np.array(q)
            for p, q in zip(corners, after, strict=True)
        ]
    )
    x, s = flat.T
    return np.column_stack((x, np.maximum(-s, 0.0), 40.0 - np.maximum(s, 0.0))).tolist()


def seen_along(
    way: tuple[float, float, float],
    middle: tuple[float, float, float],
    radii: tuple[float, float],
    turn: float,
    count: int = 64,
) -> list[list[float]]:
    """An ellipse across a direction, let down along it on to the box."""
    d = np.array(way) / np.linalg.norm(way)
    x = np.cross(d, (0.3, 0.2, 1.0))
    x /= np.linalg.norm(x)
    y = np.cross(d, x)
    a = 0.37 + np.arange(count) / count * 2.0 * np.pi
    p, q = radii[0] * np.cos(a), radii[1] * np.sin(a)
    p, q = np.cos(turn) * p - np.sin(turn) * q, np.sin(turn) * p + np.cos(turn) * q
    from_far = np.array(middle) + p[:, None] * x + q[:, None] * y - 300.0 * d
    entered = (np.where(d > 0.0, 0.0, SIZE) - from_far) / np.where(d == 0.0, np.inf, d)
    return np.clip(from_far + entered.max(axis=1)[:, None] * d, 0.0, SIZE).tolist()


def sound(result: ProductResult, solids: tuple[Solid, ...]) -> Solid:
    """The one closed body of a result whose details are all carved."""
    assert [one.problem for one in result.detailed.details] == [""]
    (solid,) = solids
    assert solid.exact is not None
    assert solid.exact.is_closed
    assert manifold(solid.mesh).volume() == pytest.approx(volume(solid), rel=1e-5)
    return solid


def floors(result: ProductResult) -> list[Any]:
    (shell,) = result.detailed.changed
    pairs = zip(shell.faces, shell.owners, strict=True)
    return [face for face, owner in pairs if owner.floor is not None]


@pytest.mark.parametrize(("top", "front"), [(9.0, 9.0), (14.0, 5.0), (4.0, 21.0)])
def test_a_pocket_over_an_edge_has_its_volume(top: float, front: float) -> None:
    """Two slabs less what they share; raised, with what stands over the edge."""
    for kind, sign in (("in", -1.0), ("raised", 1.0)):
        result, solids = solved(box(), kind=kind, draft=0.0, outlines=[rectangle(20.0, top, front)])
        change = 20.0 * (2.0 * (top + front) + sign * 2.0**2)
        assert volume(sound(result, solids)) - WHOLE == pytest.approx(sign * change, rel=2e-5)


def test_with_a_draft_the_floor_is_smaller_all_round() -> None:
    """Closed form: the floor is inset by h·tan(draft); both slabs are frusta cut by the mitre."""
    result, solids = solved(box(), kind="in", draft=5.0, outlines=[rectangle(20.0, 12.0, 12.0)])
    t = np.tan(np.radians(5.0))
    deep = np.linspace(0.0, 2.0, 4001)
    # At depth s the section of one slab goes from the mitre (s) to the far side, less the draft.
    section = (20.0 - 2.0 * t * deep) * (12.0 - t * deep - deep)
    slabs = 2.0 * np.trapezoid(section, deep)
    assert WHOLE - volume(sound(result, solids)) == pytest.approx(slabs, rel=2e-4)


@pytest.mark.parametrize(("kind", "draft"), CASES)
def test_floors_keep_their_depth_on_both_sides(kind: str, draft: float) -> None:
    result, solids = solved(box(), kind=kind, gap=0.8, draft=draft, outlines=[over_edge()])
    sound(result, solids)
    found = floors(result)
    height = 2.0 if kind == "raised" else -2.0
    assert len(found) == 2
    planes = set()
    for face in found:
        ring = np.concatenate([t.curve.value(np.linspace(*t.curve.range, 9)) for t in face.trims])
        places = face.surface.value(*ring.T)
        off = np.abs(np.column_stack((places[:, 2] - 40.0 - height, places[:, 1] + height)))
        plane = int(np.argmin(off.max(axis=0)))
        planes.add(plane)
        assert off[:, plane].max() < 1e-4
    assert planes == {0, 1}


@pytest.mark.parametrize(("kind", "draft"), CASES)
@pytest.mark.parametrize(
    ("way", "middle", "radii", "turn"),
    [
        ((-1.0, 1.0, -1.0), (100.0, 0.0, 40.0), (12.0, 10.0), 0.3),
        ((0.3, 1.0, -1.0), (50.0, 0.0, 40.0), (12.0, 7.0), 0.7),
        ((0.0, 1.0, -1.0), (50.0, 6.0, 40.0), (12.0, 10.0), 0.7),
    ],
    ids=["corner", "aslant", "more on the top"],
)
def test_over_corners_and_aslant_the_body_is_closed(
    kind: str,
    draft: float,
    way: tuple[float, float, float],
    middle: tuple[float, float, float],
    radii: tuple[float, float],
    turn: float,
) -> None:
    row = seen_along(way, middle, radii, turn)
    result, solids = solved(box(), kind=kind, gap=0.5, draft=draft, depth=1.5, outlines=[row])
    change = volume(sound(result, solids)) - WHOLE
    assert change > 0.0 if kind == "raised" else change < 0.0


def test_walls_keep_their_draft_where_the_outline_crosses_the_edge_squarely() -> None:
    result, solids = solved(box(), kind="in", draft=6.0, outlines=[rectangle(20.0, 12.0, 12.0)])
    sound(result, solids)
    (shell,) = result.detailed.changed
    walls = [f for f, o in zip(shell.faces, shell.owners, strict=True) if o.is_wall]
    assert len(walls) >= 6
    for wall in walls:
        u, v = wall.surface.ranges
        at = np.array([(a, b) for a in np.linspace(*u, 9) for b in np.linspace(*v, 3)])
        leans = np.degrees(np.arcsin(np.abs(wall.surface.normals(*at.T)[:, 1:])))
        assert np.abs(leans - 6.0).max(axis=0).min() < 1e-2


def test_an_outline_that_goes_too_little_over_an_edge_is_told() -> None:
    result, (solid,) = solved(
        box(), kind="in", depth=3.0, draft=0.0, outlines=[rectangle(20.0, 12.0, 2.0)]
    )
    (detail,) = result.detailed.details
    assert "depth smaller" in detail.problem or "less deep" in detail.problem
    assert volume(solid) == pytest.approx(WHOLE, rel=1e-9)


def test_a_thousand_times_as_large_is_the_same() -> None:
    rows = [over_edge(), (1000.0 * np.array(over_edge())).tolist()]
    found = []
    for scale, row in zip((1.0, 1000.0), rows, strict=True):
        network = box()
        for curve in network["network"]["curves"]:
            curve["points"] = (scale * np.array(curve["points"])).tolist()
        result, solids = solved(network, kind="in", draft=3.0, depth=2.0 * scale, outlines=[row])
        found.append((WHOLE * scale**3 - volume(sound(result, solids))) / scale**3)
    assert found[1] == pytest.approx(found[0], rel=1e-5)


@pytest.mark.parametrize("kind", ["cut", "split"])
def test_a_loop_from_the_top_down_an_upright_wall_takes_both(kind: str) -> None:
    """Most of it is on the top, so that across its mean normal the wall would be seen end on."""
    row = rectangle(20.0, 48.0, 9.0, steps=16)
    network = box()
    network["network"]["details"] = [
        {"kind": kind, "draft": 0.0, "outlines": [row], "color": [200, 40, 20]}
    ]
    state = product_of_network(network)
    result = solve_product(state, Job())
    solid = sound(result, shapes_of(state, result).solids)
    if kind == "split":
        colors = [group.color for group in solid.groups for _ in range(group.count)]
        a, b, c = (solid.mesh.vertices[solid.mesh.faces[:, k]].astype(float) for k in range(3))
        areas = 0.5 * np.cross(b - a, c - a)[[color == (200, 40, 20) for color in colors]]
        assert np.abs(areas).sum(axis=0) == pytest.approx([0.0, 180.0, 960.0], rel=1e-6, abs=1e-9)
    else:
        assert volume(solid) < WHOLE - 20.0 * 48.0 * 9.0 / 2.0


def pen(camera: Camera, place: tuple[float, float, float], radius: float) -> Stroke:
    """A round that a hand drew about a place."""
    turn = np.linspace(0.0, 2.0 * np.pi, 150)
    middle = camera.project(np.array([place]))[0][0]
    points = middle + radius * np.column_stack((np.cos(turn), 0.8 * np.sin(turn)))
    points = points + 0.4 * np.random.default_rng(7311).normal(size=points.shape)
    return Stroke(points[:, 0], points[:, 1], camera)


CAMERA = Camera(eye=(190.0, -170.0, 190.0), target=(50.0, 10.0, 35.0))


@pytest.mark.parametrize("kind", ["in", "raised", "button"])
def test_a_round_drawn_over_an_edge_with_the_pen_is_carved(kind: str) -> None:
    state = with_detail_drawn(product_of_network(box()), [pen(CAMERA, (55.0, 0.0, 40.0), 40.0)])
    (detail,) = state.of_kind(Detail)
    values = {"kind": kind, "depth": 1.5, "gap": 0.6}
    state = state.with_node(replace(detail, **values))
    result = solve_product(state, Job())
    sound(result, shapes_of(state, result).solids)


def test_draw_symmetric_gives_details_a_mirror_image() -> None:
    plain = product_of_network(box())
    plane = replace(plain.symmetry, point=(0.0, 30.0, 0.0))
    for place, twice in (((50.0, 15.0, 40.0), True), ((50.0, 30.0, 40.0), False)):
        for on in (True, False):
            state = replace(plain, mirror=on, symmetry=plane)
            state = with_detail_drawn(state, [pen(CAMERA, place, 25.0)])
            (detail,) = state.of_kind(Detail)
            assert detail.mirrored == (twice and on)
            result = solve_product(state, Job())
            assert [one.problem for one in result.detailed.details] == [""] * (1 + detail.mirrored)
