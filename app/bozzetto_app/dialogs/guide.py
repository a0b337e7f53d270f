"""The guide, offline: its pages with their pictures, a list of its parts, and a search."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from PySide6.QtCore import QPoint, Qt, QTimer, QUrl
from PySide6.QtGui import (
    QDesktopServices,
    QImage,
    QKeySequence,
    QResizeEvent,
    QShortcut,
    QTextBlock,
    QTextCursor,
    QTextDocument,
)
from PySide6.QtWidgets import (
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QPushButton,
    QTextBrowser,
    QVBoxLayout,
    QWidget,
)

from bozzetto_app.dialogs.dialog import Page
from bozzetto_app.dialogs.guide_pages import (
    FIRST_PAGE,
    Heading,
    guide_folder,
    headings_of,
    shares_of,
    shown_text,
)
from bozzetto_app.i18n import tr

__all__ = ["GuideDialog", "GuideText"]

MARGIN: Final = 64
"""Room beside a picture, which may be indented in a list, pixels."""

CELL: Final = 12
"""Room beside a picture in a cell of a table, pixels."""

CONTENTS: Final = 220
"""Width of the list of parts, pixels."""

DEEPEST: Final = 3
"""Headings deeper than that are not listed."""


class GuideText(QTextBrowser):
    """One page of the guide; pictures are as wide as there is room, and no wider than drawn.

    Parameters
    ----------
    folder : Path
        Where the pages lie.
    """

    def __init__(self, folder: Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._folder = folder.resolve()
        self._page = ""
        self._shares: dict[str, float] = {}
        self.headings: tuple[Heading, ...] = ()
        self.setOpenLinks(False)
        # One that comes and goes changes the width, and with it every picture.
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOn)
        self.setAccessibleName(tr("Guide", "Guide"))
        self.anchorClicked.connect(self._follow)
        self._resized = QTimer(self, singleShot=True, interval=80)
        self._resized.timeout.connect(self._show_again)

    @property
    def page(self) -> str:
        """Name of the page that is shown."""
        return self._page

    def show_page(self, name: str, anchor: str = "") -> None:
        """Show a page from its beginning, or from a heading."""
        if name != self._page:
            text = (self._folder / name).read_text("utf-8")
            self._page = name
            self.headings = tuple(headings_of(text))
            self._shares = shares_of(text)
            self.document().setBaseUrl(QUrl.fromLocalFile(str(self._folder / name)))
            self.setMarkdown(shown_text(text))
        self.go_to(anchor)

    def go_to(self, anchor: str) -> None:
        """Bring a heading to the top; the beginning where there is none of that name."""
        wanted = next((at for at, one in enumerate(self.headings) if one.anchor == anchor), 0)
        level = 0
        block = self.document().begin()
        while block.isValid():
            level += bool(block.blockFormat().headingLevel())
            if level > wanted:
                self._scroll_to(block if wanted else self.document().begin())
                return
            block = block.next()

    def _scroll_to(self, block: QTextBlock) -> None:
        layout = self.document().documentLayout()
        layout.documentSize()  # lays all of it out: pictures above push the block down
        self.setTextCursor(QTextCursor(block))
        self.verticalScrollBar().setValue(int(layout.blockBoundingRect(block).top()))

    def search(self, words: str, *, backward: bool = False) -> bool:
        """Go to the next place of some words, round the end; say whether there is one."""
        way = QTextDocument.FindFlag.FindBackward if backward else QTextDocument.FindFlag(0)
        if self.find(words, way):
            return True
        before = self.textCursor()
        self.moveCursor(
            QTextCursor.MoveOperation.End if backward else QTextCursor.MoveOperation.Start
        )
        if self.find(words, way):
            return True
        self.setTextCursor(before)
        return False

    def loadResource(self, kind: int, name: QUrl | str) -> Any:
        path = Path(self.document().baseUrl().resolved(QUrl(name)).toLocalFile()).resolve()
        if kind != QTextDocument.ResourceType.ImageResource.value or not self._is_ours(path):
            return None
        picture = QImage(str(path))
        share = self._shares.get(path.relative_to(self._folder).as_posix(), 1.0)
        room = max(int(share * (self.viewport().width() - MARGIN)) - CELL, 100)
        scale = self.devicePixelRatioF()
        if picture.width() > room * scale:
            smooth = Qt.TransformationMode.SmoothTransformation
            picture = picture.scaledToWidth(round(room * scale), smooth)
            picture.setDevicePixelRatio(scale)
        return picture

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        if event.size().width() != event.oldSize().width():
            self._resized.start()

    def _show_again(self) -> None:
        """With pictures for the width that there is now, at the same place."""
        self.document().documentLayout().documentSize()
        at_top = not self.verticalScrollBar().value()
        first = 0 if at_top else self.cursorForPosition(QPoint(0, 0)).blockNumber()
        page, self._page = self._page, ""
        if page:
            self.show_page(page)
            self._scroll_to(self.document().findBlockByNumber(first))

    def _is_ours(self, path: Path) -> bool:
        return path.is_relative_to(self._folder) and path.is_file()

    def _follow(self, link: QUrl) -> None:
        """Follow a link: to a page or heading in this dialog, to the web in the browser."""
        if link.scheme() in ("http", "https"):
            QDesktopServices.openUrl(link)
            return
        name = link.path() or self._page
        if self._is_ours((self._folder / name).resolve()):
            self.show_page(name, link.fragment())


class GuideDialog(Page):
    """The guide in a window of its own, which can stay open beside the sheet."""

    def __init__(self, parent: QWidget | None = None, folder: Path | None = None) -> None:
        super().__init__("guide", tr("Guide", "Guide"), parent)
        self.text = GuideText(folder or guide_folder())
        self.contents = QListWidget()
        self.contents.setAccessibleName(tr("Guide", "Contents"))
        self.contents.setFixedWidth(CONTENTS)
        self.contents.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.contents.setTextElideMode(Qt.TextElideMode.ElideRight)
        self.contents.itemActivated.connect(self._go)
        self.contents.itemClicked.connect(self._go)
        self.field = QLineEdit()
        self.field.setPlaceholderText(tr("Guide", "Search in this page"))
        self.field.setAccessibleName(tr("Guide", "Search"))
        self.field.setClearButtonEnabled(True)
        self.field.textChanged.connect(self._search_again)
        self.field.returnPressed.connect(self._search_on)
        self.said = QLabel()
        self.said.setProperty("tone", "warning")
        self._back = QPushButton(tr("Guide", "Back to the guide"))
        self._back.setAutoDefault(False)
        self._back.clicked.connect(lambda: self._open(FIRST_PAGE))
        top = QHBoxLayout()
        top.setSpacing(8)
        top.addWidget(self.field, 1)
        top.addWidget(self.said)
        top.addWidget(self._back)
        right = QVBoxLayout()
        right.addLayout(top)
        right.addWidget(self.text, 1)
        row = QHBoxLayout()
        row.setSpacing(12)
        row.addWidget(self.contents)
        row.addLayout(right, 1)
        self.column.addLayout(row, 1)
        self.add_button(tr("Guide", "&Close")).clicked.connect(self.accept)
        find = QShortcut(QKeySequence(QKeySequence.StandardKey.Find), self)
        find.activated.connect(self.field.setFocus)
        self.text.anchorClicked.connect(self._list_parts)
        self.resize(980, 720)
        self._open(FIRST_PAGE)
        self.field.setFocus()

    def _open(self, page: str) -> None:
        self.text.show_page(page)
        self._list_parts()

    def _list_parts(self) -> None:
        self._back.setVisible(self.text.page != FIRST_PAGE)
        shown = [one for one in self.text.headings if one.depth <= DEEPEST]
        if [one.anchor for one in shown] == self._listed():
            return
        self.contents.clear()
        for one in shown:
            item = QListWidgetItem("\u2003" * max(one.depth - 2, 0) + one.words)
            item.setData(Qt.ItemDataRole.UserRole, one.anchor)
            item.setToolTip(one.words)
            self.contents.addItem(item)

    def _listed(self) -> list[str]:
        items = (self.contents.item(row) for row in range(self.contents.count()))
        return [item.data(Qt.ItemDataRole.UserRole) for item in items]

    def _go(self, item: QListWidgetItem) -> None:
        self.text.go_to(item.data(Qt.ItemDataRole.UserRole))

    def _search_again(self, words: str) -> None:
        """Search while typing, from where the last find began."""
        cursor = self.text.textCursor()
        cursor.setPosition(cursor.selectionStart())
        self.text.setTextCursor(cursor)
        self._tell(not words or self.text.search(words))

    def _search_on(self) -> None:
        words = self.field.text()
        self._tell(not words or self.text.search(words))

    def _tell(self, found: bool) -> None:
        self.said.setText("" if found else tr("Guide", "Not on this page."))
