"""The GL viewport: pyqtgraph's view with batched items of our own.

pyqtgraph brings the widget, the tree of items and the order of drawing; camera, buffers and
shaders are ours: one pair of buffers for each kind of item in a layer, uploaded once for
every `Layer.revision`.
"""

from __future__ import annotations

import logging
import math
from time import perf_counter
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray
from OpenGL import GL
from pyqtgraph.opengl import GLViewWidget
from PySide6.QtCore import Qt, QTimer, Signal
from PySide6.QtGui import QImage, QMatrix4x4, QPainter, QResizeEvent, QSurfaceFormat
from PySide6.QtWidgets import QWidget

from bozzetto.scene.contrast import mixed
from bozzetto.scene.display_list import EMPTY, Image, Layer, Lines, Points, Scene
from bozzetto.scene.grid import GROUND as GROUND_LAYER
from bozzetto.scene.grid import ground_grid, ground_height
from bozzetto.scene.palette import LIGHT, Color, Palette
from bozzetto.scene.renderer.shading import SHADINGS
from bozzetto.scene.renderer.surfaces import shown_texture
from bozzetto.view.camera import Camera
from bozzetto.view.gl_matrices import gl_matrices, near_far
from bozzetto_app.canvas.viewport import opengl_buffers as buffers
from bozzetto_app.canvas.viewport.label_overlay import MarksSheet, paint_marks
from bozzetto_app.canvas.viewport.opengl_items import (
    BatchItem,
    Frame,
    GlassItem,
    LineItem,
    PictureItem,
    Programs,
    SurfaceItem,
)

if TYPE_CHECKING:
    from bozzetto.scene.display_list import Shaded
    from bozzetto_app.canvas.viewport.opengl_buffers import Batch
    from bozzetto_app.canvas.viewport.protocol import Shading

__all__ = ["GLViewport", "layer_items"]

log = logging.getLogger(__name__)

SURFACES, GROUND, PICTURES, GLASS, LINES, DOTS = range(6)
"""The passes of a picture, in order; ink lies over everything that is not in front of it."""

GROUND_NEAR: Final = 0.02
"""Nearest part of the ground that is shown, as a part of the distance to the target."""

LINE_BIAS: Final = 2.0
"""How far lines are brought towards the eye, so that surfaces they lie on do not eat them;
in pixel sizes at their depth, as in the software renderer."""

CONTOUR: Final = 0.8
"""Share of ink in the contour line; the rest is clay."""

READ_BACK_INTERVAL: Final = 0.15
"""Least time between two pictures read back for the loupe, seconds: each takes milliseconds."""

NEAR_ENOUGH: Final = 4
"""Difference of a colour read back from the one painted that still proves that it works."""


def _unit(color: Color) -> tuple[float, float, float]:
    red, green, blue = color
    return red / 255.0, green / 255.0, blue / 255.0


def layer_items(layer: Layer, palette: Palette, shading: Shading) -> list[BatchItem]:
    """Return the items that draw a layer."""
    made: list[BatchItem] = []
    solid, glass = buffers.opaque_surfaces(layer), buffers.glass_surfaces(layer)
    if shading == "xray":
        solid, glass = [], [*solid, *glass]
    plain = [item for item in solid if shown_texture(item, shading) is None]
    wrapped = [[item] for item in solid if shown_texture(item, shading) is not None]
    for together in [plain, *wrapped] if plain else wrapped:
        made.append(SurfaceItem(*_mesh_batch(together, palette, shading), SURFACES))
    for pane in glass:
        made.append(GlassItem(*_mesh_batch([pane], palette, shading), GLASS))
    for hidden in buffers.HIDDEN_KINDS:
        lines = [i for i in layer.items if isinstance(i, Lines) and i.hidden == hidden]
        if lines:
            order = GROUND if layer.name == GROUND_LAYER else LINES
            made.append(LineItem("strip", buffers.strips(lines, palette), order, hidden))
        points = [
            i for i in layer.items if isinstance(i, Points) and i.hidden == hidden and len(i.points)
        ]
        if points:
            made.append(LineItem("dot", buffers.dots(points, palette), DOTS, hidden))
    for item in layer.items:
        if isinstance(item, Image):
            made.append(PictureItem(buffers.picture(item), PICTURES, item))
    return made


def _mesh_batch(
    items: list[Shaded], palette: Palette, shading: Shading
) -> tuple[Batch, NDArray[np.uint8] | None]:
    """Return the buffers of meshes, and the pixels of the texture of the only one, if it has."""
    texture = shown_texture(items[0], shading)
    if texture is None:
        return buffers.surface(items, palette, shading), None
    return buffers.textured_surface(items[0], texture, palette, shading), texture.pixels


