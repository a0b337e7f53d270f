"""The program with its window, driven by a test in few words."""

from __future__ import annotations

import gc
from collections.abc import Callable
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any, Final

from PySide6.QtCore import QEvent, QSettings
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from bozzetto.document.links import resolved
from bozzetto.errors import UserError
from bozzetto.plugin.job import Job
from bozzetto.scene.display_list import Handle, Scene
from bozzetto.view.standard_views import standard_view
from bozzetto_app.main_window import Window
from bozzetto_app.session.session import Session
from bozzetto_app.session.window_faults import watch_window_faults
from bozzetto_app.startup import application
from bozzetto_app.testing.stylus import Stylus

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.geometry.shapes import Shapes
    from bozzetto.ink.stroke import Stroke
    from bozzetto.plugin.host.registry import Registry

__all__ = ["WindowShell"]

CANVAS: Final = (1200, 900)
"""Pixels of the sheet: those of the pen of the test kit."""

PATIENCE: Final = 60.0
"""Seconds after which work that does not end fails the test; a loaded machine needs some."""


class WindowShell:
    """Opens the window, takes tools, draws with a stylus, and reads what a person sees.

    Every method waits until the program has nothing left to do, or a motion plays. Strokes are
    those of the fixture ``pen``: the sheet has its size. A person who cannot have what they want
    reads why in `notices`, and nothing is raised.

    Parameters
    ----------
    registry : Registry
        The plugins.
    folder : Path
        For settings and recovery data.

    Attributes
    ----------
    window : Window
        The window itself.
    session : Session
        What it shows.
    notices : list of str
        What the person was told besides hints, oldest first.
    """

    def __init__(self, registry: Registry, folder: Path) -> None:
        application()
        for kind in (QSettings.Format.NativeFormat, QSettings.Format.IniFormat):
            QSettings.setPath(kind, QSettings.Scope.UserScope, str(folder / "settings"))
        self._folder = folder
        self.session = Session(registry)
        self.notices: list[str] = []
        self.session.notices.noticed.connect(lambda notice: self.notices.append(notice.text))
        self._end_watch = watch_window_faults(self.session)
        self.window = Window(self.session, folder / "recovery")
        self.window.canvas.motion.reduced = True
        self.window.show()
        self.settle()
        canvas, size = self.window.canvas, self.window.size()
        self.window.resize(
            size.width() + CANVAS[0] - canvas.width(), size.height() + CANVAS[1] - canvas.height()
        )
        self.settle()

    # -- what the hand does --

    def open(self, modeler: str) -> None:
        """Take a modeler: the next gesture begins an object of it."""
        self.session.toolbox.take_modeler(self.session.registry.resolve(modeler))
        self.settle()

    def take(self, tool: str) -> None:
        """Take a tool by its id."""
        self.session.toolbox.take_tool(tool)
        self.settle()

    def draw(self, *strokes: Stroke, lift: bool = True) -> None:
        """Draw strokes one after the other; with ``lift=False`` the pen stays down."""
        for stroke in strokes:
            stylus = Stylus(self.window.canvas, eraser=stroke.tool == "eraser")
            stylus.draw(stroke.points.tolist(), pressure=_firmness(stroke), lift=lift)
            self.settle()

    def hover(self, x: float, y: float) -> None:
        """Hold the pen near canvas pixels, without a touch; `shown` has what it previews."""
        Stylus(self.window.canvas).hover((x, y))
        self.settle()

    def tap(self, x: float, y: float) -> None:
        """Touch the sheet at canvas pixels."""
        stylus = Stylus(self.window.canvas)
        stylus.press((x, y))
        stylus.lift((x, y))
        self.settle()

    def drag(self, handle: str, path: Stroke) -> None:
        """Take a handle along a path.

        Raises
        ------
        UserError
            If no such handle is shown.
        """
        place = next((h.point for h in self.handles() if h.id == handle), None)
        if place is None:
            known = ", ".join(h.id for h in self.handles()) or "none"
            raise UserError(f"No handle {handle!r} is shown; there are: {known}.")
        pixels, _ = self.session.view.camera.project([place])
        firmness = _firmness(path)
        Stylus(self.window.canvas).draw(
            [*pixels.tolist(), *path.points.tolist()], pressure=[firmness[0], *firmness]
        )
        self.settle()

    def press(self, keys: str) -> None:
        """Press keys on the sheet, as "Ctrl+Z" or "Return"."""
        self.window.activateWindow()
        self.window.canvas.setFocus()
        QTest.keySequence(self.window.canvas, QKeySequence(keys))
        self.settle()

    def undo(self) -> None:
        """Take the last step back."""
        self.session.gestures.undo()
        self.settle()

    def look(self, view: str) -> None:
        """Look from a side: "front", "top", "three-quarter" …; see `STANDARD_VIEWS`."""
        self.session.view.set_camera(standard_view(self.session.view.camera, view))
        self.settle()

    def set(self, **values: object) -> None:
        """Change parameters of the selected object, each as one step."""
        for name, value in values.items():
            self.session.objects.set_parameter(name, value)
            self.settle()

    def use(self, modeler: str) -> None:
        """Use the selected object as input for a modeler: a new object is begun, and selected.

        It follows the object where its modeler can, and else begins with a copy of its shapes.
        """
        self.session.shapes.use_chosen(self.session.registry.resolve(modeler))
        self.settle()

    def choose(self, model_id: str) -> None:
        """Select an object by its id, that of a `model`."""
        self.session.selection.select(model_id)
        self.settle()

    def reopen(self) -> None:
        """Save the document, open it again, and select what was selected."""
        model, path = self.model, self._folder / "document.bozz"
        self.session.files.save(path)
        self.settle()
        self.session.files.open(path)
        self.settle()
        if model is not None:
            self.choose(model.id)

    # -- what there is --

    @property
    def hint(self) -> str:
        """The line that says what to do next."""
        return self.session.hints.step.sentence

    @property
    def model(self) -> Model | None:
        """The selected object, with its `id`, `name` and `state`; None while there is none."""
        return self.session.selection.model

    @property
    def state(self) -> Any:
        """The state of the selected object; None while there is none."""
        return None if self.model is None else self.model.state

    def shown(self) -> Scene:
        """Return all that is visible on the sheet, with the preview of a gesture that goes on."""
        return self.session.scene.visible.under(self.session.scene.live)

    def handles(self) -> tuple[Handle, ...]:
        """Return the handles that can be dragged now."""
        return tuple(item for _, item in self.shown().items() if isinstance(item, Handle))

    def shapes(self) -> Shapes:
        """Return what the selected object would hand over, with what it follows as it is now."""
        model = self.model
        known = [] if model is None else [resolved(self.session.drawing.document)[model.id]]
        return self.session.workbench.shapes(known, Job())

    # -- waiting --

    def settle(self) -> None:
        """Wait until the program has nothing left to do, or only moves what plays."""
        motion = self.session.gestures.motion
        for _ in range(2):  # an answer may be the reason for the next question
            self.wait_until(
                lambda: motion.is_playing or not (self.session.busy or self.window.keeper.busy)
            )

    def wait_until(self, condition: Callable[[], bool]) -> None:
        """Let the program go on until a condition holds.

        Raises
        ------
        TimeoutError
            If it does not within `PATIENCE`.
        """
        end = monotonic() + PATIENCE
        QApplication.processEvents()
        while not condition():
            if monotonic() > end:
                told = f"; it told: {self.notices[-1]}" if self.notices else ""
                raise TimeoutError(
                    f"what was waited for has not come within {PATIENCE:g} s: the program "
                    f"{'is still at work' if self.session.busy else 'has nothing left to do'}{told}"
                )
            QTest.qWait(2)

    def close(self) -> None:
        """Close the window without a question; nothing is saved."""
        self._end_watch()
        self.session.cancel_all()
        self.window.close_without_asking()
        self.window.keeper.wait()
        self.session.files.close()
        self.window.deleteLater()
        self.session.deleteLater()
        QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
        gc.collect()


def _firmness(stroke: Stroke) -> list[float]:
    """Return the pressure of each sample, at least a touch."""
    return [max(float(pressure), 0.01) for pressure in stroke.pressure]
