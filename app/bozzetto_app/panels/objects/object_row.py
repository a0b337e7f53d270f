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
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QWidget

from bozzetto_app.i18n import tr
from bozzetto_app.panels.objects.list_widget import ROW
from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import qcolor, set_tone, text_height, tones
from bozzetto_app.widgets.icon_button import IconButton
from bozzetto_app.widgets.slider import Slider
from bozzetto_app.widgets.swatch import Swatch
from bozzetto_app.widgets.text_field import TextField

if TYPE_CHECKING:
    from bozzetto.document.model import Model, Underlay
    from bozzetto_app.session.session import Session

__all__ = ["FOLD", "GUTTER", "Eye", "Fold", "ModelRow", "NamedRow", "Sign", "UnderlayRow"]

GUTTER = 4
"""Room before the arrow of a row, px."""

FOLD = 20
"""Side of the arrow that folds, px."""


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


class _Editor(TextField):
    """Enter takes the name, Esc leaves it as it was."""

    given_up = Signal()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape:
            self.given_up.emit()
        else:
            super().keyPressEvent(event)


class NamedRow(QWidget):
    """A row with a name that can be edited in place.

    Signals
    -------
    renamed : str
        A person typed another name.
    """

    renamed = Signal(str)

    def __init__(self) -> None:
        super().__init__()
        self.name = _Name()
        self.name.rename.connect(self.edit_name)
        self.editor = _Editor()
        self.editor.setAccessibleName(tr("Objects", "Name"))
        self.editor.setProperty("inrow", True)
        self.editor.hide()
        self.editor.editingFinished.connect(self._take_name)
        self.editor.given_up.connect(self._stop_editing)

    def sizeHint(self) -> QSize:
        return QSize(200, text_height(ROW))

    def show_name(self, name: str, *, visible: bool) -> None:
        """Show how it is called; quietly if it is hidden."""
        self.name.setText(name)
        self.name.setToolTip(tr("Objects", "{name}. Double-click renames.", name=name))
        set_tone(self.name, "" if visible else "quiet")

    def edit_name(self) -> None:
        """Type another name in place."""
        self.editor.setText(self.name.text())
        self.name.hide()
        self.editor.show()
        self.editor.setFocus(Qt.FocusReason.OtherFocusReason)
        self.editor.selectAll()

    def _take_name(self) -> None:
        if self.editor.isHidden():
            return
        name = self.editor.text().strip()
        self._stop_editing()
        if name and name != self.name.text():
            self.renamed.emit(name)

    def _stop_editing(self) -> None:
        ground, typed = self.parentWidget(), self.editor.hasFocus()
        self.editor.hide()
        self.name.show()
        if typed and ground is not None:
            ground.setFocus()  # of the list: else the next button has it, which Space presses


class Fold(IconButton):
    """The arrow that shows or hides what is under a row; it keeps its room when there is none."""

    def __init__(self) -> None:
        super().__init__("chevron-right", "", on="chevron-down", side=FOLD, glyph=14, faint=True)
        policy = self.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        self.setSizePolicy(policy)

    def show_fold(self, is_open: bool | None, owner: str) -> None:
        """Show whether it is open; None where there is nothing to fold."""
        self.setVisible(is_open is not None)
        self.setChecked(bool(is_open))
        self.rename(
            tr("Objects", "Fold the parts of {name}", name=owner)
            if is_open
            else tr("Objects", "Unfold the parts of {name}", name=owner)
        )


class Eye(IconButton):
    """Shows or hides what a row stands for."""

    def __init__(self) -> None:
        super().__init__("eye", "", on="eye-off", side=24, glyph=16, faint=True)

    def show_visible(self, visible: bool, owner: str) -> None:
        """Show whether it is visible, and say whose it is."""
        self.setChecked(not visible)
        self.rename(
            tr("Objects", "Hide {name}", name=owner)
            if visible
            else tr("Objects", "Show {name}", name=owner)
        )


