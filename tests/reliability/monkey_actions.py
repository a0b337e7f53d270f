"""What a monkey can do to a window: every device, every button, every file, in any order."""

from __future__ import annotations

import math
import random
import string
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final, Protocol

from PySide6.QtCore import QEvent, QMimeData, QObject, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import (
    QCloseEvent,
    QDragEnterEvent,
    QDropEvent,
    QEnterEvent,
    QFocusEvent,
    QImage,
    QInputDevice,
    QKeyEvent,
    QMouseEvent,
    QPointingDevice,
    QTabletEvent,
    QWheelEvent,
)
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QApplication,
    QDialog,
    QDockWidget,
    QLineEdit,
    QMenu,
    QWidget,
)
from shiboken6 import isValid

from bozzetto_app.main_window import Window

__all__ = ["ACTIONS", "Monkey", "Path", "named_actions"]

LEFT = Qt.MouseButton.LeftButton
MIDDLE = Qt.MouseButton.MiddleButton
RIGHT = Qt.MouseButton.RightButton
NONE = Qt.MouseButton.NoButton
KEYS: Final = (
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.AltModifier,
    Qt.KeyboardModifier.ShiftModifier,
    Qt.KeyboardModifier.ControlModifier,
)
Can = QInputDevice.Capability
Points = list[tuple[float, float]]

JUNK: Final = (
    "", "0", "-1", "1e308", "-1e-308", "nan", "inf", "1/0", "2**9999", "((((", "3,5", "12 mm",
    "=1+1", "💥", "a\u0301\u202e", "x" * 400, "0x10", "  7  ", "1 2 3", "--5", "9" * 40,
)  # fmt: skip
"""What a field may be given."""

FAR: Final = (-1.0, 0.0, 5000.0, -70000.0, 3.2e9)
"""Places, pixels, that no pen on the sheet would tell of, but a driver may."""

DONE_WITHOUT: Final = frozenset({"file.quit"})
"""Actions that the monkey has its own way for."""


class Monkey(Protocol):
    """What an action needs of whoever plays."""

    chance: random.Random
    window: Window
    files: list[Path]
    folder: Path
    pen: QPointingDevice
    eraser: QPointingDevice
    screen: QPointingDevice

    def stamp(self) -> int: ...
    def open_window(self) -> None: ...
    def crash_a_copy(self) -> None: ...


# -- where --


def _front(monkey: Monkey) -> QWidget:
    """The window that a person can reach: a menu, else a dialog that waits, else any."""
    front = QApplication.activePopupWidget() or QApplication.activeModalWidget()
    if front is not None:
        return front
    others = [
        widget
        for widget in QApplication.topLevelWidgets()
        if widget.isVisible() and widget is not monkey.window and widget.windowHandle() is not None
    ]
    others.sort(key=lambda widget: (type(widget).__name__, widget.objectName()))
    if others and monkey.chance.random() < 0.5:
        return monkey.chance.choice(others)
    return monkey.window


def _widgets(root: QWidget, kind: type[QWidget] = QWidget) -> list[QWidget]:
    return [
        widget
        for widget in root.findChildren(kind)
        if isValid(widget) and widget.isVisible() and widget.isEnabled()
    ]


def _place_in(monkey: Monkey, widget: QWidget) -> tuple[float, float]:
    chance = monkey.chance
    return chance.uniform(0, max(widget.width(), 1)), chance.uniform(0, max(widget.height(), 1))


def _on_sheet(monkey: Monkey) -> tuple[float, float]:
    if monkey.chance.random() < 0.01:
        return monkey.chance.choice(FAR), monkey.chance.choice(FAR)
    return _place_in(monkey, monkey.window.canvas)


def _path(monkey: Monkey) -> Points:
    """A closed outline, a clover, a line, a scribble or a dot."""
    chance = monkey.chance
    x, y = _on_sheet(monkey)
    kind = chance.randrange(6)
    count = chance.choice((2, 3, 8, 30, 80))
    size = chance.choice((2.0, 30.0, 90.0, 200.0))
    if kind == 0:
        return [(x, y)]
    if kind == 1:
        dx, dy = chance.uniform(-size, size), chance.uniform(-size, size)
        return [(x + dx * i / count, y + dy * i / count) for i in range(count + 1)]
    if kind == 2:
        places = [(x, y)]
        for _ in range(count):
            last = places[-1]
            places.append(
                (last[0] + chance.gauss(0, size / 4), last[1] + chance.gauss(0, size / 4))
            )
        return places
    wave = chance.choice((0.0, 0.0, 0.3))
    share = chance.choice((1.0, 1.0, 0.97, 0.5))
    turns = [math.tau * share * i / (count + 8) for i in range(count + 9)]
    return [
        (
            x + size * (1 + wave * math.cos(3 * turn)) * math.cos(turn),
            y + size * (1 + wave * math.cos(3 * turn)) * math.sin(turn),
        )
        for turn in turns
    ]


