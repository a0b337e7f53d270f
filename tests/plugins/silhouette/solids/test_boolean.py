"""Two bodies put together: set laws, shapes with known answers, hostile poses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bozzetto.geometry import Placement
from bozzetto_silhouette.appearance.surface_look import creased
from bozzetto_silhouette.outline.outline import outline_from_rings
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.boolean import combined
from tests.plugins.silhouette import bodies as b
from tests.plugins.silhouette import outlines as o
from tests.plugins.silhouette.solids.figures_creases import creases, pairs

OPERATIONS = ("add", "merge", "carve", "intersect")
UPSIDE = b.turn("z", 90.0)


@pytest.fixture(scope="module")
def balls() -> tuple[Body, Body]:
    return b.ball(0.0), b.ball(70.0, name="b")


@pytest.fixture(scope="module")
def bars() -> tuple[Body, Body]:
    """Two tubes of radius 10 that overlap in line by 40."""
    bar = b.capsule(50.0, 10.0, 64)
    return bar.placed(Placement(offset=(-30, 0, 0))), bar.placed(Placement(offset=(30, 0, 0)))


@pytest.fixture(scope="module")
def outlines() -> list[Body]:
    """Real outlines at size 100 about the origin."""
    result = []
    for path in sorted(o.COMMITTED.glob("*.svg")):
        body = b.body(o.outline(path.stem), 32, path.stem)
        scale = 100.0 / np.ptp(body.bounds, axis=0).max()
        middle = scale * body.bounds.mean(axis=0)
        x, y, z = (float(-v) for v in middle)
        result.append(body.placed(Placement(scale=float(scale), offset=(x, y, z))))
    return result


class TestSharp:
    def test_inclusion_and_exclusion(self, balls: tuple[Body, Body]) -> None:
        one, other = balls
        union, common = (combined(one, other, op, 0.0) for op in ("add", "intersect"))
        assert b.volume(union) + b.volume(common) == pytest.approx(
            b.volume(one) + b.volume(other), rel=1e-9
        )
        # Two caps of a ball of radius 50, cut 35 from the middle.
        lens = 2.0 * np.pi * 15.0**2 * (3.0 * 50.0 - 15.0) / 3.0
        assert b.volume(common) == pytest.approx(lens, rel=0.03)
        assert b.volume(combined(one, other, "carve", 0.0)) == pytest.approx(
            b.volume(one) - b.volume(common), rel=1e-9
        )

    def test_with_itself(self, balls: tuple[Body, Body]) -> None:
        one = balls[0]
        assert b.volume(combined(one, one, "add", 0.0)) == pytest.approx(b.volume(one), rel=1e-6)
        assert b.volume(combined(one, one, "intersect", 0.0)) == pytest.approx(
            b.volume(one), rel=1e-6
        )
        assert combined(one, one, "carve", 0.0) is None

    def test_what_is_far_apart_stays_as_it_is(self, balls: tuple[Body, Body]) -> None:
        one = balls[0]
        far = balls[1].placed(Placement(offset=(1e3, 0, 0)))
        both = combined(one, far, "add", 0.5)
        assert both is not None
        b.assert_sound(both)
        assert both.sources == ("a", "b")
        assert np.bincount(both.origins).tolist() == [len(one.vertices), len(far.vertices)]
        assert combined(one, far, "carve", 0.5) is one
        assert combined(one, far, "intersect", 0.5) is None

    def test_one_inside_the_other(self, balls: tuple[Body, Body]) -> None:
        one = balls[0]
        core = one.placed(Placement(scale=0.4))
        for blend in (0.0, 0.5):
            assert b.volume(combined(one, core, "add", blend)) == pytest.approx(
                b.volume(one), rel=1e-6
            )
            hollow = combined(one, core, "carve", blend)
            assert hollow is not None
            assert b.volume(hollow) == pytest.approx(b.volume(one) - b.volume(core), rel=1e-6)
        assert combined(core, one, "carve", 0.5) is None

    def test_origins_and_normals_come_from_the_side_they_lie_on(
        self, balls: tuple[Body, Body]
    ) -> None:
        whole = combined(*balls, "add", 0.0)
        assert whole is not None
        smooth = np.setdiff1d(np.arange(len(whole.vertices)), whole.creases)
        vertices, origins = whole.vertices[smooth], whole.origins[smooth]
        middle = np.array([[0.0, 0.0, 0.0], [70.0, 0.0, 0.0]])[origins]
        assert np.linalg.norm(vertices - middle, axis=1) == pytest.approx(50.0, rel=0.02)
        radial = (vertices - middle) / np.linalg.norm(vertices - middle, axis=1)[:, None]
        assert (radial * whole.normals[smooth]).sum(axis=1).min() > 0.995
        carved = combined(*balls, "carve", 0.0)
        assert carved is not None
        cup = np.setdiff1d(np.flatnonzero(carved.origins == 1), carved.creases)
        inward = [70.0, 0.0, 0.0] - carved.vertices[cup]
        assert (carved.normals[cup] * inward).sum(axis=1).min() > 0.0


def test_creases_are_shown_sharp(balls: tuple[Body, Body]) -> None:
    whole = combined(*balls, "add", 0.0)
    assert whole is not None
    shown = creased(whole)
    assert np.array_equal(shown.vertices[shown.faces], whole.vertices.astype("f")[whole.faces])
    new = shown.vertices[len(whole.vertices) :].astype(float)
    normals = shown.normals[len(whole.vertices) :]
    assert len(new) > 3 * len(whole.creases)
    radial = np.stack([(new - [x, 0.0, 0.0]) / 50.0 for x in (0.0, 70.0)])
    assert (radial * normals).sum(axis=2).max(axis=0).min() > 0.98


class TestBlended:
    def test_no_bulge_where_limbs_overlap_in_line(self, bars: tuple[Body, Body]) -> None:
        whole = combined(*bars, "add", 0.5)
        assert whole is not None
        b.assert_sound(whole)
        for x in (-20.0, 0.0, 20.0):
            for way in ((0, 1, 0), (0, 0, 1), (0, 0.6, -0.8)):
                height = b.reach_along(whole, (x, 0.0, 0.0), way)
                alone = b.reach_along(bars[x > 0], (x, 0.0, 0.0), way)
                assert height == pytest.approx(alone, rel=0.02)

    def test_a_limb_leaves_the_back_of_another_flat(self, bars: tuple[Body, Body]) -> None:
        trunk = bars[0].placed(Placement(offset=(30, 0, 0)))
        limb = trunk.placed(UPSIDE).placed(Placement(offset=(0, 60, 0)))
        whole = combined(trunk, limb, "add", 1.0)
        assert whole is not None
        b.assert_sound(whole)
        assert b.reach_along(whole, (0, 0, 0), (0, -1, 0)) == pytest.approx(10.0, rel=0.05)
        assert b.reach_along(whole, (0, 0, 0), (0, 0, 1)) == pytest.approx(10.0, rel=0.05)
        corner = b.reach_along(whole, (0, 0, 0), (np.sqrt(0.5), np.sqrt(0.5), 0))
        assert corner > 10.0 * np.sqrt(2.0) * 1.08

    @pytest.mark.parametrize("operation", OPERATIONS)
    def test_small_blends_tend_to_the_sharp_result(
        self, balls: tuple[Body, Body], operation
    ) -> None:
        sharp = b.volume(combined(*balls, operation, 0.0))
        gaps = [
            abs(b.volume(combined(*balls, operation, blend)) - sharp) for blend in (0.6, 0.3, 0.15)
        ]
        assert gaps[0] > gaps[1] > gaps[2]
        assert gaps[2] < 0.04 * sharp

    def test_fills_and_takes_away_on_the_right_side(self, balls: tuple[Body, Body]) -> None:
        for operation, sign in (("add", 1), ("merge", 1), ("carve", -1), ("intersect", -1)):
            sharp, soft = (combined(*balls, operation, blend) for blend in (0.0, 0.4))
            assert soft is not None
            b.assert_sound(soft)
            assert sign * (b.volume(soft) - b.volume(sharp)) > 0.0

    @pytest.mark.parametrize("operation", ["add", "merge", "intersect"])
    def test_order_does_not_matter(self, balls: tuple[Body, Body], operation) -> None:
        one, other = balls
        other = other.placed(b.turn("y", 20.0))
        forth, back = combined(one, other, operation, 0.5), combined(other, one, operation, 0.5)
        assert b.volume(forth) == pytest.approx(b.volume(back), rel=1e-9)
        assert forth is not None
        assert back is not None
        assert np.array_equal(np.sort(forth.vertices, axis=0), np.sort(back.vertices, axis=0))

    def test_the_fillet_lies_on_the_blended_solid_and_is_well_shaped(
        self, balls: tuple[Body, Body]
    ) -> None:
        whole = combined(*balls, "add", 0.5)
        assert whole is not None
        assert len(whole.creases) == 0
        assert np.abs(whole.implicit.value(whole.vertices)).max() < 0.1 * whole.step
        corner = whole.vertices[whole.faces]
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        edges = np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2)
        quality = 2.0 * np.sqrt(3.0) * np.linalg.norm(normal, axis=1) / (edges**2).sum(axis=1)
        fillet = (np.abs(corner[..., 0] - 35.0) < 12.0).any(axis=1)
        assert np.quantile(quality[fillet], 0.05) > 0.4
        unit = normal / np.linalg.norm(normal, axis=1)[:, None]
        cosine = (unit[:, None] * whole.normals[whole.faces]).sum(axis=2)
        assert cosine[fillet].min() > 0.5
        assert np.quantile(cosine[fillet], 0.02) > 0.9

    @pytest.mark.parametrize(
        "placement",
        [
            Placement(scale=1e-3),
            Placement(scale=1e3),
            b.turn("x", 33.0),
            Placement(offset=(1e4, -2e4, 5e3)),
            Placement(rotation=(-1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0)),
        ],
        ids=["tiny", "huge", "turned", "far away", "mirrored"],
    )
    def test_the_same_wherever_it_stands(
        self, balls: tuple[Body, Body], placement: Placement
    ) -> None:
        here = combined(*balls, "carve", 0.4)
        there = combined(*(body.placed(placement) for body in balls), "carve", 0.4)
        assert there is not None
        b.assert_sound(there)
        assert b.volume(there) == pytest.approx(b.volume(here) * placement.scale**3, rel=2e-3)

    def test_a_tunnel_through_a_ring_adds_a_handle(self) -> None:
        ring = b.body(outline_from_rings([o.circle(0, 0, 50), o.circle(0, 0, 20)]), 48)
        assert b.genus(ring) == 1
        drill = b.capsule(40.0, 5.0).placed(b.turn("y", 90.0)).placed(Placement(offset=(35, 0, 0)))
        for blend in (0.0, 0.5):
            drilled = combined(ring, drill, "carve", blend)
            assert drilled is not None
            b.assert_sound(drilled)
            assert b.genus(drilled) == 2

    def test_merging_joins_what_nearly_touches_and_adding_does_not(
        self, balls: tuple[Body, Body]
    ) -> None:
        one = balls[0]
        other = balls[1].placed(Placement(offset=(34.0, 0, 0)))  # a gap of 4
        pieces = {}
        for operation in ("add", "merge"):
            whole = combined(one, other, operation, 0.5)
            assert whole is not None
            b.assert_sound(whole)
            pieces[operation] = len(whole.manifold.decompose())
        assert pieces == {"add": 2, "merge": 1}
        far = balls[1].placed(Placement(offset=(80.0, 0, 0)))
        assert b.volume(combined(one, far, "merge", 0.5)) == pytest.approx(
            b.volume(one) + b.volume(far), rel=1e-6
        )

    def test_what_was_blended_can_be_blended_again(self, balls: tuple[Body, Body]) -> None:
        two = combined(*balls, "add", 0.5)
        assert two is not None
        third = b.ball(35.0, 25.0, name="c").placed(Placement(offset=(0, 0, 40)))
        three = combined(two, third, "add", 0.5)
        assert three is not None
        b.assert_sound(three)
        assert three.sources == ("a", "b", "c")
        assert set(three.origins) == {0, 1, 2}
        again = combined(three, three.placed(Placement(scale=0.3)), "carve", 0.3)
        assert again is not None
        b.assert_sound(again)


@pytest.mark.parametrize("operation", OPERATIONS)
@pytest.mark.parametrize("gap", [-1e-9, 0.0, 1e-9, 2.0, -2.0])
def test_touching(operation, gap: float) -> None:
    one = b.ball(0.0, 50.0, 32)
    other = one.placed(Placement(offset=(100.0 + gap, 0.0, 0.0)))
    for blend in (0.0, 0.5):
        result = combined(one, replace(other, sources=("b",)), operation, blend)
        if result is not None:
            b.assert_sound(result)


@pytest.mark.slow
def test_coincident_and_nearly_so(outlines: list[Body]) -> None:
    for body in outlines[:1]:
        for offset in (0.0, 1e-12, 1e-2):
            other = body.placed(Placement(offset=(offset, 0.0, offset)))
            for operation in OPERATIONS:
                result = combined(body, other, operation, 0.3)
                if result is not None:
                    b.assert_sound(result)


def random_pairs(outlines: list[Body], count: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    for _ in range(count):
        one, other = (outlines[k] for k in random.integers(0, len(outlines), 2))
        flat = random.random() < 0.3
        turn = np.eye(3) if flat else Rotation.random(rng=random).as_matrix()
        x, y, z = (float(v) for v in random.normal(0.0, 25.0, 3) * [1, 1, not flat])
        placement = Placement(
            tuple(float(v) for v in turn.ravel()), float(np.exp(random.uniform(-1, 0.3))), (x, y, z)
        )
        operation = OPERATIONS[random.integers(4)]
        blend = float(random.choice([0.0, 0.2, 0.5, 1.0, 2.0]))
        result = combined(one, other.placed(placement), operation, blend)
        if result is not None:
            b.assert_sound(result)


def test_random_pairs_of_real_outlines(outlines: list[Body]) -> None:
    random_pairs(outlines, 4, 1)


@pytest.mark.slow
def test_real_outlines_come_out_the_same_in_either_order() -> None:
    for one, other, operation, blend in pairs(78, 12):
        if operation != "carve":
            forth, back = (combined(*two, operation, blend) for two in ((one, other), (other, one)))  # type: ignore[arg-type]
            assert (forth is None) == (back is None)
            if forth is not None:
                assert b.volume(forth) == pytest.approx(b.volume(back), rel=1e-6)


@pytest.mark.slow
def test_big_blends_leave_hardly_a_crease_sharp() -> None:
    found = [
        crease
        for first, second, operation, _ in pairs(77, 25)
        for crease in creases(first, second, operation, 1.0)
        if crease.reach >= 1.5
    ]
    assert len(found) > 20
    assert sum(crease.left > 0.5 for crease in found) <= 0.02 * len(found)


@pytest.mark.slow
def test_many_random_pairs_of_real_outlines(outlines: list[Body]) -> None:
    random_pairs(outlines, 80, 2)
