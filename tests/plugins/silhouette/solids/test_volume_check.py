"""Results of set operations that cannot be: found, made in another way, and told."""

from __future__ import annotations

from dataclasses import replace

import manifold3d
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto_silhouette.analysis.report import RESAMPLED, cautions_of
from bozzetto_silhouette.inflation.manifold_check import as_manifold, topology_of
from bozzetto_silhouette.model.state import Operation, SilhouetteState
from bozzetto_silhouette.outline.outline import outline_from_rings
from bozzetto_silhouette.solids import assembly, boolean
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.boolean import combined
from bozzetto_silhouette.solids.field_body import field_body
from bozzetto_silhouette.solids.volume_check import is_allowed, is_lost, is_union, volumes_allowed
from tests.plugins.silhouette import bodies as b
from tests.plugins.silhouette import outlines as o

OPERATIONS: tuple[Operation, ...] = ("add", "merge", "carve", "intersect")
CELLS = 20
NOTHING = manifold3d.Manifold()


@pytest.fixture(scope="module")
def shapes() -> list[Body]:
    """A ball, a thin rod, a ring and a star: about 100 mm large, about the origin."""
    turns = np.linspace(0.0, 2.0 * np.pi, 14, endpoint=False)
    rays = np.column_stack([np.cos(turns), np.sin(turns)])
    star = np.where(np.arange(14) % 2, 15.0, 60.0)[:, None] * rays
    return [
        b.ball(resolution=CELLS, name="ball"),
        b.capsule(50.0, 3.0, 2 * CELLS, "rod"),
        b.body(outline_from_rings([o.circle(0, 0, 50), o.circle(0, 0, 20)]), CELLS, "ring"),
        b.body(outline_from_rings([star]), CELLS, "star"),
    ]


def own_volume(body: Body) -> float:
    """The volume by the divergence theorem, without manifold3d."""
    return topology_of(body.vertices, body.faces).volume


def assert_possible(one: Body, other: Body, operation: Operation, whole: Body | None) -> None:
    """Whether a sharp result is closed, and of a volume that it can have."""
    volume = 0.0
    if whole is not None:
        assert topology_of(whole.vertices, whole.faces).watertight
        volume = own_volume(whole)
    least, most = volumes_allowed(operation, own_volume(one), own_volume(other))
    slack = 1e-4 * max(own_volume(one), own_volume(other))
    assert least - slack <= volume <= most + slack


hostile = st.one_of(st.just(0.0), st.sampled_from([1e-12, 1e-7, 1e-3, 30.0]), st.floats(-80, 80))
turns = st.one_of(
    st.sampled_from([0.0, 90.0, 180.0, 1e-6]), st.floats(0.0, 360.0, allow_subnormal=False)
)


class TestHostile:
    @settings(max_examples=40, deadline=None)
    @given(
        which=st.tuples(st.integers(0, 3), st.integers(0, 3)),
        operation=st.sampled_from(OPERATIONS),
        offset=st.tuples(hostile, hostile, hostile),
        turn=st.tuples(turns, turns, turns),
        scale=st.sampled_from([1.0, 1.0, 0.3, 1e-4, 1.0 + 1e-9]),
        mirrored=st.booleans(),
        blend=st.sampled_from([0.0, 0.0, 0.3, 1.0]),
    )
    def test_all_results_are_closed_and_of_a_volume_that_can_be(
        self, shapes, which, operation, offset, turn, scale, mirrored, blend
    ) -> None:
        one, other = (shapes[k] for k in which)
        rows = Rotation.from_euler("xyz", turn, degrees=True).as_matrix()
        rows = rows @ np.diag([-1.0, 1.0, 1.0]) if mirrored else rows
        other = other.placed(Placement(tuple(float(v) for v in rows.ravel()), scale, offset))
        whole = combined(one, replace(other, sources=("second",)), operation, blend)
        if blend == 0.0:
            assert_possible(one, other, operation, whole)
        if whole is not None:
            b.assert_sound(whole)

    @pytest.mark.parametrize("angle", [20.0, 45.0, 90.0, 180.0])
    @pytest.mark.parametrize("blend", [0.1, 0.3, 0.6])
    def test_a_ring_carved_by_itself_leaves_nothing_or_something_sound(
        self, shapes: list[Body], angle: float, blend: float
    ) -> None:
        """What its turned copy leaves of a ring is slivers, which fillets would turn inside out."""
        rows = Rotation.from_euler("z", angle, degrees=True).as_matrix()
        copy = shapes[2].placed(Placement(tuple(float(v) for v in rows.ravel())))
        whole = combined(shapes[2], replace(copy, sources=("second",)), "carve", blend)
        if whole is not None:
            b.assert_sound(whole)

    def test_the_same_outline_over_and_over(self, shapes: list[Body]) -> None:
        ring = shapes[2]
        whole: Body | None = ring
        for k in range(4):
            copy = ring.placed(Placement(offset=(1e-9 * k, 0.0, 0.0)))
            assert whole is not None
            whole = combined(whole, replace(copy, sources=(f"c{k}",)), "add", 0.0)
        assert whole is not None
        b.assert_sound(whole)
        assert own_volume(whole) == pytest.approx(own_volume(ring), rel=1e-6)


