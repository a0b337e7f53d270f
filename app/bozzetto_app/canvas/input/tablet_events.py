"""The pen's events: read in a few microseconds, never kept."""

from __future__ import annotations

from time import perf_counter
from typing import Final

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QInputDevice, QMouseEvent, QPointingDevice, QTabletEvent

from bozzetto_app.canvas.input.state_machine import Button, Keys
from bozzetto_app.canvas.input.stroke_samples import RawSample

__all__ = [
    "ProximityWatch",
    "button_of",
    "is_echo",
    "is_eraser",
    "is_held",
    "keys_of",
    "mouse_sample",
    "tablet_sample",
]

_BUTTONS: Final = {
    Qt.MouseButton.LeftButton: Button.TIP,
    Qt.MouseButton.MiddleButton: Button.TURN,
    Qt.MouseButton.RightButton: Button.MENU,
}

_HELD: Final = {button: qt for qt, button in _BUTTONS.items()}

_PENS: Final = (
    QInputDevice.DeviceType.Stylus,
    QInputDevice.DeviceType.Airbrush,
    QInputDevice.DeviceType.Puck,
)


def tablet_sample(event: QTabletEvent) -> RawSample:
    """Copy a tablet event; the event itself dies with its handler."""
    place = event.position()
    return RawSample(
        place.x(),
        place.y(),
        event.pressure(),
        event.timestamp(),
        event.xTilt(),
        event.yTilt(),
        event.rotation(),
        perf_counter(),
    )


def mouse_sample(event: QMouseEvent) -> RawSample:
    """Copy a mouse event; it knows no pressure."""
    place = event.position()
    return RawSample(place.x(), place.y(), 0.5, event.timestamp(), 0.0, 0.0, 0.0, perf_counter())


def button_of(button: Qt.MouseButton) -> Button | None:
    """Return the meaning of a button; None if it has none."""
    return _BUTTONS.get(button)


def is_held(button: Button, event: QTabletEvent | QMouseEvent) -> bool:
    """Whether a button is down during an event."""
    return bool(event.buttons() & _HELD[button])


def keys_of(modifiers: Qt.KeyboardModifier, *, space: bool) -> Keys:
    """Return the keys held down during an event."""
    return Keys(
        alt=bool(modifiers & Qt.KeyboardModifier.AltModifier),
        space=space,
        shift=bool(modifiers & Qt.KeyboardModifier.ShiftModifier),
        ctrl=bool(modifiers & Qt.KeyboardModifier.ControlModifier),
    )


def is_eraser(event: QTabletEvent) -> bool:
    """Whether the pen's other end is meant."""
    return event.pointerType() == QPointingDevice.PointerType.Eraser


def is_echo(event: QMouseEvent) -> bool:
    """Whether a mouse event was made from a pen's or a finger's event."""
    return (
        event.source() != Qt.MouseEventSource.MouseEventNotSynthesized
        or event.deviceType() in _PENS
        or event.deviceType() == QInputDevice.DeviceType.TouchScreen
    )


class ProximityWatch(QObject):
    """Tells when the pen comes near or leaves.

    Qt sends these two events to the application and to no widget, so this object has to be
    installed as an event filter on the application.
    """

    came = Signal()
    left = Signal()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        kind = event.type()
        if kind == QEvent.Type.TabletEnterProximity:
            self.came.emit()
        elif kind == QEvent.Type.TabletLeaveProximity:
            self.left.emit()
        return False
