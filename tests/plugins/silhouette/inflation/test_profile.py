"""Thickness from the pen: laws of pressure and of profiles drawn from the side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.view import Camera
from bozzetto_silhouette.analysis.projected_outline import shadow_of
from bozzetto_silhouette.inflation.pen_pressure import continued_harmonically
from bozzetto_silhouette.inflation.profile import highest_crossings, understood
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid
from bozzetto_silhouette.model.sketch_plane import Sheet
from bozzetto_silhouette.model.state import Part
from bozzetto_silhouette.outline.boundary_sampling import sample_rim
from bozzetto_silhouette.outline.domain_mesh import plan_of
from bozzetto_silhouette.solids.part_solid import solid_of
from tests.plugins.silhouette import outlines as o

FRONT = Camera("orthographic", eye=(0, -500, 0), target=(0, 0, 0))
TOP = Camera("orthographic", eye=(0, 0, 500), target=(0, 0, 0), up=(0, 1, 0))
SIDE = Camera("orthographic", eye=(500, 0, 0), target=(0, 0, 0))
ABOVE = Camera("perspective", eye=(30, 15, 400), target=(0, 0, 0), up=(0, 1, 0))


def _drawn(world: np.ndarray, camera: Camera, **columns: object) -> Stroke:
    pixels, _ = camera.project(world)
    return Stroke(pixels[:, 0], pixels[:, 1], camera, **columns)


def _part(ring: np.ndarray, **fields: object) -> Part:
    """A part drawn from the front, closed; (x, y) on the sheet is (x, 0, y) in the world."""
    closed = np.vstack([ring, ring[:1]])
    columns = {key: fields.pop(key) for key in ("pressure_column",) if key in fields}
    world = np.column_stack([closed[:, 0], np.zeros(len(closed)), closed[:, 1]])
    pressure = columns.get("pressure_column")
    return Part(id="n1", strokes=Strokes([_drawn(world, FRONT, pressure=pressure)]), **fields)


@pytest.fixture(scope="module")
def bar() -> np.ndarray:
    return o.dense(np.array([[-60, -12], [60, -12], [60, 12], [-60, 12.0]]), 1.5)


def _from_above(x: np.ndarray, z: np.ndarray, camera: Camera = TOP) -> Stroke:
    """A stroke at object depth z (towards the person: world -y) over x."""
    return _drawn(np.column_stack([x, -z, np.zeros(len(x))]), camera)


def _side_view(solid: SilhouetteSolid, axis: np.ndarray) -> shapely.Geometry:
    """What is seen of a solid along the sheet: place along the axis against depth."""
    v = solid.vertices
    turned = np.column_stack([v[:, :2] @ axis, v[:, 2], v[:, :2] @ [axis[1], -axis[0]]])
    return shadow_of(turned, solid.faces)


def _top_of(shadow: shapely.Geometry, x: float, sign: float = 1.0) -> float:
    cut = shadow.intersection(shapely.LineString([(x, 0), (x, sign * 500)]))
    return float(cut.length)


# -- pressure --


def test_even_pressure_and_none_change_nothing(bar: np.ndarray) -> None:
    count = len(bar) + 1
    plain = solid_of(_part(bar), 48)
    for column in (None, np.full(count, 0.3), np.zeros(count)):
        part = _part(bar, pressure=1.0, pressure_column=column)
        assert solid_of(part, 48).front == pytest.approx(plain.front, rel=1e-9)


def test_a_harder_pressed_end_is_thicker_and_the_outline_stays(bar: np.ndarray) -> None:
    closed = np.vstack([bar, bar[:1]])
    column = np.where(closed[:, 0] > 0, 0.8, 0.4)
    plain = solid_of(_part(bar), 64)
    heights = []
    for strength in (0.25, 0.5, 1.0):
        pressed = solid_of(_part(bar, pressure=strength, pressure_column=column), 64)
        assert pressed.soundness.ok
        assert np.array_equal(pressed.vertices[:, :2], plain.vertices[:, :2])
        view = _side_view(pressed, np.array([1.0, 0.0]))
        heights.append((_top_of(view, -40.0), _top_of(view, 40.0)))
    for thin, thick in heights:
        assert thick > thin
    ratio = [thick / thin for thin, thick in heights]
    assert ratio == sorted(ratio)
    assert ratio[2] == pytest.approx(2.0, rel=0.05)


def test_hostile_pressures_stay_in_bounds(bar: np.ndarray) -> None:
    random = np.random.default_rng(0)
    count = len(bar) + 1
    plain = solid_of(_part(bar), 48)
    for column in (random.integers(0, 2, count), np.eye(1, count, 7)[0], random.random(count)):
        solid = solid_of(_part(bar, pressure=1.0, pressure_column=column), 48)
        assert solid.soundness.volume > 0
        inner = slice(len(plain.plan.after), None)
        factor = np.sqrt(solid.front[inner] / plain.front[inner])
        assert ((factor > 0.399) & (factor < 2.501)).all()


def _continued(step: float, function) -> float:
    """Largest error of the continuation into a disc."""
    rim = sample_rim((o.circle(0, 0, 0.5, 400),), step, 0.3 * step)
    plan = plan_of(rim, np.zeros((0, 2)), step)
    exact = function(*plan.points.T)
    return float(np.abs(continued_harmonically(plan, exact[: len(plan.after)]) - exact).max())


def test_harmonic_continuation_of_harmonic_functions() -> None:
    assert _continued(0.05, lambda x, y: 2 * x - 3 * y + 1) < 1e-9
    coarse, fine = (_continued(step, lambda x, y: x * x - y * y + x * y) for step in (0.05, 0.02))
    assert fine < 0.6 * coarse < 1e-3


# -- profile --


def test_highest_crossings_against_shapely() -> None:
    random = np.random.default_rng(1)
    x0, y0, x1, y1 = random.uniform(-1, 1, (4, 40))
    columns = np.linspace(-0.9, 0.9, 37)
    found = highest_crossings(x0, y0, x1, y1, columns)
    lines = shapely.MultiLineString(
        [[(a, b), (c, d)] for a, b, c, d in zip(x0, y0, x1, y1, strict=True)]
    )
    for x, y in zip(columns, found, strict=True):
        cut = lines.intersection(shapely.LineString([(x, -2), (x, 2)]))
        assert y == pytest.approx(cut.bounds[3], abs=1e-9)


@pytest.mark.parametrize("camera", [TOP, ABOVE], ids=["parallel", "perspective"])
def test_the_part_is_as_thick_as_drawn(bar: np.ndarray, camera: Camera) -> None:
    x = np.linspace(-58, 58, 90)
    wave = 18.0 + 8.0 * np.cos(x / 14.0)
    plain = solid_of(_part(bar), 96)
    solid = solid_of(_part(bar, profile=Strokes([_from_above(x, wave, camera)])), 96)
    assert solid.soundness.ok
    assert np.array_equal(solid.vertices[:, :2], plain.vertices[:, :2])
    view = _side_view(solid, np.array([1.0, 0.0]))
    # A part seen in perspective shows another height beside its middle than over it.
    tolerance = 0.03 if camera is TOP else 0.08
    for at in np.linspace(-45, 45, 19):
        for sign in (1.0, -1.0):
            wanted = 18.0 + 8.0 * np.cos(at / 14.0)
            assert _top_of(view, at, sign) == pytest.approx(wanted, rel=tolerance)


def test_a_closed_profile_gives_front_and_back(bar: np.ndarray) -> None:
    angle = np.linspace(0, 2 * np.pi, 200)
    z = np.where(np.sin(angle) > 0, 30.0, 8.0) * np.sin(angle)
    part = _part(bar, profile=Strokes([_from_above(62 * np.cos(angle), z)]))
    view = _side_view(solid_of(part, 96), np.array([1.0, 0.0]))
    for x in (-35.0, 0.0, 35.0):
        share = np.sqrt(1 - (x / 62) ** 2)
        assert _top_of(view, x) == pytest.approx(30 * share, rel=0.03)
        assert _top_of(view, x, -1.0) == pytest.approx(8 * share, rel=0.03)


def test_beyond_a_short_profile_the_part_is_as_before(bar: np.ndarray) -> None:
    x = np.linspace(-15, 15, 40)
    part = _part(bar, profile=Strokes([_from_above(x, np.full(40, 24.0))]))
    view = _side_view(solid_of(part, 96), np.array([1.0, 0.0]))
    before = _side_view(solid_of(_part(bar), 96), np.array([1.0, 0.0]))
    assert _top_of(view, 0.0) == pytest.approx(24.0, rel=0.02)
    for x in (-45.0, 45.0):
        assert _top_of(view, x) == pytest.approx(_top_of(before, x), rel=1e-6)


def test_from_the_side_it_runs_along_the_height(bar: np.ndarray) -> None:
    z = np.linspace(-58, 58, 60)
    depth = 10.0 + 0.1 * z
    world = np.column_stack([np.zeros(60), -depth, z])
    part = _part(bar[:, ::-1], profile=Strokes([_drawn(world, SIDE)]))
    view = _side_view(solid_of(part, 96), np.array([0.0, 1.0]))
    for at in (-40.0, 0.0, 40.0):
        assert _top_of(view, at) == pytest.approx(10.0 + 0.1 * at, rel=0.04)


def test_the_drawing_may_be_turned_as_a_whole(bar: np.ndarray) -> None:
    """A sheet and a view turned together give the same solid."""
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])

    def turned(camera: Camera) -> Camera:
        eye, up = (tuple(map(float, turn @ np.asarray(v))) for v in (camera.eye, camera.up))
        return replace(camera, eye=eye, up=up)

    x = np.linspace(-50, 50, 60)
    wave = 15.0 + 4.0 * np.sin(x / 20.0)
    part = _part(bar, profile=Strokes([_from_above(x, wave)]))
    sheet = Sheet(right=(c, s, 0.0), up=(0.0, 0.0, 1.0))

    def carried(stroke: Stroke) -> Stroke:
        return Stroke(stroke.x, stroke.y, turned(stroke.camera))

    other = Part(
        strokes=Strokes([carried(part.strokes[0])]),
        profile=Strokes([carried(part.profile[0])]),
        sheet=sheet,
    )
    here, there = solid_of(part, 64), solid_of(other, 64)
    assert there.soundness.volume == pytest.approx(here.soundness.volume, rel=1e-3)
    one, two = (_side_view(solid, np.array([1.0, 0.0])) for solid in (here, there))
    assert one.symmetric_difference(two).area < 2e-3 * one.area


@pytest.mark.parametrize(
    ("stroke", "says"),
    [
        (lambda: _drawn(np.array([[-50, 0, 5], [50, 0, 30.0]]), FRONT), "face-on"),
        (lambda: _from_above(np.linspace(100, 200, 9), np.full(9, 20.0)), "not over the part"),
        (lambda: _from_above(np.linspace(-50, 50, 9), np.zeros(9)), "profile"),
        (lambda: _from_above(np.linspace(-50, 50, 9), np.full(9, 1e-3)), "own plane"),
        (lambda: _from_above(np.array([3.0]), np.array([20.0])), "not over the part"),
        (lambda: _from_above(np.array([3.0, 3.0]), np.array([5.0, 20.0])), "not over the part"),
    ],
)
def test_what_cannot_be_understood_is_told(bar: np.ndarray, stroke, says: str) -> None:
    with pytest.raises(UserError, match=says):
        understood(_part(bar, profile=Strokes([stroke()])))


def test_two_views_in_one_profile_are_refused(bar: np.ndarray) -> None:
    x = np.linspace(-50, 50, 20)
    side = _drawn(np.column_stack([0 * x, -20 + 0 * x, x]), SIDE)
    with pytest.raises(UserError, match="another side"):
        understood(_part(bar, profile=Strokes([_from_above(x, 20 + 0 * x), side])))


def test_scribbles_give_a_sound_solid_or_a_word(bar: np.ndarray) -> None:
    random = np.random.default_rng(6)
    for _ in range(15):
        count = int(random.integers(1, 60))
        walk = random.normal(size=(count, 2)).cumsum(axis=0) * random.choice([0.1, 10.0, 1e3])
        camera = [TOP, ABOVE, SIDE][int(random.integers(3))]
        stroke = Stroke(600 + walk[:, 0], 450 + walk[:, 1], camera)
        part = _part(bar, profile=Strokes([stroke]))
        try:
            understood(part)
        except UserError:
            continue
        solid = solid_of(part, 32)
        assert np.isfinite(solid.vertices).all()
        assert solid.soundness.volume > 0