class TestWhatCanBe:
    def test_of_volumes(self) -> None:
        assert volumes_allowed("add", 3.0, 5.0) == (5.0, 8.0)
        assert volumes_allowed("merge", 3.0, 5.0) == (5.0, 8.0)
        assert volumes_allowed("carve", 3.0, 5.0) == (0.0, 3.0)
        assert volumes_allowed("carve", 5.0, 3.0) == (2.0, 5.0)
        assert volumes_allowed("intersect", 3.0, 5.0) == (0.0, 3.0)

    def test_true_results_are_allowed_and_others_not(self) -> None:
        ball = manifold3d.Manifold.sphere(1.0, 32)
        small = manifold3d.Manifold.sphere(0.5, 32).translate((0.9, 0.0, 0.0))
        results = {"add": ball + small, "carve": ball - small, "intersect": ball ^ small}
        for operation, result in results.items():
            assert is_allowed(result, operation, ball, small)  # type: ignore[arg-type]
        assert is_union(results["add"], [ball, small])
        assert not is_union(results["carve"], [ball, small])
        assert not is_union(NOTHING, [ball, small])
        assert not is_allowed(results["add"], "carve", ball, small)
        assert not is_allowed(NOTHING, "carve", ball, small)
        assert not is_allowed(ball, "intersect", ball, small)

    def test_what_is_inside_out_or_open_is_not(self) -> None:
        ball = b.ball(resolution=CELLS)
        inverted = as_manifold(ball.vertices, ball.faces[:, ::-1])
        torn = as_manifold(ball.vertices, ball.faces[1:])
        broken = as_manifold(np.where(ball.vertices > 40.0, np.nan, ball.vertices), ball.faces)
        for bad in (inverted, torn, broken):
            assert not is_allowed(bad, "add", ball.manifold, ball.manifold)
            assert not is_union(ball.manifold, [ball.manifold, bad])

    def test_something_deep_is_lost_and_a_skin_is_not(self) -> None:
        ball = b.ball(resolution=CELLS)
        assert is_lost(ball.implicit, ball.bounds, ball.step)
        assert not is_lost(ball.implicit, ball.bounds, 30.0)
        assert not is_lost(ball.implicit, ball.bounds + 200.0, ball.step)


def failing(monkeypatch: pytest.MonkeyPatch, result: manifold3d.Manifold) -> None:
    """Let manifold3d fail in the way that its results are what is given."""
    answer = staticmethod(lambda parts, operation: result)
    monkeypatch.setattr(manifold3d.Manifold, "batch_boolean", answer)


