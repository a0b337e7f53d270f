"""Commands: changes of a model, and files made from one, that need no gesture."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from bozzetto.plugin.context import Context


def _always(state: Any) -> bool:
    return True


@dataclass(frozen=True)
class Command:
    """One thing that can be done to a state.

    Parameters
    ----------
    id : str
        Unique within the modeler; steps of ink files name it.
    title : str
        In menus and in the command palette, and the name of the step in the history.
    help : str
        One sentence: what it does, for whom it is there.
    run : callable
        ``run(state, context)`` gives the new state, as `Tool.apply` does; a `UserError` says
        what to do instead. See `writes`.
    key : str
        A key or a combination as Qt writes it, such as "X" or "Shift+J"; "" for none. The
        program's own keys come first: where it has this one, the command has none.
    enabled : callable
        ``enabled(state)``: whether the command means something now. Quick. It is asked of an
        empty state too: commands are there before the first object, and one that means
        something then begins an object.
    writes : str
        Ending of the file that the command writes, such as ".json"; "" where it gives a state.
        With an ending, `run` gives the content of the file, bytes: a person is asked where it
        goes, the command line is told (``--command``), and nothing of the model changes.
    menu : str
        Title of the submenu in which it stands with others of its kind, such as "Curve"; "" for
        the modeler's menu itself.
    """

    id: str
    title: str
    help: str
    run: Callable[[Any, Context], Any]
    key: str = ""
    enabled: Callable[[Any], bool] = _always
    writes: str = ""
    menu: str = ""
