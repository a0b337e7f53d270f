"""State machine between presses and strokes, without Qt.

One gesture at a time. A press decides what the gesture is (ink, an eraser, a tap, a tap that
is aimed, the drag of a handle, the menu, or a turn of the view); until its own pointer lifts or
the gesture is cancelled, nothing else can begin, so that a palm, a second button or a
synthesised mouse event never makes a second stroke. Only the pen may interrupt, and only a turn
of the view.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Final, Literal, NamedTuple

__all__ = [
    "FLICK_TRAVEL",
    "TAP_TRAVEL",
    "Button",
    "GestureMachine",
    "Keys",
    "Mode",
    "Motion",
    "Outcome",
    "Pointer",
    "Press",
]

Pointer = Literal["pen", "mouse", "touch"]

TAP_TRAVEL: Final = 4.0
"""Largest movement of a tap, and of a dot that is not yet ink, pixels."""

TAP_TIME: Final = 0.25
"""Longest time of a tap, seconds."""

STILL: Final = 2.0
"""Largest movement, however slow, of a tap on the handle of a tool that aims, pixels: a drag may
be as short as that, for marks are put right by little."""

PALM_TIME: Final = 0.4
"""How long after the pen was last seen touch and mouse stay ignored, seconds."""

NEAR_TIME: Final = 5.0
"""How long a pen that fell silent counts as near, seconds: not every system says that it
left, and fingers must not stay dead for ever."""

FLICK_TRAVEL: Final = 18.0
"""Movement beyond which a press on the menu button is a flick, pixels."""


class Mode(Enum):
    """State of the hand."""

    IDLE = auto()
    INKING = auto()
    ERASING = auto()
    TAPPING = auto()
    AIMING = auto()
    DRAGGING = auto()
    NAVIGATING = auto()
    CHOOSING = auto()

    @property
    def records(self) -> bool:
        """Whether samples are kept in this mode."""
        return self in _RECORDING


_RECORDING: Final = frozenset({Mode.INKING, Mode.ERASING, Mode.DRAGGING})


class Motion(Enum):
    """How the view follows the pointer."""

    ORBIT = auto()
    PAN = auto()
    ZOOM = auto()


class Outcome(Enum):
    """Kind of a gesture, known when its pointer lifts."""

    NOTHING = auto()
    STROKE = auto()
    TAP = auto()
    DROP = auto()
    FLICK = auto()
    MENU = auto()


class Button(Enum):
    """Which part of the pen or mouse was pressed."""

    TIP = auto()
    """The pen's tip or eraser, or the left mouse button."""
    TURN = auto()
    """The middle button."""
    MENU = auto()
    """The barrel button, or the right mouse button."""


class Keys(NamedTuple):
    """Keys held down."""

    alt: bool = False
    space: bool = False
    shift: bool = False
    ctrl: bool = False

    @property
    def motion(self) -> Motion:
        """The motion of the view that these keys ask for."""
        if self.ctrl:
            return Motion.ZOOM
        return Motion.PAN if self.shift else Motion.ORBIT


NO_KEYS: Final = Keys()


class Press(NamedTuple):
    """A pointer that goes down.

    Parameters
    ----------
    pointer : {"pen", "mouse", "touch"}
    button : Button
    x, y : float
        Canvas pixels.
    t : float
        Seconds on the caller's clock.
    eraser : bool
        Whether it is the pen's other end.
    handle : str
        Id of the handle under the pointer, "" for none.
    takes : {"ink", "tap", "drag"}
        What the active tool wants.
    aims : bool
        Whether its taps are where the pointer lifts, however long that takes.
    grabs : bool
        Whether its drags may begin beside all handles.
    """

    pointer: Pointer
    button: Button
    x: float
    y: float
    t: float
    keys: Keys = NO_KEYS
    eraser: bool = False
    handle: str = ""
    takes: Literal["ink", "tap", "drag"] = "ink"
    aims: bool = False
    grabs: bool = False


