"""View advice: a modeler says how well something can be drawn as the sheet is seen now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, runtime_checkable

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
        A few words for the light above the sheet, such as "12° to the centre plane".
    better : Camera, optional
        Where to turn to, in the frame of the model.
    scene : Scene
        What depends on the view, such as vanishing points; a layer stands in for the one of
        the same name in the modeler's own scene.
    pinned : bool
        The view stands where a picture was drawn from. Moving and zooming then turn the
        camera about its eye and change its opening angle, so that the picture and what is
        laid over it stay together; turning the view leaves the place as usual.
    follow : bool
        What the view showed has another camera now: the view goes to `better` at once, unless a
        hand is turning it.
    """

    level: Literal["good", "warn", "refuse"]
    message: str
    better: Camera | None = None
    scene: Scene = field(default_factory=Scene)
    pinned: bool = False
    follow: bool = False


@runtime_checkable
class AdvisesView(Protocol):
    """A modeler for which it matters from where one draws."""

    def view_advice(self, state: Any, camera: Camera) -> ViewAdvice:
        """Return advice on a view; asked up to ten times a second while the view turns."""
        ...


@runtime_checkable
class MovesView(Protocol):
    """A modeler of which pictures get another camera when the model changes."""

    def view_after(self, seen: Any, state: Any, camera: Camera) -> Camera | None:
        """Return the view that shows of a state what another view showed of an earlier one.

        Asked while a view is pinned (`ViewAdvice.pinned`) and the model has changed since.

        Parameters
        ----------
        seen : state
            As the model was when the view was pinned to it.
        state : state
            As it is now.
        camera : Camera
            The view now.

        Returns
        -------
        Camera or None
            Where the view goes at once; None where it may stay.
        """
        ...


@runtime_checkable
class AdvisesOnResults(Protocol):
    """A modeler whose advice on a view follows from a solved model, at whatever quality.

    Where a result is known it is asked instead of `AdvisesView` and `MovesView`: while a value is
    dragged only previews are known, and to solve for the advice would take longer than to show.
    """

    def advice_on_result(
        self, state: Any, result: Any, camera: Camera, seen: Sequence[Any]
    ) -> ViewAdvice:
        """Return advice on a view of a solved model.

        Parameters
        ----------
        state : state
            The model.
        result : result
            What `solve` made of it, as a preview or finally.
        camera : Camera
            The view now.
        seen : sequence of result
            Results to which the view was pinned a moment ago, newest first. Where what the view
            showed of one has another camera now, the advice is on the view through that one,
            which is `ViewAdvice.better`, and says `ViewAdvice.follow`.
        """
        ...
