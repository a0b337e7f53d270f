"""A process that opens the window and draws until it is killed: for `test_keeping.py`.

Prints "began", then the number of strokes so far after the pen was lifted from each; none
of them is one that could be refused.
"""

from __future__ import annotations

import sys
from pathlib import Path

from PySide6.QtCore import QTimer

from bozzetto.plugin.host.registry import Registry
from bozzetto_app.main_window import Window
from bozzetto_app.session.session import Session
from bozzetto_app.startup import application
from tests.app.tablet import Stylus, circle

PACE = 150
"""Time between two strokes, ms: quicker than a hand."""


def main(recovery: str) -> int:
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

    def begin() -> None:
        print("began", flush=True)
        timer.start()

    QTimer.singleShot(300, begin)
    return app.exec()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
