"""View advice: a modeler says how well something can be drawn as the sheet is seen now."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from bozzetto.scene.display_list import Scene
from bozzetto.view.camera import Camera


@dataclass(frozen=True)
class ViewAdvice:
    """Advice on a view: how well one can draw in it, and which one is better.

    Parameters
    ----------
    level : {"good", "warn", "refuse"}
        Whether drawing here goes well, badly, or not at all.
    message : str
        What is wrong with the view, in a few words for the light above the sheet, such as "12° to
        the centre plane"; what to do next is said by `Modeler.next_step`. It stands there while
        the view is not good, or a better one is named; "" where it is good and none is.
    better : Camera, optional
        Where to turn to, in the frame of the model.
    scene : Scene
        What depends on the view, such as vanishing points; a layer stands in for the one of
        the same name in the modeler's own scene.
    pinned : bool
        The view stands where a picture was drawn from. Moving and zooming then turn the
        camera about its eye and change its opening angle, so that the picture and what is
        laid over it stay together; turning the view leaves the place as usual. Other objects of
        the modeler are not shown meanwhile: they would stand before the picture.
    as_drawn : bool
        The view shows the model as it was drawn. Where the model is put elsewhere in space, nothing
        moves on the sheet: a modeler that sees this in `Modeler.advice_on_result` says with
        `better` and `follow` which view shows the same now. The view goes along if nothing else
        is visible, which would move instead. Other than a pinned view it moves freely.
    follow : bool
        What the view showed has another camera now: the view goes to `better` at once, unless a
        hand is turning it.
    """

    level: Literal["good", "warn", "refuse"]
    message: str
    better: Camera | None = None
    scene: Scene = field(default_factory=Scene)
    pinned: bool = False
    as_drawn: bool = False
    follow: bool = False
