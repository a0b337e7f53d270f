"""Steps: how a drawing was made, one gesture or one change after the other.

The fields are those of the file (docs/ink-format.md). Strokes are named by their place in
the drawing, counted from 0; parts by their names, "" being the one that is chosen.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from bozzetto.view.camera import Camera

Value = bool | int | float | str | tuple[int, int, int] | None
"""Value of a parameter."""


@dataclass(frozen=True)
class DrawStep:
    """Strokes drawn with a tool, all at once."""

    tool: str
    strokes: tuple[int, ...]


@dataclass(frozen=True)
class DragStep:
    """The handle `drag` taken along a stroke by a tool."""

    tool: str
    drag: str
    stroke: int
    shift: bool = False
    ctrl: bool = False


@dataclass(frozen=True)
class TapStep:
    """A touch at (x, y), pixels, with a tool; without a camera through the sheet's."""

    tool: str
    tap: tuple[float, float]
    shift: bool = False
    ctrl: bool = False
    camera: Camera | None = None


@dataclass(frozen=True)
class SetStep:
    """Parameters changed, of a part or as ``--set`` does."""

    set: Mapping[str, Value]
    part: str = ""


@dataclass(frozen=True)
class SelectStep:
    """Another part chosen; "" for none."""

    select: str


@dataclass(frozen=True)
class RenameStep:
    """A part called something else."""

    rename: str
    part: str = ""


@dataclass(frozen=True)
class ShowStep:
    """A part shown or hidden."""

    show: bool
    part: str = ""


@dataclass(frozen=True)
class DeleteStep:
    """A part taken out, with what is in it."""

    delete: str


@dataclass(frozen=True)
class DuplicateStep:
    """A part copied, with what is in it."""

    duplicate: str


@dataclass(frozen=True)
class MoveStep:
    """A part put into a group ("" for none), before what is `at` there, from 0."""

    move: str
    at: int
    into: str = ""


@dataclass(frozen=True)
class GroupStep:
    """Parts put into a new group."""

    group: tuple[str, ...]


@dataclass(frozen=True)
class UngroupStep:
    """A group dissolved; what is in it stays."""

    ungroup: str


@dataclass(frozen=True)
class CommandStep:
    """A command of the modeler run."""

    command: str


@dataclass(frozen=True)
class AddStep:
    """A drawing of another file added to the model, by the name of the file."""

    add: str


Step = (
    DrawStep
    | DragStep
    | TapStep
    | SetStep
    | SelectStep
    | RenameStep
    | ShowStep
    | DeleteStep
    | DuplicateStep
    | MoveStep
    | GroupStep
    | UngroupStep
    | CommandStep
    | AddStep
)
