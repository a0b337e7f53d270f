"""Drafts: what is seen of them is the body, and a change costs what it touches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import Cancelled, UserError
from bozzetto.geometry import Mesh, Placement
from bozzetto.plugin.cache import forget_all
from bozzetto.scene import Layer, Scene, Shaded, cast_rays
from bozzetto.view import Rays
from bozzetto_silhouette.appearance.surface_look import painted, sketched
from bozzetto_silhouette.implicit.composite import Composite
from bozzetto_silhouette.implicit.fillet_solid import Shaped
from bozzetto_silhouette.model.state import Group, Operation, Part, SilhouetteState
from bozzetto_silhouette.solids import draft as drafts
from bozzetto_silhouette.solids import evaluate as tree
from bozzetto_silhouette.solids import fillet, lump
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.fillet_rim import END, OUTER, with_even_rim
from bozzetto_silhouette.solids.traversal import without_blends
from tests.plugins.silhouette import bodies as b

RADIUS = 50.0


@pytest.fixture(autouse=True)
def leaves(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every part is a ball where its pose puts it."""
    ball = b.ball(resolution=32)
    remembered: dict[object, Body] = {}

    def body_of(part: Part, resolution: int, checkpoint) -> Body:
        if part.name == "bad":
            raise UserError("This ink is no outline.", places=[(1.0, 2.0)])
        return remembered.setdefault(
            (part.id, part.pose), replace(ball.placed(part.pose), sources=(part.id,))
        )

    for module in (tree, drafts):
        monkeypatch.setattr(module, "body_of", body_of)


def part(name: str, x: float = 0.0, z: float = 0.0, **changes) -> Part:
    pose = Placement(offset=(x, z, 0.0))
    return replace(Part(id=name, name=name, pose=pose, blend=0.0), **changes)


def draft(*nodes: Part | Group, chosen: str = "") -> Body:
    found, _ = drafts.draft_of(SilhouetteState(nodes, selected=chosen), 32)
    assert found is not None
    return found.body


def seen(shape: Body, low: tuple[float, float], high: tuple[float, float]):
    """Where parallel rays along the third axis meet a shape, and its normals there."""
    x, y = (
        axis.ravel() for axis in np.meshgrid(*map(np.linspace, low, high, (41, 41)))
    )  # fmt: skip
    rays = Rays(
        np.column_stack([x, y, np.full(len(x), 900.0)]), np.tile([0.0, 0.0, -1.0], (len(x), 1))
    )
    mesh = Mesh(shape.vertices.astype(np.float32), shape.faces, shape.normals.astype(np.float32))
    return cast_rays(Scene((Layer("s", (Shaded(mesh),)),)), rays)


def assert_alike(nodes: tuple[Part | Group, ...], low, high) -> None:
    """What is seen of the draft is the body, but for how even the fillets are."""
    state = SilhouetteState(nodes)
    body, some = tree.tree_body(state, 32), draft(*nodes)
    assert body is not None
    one, other = seen(body, low, high), seen(some, low, high)
    assert (one.hit != other.hit).mean() < 0.01
    both = one.hit & other.hit
    assert both.sum() > 100
    gap = np.abs(one.points[both] - other.points[both]).max(axis=1)
    assert np.median(gap) < 1e-3  # of 50, after two changes of frame in single precision
    assert np.quantile(gap, 0.97) < 0.5 * body.step
    assert np.allclose(np.linalg.norm(some.normals, axis=1), 1.0, atol=1e-6)
    # Nothing that is seen is inside out, and shading is that of the body.
    corners = some.faces[other.faces[both]]
    facing = np.cross(*(some.vertices[corners[:, k]] - some.vertices[corners[:, 0]]
                        for k in (1, 2)))  # fmt: skip
    leaning = np.einsum("fk,fk->f", facing, some.normals[corners].mean(axis=1))
    assert (leaning < -1e-9).mean() < 0.01


@pytest.mark.parametrize("operation", ["add", "merge", "carve", "intersect"])
@pytest.mark.parametrize("blend", [0.0, 0.5])
def test_it_looks_like_the_body(operation: str, blend: float) -> None:
    nodes = (
        part("a"), part("b", 60.0, blend=blend, operation=operation), part("c", 95.0, blend=blend),
    )  # fmt: skip
    assert_alike(nodes, (-60.0, -55.0), (150.0, 55.0))


@pytest.mark.parametrize("blend", [0.2, 0.5])
def test_where_fillets_end_they_are_shaded_like_what_they_end_on(blend: float) -> None:
    some = draft(part("a"), part("b", 60.0, blend=blend), part("c", 30.0, 55.0, blend=blend))
    meant = some.implicit.sample(some.vertices)
    slope = meant.gradient / np.linalg.norm(meant.gradient, axis=1, keepdims=True)
    near = np.abs(meant.value) < 0.5 * some.step  # as deep as may be seen
    cosine = -(some.normals * slope).sum(axis=1)[near]
    assert near.sum() > 1000
    assert cosine.min() > np.cos(np.radians(45.0)), "flanks of fillets are steeper"


