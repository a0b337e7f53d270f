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
