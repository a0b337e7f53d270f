"""The canvas: viewport, wet ink, view cube, menu and hand, put together."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, QTimer, Signal
from PySide6.QtGui import (
    QCursor,
    QDragEnterEvent,
    QDropEvent,
    QFocusEvent,
    QHideEvent,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QResizeEvent,
    QTabletEvent,
    QTouchEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QApplication, QWidget

from bozzetto.errors import UserError
from bozzetto.ink.checked_points import is_seen
from bozzetto.scene.display_list import EMPTY, Scene, Shaded
from bozzetto_app.canvas.animation import FRAME, ViewMotion
from bozzetto_app.canvas.ink_on_sheet import InkOnSheet
from bozzetto_app.canvas.input.controller import Hand
from bozzetto_app.canvas.input.drag_and_drop import carries_something, take
from bozzetto_app.canvas.input.state_machine import Mode
from bozzetto_app.canvas.input.stroke_samples import PressureCurve
from bozzetto_app.canvas.input.tablet_events import ProximityWatch
from bozzetto_app.canvas.input.waiting_touch import WaitingTouch
from bozzetto_app.canvas.overlay.advice_light import ViewLight
from bozzetto_app.canvas.overlay.empty_hint import SheetHint
from bozzetto_app.canvas.overlay.pace_badge import PaceBadge
from bozzetto_app.canvas.overlay.thickness_scale import ThicknessScale
from bozzetto_app.canvas.overlay.view_cube import ViewCube
from bozzetto_app.canvas.overlay.wet_ink import InkOverlay
from bozzetto_app.canvas.view_changes import ViewChanges
from bozzetto_app.canvas.viewport.switching import Viewports
from bozzetto_app.i18n import tr
from bozzetto_app.settings import settings
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto.plugin.job import Job
    from bozzetto.scene.palette import Palette
    from bozzetto.view.camera import Camera
    from bozzetto_app.canvas.overlay.loupe import Loupe
    from bozzetto_app.canvas.radial_menu import MenuEntry, RadialMenu
    from bozzetto_app.session.notices import Notice
    from bozzetto_app.session.session import Session

__all__ = ["Canvas"]

log = logging.getLogger(__name__)

CUBE_MARGIN: Final = 16
"""Distance of the view cube from the canvas's corner, pixels."""

HELD: Final = 2000
"""How long another scene waits for the view that goes along with it, ms.

On a busy machine a view takes most of a second. A picture that jumps is worse than a late one.
"""


def _ignore(answer: object) -> None:
    """Ignore the answer of work that only warms something up."""


def _raise(problem: BaseException) -> None:
    raise problem


