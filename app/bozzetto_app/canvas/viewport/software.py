"""The software viewport: frames of the core's renderer, made beside the window's thread.

The newest request wins. While the view turns, or while what is shown changes faster than frames
can be made, frames are rendered smaller, and sharpened once there is rest. A full frame that has
taken long already is abandoned for a newer request; a smaller one never is, so that there is
always something to see.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF, Qt, QTimer, Signal
from PySide6.QtGui import QImage, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QWidget

from bozzetto.errors import Cancelled
from bozzetto.plugin.job import Job
from bozzetto.scene.display_list import EMPTY, Scene
from bozzetto.scene.palette import LIGHT, Palette
from bozzetto.view.camera import Camera
from bozzetto_app.style.theme import fill
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto_app.canvas.viewport.protocol import Shading

__all__ = ["SoftwareViewport"]

REST: Final = 120
"""How long the view must rest before a frame is sharpened, milliseconds."""

DRAG_REST: Final = 250
"""The same of a shape that is dragged, milliseconds, at least: frames come as slowly as it is
solved, and a frame that is sharpened between two of them delays the second."""

SLOWER: Final = 1.5
"""How many times as long as the time between two such shapes that rest is."""

NEXT: Final = 1000.0
"""Longest time between two shapes of one drag, milliseconds."""

FAST_ENOUGH: Final = 0.045
"""Longest time of a full frame with which turning still feels smooth, seconds."""

PATIENCE: Final = 0.1
"""How long a full frame goes on while a newer one is wanted, seconds."""

COARSE: Final = (0.3, 0.6)
"""Least and greatest resolution of a frame while something moves and full ones are too slow."""


def to_image(pixels: NDArray[np.uint8], scale: float) -> QImage:
    """Return a QImage with its own copy of RGBA pixels, shape (h, w, 4)."""
    rows = np.ascontiguousarray(pixels)
    height, width = rows.shape[:2]
    image = QImage(
        rows.data, width, height, 4 * width, QImage.Format.Format_RGBA8888
    ).convertToFormat(QImage.Format.Format_RGB32)
    image.setDevicePixelRatio(scale)
    return image


def coarseness(frame_time: float) -> float:
    """Return the resolution at which a frame is fast enough, as a share of the full one.

    Parameters
    ----------
    frame_time : float
        What a full frame takes, seconds; it is taken to grow with the pixels.
    """
    least, most = COARSE
    return float(np.clip(np.sqrt(FAST_ENOUGH / max(frame_time, FAST_ENOUGH)), least, most))


class SoftwareViewport(QWidget):
    """Shows frames made by `bozzetto.scene.renderer.render`.

    Signals
    -------
    first_painted
        The widget has been painted once.
    painted : int
        A frame is painted; how many newer scenes are on their way.
    """

    first_painted = Signal()
    painted = Signal(int)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self._scene: Scene = EMPTY
        self._live: Scene = EMPTY
        self._camera = Camera()
        self._palette: Palette = LIGHT
        self._shading: Shading = "clay"
        self._grid = True
        self._frame = QImage()
        self._frame_time = 0.0
        # Time of a full frame with one sample a pixel per time of an antialiased one.
        self._one_sample = 1.0
        self._share = COARSE[1]
        self._asked = 0
        self._scenes = self._scenes_shown = 0
        self._moved_at = 0.0
        self._was_overtaken = False
        self._was_painted = False
        self._channel = Channel("frames", parent=self)
        self._rest = QTimer(self, singleShot=True, interval=REST)
        self._rest.timeout.connect(self._sharpen)
        self._soon = QTimer(self, singleShot=True, interval=0)
        self._soon.timeout.connect(self._request)

    # -- ViewportBackend ----------------------------------------------------------------------

    @property
    def widget(self) -> QWidget:
        """The viewport itself."""
        return self

    def set_scene(self, scene: Scene, *, moving: bool = False) -> None:
        """Show this scene, coarsely while it moves and fine frames are too slow."""
        if scene is not self._scene:
            if moving:
                now = perf_counter()
                passed, self._moved_at = 1000.0 * (now - self._moved_at), now
                pace = SLOWER * passed if passed < NEXT else 0.0
                self._wait_for_rest(max(DRAG_REST, round(pace)))
                # Who solves the next shape needs the processor more than the picture does.
                self._share = min(self._share, coarseness(self._frame_time))
            elif self._rest.remainingTime() > REST:
                self._rest.start(REST)
            self._scene = scene
            self._scenes += 1
            self._ask()

    def set_live(self, scene: Scene) -> None:
        """Show this on top, or in place of layers, for as long as the pen is down."""
        if scene is not self._live:
            self._live = scene
            self._ask()

    def set_camera(self, camera: Camera) -> None:
        """Look through this camera."""
        if camera != self._camera:
            self._camera = camera
            self._wait_for_rest(REST)
            self._ask()

    def set_palette(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._palette = palette
        self._ask()

    def set_style(self, shading: Shading, grid: bool) -> None:
        """Say how surfaces are shaded and whether the ground is shown."""
        self._shading, self._grid = shading, grid
        self._ask()

    def grab(self) -> QImage:  # type: ignore[override]
        """Return the picture as it is now, at full resolution."""
        scale = self.devicePixelRatioF()
        return to_image(self._work(scale)(Job()), scale)

    def shown(self) -> QImage:
        """Return the newest frame."""
        return self._frame

    def describe(self) -> str:
        """Return the name of the renderer."""
        return "Software renderer (NumPy)"

    def release(self) -> None:
        """Do nothing: nothing outlives the widget."""

    # -- frames -------------------------------------------------------------------------------

    @property
    def is_waiting(self) -> bool:
        """Whether a newer frame than the one shown is on its way."""
        return self._soon.isActive() or self._channel.busy or self._rest.isActive()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        if self._frame.isNull():
            fill(painter, event.rect(), self._palette.paper)
        else:
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
            painter.drawImage(QRectF(self.rect()), self._frame)
        painter.end()
        if not self._was_painted:
            self._was_painted = True
            self.first_painted.emit()
            # The renderer is imported once all of the window is painted.
            QTimer.singleShot(0, self, self._ask)
        self.painted.emit(self._scenes - self._scenes_shown)

    def resizeEvent(self, event: QResizeEvent) -> None:
        self._ask()

    def _ask(self) -> None:
        """Request a frame once all that changes together has changed, such as scene and view."""
        self._soon.start()

    def _request(self) -> None:
        """Request a frame of what is to be shown now."""
        if self.width() < 2 or self.height() < 2 or not self._was_painted:
            return  # the first paint asks again
        if self._was_overtaken:
            self._wait_for_rest(REST)
        scale = self.devicePixelRatioF()
        coarse = self._rest.isActive() and self._frame_time > FAST_ENOUGH
        self._asked += 1
        if coarse:  # the resolution does not rise and fall within one motion
            self._share = min(self._share, coarseness(self._one_sample * self._frame_time))
        share = self._share if coarse else 1.0
        work = self._work(
            share * scale, antialias=not coarse, number=None if coarse else self._asked
        )
        begun, scenes = perf_counter(), self._scenes

        def done(pixels: NDArray[np.uint8]) -> None:
            spent = perf_counter() - begun
            if coarse:
                found = min(spent / (share**2 * self._frame_time), 1.0)
                self._one_sample += 0.5 * (found - self._one_sample)
            else:
                self._frame_time, self._share = spent, COARSE[1]
                self._was_overtaken = False
            self._frame, self._scenes_shown = to_image(pixels, 1.0), scenes
            self.update()

        self._channel.submit(Request(work, done, self._failed))

    def _wait_for_rest(self, time: int) -> None:
        """Sharpen the frame when nothing has moved for some time, milliseconds, from now on."""
        self._rest.start(max(time, self._rest.remainingTime()))

    def _sharpen(self) -> None:
        """Request a full frame, now that there is rest."""
        self._was_overtaken = False
        self._ask()

    def _work(
        self, scale: float, *, antialias: bool = True, number: int | None = None
    ) -> Callable[[Job], NDArray[np.uint8]]:
        """Return a function for a worker that renders what is set now.

        A frame with a number is abandoned if it takes long and a later one is asked for.
        """
        size = (self.width(), self.height())
        camera = self._camera.with_viewport(*size)
        solid, live, grid = self._scene, self._live, self._grid
        palette, shading = self._palette, self._shading

        def work(job: Job) -> NDArray[np.uint8]:
            begun = perf_counter()

            def checkpoint() -> None:
                spent = perf_counter() - begun
                if number is not None and number != self._asked and spent > PATIENCE:
                    self._was_overtaken = True
                    self._frame_time = max(self._frame_time, spent)
                    raise Cancelled("a newer frame is wanted")
                job.checkpoint(0.0, "frame")

            # Not needed for the first paint of the window, which is the empty sheet.
            from bozzetto.scene.grid import ground_grid, ground_height
            from bozzetto.scene.renderer import render

            scene = solid.under(live)
            if grid:
                ground = ground_grid(camera, ground_height(solid.bounds()))
                scene = Scene((ground, *scene.layers))
            return render(
                scene,
                camera,
                palette,
                size=size,
                scale=scale,
                shading=shading,
                antialias=antialias,
                checkpoint=checkpoint,
            )

        return work

    @staticmethod
    def _failed(error: BaseException) -> None:
        raise error