# -- devices --


def _tablet(
    monkey: Monkey,
    device: QPointingDevice,
    kind: QEvent.Type,
    place: tuple[float, float],
    button: Qt.MouseButton,
    buttons: Qt.MouseButton,
    keys: Qt.KeyboardModifier,
) -> None:
    """Send a tablet event to the whole window, which finds who is meant, as the system does."""
    window = monkey.window
    handle = window.windowHandle()
    if handle is None:
        return
    chance = monkey.chance
    there = QPointF(window.canvas.mapTo(window, QPointF(*place)))
    pressure = 0.0 if kind == QEvent.Type.TabletRelease else chance.random()
    event = QTabletEvent(
        kind, device, there, QPointF(handle.mapToGlobal(there)), pressure,
        chance.uniform(-60, 60), chance.uniform(-60, 60), 0.0, chance.uniform(0, 360), 0.0,
        keys, button, buttons,
    )  # fmt: skip
    event.setTimestamp(monkey.stamp())
    QApplication.sendEvent(handle, event)


def pen_stroke(monkey: Monkey) -> None:
    """Draw, erase, turn or open the menu with the pen; not every stroke is lifted."""
    if QApplication.activeModalWidget() or QApplication.activePopupWidget():
        return
    chance = monkey.chance
    device = monkey.eraser if chance.random() < 0.1 else monkey.pen
    button = chance.choices((LEFT, MIDDLE, RIGHT), (10, 1, 1))[0]
    keys = chance.choice(KEYS)
    places = _path(monkey)
    if chance.random() < 0.97:
        _tablet(monkey, device, QEvent.Type.TabletPress, places[0], button, button, keys)
    pause = chance.random() < 0.3
    for place in places[1:]:
        _tablet(monkey, device, QEvent.Type.TabletMove, place, NONE, button, keys)
        if pause and chance.random() < 0.2:
            QApplication.processEvents()
    if chance.random() < 0.95:
        _tablet(monkey, device, QEvent.Type.TabletRelease, places[-1], button, NONE, keys)


def pen_hovers(monkey: Monkey) -> None:
    """Move the pen over the sheet without touching it."""
    for place in _path(monkey)[:20]:
        _tablet(monkey, monkey.pen, QEvent.Type.TabletMove, place, NONE, NONE, KEYS[0])


def pen_comes_or_goes(monkey: Monkey) -> None:
    """Tell the program that the pen is near, or has left."""
    kind = monkey.chance.choice(
        (QEvent.Type.TabletEnterProximity, QEvent.Type.TabletLeaveProximity)
    )
    event = QTabletEvent(
        kind, monkey.pen, QPointF(), QPointF(), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, KEYS[0], NONE, NONE
    )
    QApplication.sendEvent(QApplication.instance(), event)


def _mouse(
    monkey: Monkey,
    window: QWidget,
    kind: QEvent.Type,
    place: QPointF,
    button: Qt.MouseButton,
    buttons: Qt.MouseButton,
    keys: Qt.KeyboardModifier,
) -> None:
    handle = window.windowHandle() if isValid(window) else None
    if handle is None:
        return
    event = QMouseEvent(kind, place, handle.mapToGlobal(place), button, buttons, keys)
    event.setTimestamp(monkey.stamp())
    QApplication.sendEvent(handle, event)


def mouse_drag(monkey: Monkey) -> None:
    """Press, move and release a button of the mouse on the sheet."""
    if QApplication.activeModalWidget() or QApplication.activePopupWidget():
        return
    chance, window = monkey.chance, monkey.window
    button = chance.choices((LEFT, MIDDLE, RIGHT), (6, 5, 1))[0]
    keys = chance.choice(KEYS)
    places = [QPointF(window.canvas.mapTo(window, QPointF(*place))) for place in _path(monkey)]
    under = window.childAt(places[0].toPoint())
    if under is not None and _drags(under):
        return
    _mouse(monkey, window, QEvent.Type.MouseButtonPress, places[0], button, button, keys)
    for place in places[1:]:
        _mouse(monkey, window, QEvent.Type.MouseMove, place, NONE, button, keys)
    if chance.random() < 0.97:
        _mouse(monkey, window, QEvent.Type.MouseButtonRelease, places[-1], button, NONE, keys)


