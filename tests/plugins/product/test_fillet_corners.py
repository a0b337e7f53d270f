"""Corners where more than two curves meet: two are rounded, and the others end on the arc."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bozzetto.document.model import Document, Model
from bozzetto.document.storage.bozz_file import decode_document, encode_document
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.plugin import Context, Drag, Job, Tap
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene import Handle, Lines
from bozzetto.testing import Pen, same
from bozzetto.view import Camera
from bozzetto_product.model.arcs import Arc
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.operations.corners import Corner, corners_of
from bozzetto_product.operations.fillet import fillet
from bozzetto_product.operations.largest_radius import radius_refused
from bozzetto_product.operations.meetings import splines_of
from bozzetto_product.operations.pieces import split_curve
from bozzetto_product.operations.rounded_corners import rounded_corner
from bozzetto_product.solve.found_patches import with_patches_found
from bozzetto_product.solve.solver import solve_product
from bozzetto_product.tools.fillet import Fillet
from tests.plugins.product.test_curve_operations import misses

SIZES = (60.0, 50.0, 40.0)
TURNED = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
VIEW = Camera(eye=(260.0, 220.0, 200.0), target=(30.0, 25.0, 20.0))
RADIUS = 9.0


def box(turn: np.ndarray | None = None) -> ProductState:
    """The twelve edges of a box, every second one drawn backwards; six surfaces."""
    turn = np.eye(3) if turn is None else turn
    corners = np.array(list(itertools.product(*((0.0, size) for size in SIZES))))
    pairs = [
        (a, b)
        for a, b in itertools.combinations(range(8), 2)
        if np.count_nonzero(corners[a] != corners[b]) == 1
    ]
    pairs = [pair[:: 1 if number % 2 else -1] for number, pair in enumerate(pairs)]
    share = np.linspace(0.0, 1.0, 7)[:, None]
    curves = [
        Curve(
            f"e{number}",
            f"Edge {number}",
            spline=Spline.uniform(((1 - share) * corners[a] + share * corners[b]) @ turn.T),
        )
        for number, (a, b) in enumerate(pairs)
    ]
    joints = [
        Joint(
            f"j{corner}",
            tuple(
                Meeting(f"e{number}", float(pair.index(corner)))
                for number, pair in enumerate(pairs)
                if corner in pair
            ),
        )
        for corner in range(8)
    ]
    return with_patches_found(ProductState(nodes=tuple(curves), joints=tuple(joints)))


PAIRS = list(itertools.combinations(range(3), 2))


@pytest.mark.parametrize("corner", range(8))
@pytest.mark.parametrize("pair", PAIRS)
def test_the_solid_stays_closed_and_its_surfaces_are_kept(
    corner: int, pair: tuple[int, int]
) -> None:
    state = box(TURNED)
    joint = state.joints[corner]
    first, second = (joint.meetings[k].curve for k in pair)
    (third,) = {meet.curve for meet in joint.meetings} - {first, second}
    done, arc = fillet(state, joint.id, first, second, RADIUS)
    assert misses(done) == 0.0
    (kept,) = (one for one in done.joints if one.id == joint.id)
    assert {meet.curve for meet in kept.meetings} == {third, arc}
    assert [patch.id for patch in done.of_kind(Patch)] == [p.id for p in state.of_kind(Patch)]
    assert sorted(len(patch.boundary) for patch in done.of_kind(Patch)) == [4, 4, 4, 5, 5, 5]
    found = with_patches_found(done)
    assert found.of_kind(Patch) == done.of_kind(Patch)
    result = solve_product(done, Job())
    assert len(result.filled) == 6
    assert not result.open_edges


def test_which_is_named_first_does_not_matter() -> None:
    state = box()
    one, _ = fillet(state, "j7", *_curves_at(state, "j7")[:2], RADIUS)
    other, _ = fillet(state, "j7", *_curves_at(state, "j7")[1::-1], RADIUS)
    ends = [
        sorted(tuple(np.round(spline.value(spline.range)[k], 9)) for k in (0, 1))
        for made in (one, other)
        for spline in [splines_of(made)["e0"]]
    ]
    assert ends[0] == ends[1]
    areas = [
        sorted(round(p.fill.area, 3) for p in solve_product(made, Job()).filled if p.fill)
        for made in (one, other)
    ]
    assert areas[0] == pytest.approx(areas[1], rel=1e-5)


def _curves_at(state: ProductState, joint: str) -> list[str]:
    return [m.curve for one in state.joints if one.id == joint for m in one.meetings]


def network(lines: dict[str, list[tuple[float, float, float]]], mirrored: str = "") -> ProductState:
    """Straight curves by their ends, joined wherever an end lies on a curve; y = 0 is symmetric."""
    knots = Spline.uniform(np.zeros((7, 3))).knots
    share = np.array([knots[k + 1 : k + 4].mean() for k in range(7)])[:, None] / knots[-1]
    curves = []
    for name, ends in lines.items():
        first, last = np.array(ends, float)
        spline = Spline.uniform((1.0 - share) * first + share * last)
        curves.append(Curve(name, name, spline=spline, mirrored=name in mirrored))
    places = sorted({end for ends in lines.values() for end in ends})
    joints = []
    for number, place in enumerate(places):
        meetings = []
        for name, (first, last) in lines.items():
            way = np.subtract(last, first)
            at = float(np.subtract(place, first) @ way / (way @ way))
            off = np.linalg.norm(np.array(first) + at * way - place)
            if -1e-9 < at < 1.0 + 1e-9 and off < 1e-9:
                meetings.append(Meeting(name, at))
        joints.append(Joint(f"j{number}", tuple(meetings), bool(mirrored) and place[1] == 0.0))
    return with_patches_found(ProductState(nodes=tuple(curves), joints=tuple(joints)))


def areas(state: ProductState) -> list[float]:
    result = solve_product(state, Job())
    assert not any(one.problem for one in result.patches)
    return sorted(one.fill.area for one in result.filled if one.fill is not None)


SHEET = {
    "t": [(0.0, 0.0, 0.0), (100.0, 0.0, 0.0)],
    "u": [(0.0, 40.0, 0.0), (100.0, 40.0, 0.0)],
    "l": [(0.0, 0.0, 0.0), (0.0, 40.0, 0.0)],
    "r": [(100.0, 0.0, 0.0), (100.0, 40.0, 0.0)],
    "a": [(60.0, 0.0, 0.0), (60.0, 40.0, 0.0)],
}
"""A sheet of 100 by 40, parted by one line that ends inside both long sides."""

CUT_OFF = (1.0 - 0.25 * np.pi) * RADIUS**2
"""Area between a right angle and its arc, mm²."""

COARSE = 0.05 * CUT_OFF
"""Of triangles between an arc and its chords."""


def corner_at(state: ProductState, curves: set[str], toward: tuple[float, float, float]) -> Corner:
    return min(
        (
            one
            for one in corners_of(state.joints, splines_of(state), state.symmetry)
            if {one.first, one.second} == curves
        ),
        key=lambda one: float(np.linalg.norm(np.subtract(one.handle, toward))),
    )


def rounded(state: ProductState, corner: Corner) -> ProductState:
    done, arc = fillet(state, corner.joint, corner.first, corner.second, RADIUS, corner.ways)
    spline = splines_of(done)[arc]
    middles = spline.value(np.linspace(*spline.range, 9))
    way = np.subtract(corner.handle, corner.place)
    centre = corner.place + np.sqrt(2.0) * RADIUS * way / np.linalg.norm(way)
    assert np.linalg.norm(middles - centre, axis=1) == pytest.approx(RADIUS, rel=1e-6)
    assert [patch.id for patch in done.of_kind(Patch)] == [p.id for p in state.of_kind(Patch)]
    assert with_patches_found(done).of_kind(Patch) == done.of_kind(Patch)
    return done


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("x", [50.0, 70.0])
def test_on_a_curve_that_runs_through_the_arc_ends_inside_it(x: float, turned: bool) -> None:
    """What one surface loses the other one gets."""
    lines = {name: ends[::-1] if turned else ends for name, ends in SHEET.items()}
    state = network(lines)
    assert areas(state) == pytest.approx([1600.0, 2400.0], abs=1e-6)
    done = rounded(state, corner_at(state, {"t", "a"}, (x, 10.0, 0.0)))
    assert misses(done) < 1e-9
    found = splines_of(done)["t"].control_points[[0, -1]]
    np.testing.assert_array_equal(found, splines_of(state)["t"].control_points[[0, -1]])
    change = CUT_OFF if x < 60.0 else -CUT_OFF
    assert areas(done) == pytest.approx([1600.0 + change, 2400.0 - change], abs=COARSE)


def test_what_runs_through_meets_the_arc_of_two_others() -> None:
    """Two curves end in one place inside a third one: that goes on to touch their arc."""
    share = np.linspace(-1.0, 1.0, 9)[:, None]
    through = Spline.uniform(share * (50.0, 0.0, 0.0))
    ends = [Spline.uniform((share + 1.0) * way) for way in ((20.0, 20.0, 0.0), (-20.0, 20.0, 0.0))]
    curves = [
        Curve(name, spline=spline) for name, spline in zip("tab", (through, *ends), strict=True)
    ]
    joint = Joint("j", (Meeting("t", 0.5), Meeting("a", 0.0), Meeting("b", 0.0)))
    state = ProductState(nodes=tuple(curves), joints=(joint,))
    done, arc = fillet(state, "j", "a", "b", 5.0)
    assert misses(done) < 1e-9
    (kept,) = (one for one in done.joints if one.id == "j")
    assert {meet.curve for meet in kept.meetings} == {"t", arc}


HALF = {name: SHEET[name] for name in "tulr"}
"""Half of a sheet that is symmetric across its side t."""


def test_a_corner_in_the_symmetry_plane_is_rounded_on_both_sides() -> None:
    state = network(HALF, mirrored="ulr")
    assert areas(state) == pytest.approx([4000.0, 4000.0], abs=1e-6)
    done = rounded(state, corner_at(state, {"t", "l"}, (9.0, 9.0, 0.0)))
    spline = splines_of(done)["t"].control_points
    assert (spline[:, 1] == 0.0).all()
    assert min(spline[[0, -1], 0]) == pytest.approx(RADIUS)
    one, other = areas(done)
    assert one == pytest.approx(4000.0 - CUT_OFF, abs=COARSE)
    assert one == other
    (foot,) = (
        joint for joint in done.joints if {m.curve for m in joint.meetings} == {"t", done.selected}
    )
    assert foot.in_plane


@pytest.mark.parametrize("x", [50.0, 70.0])
def test_a_curve_in_the_symmetry_plane_stays_whole_where_it_goes_on(x: float) -> None:
    state = network(SHEET, mirrored="ulra")
    done = rounded(state, corner_at(state, {"t", "a"}, (x, 10.0, 0.0)))
    change = CUT_OFF if x < 60.0 else -CUT_OFF
    expected = [1600.0 + change] * 2 + [2400.0 - change] * 2
    assert areas(done) == pytest.approx(expected, abs=COARSE)
    found = splines_of(done)["t"].control_points
    np.testing.assert_array_equal(found, splines_of(state)["t"].control_points)


def test_a_corner_of_two_curves_in_the_symmetry_plane_stays_in_it() -> None:
    """A third curve that ends there ends on the arc, in the plane, from then on."""
    lines = {**HALF, "v": [(0.0, 0.0, 0.0), (0.0, 0.0, 50.0)]}
    state = network(lines, mirrored="ulr")
    done, arc = fillet(state, *corner_names(state, {"t", "v"}), RADIUS)
    spline = splines_of(done)[arc]
    assert (spline.control_points[:, 1] == 0.0).all()
    middle = np.array((RADIUS, 0.0, RADIUS))
    away = np.linalg.norm(spline.value(np.linspace(*spline.range, 9)) - middle, axis=1)
    assert away == pytest.approx(RADIUS, rel=1e-6)
    assert misses(done) < 1e-9
    on_arc = [one for one in done.joints if any(m.curve == arc for m in one.meetings)]
    assert len(on_arc) == 3
    assert all(one.in_plane for one in on_arc)


def corner_names(state: ProductState, curves: set[str]) -> tuple[str, str, str]:
    corner = corner_at(state, curves, (0.0, 0.0, 0.0))
    return corner.joint, corner.first, corner.second


def _context(state: ProductState) -> Context:
    scene = ProductModeler().scene(state, solve_product(state, Job()))
    return Context(camera=VIEW, scene=scene)


def test_every_corner_has_a_handle_of_the_tool() -> None:
    state = box()
    items = [(layer, item) for layer, item in _context(state).scene.items()]
    handles = [item for layer, item in items if isinstance(item, Handle) and layer.tool == "fillet"]
    assert len(handles) == 8 * len(PAIRS)


@pytest.mark.parametrize("radius", [4.0, 18.0])
def test_the_arc_goes_where_the_pen_drags_it(radius: float) -> None:
    """Dragged along the bisector to where the middle of the arc of a radius is."""
    state = box()
    corner = next(
        one
        for one in corners_of(state.joints, splines_of(state), state.symmetry)
        if one.joint == "j7"
    )
    start, place = np.array(corner.handle), np.array(corner.place)
    way = (start - place) / np.linalg.norm(start - place)
    goal = place + radius * (1.0 / np.sin(0.25 * np.pi) - 1.0) * way
    top = Camera(kind="orthographic", eye=tuple(start + 300.0 * np.cross(*_ways(corner, state))),
                 target=tuple(start), up=tuple(way), height=200.0)  # fmt: skip
    pixels = top.project(np.array((start, goal)))[0]
    path = Pen(camera=top).along([tuple(map(float, pixel)) for pixel in pixels])
    drag = Drag(corner.name, path)
    context = Context(camera=top)
    preview = Fillet().preview(state, drag, context)
    assert [layer.name for layer in preview.layers] == ["rounded"]
    done = Fillet().drag(state, drag, context)
    assert done.rounding == pytest.approx(radius, rel=0.02)
    arc = splines_of(done)[done.selected]
    middle = arc.value([np.mean(arc.range)])[0]
    assert np.linalg.norm(middle - goal) < 0.05 * radius


def _ways(corner: Corner, state: ProductState) -> tuple[np.ndarray, np.ndarray]:
    splines = splines_of(state)
    ways = []
    for name in (corner.first, corner.second):
        ends = splines[name].control_points[[0, -1]]
        far = ends[int(np.argmax(np.linalg.norm(ends - corner.place, axis=1)))]
        ways.append((far - corner.place) / np.linalg.norm(far - corner.place))
    return ways[0], ways[1]


def test_a_touch_on_a_dot_takes_the_radius_that_is_set() -> None:
    state = box()
    corner = next(
        one
        for one in corners_of(state.joints, splines_of(state), state.symmetry)
        if one.joint == "j7"
    )
    x, y = VIEW.project(np.array((corner.handle,)))[0][0].tolist()
    path = Pen(camera=VIEW).along([(x, y), (x + 0.4, y)])
    done = Fillet().drag(state, Drag(corner.name, path), Context(camera=VIEW))
    assert done.rounding == state.rounding
    by_number, _ = fillet(state, corner.joint, corner.first, corner.second, state.rounding)
    assert same(done.joints, by_number.joints)


def test_the_preview_shows_what_changes_only() -> None:
    state = box()
    corner = next(
        one
        for one in corners_of(state.joints, splines_of(state), state.symmetry)
        if one.joint == "j7"
    )
    x, y = VIEW.project(np.array((corner.handle,)))[0][0].tolist()
    path = Pen(camera=VIEW).along([(x, y), (x + 6.0, y)])
    (layer,) = Fillet().preview(state, Drag(corner.name, path), Context(camera=VIEW)).layers
    (item,) = layer.items
    assert isinstance(item, Lines)
    assert len(item.starts) == 4  # three curves that end in the corner, and the arc


@pytest.mark.parametrize("pair", PAIRS)
def test_a_touch_means_the_corner_that_it_lies_in(pair: tuple[int, int]) -> None:
    state = box()
    curves = _curves_at(state, "j7")
    names = {curves[k] for k in pair}
    wanted = next(
        one
        for one in corners_of(state.joints, splines_of(state), state.symmetry)
        if one.joint == "j7" and {one.first, one.second} == names
    )
    seen = VIEW.project(np.array((wanted.place, wanted.handle)))[0]
    x, y = seen[0] + 12.0 * (seen[1] - seen[0]) / np.linalg.norm(seen[1] - seen[0])
    done = Fillet().tap(state, Tap(float(x), float(y), VIEW), _context(state))
    arc = splines_of(done)[done.selected]
    joined = {
        meet.curve
        for one in done.joints
        if any(m.curve == done.selected and m.at in (0.0, 1.0) for m in one.meetings)
        for meet in one.meetings
    }
    assert joined == {*names, done.selected}
    assert np.linalg.norm(arc.value(arc.range) - wanted.place, axis=1).max() < 6.0


def test_nothing_is_rounded_where_no_corner_is() -> None:
    state = box()
    with pytest.raises(UserError, match="no corner"):
        Fillet().tap(state, Tap(3.0, 3.0, VIEW), _context(state))
    path = Pen(camera=VIEW).along([(100.0, 100.0), (120.0, 100.0)])
    with pytest.raises(UserError, match="not there any more"):
        Fillet().drag(state, Drag("corner j7 e0 gone", path), _context(state))


def test_another_radius_typed_rounds_the_corner_anew() -> None:
    """It is the network that the first radius would have made, but for ids and their order."""
    state = box()
    names = ("j7", *_curves_at(state, "j7")[:2])
    once = rounded_corner(state, *names, 5.0)
    arc = once.node(once.selected)
    assert isinstance(arc, Arc)
    painted = once.with_node(replace(arc, color=(200, 10, 10), name="Lip"))
    nodes = tuple(replace(n, radius=9.0) if n.id == arc.id else n for n in painted.nodes)
    anew = ProductModeler().with_parts(painted, nodes, arc.id)
    fresh = rounded_corner(state, *names, 9.0)
    for name, spline in splines_of(fresh).items():
        np.testing.assert_array_equal(splines_of(anew)[name].control_points, spline.control_points)
    assert {joint.id: set(joint.meetings) for joint in anew.joints} == {
        joint.id: set(joint.meetings) for joint in fresh.joints
    }
    assert [one.boundary for one in anew.of_kind(Patch)] == [
        one.boundary for one in fresh.of_kind(Patch)
    ]
    kept = anew.node(arc.id)
    assert (kept.name, kept.color, kept.radius) == ("Lip", (200, 10, 10), 9.0)
    back = ProductModeler().with_parts(
        anew, tuple(replace(n, radius=5.0) if n.id == arc.id else n for n in anew.nodes), arc.id
    )
    assert same(back.node(arc.id).spline, arc.spline)


def test_a_corner_that_was_changed_since_keeps_its_radius_and_says_so() -> None:
    state = box()
    once = rounded_corner(state, "j7", *_curves_at(state, "j7")[:2], 5.0)
    arc = once.node(once.selected)
    cut, _ = split_curve(once, arc.rounded.first, [0.4])
    nodes = tuple(replace(n, radius=9.0) if n.id == arc.id else n for n in cut.nodes)
    with pytest.raises(UserError, match="changed since"):
        ProductModeler().with_parts(cut, nodes, arc.id)
    nodes = tuple(replace(n, radius=900.0) if n.id == arc.id else n for n in once.nodes)
    with pytest.raises(UserError, match="too large"):
        ProductModeler().with_parts(once, nodes, arc.id)


def test_an_arc_comes_back_from_a_document_and_is_rounded_anew() -> None:
    state = box()
    once = rounded_corner(state, "j7", *_curves_at(state, "j7")[:2], 5.0)
    version = ProductModeler.state_version
    made = Model("m", "Box", "bozzetto.product", once, state_version=version)
    content = encode_document(Document((made,)))
    (again,) = decode_document(content, Registry())[0].models
    assert encode_document(Document((again,))) == content
    nodes = tuple(replace(n, radius=7.0) if n.id == once.selected else n for n in again.state.nodes)
    anew = ProductModeler().with_parts(again.state, nodes, once.selected)
    wanted = rounded_corner(state, "j7", *_curves_at(state, "j7")[:2], 7.0)
    assert same(anew.node(once.selected).spline, wanted.node(wanted.selected).spline)


def test_a_radius_that_is_too_large_is_refused_with_the_largest_one() -> None:
    state = box()
    first, second = _curves_at(state, "j7")[:2]
    with pytest.raises(UserError, match=r"at most ([\d.]+) mm") as refused:
        rounded_corner(state, "j7", first, second, 900.0)
    largest = float(re.findall(r"at most ([\d.]+) mm", str(refused.value))[0])
    rounded_corner(state, "j7", first, second, largest)
    with pytest.raises(UserError, match="too large"):
        rounded_corner(state, "j7", first, second, 1.15 * largest)
    lengths = [
        np.ptp(splines_of(state)[name].control_points, axis=0).max() for name in (first, second)
    ]
    assert 0.9 * min(lengths) <= largest <= min(lengths)  # square: the arc ends at its radius


@pytest.mark.parametrize("most", [0.03, 1.0, 7.77])
def test_the_largest_radius_found_fits(most: float) -> None:
    told = str(radius_refused("No", 10.0, lambda size: size <= most, 12))
    found = float(re.findall(r"at most ([\d.e+-]+) mm", told)[0])
    assert 0.9 * most <= found <= most


def test_where_no_radius_fits_none_is_told() -> None:
    told = str(radius_refused("No", 10.0, lambda size: False, 4))
    assert "at most" not in told
    assert "Leave it" in told


@pytest.mark.parametrize("radius", [5.0, 12.0])
def test_a_radius_by_which_a_surface_folds_is_refused(
    monkeypatch: pytest.MonkeyPatch, radius: float
) -> None:
    def solved(made: ProductState, job: Job) -> SimpleNamespace:
        folds = any(one.radius > 6.0 for one in made.of_kind(Arc))
        one = SimpleNamespace(surface=object(), creased=(0,) if folds else ())
        return SimpleNamespace(patches=(one,))

    monkeypatch.setattr("bozzetto_product.tools.fillet.solve_product", solved)
    state = replace(box(), rounding=radius)
    corner = next(
        one
        for one in corners_of(state.joints, splines_of(state), state.symmetry)
        if one.joint == "j7"
    )
    x, y = VIEW.project(np.array((corner.handle,)))[0][0].tolist()
    still = Drag(corner.name, Pen(camera=VIEW).along([(x, y), (x + 0.4, y)]))
    if radius < 6.0:
        done = Fillet().drag(state, still, Context(camera=VIEW))
        assert [one.radius for one in done.of_kind(Arc)] == [radius]
        return
    with pytest.raises(UserError, match=r"would fold.*at most ([\d.]+) mm") as refused:
        Fillet().drag(state, still, Context(camera=VIEW))
    assert 5.0 <= float(re.findall(r"at most ([\d.]+) mm", str(refused.value))[0]) <= 6.0
