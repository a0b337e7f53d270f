"""The three things a hand can do on the sheet."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from bozzetto.ink.stroke import Stroke
from bozzetto.view.camera import Camera

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement


@dataclass(frozen=True)
class Ink:
    """One or several strokes, committed together.

    Parameters
    ----------
    strokes : tuple of Stroke
        In the order drawn; at least one. Each carries its own camera.
    committed : bool
        False while the person may still add strokes: a tool that needs more raises
        `Unfinished` then. True once they said that this is all (Enter, the command line).
    """

    strokes: tuple[Stroke, ...]
    committed: bool = False

    @property
    def camera(self) -> Camera:
        """The camera of the first stroke."""
        return self.strokes[0].camera

    @property
    def erases(self) -> bool:
        """Whether the last stroke was made with the eraser end of the pen."""
        return self.strokes[-1].tool == "eraser"

    def moved(self, placement: Placement) -> Ink:
        """Return the same ink in a world that was moved; see `Stroke.moved`."""
        return replace(self, strokes=tuple(stroke.moved(placement) for stroke in self.strokes))


@dataclass(frozen=True)
class Tap:
    """A short touch at a canvas position.

    Parameters
    ----------
    x, y : float
        Pixels.
    camera : Camera
        Through which it was seen.
    shift, ctrl : bool
        Keys held down.
    pressure : float
        The firmest of it, 0 … 1; 0.5 where the device does not tell.
    """

    x: float
    y: float
    camera: Camera
    shift: bool = False
    ctrl: bool = False
    pressure: float = 0.5

    def moved(self, placement: Placement) -> Tap:
        """Return the same touch in a world that was moved; see `Camera.moved`."""
        x = self.camera.viewport[0] - self.x if placement.mirrors else self.x
        return replace(self, x=x, camera=self.camera.moved(placement))


@dataclass(frozen=True)
class Drag:
    """A named handle taken from one place to another.

    Parameters
    ----------
    handle : str
        The `Handle.id` of the scene.
    path : Stroke
        Where the pen went, with its pressure; the last sample is where the handle is now.
    """

    handle: str
    path: Stroke
    shift: bool = False
    ctrl: bool = False

    @property
    def camera(self) -> Camera:
        """The camera through which the handle was dragged."""
        return self.path.camera

    def moved(self, placement: Placement) -> Drag:
        """Return the same drag in a world that was moved; see `Stroke.moved`."""
        return replace(self, path=self.path.moved(placement))


Gesture = Ink | Tap | Drag
