"""Merging and carving of variational bodies: laws, and what must never come out."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.errors import Cancelled
from bozzetto.geometry import Placement
from bozzetto_silhouette.inflation.heightfield import Relief
from bozzetto_silhouette.inflation.solidify import solidify
from bozzetto_silhouette.inflation.variational_relief import VariationalHeights
from bozzetto_silhouette.outline.outline import Outline, outline_from_rings
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.surface_constraints import constraints_on
from bozzetto_silhouette.solids.variational_csg import variational_combined
from tests.plugins.silhouette import outlines as o

Points = NDArray[np.float64]

UPRIGHT = (1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0)
"""A quarter turn about x: the outline that lay in z = 0 stands."""


def body_of(outline: Outline, name: str, resolution: int = 32) -> Body:
    solid = solidify(outline, resolution=resolution, height_model=VariationalHeights())
    relief = Relief(solid)
    return Body(
        solid.vertices,
        solid.faces,
        solid.normals,
        np.zeros(len(solid.vertices), np.int32),
        (name,),
        relief,
        float(solid.skeleton.nodes[:, 2].max()),
        solid.step,
        constraints=constraints_on(solid, relief),
    )


@pytest.fixture(scope="module")
def ball() -> Body:
    return body_of(outline_from_rings([o.circle(0, 0, 50, 200)]), "ball")


@pytest.fixture(scope="module")
def bar() -> Body:
    ring = np.array([[-90, -12], [90, -12], [90, 12], [-90, 12.0]])
    return body_of(outline_from_rings([ring]), "bar")


def renamed(body: Body, name: str, **placement: object) -> Body:
    return replace(body.placed(Placement(**placement)), sources=(name,))  # type: ignore[arg-type]


def sound(body: Body | None) -> Body:
    assert body is not None
    whole = body.manifold
    assert whole.status().name == "NoError"
    assert whole.volume() > 0.0
    assert np.isfinite(body.vertices).all()
    assert np.linalg.norm(body.normals, axis=1) == pytest.approx(np.ones(len(body.normals)))
    assert body.origins.min() >= 0
    assert body.origins.max() < len(body.sources)
    return body


def test_two_balls_merge_and_the_blend_fills_the_crease(ball: Body) -> None:
    other = renamed(ball, "other", offset=(60.0, 10.0, 5.0))
    sharp = (ball.manifold + other.manifold).volume()
    total = ball.manifold.volume() + other.manifold.volume()
    volumes = []
    for blend in (0.1, 0.7, 2.0):
        merged = sound(variational_combined(ball, other, "merge", blend))
        assert merged.manifold.genus() == 0
        assert len(merged.manifold.decompose()) == 1
        volumes.append(merged.manifold.volume())
    assert volumes == sorted(volumes)
    assert 0.99 * sharp < volumes[0] < 1.02 * sharp
    assert volumes[-1] < 1.12 * total


def test_merging_is_commutative(ball: Body, bar: Body) -> None:
    through = renamed(bar, "bar", rotation=UPRIGHT, offset=(45.0, 0.0, 0.0))
    one = sound(variational_combined(ball, through, "merge", 0.5))
    two = sound(variational_combined(through, ball, "merge", 0.5))
    assert one.manifold.volume() == pytest.approx(two.manifold.volume(), rel=1e-3)
    assert one.bounds == pytest.approx(two.bounds, abs=0.5)


def test_far_from_the_crease_the_bodies_stay(ball: Body, bar: Body) -> None:
    through = renamed(bar, "bar", offset=(90.0, 0.0, 0.0))
    merged = sound(variational_combined(ball, through, "merge", 0.5))
    for body, far in ((ball, merged.vertices[:, 0] < 0.0), (through, merged.vertices[:, 0] > 90)):
        miss = body.implicit.value(merged.vertices[far])
        assert np.abs(miss).max() < 0.06 * body.radius
    assert set(merged.origins[merged.vertices[:, 0] < 0.0]) == {0}
    assert set(merged.origins[merged.vertices[:, 0] > 90.0]) == {1}
    assert merged.sources == ("ball", "bar")


def test_carving_takes_what_lies_inside_and_leaves_no_shell(ball: Body) -> None:
    tool = renamed(ball, "tool", scale=0.6, offset=(45.0, 0.0, 10.0))
    sharp = (ball.manifold - tool.manifold).volume()
    carved = sound(variational_combined(ball, tool, "carve", 0.1))
    assert carved.manifold.volume() == pytest.approx(sharp, rel=0.03)
    assert len(carved.manifold.decompose()) == 1
    inside = carved.implicit.value(np.array([[45.0, 0.0, 10.0], [-20.0, 0.0, 0.0]]))
    assert inside[0] < 0.0 < inside[1]
    beyond = carved.vertices[carved.vertices[:, 0] > 60.0]
    assert not len(beyond)


def test_a_hole_is_carved_right_through(ball: Body, bar: Body) -> None:
    drill = renamed(bar, "drill", rotation=(0.0, 0, 1, 0, 1, 0, -1, 0, 0))
    carved = sound(variational_combined(ball, drill, "carve", 0.2))
    assert carved.manifold.genus() == 1
    sharp = (ball.manifold - drill.manifold).volume()
    assert carved.manifold.volume() == pytest.approx(sharp, rel=0.03)


def test_what_is_inside_or_apart(ball: Body) -> None:
    small = renamed(ball, "small", scale=0.3)
    away = renamed(ball, "away", offset=(500.0, 0.0, 0.0))
    assert variational_combined(ball, small, "merge", 0.5) is ball
    assert variational_combined(small, ball, "merge", 0.5) is ball
    assert variational_combined(small, ball, "carve", 0.5) is None
    assert variational_combined(ball, ball, "carve", 0.5) is None
    assert variational_combined(ball, away, "carve", 0.5) is ball
    both = sound(variational_combined(ball, away, "merge", 0.5))
    assert len(both.manifold.decompose()) == 2
    assert both.manifold.volume() == pytest.approx(2 * ball.manifold.volume(), rel=0.02)


def test_a_cavity_is_carved(ball: Body) -> None:
    small = renamed(ball, "small", scale=0.5)
    hollow = sound(variational_combined(ball, small, "carve", 0.5))
    wanted = (1 - 0.5**3) * ball.manifold.volume()
    assert hollow.manifold.volume() == pytest.approx(wanted, rel=0.02)


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_moving_both_moves_the_result(ball: Body, bar: Body, mirror: float) -> None:
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    turn *= mirror * np.sign(np.linalg.det(turn))
    placement = Placement(tuple(turn.ravel().tolist()), 0.01, (3.0, -2.0, 8.0))
    through = renamed(bar, "bar", offset=(60.0, 0.0, 0.0))
    plain = sound(variational_combined(ball, through, "merge", 0.5))
    moved = sound(
        variational_combined(ball.placed(placement), through.placed(placement), "merge", 0.5)
    )
    assert moved.manifold.volume() / 1e-6 == pytest.approx(plain.manifold.volume(), rel=2e-3)
    asked = np.random.default_rng(4).uniform(-60, 60, (200, 3))
    assert moved.implicit.value(placement.points(asked)) / 0.01 == pytest.approx(
        plain.implicit.value(asked), abs=0.5
    )


@pytest.mark.slow
def test_several_in_turn(ball: Body) -> None:
    chain = ball
    for k in range(1, 3):
        following = renamed(ball, f"ball {k}", offset=(70.0 * k, 0.0, 0.0))
        chain = sound(variational_combined(chain, following, "merge", 0.5))
    assert len(chain.manifold.decompose()) == 1
    assert chain.manifold.genus() == 0
    assert len(chain.sources) == 3
    for k in range(3):
        tip = chain.vertices[np.abs(chain.vertices[:, 0] - 70.0 * k) < 10.0]
        assert np.hypot(tip[:, 1], tip[:, 2]).max() == pytest.approx(50.0, rel=0.06)


@pytest.mark.slow
@pytest.mark.parametrize("operation", ["merge", "carve"])
def test_limbs_in_any_pose(operation: Literal["merge", "carve"]) -> None:
    rng = np.random.default_rng(11)
    hand = body_of(o.outline("hand-paper"), "hand")
    key = body_of(o.outline("key"), "key")
    for _ in range(2):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        middle = key.bounds.mean(axis=0)
        target = hand.bounds.mean(axis=0) + rng.uniform(-25, 25, 3)
        scale = rng.uniform(0.4, 1.2)
        offset = target - scale * turn @ middle
        posed = key.placed(Placement(tuple(turn.ravel()), scale, tuple(offset)))
        made = sound(variational_combined(hand, posed, operation, rng.uniform(0, 2)))
        most = hand.manifold.volume() + posed.manifold.volume()
        assert made.manifold.volume() < (1.1 * most if operation == "merge" else most)


def test_work_can_be_stopped(ball: Body) -> None:
    def stop(fraction: float, step: str) -> None:
        raise Cancelled

    with pytest.raises(Cancelled):
        variational_combined(ball, renamed(ball, "b", offset=(50.0, 0, 0)), "merge", 0.5, stop)


def test_bodies_without_constraints_are_a_mistake_of_the_caller(ball: Body) -> None:
    with pytest.raises(TypeError):
        variational_combined(ball, replace(ball, constraints=None), "merge", 0.5)