class Canvas(QWidget):
    """The sheet: what people draw on, with all that lies over it.

    Parameters
    ----------
    session : Session
        Read, called and listened to; never changed by any other road.
    palette : Palette
        Colours of the theme.

    Attributes
    ----------
    hand : Hand
        What turns input into gestures.
    motion : ViewMotion
    views : ViewChanges
        The ways to other views.
    waiting : InkOnSheet
        The ink that no modeler has taken yet.
    viewports : Viewports
    light : ViewLight
        What the modeler says of the view.
    menu_entries : callable
        Returns what the radial menu shows, most wanted first; set by the window.

    Signals
    -------
    menu_refused : MenuEntry
        Something was chosen in the radial menu that cannot be done now.
    """

    menu_refused = Signal(object)

    def __init__(self, session: Session, palette: Palette, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(tr("Canvas", "Sheet"))
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        self.setMouseTracking(True)
        self.setTabletTracking(True)
        self.setAttribute(Qt.WidgetAttribute.WA_AcceptTouchEvents)
        self.setAcceptDrops(True)
        self.setMinimumSize(200, 160)
        self.setFocus()
        self.menu_entries: Callable[[], Sequence[MenuEntry]] = tuple
        self._session = session
        self._colors = palette
        self._tilted = False
        self._pictured = ""

        self.viewports = Viewports(session, self, palette)
        self._sorting = Channel("sort-for-picking", parent=self)
        self.overlay = InkOverlay(self)
        self.waiting = InkOnSheet(session, self.overlay)
        self.empty_hint = SheetHint(self)
        self.cube = ViewCube(self)
        self.light = ViewLight(self)
        self.pace_badge = PaceBadge(self)
        self.thickness_scale = ThicknessScale(self)
        self._loupe: Loupe | None = None
        self._menu: RadialMenu | None = None
        self.hand = Hand(session, self.overlay)
        self._touch = WaitingTouch(session, self)
        self.motion = ViewMotion(session, self)
        self.views = ViewChanges(session, self.motion)
        self._sorted = EMPTY

        self._proximity = ProximityWatch(self)
        self._proximity.came.connect(self.hand.pen_came)
        self._proximity.left.connect(self.hand.pen_left)
        self.viewports.first_painted.connect(self._watch_proximity)

        self._held = QTimer(self, singleShot=True)
        self._held.timeout.connect(self._show_held)
        self._listen_to_session()
        self._listen_to_hand()
        self._listen_to_view_tools()

        self._mode_changed()
        self.read_settings()
        self.set_palette(palette)
        self.viewports.show_all()
        self._show_camera()
        self._name_sides()
        self._show_scene()
        self._show_pending()
        self.installEventFilter(self)

    def _listen_to_session(self) -> None:
        """Show what changes in the session."""
        session = self._session
        session.scene.changed.connect(self._show_scene)
        session.scene.live_changed.connect(self._show_live)
        session.view.camera_changed.connect(self._show_camera)
        session.drawing.waiting_changed.connect(self._show_pending)
        session.toolbox.tool_changed.connect(self._show_pending)
        session.view.style_changed.connect(self.viewports.show_style)
        session.view.style_changed.connect(self._show_scale)
        self.viewports.thickness.changed.connect(self._show_scale)
        session.notices.noticed.connect(self._notice)
        session.solver.settled.connect(self._settled)
        session.advice.changed.connect(self._show_advice)
        session.hints.changed.connect(self._show_next_step)
        session.pictures.taken.connect(self._got_picture)

    def _listen_to_hand(self) -> None:
        """Show what the hand does, and answer its touches."""
        session = self._session
        self.hand.pressed.connect(self.motion.finish)
        self.hand.ink_began.connect(self._fade_hint)
        self.hand.ink_began.connect(session.pictures.placing.leave)
        self.hand.aimed.connect(self._aim)
        self.hand.aim_ended.connect(self._put_loupe_away)
        self.hand.mode_changed.connect(self._mode_changed)
        self.hand.touched.connect(self._touch.take)
        self.hand.pressed.connect(self._touch.forget)
        self.hand.came_to_nothing.connect(session.gestures.explain)
        self.hand.menu_pressed.connect(self.open_menu)
        self.hand.menu_moved.connect(lambda place: self.menu.point(place))
        self.hand.menu_released.connect(lambda flicked: self.menu.lift(flicked=flicked))

    def _listen_to_view_tools(self) -> None:
        """Follow what lies over the sheet: the cube, the light, and the pace of what moves."""
        session = self._session
        self.cube.direction_chosen.connect(self.views.look_from)
        self.cube.turned.connect(self.views.turn)
        for signal in (
            session.toolbox.modeler_changed,
            session.selection.changed,
            session.drawing.changed,
        ):
            signal.connect(self._name_sides)
        self.cube.home_chosen.connect(self.views.fit)
        self.cube.projection_chosen.connect(self.views.toggle_projection)
        self.light.turn_chosen.connect(self.views.turn_to_better)
        session.gestures.motion.pace_changed.connect(self.pace_badge.show_pace)

    def _watch_proximity(self) -> None:
        """Look out for the pen from the first paint on: till then thousands of events pass."""
        application = QApplication.instance()
        if application is not None:
            application.installEventFilter(self._proximity)

    # -- theme, settings, words -----------------------------------------------------------------

    def set_palette(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._colors = palette
        self.viewports.set_palette(palette)
        for part in (
            *(self.overlay, self.empty_hint, self.cube, self.light),
            *(self.pace_badge, self.thickness_scale, self._loupe, self._menu),
        ):
            if part is not None:
                part.set_colors(palette)

    def read_settings(self) -> None:
        """Take over what the settings say; call it when they changed."""
        store = settings()
        self.hand.curve = PressureCurve.from_setting(store.value("pen/pressure_curve", 1.0))
        self.motion.reduced = bool(store.value("view/reduced_motion", False, type=bool))
        application = QApplication.instance()
        assert application is not None
        application.setProperty("reducedMotion", self.motion.reduced)
        self._tilts = bool(store.value("view/settle_tilt", True, type=bool))

    def show_hint(self, text: str) -> None:
        """Show a line in the middle of the sheet until ink begins; "" takes it away."""
        self.empty_hint.say(text)
        self._show_words()

    def _fade_hint(self) -> None:
        self.empty_hint.fade()
        self._show_words()

    def leave_room(self, left: int) -> None:
        """Centre what is said beside what covers so many pixels of the sheet's left.

        What is framed from now on lies there as well.
        """
        self._session.view.covered = left
        self.empty_hint.left = self.light.left = left
        self.empty_hint.update()
        self._place_cube()
        self.light.lie_on(self.rect())
        self.pace_badge.lie_on(self.rect())
        self.thickness_scale.lie_on(self.rect(), left)

    def describe_viewport(self) -> str:
        """Return the name of the renderer, for the About dialog."""
        return self.viewports.current.describe()

    def grab_picture(self) -> QImage:
        """Return a picture of the scene as it is shown now, without wet ink and view cube."""
        return self.viewports.current.grab()

    # -- looking ------------------------------------------------------------------------------

    def _settled(self, model_id: str) -> None:
        """Tilt the first shape to show that it is one, once the view has gone to where it is."""
        if self._session.advice.holds_eye(self._session.view.camera) or self._pictured == model_id:
            return
        if self._session.scene.busy or self._session.advice.may_follow:
            QTimer.singleShot(FRAME, self, lambda: self._settled(model_id))
            return
        idle = self.hand.machine.mode is Mode.IDLE and not self.motion.is_running
        if self._tilts and not self._tilted and idle and not self._is_of_lines(model_id):
            self._tilted = True
            self.motion.tilt()

    def _is_of_lines(self, model_id: str) -> bool:
        """Whether a model has no surface: the next line is aimed at where the last one is seen."""
        layers = [layer for layer in self._session.scene.visible.layers if layer.owner == model_id]
        items = [item for layer in layers for item in layer.items]
        surfaces = (item for item in items if isinstance(item, Shaded) and item.pickable)
        return bool(items) and not any(surfaces)

    # -- the menu -----------------------------------------------------------------------------

    @property
    def menu(self) -> RadialMenu:
        """The radial menu, made when it is first asked for: the first paint needs none."""
        if self._menu is None:
            from bozzetto_app.canvas.radial_menu import RadialMenu

            self._menu = RadialMenu(self)
            self._menu.refused.connect(self.menu_refused)
            self._menu.set_colors(self._colors)
        return self._menu

    def open_menu(self, place: QPointF | None = None) -> None:
        """Open the radial menu at a place; without one at the pointer, or close it."""
        if place is None:
            if self.menu.isVisible():
                self.menu.close_menu()
                return
            place = QPointF(self.mapFromGlobal(QCursor.pos()))
            if not self.rect().contains(place.toPoint()):
                place = QPointF(self.rect().center())
        self.menu.open_at(place, self.menu_entries())

    # -- what the session shows -----------------------------------------------------------------

    def _show_scene(self) -> None:
        """Show another scene, together with the view where the view goes along with it."""
        if self._session.advice.may_follow:
            if not self._held.isActive():
                self._held.start(HELD)
            return
        self._show_held()

    def _show_held(self) -> None:
        self._held.stop()
        self.viewports.show_scene()
        self._magnify()
        self.hand.hovering.scene_or_view_changed()
        if not self._session.drawing.is_dragging:
            self._prepare_picking(self._session.scene.visible, self._session.view.camera)

    def _show_live(self) -> None:
        self.viewports.show_live()
        self._magnify()

    @property
    def loupe(self) -> Loupe:
        """The loupe, made when a place is first aimed at: the first paint needs none."""
        if self._loupe is None:
            from bozzetto_app.canvas.overlay.loupe import Loupe

            self._loupe = Loupe(lambda: self.viewports.current.shown(), self)
            self._loupe.set_colors(self._colors)
        return self._loupe

    def _magnify(self) -> None:
        """Show what has changed in the loupe as well, while it is there."""
        if self._loupe is not None and self._loupe.isVisible():
            self._loupe.show_scene(self._all_shown(), self._session.view.camera)

    def _put_loupe_away(self) -> None:
        if self._loupe is not None:
            self._loupe.put_away()

    def _aim(self, place: QPointF) -> None:
        """Magnify the place that the pen aims at."""
        if not self.loupe.isVisible():
            self._fade_hint()
            self.loupe.show_scene(self._all_shown(), self._session.view.camera)
        self.loupe.point(place.x(), place.y())

    def _all_shown(self) -> Scene:
        return self._session.scene.visible.under(self._session.scene.live)

    def _prepare_picking(self, scene: Scene, camera: Camera) -> None:
        """Cast a first ray beside the window: it sorts large meshes, which takes a moment."""
        if scene is self._sorted:
            return
        self._sorted = scene
        if not scene.layers:
            return

        def work(job: Job) -> None:
            from bozzetto.scene.picking import cast_rays

            cast_rays(scene, camera.rays([(0.0, 0.0)]))

        self._sorting.submit(Request(work, _ignore, _raise))

    def _name_sides(self) -> None:
        self.cube.name_sides(self.views.sides)

    def _show_camera(self) -> None:
        self.viewports.show_camera()
        self.cube.set_camera(self._session.view.camera)
        self._show_next_place()
        self.hand.hovering.scene_or_view_changed()
        if not self.waiting.is_empty:
            self._show_pending()

    def _show_pending(self) -> None:
        self.waiting.show()
        if self._session.drawing.pending:
            self._fade_hint()  # ink that no pen brought

    def _show_next_step(self) -> None:
        if self.empty_hint.is_read:
            self.empty_hint.say(self._session.hints.step.sentence)
        self._show_words()
        self._show_next_place()

    def _show_words(self) -> None:
        """Show what is next over the sheet, unless it stands in the middle of it."""
        said = "" if self.empty_hint.is_read else self._session.hints.step.sentence
        self.light.show_advice(self._session.advice.advice, said)

    def _show_next_place(self) -> None:
        """Mark where the next step is done, while the pen is up."""
        step, session = self._session.hints.step, self._session
        place = step.place
        if step.on_picture and not session.advice.holds_eye(session.view.camera):
            place = None
        if place is None or self.hand.machine.mode not in (Mode.IDLE, Mode.NAVIGATING):
            self.overlay.mark_next(None)
            return
        seen, depth = self._session.view.camera.project([place])
        ahead = is_seen(seen)[0] and depth[0] > 0.0
        self.overlay.mark_next((float(seen[0, 0]), float(seen[0, 1])) if ahead else None)

    def _show_advice(self) -> None:
        advising = self._session.advice
        self._show_words()
        self._show_next_place()
        self.viewports.show_advice()
        self.hand.hovering.scene_or_view_changed()
        model = self._session.selection.model if self._pictured else None
        if model is not None and model.id == self._pictured and model is advising.about:
            self._pictured = ""
            self.views.turn_to_better()
        followed = self._follow()
        if self._held.isActive() and (followed or not advising.may_follow):
            self._show_held()

    def _follow(self) -> bool:
        """Go along with a picture that has another camera now, unless a hand is at work.

        Where it is, the view is looked at again when it has done. Returns whether it went along.
        """
        session, advice = self._session, self._session.advice.advice
        idle = self.hand.machine.mode is Mode.IDLE and not self.motion.is_running
        if advice is None or not advice.follow or advice.better is None or not idle:
            return False
        if not session.advice.is_about(session.view.camera):
            return False
        session.view.set_camera(advice.better.with_viewport(*session.view.camera.viewport))
        return True

    def _got_picture(self, model_id: str) -> None:
        """Go to the view of a sketch that came in, once the modeler says which it is."""
        self._pictured = model_id

    def _notice(self, notice: Notice) -> None:
        if notice.places:
            self.overlay.light_up(notice.places, notice.text)

    def _show_scale(self) -> None:
        """Tell what the colours of thickness mean while they are shown."""
        self.thickness_scale.setVisible(self._session.view.shading == "thickness")
        self.thickness_scale.say(self.viewports.thickness.view)

    def _mode_changed(self) -> None:
        mode = self.hand.machine.mode
        self._session.toolbox.hold(mode.records)
        if mode not in (Mode.IDLE, Mode.CHOOSING):
            self.menu.close_menu()
        self._show_next_place()
        if mode is Mode.IDLE:
            # Later: what the hand has just done belongs to the view in which it was done.
            QTimer.singleShot(0, self, self._follow)
        shape = {
            Mode.NAVIGATING: Qt.CursorShape.ClosedHandCursor,
            Mode.DRAGGING: Qt.CursorShape.SizeAllCursor,
        }.get(mode, Qt.CursorShape.CrossCursor)
        self.setCursor(shape)

    # -- events -------------------------------------------------------------------------------

    def resizeEvent(self, event: QResizeEvent) -> None:
        self.viewports.set_geometry(self.rect())
        self.overlay.setGeometry(self.rect())
        self.empty_hint.setGeometry(self.rect())
        self._place_cube()
        self.light.lie_on(self.rect())
        self.pace_badge.lie_on(self.rect())
        self.thickness_scale.lie_on(self.rect(), self.light.left)
        self.menu.close_menu()
        camera: Camera = self._session.view.camera
        size = (float(max(self.width(), 1)), float(max(self.height(), 1)))
        if camera.viewport != size:
            self._session.view.set_camera(camera.with_viewport(*size))

    def _place_cube(self) -> None:
        """Put the cube at the upper right, or away where something else covers its place."""
        left = self.width() - self.cube.width() - CUBE_MARGIN
        self.cube.move(left, CUBE_MARGIN)
        self.cube.setVisible(left >= self.empty_hint.left)

    def tabletEvent(self, event: QTabletEvent) -> None:
        self.hand.tablet(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.hand.mouse_pressed(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self.hand.mouse_moved(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self.hand.mouse_released(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self.hand.mouse_pressed(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        self.hand.wheel(event)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Take touches, for which Qt has no handler of their own.

        Not in `event`: an exception in a handler that was called through an override of it is
        taken apart by PySide, and some exceptions cannot be; see `screen_limits`.
        """
        if watched is self and isinstance(event, QTouchEvent):
            self.hand.touch(event)
            return True
        return False

    def leaveEvent(self, event: QEvent) -> None:
        self.hand.hovering.leave()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        again = event.isAutoRepeat()
        if event.key() == Qt.Key.Key_Escape and (
            again or self.hand.cancel() or self._session.escape()
        ):
            return  # held on after it dropped a stroke, it must not drop the waiting ink as well
        if event.key() == Qt.Key.Key_Space:
            self.hand.space_held = True
        elif event.key() == Qt.Key.Key_Q and not event.modifiers():
            if not again:
                self.open_menu()
        else:
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Space:
            self.hand.space_held = event.isAutoRepeat()
        else:
            super().keyReleaseEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        self.hand.space_held = False
        super().focusOutEvent(event)

    def hideEvent(self, event: QHideEvent) -> None:
        self.hand.end()
        super().hideEvent(event)

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        if carries_something(event.mimeData()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        event.acceptProposedAction()
        under = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        if not take(self._session, event.mimeData(), under=under):
            self._session.notices.complain(
                UserError(
                    tr("Canvas", "Only files of this computer and pictures can be dropped here.")
                )
            )
