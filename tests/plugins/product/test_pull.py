"""Pulls: contours against the strokes they follow, and what must stay."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Job
from bozzetto.view import Camera
from bozzetto_product.fill.fill import Fill
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.planes import Plane
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.shaping.pull import pulled
from bozzetto_product.tools.pull import with_pull
from tests.plugins.product.test_pressure import disc, middle_of_a_sheet
from tests.plugins.product.test_walls import product_box

PRODUCT = ProductModeler()


def side(eye=(1.6, -30.0, 0.0), kind="orthographic", height=4.0) -> Camera:
    target = (eye[0], 1.6, 0.0)
    return Camera(kind, eye, target, (0, 0, 1), 8.0, height, (1200.0, 900.0))


def stroke_through(points: np.ndarray, camera: Camera) -> Stroke:
    pixels = camera.project(points)[0]
    return Stroke(pixels[:, 0], pixels[:, 1], camera)


def bump(x: np.ndarray) -> np.ndarray:
    """One in the middle of the sheet's middle, flat at its border."""
    return np.maximum(0.0, (x - 1.0) * (2.2 - x) / 0.36) ** 2


def over(height, camera: Camera, low=1.05, high=2.15, y=1.6) -> Stroke:
    x = np.linspace(low, high, 60)
    return stroke_through(np.column_stack((x, np.full(60, y), height(x))), camera)


def profile(fill: Fill, camera: Camera, sense: float) -> tuple[np.ndarray, np.ndarray]:
    """The outline of a fill on the sheet, by dense places: columns of pixels and their extreme."""
    at = np.linspace(0, 1, 161)
    u, v = (part.ravel() for part in np.meshgrid(at, at))
    pixels = camera.project(np.concatenate([p.value(u, v) for p in fill.patches]))[0]
    columns = np.round(pixels[:, 0] / 4.0).astype(int)
    seen = np.unique(columns)
    tops = [sense * (sense * pixels[columns == c, 1]).min() for c in seen]
    return 4.0 * seen, np.array(tops)


@pytest.mark.parametrize("kind", ["orthographic", "perspective"])
@pytest.mark.parametrize("height", [0.12, -0.12])
def test_the_contour_follows_the_stroke(height: float, kind: str) -> None:
    camera = side(kind=kind)
    start = middle_of_a_sheet(lambda x, y: 0.0 * x)
    stroke = over(lambda x: height * bump(x), camera)
    found = pulled(start, stroke)
    assert not found.problem
    columns, tops = profile(found.fill, camera, np.sign(height))
    inside = (columns > stroke.x[10]) & (columns < stroke.x[-10])
    wanted = np.interp(columns[inside], stroke.x, stroke.y)
    reach = np.ptp(stroke.y)
    assert np.abs(tops[inside] - wanted).max() <= 0.06 * reach


def test_the_border_and_tangent_planes_stay() -> None:
    start = middle_of_a_sheet(lambda x, y: -0.1 * (x * x + (y - 1.5) ** 2))
    found = pulled(start, over(lambda x: -0.1 * x * x + 0.15 * bump(x), side())).fill
    assert found is not start
    for one, two in zip(start.patches, found.patches, strict=True):
        np.testing.assert_array_equal(one.control_points[0], two.control_points[0])
        np.testing.assert_array_equal(one.control_points[:, 0], two.control_points[:, 0])
    assert max(found.g1_degrees) <= max(start.g1_degrees) + 0.1


def test_pulled_up_and_down_are_mirror_images_on_a_plane() -> None:
    start, camera = middle_of_a_sheet(lambda x, y: 0.0 * x), side()
    up, down = (pulled(start, over(lambda x, s=s: s * 0.1 * bump(x), camera)).fill for s in (1, -1))
    for one, two in zip(up.patches, down.patches, strict=True):
        np.testing.assert_allclose(one.control_points * (1, 1, -1), two.control_points, atol=2e-3)


def test_a_pull_to_where_the_surface_is_already_changes_next_to_nothing() -> None:
    start, camera = disc(), side(eye=(0.0, -30.0, 0.0))
    stroke = over(lambda x: 0.4 * (1 - x * x), camera, -0.9, 0.9, 0.0)
    once = pulled(start, stroke).fill
    again = pulled(once, stroke).fill
    change = np.abs(again.solution.free - once.solution.free).max()
    assert change <= 0.05 * np.abs(once.solution.free - start.bent.solution.free).max()


def test_the_mirror_image_of_a_stroke_pulls_the_mirror_image() -> None:
    start = disc()
    mirror = Reflection(Plane((0, 0, 0), (1, 0, 0)))
    camera = side(eye=(0.0, -30.0, 0.0))
    lopsided = over(lambda x: 0.4 * (1 - x * x) * (1 + 0.5 * x), camera, -0.9, 0.9, 0.0)
    plain, image = pulled(start, lopsided).fill, pulled(start, lopsided, mirror).fill
    for sense in (1.0,):
        one, two = (profile(fill, camera, sense)[1] for fill in (plain, image))
        np.testing.assert_allclose(one, two[::-1], atol=4.0)


def test_a_stroke_beside_a_surface_or_from_above_is_refused() -> None:
    start = middle_of_a_sheet()
    beside = over(lambda x: 0.1 + 0.0 * x, side(), 5.0, 6.0)
    assert pulled(start, beside).fill is start
    assert "side" in pulled(start, beside).problem
    far = over(lambda x: 40.0 * bump(x), side(height=100.0))
    assert pulled(start, far).problem


def test_the_tool_keeps_the_ink_in_the_recipe_and_the_result_follows() -> None:
    state = product_box()
    camera = Camera("orthographic", (20, -300, 10), (20, 0, 10), (0, 0, 1), 35, 80, (1200, 900))
    x = np.linspace(2, 38, 50)
    stroke = stroke_through(
        np.column_stack((x, np.full(50, 15.0), 20 + 6 * (x * (40 - x) / 400))), camera
    )
    top = next(
        one.patch
        for one in PRODUCT.solve(state, Job()).filled
        if one.fill.mesh.vertices[:, 2].min() > 19.0
    )
    after = with_pull(replace(state, selected=top.id), stroke)
    assert len(after.node(top.id).pulls) == 1
    result = PRODUCT.solve(after, Job())
    solved = next(one for one in result.filled if one.patch.id == top.id)
    assert solved.fill.mesh.vertices[:, 2].max() == pytest.approx(26.0, abs=0.2)
    assert PRODUCT.shapes(after, result).solids[0].exact.is_closed
    (forget,) = (c for c in PRODUCT.commands() if c.id == "forget-pulls")
    plain = forget.run(after, Context())
    assert not len(plain.node(top.id).pulls)
    assert isinstance(plain.node(top.id), Patch)


def test_without_a_surface_there_is_a_sentence() -> None:
    state = product_box()
    state = replace(state, nodes=tuple(n for n in state.nodes if not isinstance(n, Patch)))
    with pytest.raises(UserError, match="no surface"):
        with_pull(state, over(bump, side()))