@dataclass
class GestureMachine:
    """The gesture under way, if any.

    Attributes
    ----------
    mode : Mode
    motion : Motion
        How the view moves while `mode` is NAVIGATING.
    press : Press or None
        What began the gesture.
    travel : float
        Farthest distance from the press so far, pixels.
    place : (x, y)
        Where its pointer was seen last.
    """

    mode: Mode = Mode.IDLE
    motion: Motion = Motion.ORBIT
    press: Press | None = None
    travel: float = 0.0
    place: tuple[float, float] = (0.0, 0.0)
    _pen_near: bool = field(default=False, repr=False)
    _pen_seen: float = field(default=-math.inf, repr=False)

    # -- who may speak ---------------------------------------------------------------------

    def see_pen(self, t: float) -> None:
        """Note that the pen is at the sheet (a hover, a press, an approach)."""
        self._pen_near = True
        self._pen_seen = t

    def lose_pen(self, t: float) -> None:
        """Note that the pen has left."""
        self._pen_near = False
        self._pen_seen = t

    def listens_to_touch(self, t: float) -> bool:
        """Whether a finger is meant: no pen is near, nor was a moment ago."""
        pen_draws = self.press is not None and self.press.pointer == "pen"
        silence = NEAR_TIME if self._pen_near else PALM_TIME
        return not pen_draws and t - self._pen_seen > silence

    def listens_to_mouse(self, t: float) -> bool:
        """Whether a mouse event is the mouse's own, not an echo of the pen."""
        pen_draws = self.press is not None and self.press.pointer == "pen"
        return not pen_draws and t - self._pen_seen > PALM_TIME

    # -- the gesture -----------------------------------------------------------------------

    def begin(self, press: Press) -> bool:
        """Begin a gesture, unless one is under way; say whether it began."""
        interrupts = press.pointer == "pen" and self.mode is Mode.NAVIGATING
        if self.mode is not Mode.IDLE and not (interrupts and self._owner() != "pen"):
            return False
        mode = self._meaning(press)
        if mode is Mode.IDLE:
            return False
        self.mode, self.press, self.travel = mode, press, 0.0
        self.place = press.x, press.y
        if mode is Mode.NAVIGATING:
            self.motion = press.keys.motion
        return True

    def move(self, x: float, y: float) -> None:
        """Follow the pointer that made the gesture."""
        if self.press is not None:
            self.place = x, y
            distance = math.hypot(x - self.press.x, y - self.press.y)
            if distance > self.travel:
                self.travel = distance

    def owns(self, pointer: Pointer, button: Button | None = None) -> bool:
        """Whether the gesture under way is this pointer's (and was begun with this button)."""
        press = self.press
        return (
            press is not None
            and press.pointer == pointer
            and (button is None or press.button is button)
        )

    def release(self, pointer: Pointer, button: Button, t: float) -> Outcome:
        """End the gesture if this pointer and button made it; say what it was."""
        if not self.owns(pointer, button) or self.press is None:
            return Outcome.NOTHING
        mode, travel, lasted = self.mode, self.travel, t - self.press.t
        aims, grabs, handle = self.press.aims, self.press.grabs, self.press.handle
        self.cancel()
        if mode is Mode.INKING:
            return Outcome.STROKE if travel >= TAP_TRAVEL else Outcome.NOTHING
        if mode is Mode.ERASING:
            return Outcome.STROKE
        if mode is Mode.DRAGGING:
            # Places may be closer together than a handle reaches: a tap there is still a tap.
            quick = travel < TAP_TRAVEL and lasted < TAP_TIME
            taps = aims or (grabs and not handle)
            return Outcome.TAP if taps and (quick or travel < STILL) else Outcome.DROP
        if mode is Mode.AIMING:
            return Outcome.TAP
        if mode is Mode.TAPPING and travel < TAP_TRAVEL and lasted < TAP_TIME:
            return Outcome.TAP
        if mode is Mode.CHOOSING:
            return Outcome.FLICK if travel >= FLICK_TRAVEL else Outcome.MENU
        return Outcome.NOTHING

    def cancel(self) -> Mode:
        """Drop the gesture; return what it had been."""
        was = self.mode
        self.mode, self.press, self.travel = Mode.IDLE, None, 0.0
        return was

    def _owner(self) -> Pointer | None:
        return self.press.pointer if self.press is not None else None

    @staticmethod
    def _meaning(press: Press) -> Mode:
        if press.pointer == "touch" or press.button is Button.TURN:
            return Mode.NAVIGATING
        if press.button is Button.MENU:
            return Mode.CHOOSING
        if press.keys.alt or press.keys.space:
            return Mode.NAVIGATING
        if press.eraser:
            return Mode.ERASING
        if press.handle or (press.grabs and press.takes == "drag"):
            return Mode.DRAGGING
        if press.takes == "ink":
            # Neither a mouse nor every pen has another end.
            return Mode.ERASING if press.keys.ctrl else Mode.INKING
        return Mode.AIMING if press.aims else Mode.TAPPING
