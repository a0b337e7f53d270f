"""Tools as the tool rail shows them: tools of one group share a button."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Literal, NamedTuple

import msgspec

__all__ = ["TOOL_KEYS", "ToolGroup", "ToolInfo", "groups_of", "keys_of"]

TOOL_KEYS = "1234567890"
"""The keys that take the tools of a modeler: one for each button of the rail, in their order."""


class ToolInfo(NamedTuple):
    """A tool as the tool rail shows it."""

    id: str
    title: str
    icon: Path | None
    hint: str
    gesture: Literal["ink", "tap", "drag"]
    aims: bool = False
    grabs: bool = False
    plays: bool = False
    hovers: bool = False
    group: str = ""
    """These five: see `bozzetto.plugin.Tool`."""
    moves: bool = False
    """Whether it has a `Tool.step` of its own."""
    touches: bool = False
    """Whether it has a `Tool.tap` of its own."""


class ToolGroup(msgspec.Struct, frozen=True):
    """The tools behind one button of the rail.

    Parameters
    ----------
    title : str
        Name of the group; that of the tool where there is only one.
    tools : tuple of ToolInfo
        At least one, in the modeler's order.
    """

    title: str
    tools: tuple[ToolInfo, ...]

    def __contains__(self, tool_id: str) -> bool:
        return any(tool.id == tool_id for tool in self.tools)

    def tool_of(self, *wanted: str) -> ToolInfo:
        """Return the first tool of these ids that is in the group; else its first tool."""
        of_id = {tool.id: tool for tool in self.tools}
        return next((of_id[one] for one in wanted if one in of_id), self.tools[0])

    def after(self, tool_id: str) -> ToolInfo:
        """Return the tool behind another one, the first behind the last."""
        ids = [tool.id for tool in self.tools]
        return self.tools[(ids.index(tool_id) + 1) % len(ids)]


def groups_of(tools: Iterable[ToolInfo]) -> tuple[ToolGroup, ...]:
    """Return the buttons of the rail, each at the place of the first tool of its group."""
    found: dict[str, list[ToolInfo]] = {}
    for tool in tools:
        found.setdefault(f"group {tool.group}" if tool.group else f"tool {tool.id}", []).append(
            tool
        )
    return tuple(
        ToolGroup(some[0].group if len(some) > 1 else some[0].title, tuple(some))
        for some in found.values()
    )


def keys_of(groups: Iterable[ToolGroup]) -> Mapping[str, str]:
    """Return the key of each tool that has one, by id: pressed again, it takes the next one."""
    return {
        tool.id: key for group, key in zip(groups, TOOL_KEYS, strict=False) for tool in group.tools
    }
