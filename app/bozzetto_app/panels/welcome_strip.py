"""The welcome strip: sample drawings and recent files; it closes by drawing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QEvent, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QImage, QMouseEvent, QPainter, QPainterPath, QPaintEvent, QPen, QShowEvent
from PySide6.QtWidgets import (
    QAbstractButton,
    QFrame,
    QHBoxLayout,
    QLabel,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from bozzetto_app.i18n import tr
from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import qcolor, small_font, tones
from bozzetto_app.widgets.icon_button import IconButton, paint_focus
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["WIDTH", "WelcomeStrip"]

PICTURE = QSize(72, 54)
"""Size of a thumbnail, px."""

WIDTH = 276
"""Of the strip over a sheet, px."""

AFTER_PAINT = 50
"""Time for the first paint of the window before pictures are read, ms."""

Thumbnail = Callable[[Path], QImage | None]


class _Card(QAbstractButton):
    """A picture with two lines of words.

    Signals
    -------
    outdated
        The picture belongs to another theme.
    """

    outdated = Signal()

    def __init__(
        self, title: str, below: str, picture: Callable[[], QImage | None], icon: str | Path
    ) -> None:
        super().__init__()
        self._below = below
        self.read = picture
        self._picture: QImage | None = None
        self._theme = tones().name
        self._icon = icon
        self.setText(title)
        self.setAccessibleName(title)
        self.setAccessibleDescription(below)
        self.setToolTip(f"{title}\n{below}")
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        return QSize(200, PICTURE.height() + 8)

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if self._theme != tones().name:  # pictures of ink have the theme's ink
            self._theme = tones().name
            self.outdated.emit()

    def show_picture(self, picture: QImage | None) -> None:
        """Show a picture instead of the icon, if there is one."""
        self._picture = picture
        self.update()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Do nothing: the first click of the two has opened it."""

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        if self.underMouse() or self.isDown():
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(qcolor(colors.press if self.isDown() else colors.hover))
            painter.drawRoundedRect(QRectF(self.rect()), 6, 6)
        frame = QRectF(4.5, 4.5, PICTURE.width() - 1, PICTURE.height() - 1)
        shape = QPainterPath()
        shape.addRoundedRect(frame, 4, 4)
        painter.fillPath(shape, qcolor(colors.field))
        if self._picture is not None and not self._picture.isNull():
            size = self._picture.size().scaled(PICTURE, Qt.AspectRatioMode.KeepAspectRatio)
            place = QRectF(0, 0, size.width(), size.height())
            place.moveCenter(frame.center())
            painter.setClipPath(shape)
            painter.drawImage(place, self._picture)
            painter.setClipping(False)
        else:
            glyph = QRectF(0, 0, 24, 24)
            glyph.moveCenter(frame.center())
            paint_icon(painter, self._icon, glyph, colors.quiet)
        painter.setPen(QPen(qcolor(colors.hairline), 1))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawPath(shape)
        room = self.rect().adjusted(PICTURE.width() + 16, 10, -36, -10)
        painter.setPen(qcolor(colors.text))
        title = painter.fontMetrics().elidedText(
            self.text(), Qt.TextElideMode.ElideRight, room.width()
        )
        painter.drawText(
            room.adjusted(0, 2, 0, -room.height() // 2), Qt.AlignmentFlag.AlignBottom, title
        )
        painter.setFont(small_font(self.font()))
        painter.setPen(qcolor(colors.quiet))
        below = painter.fontMetrics().elidedText(
            self._below, Qt.TextElideMode.ElideMiddle, room.width()
        )
        painter.drawText(
            room.adjusted(0, room.height() // 2 + 4, 0, 0), Qt.AlignmentFlag.AlignTop, below
        )
        if self.hasFocus():
            paint_focus(painter, QRectF(self.rect()), 6)


def _raise(problem: BaseException) -> None:
    raise problem


def _heading(words: str) -> QLabel:
    label = QLabel(words)
    label.setProperty("type", "heading")
    label.setContentsMargins(4, 8, 0, 4)
    return label


class WelcomeStrip(QScrollArea):
    """Strip of samples and recent drawings beside an empty sheet.

    Parameters
    ----------
    session : Session
    recent : sequence of Path
        Documents, newest first.
    thumbnail : callable, optional
        The picture of a sample or a document, or None.

    Signals
    -------
    sample_chosen : str, Path, str
        A modeler's id, the sample's ink file and its title: open it.
    sample_watched : str, Path
        The same, to watch it being drawn.
    recent_chosen : Path
    closed
        By drawing, or by the cross; whoever holds the strip puts it away.
    """

    sample_chosen = Signal(str, object, str)
    sample_watched = Signal(str, object)
    recent_chosen = Signal(object)
    closed = Signal()

    def __init__(
        self,
        session: Session,
        recent: Sequence[Path] = (),
        thumbnail: Thumbnail = lambda path: None,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._session = session
        self._thumbnail = thumbnail
        self.setObjectName("welcome")
        self.setWindowTitle(tr("Welcome", "Welcome"))
        self.setAccessibleName(self.windowTitle())
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setMinimumWidth(264)
        page = QWidget()
        self._column = QVBoxLayout(page)
        self._column.setContentsMargins(12, 8, 12, 12)
        self._column.setSpacing(0)
        words = QLabel(tr("Welcome", "Take the pen and draw, or begin with one of these."))
        words.setWordWrap(True)
        words.setProperty("tone", "quiet")
        close = IconButton("cross", tr("Welcome", "Close"), side=24, glyph=16, faint=True)
        close.clicked.connect(self.closed)
        top = QHBoxLayout()
        top.setContentsMargins(4, 0, 0, 0)
        top.addWidget(words, 1)
        top.addWidget(close, 0, Qt.AlignmentFlag.AlignTop)
        self._column.addLayout(top)
        self._add_samples()
        self._add_recent(recent)
        self._column.addStretch(1)
        self.setWidget(page)
        self._pictures = Channel("welcome", keep_all=True, parent=self)
        self._cards = page.findChildren(_Card)
        for card in self._cards:
            card.outdated.connect(partial(self._read, card))
        session.drawing.waiting_changed.connect(self._drawn)
        session.drawing.changed.connect(self._drawn)

    def _add_samples(self) -> None:
        infos = [info for info in self._session.toolbox.modelers if info.samples]
        if not infos:
            return
        self._column.addWidget(_heading(tr("Welcome", "Sample drawings")))
        for info in infos:
            for sample, title in zip(info.samples, info.sample_titles, strict=True):
                card = _Card(title, info.title, partial(self._thumbnail, sample), info.icon)
                card.clicked.connect(
                    lambda _, name=info.id, path=sample, title=title: self.sample_chosen.emit(
                        name, path, title
                    )
                )
                watch = IconButton(
                    "play",
                    tr("Welcome", "Watch {title} being drawn", title=title),
                    card,
                    side=28,
                    glyph=16,
                    faint=True,
                )
                watch.clicked.connect(
                    lambda _, name=info.id, path=sample: self.sample_watched.emit(name, path)
                )
                beside = QHBoxLayout(card)
                beside.setContentsMargins(0, 0, 4, 0)
                beside.addWidget(watch, 0, Qt.AlignmentFlag.AlignRight)
                self._column.addWidget(card)

    def _add_recent(self, recent: Sequence[Path]) -> None:
        if not recent:
            return
        self._column.addWidget(_heading(tr("Welcome", "Recent")))
        for path in recent:
            card = _Card(path.stem, str(path.parent), partial(self._thumbnail, path), "drawing")
            card.clicked.connect(lambda _, path=path: self.recent_chosen.emit(path))
            self._column.addWidget(card)

    def showEvent(self, event: QShowEvent) -> None:
        """Have the pictures read in a worker, which takes some milliseconds each."""
        super().showEvent(event)
        QTimer.singleShot(AFTER_PAINT, self, self._read_all)

    def _read_all(self) -> None:
        cards, self._cards = self._cards, []
        for card in cards:
            self._read(card)

    def _read(self, card: _Card) -> None:
        self._pictures.submit(Request(lambda job: card.read(), card.show_picture, _raise))

    def lie_on(self, sheet: QSize) -> None:
        """Take a sheet's upper left corner, no more of it than there is to show."""
        tall = self._column.totalHeightForWidth(WIDTH - 1)
        self.setGeometry(0, 0, WIDTH, min(tall + 1, sheet.height()))

    def _drawn(self) -> None:
        if self.isVisible() and (
            self._session.drawing.pending or self._session.drawing.document.models
        ):
            self.closed.emit()
