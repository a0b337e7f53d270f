"""Public names that look like a misspelt ability: such an ability is silently never asked for."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from bozzetto.plugin.cautions import Warns
from bozzetto.plugin.commands import HasCommands
from bozzetto.plugin.modeler import (
    Aims,
    Modeler,
    OffersCurves,
    ReadsDrawings,
    ReadsShapes,
    Reports,
    TakesPictures,
    TellsNext,
    Tool,
)
from bozzetto.plugin.parts import HasParts, ReleasesParts
from bozzetto.plugin.view_advice import AdvisesOnResults, AdvisesView, MovesView
from bozzetto.testing.subject import Subject, ensure

MOST_EDITS: Final = 2
"""Letters that may be missing, too many, exchanged or wrong in a misspelt name."""

SHORTEST: Final = 4
"""Letters of a name below which two edits make another word of it."""


def _names(*protocols: Any) -> frozenset[str]:
    return frozenset(
        name
        for protocol in protocols
        for name in (*vars(protocol), *getattr(protocol, "__annotations__", ()))
        if not name.startswith("_")
    )


MODELER_NAMES: Final = _names(
    Modeler, ReadsDrawings, ReadsShapes, TakesPictures, OffersCurves, Reports, Warns,
    HasParts, ReleasesParts, HasCommands, AdvisesView, MovesView,
    AdvisesOnResults,
)  # fmt: skip
"""Public names of the contract of a modeler."""

TOOL_NAMES: Final = _names(Tool, TellsNext, Aims)
"""Public names of the contract of a tool."""


def check_spelling(subject: Subject) -> None:
    """Check that no public attribute is a misspelt ability, which nobody would ever ask for."""
    with subject.shell() as shell:
        modeler = shell.registry.modeler(subject.modeler)
        found = [f"the modeler: {said}" for said in _misspelt(modeler, MODELER_NAMES)]
        for tool in shell.tools():
            found += [f"the tool {tool.id}: {said}" for said in _misspelt(tool, TOOL_NAMES)]
        ensure(
            not found,
            f"{'; '.join(found)}; write it so, or let the name begin with an underscore",
        )


def _misspelt(owner: object, known: frozenset[str]) -> Iterator[str]:
    for name in dir(owner):
        meant = "" if name.startswith("_") or name in known else meant_by(name, known)
        # Who has the ability besides has not misspelt it.
        if meant and not hasattr(owner, meant):
            yield f"{name!r} looks like {meant!r}"


def meant_by(name: str, known: frozenset[str]) -> str:
    """Return the known name that another one is a misspelling of; "" for none."""
    plain = _plain(name)
    for other in sorted(known):
        most = MOST_EDITS if len(other) > SHORTEST else 1
        if _plain(other) == plain or _edits(plain, _plain(other), most) <= most:
            return other
    return ""


def _plain(name: str) -> str:
    return name.replace("_", "").lower()


def _edits(one: str, other: str, most: int) -> int:
    """Count the letters that must be inserted, left out, changed or swapped with the next one.

    The distance of Damerau (1964) with non-overlapping swaps; more than `most` is only told
    as more.
    """
    if abs(len(one) - len(other)) > most:
        return most + 1
    rows = [list(range(len(other) + 1))]
    for i, letter in enumerate(one, 1):
        row = [i]
        for j, wanted in enumerate(other, 1):
            cost = min(row[-1] + 1, rows[-1][j] + 1, rows[-1][j - 1] + (letter != wanted))
            swapped = i > 1 and j > 1 and letter == other[j - 2] and one[i - 2] == wanted
            row.append(min(cost, rows[-2][j - 2] + 1) if swapped else cost)
        rows.append(row)
    return rows[-1][-1]