def mouse_click(monkey: Monkey) -> None:
    """Click anywhere in the window in front, once or twice."""
    chance, front = monkey.chance, _front(monkey)
    place = QPointF(*_place_in(monkey, front))
    button = chance.choices((LEFT, RIGHT), (5, 1))[0]
    keys = chance.choice(KEYS)
    for turn in range(chance.choice((1, 1, 2, 3))):
        press = QEvent.Type.MouseButtonDblClick if turn == 1 else QEvent.Type.MouseButtonPress
        _mouse(monkey, front, press, place, button, button, keys)
        _mouse(monkey, front, QEvent.Type.MouseButtonRelease, place, button, NONE, keys)


def touch(monkey: Monkey) -> None:
    """Turn, move and zoom with one to three fingers; some touches are cancelled."""
    if QApplication.activeModalWidget() or QApplication.activePopupWidget():
        return
    chance, canvas = monkey.chance, monkey.window.canvas
    fingers = [
        QPoint(*map(int, _place_in(monkey, canvas))) for _ in range(chance.choice((1, 2, 2, 3)))
    ]
    begin = QTest.touchEvent(canvas, monkey.screen, False)
    for number, place in enumerate(fingers):
        begin.press(number, place, canvas)
    begin.commit(False)
    for _ in range(chance.randrange(6)):
        step = QTest.touchEvent(canvas, monkey.screen, False)
        fingers = [
            place + QPoint(chance.randint(-60, 60), chance.randint(-60, 60)) for place in fingers
        ]
        for number, place in enumerate(fingers):
            step.move(number, place, canvas)
        step.commit(False)
    end = QTest.touchEvent(canvas, monkey.screen, False)
    for number, place in enumerate(fingers):
        end.release(number, place, canvas)
    end.commit(False)


