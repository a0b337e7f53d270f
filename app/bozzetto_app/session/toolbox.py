"""The modeler and the tool that the person draws with."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Literal

from PySide6.QtCore import QObject, Signal

from bozzetto.plugin.overrides import overrides
from bozzetto_app.i18n import tr
from bozzetto_app.session.tool_groups import ToolGroup, ToolInfo, groups_of
from bozzetto_app.workers.channel import Channel, Request

if TYPE_CHECKING:
    from collections.abc import Callable

    from bozzetto.plugin.host.registry import ModelerInfo
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.notices import Notices
    from bozzetto_app.session.selection import Selection

__all__ = ["Toolbox"]

TOOLS_LIMIT = 20.0
"""Seconds a plugin may take to be imported and to name its tools before it counts as hung."""


class Toolbox(QObject):
    """The active modeler with its tools.

    Attributes
    ----------
    modeler, tool : str
        Ids of the active modeler and tool; empty while there is none.
    tools : tuple of ToolInfo
        Empty until a worker has imported the plugin of the modeler.
    last_used : dict of str
        Id of the tool that was taken last, by the group it is in.
    channel : Channel
        The work of asking for the tools.

    Signals
    -------
    modeler_changed
        Another modeler is active, or its tools are known now.
    tool_changed
        Another tool is active.
    """

    modeler_changed = Signal()
    tool_changed = Signal()

    def __init__(
        self,
        workbench: Workbench,
        selection: Selection,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self.modeler = ""
        self.tool = ""
        self.tools: tuple[ToolInfo, ...] = ()
        self.last_used: dict[str, str] = {}
        self._known: dict[str, tuple[ToolInfo, ...]] = {}
        self._is_held = False
        self._chosen: Callable[[], None] | None = None
        self.channel = Channel("tools", time_limit=TOOLS_LIMIT, is_patient=True, parent=self)
        notices.watch(self.channel)
        self._workbench, self._selection, self._notices = workbench, selection, notices
        self._registry = workbench.registry
        selection.changed.connect(self._selection_changed)

    @property
    def modelers(self) -> tuple[ModelerInfo, ...]:
        """All modelers that can be drawn with, in their order."""
        return tuple(info for info in self._registry.modelers() if info.listed)

    @property
    def active(self) -> ToolInfo | None:
        """The active tool; None until the tools are known."""
        return next((tool for tool in self.tools if tool.id == self.tool), None)

    @property
    def has_first_tool(self) -> bool:
        """Whether the active tool is the first one, with which a new object is begun."""
        return bool(self.tools) and self.tool == self.tools[0].id

    @property
    def groups(self) -> tuple[ToolGroup, ...]:
        """The tools by the buttons of the rail."""
        return groups_of(self.tools)

    def stop(self) -> None:
        """Stop waiting for tools; to choose the modeler again asks again."""
        if self.channel.busy:
            self.channel.cancel()
            self.modeler = ""
            self.modeler_changed.emit()

    def hold(self, held: bool) -> None:
        """Keep the tool in the hand while a gesture is made with it.

        Parameters
        ----------
        held : bool
            Whether one is under way. What is chosen meanwhile, by a number key for example, is
            taken when it ends: a stroke belongs to the tool with which it was begun.
        """
        self._is_held = held
        if not held and self._chosen is not None:
            take, self._chosen = self._chosen, None
            take()

    def take_modeler(self, modeler_id: str) -> None:
        """Draw with another modeler; waiting ink stays."""
        if self._is_held:
            self._chosen = partial(self.take_modeler, modeler_id)
        elif modeler_id != self.modeler:
            self.channel.cancel()
            self.prefer(modeler_id)
            self.ask_for_tools()

    def prefer(self, modeler_id: str) -> None:
        """Draw with another modeler, without asking for its tools yet."""
        self.modeler, self.tools, self.tool = modeler_id, self._known.get(modeler_id, ()), ""
        self.modeler_changed.emit()

    def ask_for_tools(self) -> None:
        """Ask for the tools of the active modeler, whose plugin is imported for that.

        Those that are known stand at once: a worker may still be importing another plugin.
        """
        bench, modeler_id = self._workbench, self.modeler
        if self.tools and not self.tool:
            self.take_first_tool()
        if self.tools or not modeler_id:
            return
        info = self._registry.info(modeler_id)

        def work(job: Job) -> tuple[ToolInfo, ...]:
            return tuple(
                ToolInfo(
                    tool.id,
                    tool.title,
                    info.folder / tool.icon if tool.icon else None,
                    tool.hint,
                    tool.gesture,
                    tool.aims,
                    tool.grabs,
                    tool.plays,
                    tool.hovers,
                    tool.group,
                    overrides(tool, "step"),
                    overrides(tool, "tap"),
                )
                for tool in bench.tools(modeler_id)
            )

        def found(tools: tuple[ToolInfo, ...]) -> None:
            self._known[modeler_id] = tools
            if self.modeler == modeler_id:
                self.tools = tools
                self.modeler_changed.emit()
                self.take_first_tool()

        self.channel.submit(Request(work, found, self._notices.complain))

    def drop_if_gone(self) -> None:
        """Replace the active modeler by the first one if its plugin was switched off."""
        self._known.clear()
        gone = self.modeler
        if not gone or any(info.id == gone for info in self.modelers):
            return
        title = self._registry.info(gone).title
        if self.modelers:
            other = self.modelers[0]
            self.take_modeler(other.id)
            words = tr(
                "Session",
                "{title} is switched off; you draw with {other} now. Its objects stay as they are.",
                title=title,
                other=other.title,
            )
        else:
            self.channel.cancel()
            self.modeler, self.tools, self.tool = "", (), ""
            self.modeler_changed.emit()
            words = tr(
                "Session",
                "{title} is switched off, and there is no other modeler. Switch one on to draw.",
                title=title,
            )
        self._notices.tell(words)

    def take_tool(self, tool_id: str) -> None:
        """Draw with another tool of the active modeler."""
        if self._is_held:
            self._chosen = partial(self.take_tool, tool_id)
            return
        for tool in self.tools:
            if tool.id == tool_id == self.tool:
                words = tr("Session", "“{title}” is the active tool already.", title=tool.title)
                self._notices.tell(words)
            elif tool.id == tool_id:
                self.tool = tool_id
                if tool.group:
                    self.last_used[tool.group] = tool_id
                self.tool_changed.emit()

    def take_group(self, place: int) -> None:
        """Draw with the tool that the button at a place of the rail shows; again, with the next."""
        group = self.groups[place]
        if self.tool in group:
            self.take_tool(group.after(self.tool).id)
        else:
            self.take_tool(group.tool_of(self.last_used.get(group.title, "")).id)

    def take_first_tool(self) -> None:
        """Draw with the first tool of the active modeler."""
        if self.tools and not self.has_first_tool:
            self.take_tool(self.tools[0].id)

    def tool_for(self, gesture: Literal["ink", "tap", "drag"]) -> str:
        """Return the id of the tool that gets a gesture.

        Drags of handles go to a tool that takes drags, the active one before others;
        everything else to the active tool.
        """
        if gesture == "drag":
            takers = [tool.id for tool in self.tools if tool.gesture == "drag"]
            if takers and self.tool not in takers:
                return takers[0]
        return self.tool

    def hint_of(self, tool_id: str) -> str:
        """Return the hint of a tool; "" if the active modeler has no such tool."""
        return next((tool.hint for tool in self.tools if tool.id == tool_id), "")

    def hint_and_more(self, tool_id: str) -> str:
        """Return the hint of a tool, and what else can be done once there is an object."""
        return tr(
            "Session",
            "{hint} Middle button or Alt + pen turns. Enter starts a new object.",
            hint=self.hint_of(tool_id),
        ).strip()

    def _selection_changed(self) -> None:
        """Draw with the modeler of the selected model."""
        model = self._selection.model
        if model is not None and any(info.id == model.modeler for info in self.modelers):
            self.take_modeler(model.modeler)
