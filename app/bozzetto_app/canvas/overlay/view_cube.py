"""The view cube: where we look from, and the way to anywhere else."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QEnterEvent,
    QFont,
    QMouseEvent,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPen,
    QPolygonF,
    QTransform,
)
from PySide6.QtWidgets import QAbstractButton, QWidget

from bozzetto.scene.contrast import mixed
from bozzetto.scene.palette import LIGHT, Palette
from bozzetto.view.camera import Camera, Point
from bozzetto.view.navigation import orbit
from bozzetto_app.canvas.overlay.cube_geometry import (
    Face,
    SeenFace,
    direction_at,
    patch,
    seen_faces,
)
from bozzetto_app.i18n import tr
from bozzetto_app.style.colors import tones_of
from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import qcolor

__all__ = ["ViewCube"]

SIZE: Final = 84
"""Side of the square in which the cube turns, pixels."""

HALF_EDGE: Final = 24.0
"""Half an edge of the cube, pixels: its corners stay inside at any turn."""

BUTTON: Final = 28
GAP: Final = 4
DRAG_TRAVEL: Final = 4.0
"""Movement beyond which a press turns the view instead of choosing a side, pixels."""

TURN_FACTOR: Final = 1.6
"""The cube is small: its drags turn further than those on the sheet."""

LABEL_PIXELS: Final = 12


def _label(name: str) -> str:
    return {
        "front": tr("ViewCube", "Front"),
        "back": tr("ViewCube", "Back"),
        "left": tr("ViewCube", "Left"),
        "right": tr("ViewCube", "Right"),
        "top": tr("ViewCube", "Top"),
        "bottom": tr("ViewCube", "Bottom"),
    }[name]


class CubeButton(QAbstractButton):
    """A quiet button with an icon of the family, legible on whatever lies under it."""

    def __init__(self, icon: str, name: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.icon_name = icon
        self.colors: Palette = LIGHT
        self.setAccessibleName(name)
        self.setToolTip(name)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setAttribute(Qt.WidgetAttribute.WA_Hover)
        self.resize(BUTTON, BUTTON)

    def sizeHint(self) -> QSize:
        return QSize(BUTTON, BUTTON)

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        tones = tones_of(self.colors)
        ground = QRectF(self.rect()).adjusted(1, 1, -1, -1)
        # A ground of its own: beneath may lie a picture on white paper, in the dark theme, too.
        painter.setPen(QPen(qcolor(tones.hairline), 1.0))
        lit = tones.press if self.isDown() else tones.hover if self.underMouse() else tones.panel
        painter.setBrush(qcolor(lit))
        painter.drawRoundedRect(ground, 6, 6)
        if self.hasFocus():
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(qcolor(tones.accent), 1.5))
            painter.drawRoundedRect(ground, 6, 6)
        side = 18.0
        place = QRectF((self.width() - side) / 2, (self.height() - side) / 2, side, side)
        color = tones.text if self.underMouse() else tones.quiet
        paint_icon(painter, self.icon_name, place, color)
        painter.end()


class ViewCube(QWidget):
    """A small cube that turns with the view.

    Signals
    -------
    direction_chosen : (x, y, z)
        Outward direction of the face, edge or corner that was clicked.
    turned : Camera
        The view after a drag on the cube.
    home_chosen, projection_chosen
        The buttons beneath.
    """

    direction_chosen = Signal(object)
    turned = Signal(object)
    home_chosen = Signal()
    projection_chosen = Signal()

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName(tr("ViewCube", "View cube"))
        self.setToolTip(tr("ViewCube", "Click a side to look at it; drag to turn."))
        self.setMouseTracking(True)
        self.setCursor(Qt.CursorShape.ArrowCursor)
        self.setFixedSize(SIZE, SIZE + GAP + BUTTON)
        self._palette: Palette = LIGHT
        self._camera = Camera()
        self._names: Mapping[str, str] = {}
        self._hot: Point | None = None
        self._pressed: tuple[QPointF, Camera] | None = None
        self._dragging = False
        self.home_button = CubeButton("home", tr("ViewCube", "Show everything"), self)
        self.projection_button = CubeButton("perspective", "", self)
        left = (SIZE - 2 * BUTTON - GAP) // 2
        self.home_button.move(left, SIZE + GAP)
        self.projection_button.move(left + BUTTON + GAP, SIZE + GAP)
        self.home_button.clicked.connect(lambda: self.home_chosen.emit())
        self.projection_button.clicked.connect(lambda: self.projection_chosen.emit())
        self.set_camera(self._camera)

    def set_colors(self, palette: Palette) -> None:
        """Use the colours of a theme."""
        self._palette = palette
        for button in (self.home_button, self.projection_button):
            button.colors = palette
            button.update()
        self.update()

    def name_sides(self, sides: Mapping[str, str]) -> None:
        """Call sides as an object does: its own names, and the world's for each."""
        named = {world: own for own, world in sides.items()}
        if named != self._names:
            self._names = named
            self.update(0, 0, SIZE, SIZE)

    def label_of(self, face: Face) -> str:
        """Return the name by which a face is called now."""
        return self._names.get(face.name, face.name)

    def set_camera(self, camera: Camera) -> None:
        """Turn with a camera."""
        self._camera = camera
        flat = camera.kind == "orthographic"
        name = (
            tr("ViewCube", "Change to perspective")
            if flat
            else tr("ViewCube", "Change to parallel projection")
        )
        if self.projection_button.accessibleName() != name:
            self.projection_button.icon_name = "orthographic" if flat else "perspective"
            self.projection_button.setAccessibleName(name)
            self.projection_button.setToolTip(name)
            self.projection_button.update()
        self.update(0, 0, SIZE, SIZE)

    # -- pointing -----------------------------------------------------------------------------

    def direction_under(self, place: QPointF) -> Point | None:
        """Outward direction of what lies under a place of the widget."""
        middle = SIZE / 2.0
        return direction_at(
            self._camera, (place.x() - middle) / HALF_EDGE, (place.y() - middle) / HALF_EDGE
        )

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton:
            self._pressed = (event.position(), self._camera)
            self._dragging = False

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        if self._pressed is None:
            self._heat(self.direction_under(event.position()))
            return
        start, camera = self._pressed
        moved = event.position() - start
        if moved.manhattanLength() > DRAG_TRAVEL:
            self._dragging = True
            self._heat(None)
        if self._dragging:
            self.turned.emit(orbit(camera, TURN_FACTOR * moved.x(), TURN_FACTOR * moved.y()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        if event.button() != Qt.MouseButton.LeftButton or self._pressed is None:
            return
        self._pressed = None
        direction = self.direction_under(event.position())
        if not self._dragging and direction is not None:
            self.direction_chosen.emit(direction)
        self._dragging = False

    def enterEvent(self, event: QEnterEvent) -> None:
        self.update()

    def leaveEvent(self, event: QEvent) -> None:
        self._heat(None)

    def _heat(self, direction: Point | None) -> None:
        if direction != self._hot:
            self._hot = direction
            over = Qt.CursorShape.PointingHandCursor if direction else Qt.CursorShape.ArrowCursor
            self.setCursor(over)
            self.update(0, 0, SIZE, SIZE)

    # -- painting -----------------------------------------------------------------------------

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(SIZE / 2.0, SIZE / 2.0)
        for seen in seen_faces(self._camera):
            self._paint_face(painter, seen)
        painter.end()

    def _paint_face(self, painter: QPainter, seen: SeenFace) -> None:
        palette = self._palette
        light = 0.35 + 0.65 * seen.facing
        top = mixed(palette.clay, palette.panel, 0.55)
        low = mixed(palette.faint, palette.panel, 0.55)
        corners = [seen.place(u, v) for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        outline = _polygon(corners)
        painter.setPen(QPen(qcolor(mixed(palette.ink, palette.panel, 0.45)), 1.0))
        painter.setBrush(qcolor(mixed(top, low, light)))
        painter.drawPolygon(outline)
        if self._hot is not None:
            area = patch(seen, self._hot)
            if area is not None:
                painter.setPen(Qt.PenStyle.NoPen)
                painter.setBrush(qcolor(palette.accent, 0.85))
                painter.drawPolygon(_polygon(area))
        self._paint_label(painter, seen)

    def _paint_label(self, painter: QPainter, seen: SeenFace) -> None:
        if seen.facing < 0.3:
            return
        font = QFont(self.font())
        font.setPixelSize(LABEL_PIXELS)
        font.setWeight(QFont.Weight.DemiBold)
        path = QPainterPath()
        path.addText(0, 0, font, _label(self.label_of(seen.face)))
        box = path.boundingRect()
        fit = min(1.0, 1.66 * HALF_EDGE / max(box.width(), 1.0)) / HALF_EDGE
        # Letters are drawn in pixels, y down; a face has half edges, v up.
        place = QTransform(
            HALF_EDGE * float(seen.across[0]), HALF_EDGE * float(seen.across[1]),
            -HALF_EDGE * float(seen.above[0]), -HALF_EDGE * float(seen.above[1]),
            HALF_EDGE * float(seen.middle[0]), HALF_EDGE * float(seen.middle[1]),
        )  # fmt: skip
        centre = QTransform.fromTranslate(-box.center().x(), -box.center().y())
        letters = (centre * QTransform.fromScale(fit, fit) * place).map(path)
        chosen = self._hot is not None and tuple(self._hot) == tuple(seen.face.outward)
        palette = self._palette
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(qcolor(tones_of(palette).on_accent if chosen else palette.ink))
        painter.drawPath(letters)


def _polygon(places: Any) -> QPolygonF:
    return QPolygonF([QPointF(HALF_EDGE * float(x), HALF_EDGE * float(y)) for x, y in places])
