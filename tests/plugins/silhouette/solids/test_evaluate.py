"""The tree: order, groups, what is switched off, what is remembered, what fails."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.plugin.cache import forget_all
from bozzetto_silhouette.model.state import Group, Part, SilhouetteState
from bozzetto_silhouette.solids import evaluate as tree
from bozzetto_silhouette.solids import seams
from bozzetto_silhouette.solids.assembly import Assembly
from bozzetto_silhouette.solids.body import Body
from tests.plugins.silhouette import bodies as b


@pytest.fixture(autouse=True)
def leaves(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Every part is a ball of radius 50 where its pose puts it; which ones were asked for."""
    asked: list[str] = []
    ball = b.ball(resolution=32)

    def body_of(part: Part, resolution: int, checkpoint) -> Body:
        asked.append(part.id)
        if part.name == "bad":
            raise UserError("This ink is no outline.", places=[(1.0, 2.0)])
        return remembered.setdefault(
            (part.id, part.pose), replace(ball.placed(part.pose), sources=(part.id,))
        )

    remembered: dict[object, Body] = {}
    monkeypatch.setattr(tree, "body_of", body_of)
    return asked


def part(name: str, x: float = 0.0, **changes) -> Part:
    pose = Placement(offset=(x, 0.0, 0.0))
    return replace(Part(id=name, name=name, pose=pose, blend=0.0), **changes)


def volume(*nodes: Part | Group) -> float:
    return b.volume(tree.tree_body(SilhouetteState(nodes), 32))


BALL = 4.0 / 3.0 * np.pi * 50.0**3


def test_nothing_is_nothing() -> None:
    assert tree.tree_body(SilhouetteState(), 32) is None
    assert tree.tree_body(SilhouetteState((part("a", visible=False),)), 32) is None
    assert tree.tree_body(SilhouetteState((Group(id="g"),)), 32) is None


def test_what_acts_on_a_hidden_shape_does_not_take_its_place() -> None:
    hidden = part("a", visible=False)
    assert volume(hidden, part("b", operation="carve")) == 0.0
    added = part("c", x=300.0)
    assert volume(hidden, part("b", operation="carve"), added) == pytest.approx(BALL, rel=0.05)


def test_what_carves_everything_leaves_nothing_and_more_can_follow() -> None:
    gone = part("a"), part("b", operation="carve")
    assert volume(*gone) == 0.0
    assert volume(*gone, part("c", operation="intersect")) == 0.0
    assert volume(*gone, part("c")) == pytest.approx(BALL, rel=0.05)


def test_order_counts() -> None:
    a, cut, c = part("a"), part("b", 60.0, operation="carve"), part("c", 60.0)
    assert volume(a, cut, c) > 1.3 * volume(a, c, cut)


def test_switched_off_it_takes_no_part() -> None:
    a, cut = part("a"), part("b", 60.0, operation="carve")
    assert volume(a, replace(cut, visible=False)) == pytest.approx(volume(a))


def test_a_group_acts_as_one() -> None:
    a = part("a")
    inside = part("b", 60.0, within="g"), part("c", 60.0, within="g", operation="carve")
    group = Group(id="g", operation="carve", blend=0.0)
    assert volume(a, group, *inside) == pytest.approx(volume(a))
    assert volume(a, group, inside[0]) < 0.95 * volume(a)
    moved = replace(group, pose=Placement(offset=(500.0, 0.0, 0.0)))
    assert volume(a, moved, inside[0]) == pytest.approx(volume(a))


def test_what_did_not_change_is_not_put_together_again(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[tuple[str, ...]] = []
    real = tree.joined

    def counted(first: Assembly, second: Assembly, *rest) -> Assembly | None:
        made.append(second.sources)
        return real(first, second, *rest)

    monkeypatch.setattr(tree, "joined", counted)
    nodes = [part(f"n{k}", 80.0 * k) for k in range(6)]
    volume(*nodes)
    assert len(made) == 5
    volume(*nodes)
    assert len(made) == 5
    volume(*nodes[:-1], part("n5", 390.0))
    assert made[5:] == [("n5",)]
    volume(*(replace(node, color=(1, 2, 3)) for node in nodes))
    assert len(made) == 6


def test_a_change_makes_only_the_blends_beside_it_even_anew(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[float] = []
    real = seams.each

    def counted(one, several, asked):
        def noted(questions):
            zones = [some for some in questions if hasattr(some, "evenings")]
            made.extend(float(zone.vertices[:, 0].mean()) for zone in zones)
            return several(questions)

        return real(one, noted, asked)

    monkeypatch.setattr(seams, "each", counted)
    nodes = [part(f"n{k}", 80.0 * k, blend=0.4) for k in range(8)]
    whole = volume(*nodes)
    assert len(made) == 7
    made.clear()
    shifted = part("n1", 84.0, blend=0.4)
    changed = volume(nodes[0], shifted, *nodes[2:])
    assert sorted(made)[:2] == pytest.approx([42.0, 122.0], abs=3.0)
    assert len(made) <= 4  # two more may be near enough to feel it
    assert max(made) < 300.0
    assert volume(*nodes) == pytest.approx(whole, rel=1e-12)
    # The same as if nothing had been remembered.
    forget_all()
    assert volume(nodes[0], shifted, *nodes[2:]) == pytest.approx(changed, rel=1e-9)


def test_a_mistake_names_its_part() -> None:
    with pytest.raises(UserError, match=r"^bad: This ink") as caught:
        volume(part("a"), part("bad"))
    assert caught.value.places == ((1.0, 2.0),)