class TestFallback:
    """Faults are put in: no shape is known on which manifold3d fails."""

    @pytest.mark.parametrize("fault", ["empty", "inside out", "open", "half", "far too large"])
    @pytest.mark.parametrize("blend", [0.0, 0.4])
    def test_a_union_that_cannot_be_is_made_from_the_field(
        self, monkeypatch: pytest.MonkeyPatch, fault: str, blend: float
    ) -> None:
        one, other = b.ball(resolution=CELLS), b.ball(70.0, resolution=CELLS, name="b")
        whole = combined(one, other, "add", blend)
        assert whole is not None
        assert not whole.resampled
        bad = {
            "empty": NOTHING,
            "inside out": as_manifold(whole.vertices, whole.faces[:, ::-1]),
            "open": as_manifold(whole.vertices, whole.faces[1:]),
            "half": manifold3d.Manifold.cube((30.0, 30.0, 30.0)),
            "far too large": manifold3d.Manifold.cube((300.0, 300.0, 300.0)),
        }[fault]
        failing(monkeypatch, bad)
        monkeypatch.setattr(boolean, "contacts", lambda *_: None)  # strips need no union
        again = combined(one, other, "add", blend)
        assert again is not None
        monkeypatch.undo()
        assert again.resampled
        b.assert_sound(again)
        assert own_volume(again) == pytest.approx(own_volume(whole), rel=0.02)
        assert again.sources == ("a", "b")
        left = again.vertices[:, 0] < 20.0
        assert set(again.origins[left]) == {0}
        assert set(again.origins[again.vertices[:, 0] > 50.0]) == {1}

    @pytest.mark.parametrize("operation", ["carve", "intersect"])
    @pytest.mark.parametrize("blend", [0.0, 0.4])
    def test_so_is_what_is_taken_away(
        self, monkeypatch: pytest.MonkeyPatch, operation: Operation, blend: float
    ) -> None:
        one, other = b.ball(resolution=CELLS), b.ball(70.0, resolution=CELLS, name="b")
        whole = combined(one, other, operation, blend)
        monkeypatch.setattr(assembly, "is_allowed", lambda *_: False)
        again = combined(one, other, operation, blend)
        assert whole is not None
        assert again is not None
        assert (whole.resampled, again.resampled) == (False, True)
        b.assert_sound(again)
        assert own_volume(again) == pytest.approx(own_volume(whole), rel=0.05)

    def test_what_vanished_without_cause_is_made_again(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        one, other = b.ball(resolution=CELLS), b.ball(70.0, resolution=CELLS, name="b")
        lens = combined(one, other, "intersect", 0.0)
        monkeypatch.setattr(manifold3d.Manifold, "__xor__", lambda *_: NOTHING)
        again = combined(one, other, "intersect", 0.0)
        assert lens is not None
        assert again is not None
        assert again.resampled
        assert own_volume(again) == pytest.approx(own_volume(lens), rel=0.05)
        assert combined(one, one, "carve", 0.0) is None

    def test_it_is_told_and_stays_known(self, monkeypatch: pytest.MonkeyPatch) -> None:
        one, other = b.ball(resolution=CELLS), b.ball(70.0, resolution=CELLS, name="b")
        failing(monkeypatch, NOTHING)
        again = combined(one, other, "add", 0.0)
        monkeypatch.undo()
        assert again is not None
        third = b.ball(-70.0, resolution=CELLS, name="c")
        more = combined(again.placed(Placement(offset=(0.0, 0.0, 9.0))), third, "add", 0.0)
        assert more is not None
        assert [caution.message for caution in cautions_of(SilhouetteState(), more)] == [RESAMPLED]
        assert cautions_of(SilhouetteState(), one) == ()

    def test_where_nothing_is_left_of_a_union_it_is_said(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        one, other = b.ball(resolution=CELLS), b.ball(70.0, resolution=CELLS, name="b")
        failing(monkeypatch, NOTHING)
        monkeypatch.setattr(boolean, "remade", lambda *_: None)
        with pytest.raises(UserError, match="Move one of them"):
            combined(one, other, "add", 0.0)


def test_a_body_from_a_field_is_the_body() -> None:
    ball = b.ball(resolution=32)
    again = field_body(ball.implicit, [ball], ball.radius, ball.step)
    assert again is not None
    b.assert_sound(again)
    assert own_volume(again) == pytest.approx(own_volume(ball), rel=0.01)
    assert len(again.creases) == 0
    away = np.linalg.norm(again.vertices, axis=1)
    assert away == pytest.approx(50.0, rel=0.02)
