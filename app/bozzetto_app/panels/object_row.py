"""Rows of the object list: a model, an underlay."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QEnterEvent,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPen,
)
from PySide6.QtWidgets import QHBoxLayout, QLabel, QLineEdit, QSizePolicy, QWidget

from bozzetto.document.model import Model, Underlay
from bozzetto_app.panels.icon_button import IconButton
from bozzetto_app.panels.slider import Slider
from bozzetto_app.panels.swatch import Swatch
from bozzetto_app.theme import qcolor, tones
from bozzetto_app.words import tr

if TYPE_CHECKING:
    from bozzetto_app.session import Session

__all__ = ["ModelRow", "UnderlayRow"]

ROW = 32
"""Height of a row, px."""


class _Name(QLabel):
    """A name in one line; a double click edits it."""

    rename = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self.rename.emit()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setPen(self.palette().windowText().color())
        words = self.fontMetrics().elidedText(
            self.text(), Qt.TextElideMode.ElideMiddle, self.width()
        )
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignVCenter, words)


class _Editor(QLineEdit):
    """Enter takes the name, Esc leaves it as it was."""

    given_up = Signal()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self.given_up.emit()
        else:
            super().keyPressEvent(event)


def _toned(label: QLabel, tone: str) -> None:
    if label.property("tone") != tone:
        label.setProperty("tone", tone)
        label.style().unpolish(label)
        label.style().polish(label)


class ModelRow(QWidget):
    """Colour, name, lock and eye of one model."""

    def __init__(self, session: Session, model: Model) -> None:
        super().__init__()
        self._session = session
        self._model = model
        self.swatch = Swatch()
        self.swatch.chosen.connect(lambda color: session.set_color(self._model.id, color))
        self.name = _Name()
        self.name.rename.connect(self.edit_name)
        self.editor = _Editor()
        self.editor.setAccessibleName(tr("Objects", "Name"))
        self.editor.hide()
        self.editor.editingFinished.connect(self._take_name)
        self.editor.given_up.connect(self._stop_editing)
        self.lock = IconButton("unlock", "", on="lock", side=24, glyph=16, faint=True)
        self.lock.clicked.connect(lambda on: session.set_locked(self._model.id, bool(on)))
        self.eye = IconButton("eye", "", on="eye-off", side=24, glyph=16, faint=True)
        self.eye.clicked.connect(lambda off: session.set_visible(self._model.id, not off))
        policy = self.lock.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        self.lock.setSizePolicy(policy)
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 0, 8, 0)
        row.setSpacing(4)
        row.addWidget(self.swatch)
        row.addWidget(self.name, 1)
        row.addWidget(self.editor, 1)
        row.addWidget(self.lock)
        row.addWidget(self.eye)
        self.show_model(model)

    def sizeHint(self) -> QSize:
        return QSize(200, ROW)

    def show_model(self, model: Model) -> None:
        """Show the model as it is now."""
        self._model = model
        self.name.setText(model.name)
        self.name.setToolTip(tr("Objects", "{name}. Double-click renames.", name=model.name))
        _toned(self.name, "" if model.visible else "quiet")
        self.swatch.show_color(model.color, model.name)
        self.lock.setChecked(model.locked)
        self.lock.rename(
            tr("Objects", "Unlock {name}", name=model.name)
            if model.locked
            else tr("Objects", "Lock {name}", name=model.name)
        )
        self.lock.setVisible(model.locked or self.underMouse())
        self.eye.setChecked(not model.visible)
        self.eye.rename(
            tr("Objects", "Hide {name}", name=model.name)
            if model.visible
            else tr("Objects", "Show {name}", name=model.name)
        )

    def edit_name(self) -> None:
        """Type another name in place."""
        self.editor.setText(self._model.name)
        self.name.hide()
        self.editor.show()
        self.editor.setFocus(Qt.FocusReason.OtherFocusReason)
        self.editor.selectAll()

    def _take_name(self) -> None:
        if self.editor.isHidden():
            return
        name = self.editor.text().strip()
        self._stop_editing()
        if name and name != self._model.name:
            self._session.rename(self._model.id, name)

    def _stop_editing(self) -> None:
        self.editor.hide()
        self.name.show()

    def enterEvent(self, event: QEnterEvent) -> None:
        self.lock.show()

    def leaveEvent(self, event: object) -> None:
        self.lock.setVisible(self._model.locked)


class _Thumbnail(QWidget):
    """An underlay's picture, small."""

    def __init__(self, underlay: Underlay) -> None:
        super().__init__()
        height, width, _ = underlay.pixels.shape
        picture = QImage(
            underlay.pixels.tobytes(), width, height, 4 * width, QImage.Format.Format_RGBA8888
        )
        self._picture = picture.copy().scaled(
            96,
            96,
            Qt.AspectRatioMode.KeepAspectRatioByExpanding,
            Qt.TransformationMode.SmoothTransformation,
        )
        self.setFixedSize(QSize(24, 24))

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        place = QRectF(self.rect()).adjusted(1.5, 1.5, -1.5, -1.5)
        shape = QPainterPath()
        shape.addRoundedRect(place, 3, 3)
        side = min(self._picture.width(), self._picture.height())
        middle = self._picture.rect().center()
        source = QRectF(middle.x() - side / 2, middle.y() - side / 2, side, side)
        painter.setClipPath(shape)
        painter.drawImage(place, self._picture, source)
        painter.setClipping(False)
        painter.setPen(QPen(qcolor(tones().edge), 1))
        painter.drawPath(shape)


class UnderlayRow(QWidget):
    """Picture, name, opacity and eye of one underlay."""

    def __init__(self, session: Session, underlay: Underlay) -> None:
        super().__init__()
        self._session = session
        self._id = underlay.id
        self.name = _Name()
        self.opacity = Slider(tr("Objects", "Opacity"), 0.0, 1.0, 0.01, 0.5)
        self.opacity.setFixedWidth(72)
        self.opacity.slid.connect(
            lambda value, going: session.set_underlay_opacity(self._id, value, dragging=going)
        )
        self.opacity.drag_ended.connect(session.end_drag)
        self.eye = IconButton("eye", "", on="eye-off", side=24, glyph=16, faint=True)
        self.eye.clicked.connect(lambda off: session.set_underlay_visible(self._id, not off))
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 0, 8, 0)
        row.setSpacing(4)
        row.addWidget(_Thumbnail(underlay))
        row.addWidget(self.name, 1)
        row.addWidget(self.opacity)
        row.addWidget(self.eye)
        self.show_underlay(underlay)

    def sizeHint(self) -> QSize:
        return QSize(200, ROW)

    def show_underlay(self, underlay: Underlay) -> None:
        """Show the underlay as it is now."""
        self.name.setText(underlay.name)
        self.name.setToolTip(underlay.name)
        _toned(self.name, "" if underlay.visible else "quiet")
        percent = round(100 * underlay.opacity)
        said = tr("Objects", "Opacity of {name}: {percent} %", name=underlay.name, percent=percent)
        self.opacity.setAccessibleName(said)
        self.opacity.setToolTip(said)
        self.opacity.set_silently(underlay.opacity)
        self.eye.setChecked(not underlay.visible)
        self.eye.rename(
            tr("Objects", "Hide {name}", name=underlay.name)
            if underlay.visible
            else tr("Objects", "Show {name}", name=underlay.name)
        )
