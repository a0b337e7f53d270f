"""A process that opens the window and draws until it is killed: for `test_keeping.py`.

Prints "began", then the number of strokes so far after the pen was lifted from each.
"""

from __future__ import annotations

import sys
from pathlib import Path

from PySide6.QtCore import QTimer

from bozzetto.plugin.registry import Registry
from bozzetto_app.session import Session
from bozzetto_app.start import application
from bozzetto_app.window import Window
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
        share = 0.5 if count % 4 == 3 else 1.0  # every fourth one waits for its other half
        stylus.draw(circle(520.0, 350.0, 60.0 + 5 * (count % 20), samples=40, share=share))
        count += 1
        if count % 3 == 0:
            session.commit_pending()
        print(count, flush=True)

    timer = QTimer(interval=PACE)
    timer.timeout.connect(draw)

    def begin() -> None:
        print("began", flush=True)
        timer.start()

    QTimer.singleShot(300, begin)
    return app.exec()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
