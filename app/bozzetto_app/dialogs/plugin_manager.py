"""The plugins: what is installed, in which state, and a switch for each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from bozzetto.errors import UserError
from bozzetto_app.dialogs.dialog import Page, label, quiet
from bozzetto_app.dialogs.fault_details import FaultDetails
from bozzetto_app.i18n import tr
from bozzetto_app.settings import keep_plugin_disabled
from bozzetto_app.style.icons import paint_icon
from bozzetto_app.style.theme import tones
from bozzetto_app.toolkit.panel_scroll import PanelScroll
from bozzetto_app.widgets.toggle import Toggle

if TYPE_CHECKING:
    from bozzetto.plugin.host.registry import PluginInfo
    from bozzetto_app.session.session import Session

__all__ = ["PluginManager"]


class _Sign(QWidget):
    def __init__(self, status: str) -> None:
        super().__init__()
        self._status = status
        self.setFixedSize(QSize(20, 20))

    def paintEvent(self, event: QPaintEvent) -> None:
        colors = tones()
        name, color = {
            "loaded": ("check", colors.good),
            "ready": ("plugin", colors.quiet),
            "disabled": ("minus", colors.quiet),
            "broken": ("warning", colors.warning),
        }[self._status]
        paint_icon(QPainter(self), name, QRectF(self.rect()), color)


def _said(status: str) -> str:
    return {
        "loaded": tr("Plugins", "in use"),
        "ready": tr("Plugins", "ready; loaded on first use"),
        "disabled": tr("Plugins", "switched off"),
        "broken": tr("Plugins", "cannot be used"),
    }[status]


class PluginManager(Page):
    """A card for every plugin.

    Signals
    -------
    switched : str, bool
        A plugin's id, and whether it is on now.
    """

    switched = Signal(str, bool)

    def __init__(self, session: Session, parent: QWidget | None = None) -> None:
        super().__init__("plugins", tr("Plugins", "Plugins"), parent)
        self._session = session
        self._area = PanelScroll()
        self.column.addWidget(self._area, 1)
        self.column.addWidget(
            quiet(
                tr(
                    "Plugins",
                    "Plugins are installed as Python packages, for example with pip, and appear "
                    "here at the next start. They run with all your rights: install only what "
                    "you trust.",
                )
            )
        )
        self.add_button(tr("Plugins", "&Close"), default=True).clicked.connect(self.accept)
        self.resize(560, 520)
        self.refresh()

    def refresh(self) -> None:
        """Show the plugins as they are now."""
        page = self._page = QWidget()
        column = QVBoxLayout(page)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(8)
        infos = self._session.registry.plugins()
        for info in infos:
            column.addWidget(self._card(info))
        if not infos:
            column.addWidget(quiet(tr("Plugins", "No plugin is installed.")))
        column.addStretch(1)
        self._area.setWidget(page)

    def _card(self, info: PluginInfo) -> QFrame:
        card = QFrame()
        card.setProperty("shape", "card")
        title = label(info.title, kind="heading")
        title.setWordWrap(False)
        head = QHBoxLayout()
        head.setSpacing(8)
        head.addWidget(title)
        head.addWidget(quiet(info.version), 1)
        words = QVBoxLayout()
        words.setSpacing(4)
        words.addLayout(head)
        if info.summary:
            words.addWidget(label(info.summary))
        state = quiet(tr("Plugins", "{id}: {state}", id=info.id, state=_said(info.status)))
        state.setToolTip(tr("Plugins", "Package {package}", package=info.package))
        words.addWidget(state)
        for warning in info.warnings:
            words.addWidget(quiet(warning))
        if info.fault:
            words.addLayout(self._fault(info))
        toggle = Toggle(tr("Plugins", "Use {title}", title=info.title))
        toggle.setObjectName(info.id)
        toggle.setChecked(info.status != "disabled")
        toggle.clicked.connect(lambda on: self._switch(info.id, bool(on)))
        row = QHBoxLayout(card)
        row.setContentsMargins(12, 12, 12, 12)
        row.setSpacing(12)
        row.addWidget(_Sign(info.status), 0, Qt.AlignmentFlag.AlignTop)
        row.addLayout(words, 1)
        row.addWidget(toggle, 0, Qt.AlignmentFlag.AlignTop)
        return card

    def _fault(self, info: PluginInfo) -> QHBoxLayout:
        line = QHBoxLayout()
        line.setSpacing(8)
        line.addWidget(label(info.fault, tone="warning"), 1)
        details = QPushButton(tr("Plugins", "Details"))
        details.setAutoDefault(False)
        details.setAccessibleName(tr("Plugins", "Details of {title}", title=info.title))
        details.clicked.connect(lambda: self.details_of(info).open())
        line.addWidget(details, 0, Qt.AlignmentFlag.AlignTop)
        return line

    def details_of(self, info: PluginInfo) -> FaultDetails:
        """Show the dialog with the traceback of a plugin."""
        return FaultDetails(f"{info.title} {info.version}: {info.fault}", info.details, self)

    def _switch(self, plugin: str, on: bool) -> None:
        registry = self._session.registry
        registry.set_disabled(plugin, not on)
        try:
            keep_plugin_disabled(plugin, not on)
        except UserError as problem:
            self._session.notices.complain(problem)
        place = self._area.verticalScrollBar().value()
        self.refresh()
        self._go_on_at(plugin, place)
        self.switched.emit(plugin, on)

    def _go_on_at(self, plugin: str, place: int) -> None:
        """Show the cards where they were, with the switch of a plugin in the hand."""
        page = self._page
        page.adjustSize()  # else the range of the scroll bar is not known yet
        self._area.verticalScrollBar().setValue(place)
        toggle = page.findChild(Toggle, plugin)
        if toggle is not None:
            toggle.setFocus()