def _wheel(monkey: Monkey, target: QWidget, place: QPointF, turned: int) -> None:
    event = QWheelEvent(
        place,
        QPointF(target.mapToGlobal(place)),
        QPoint(),
        QPoint(0, turned),
        NONE,
        monkey.chance.choice(KEYS),
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(target, event)


def wheel(monkey: Monkey) -> None:
    """Turn the wheel over the sheet or a panel."""
    chance, window = monkey.chance, monkey.window
    target = window.canvas if chance.random() < 0.7 else chance.choice(_widgets(window) or [window])
    place = QPointF(*_place_in(monkey, target))
    for _ in range(chance.randrange(1, 6)):
        _wheel(monkey, target, place, chance.choice((120, -120, 30, -240, 1200, -1200)))


def zoom_far(monkey: Monkey) -> None:
    """Zoom to one end, at one place."""
    place = QPointF(*_place_in(monkey, monkey.window.canvas))
    turned = monkey.chance.choice((120, -120, 2400, -2400, 30000, -30000))
    for _ in range(monkey.chance.choice((20, 60, 150))):
        _wheel(monkey, monkey.window.canvas, place, turned)


# -- keys and commands --


def _key(target: QObject, key: Qt.Key, keys: Qt.KeyboardModifier, text: str = "") -> None:
    for kind in (QEvent.Type.KeyPress, QEvent.Type.KeyRelease):
        if isValid(target):
            QApplication.sendEvent(target, QKeyEvent(kind, key, keys, text))


def hold_key(monkey: Monkey) -> None:
    """Hold a key down, as long as the keyboard repeats it."""
    chance = monkey.chance
    target = QApplication.activePopupWidget() or QApplication.focusWidget() or monkey.window.canvas
    key, keys = chance.choice(HELD_KEYS)
    for number in range(chance.choice((2, 8, 40))):
        if not isValid(target):
            return
        for kind in (QEvent.Type.ShortcutOverride, QEvent.Type.KeyPress):
            if isValid(target):
                QApplication.sendEvent(target, QKeyEvent(kind, key, keys, "", number > 0))
        if chance.random() < 0.3:
            QApplication.processEvents()
    if isValid(target):
        QApplication.sendEvent(target, QKeyEvent(QEvent.Type.KeyRelease, key, keys))


def disturbed_stroke(monkey: Monkey) -> None:
    """Do something else in the middle of a stroke, then draw on and lift the pen."""
    if QApplication.activeModalWidget() or QApplication.activePopupWidget():
        return
    chance, window = monkey.chance, monkey.window
    places = _path(monkey)
    half = len(places) // 2
    keys = chance.choice(KEYS)
    _tablet(monkey, monkey.pen, QEvent.Type.TabletPress, places[0], LEFT, LEFT, keys)
    for place in places[1:half]:
        _tablet(monkey, monkey.pen, QEvent.Type.TabletMove, place, NONE, LEFT, keys)
    if chance.random() < 0.5:
        QApplication.processEvents()
    chance.choice((shortcut, hold_key, drop, wheel, lose_focus, lock_or_hide, take_modeler, save))(
        monkey
    )
    if not isValid(window) or window is not monkey.window:
        return
    for place in places[half:]:
        _tablet(monkey, monkey.pen, QEvent.Type.TabletMove, place, NONE, LEFT, keys)
    _tablet(monkey, monkey.pen, QEvent.Type.TabletRelease, places[-1], LEFT, NONE, keys)


def _type(target: QObject, text: str) -> None:
    for letter in text:
        _key(target, Qt.Key.Key_unknown, KEYS[0], letter)


NAMED_KEYS: Final = (
    Qt.Key.Key_Escape, Qt.Key.Key_Return, Qt.Key.Key_Tab, Qt.Key.Key_Backtab, Qt.Key.Key_Space,
    Qt.Key.Key_Backspace, Qt.Key.Key_Delete, Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_Left,
    Qt.Key.Key_Right, Qt.Key.Key_Home, Qt.Key.Key_End, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown,
    Qt.Key.Key_F1, Qt.Key.Key_F2, Qt.Key.Key_F5, Qt.Key.Key_F10, Qt.Key.Key_Menu, Qt.Key.Key_Q,
)  # fmt: skip


HELD_KEYS: Final = (
    (Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier),
    (Qt.Key.Key_Y, Qt.KeyboardModifier.ControlModifier),
    *((key, Qt.KeyboardModifier.NoModifier) for key in NAMED_KEYS),
    *((Qt.Key(ord(letter)), Qt.KeyboardModifier.NoModifier) for letter in "123GITFPX"),
)
"""What is held down, and with which keys."""


def press_keys(monkey: Monkey) -> None:
    """Press some keys where the focus is."""
    chance = monkey.chance
    for _ in range(chance.randrange(1, 4)):
        target = (
            QApplication.activePopupWidget()
            or QApplication.focusWidget()
            or QApplication.activeModalWidget()
            or monkey.window.canvas
        )
        if chance.random() < 0.6:
            _key(target, chance.choice(NAMED_KEYS), chance.choice(KEYS))
        else:
            letter = chance.choice(string.ascii_lowercase + string.digits + "+-*/(). ")
            _type(target, letter)


def shortcut(monkey: Monkey) -> None:
    """Press the keys of a command."""
    made = [
        (action, key)
        for action in monkey.window.actions_.actions()
        for key in action.keys
        if action.id not in DONE_WITHOUT
    ]
    _, key = monkey.chance.choice(made)
    QTest.keySequence(_front(monkey), key)


def command(monkey: Monkey) -> None:
    """Run a command, as its menu entry does."""
    if QApplication.activeModalWidget():
        return
    registry = monkey.window.actions_
    registry.refresh()
    ready = [
        action.id
        for action in registry.actions()
        if registry.qaction(action.id).isEnabled() and action.id not in DONE_WITHOUT
    ]
    monkey.window.actions_.run(monkey.chance.choice(ready))


def open_menu(monkey: Monkey) -> None:
    """Pull down a menu; what follows is up to the keys and clicks that come."""
    bar = monkey.window.menuWidget()
    if bar is None or QApplication.activeModalWidget():
        return
    menus = [menu for menu in bar.findChildren(QMenu) if menu.actions()]
    if menus:
        menu = monkey.chance.choice(menus)
        menu.popup(bar.mapToGlobal(QPoint(20, bar.height())))
        QApplication.processEvents()
        ready = [action for action in menu.actions() if action.isEnabled()]
        if ready and monkey.chance.random() < 0.5 and isValid(menu):
            menu.setActiveAction(monkey.chance.choice(ready))
        if monkey.chance.random() < 0.8 and isValid(menu):
            menu.close()


def undo_storm(monkey: Monkey) -> None:
    """Undo and redo many times, quicker than anything can be solved."""
    session = monkey.window.session
    for _ in range(monkey.chance.choice((3, 10, 40))):
        monkey.chance.choice((session.drawing.undo, session.drawing.undo, session.drawing.redo))()
        if monkey.chance.random() < 0.1:
            QApplication.processEvents()


# -- panels and dialogs --


def _drags(widget: QWidget) -> bool:
    """Whether a row is dragged out of it: that ends with the release of the true mouse alone."""
    view: QWidget | None = widget
    while view is not None and not isinstance(view, QAbstractItemView):
        view = view.parentWidget()
    return view is not None and view.dragEnabled()


def use_widget(monkey: Monkey) -> None:
    """Press, drag over, type into or scroll any widget of the window in front."""
    chance, front = monkey.chance, _front(monkey)
    found = _widgets(front)
    if not found:
        return
    widget = chance.choice(found)
    inside = QPointF(widget.mapTo(front, QPoint(*map(int, _place_in(monkey, widget)))))
    how = chance.randrange(6)
    if isinstance(widget, QLineEdit) or how == 0:
        fields = _widgets(front, QLineEdit)
        if fields:
            field = chance.choice(fields)
            field.setFocus()
            if isinstance(field, QLineEdit):
                field.selectAll()
            _type(field, chance.choice(JUNK))
            if isValid(field):
                _key(field, chance.choice(NAMED_KEYS[:4]), KEYS[0])
    elif how == 1 and not _drags(widget):
        _mouse(monkey, front, QEvent.Type.MouseButtonPress, inside, LEFT, LEFT, KEYS[0])
        for _ in range(chance.randrange(1, 25)):
            inside += QPointF(chance.gauss(0, 15), chance.gauss(0, 4))
            _mouse(monkey, front, QEvent.Type.MouseMove, inside, NONE, LEFT, KEYS[0])
            if chance.random() < 0.2:
                QApplication.processEvents()
        _mouse(monkey, front, QEvent.Type.MouseButtonRelease, inside, LEFT, NONE, KEYS[0])
    elif how == 2:
        _wheel(monkey, widget, QPointF(3, 3), chance.choice((120, -120)))
    elif how == 3:
        widget.setFocus()
        _key(widget, chance.choice(NAMED_KEYS), chance.choice(KEYS))
    else:
        for kind, buttons in (
            (QEvent.Type.MouseButtonPress, LEFT),
            (QEvent.Type.MouseButtonRelease, NONE),
        ):
            _mouse(monkey, front, kind, inside, LEFT, buttons, KEYS[0])


def press_button(monkey: Monkey) -> None:
    """Press a button in the window in front."""
    buttons = [
        w for w in _widgets(_front(monkey), QAbstractButton) if isinstance(w, QAbstractButton)
    ]
    if buttons:
        monkey.chance.choice(buttons).click()


def answer_dialog(monkey: Monkey) -> None:
    """Answer a dialog by one of its buttons, or close it; else close a menu."""
    popup = QApplication.activePopupWidget()
    if popup is not None:
        popup.close()
        return
    dialogs = [
        w for w in QApplication.topLevelWidgets() if isinstance(w, QDialog) and w.isVisible()
    ]
    for dialog in sorted(dialogs, key=lambda one: (type(one).__name__, one.objectName())):
        buttons = [w for w in _widgets(dialog, QAbstractButton) if isinstance(w, QAbstractButton)]
        if buttons and monkey.chance.random() < 0.7:
            monkey.chance.choice(buttons).click()
        else:
            dialog.close()
        return


def lock_or_hide(monkey: Monkey) -> None:
    """Lock, unlock, hide or show some objects, and select one of them or none."""
    session, chance = monkey.window.session, monkey.chance
    models = session.drawing.document.models
    for model in chance.sample(models, min(len(models), chance.choice((1, 1, 3)))):
        if chance.random() < 0.5:
            session.objects.set_locked(model.id, not model.locked)
        else:
            session.objects.set_visible(model.id, not model.visible)
    if models:
        session.selection.select(chance.choice((*(model.id for model in models), None)))


def move_docks(monkey: Monkey) -> None:
    """Put a panel elsewhere, in a tab, at the other side, or beside the others."""
    chance, window = monkey.chance, monkey.window
    docks = window.findChildren(QDockWidget)
    dock, other = chance.choice(docks), chance.choice(docks)
    areas = (Qt.DockWidgetArea.LeftDockWidgetArea, Qt.DockWidgetArea.RightDockWidgetArea)
    how = chance.randrange(4)
    if how == 0 and dock is not other:
        window.tabifyDockWidget(dock, other)
    elif how == 1 and dock is not other:
        window.splitDockWidget(dock, other, chance.choice(tuple(Qt.Orientation)))
    elif how == 2:
        window.addDockWidget(chance.choice(areas), dock)
    else:
        window.resizeDocks([dock], [chance.choice((1, 90, 400, 3000))], Qt.Orientation.Vertical)
    dock.setVisible(dock.isVisible())


# -- files --


def take_modeler(monkey: Monkey) -> None:
    """Take another modeler, or another tool of this one."""
    session, chance = monkey.window.session, monkey.chance
    if chance.random() < 0.5 and session.toolbox.tools:
        session.toolbox.take_tool(chance.choice(session.toolbox.tools).id)
    elif session.toolbox.modelers:
        session.toolbox.take_modeler(chance.choice(session.toolbox.modelers).id)


def _mime(monkey: Monkey) -> QMimeData:
    chance, data = monkey.chance, QMimeData()
    kind = chance.randrange(6)
    if kind == 0:
        data.setText(chance.choice(JUNK))
    elif kind == 1:
        picture = QImage(chance.choice((1, 64, 900)), 48, QImage.Format.Format_ARGB32)
        picture.fill(0xFF336699)
        data.setImageData(picture)
    elif kind == 2:
        data.setData("application/x-junk", chance.randbytes(200))
    elif kind == 3:
        data.setUrls([QUrl("https://example.org/picture.png"), QUrl("file://nowhere/a.png")])
    else:
        files = [chance.choice(monkey.files) for _ in range(chance.choice((1, 1, 2)))]
        data.setUrls([QUrl.fromLocalFile(str(path)) for path in files])
    return data


def drop(monkey: Monkey) -> None:
    """Drag something over the sheet, and drop it there or not."""
    if QApplication.activeModalWidget():
        return
    canvas, data = monkey.window.canvas, _mime(monkey)
    place = QPointF(*_place_in(monkey, canvas))
    keys = monkey.chance.choice(KEYS)
    entered = QDragEnterEvent(place.toPoint(), Qt.DropAction.CopyAction, data, LEFT, keys)
    QApplication.sendEvent(canvas, entered)
    if entered.isAccepted() and monkey.chance.random() < 0.8:
        dropped = QDropEvent(place, Qt.DropAction.CopyAction, data, LEFT, keys)
        QApplication.sendEvent(canvas, dropped)


def paste(monkey: Monkey) -> None:
    """Put something, or nothing, on the clipboard and paste it."""
    clipboard = QApplication.clipboard()
    if monkey.chance.random() < 0.3:
        clipboard.clear()
    else:
        clipboard.setMimeData(_mime(monkey))
    monkey.window.files.paste(under=monkey.chance.random() < 0.3)


def save(monkey: Monkey) -> None:
    """Save the document into the scratch folder, at once or under another name."""
    session = monkey.window.session
    place = monkey.folder / f"saved {monkey.chance.randrange(4)}.bozz"
    if place not in monkey.files:
        monkey.files.append(place)
    if monkey.chance.random() < 0.3:
        monkey.window.files.ask_save()
    else:
        session.files.save(place)


def open_file(monkey: Monkey) -> None:
    """Open a document at once, without asking about unsaved work, sometimes two in a row."""
    for _ in range(monkey.chance.choice((1, 1, 2))):
        monkey.window.session.files.open(monkey.chance.choice(monkey.files))


def import_sample(monkey: Monkey) -> None:
    """Bring a sample onto the sheet with its modeler."""
    infos = [info for info in monkey.window.session.registry.modelers() if info.samples]
    info = monkey.chance.choice(infos)
    monkey.window.session.toolbox.take_modeler(info.id)
    monkey.window.session.files.exchange.import_file(monkey.chance.choice(info.samples))


def new_document(monkey: Monkey) -> None:
    """Begin a new document, without asking."""
    monkey.window.session.files.new()


def close_and_open(monkey: Monkey) -> None:
    """Close the window as its cross does; where it goes, another one is opened."""
    if QApplication.activeModalWidget():
        return
    QApplication.sendEvent(monkey.window, QCloseEvent())
    if not monkey.window.isVisible() or monkey.chance.random() < 0.3:
        monkey.open_window()


def recover(monkey: Monkey) -> None:
    """Leave a copy of the recovery data as a crash would, and be asked about it."""
    monkey.crash_a_copy()
    monkey.window.offer_recovery()


# -- the window itself --


def resize(monkey: Monkey) -> None:
    """Make the window another size, full or normal; one that was closed is not shown again."""
    chance, window = monkey.chance, monkey.window
    if not window.isVisible():
        return
    how = chance.randrange(6)
    if how == 0:
        window.showMaximized()
    elif how == 1:
        window.showNormal()
    else:
        window.resize(chance.randint(200, 1600), chance.randint(150, 1100))


def lose_focus(monkey: Monkey) -> None:
    """Take the focus away and give it back, as another program's window does."""
    canvas = monkey.window.canvas
    kind = monkey.chance.choice((QEvent.Type.FocusOut, QEvent.Type.FocusIn))
    QApplication.sendEvent(canvas, QFocusEvent(kind, Qt.FocusReason.ActiveWindowFocusReason))
    QApplication.sendEvent(canvas, QEvent(QEvent.Type.Leave))
    here = QPointF(5, 5)
    QApplication.sendEvent(canvas, QEnterEvent(here, here, here))


def change_looks(monkey: Monkey) -> None:
    """Change the theme, or the size of the letters."""
    if monkey.chance.random() < 0.6:
        monkey.window.toggle_theme()
    else:
        font = QApplication.font()
        font.setPointSizeF(monkey.chance.choice((7.0, 10.0, 14.0, 24.0)))
        QApplication.setFont(font)


def view_cube(monkey: Monkey) -> None:
    """Click or drag on the view cube."""
    canvas = monkey.window.canvas
    cubes = [w for w in _widgets(canvas) if type(w).__name__ == "ViewCube"]
    if cubes and not QApplication.activeModalWidget():
        cube = cubes[0]
        place = QPoint(*map(int, _place_in(monkey, cube)))
        QTest.mouseClick(cube, LEFT, KEYS[0], place)


def radial_menu(monkey: Monkey) -> None:
    """Open the radial menu and press somewhere near."""
    if QApplication.activeModalWidget():
        return
    canvas = monkey.window.canvas
    place = QPointF(*_place_in(monkey, canvas))
    canvas.open_menu(place)
    if monkey.chance.random() < 0.7:
        away = QPointF(monkey.chance.gauss(0, 60), monkey.chance.gauss(0, 60))
        there = QPointF(canvas.mapTo(monkey.window, place + away))
        for kind, buttons in (
            (QEvent.Type.MouseButtonPress, LEFT),
            (QEvent.Type.MouseButtonRelease, NONE),
        ):
            _mouse(monkey, monkey.window, kind, there, LEFT, buttons, KEYS[0])


ACTIONS: Final[tuple[tuple[Callable[[Monkey], None], int], ...]] = (
    (pen_stroke, 22),
    (pen_hovers, 3),
    (pen_comes_or_goes, 1),
    (mouse_drag, 8),
    (mouse_click, 6),
    (touch, 3),
    (wheel, 4),
    (zoom_far, 2),
    (press_keys, 6),
    (hold_key, 3),
    (disturbed_stroke, 6),
    (lock_or_hide, 3),
    (move_docks, 1),
    (shortcut, 4),
    (command, 8),
    (open_menu, 2),
    (undo_storm, 3),
    (use_widget, 14),
    (press_button, 4),
    (answer_dialog, 10),
    (take_modeler, 4),
    (drop, 2),
    (paste, 2),
    (save, 2),
    (open_file, 2),
    (import_sample, 2),
    (new_document, 2),
    (close_and_open, 1),
    (recover, 1),
    (resize, 2),
    (lose_focus, 2),
    (change_looks, 1),
    (view_cube, 2),
    (radial_menu, 2),
)
"""What can be done, and how often it is, in parts."""


def named_actions() -> Iterator[str]:
    """The names of all actions."""
    return (action.__name__ for action, _ in ACTIONS)
