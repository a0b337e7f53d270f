"""The toolbox: which modeler is drawn with, which tools it has, and which one is in the hand."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from PySide6.QtCore import QObject

from bozzetto.plugin.job import Job
from bozzetto.plugin.modeler import Aims, TellsNext
from bozzetto_app.i18n import tr
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["TOOL_KEYS", "ToolInfo", "Toolbox"]

TOOL_KEYS = "1234567890"
"""The keys that take the tools of a modeler, in their order."""

TOOLS_LIMIT = 20.0
"""Seconds a plugin may take to be imported and to name its tools before it counts as hung."""


@dataclass(frozen=True)
class ToolInfo:
    """A tool as the rail shows it."""

    id: str
    title: str
    icon: Path | None
    hint: str
    gesture: Literal["ink", "tap", "drag"]
    tells_next: bool = False
    """Whether it says itself what to do next; see `TellsNext`."""
    aims: bool = False
    """Whether its places must be met exactly; see `Aims`."""


class Toolbox(QObject):
    """The active modeler with its tools.

    Attributes
    ----------
    modeler, tool : str
        Ids; empty while there is none.
    tools : tuple of ToolInfo
        Empty until the modeler's plugin has been imported, which happens in a worker.
    """

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._session = session
        self.modeler = ""
        self.tool = ""
        self.tools: tuple[ToolInfo, ...] = ()
        self._channel = Channel("tools", time_limit=TOOLS_LIMIT, is_patient=True, parent=self)
        self._channel.slow.connect(session.tell_slow)

    @property
    def busy(self) -> bool:
        """Whether the tools are still being asked for."""
        return self._channel.busy

    def stop(self) -> None:
        """Wait no longer for tools; to choose the modeler again asks again."""
        if self._channel.busy:
            self._channel.cancel()
            self.modeler = ""
            self._session.modeler_changed.emit()

    def take_modeler(self, modeler_id: str) -> None:
        """Draw with another modeler."""
        session = self._session
        info = session.registry.info(modeler_id)
        self.modeler, self.tools, self.tool = modeler_id, (), ""
        session.modeler_changed.emit()
        session.say_hint(info.hint)

        def work(job: Job) -> tuple[ToolInfo, ...]:
            return tuple(
                ToolInfo(
                    tool.id,
                    tool.title,
                    info.folder / tool.icon if tool.icon else None,
                    tool.hint,
                    tool.gesture,
                    isinstance(tool, TellsNext),
                    isinstance(tool, Aims) and tool.aims,
                )
                for tool in session.workbench.tools(modeler_id)
            )

        def found(tools: tuple[ToolInfo, ...]) -> None:
            if self.modeler == modeler_id:
                self.tools = tools
                session.modeler_changed.emit()
                if tools:
                    self.take_tool(tools[0].id)

        self._channel.cancel()
        self._channel.submit(Request(work, found, session.complain))

    def drop_if_gone(self) -> None:
        """Where the plugin of the active modeler was switched off, take the first one there is."""
        session = self._session
        gone = self.modeler
        if not gone or any(info.id == gone for info in session.modelers):
            return
        title = session.registry.info(gone).title
        if session.modelers:
            other = session.modelers[0]
            self.take_modeler(other.id)
            words = tr(
                "Session",
                "{title} is switched off; you draw with {other} now. Its objects stay as they are.",
                title=title,
                other=other.title,
            )
        else:
            self._channel.cancel()
            self.modeler, self.tools, self.tool = "", (), ""
            session.modeler_changed.emit()
            words = tr(
                "Session",
                "{title} is switched off, and there is no other modeler. Switch one on to draw.",
                title=title,
            )
        session.tell(words)

    def take_tool(self, tool_id: str) -> None:
        """Take another tool of the active modeler."""
        for tool in self.tools:
            if tool.id == tool_id:
                self.tool = tool_id
                self._session.tool_changed.emit()
                self._session.say_hint(tool.hint)

    def take_first_tool(self) -> None:
        """Take the modeler's first tool: with it a picture that came in is worked on."""
        if self.tools and self.tool != self.tools[0].id:
            self.take_tool(self.tools[0].id)

    def tool_for(self, gesture: Literal["ink", "tap", "drag"]) -> str:
        """The tool that gets a gesture.

        Drags of handles go to a tool that takes drags, the one in the hand before others;
        everything else to the tool in the hand.
        """
        if gesture == "drag":
            takers = [tool.id for tool in self.tools if tool.gesture == "drag"]
            if takers and self.tool not in takers:
                return takers[0]
        return self.tool

    def hint_of(self, tool_id: str) -> str:
        """A tool's hint; "" where it is not among the tools."""
        return next((tool.hint for tool in self.tools if tool.id == tool_id), "")

    def hint_and_more(self, tool_id: str) -> str:
        """A tool's hint, and what can be done beside drawing once there is an object."""
        return tr(
            "Session",
            "{hint} Middle button or Alt + pen turns. Enter starts a new object.",
            hint=self.hint_of(tool_id),
        ).strip()

    def tells_next(self, tool_id: str) -> bool:
        """Whether a tool says itself what to do next."""
        return any(tool.tells_next for tool in self.tools if tool.id == tool_id)