class GLViewport(GLViewWidget):  # type: ignore[misc]
    """Shows a scene with OpenGL.

    Signals
    -------
    proved
        A first picture was made, read back, and found to be right.
    painted
        The newest scene is painted.
    failed : str
        OpenGL does not do what it should; the reason.
    """

    proved = Signal()
    painted = Signal()
    failed = Signal(str)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent, rotationMethod="quaternion")
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.frame = Frame()
        self.programs = Programs(core=False)
        self._scene: Scene = EMPTY
        self._live: Scene = EMPTY
        self._camera = Camera()
        self._palette: Palette = LIGHT
        self._shading: Shading = "clay"
        self._grid = True
        self._bounds = np.full((2, 3), np.nan)
        self._shown: dict[tuple[Any, ...], list[BatchItem]] = {}
        self._renderer = ""
        self._is_proved = False
        self._blank = False
        self._broken = False
        self._read_back = QImage()
        self._is_newer = True
        self._read_back_at = -math.inf
        self._marks = MarksSheet(self)

    # -- ViewportBackend ----------------------------------------------------------------------

    @property
    def widget(self) -> QWidget:
        """The viewport itself."""
        return self

    def set_scene(self, scene: Scene, *, moving: bool = False) -> None:
        """Show this scene."""
        if scene is not self._scene:
            self._scene = scene
            self._changed()

    def set_live(self, scene: Scene) -> None:
        """Show this on top, or in place of layers, for as long as the pen is down."""
        if scene is not self._live:
            self._live = scene
            self._changed()

    def set_camera(self, camera: Camera) -> None:
        """Look through this camera."""
        self._camera = camera
        self._is_newer = True
        self._place_ground()
        self._show_marks()
        self.update()

    def set_palette(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._palette = palette
        self.setBackgroundColor(palette.paper)
        self._changed()

    def set_style(self, shading: Shading, grid: bool) -> None:
        """Say how surfaces are shaded and whether the ground is shown."""
        self._shading, self._grid = shading, grid
        self._changed()

    def grab(self) -> QImage:
        """Return the picture as it is now, at full resolution."""
        image: QImage = self.grabFramebuffer()
        image.setDevicePixelRatio(self.devicePixelRatioF())
        painter = QPainter(image)
        painter.setFont(self.font())
        paint_marks(painter, self._scene.under(self._live), self._seen(), self._palette)
        painter.end()
        return image

    def shown(self) -> QImage:
        """Return the picture on the screen; it is read back now and then if it has changed."""
        now = perf_counter()
        if self._is_newer and now - self._read_back_at > READ_BACK_INTERVAL:
            self._read_back, self._read_back_at = self.grab(), now
            self._is_newer = False
        return self._read_back

    def describe(self) -> str:
        """Return the name of the renderer."""
        return f"OpenGL ({self._renderer})" if self._renderer else "OpenGL"

    def release(self) -> None:
        """Give back what lies on the card; contexts share it, so it outlives this one."""
        if not self.isValid():
            return
        self.makeCurrent()
        for items in self._shown.values():
            for item in items:
                item.free()
        self.programs.free()
        self.doneCurrent()

    # -- the layers on the card -----------------------------------------------------------------

    def _seen(self) -> Camera:
        return self._camera.with_viewport(max(self.width(), 1), max(self.height(), 1))

    def _changed(self) -> None:
        self._is_newer = True
        both = self._scene.under(self._live)
        self._bounds = both.bounds()
        wanted = {
            (layer.revision, self._palette.name, self._shading): layer for layer in both.layers
        }
        self._drop([key for key in self._shown if key not in wanted and key[0] != GROUND_LAYER])
        for key, layer in wanted.items():
            if key not in self._shown:
                self._add(key, layer)
        self._place_ground()
        self._show_marks()
        self.update()

    def _ground(self) -> Scene:
        """Draw the grid under the objects, unless it is switched off."""
        if not self._grid:
            return Scene()
        return Scene((ground_grid(self._seen(), ground_height(self._scene.bounds())),))

    def _place_ground(self) -> None:
        lines = [item for _, item in self._ground().items() if isinstance(item, Lines)]
        key = (GROUND_LAYER, self._palette.name, *(line.points.tobytes() for line in lines))
        if key not in self._shown:
            self._drop([known for known in self._shown if known[0] == GROUND_LAYER])
            self._add(key, Layer(GROUND_LAYER, tuple(lines)))

    def _add(self, key: tuple[Any, ...], layer: Layer) -> None:
        items = layer_items(layer, self._palette, self._shading)
        self._shown[key] = items
        for item in items:
            self.addItem(item)

    def _drop(self, keys: list[tuple[Any, ...]]) -> None:
        gone = [item for key in keys for item in self._shown.pop(key)]
        if not gone:
            return
        if self.isValid():
            self.makeCurrent()
        for item in gone:
            if self.isValid():
                item.free()
            self.removeItem(item)
        if self.isValid():
            self.doneCurrent()

    def _show_marks(self) -> None:
        self._marks.show_marks(self._scene.under(self._live), self._seen(), self._palette)

    # -- pyqtgraph ----------------------------------------------------------------------------

    def initializeGL(self) -> None:
        """Start over in a context that is new, or new again after the widget moved."""
        profile = self.context().format().profile()
        core = profile == QSurfaceFormat.OpenGLContextProfile.CoreProfile
        self.programs = Programs(core=core)
        for items in self._shown.values():
            for item in items:
                item.forget()
        name = GL.glGetString(GL.GL_RENDERER)
        self._renderer = name.decode(errors="replace") if name else ""
        super().initializeGL()

    def viewMatrix(self) -> QMatrix4x4:
        """World to eye."""
        return QMatrix4x4(self.frame.view.ravel().tolist())

    def projectionMatrix(self, region: Any, viewport: Any) -> QMatrix4x4:
        """Eye to clip coordinates."""
        return QMatrix4x4(self.frame.projection.ravel().tolist())

    def paintGL(self) -> None:
        """Draw the picture; errors are signalled, not printed."""
        if self._broken:
            return
        try:
            self._prepare_frame()
            super().paintGL()
            _check_errors()
        except Exception as problem:  # whatever a driver may throw: the software viewport helps
            self._broken = True
            log.exception("the GL viewport cannot draw")
            self.failed.emit(str(problem))
            return
        if not self._is_proved and not self._blank:
            QTimer.singleShot(0, self, self._prove)
        self.painted.emit()

    def drawItemTree(self, item: Any = None, useItemNames: bool = False) -> None:
        """Draw the items in order; unlike pyqtgraph's, errors pass."""
        if self._blank:
            return
        for each in sorted(self.items, key=lambda each: each.depthValue()):
            if self.default_vao.isCreated():
                self.default_vao.bind()
            each.paint()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._is_newer = True
        self._marks.setGeometry(self.rect())
        self._place_ground()  # the lines' distance depends on the scale
        self._show_marks()

    def _prepare_frame(self) -> None:
        camera = self._seen()
        near, far = near_far(camera, self._bounds)
        if self._grid:
            # The ground may reach behind the eye; it shall not cost the model its depth.
            ground_near, ground_far = near_far(camera, self._ground().bounds())
            parallel = camera.kind == "orthographic"
            near = min(near, ground_near if parallel else GROUND_NEAR * camera.distance)
            far = max(far, ground_far)
        view, projection = gl_matrices(camera, near, far)
        frame = self.frame
        frame.number += 1
        frame.view = view.astype(np.float32)
        frame.projection = projection.astype(np.float32)
        frame.size = (float(self.width()), float(self.height()))
        frame.pixels_per_mm = camera.pixels_per_mm
        frame.parallel = camera.kind == "orthographic"
        frame.ink = _unit(self._palette.ink)
        frame.contour = _unit(mixed(self._palette.ink, self._palette.clay, CONTOUR))
        pixel = 1.0 / camera.pixels_per_mm  # mm at the target
        frame.bias = (
            (1.0, LINE_BIAS * pixel)
            if frame.parallel
            else (1.0 - LINE_BIAS * pixel / camera.distance, 0.0)
        )
        frame.shading = SHADINGS.index(self._shading)

    def _prove(self) -> None:
        """Make an empty picture and look whether it has the colour of the paper."""
        if self._is_proved or self._broken:
            return
        self._blank = True
        image = self.grabFramebuffer()
        self._blank = False
        if not self.isValid() or image.isNull():
            self.failed.emit("no picture")
            return
        color = image.pixelColor(image.width() // 2, image.height() // 2)
        read = np.array((color.red(), color.green(), color.blue()))
        if np.abs(read - np.array(self._palette.paper)).max() > NEAR_ENOUGH:
            self.failed.emit(f"painted {self._palette.paper}, read back {tuple(read.tolist())}")
            return
        self._is_proved = True
        self.update()
        self.proved.emit()


def _check_errors() -> None:
    """Raise `RuntimeError` if OpenGL could not do something since this was asked last."""
    found = GL.glGetError()
    if found != GL.GL_NO_ERROR:
        raise RuntimeError(f"OpenGL error {found:#06x}")