class Sign(QWidget):
    """An icon that says something of a row, such as how a part is put together with others."""

    def __init__(self) -> None:
        super().__init__()
        self._icon = ""
        self.setFixedSize(QSize(24, 24))

    def show_sign(self, icon: str, words: str) -> None:
        """Show an icon, "" for none, with words for those who cannot see it."""
        self._icon = icon
        self.setAccessibleName(words)
        self.setToolTip(words)
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        if self._icon:
            paint_icon(QPainter(self), self._icon, QRectF(4, 4, 16, 16), tones().quiet)


class ModelRow(NamedRow):
    """Arrow, colour, name, link, lock and eye of one model.

    Signals
    -------
    folded : bool
        A person unfolded (True) or folded its parts.
    """

    folded = Signal(bool)

    def __init__(self, session: Session, model: Model) -> None:
        super().__init__()
        self._model = model
        self.renamed.connect(lambda name: session.objects.rename(self._model.id, name))
        self.fold = Fold()
        self.fold.clicked.connect(self.folded)
        self.swatch = Swatch()
        self.swatch.chosen.connect(lambda color: session.objects.set_color(self._model.id, color))
        self.link = Sign()
        self.lock = IconButton("unlock", "", on="lock", side=24, glyph=16, faint=True)
        self.lock.clicked.connect(lambda on: session.objects.set_locked(self._model.id, bool(on)))
        self.eye = Eye()
        self.eye.clicked.connect(lambda off: session.objects.set_visible(self._model.id, not off))
        policy = self.lock.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        self.lock.setSizePolicy(policy)
        row = QHBoxLayout(self)
        row.setContentsMargins(GUTTER, 0, 8, 0)
        row.setSpacing(0)
        row.addWidget(self.fold)
        row.addWidget(self.swatch)
        row.addSpacing(4)
        row.addWidget(self.name, 1)
        row.addWidget(self.editor, 1)
        row.addSpacing(4)
        row.addWidget(self.link)
        row.addWidget(self.lock)
        row.addSpacing(4)
        row.addWidget(self.eye)
        self.show_model(model, None)

    def show_model(self, model: Model, is_open: bool | None, link: str = "") -> None:
        """Show the model as it is now.

        Parameters
        ----------
        model : Model
            The model of this row.
        is_open : bool, optional
            Whether its parts are listed; None where it has none.
        link : str
            What it is made from, in words.
        """
        self._model = model
        self.link.show_sign(("link" if model.followed else "link-off") if link else "", link)
        self.link.setVisible(bool(link))
        self.show_name(model.name, visible=model.visible)
        self.fold.show_fold(is_open, model.name)
        self.swatch.show_color(model.color, model.name)
        self.lock.setChecked(model.locked)
        self.lock.rename(
            tr("Objects", "Unlock {name}", name=model.name)
            if model.locked
            else tr("Objects", "Lock {name}", name=model.name)
        )
        self.lock.setVisible(model.locked or self.underMouse())
        self.eye.show_visible(model.visible, model.name)

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
            lambda value, going: session.objects.set_underlay_opacity(
                self._id, value, dragging=going
            )
        )
        self.opacity.drag_ended.connect(session.objects.end_drag)
        self.eye = Eye()
        self.eye.clicked.connect(
            lambda off: session.objects.set_underlay_visible(self._id, not off)
        )
        row = QHBoxLayout(self)
        row.setContentsMargins(GUTTER + FOLD, 0, 8, 0)
        row.setSpacing(4)
        row.addWidget(_Thumbnail(underlay))
        row.addWidget(self.name, 1)
        row.addWidget(self.opacity)
        row.addWidget(self.eye)
        self.show_underlay(underlay)

    def sizeHint(self) -> QSize:
        return QSize(200, text_height(ROW))

    def show_underlay(self, underlay: Underlay) -> None:
        """Show the underlay as it is now."""
        self.name.setText(underlay.name)
        self.name.setToolTip(underlay.name)
        set_tone(self.name, "" if underlay.visible else "quiet")
        percent = round(100 * underlay.opacity)
        said = tr("Objects", "Opacity of {name}: {percent} %", name=underlay.name, percent=percent)
        self.opacity.setAccessibleName(said)
        self.opacity.setToolTip(said)
        self.opacity.set_silently(underlay.opacity)
        self.eye.show_visible(underlay.visible, underlay.name)
