"""The hand on the sheet: from events of pen, mouse and fingers to calls of the session.

One machine (`state_machine`) decides what is meant. While ink flows the handlers only copy the
event; everything else happens once per round of the event loop in `_drain`.
"""

from __future__ import annotations

import math
from time import perf_counter
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, QTimer, Signal
from PySide6.QtGui import (
    QEventPoint,
    QGuiApplication,
    QMouseEvent,
    QTabletEvent,
    QTouchEvent,
    QWheelEvent,
)

from bozzetto.plugin.gesture import Drag, Tap
from bozzetto_app.canvas.input.hovering import Hovering
from bozzetto_app.canvas.input.report_pace import ReportPace
from bozzetto_app.canvas.input.state_machine import (
    TAP_TRAVEL,
    Button,
    GestureMachine,
    Mode,
    Outcome,
    Pointer,
    Press,
)
from bozzetto_app.canvas.input.stroke_samples import Clock, PressureCurve, RawSample, SampleColumns
from bozzetto_app.canvas.input.tablet_events import (
    button_of,
    is_echo,
    is_eraser,
    is_held,
    keys_of,
    mouse_sample,
    tablet_sample,
)
from bozzetto_app.canvas.input.view_control import ViewControl
from bozzetto_app.session.underlay_placing import is_of_underlay

if TYPE_CHECKING:
    from bozzetto.ink.stroke import Stroke, StrokeTool
    from bozzetto.view.camera import Camera
    from bozzetto_app.canvas.overlay.wet_ink import InkOverlay
    from bozzetto_app.session.gestures import Gestures
    from bozzetto_app.session.session import Session
    from bozzetto_app.session.underlay_placing import UnderlayPlacing

__all__ = ["Hand"]

NO_PRESSURE: Final = 0.5
"""Pressure of a tap where the device tells of none, 0 … 1."""

_MOVE: Final = QEvent.Type.TabletMove
_TIP_ALONE: Final = Qt.MouseButton.LeftButton


_MEANT: Final = {Mode.NAVIGATING: "turn", Mode.TAPPING: "tap"}
"""What a press was taken for; in the other modes a stroke."""


