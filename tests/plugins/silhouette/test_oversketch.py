"""Drawing over an outline: what is replaced, what stays, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import shapely

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.ink import Strokes
from bozzetto.ink.curves.resample import resample
from bozzetto.plugin import Context, Drag, Ink
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto.view.standard_views import standard_view
from bozzetto_silhouette.ink.oversketch import drawn_over, ring_drawn_over
from bozzetto_silhouette.model.state import Group, Oversketch, Part, SilhouetteState
from bozzetto_silhouette.outline.edits import edited, size_of
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.solids.part_solid import solid_of
from bozzetto_silhouette.solids.placements import drawn_rings
from bozzetto_silhouette.tools.outline_edits import SketchOver
from tests.plugins.silhouette import outlines
from tests.previews import preview_of

PEN, TOOL, CONTEXT = Pen(), SketchOver(), Context()
CIRCLE = outlines.circle(0.0, 0.0, 50.0)
SQUARE = np.array([(-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)])


def arc(x, y, across, up, first, last, count=60):
    angle = np.deg2rad(np.linspace(first, last, count))
    return np.column_stack([x + across * np.cos(angle), y + up * np.sin(angle)])


def over(ring, line):
    return drawn_over(ring, np.asarray(line, float), size_of((ring,)))


def region(ring):
    return shapely.Polygon(ring)


def differ(one, other) -> float:
    """Area in which two rings differ, as a share of the first."""
    return region(one).symmetric_difference(region(other)).area / region(one).area


def turned(points, degrees, about=(0.0, 0.0)):
    c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    return (points - about) @ np.array([[c, s], [-s, c]]) + about


BUMP = arc(0, 48, 18, 22, 175, 5)
DENT = arc(0, 52, 18, 22, 185, 355)
EAR = arc(0, 66, 22, 20, -60, 240)
CUT = np.array([(-20.0, 55.0), (-20.0, -55.0)])
MOST = arc(0, 0, 46, 54, 120, -200)


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (BUMP, region(CIRCLE).union(region(BUMP))),
        (DENT, region(CIRCLE).difference(region(DENT))),
        (EAR, region(CIRCLE).union(region(EAR))),
        (CUT, region(CIRCLE).difference(shapely.box(-60, -60, -20, 60))),
        (MOST, region(arc(0, 0, 46, 54, 0, 360))),
    ],
    ids=["bump", "dent", "ear", "cut across", "nearly all of it"],
)
def test_the_nearest_stretch_is_replaced(line, expected) -> None:
    """Against the set operation that the stroke means."""
    new = region(over(CIRCLE, line))
    assert new.is_valid
    assert new.symmetric_difference(expected).area / expected.area < 0.02


@pytest.mark.parametrize("line", [BUMP, DENT, EAR, CUT, MOST], ids=list("bdecm"))
def test_direction_and_start_do_not_matter(line) -> None:
    expected = over(CIRCLE, line)
    assert differ(expected, over(CIRCLE, line[::-1])) < 1e-4
    for shift in (13, 24, 25, 70):
        rolled = np.roll(CIRCLE, shift, axis=0)
        assert differ(expected, over(rolled, line)) < 1e-4
        assert differ(expected, over(rolled[::-1], line)) < 1e-4


@pytest.mark.parametrize("factor", [1e-3, 1e3])
@pytest.mark.parametrize("degrees", [0.0, 37.0])
@pytest.mark.parametrize("away", [0.0, 1e4])
def test_turned_moved_and_scaled_it_is_the_same(factor, degrees, away) -> None:
    expected = over(CIRCLE, BUMP)

    def moved(points):
        return factor * (turned(points, degrees) + away)

    assert differ(moved(expected), over(moved(CIRCLE), moved(BUMP))) < 1e-5


def test_what_is_not_drawn_over_stays_vertex_for_vertex() -> None:
    ring = outlines.outline("horse_skimage").rings[0]
    line = resample(ring, spacing=2.0, closed=True)[60:90] + np.array([4.0, 4.0])
    new = over(ring, line)
    far = ring[shapely.distance(shapely.LineString(line), shapely.points(ring)) > 25.0]
    kept = {tuple(point) for point in new.round(9).tolist()}
    assert all(tuple(point) in kept for point in far.round(9).tolist())


def test_a_corner_that_was_drawn_stays_a_corner_and_a_joint_gets_smooth() -> None:
    tooth = over(SQUARE, [(20, 50), (20, 80), (-20, 80), (-20, 50)])
    assert region(tooth).area == pytest.approx(100 * 100 + 40 * 30, rel=2e-3)
    for corner in [(20, 80), (-20, 80), (50, 50), (-50, -50)]:
        assert np.hypot(*(tooth - corner).T).min() < 0.3
    # A new back of the circle, two units higher: it leaves and arrives along the circle.
    new = resample(over(CIRCLE, arc(0, 0, 50, 54, 150, 30)), spacing=1.0, closed=True)
    step = np.roll(new, -1, axis=0) - new
    direction = np.unwrap(np.arctan2(step[:, 1], step[:, 0]))
    assert np.abs(np.diff(direction)).max() < np.deg2rad(12.0)


def test_loose_ends_come_to_the_line() -> None:
    """Ends that stop short or overshoot by a few percent make no spur and no gap."""
    exact = over(CIRCLE, BUMP)
    for reach in (-0.25, 0.25):
        line = arc(0, 48, 18, 22, 175 + 40 * reach, 5 - 40 * reach)
        assert differ(exact, over(CIRCLE, line)) < 0.02


def test_a_thin_limb_takes_the_stroke_on_the_side_that_is_meant() -> None:
    limb = np.array([(-50.0, -2.0), (50.0, -2.0), (50.0, 2.0), (-50.0, 2.0)])
    for side in (1.0, -1.0):
        new = region(over(limb, np.column_stack([np.linspace(-20, 20, 40),
                                                 side * (2 + 10 * np.hanning(40))])))  # fmt: skip
        assert new.area == pytest.approx(400 + 10 * 40 * 0.5, rel=0.03)
        assert np.sign(new.centroid.y) == side


def test_several_in_a_row_and_rings_of_holes() -> None:
    hole = outlines.circle(0.0, 0.0, 20.0)
    rings = (CIRCLE, hole)
    for ring, line in [
        (0, BUMP),
        (1, arc(20, 0, 8, 8, -110, 110)),
        (0, arc(48, 0, 20, 16, -85, 85)),
        (1, arc(0, 0, 26, 24, 5, 362)),
    ]:
        assert ring_drawn_over(rings, line, size_of(rings)) == ring
        stroke = PEN.along(line)
        rings = edited(rings, Oversketch(stroke, ring), line)
    outer, inner = (region(ring) for ring in rings)
    assert outer.contains(inner)
    assert inner.area == pytest.approx(np.pi * 26 * 24, rel=0.01)


def test_what_is_cut_off_takes_its_hole_along() -> None:
    hole = outlines.circle(-35.0, 0.0, 8.0)
    rings = edited((CIRCLE, hole), Oversketch(PEN.along(CUT), 0), CUT)
    assert rings[1] is None
    with pytest.raises(UserError, match="Two outlines would cross") as refusal:
        edited((CIRCLE, hole + np.array([15.0, 0.0])), Oversketch(PEN.along(CUT), 0), CUT)
    # The cut meets the hole, at (-20, ±8).
    assert np.abs(np.array(refusal.value.places) - [-20.0, 0.0]).max() < 8.5


@pytest.mark.parametrize(
    "line",
    [
        [(200, 0), (230, 40)],
        [(0, 50), (0, 200)],
        [(0, 50), (0, 50)],
        [(120, 120), (160, 120), (140, 150), (120, 120)],
    ],
    ids=["far", "one end far", "a dot", "a loop elsewhere"],
)
def test_far_from_any_outline_it_is_refused(line) -> None:
    with pytest.raises(UserError, match=r"no outline .*\."):
        ring_drawn_over((CIRCLE,), np.array(line, float), 100.0)


# -- the tool --


HERE = Placement()


def part_of(*strokes, pose=HERE) -> Part:
    return Part(id="n1", name="Part", strokes=Strokes(strokes), pose=pose)


def bump_in(camera: Camera, x: float, y: float, radius: float) -> np.ndarray:
    return arc(x, y - radius, 0.3 * radius, 0.4 * radius, 175, 365)


POSES = {
    "as drawn": Placement(),
    "moved": Placement(offset=(30.0, 0.0, -20.0)),
    "larger": Placement(scale=1.7, offset=(5.0, 3.0, 0.0)),
    "mirrored": Placement((-1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0), 1.0, (4.0, 0.0, 0.0)),
    "turned": Placement((0.6, 0, -0.8, 0, 1.0, 0, 0.8, 0, 0.6), 1.0, (0.0, 0.0, 0.0)),
}


@pytest.mark.parametrize("pose", POSES.values(), ids=POSES)
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
@pytest.mark.parametrize("grouped", [False, True])
def test_the_new_line_is_where_the_pen_was(pose, kind, grouped) -> None:
    """Whatever happened to the part since, it is changed under the pen, and only there."""
    camera = standard_view(Camera(kind), "front")
    part = part_of(Pen(camera).circle(600, 450, 150), pose=pose)
    nodes = (part,)
    if grouped:
        group = Group(id="g", name="G", pose=POSES["mirrored"])
        nodes = (group, replace(part, within="g"))
    state = SilhouetteState(nodes=nodes, selected="n1")
    before, _ = camera.project(drawn_rings(state, state.node("n1"))[0])
    low, high = before.min(axis=0), before.max(axis=0)
    middle, radius = 0.5 * (low + high), 0.5 * (high - low)[0]
    line = bump_in(camera, *middle, radius)
    gesture = Ink((Pen(camera).along(line),), True)
    after = TOOL.apply(state, gesture, CONTEXT)
    ring, _ = camera.project(drawn_rings(after, after.node("n1"))[0])
    expected = region(before).union(region(np.vstack([line, [middle]])))
    assert region(ring).symmetric_difference(expected).area / expected.area < 0.02
    assert after.node("n1").strokes == part.strokes
    # The preview shows the same line.
    (lines,) = [item for _, item in preview_of(TOOL, state, gesture, CONTEXT).items()]
    seen, _ = camera.project(lines.points)
    assert region(seen).symmetric_difference(region(ring)).area < 1e-3 * expected.area


def test_places_of_a_crossing_are_seen_on_a_mirrored_part() -> None:
    camera = standard_view(Camera(), "front")
    state = SilhouetteState(nodes=(part_of(Pen(camera).circle(500, 450, 100),
                                           pose=POSES["mirrored"]),))  # fmt: skip
    ring, _ = camera.project(drawn_rings(state, state.parts[0])[0])
    x, y = ring.mean(axis=0)
    # A bump with a loop in it, which crosses itself above the middle.
    line = [(x - 40, y - 92), (x + 40, y - 200), (x - 40, y - 200), (x + 40, y - 92)]
    with pytest.raises(UserError, match="cross itself") as refusal:
        TOOL.apply(state, Ink((Pen(camera).along(line),), True), CONTEXT)
    assert refusal.value.places[0] == pytest.approx((x, y - 146), abs=8)


def test_the_chosen_part_comes_first_then_the_nearest() -> None:
    left, right = part_of(PEN.circle(400, 450, 100)), part_of(PEN.circle(620, 450, 100))
    right = replace(right, id="n2")
    state = SilhouetteState(nodes=(left, right), selected="n1")
    top = PEN.along(arc(510, 450, 12, 40, -90, 90))

    def changed(state, stroke):
        after = TOOL.apply(state, Ink((stroke,), True), CONTEXT)
        return [new.id for old, new in zip(state.parts, after.parts, strict=True) if new != old]

    assert changed(state, top) == ["n1"]
    assert changed(replace(state, selected="n2"), top) == ["n2"]
    bump = PEN.along(bump_in(Camera(), 620, 450, 100))
    assert changed(state, bump) == ["n2"]
    hidden = replace(state, nodes=(left, replace(right, visible=False)))
    with pytest.raises(UserError, match="no outline"):
        changed(hidden, bump)


def test_an_edit_belongs_to_its_ring_also_when_another_comes_nearer() -> None:
    """A hole drawn into a bump that was drawn over leaves the bump alone."""
    state = SilhouetteState(nodes=(part_of(PEN.circle(600, 450, 150)),))
    bump = PEN.along(arc(600, 310, 60, 80, 175, 365))
    state = TOOL.apply(state, Ink((bump,), True), CONTEXT)
    whole = outline_of(state.parts[0])
    part = state.parts[0]
    holed = replace(part, strokes=part.strokes.extended([PEN.circle(600, 270, 25)]))
    outline = outline_of(holed)
    assert (outline.components, outline.genus) == (1, 1)
    assert region(outline.rings[0]).area == pytest.approx(region(whole.rings[0]).area, rel=1e-3)


def test_the_solid_follows_and_undo_is_the_state_before() -> None:
    state = SilhouetteState(nodes=(part_of(PEN.circle(600, 450, 150)),))
    after = TOOL.apply(state, Ink((PEN.along(bump_in(Camera(), 600, 450, 150)),)), CONTEXT)
    tops = [drawn_rings(each, each.parts[0])[0][:, 2].max() for each in (state, after)]
    reached = [solid_of(each.parts[0], 48).vertices[:, 1].max() for each in (state, after)]
    assert reached == pytest.approx(tops, rel=5e-3)
    assert tops[1] > 1.2 * tops[0]
    assert not state.parts[0].edits


def answered(state: SilhouetteState, gesture: Ink) -> SilhouetteState:
    """The state after a gesture, or the same one after a refusal in words."""
    try:
        return TOOL.apply(state, gesture, CONTEXT)
    except UserError as refusal:
        problem = refusal
    assert problem.message.endswith(".")
    assert np.isfinite(np.array(problem.places)).all()
    return state


@pytest.mark.parametrize("seed", range(12))
def test_any_stroke_gives_an_outline_or_words(seed: int) -> None:
    random = np.random.default_rng(seed)
    camera = standard_view(Camera(), ["front", "right", "top", "three-quarter"][seed % 4])
    state = SilhouetteState(nodes=(part_of(PEN.circle(600, 450, 200), PEN.circle(600, 450, 80)),))
    for _ in range(6):
        count = int(random.integers(1, 60))
        line = random.uniform(100, 1000) + random.normal(0, 30, (count, 2)).cumsum(axis=0)
        if random.random() < 0.5:
            line = [600, 450] + random.uniform(60, 240) * (
                [1, 1] + 0.1 * random.normal(size=(count, 1))
            ) * arc(0, 0, 1, 1, *random.uniform(-400, 400, 2), count)  # fmt: skip
        gesture = Ink((Pen(camera).along(line),), True)
        preview_of(TOOL, state, gesture, CONTEXT)
        state = answered(state, gesture)
        for part in state.parts:
            assert outline_of(part).polygon().is_valid


def test_other_gestures_are_refused_in_words() -> None:
    with pytest.raises(UserError, match=TOOL.hint):
        TOOL.apply(SilhouetteState(), Drag("x", PEN.circle()), CONTEXT)
    with pytest.raises(UserError, match="no outline yet"):
        TOOL.apply(SilhouetteState(), Ink((PEN.circle(),), True), CONTEXT)
