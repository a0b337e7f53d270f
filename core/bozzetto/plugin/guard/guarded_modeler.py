"""A modeler behind the guard: every method calls it, and checks what came back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from bozzetto.errors import UserError
from bozzetto.geometry.shapes import Curve, Shapes
from bozzetto.plugin.guard import answer_validation as validation
from bozzetto.plugin.guard.earlier_plugins import with_job
from bozzetto.plugin.guard.scene_validation import sound_scene
from bozzetto.plugin.guard.shape_validation import sound_shapes
from bozzetto.plugin.overrides import overrides
from bozzetto.plugin.part_tree import PartTree
from bozzetto.plugin.parts import Group, PartsModeler, PartsState
from bozzetto.plugin.tool import method_for

if TYPE_CHECKING:
    from bozzetto.images.stored_picture import Picture
    from bozzetto.ink.drawing import Drawing
    from bozzetto.ink.stroke import Strokes
    from bozzetto.plugin.cautions import Caution
    from bozzetto.plugin.commands import Command
    from bozzetto.plugin.context import Context
    from bozzetto.plugin.gesture import Drag, Gesture
    from bozzetto.plugin.guard.guard import Guard
    from bozzetto.plugin.job import Job
    from bozzetto.plugin.modeler import Modeler
    from bozzetto.plugin.next_step import NextStep
    from bozzetto.plugin.tool import Preview, Tool
    from bozzetto.plugin.view_advice import ViewAdvice
    from bozzetto.scene.display_list import Scene
    from bozzetto.view.camera import Camera

Answer = TypeVar("Answer")


class GuardedModeler:
    """A modeler as the host calls it.

    What a method returns can be stored, shown or handed over. All of them raise `UserError`,
    `Unfinished` and `Cancelled` as the modeler says, and `PluginFault` where it fails otherwise.
    May be used from any thread.

    Parameters
    ----------
    guard : Guard
        Which every call passes.
    modeler : Modeler
        What is called.
    """

    def __init__(self, guard: Guard, modeler: Modeler[Any, Any]) -> None:
        self._guard = guard
        self._modeler: Any = modeler
        self.id = modeler.id

    # -- states --

    def create(self, context: Context) -> Any:
        """Return a new, empty model's state."""
        return self._state("create", self._modeler.create, context)

    def read_drawing(self, drawing: Drawing, context: Context, job: Job) -> Any:
        """Return a state from a whole drawing."""
        read = self._modeler.read_drawing
        return self._state("read_drawing", read, *with_job(read, drawing, context, job=job))

    def read_shapes(self, shapes: Shapes) -> Any:
        """Return a state from meshes and curves."""
        return self._state("read_shapes", self._modeler.read_shapes, shapes)

    def add_picture(self, state: Any, picture: Picture, context: Context) -> Any:
        """Return the state with one more picture."""
        return self._state("add_picture", self._modeler.add_picture, state, picture, context)

    def add_drawing(self, state: Any, drawing: Drawing, context: Context) -> Any:
        """Return the state with a drawing in it."""
        return self._state("add_drawing", self._modeler.add_drawing, state, drawing, context)

    def ink(self, state: Any) -> Strokes:
        """Return the strokes that a state was drawn with."""
        return self._checked("ink", validation.sound_ink, self._modeler.ink, state)

    # -- links --

    def follow(self, sources: Mapping[str, Shapes]) -> Any:
        """Return a state that follows models."""
        state = self._state("follow", self._modeler.follow, sources)
        unknown = sorted(set(self.sources(state)) - set(sources))
        if unknown:
            raise self._guard.blame(self.id, f"follow names {unknown[0]!r}, which was not given")
        return state

    def sources(self, state: Any) -> tuple[str, ...]:
        """Return the ids of the models that a state is made from."""
        if not overrides(self._modeler, "sources"):
            return ()
        return self._checked("sources", validation.sound_sources, self._modeler.sources, state)

    def with_sources(self, state: Any, sources: tuple[str, ...]) -> Any:
        """Return a state with other sources."""
        if sources == self.sources(state):
            return state
        changed = self._state("with_sources", self._modeler.with_sources, state, sources)
        if self.sources(changed) != sources:
            raise self._guard.blame(self.id, "with_sources gave a state with other sources")
        return changed

    # -- states, changed --

    def change(self, state: Any, change: Callable[[Any], Any]) -> Any:
        """Return what a function makes of a state; the state's own check of itself may fail."""
        return self._state("its state", change, state)

    def is_same(self, one: Any, other: Any) -> bool:
        """Whether two states are the same by value."""
        return self._guard.call(self.id, "its state", lambda one, two: bool(one == two), one, other)

    # -- gestures --

    def tools(self) -> tuple[Tool[Any], ...]:
        """Return all tools."""
        return self._checked("tools", validation.sound_tools, self._modeler.tools)

    def apply(self, tool: Tool[Any], state: Any, gesture: Gesture, context: Context) -> Any:
        """Return the state after a gesture."""
        name = f"{tool.id}.{method_for(gesture)}"
        return self._state(name, tool.apply, state, gesture, context)

    def begin(self, tool: Tool[Any], state: Any, context: Context) -> Preview[Any]:
        """Return the preview of a gesture that begins."""
        name = f"{tool.id}.begin"
        return self._checked(name, validation.sound_preview, tool.begin, state, context)

    def preview(self, preview: Preview[Any], gesture: Gesture) -> Scene:
        """Return what a preview shows of the gesture so far."""

        def update(gesture: Gesture, state: Any, context: Context) -> Scene:
            return preview.update(gesture)

        world = (gesture, preview.state, preview.context)  # what the tool may not change
        return self._checked(f"{preview.tool.id}.preview", sound_scene, update, *world)

    def step(
        self, tool: Tool[Any], state: Any, held: Drag | None, seconds: float, context: Context
    ) -> Any:
        """Return the state a moment later."""
        return self._state(f"{tool.id}.step", tool.step, state, held, seconds, context)

    def next_step(self, state: Any, tool: Tool[Any]) -> NextStep:
        """Return what to do next with a tool."""
        return self._checked(
            "next_step", validation.sound_next_step, self._modeler.next_step, state, tool
        )

    def recorded(self, state: Any) -> tuple[float, ...]:
        """Return the times at which a state has recorded how it moved."""
        return self._checked("recorded", validation.sound_times, self._modeler.recorded, state)

    def replayed(self, state: Any, seconds: float) -> Any:
        """Return the state as it was at a time of its recording."""
        return self._state("replayed", self._modeler.replayed, state, seconds)

    # -- commands --

    def commands(self) -> tuple[Command, ...]:
        """Return all commands."""
        return self._checked("commands", validation.sound_commands, self._modeler.commands)

    def can_run(self, command: Command, state: Any) -> bool:
        """Whether a command means something now."""
        name = f"{command.id}.enabled"
        return self._guard.call(self.id, name, lambda now: bool(command.enabled(now)), state)

    def run(self, command: Command, state: Any, context: Context) -> Any:
        """Return the state after a command."""
        return self._state(f"{command.id}.run", command.run, state, context)

    def written(self, command: Command, state: Any, context: Context) -> bytes:
        """Return the content of the file that a command writes."""
        name = f"{command.id}.run"
        return self._checked(name, validation.sound_content, command.run, state, context)

    # -- results --

    def solve(self, state: Any, job: Job) -> Any:
        """Return the result; only its modeler can read it."""
        return self._guard.call(self.id, "solve", self._modeler.solve, state, job)

    def scene(self, state: Any, result: Any | None) -> Scene:
        """Return what to show."""
        return self._checked("scene", sound_scene, self._modeler.scene, state, result)

    def shapes(self, state: Any, result: Any) -> Shapes:
        """Return what to hand over."""
        return self._checked("shapes", sound_shapes, self._modeler.shapes, state, result)

    def curves(self, state: Any, result: Any) -> tuple[Curve, ...]:
        """Return what others may snap to."""

        def sound(curves: Iterable[Curve]) -> tuple[Curve, ...]:
            return sound_shapes(Shapes(curves=tuple(curves))).curves

        return self._checked("curves", sound, self._modeler.curves, state, result)

    def report(self, state: Any, result: Any, job: Job) -> dict[str, Any]:
        """Return how good a result is."""
        report = self._modeler.report
        arguments = with_job(report, state, result, job=job)
        return self._checked("report", validation.sound_report, report, *arguments)

    def cautions(self, state: Any, result: Any) -> tuple[Caution, ...]:
        """Return what a person must know of a result."""
        return self._checked(
            "cautions", validation.sound_cautions, self._modeler.cautions, state, result
        )

    # -- the view --

    def view_advice(self, state: Any, camera: Camera, job: Job) -> ViewAdvice | None:
        """Return advice on a view; None where it does not matter."""
        advise = self._modeler.view_advice
        arguments = with_job(advise, state, camera, job=job)
        return self._checked("view_advice", validation.sound_advice, advise, *arguments)

    def advice_on_result(
        self, state: Any, result: Any, camera: Camera, seen: tuple[Any, ...]
    ) -> ViewAdvice | None:
        """Return advice on a view that follows from a result; None where it does not matter."""
        return self._checked(
            "advice_on_result", validation.sound_advice, self._modeler.advice_on_result,
            state, result, camera, seen,
        )  # fmt: skip

    def view_after(self, seen: Any, state: Any, camera: Camera) -> Camera | None:
        """Return the view that a pinned view becomes; None where it may stay."""
        return self._checked(
            "view_after", validation.sound_view, self._modeler.view_after, seen, state, camera
        )

    # -- parts --

    def parts(self, state: Any) -> PartTree | None:
        """Return the parts of a state; None where it has none."""
        if not (isinstance(self._modeler, PartsModeler) and isinstance(state, PartsState)):
            return None
        return self._checked("parts", validation.sound_parts, _tree_of, state)

    def with_parts(self, state: Any, change: Callable[[PartTree], PartTree]) -> Any:
        """Return a state of which the parts were changed.

        Raises
        ------
        UserError
            If there are no parts, or as the change says.
        """
        modeler, tree = self._modeler, self.parts(state)
        if tree is None or not isinstance(modeler, PartsModeler):
            raise UserError("This object is not made of parts.")

        def changed(state: Any) -> Any:
            new = change(tree)
            return modeler.with_parts(state, new.parts, new.selected)

        return self._state("with_parts", changed, state)

    def grouped(self, state: Any, part_ids: tuple[str, ...]) -> Any:
        """Return a state with parts in a new group.

        Raises
        ------
        UserError
            If its parts cannot be grouped.
        """

        def change(tree: PartTree) -> PartTree:
            group = self._modeler.new_group(state)
            if group is None:
                raise UserError("The parts of this object cannot be grouped.")
            return tree.grouped(part_ids, group)

        return self.with_parts(state, change)

    def ungrouped(self, state: Any, group_id: str) -> Any:
        """Return a state with a group dissolved."""
        return self.with_parts(state, lambda tree: tree.ungrouped(group_id, self._modeler.released))

    # -- inside --

    def _state(self, what: str, function: Callable[..., Any], *arguments: Any) -> Any:
        state = self._guard.call(self.id, what, function, *arguments)
        before = arguments[0] if isinstance(arguments[0], self._modeler.state_type) else None
        self.check_state(state, what, before)
        return state

    def check_state(self, state: Any, what: str, before: Any = None) -> None:
        """Refuse a state of another type, or one that a document could not store.

        Parameters
        ----------
        state : object
            What was given as a state.
        what : str
            Who gave it, for the message.
        before : object, optional
            The state that it was made from, which saves time; see `check_encodable`.

        Raises
        ------
        PluginFault
        """
        from bozzetto.document.storage.state_codec import check_encodable

        kind = self._modeler.state_type
        self._guard.check(self.id, what, lambda: check_encodable(kind, state, before))

    def _checked(
        self,
        what: str,
        sound: Callable[[Any], Answer],
        function: Callable[..., Any],
        *arguments: Any,
    ) -> Answer:
        answer = self._guard.call(self.id, what, function, *arguments)
        return self._guard.check(self.id, what, lambda: sound(answer))


def _tree_of(state: PartsState) -> PartTree:
    groups = frozenset(node.id for node in state.nodes if isinstance(node, Group))
    return PartTree(state.nodes, groups, state.selected)