class Hand(QObject):
    """Turns input into gestures, and gestures into what the session does.

    Parameters
    ----------
    session : Session
    overlay : InkOverlay
        Where wet ink, the ring and the hot handle are shown.

    Attributes
    ----------
    hovering : Hovering
        What lies under a pen that is not down.

    Signals
    -------
    pressed
        Something goes down: the view must be at rest when this returns.
    menu_pressed, menu_moved : QPointF; menu_released : bool
        The menu button; whether its release was a flick.
    aimed : QPointF; aim_ended
        A place is being sought that must be met exactly; no longer.
    ink_began, mode_changed
    touched : Tap, bool
        The tool draws, and the pen has gone nowhere; whether it is the second of a double click.
    came_to_nothing : str
        A press was let go, and it was none of the gestures that mean something: "turn", "tap"
        or "stroke" says what it was taken for.
    """

    pressed = Signal()
    menu_pressed = Signal(QPointF)
    menu_moved = Signal(QPointF)
    menu_released = Signal(bool)
    aimed = Signal(QPointF)
    aim_ended = Signal()
    ink_began = Signal()
    mode_changed = Signal()
    touched = Signal(object, bool)
    came_to_nothing = Signal(str)

    def __init__(self, session: Session, overlay: InkOverlay) -> None:
        super().__init__(overlay)
        self.machine = GestureMachine()
        self.curve = PressureCurve()
        self.space_held = False
        self._session = session
        self._overlay = overlay
        self._columns: SampleColumns | None = None
        self._camera: Camera = session.view.camera
        self._view = ViewControl(session)
        self._recording = False
        self._seeking = False
        self._fresh: list[RawSample] = []
        self._newest: RawSample | None = None
        self._lasting = Clock()
        self._tapped: Press | None = None
        self._again = False
        self._keys = keys_of(Qt.KeyboardModifier.NoModifier, space=False)
        self._tool: StrokeTool = "pen"
        self._due = False
        self._firmest = NO_PRESSURE
        self._soon = QTimer(self, singleShot=True, interval=0)
        self._soon.timeout.connect(self._drain)
        self._pace = ReportPace(self)
        self._pace.due.connect(self._report)
        self.hovering = Hovering(session, overlay, self._pace)

    # -- pen ----------------------------------------------------------------------------------

    def tablet(self, event: QTabletEvent) -> None:
        """Take a tablet event; it is always accepted, or Qt would send a mouse event too."""
        event.accept()
        kind = event.type()
        if kind == _MOVE:
            if event.buttons() != _TIP_ALONE:  # rare, and more expensive to look at
                self._end_unseen("pen", event)
            if self._recording and self.machine.owns("pen"):
                self._keep(tablet_sample(event))
                return
            self._firmest = max(self._firmest, self.curve(event.pressure()))
        self.machine.see_pen(perf_counter())
        button = button_of(event.button())
        if kind == QEvent.Type.TabletPress and button is not None:
            self._press("pen", button, tablet_sample(event), event, eraser=is_eraser(event))
        elif kind == QEvent.Type.TabletRelease and button is not None:
            self._release("pen", button, tablet_sample(event), event)
        elif kind == _MOVE:
            self._move("pen", event.position(), event, eraser=is_eraser(event))

    def pen_came(self) -> None:
        """Note that the pen is near: from now on a touch is a palm."""
        self.machine.see_pen(perf_counter())
        if self.machine.owns("touch"):
            self.cancel()

    def pen_left(self) -> None:
        """Note that the pen has gone; a stroke that was not lifted ends here."""
        self.machine.lose_pen(perf_counter())
        self._overlay.set_hover(None)
        if self.machine.owns("pen"):
            self.end()

    # -- mouse --------------------------------------------------------------------------------

    def mouse_pressed(self, event: QMouseEvent) -> None:
        """Take a press of the mouse's own, not an echo of the pen."""
        event.accept()
        button = button_of(event.button())
        if button is not None and self._is_mouse(event):
            self._press("mouse", button, mouse_sample(event), event)

    def mouse_moved(self, event: QMouseEvent) -> None:
        """Take a movement of the mouse."""
        event.accept()
        if not self._is_mouse(event):
            return
        self._end_unseen("mouse", event)
        if self._recording and self.machine.owns("mouse"):
            self._keys = keys_of(event.modifiers(), space=self.space_held)
            self._keep(mouse_sample(event))
            return
        self._move("mouse", event.position(), event)

    def mouse_released(self, event: QMouseEvent) -> None:
        """Take a release of the mouse."""
        event.accept()
        button = button_of(event.button())
        if button is not None and not is_echo(event):
            self._release("mouse", button, mouse_sample(event), event)

    def _is_mouse(self, event: QMouseEvent) -> bool:
        if is_echo(event):
            return False
        return self.machine.owns("mouse") or self.machine.listens_to_mouse(perf_counter())

    def wheel(self, event: QWheelEvent) -> None:
        """Zoom to the place under the cursor."""
        event.accept()
        turned = event.angleDelta().y() or event.angleDelta().x()
        if self.machine.mode is not Mode.IDLE or not turned:
            return
        self.pressed.emit()
        self._view.wheel(event.position().x(), event.position().y(), turned)

    # -- fingers ------------------------------------------------------------------------------

    def touch(self, event: QTouchEvent) -> None:
        """Turn, move and zoom the view, unless the touch is a palm's."""
        event.accept()
        now = perf_counter()
        places = [p.position() for p in event.points() if p.state() != QEventPoint.State.Released]
        if not self.machine.owns("touch"):
            began = event.type() == QEvent.Type.TouchBegin and places
            if not began or not self.machine.listens_to_touch(now):
                return
            self.pressed.emit()
            first = places[0]
            if not self.machine.begin(Press("touch", Button.TIP, first.x(), first.y(), now)):
                return
            self._camera = self._session.view.camera
            self._view.touch_began()
        if not places or event.type() == QEvent.Type.TouchCancel:
            self.machine.release("touch", Button.TIP, now)
            return
        self._view.touch(places)

    # -- gestures -----------------------------------------------------------------------------

    def cancel(self) -> bool:
        """Drop the gesture under way (Esc); say whether there was one."""
        mode = self.machine.cancel()
        if mode is Mode.NAVIGATING:
            self._session.view.set_camera(self._camera)
        if mode.records or mode is Mode.AIMING:
            self._forget()
            self._session.pictures.placing.cancel()
            self._session.gestures.cancel()
        self.mode_changed.emit()
        return mode is not Mode.IDLE

    def end(self) -> None:
        """End the gesture under way as if its pointer had been lifted where it was seen last.

        For when nobody will tell of the lift: the window was put away, the pen has left. What
        was drawn is kept.
        """
        press = self.machine.press
        if press is None:
            return
        if press.pointer == "touch":
            self.machine.release("touch", press.button, perf_counter())
            self.mode_changed.emit()
        else:
            self._conclude(press.pointer, press.button, perf_counter() - press.t)

    def _end_unseen(self, pointer: Pointer, event: QTabletEvent | QMouseEvent) -> None:
        """End a gesture whose button was let go while somebody else had the pointer.

        Another program, or a window over this one, may have taken it; without this the stroke
        would go on with no button down, and the next press would be taken for a second one.
        """
        press = self.machine.press
        if press is not None and press.pointer == pointer and not is_held(press.button, event):
            self.end()

    def _press(
        self,
        pointer: Pointer,
        button: Button,
        sample: RawSample,
        event: QTabletEvent | QMouseEvent,
        *,
        eraser: bool = False,
    ) -> None:
        if self.machine.owns(pointer, button):
            self.end()  # a button that goes down was up
        self.pressed.emit()
        self._again = self._is_again(pointer, sample)
        takes, aims = self.hovering.takes, self.hovering.aims
        found = self.hovering.handle_under(sample.x, sample.y)
        press = Press(
            pointer,
            button,
            sample.x,
            sample.y,
            sample.received,
            keys_of(event.modifiers(), space=self.space_held),
            eraser,
            found[0].id if found is not None else "",
            takes,
            aims,
            self.hovering.tool_is(lambda tool: tool.grabs),
        )
        if not self.machine.begin(press):
            return
        self._keys = press.keys
        self._firmest = self.curve(sample.pressure) if pointer == "pen" else NO_PRESSURE
        self._lasting = Clock()
        self._lasting(sample.stamp, sample.received)
        self._camera = self._session.view.camera
        mode = self.machine.mode
        if mode.records:
            plain: StrokeTool = "mouse" if pointer == "mouse" else "pen"
            self._tool = "eraser" if mode is Mode.ERASING else plain
            self._columns = SampleColumns(self.curve, has_pressure=pointer == "pen")
            self._recording = True
            self._seeking = aims and mode is Mode.DRAGGING
            self._pace.forget()
            if mode is not Mode.DRAGGING:
                self._overlay.begin(erasing=mode is Mode.ERASING)
                self.ink_began.emit()
            self._keep(sample)
            self._drain()
        elif mode is Mode.NAVIGATING:
            self._view.begin(sample.x, sample.y)
        elif mode is Mode.AIMING:
            self._seeking = True
            self._pace.forget()
            self._seek()
        elif mode is Mode.CHOOSING:
            self.menu_pressed.emit(QPointF(sample.x, sample.y))
        if mode is not Mode.DRAGGING:
            self._overlay.set_hover(None)
        self.mode_changed.emit()

    def _move(
        self,
        pointer: Pointer,
        place: QPointF,
        event: QTabletEvent | QMouseEvent,
        *,
        eraser: bool = False,
    ) -> None:
        mode = self.machine.mode
        if mode is Mode.IDLE:
            erases = self.hovering.takes == "ink" and keys_of(event.modifiers(), space=False).ctrl
            self.hovering.move(place.x(), place.y(), eraser=eraser or erases)
            return
        if not self.machine.owns(pointer):
            return
        self.machine.move(place.x(), place.y())
        if mode is Mode.NAVIGATING:
            self._turn(place.x(), place.y())
        elif mode is Mode.AIMING:
            self._seek()
        elif mode is Mode.CHOOSING:
            self.menu_moved.emit(place)

    def _release(
        self,
        pointer: Pointer,
        button: Button,
        sample: RawSample,
        event: QTabletEvent | QMouseEvent,
    ) -> None:
        if not self.machine.owns(pointer, button):
            return
        if self._recording:
            self._keys = keys_of(event.modifiers(), space=self.space_held)
            last = self._newest
            if last is None or (last.x, last.y) != (sample.x, sample.y):
                self._keep(self._as_lifted(sample))
        else:
            self.machine.move(sample.x, sample.y)
            if self.machine.mode is Mode.NAVIGATING:
                self._turn(sample.x, sample.y)
        self._conclude(pointer, button, self._lasting(sample.stamp, sample.received))

    def _is_again(self, pointer: Pointer, sample: RawSample) -> bool:
        """Whether a press is the second one of a double click, by the time of the device."""
        first = self._tapped
        if first is None or first.pointer != pointer:
            return False
        hints, is_pen = QGuiApplication.styleHints(), pointer == "pen"
        reach = hints.touchDoubleTapDistance() if is_pen else hints.mouseDoubleClickDistance()
        passed = self._lasting(sample.stamp, sample.received)  # since the first one went down
        near = math.hypot(sample.x - first.x, sample.y - first.y) <= reach
        return near and passed * 1000.0 < hints.mouseDoubleClickInterval()

    def _conclude(self, pointer: Pointer, button: Button, lasted: float) -> None:
        """End the gesture, which took so many seconds of the hand's time."""
        if self._recording:
            self._drain()
        press, columns, place = self.machine.press, self._columns, self.machine.place
        mode, travel = self.machine.mode, self.machine.travel
        outcome = self.machine.release(pointer, button, press.t + lasted if press else 0.0)
        stroke = self._stroke(columns) if columns is not None and self._recording else None
        was_recording = self._recording
        self._forget(keep_wet=outcome is Outcome.STROKE)
        short = outcome is Outcome.TAP or (outcome is Outcome.NOTHING and mode is Mode.INKING)
        self._tapped = press if short and not self._again else None
        if outcome is Outcome.STROKE and stroke is not None:
            self._session.gestures.stroke_lifted(stroke)
            self._overlay.clear_wet()
        elif outcome is Outcome.DROP and stroke is not None and press is not None:
            self._grip(press.handle).handle_released(self._drag(press.handle, stroke))
        elif outcome is Outcome.TAP and press is not None:
            x, y = place if press.aims else (press.x, press.y)
            tap, placing = self._tap(x, y, press), self._session.pictures.placing
            if placing.is_aligning:
                placing.touch(tap)
            else:
                self._session.gestures.tap(tap, again=self._again)
        elif outcome in (Outcome.FLICK, Outcome.MENU):
            self.menu_released.emit(outcome is Outcome.FLICK)
        elif was_recording:
            self._session.pictures.placing.cancel()
            self._session.gestures.cancel()
        if outcome is Outcome.NOTHING and mode is Mode.INKING and press is not None:
            self.touched.emit(self._tap(press.x, press.y, press), self._again)
        elif outcome is Outcome.NOTHING and (mode is not Mode.NAVIGATING or travel < TAP_TRAVEL):
            self.came_to_nothing.emit(_MEANT.get(mode, "stroke"))
        self.mode_changed.emit()

    def _forget(self, *, keep_wet: bool = False) -> None:
        self._recording = False
        self._fresh.clear()
        self._newest = None
        self._columns = None
        self._soon.stop()
        self._pace.stop()
        self._due = False
        if self._seeking:
            self._seeking = False
            self.aim_ended.emit()
        if not keep_wet:
            self._overlay.clear_wet()

    # -- ink ----------------------------------------------------------------------------------

    def _keep(self, sample: RawSample) -> None:
        """Take a sample; what is done with it is done once a round of the event loop."""
        self._fresh.append(sample)
        self._newest = sample
        if not self._due:
            self._due = True
            self._soon.start()

    def _drain(self) -> None:
        """Paint and keep the samples that came since the last round."""
        self._due = False
        columns = self._columns
        if columns is None or not self._fresh:
            return
        fresh, self._fresh = self._fresh, []
        painted = []
        for raw in fresh:
            pressure = columns.append(raw)
            self.machine.move(raw.x, raw.y)
            painted.append((raw.x, raw.y, pressure))
        if self.machine.mode is not Mode.DRAGGING:
            self._overlay.extend(painted)
        elif self._seeking:
            self.aimed.emit(QPointF(*self.machine.place))
        self._pace.ask()

    def _seek(self) -> None:
        """Follow a tap that is aimed."""
        self.aimed.emit(QPointF(*self.machine.place))
        self._pace.ask()

    def _report(self) -> None:
        """Tell the session how the gesture stands, at most 30 times a second."""
        press, columns = self.machine.press, self._columns
        if press is None:
            return
        self._pace.begin()
        if self.machine.mode is Mode.AIMING:
            if not self._session.pictures.placing.is_aligning:
                self._session.gestures.tap_moved(self._tap(*self.machine.place, press))
            return
        if columns is None or not len(columns):
            return
        stroke = self._stroke(columns)
        if self.machine.mode is Mode.DRAGGING:
            # What begins beside all handles may yet be a tap.
            if press.handle or self.machine.travel >= TAP_TRAVEL:
                self._grip(press.handle).handle_moved(self._drag(press.handle, stroke))
        else:
            self._session.gestures.stroke_moved(stroke)

    def _stroke(self, columns: SampleColumns) -> Stroke:
        return columns.stroke(self._camera, self._tool)

    def _tap(self, x: float, y: float, press: Press) -> Tap:
        camera, keys = self._session.view.camera, press.keys
        return Tap(x, y, camera, keys.shift, keys.ctrl, self._firmest)

    def _drag(self, handle: str, path: Stroke) -> Drag:
        return Drag(handle, path, self._keys.shift, self._keys.ctrl)

    def _grip(self, handle: str) -> Gestures | UnderlayPlacing:
        """Return who takes the drags of a handle."""
        session = self._session
        return session.pictures.placing if is_of_underlay(handle) else session.gestures

    def _as_lifted(self, sample: RawSample) -> RawSample:
        """Return the last sample with the pressure before it: a release reports none."""
        last = self._newest
        return sample if last is None else sample._replace(pressure=last.pressure)

    def _turn(self, x: float, y: float) -> None:
        press = self.machine.press
        if press is not None:
            self._view.turn(self.machine.motion, x - press.x, y - press.y)
