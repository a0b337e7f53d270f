"""Drags sliders of the bundled samples in a real window, and counts what is shown meanwhile."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PySide6.QtCore import QEvent, QObject, Qt, QTimer
from PySide6.QtWidgets import QApplication

from bozzetto.plugin.host.registry import Registry
from bozzetto_app.canvas.viewport.protocol import ViewportBackend
from bozzetto_app.canvas.viewport.software import SoftwareViewport
from bozzetto_app.main_window import Window
from bozzetto_app.session.session import Session

TICK = 16
"""Time between two values, ms: 60 in a second."""

MOST_WAITING = 60.0
"""Seconds that work may take before a drag counts as stuck."""

SAMPLES = (
    ("bozzetto.silhouette", "horse"),
    ("bozzetto.silhouette", "fish"),
    ("bozzetto.silhouette", "key"),
    ("bozzetto.symmetry", "boat"),
    ("bozzetto.car", "hatchback"),
    ("bozzetto.product", "mouse"),
    ("bozzetto.polyhedron", "house"),
)

SPANS = {"length": 0.1, "width": 0.1, "height": 0.1, "front_overhang": 0.1, "wheelbase": 0.1}
"""Parameters without ends that are dragged by this share about what the sample has."""


@dataclass(frozen=True)
class Dragged:
    """What was seen of one drag.

    Attributes
    ----------
    label : str
    ticks : int
        Values that the window took.
    frames : int
        Values that were shown before the release.
    followers : int
        Frames of other models meanwhile, which follow the one that was dragged.
    painted : int
        Pictures that the viewport has painted meanwhile.
    seconds, processor : float
        From press to release: by the clock, and of all threads.
    settled : float
        From the release to the last final picture, s.
    steps : int
        Steps of the history that it became.
    in_order, last_is_shown : bool
    """

    label: str
    ticks: int
    frames: int
    painted: int
    seconds: float
    processor: float
    settled: float
    steps: int
    in_order: bool
    last_is_shown: bool
    followers: int = 0


def pump(until: Callable[[], bool], limit: float = MOST_WAITING) -> None:
    """Turn the event loop until something holds."""
    end = time.monotonic() + limit
    while not until():
        QApplication.processEvents()
        time.sleep(0.0005)
        if time.monotonic() > end:
            raise TimeoutError("the window did not come to rest")


def settle(session: Session) -> None:
    """Wait until nothing is under way; an answer may be the reason for the next request."""
    for _ in range(3):
        pump(lambda: not session.busy)
        QApplication.processEvents()


def open_sample(modeler: str, stem: str, folder: Path) -> Window:
    """A window with a sample on its sheet."""
    session = Session(Registry())
    window = Window(session, folder)
    window.canvas.motion.reduced = True
    window.resize(1280, 800)
    window.show()
    settle(session)
    session.toolbox.take_modeler(modeler)
    settle(session)
    session.files.exchange.import_file(
        next(p for p in session.registry.info(modeler).samples if p.stem == stem)
    )
    settle(session)
    pump(lambda: window.docks.parameters.is_ready)
    return window


def close(window: Window) -> None:
    """Close a window without a question."""
    window.close_without_asking()
    window.deleteLater()
    window.session.deleteLater()
    QApplication.processEvents()


def sliders(window: Window) -> tuple[tuple[str, str], ...]:
    """The parameters that can be dragged: whose, and which."""
    rows = window.docks.parameters.form.rows
    return tuple(key for key, row in rows.items() if row.field.kind in ("number", "integer"))


class _Paintings(QObject):
    """Counts the pictures that a viewport paints; the same one again does not count."""

    def __init__(self, viewport: ViewportBackend) -> None:
        super().__init__()
        self.count = 0
        self._viewport = viewport
        self._last = 0
        viewport.widget.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if event.type() == QEvent.Type.Paint:
            is_software = isinstance(self._viewport, SoftwareViewport)
            now = self._viewport.shown().cacheKey() if is_software else self._last + 1
            self.count += now != self._last
            self._last = now
        return False


def drag(window: Window, key: tuple[str, str], seconds: float) -> Dragged:
    """Drag one parameter there and back at 60 values in a second, and let go."""
    session, row = window.session, window.docks.parameters.form.rows[key]
    model = session.selection.model
    assert model is not None
    low, high = _span(window, key)
    asked: list[Any] = []
    shown: list[Any] = []
    followers: list[str] = []

    def changed(model_id: str, solved: bool) -> None:
        if model_id != model.id:
            followers.append(model_id)
            return
        found = session.solver.shown(model_id)
        if found is not None and (not shown or shown[-1] is not found.state):
            shown.append(found.state)

    session.drawing.history.end_merge()
    before = len(session.drawing.history.entries)
    begun, spent = time.monotonic(), time.process_time()
    timer = QTimer()
    timer.setTimerType(Qt.TimerType.PreciseTimer)
    timer.setInterval(TICK)

    def tick() -> None:
        share = (time.monotonic() - begun) / seconds
        if share >= 1.0:
            timer.stop()
            return
        value = low + (high - low) * (0.05 + 0.9 * (1.0 - abs(1.0 - 2.0 * share)))
        row.changed.emit(round(value) if row.field.kind == "integer" else value, True)
        now = session.selection.model
        if now is not None and (not asked or asked[-1] is not now.state):
            asked.append(now.state)

    paintings = _Paintings(window.canvas.viewports.current)
    timer.timeout.connect(tick)
    session.solver.changed.connect(changed)
    timer.start()
    pump(lambda: not timer.isActive())
    passed, spent = time.monotonic() - begun, time.process_time() - spent
    frames, released, painted = len(shown), time.monotonic(), paintings.count
    following = len(followers)
    window.canvas.viewports.current.widget.removeEventFilter(paintings)
    row.drag_ended.emit()
    last = session.selection.model
    if last is not None and asked[-1] is not last.state:
        asked.append(last.state)  # what had waited for the next beat
    pump(lambda: not session.solver.busy)
    QApplication.processEvents()
    settled = time.monotonic() - released
    settle(session)
    session.solver.changed.disconnect(changed)
    numbers = {id(state): number for number, state in enumerate(asked)}
    order = [numbers[id(state)] for state in shown if id(state) in numbers]
    steps = len(session.drawing.history.entries) - before
    result = Dragged(
        row.field.parameter.label, len(asked), frames, painted, passed, spent, settled, steps,
        order == sorted(order), bool(shown) and shown[-1] is asked[-1], following,
    )  # fmt: skip
    return result


def drags(seconds: float, folder: Path, count: int | None = None) -> Iterator[tuple[str, Dragged]]:
    """Drag every slider of every sample, or the first of each."""
    for modeler, stem in SAMPLES:
        window = open_sample(modeler, stem, folder / stem)
        try:
            for key in sliders(window)[:count]:
                yield stem, drag(window, key, seconds)
        finally:
            close(window)


def _span(window: Window, key: tuple[str, str]) -> tuple[float, float]:
    """Between which values a parameter is dragged."""
    owner, name = key
    session = window.session
    asked = window.docks.parameters.form.rows[key].field.parameter
    if not asked.zero and asked.minimum is not None and asked.maximum is not None:
        return asked.minimum, asked.maximum
    found = session.parts.parameters if owner else session.objects.parameters
    now = next(float(value) for field, value in found if field.name == name)
    told = session.solver.report.get("dimensions", {}) if not now else {}
    now = now or float(told.get(name, 0.0)) or CAR.get(name, 100.0)
    share = SPANS.get(name, 0.1)
    return now * (1.0 - share), now * (1.0 + share)


CAR = {
    "length": 4000.0,
    "width": 1700.0,
    "height": 1450.0,
    "front_overhang": 750.0,
    "wheelbase": 2530.0,
}
"""Dimensions of a hatchback, mm, where a car does not say its own."""
