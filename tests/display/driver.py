"""The program with an ear: ``python -m tests.display.driver`` opens the real window by `start`.

One question a line on stdin, ``{"do": NAME, …}``; one answer a line on stdout, ``{"is": …}`` or
``{"problem": TRACEBACK}``. A question is a function of `QUESTIONS`.
"""

from __future__ import annotations

import json
import os
import sys
import threading
import time
import traceback
from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtCore import (
    QEvent,
    QMimeData,
    QObject,
    QPoint,
    QPointF,
    QSocketNotifier,
    Qt,
    QTimer,
    QUrl,
)
from PySide6.QtGui import (
    QColor,
    QDragEnterEvent,
    QDropEvent,
    QGuiApplication,
    QImage,
    QInputDevice,
    QPointingDevice,
    QTabletEvent,
)
from PySide6.QtWidgets import QApplication, QMessageBox

from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.job import Job
from bozzetto_app.canvas.input.state_machine import Mode
from bozzetto_app.main_window import Window
from bozzetto_app.startup import application, start

NO_BUTTON, LEFT = Qt.MouseButton.NoButton, Qt.MouseButton.LeftButton
NO_KEY = Qt.KeyboardModifier.NoModifier
Can = QInputDevice.Capability


class Driver(QObject):
    """Answers questions about the one window."""

    def __init__(self) -> None:
        super().__init__(application())
        self._answers = os.fdopen(os.dup(1), "w", buffering=1)
        os.dup2(2, 1)  # nothing else gets between the answers
        self._rest = b""
        self._ear = QSocketNotifier(0, QSocketNotifier.Type.Read, self)
        self._ear.activated.connect(self._read)
        self._window: Window | None = None
        self._painted = False
        self._strokes: list[Stroke] = []
        self._sending: threading.Thread | None = None
        self._busy = QTimer(self)
        self._pause = 0.0
        self._busy.timeout.connect(lambda: time.sleep(self._pause))
        self._stylus = QPointingDevice(
            "test stylus", 7, QInputDevice.DeviceType.Stylus, QPointingDevice.PointerType.Pen,
            Can.Position | Can.Pressure | Can.Hover, 1, 3,
        )  # fmt: skip
        application().installEventFilter(self)  # which hears of every object's events

    @property
    def window(self) -> Window:
        if self._window is None:
            self._window = next(w for w in QApplication.topLevelWidgets() if isinstance(w, Window))
            keep = self._window.session.gestures.stroke_lifted

            def lifted(stroke: Stroke) -> None:
                self._strokes.append(stroke)
                keep(stroke)

            self._window.session.gestures.stroke_lifted = lifted  # type: ignore[method-assign]
        return self._window

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Paint and isinstance(watched, Window):
            self._painted = True
        return False

    def _read(self) -> None:
        got = os.read(0, 65536)
        if not got:  # whoever asked is gone
            os._exit(3)
        *lines, self._rest = (self._rest + got).split(b"\n")
        for line in lines:
            facts = json.loads(line)
            try:
                ask = getattr(self, f"do_{facts.pop('do')}")
                answer = {"is": ask(**facts)}
            except Exception:
                answer = {"problem": traceback.format_exc()}
            self._answers.write(json.dumps(answer) + "\n")

    # -- what can be asked --------------------------------------------------------------------

    def do_painted(self) -> bool:
        """Whether the window was painted, and what follows the first paint is done."""
        names = {thread.name for thread in threading.enumerate()}
        return self._painted and "bozzetto-imports" not in names and not self.window.session.busy

    def do_calm(self) -> bool:
        """Whether nothing is being sent, worked out or kept."""
        sending = self._sending is not None and self._sending.is_alive()
        window = self.window
        return not sending and not window.session.busy and not window.keeper.busy

    def do_facts(self) -> dict[str, Any]:
        """Where the sheet is on the screen, and how the window stands."""
        canvas, window = self.window.canvas, self.window
        corner = canvas.mapToGlobal(QPoint(0, 0))
        return {
            "platform": QGuiApplication.platformName(),
            "corner": (corner.x(), corner.y()),
            "size": (canvas.width(), canvas.height()),
            "scale": canvas.devicePixelRatioF(),
            "active": window.isActiveWindow(),
            "minimised": window.isMinimized(),
            "mode": canvas.hand.machine.mode.name,
            "models": len(window.session.drawing.document),
            "pending": len(window.session.drawing.pending),
            "underlays": len(window.session.drawing.document.underlays),
            "high": QApplication.testAttribute(
                Qt.ApplicationAttribute.AA_CompressHighFrequencyEvents
            ),
            "tablet": QApplication.testAttribute(Qt.ApplicationAttribute.AA_CompressTabletEvents),
        }

    def do_lifted(self) -> bool:
        """Whether no gesture is under way, and a stroke has come since `strokes` was asked."""
        sending = self._sending is not None and self._sending.is_alive()
        idle = self.window.canvas.hand.machine.mode is Mode.IDLE
        return bool(self._strokes) and idle and not sending

    def do_strokes(self) -> list[list[tuple[float, float, float]]]:
        """The strokes that were handed to the session: x, y, t of every sample."""
        made = [
            list(zip(s.x.tolist(), s.y.tolist(), s.t.tolist(), strict=True)) for s in self._strokes
        ]
        self._strokes.clear()
        return made

    def do_busy(self, milliseconds: int) -> None:
        """Keep the window's thread busy in pieces of so many milliseconds; 0 ends it."""
        self._pause = milliseconds / 1000.0
        if milliseconds:
            self._busy.start(1)
        else:
            self._busy.stop()

    def do_stylus(self, points: list[tuple[float, float]], pace: float) -> None:
        """Post a stroke of the stylus from beside the window's thread, `pace` seconds a point."""
        canvas = self.window.canvas
        corner = QPointF(canvas.mapToGlobal(QPoint(0, 0)))

        def send() -> None:
            begun = time.monotonic()
            for k, place in enumerate(points):
                time.sleep(max(0.0, begun + k * pace - time.monotonic()))
                last = k == len(points) - 1
                kind = QEvent.Type.TabletMove
                if k == 0:
                    kind = QEvent.Type.TabletPress
                elif last:
                    kind = QEvent.Type.TabletRelease
                button = LEFT if k == 0 or last else NO_BUTTON
                here = QPointF(*place)
                event = QTabletEvent(
                    kind, self._stylus, here, here + corner, 0.0 if last else 0.5,
                    0.0, 0.0, 0.0, 0.0, 0.0, NO_KEY, button, NO_BUTTON if last else LEFT,
                )  # fmt: skip
                event.setTimestamp(1000 + int(1000 * k * pace))
                QApplication.postEvent(canvas, event)

        self._sending = threading.Thread(target=send, name="stylus")
        self._sending.start()

    def do_run(self, action: str) -> None:
        """Run a command of the window by its name, once this answer is given."""
        QTimer.singleShot(0, lambda: self.window.actions_.run(action))

    def do_volume(self) -> float:
        """The volume of the newest model's solids, mm³."""
        session = self.window.session
        model = list(session.drawing.document)[-1]
        solids = session.workbench.shapes([model], Job()).solids
        corners = [s.mesh.vertices.astype(float)[s.mesh.faces] for s in solids]
        return sum(float(np.linalg.det(c).sum()) / 6.0 for c in corners)

    def do_ask(self) -> None:
        """Open a question over the window, as programs do in the middle of something."""
        self._question = QMessageBox(self.window)
        self._question.setText("Is this a question?")
        self._question.open()

    def do_answer(self) -> None:
        """Close the question."""
        self._question.close()

    def do_copy_picture(self) -> None:
        """Put a picture on the clipboard."""
        picture = QImage(64, 48, QImage.Format.Format_RGB32)
        picture.fill(QColor("#c05020"))
        QGuiApplication.clipboard().setImage(picture)

    def do_clipboard(self, text: str | None = None) -> str:
        """Put a text on the clipboard, if there is one; what is on it now."""
        if text is not None:
            QGuiApplication.clipboard().setText(text)
        return QGuiApplication.clipboard().text()

    def do_drop(self, path: str) -> None:
        """Let go of a file over the sheet."""
        data = QMimeData()
        data.setUrls([QUrl.fromLocalFile(path)])
        canvas = self.window.canvas
        place = QPointF(canvas.rect().center())
        enters = QDragEnterEvent(place.toPoint(), Qt.DropAction.CopyAction, data, LEFT, NO_KEY)
        QApplication.sendEvent(canvas, enters)
        event = QDropEvent(place, Qt.DropAction.CopyAction, data, LEFT, NO_KEY)
        QApplication.sendEvent(canvas, event)

    def do_look(self, path: str) -> None:
        """Write a picture of the whole window."""
        self.window.grab().save(path)

    def do_minimise(self) -> None:
        """Put the window away."""
        self.window.showMinimized()

    def do_restore(self) -> None:
        """Bring the window back."""
        self.window.showNormal()
        self.window.activateWindow()


def main(words: list[str]) -> int:
    Driver()
    return start(Path(words[0]) if words else None)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
