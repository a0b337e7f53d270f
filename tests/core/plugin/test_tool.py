"""Tools: which method gets a gesture, what a gesture that is not taken says, and previews."""

from __future__ import annotations

import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag, Gesture, Ink, Tap, Tool
from bozzetto.plugin.tool import NOTHING_TO_ERASE
from bozzetto.scene import Layer, Scene
from bozzetto.view import Camera

CAMERA, CONTEXT = Camera(), Context()
PEN = Stroke([1.0, 2.0], [3.0, 4.0], CAMERA)
RUB = Stroke([1.0, 2.0], [3.0, 4.0], CAMERA, tool="eraser")
GESTURES = {
    "draw": Ink((PEN,)),
    "erase": Ink((PEN, RUB)),
    "tap": Tap(1.0, 2.0, CAMERA),
    "drag": Drag("handle", PEN),
}


class Listing(Tool[tuple[object, ...]]):
    """Keeps what it was given, in the state."""

    id, title, hint = "listing", "Listing", "Do something."

    def draw(self, state, ink, context):
        return (*state, "draw", ink)

    def erase(self, state, ink, context):
        return (*state, "erase", ink)

    def tap(self, state, tap, context):
        return (*state, "tap", tap)

    def drag(self, state, drag, context):
        return (*state, "drag", drag)

    def preview(self, state, gesture, context):
        return Scene((Layer("seen"),))


class Idle(Tool[None]):
    id, title, hint = "idle", "Idle", "Do something else."


@pytest.mark.parametrize("kind", GESTURES)
def test_a_gesture_goes_to_the_method_of_its_kind(kind: str) -> None:
    assert Listing().apply((), GESTURES[kind], CONTEXT) == (kind, GESTURES[kind])


@pytest.mark.parametrize("kind", GESTURES)
def test_what_a_tool_does_not_take_is_refused_in_words(kind: str) -> None:
    with pytest.raises(UserError) as refused:
        Idle().apply(None, GESTURES[kind], CONTEXT)
    assert refused.value.message == (NOTHING_TO_ERASE if kind == "erase" else Idle.hint)


@pytest.mark.parametrize("kind", GESTURES)
def test_a_tool_is_asked_to_show_everything_but_erasers(kind: str) -> None:
    layers = Listing().begin((), CONTEXT).update(GESTURES[kind]).layers
    assert [layer.name for layer in layers] == ([] if kind == "erase" else ["seen"])
    assert not Idle().begin(None, CONTEXT).update(GESTURES[kind]).layers


def test_one_preview_gets_a_gesture_as_it_grows() -> None:
    asked: list[Gesture] = []

    class Watching(Listing):
        def preview(self, state, gesture, context):
            asked.append(gesture)
            return Scene()

    preview = Watching().begin(("state",), CONTEXT)
    assert (preview.state, preview.context) == (("state",), CONTEXT)
    for kind in ("draw", "drag"):
        preview.update(GESTURES[kind])
    assert asked == [GESTURES["draw"], GESTURES["drag"]]


class Carried(Tool[tuple[tuple[int, float], ...]]):
    """Notes how much of the path each step has, and its time."""

    id, title, hint, gesture = "carried", "Carried", "Drag it.", "drag"

    def step(self, state, held, seconds, context):
        assert held is not None
        assert held.handle == "handle"
        return (*state, (len(held.path.x), round(seconds, 6)))


def test_a_drag_of_a_file_is_taken_in_the_steps_of_a_hand() -> None:
    times = [0.0, 0.001, 0.02, 0.03, 0.04, 9.0, 9.001]
    path = Stroke(range(7), [0.0] * 7, CAMERA, t=times, pressure=[0.1 * k for k in range(7)])
    steps = Carried().drag((), Drag("handle", path), CONTEXT)
    assert [count for count, _ in steps] == [1, 3, 5, 6, 7], "as quickly as the host, and the end"
    assert max(seconds for _, seconds in steps) == pytest.approx(0.05), "nothing jumps"
    assert min(seconds for _, seconds in steps) > 0.0
    assert steps == Carried().apply((), Drag("handle", path), CONTEXT)
    untimed = Carried().drag((), Drag("handle", Stroke(range(4), [0.0] * 4, CAMERA)), CONTEXT)
    assert untimed == tuple((k, pytest.approx(1 / 60, abs=1e-6)) for k in (1, 2, 3, 4))


def test_a_tool_of_taps_that_plays_takes_no_drag() -> None:
    tool = Carried()
    tool.gesture = "tap"
    with pytest.raises(UserError, match="Drag it"):
        tool.drag((), GESTURES["drag"], CONTEXT)