@pytest.mark.parametrize("blend", [0.0, 0.4])
@pytest.mark.parametrize("mirrors", [1.0, -1.0])
def test_groups_that_were_moved_and_carved_look_like_the_body(blend: float, mirrors) -> None:
    pose = Placement((0.6, 0.8, 0.0, -0.8, 0.6, 0.0, 0.0, 0.0, mirrors), 1.3, (20.0, -10.0, 5.0))
    nodes = (
        part("a"),
        Group(id="g", pose=pose, blend=blend),
        part("b", 60.0, within="g"),
        part("c", 110.0, 10.0, within="g", blend=blend),
        part("d", 85.0, 40.0, within="g", operation="carve", blend=blend),
        part("e", 60.0, -60.0, operation="carve", blend=blend),
        part("f", -30.0, 60.0, blend=blend),
    )
    assert_alike(nodes, (-90.0, -200.0), (220.0, 130.0))


def test_a_group_carves_as_one() -> None:
    nodes = (
        part("a"), part("b", 60.0), Group(id="g", operation="carve", blend=0.0),
        part("c", 30.0, 40.0, within="g"), part("d", 50.0, 40.0, within="g"),
    )  # fmt: skip
    assert_alike(nodes, (-60.0, -55.0), (115.0, 55.0))


def test_nothing_and_what_carves_everything_leave_nothing() -> None:
    for nodes in ((), (part("a", visible=False),), (part("a"), part("a2", operation="carve")),
                  (part("a"), part("b", 300.0, operation="intersect"))):  # fmt: skip
        assert drafts.draft_of(SilhouetteState(nodes), 32)[0] is None
    after = part("a"), part("a2", operation="carve"), part("c", 40.0)
    assert len(draft(*after).vertices) == len(draft(part("c", 40.0)).vertices)


def test_one_part_is_itself() -> None:
    assert draft(part("a")) is tree.tree_body(SilhouetteState((part("a"),)), 32)


def test_it_is_told_by_the_state_alone() -> None:
    nodes = part("a"), *(part(f"b{k}", 30.0 * k - 45.0, blend=0.5) for k in range(4))
    first = draft(*nodes, chosen="b1")
    draft(*nodes)  # now all its fillets are remembered
    again = draft(*nodes, chosen="b1")
    forget_all()
    anew = draft(*nodes, chosen="b1")
    for other in (again, anew):
        assert np.array_equal(other.vertices, first.vertices)
        assert np.array_equal(other.faces, first.faces)


def test_a_part_that_meets_many_is_shown_without_the_fillets_that_change_with_it() -> None:
    limbs = [part(f"b{k}", 400.0 * np.cos(k), 400.0 * np.sin(k), blend=0.5) for k in range(5)]
    trunk = part("a", pose=Placement(scale=7.5))
    nodes = (trunk, *limbs)
    sharp = len(draft(*without_blends(SilhouetteState(nodes)).nodes).faces)
    assert len(draft(*nodes, chosen="a").faces) == sharp
    one = len(draft(*nodes).faces)
    assert len(draft(*nodes, chosen="b3").faces) == one > sharp  # but for limb 3 they stand
    group = Group(id="g", blend=0.5)
    inside = (trunk, group, *(replace(limb, within="g") for limb in limbs))
    assert len(draft(*inside, chosen="g").faces) == len(draft(*inside, chosen="b3").faces)


