"""What all makers of pictures share: writing them small, and a window that is drawn in."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import PIL.Image
    from PySide6.QtWidgets import QWidget

    from bozzetto_app.main_window import Window

HERE = Path(__file__).parent
PICTURES = HERE / "pictures"
GALLERY = HERE / "gallery"
PATIENCE = 60.0
"""Seconds that a solve may take."""

STILL = 2.0
"""Seconds in which nothing more comes from a worker."""

EXACT = 64
"""Colours that a picture keeps as they are, the most frequent ones."""


def save(pixels: object, name: str, folder: Path | None = None, *, smooth: bool = False) -> None:
    """Write a picture small enough for a repository.

    Smooth ones keep every colour, for shades over large faces would fall into steps.
    """
    import numpy as np
    from PIL import Image

    image = Image.fromarray(np.asarray(pixels)).convert("RGB")
    target = (folder or PICTURES) / name
    (image if smooth else reduced(image)).save(target, optimize=True)
    print(f"wrote {target.parent.name}/{name}")


def reduced(image: PIL.Image.Image) -> PIL.Image.Image:
    """The same picture in 256 colours, dithered: shades would fall into steps."""
    import numpy as np
    from PIL import Image

    # The papers and panels keep their very colours; the rest, few pixels of the accent too,
    # goes to what covers it best, where the usual median cut makes the accent brown.
    colors, counts = np.unique(np.asarray(image).reshape(-1, 3), axis=0, return_counts=True)
    common = colors[np.argsort(counts)[::-1][:EXACT]]
    covering = image.quantize(256 - len(common), Image.Quantize.MAXCOVERAGE).getpalette()
    palette = np.concatenate((common, np.reshape(covering, (-1, 3)))).astype(np.uint8)
    kept = Image.new("P", (1, 1))
    kept.putpalette(palette.ravel().tolist())
    return image.quantize(palette=kept, dither=Image.Dither.FLOYDSTEINBERG)


def pen_stroke(
    canvas: object, path: object, pressure: object, at_four_fifths: Callable[[], None]
) -> None:
    """One stroke of a simulated pen."""
    from PySide6.QtCore import QEvent, QPointF, Qt
    from PySide6.QtGui import QInputDevice, QPointingDevice, QTabletEvent
    from PySide6.QtWidgets import QApplication

    kind, able = QEvent.Type, QInputDevice.Capability
    pen = QPointingDevice(
        "pen",
        7,
        QInputDevice.DeviceType.Stylus,
        QPointingDevice.PointerType.Pen,
        able.Position | able.Pressure | able.Hover,
        1,
        3,
    )
    none, left = Qt.MouseButton.NoButton, Qt.MouseButton.LeftButton
    last = len(path) - 1
    for number, (x, y) in enumerate(path):
        place = QPointF(float(x), float(y))
        event = QTabletEvent(
            kind.TabletPress
            if number == 0
            else kind.TabletRelease
            if number == last
            else kind.TabletMove,
            pen,
            place,
            QPointF(canvas.mapToGlobal(place)),
            0.0 if number == last else float(pressure[number]),
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
            Qt.KeyboardModifier.NoModifier,
            left if number in (0, last) else none,
            none if number == last else left,
        )
        event.setTimestamp(1000 + 8 * number)
        QApplication.sendEvent(canvas, event)
        wait(0.002)
        if number == 4 * last // 5:
            wait(1.0)
            at_four_fifths()


def opened() -> Window:
    """The real window on light paper, at rest, with an empty sheet."""
    from bozzetto.plugin.host.registry import Registry
    from bozzetto_app.main_window import Window
    from bozzetto_app.session.session import Session
    from bozzetto_app.startup import application
    from bozzetto_app.style.theme import Theme

    application()
    window = Window(Session(Registry()), Path(tempfile.mkdtemp()))
    window.resize(1280, 800)
    window.set_theme(Theme.LIGHT)
    window.show()
    until(lambda: not window.session.busy)
    until_still(window)
    return window


def grab(widget: QWidget, name: str) -> None:
    """Save what a widget shows once its frames, which a worker draws, are there."""
    import numpy as np
    from PySide6.QtGui import QImage

    from bozzetto_app.canvas.viewport.software import SoftwareViewport

    viewports = widget.findChildren(SoftwareViewport)
    until(lambda: not any(viewport.is_waiting for viewport in viewports))
    image = widget.grab().toImage().convertToFormat(QImage.Format.Format_RGBA8888)
    pixels = np.frombuffer(image.constBits(), np.uint8)
    save(pixels.reshape(image.height(), image.width(), 4), name)


def wait(seconds: float) -> None:
    """Let the window live for a while."""
    from PySide6.QtWidgets import QApplication

    end = time.monotonic() + seconds
    while time.monotonic() < end:
        QApplication.processEvents()
        time.sleep(0.002)


def until(true: Callable[[], bool]) -> None:
    """Let the window live until something is so."""
    end = time.monotonic() + PATIENCE
    while not true():
        if time.monotonic() > end:
            raise TimeoutError("the window did not come to rest")
        wait(0.02)


def until_still(widget: QWidget) -> None:
    """Let the window live until a widget has looked the same for a while.

    What workers bring, as tools and the pictures of samples, is there then.
    """
    before = None
    while before != (before := widget.grab().toImage()):
        wait(STILL)
