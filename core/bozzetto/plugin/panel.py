"""Host of a plugin's own panel: what it may know of the program, and ask of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from bozzetto.errors import UserError
    from bozzetto.plugin.commands import Command
    from bozzetto.plugin.host.listing import TemplateFile
    from bozzetto.plugin.next_step import NextStep


class PanelHost(Protocol):
    """Access of a plugin's Qt panel to the object that is selected.

    Use it on the thread of the window only.
    """

    @property
    def state(self) -> Any | None:
        """The selected object's state; None while none of this modeler is selected."""
        ...

    @property
    def next_step(self) -> NextStep:
        """Next step, as every other place of the window says it; see `Modeler.next_step`."""
        ...

    @property
    def templates(self) -> Sequence[TemplateFile]:
        """Files that plugins bring for models of this modeler to begin with; nobody has read them.

        See ``[templates]`` of the manifest.
        """
        ...

    def change(self, state: Any, label: str, *, going: bool = False) -> None:
        """Put another state in its place, as one step of the history called `label`.

        What cannot be done is told to the person, and the state stays as it was.

        Parameters
        ----------
        state : State
            The new state.
        label : str
            Name of the step.
        going : bool
            Whether more of the same follows, as while a slider is dragged: all such changes of one
            label and the one that ends them are one step.
        """
        ...

    def run(self, command: Command) -> None:
        """Change the state by a command, beside the window: for what takes more than a moment.

        It runs like those of `Modeler.commands`, of which it need not be one: after what was drawn
        before, with the world around as its context, and as one step of the history.
        """
        ...

    def complain(self, problem: UserError) -> None:
        """Tell the person why something cannot be done, as every other refusal is told."""
        ...

    def on_change(self, callback: Callable[[], None]) -> None:
        """Have a function called whenever `state` or `next_step` has become another."""
        ...