def test_an_early_part_of_a_large_tree_costs_neither_fillets_nor_a_union(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[object] = []
    real = fillet.extracted
    monkeypatch.setattr(
        fillet, "extracted", lambda some, *more: made.extend(some) or real(some, *more)
    )

    def united(*_: object) -> None:
        raise AssertionError("the tree was united")

    monkeypatch.setattr(lump, "is_union", united)
    row = [part(f"n{k}", 80.0 * k, blend=0.4) for k in range(12)]
    draft(*row, chosen="n0")
    assert 8 <= len(made) <= 11
    made.clear()
    for k in range(5):
        draft(part("n0", -1.0 * k, blend=0.4), *row[1:], chosen="n0")
    assert len(made) <= 2 * 5


def test_colours_are_those_of_the_parts() -> None:
    red, blue = (200, 30, 30), (30, 30, 200)
    nodes = (part("a", color=red), part("b", 70.0, color=blue, blend=0.5))
    state = SilhouetteState(nodes)
    some, body = drafts.draft_of(state, 32)[0], tree.tree_body(state, 32)
    assert some is not None
    assert body is not None
    shown, final = sketched(state, some), painted(state, body).shown
    assert shown.colors is not None
    assert final.colors is not None
    for x, color in ((-30.0, red), (110.0, blue)):
        for mesh in (shown, final):
            near = np.abs(mesh.vertices[:, 0] - x) < 4.0
            assert near.any()
            assert (mesh.colors[near, :3] == color).all()
    plain = SilhouetteState((part("a"), part("b", 70.0)))
    bare = drafts.draft_of(plain, 32)[0]
    assert bare is not None
    assert sketched(plain, bare).colors is None


@pytest.mark.parametrize("operation", ["carve", "intersect"])
@pytest.mark.parametrize("blend", [0.0, 0.3])
def test_walls_belong_to_what_made_them_and_have_its_colour_or_else_that_under_it(
    operation: str, blend: float
) -> None:
    red, blue, green = (200, 30, 30), (30, 30, 200), (30, 200, 30)
    tool = part("t", 60.0, operation=operation, blend=blend)
    nodes = (part("a", color=red), part("b", 0.0, 40.0, color=blue), tool)
    for color in (None, green):
        state = SilhouetteState((*nodes[:2], replace(tool, color=color)))
        some, body = drafts.draft_of(state, 32)[0], tree.tree_body(state, 32)
        assert some is not None
        assert body is not None
        one, other = some.body, body
        names, owners = (np.array(each.sources)[each.origins] for each in (one, other))
        on_wall = [
            np.abs(np.linalg.norm(each.vertices - (60.0, 0.0, 0.0), axis=1) - 50.0) < 0.02
            for each in (one, other)
        ]
        assert on_wall[0].sum() > 100
        assert (names[on_wall[0]] == "t").mean() > 0.95
        assert (owners[on_wall[1]] == "t").mean() > 0.95
        shown = sketched(state, some).colors
        assert shown is not None
        seen_there = {tuple(row) for row in shown[on_wall[0] & (names == "t"), :3].tolist()}
        assert seen_there == ({green} if color else {red, blue})


def test_a_mistake_names_its_part_and_nobody_waits_for_what_is_not_wanted() -> None:
    with pytest.raises(UserError, match=r"^bad: This ink"):
        draft(part("a"), part("bad"))

    def cancelled(fraction: float, step: str) -> None:
        raise Cancelled(step)

    with pytest.raises(Cancelled):
        drafts.draft_of(SilhouetteState((part("a"), part("b", 60.0, blend=0.5))), 32, cancelled)


@pytest.mark.parametrize("operation", ["add", "merge", "carve"])
@pytest.mark.parametrize(("blend", "away"), [(0.5, 60.0), (1.0, 75.0), (0.4, 50.0)])
def test_the_rim_of_a_fillet_has_no_teeth(operation: Operation, blend: float, away: float) -> None:
    """It lies where the blended side meets the ends, and what is seen is the blended surface."""
    one, other = b.ball(resolution=32), b.ball(away, 30.0, 32, "b")
    solid = Composite(one.implicit, other.implicit, operation, blend, 30.0 * blend)
    box = fillet.common_box(one.bounds, other.bounds, 2.0 * solid.reach)
    step = min(one.step, other.step)
    made = fillet.fillets_of([fillet.Blend(solid, box, (one, other), step)])[0]
    assert made
    for some in made:
        even = with_even_rim(some, solid, step)
        assert np.array_equal(even.faces, some.surface.faces)
        assert np.isfinite(even.vertices).all()
        assert np.allclose(np.linalg.norm(even.normals, axis=1), 1.0, atol=1e-6)
        off = []
        for surface in (some.surface, even):
            shaped, _ = Shaped.of(solid, step, some.cell, some.surface.vertices)
            side = np.stack([shaped.top, shaped.floor, shaped.flank]).argmin(axis=0)
            a, c = surface.faces.ravel(), np.roll(surface.faces, -1, axis=1).ravel()
            rim = np.unique(a[(side[a] == OUTER) & (side[c] == END)])
            assert len(rim) > 20
            now, _ = Shaped.of(solid, step, some.cell, surface.vertices)
            away_from = np.maximum(np.abs(now.top), np.abs(now.flank))[rim] / some.cell
            others = np.concatenate([rim, c[(side[c] == OUTER) & (side[a] == END)]])
            outer = np.setdiff1d(np.flatnonzero(side == OUTER), others)
            beside = np.quantile(np.abs(now.top[outer]), 0.99) / some.cell
            off.append((np.quantile(away_from, 0.9), beside))
        (teeth, _), (smooth, beside) = off
        assert smooth < 0.15
        assert smooth < 0.25 * teeth
        assert beside < 0.1
