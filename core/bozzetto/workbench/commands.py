"""Commands of modelers, found and run through the guard."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
        if model.locked or isinstance(model.state, OpaqueState):
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
            If the model is locked, the command means nothing now, or as the command says.
        PluginFault
        """
        if model.locked:
            raise UserError(f"“{model.name}” is locked. Unlock it in the object list first.")
        if not self.can_run(model, command):
            raise UserError(f"“{command.title}” cannot be done here now. {command.help}".rstrip())
        own = context.moved(model.placement.inverse())
        state = self._registry.guarded(model.modeler).run(command, model.state, own)
        return with_state(self._registry, model, state)
