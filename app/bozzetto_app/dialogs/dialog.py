"""The common shape of dialogs: a title, a column, buttons at the lower right."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QDialog, QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget

from bozzetto_app.style.theme import FRAME
from bozzetto_app.toolkit.panel_scroll import PanelScroll
from bozzetto_app.widgets.tab_order import put_in_tab_order

__all__ = ["Page", "label", "quiet"]


def label(words: str, *, kind: str = "", tone: str = "") -> QLabel:
    """Return a label whose words wrap, as plain text: names in them may contain anything.

    Parameters
    ----------
    words : str
        The text of the label.
    kind : {"", "heading", "small"}
        Its rank in the style sheet, such as “heading”.
    tone : {"", "quiet", "warning"}
        Its colour in the style sheet, such as “quiet”.
    """
    made = QLabel(words)
    made.setTextFormat(Qt.TextFormat.PlainText)
    made.setProperty("type", kind)
    made.setProperty("tone", tone)
    made.setWordWrap(True)
    return made


def quiet(words: str) -> QLabel:
    """Return a label in the quiet colour of secondary text."""
    return label(words, tone="quiet")


class Page(QDialog):
    """A dialog with a column to fill and a row of buttons.

    On a screen that is too low for it the column is scrolled, so that the buttons are in reach, and
    what must be seen before one is pressed is in sight.

    Parameters
    ----------
    name : str
        Object name.
    title : str
        Of the window.

    Attributes
    ----------
    in_sight : list of QWidget
        Those in the column that lie above the buttons where the column is scrolled.
    """

    def __init__(self, name: str, title: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName(name)
        self.setWindowTitle(title)
        self.setAccessibleName(title)
        outer = QVBoxLayout(self)
        outer.setContentsMargins(20, 20, 20, 16)
        outer.setSpacing(16)
        self.column = QVBoxLayout()
        self.column.setSpacing(12)
        self._columns = QHBoxLayout()
        self._columns.setSpacing(24)
        self._columns.addLayout(self.column, 1)
        outer.addLayout(self._columns, 1)
        self.in_sight: list[QWidget] = []
        self._pressed: list[QPushButton] = []
        self._buttons = QHBoxLayout()
        self._buttons.setSpacing(8)
        self._buttons.addStretch(1)
        outer.addLayout(self._buttons)

    def add_beside(self) -> QVBoxLayout:
        """Add a second column to the right of the first one; it is never scrolled."""
        made = QVBoxLayout()
        made.setSpacing(12)
        self._columns.addLayout(made)
        return made

    def add_button(self, words: str, *, default: bool = False) -> QPushButton:
        """Add a button at the lower right; Enter presses the default one."""
        button = QPushButton(words)
        button.setDefault(default)
        button.setAutoDefault(default)
        self._buttons.addWidget(button)
        self._pressed.append(button)
        return button

    def showEvent(self, event: QShowEvent) -> None:
        free = self.screen().availableGeometry().size() - QSize(*FRAME)
        if self._least_size.height() > free.height():
            self._scroll()
        # Qt gives a dialog two thirds of the screen at most, and takes words for unwrapped then.
        self.resize(self.size().expandedTo(self._least_size).boundedTo(free))
        super().showEvent(event)

    @property
    def _least_size(self) -> QSize:
        """The size in which nothing is cut, with words wrapped as they are at this width."""
        outer = self.layout()
        if outer is None:
            return QSize()
        least = outer.totalMinimumSize()
        wrapped = outer.totalMinimumHeightForWidth(max(self.width(), least.width()))
        return least.expandedTo(QSize(0, wrapped))

    @property
    def is_scrolled(self) -> bool:
        """Whether the screen is too low for the column."""
        return self.column.parentWidget() is not self

    def _scroll(self) -> None:
        """Put the column into an area that is scrolled."""
        outer, inner, area = self.layout(), QWidget(), PanelScroll(self)
        if not isinstance(outer, QVBoxLayout) or self.is_scrolled:
            return  # it is there already
        self._columns.removeItem(self.column)
        self.column.setParent(None)
        self.column.setContentsMargins(0, 0, 8, 0)
        inner.setLayout(self.column)
        area.setWidget(inner)
        for widget in inner.findChildren(QWidget):
            widget.ensurePolished()  # its letters may be larger in the style of this window
        self.column.activate()
        bar = area.verticalScrollBar().sizeHint().width()
        area.setMinimumWidth(inner.minimumSizeHint().width() + bar)
        self._columns.insertWidget(0, area, 1)
        for number, widget in enumerate(self.in_sight, 1):
            self.column.removeWidget(widget)
            outer.insertWidget(number, widget)
        outer.activate()
        area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        put_in_tab_order(self, (inner, *self._pressed))
        for widget in inner.findChildren(QWidget):
            if widget.focusPolicy() & Qt.FocusPolicy.TabFocus and widget.isEnabled():
                widget.setFocus()
                break
