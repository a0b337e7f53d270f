"""A process that opens the window and draws until it is killed: for `test_autosave.py`.

Prints "began", then the number of strokes so far after the pen was lifted from each; none
of them is one that could be refused. With "drag" as second argument it draws one stroke, drags a
slider of what comes of it without a pause, and prints each value that it has set, and when.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from PySide6.QtCore import QTimer

from bozzetto.plugin.host.registry import Registry
from bozzetto_app.main_window import Window
from bozzetto_app.session.session import Session
from bozzetto_app.startup import application
from tests.app.tablet import Stylus, circle

PACE = 150
"""Time between two strokes, ms: quicker than a hand."""


VALUE, TICK, STEP = "inflation", 20, 1e-4
"""The parameter that is dragged, the time between two values, ms, and their difference."""


def main(recovery: str, what: str = "draw") -> int:
    app = application()
    session = Session(Registry())
    window = Window(session, Path(recovery))
    window.resize(1000, 700)
    window.show()
    stylus = Stylus(window.canvas)
    count = 0

    def draw() -> None:
        nonlocal count
        across, down = 400.0 + 90 * (count % 5), 200.0 + 90 * (count // 5 % 4)
        share = 0.7 if count % 4 == 3 else 1.0  # every fourth one waits until the next begins
        if session.drawing.pending:
            session.gestures.commit()
        if count % 20 == 0:
            session.gestures.commit()
        stylus.draw(circle(across, down, 30.0, samples=40, share=share))
        count += 1
        print(count, flush=True)

    session.notices.noticed.connect(
        lambda said: said.kind == "error" and print(said.text, flush=True)
    )
    timer = QTimer(interval=PACE)
    timer.timeout.connect(draw)

    def drag() -> None:
        nonlocal count
        count += 1
        session.parts.set_parameter(VALUE, 0.5 + STEP * count, dragging=True)
        print(f"{count} {time.monotonic():.3f}", flush=True)

    def begin_to_drag() -> None:
        nonlocal count, timer
        if session.busy or not len(session.drawing.document):
            return
        timer.stop()
        count = 0
        timer = QTimer(interval=TICK)
        timer.timeout.connect(drag)
        print("began", flush=True)
        timer.start()

    def begin() -> None:
        nonlocal timer
        if what == "drag":
            stylus.draw(circle(400.0, 300.0, 60.0, samples=40))
            timer = QTimer(interval=TICK)
            timer.timeout.connect(begin_to_drag)
        else:
            print("began", flush=True)
        timer.start()

    QTimer.singleShot(300, begin)
    return app.exec()


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
