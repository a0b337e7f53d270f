"""Entries of the command palette: commands, tools, parameters, objects, documents."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from bozzetto_app.actions.dynamic_menus import RECENT
from bozzetto_app.actions.registry import ActionRegistry, key_text
from bozzetto_app.dialogs.fuzzy_match import Match, match
from bozzetto_app.i18n import tr
from bozzetto_app.session.tool_groups import groups_of, keys_of

if TYPE_CHECKING:
    from bozzetto_app.session.session import Session

__all__ = ["Entry", "Found", "entries_of", "search"]

DISABLED = 6.0
"""Off for what cannot be done now."""

BY_KIND = 3.0
"""Off where the kind's name was needed for the match ("object horse")."""

USED = 2.0
"""For what was used last; less for what was used earlier."""


@dataclass(frozen=True)
class Entry:
    """One line of the palette.

    Attributes
    ----------
    id : str
        Stays the same from one opening to the next.
    title, kind : str
        The person's words; the kind of a command is where it stands in the menus.
    run : callable
    icon : str or Path
    key : str
        As the platform writes it.
    enabled : bool
    """

    id: str
    title: str
    kind: str
    run: Callable[[], object]
    icon: str | Path = ""
    key: str = ""
    enabled: bool = True


@dataclass(frozen=True)
class Found:
    """An entry with how it fits."""

    entry: Entry
    match: Match


def entries_of(
    actions: ActionRegistry,
    session: Session,
    *,
    recent: Sequence[Path],
    open_document: Callable[[Path], object],
    focus_parameter: Callable[[str], object],
) -> Iterator[Entry]:
    """Everything that can be found now."""
    tools = {tool.title for tool in session.toolbox.tools}
    keys = keys_of(groups_of(session.toolbox.tools))
    for tool in session.toolbox.tools:
        yield Entry(
            f"tool {tool.id}",
            tool.title,
            tr("Palette", "Tool"),
            partial(session.toolbox.take_tool, tool.id),
            tool.icon or "pen",
            keys.get(tool.id, ""),
        )
    for action in actions.actions():
        if action.id.startswith("tool.") and tools:
            continue  # the number keys: their tools stand above under their own names
        if action.id.startswith(RECENT):
            continue  # they stand below among the documents
        yield Entry(
            f"command {action.id}",
            action.plain_title,
            " › ".join(action.menu).replace("&", "") or tr("Palette", "Command"),
            partial(actions.run, action.id),
            action.icon or "command",
            key_text(action),
            action.enabled(),
        )
    for info in session.toolbox.modelers:
        yield Entry(
            f"modeler {info.id}",
            info.title,
            tr("Palette", "Modeler"),
            partial(session.toolbox.take_modeler, info.id),
            info.icon,
        )
    for field, _ in (*session.objects.parameters, *session.parts.parameters):
        yield Entry(
            f"parameter {field.name}",
            field.parameter.label,
            tr("Palette", "Parameter"),
            partial(focus_parameter, field.name),
            "sliders",
        )
    for model in session.drawing.document:
        yield Entry(
            f"object {model.id}",
            model.name,
            tr("Palette", "Object"),
            partial(session.selection.select, model.id),
            "cube",
        )
    for path in recent:
        yield Entry(
            f"document {path}",
            path.stem,
            tr("Palette", "Document"),
            partial(open_document, path),
            "recent",
        )


def search(typed: str, entries: Iterable[Entry], used: Sequence[str] = ()) -> list[Found]:
    """Return the entries that match, best first.

    Parameters
    ----------
    typed : str
        Nothing typed shows everything, what was used lately on top.
    entries : iterable of Entry
        What can be found.
    used : sequence of str
        Ids, the latest first.
    """
    found = []
    for entry in entries:
        fit = match(typed, entry.title)
        if fit is None:
            wider = match(typed, f"{entry.title} {entry.kind}")
            if wider is None:
                continue
            inside = tuple(place for place in wider.places if place < len(entry.title))
            fit = Match(wider.score - BY_KIND, inside)
        score = fit.score if typed.strip() else 0.0
        score -= 0.0 if entry.enabled else DISABLED
        if entry.id in used:
            score += USED / (1 + used.index(entry.id))
        found.append(Found(entry, Match(score, fit.places)))
    return sorted(found, key=lambda one: -one.match.score)
