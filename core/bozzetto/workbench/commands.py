"""Commands of modelers, found and run through the guard."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from bozzetto.atomic_files import write_bytes
from bozzetto.document.model import Model, OpaqueState
from bozzetto.errors import UserError
from bozzetto.workbench.links import with_state

if TYPE_CHECKING:
    from bozzetto.plugin.commands import Command
    from bozzetto.plugin.context import Context
    from bozzetto.plugin.host.registry import Registry


class ModelCommands:
    """Commands of modelers, run on models; see `bozzetto.plugin.Command`.

    Parameters
    ----------
    registry : Registry
        Where modelers come from, and the guard.

    Notes
    -----
    All methods may be called from any thread; what goes wrong in a plugin is a `PluginFault`.
    """

    def __init__(self, registry: Registry) -> None:
        self._registry = registry

    def of(self, modeler_id: str) -> tuple[Command, ...]:
        """Return all commands of a modeler; empty where it has none."""
        return self._registry.guarded(modeler_id).commands()

    def find(self, modeler_id: str, command_id: str) -> Command:
        """Return a command by its id.

        Raises
        ------
        UserError
            If the modeler has no such command; it names those that there are.
        """
        known = self.of(modeler_id)
        for command in known:
            if command.id == command_id:
                return command
        title = self._registry.info(modeler_id).title
        there = ", ".join(command.id for command in known) or "none"
        raise UserError(f"{title} has no command {command_id!r}; there are: {there}.")

    def can_run(self, model: Model, command: Command) -> bool:
        """Whether a command means something to a model as it is."""
        if isinstance(model.state, OpaqueState) or (model.locked and not command.writes):
            return False
        return self._registry.guarded(model.modeler).can_run(command, model.state)

    def run(self, model: Model, command: Command, context: Context) -> Model:
        """Return the model after a command.

        Parameters
        ----------
        model : Model
            The model before.
        command : Command
            One of the modeler's commands.
        context : Context
            In the world; the command gets it in the model's own frame.

        Raises
        ------
        UserError
            If the model is locked, the command means nothing now or writes a file, or as the
            command says.
        PluginFault
        """
        if model.locked:
            raise UserError(f"“{model.name}” is locked. Unlock it in the object list first.")
        if command.writes:
            raise UserError(f"“{command.title}” writes a file, and changes nothing. Say where to.")
        own = self._own_context(model, command, context)
        state = self._registry.guarded(model.modeler).run(command, model.state, own)
        return with_state(self._registry, model, state)

    def content(self, model: Model, command: Command, context: Context, name: str) -> bytes:
        """Return the content of the file that a command writes.

        Parameters
        ----------
        model, command, context
            As in `run`; a locked model may be written, for nothing of it changes.
        name : str
            Name of the file, without its ending.

        Raises
        ------
        UserError
            If the command means nothing now or writes no file, or as the command says.
        PluginFault
        """
        if not command.writes:
            raise UserError(f"“{command.title}” writes no file. It changes the object.")
        own = replace(self._own_context(model, command, context), file=name)
        return self._registry.guarded(model.modeler).written(command, model.state, own)

    def write(self, model: Model, command: Command, context: Context, path: Path) -> None:
        """Write the file of a command that writes one, as a whole or not at all.

        A file of that name is replaced; whoever asks for the place has asked about that.

        Raises
        ------
        UserError
            As `content` does, or if the name has another ending or cannot be written.
        PluginFault
        """
        if command.writes and not path.name.lower().endswith(command.writes):
            raise UserError(f"“{command.title}” writes a {command.writes} file. Name it so.")
        stem = path.name[: len(path.name) - len(command.writes)]
        write_bytes(path, self.content(model, command, context, stem))

    def _own_context(self, model: Model, command: Command, context: Context) -> Context:
        """Return the context in the model's own frame, for a command that means something now."""
        if not self.can_run(model, command):
            raise UserError(f"“{command.title}” cannot be done here now. {command.help}".rstrip())
        return context.moved(model.placement.inverse())
