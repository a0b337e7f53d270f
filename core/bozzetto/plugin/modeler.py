"""The modeler's contract, in the spirit of model, update, view.

A modeler is a set of pure functions over its state. The state is a frozen dataclass made
of numbers, texts, tuples, `Strokes`, `Camera`, read-only arrays and further frozen
dataclasses: the *recipe* of a shape. The host keeps it, saves it, undoes it, and calls the
functions in a worker; the modeler owns nothing.

What makes something is named by a verb (`create`, `read_shapes`, `solve`); what answers a question
is named by the answer (`scene`, `report`, `next_step`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Final, Generic, TypeVar

from bozzetto.errors import UserError
from bozzetto.plugin.gesture import Ink

if TYPE_CHECKING:
    from bozzetto.geometry.shapes import Curve, Shapes
    from bozzetto.images.stored_picture import Picture
    from bozzetto.ink.drawing import Drawing
    from bozzetto.ink.stroke import Strokes
    from bozzetto.plugin.cautions import Caution
    from bozzetto.plugin.commands import Command
    from bozzetto.plugin.context import Context
    from bozzetto.plugin.figures import Figure
    from bozzetto.plugin.job import Job
    from bozzetto.plugin.next_step import NextStep
    from bozzetto.plugin.tool import Tool
    from bozzetto.plugin.view_advice import ViewAdvice
    from bozzetto.scene.display_list import Scene
    from bozzetto.view.camera import Camera

State = TypeVar("State")
Result = TypeVar("Result")

TAKES_NO_INK: Final = "This modeler takes no ink. Choose another modeler."
NO_STROKES: Final = "The drawing has no strokes. Draw something first."
READS_NO_SHAPES: Final = "This modeler cannot start from what is there. Choose another modeler."
TAKES_NO_DRAWINGS: Final = "Drawings cannot be added to this object. Import the file instead."
TAKES_NO_PICTURES: Final = "This modeler takes no pictures. Choose another modeler."


class Modeler(ABC, Generic[State, Result]):
    """A way to turn ink into shape.

    `solve`, `scene` and `shapes` must be written; every other method has a meaning of its own
    that suits a modeler without that ability. Write `bozzetto.plugin.override` over what you
    write, and a checker of types finds misspelt names. The title, the icon and the samples stand
    in the manifest, as do the abilities that a menu must know before the plugin is imported.

    Attributes
    ----------
    id : str
        Unique; "author.name".
    state_type : type
        The frozen dataclass of its states; documents are read through it.
    state_version : int
        Raised when stored states change shape; see `upgrade`.
    first_parameters : tuple of str
        Parameters that people reach for first, three at most: forms show them first.
    figures : mapping of str to Figure
        Words, units and bounds of what `report` tells, by its keys without their units.
    """

    id: str
    state_type: type[State]
    state_version: int = 1
    first_parameters: ClassVar[tuple[str, ...]] = ()
    figures: ClassVar[Mapping[str, Figure]] = {}

    # -- from state to shape --

    @abstractmethod
    def solve(self, state: State, job: Job) -> Result:
        """Solve the model; may be slow.

        Call ``job.checkpoint`` between steps. An empty state must give an empty result.

        Raises
        ------
        UserError
            If this recipe has no solution; the message says what to change.
        """

    @abstractmethod
    def scene(self, state: State, result: Result | None) -> Scene:
        """Return what to show; `result` is None while the first solve is still running."""

    @abstractmethod
    def shapes(self, state: State, result: Result) -> Shapes:
        """Return what to hand over to other programs, mm, in the model's own frame."""

    def curves(self, state: State, result: Result) -> Sequence[Curve]:
        """Return the curves that others may snap to or start from; see `Context.curves`.

        In mm, in the model's own frame. Asked after every final solve: quick.
        """
        return ()

    def report(self, state: State, result: Result, job: Job) -> Mapping[str, Any]:
        """Return how good the result is, as JSON values by readable keys.

        Shown in a panel in the words of `figures`, and written by ``--report``; numbers and arrays
        of numpy are written as plain ones. May be slow: call ``job.checkpoint`` in its loops.
        """
        return {}

    def cautions(self, state: State, result: Result) -> Sequence[Caution]:
        """Return what a person must know of a result; empty where all is well.

        Asked after a final solve, before shapes are handed over: quick.
        """
        return ()

    # -- states --

    def create(self, context: Context) -> State:
        """Return a new, empty model; by default the state of which nothing is said."""
        return self.state_type()

    def ink(self, state: State) -> Strokes:
        """Return the strokes that a state was drawn with, for other modelers to read.

        In the model's own frame, each with its camera; hidden parts are left out. By default all
        strokes that the state holds, in the order of its fields and parts. Write it where some of
        them are no drawing, or lie elsewhere than their camera says.
        """
        from bozzetto.plugin.state_ink import ink_of_state

        return ink_of_state(state)

    def upgrade(self, state: dict[str, Any], version: int) -> dict[str, Any]:
        """Turn the stored form of an older version's state into today's."""
        return state

    def read_drawing(self, drawing: Drawing, context: Context, job: Job) -> State:
        """Return a state from a whole drawing, for the command line and for drag and drop.

        By default the first tool that draws gets all the ink, and a file without strokes that has
        one of the keys that the manifest names under ``facts`` goes to `create`. May be slow, for
        a file may hold anything: call ``job.checkpoint`` in its loops.

        Raises
        ------
        UserError
            If it makes no model; the message says what to do instead.
        """
        first = next((tool for tool in self.tools() if tool.gesture == "ink"), None)
        if first is None:
            raise UserError(TAKES_NO_INK)
        if not len(drawing.strokes):
            raise UserError(NO_STROKES)
        job.checkpoint(0.0, drawing.name)
        ink = Ink(tuple(drawing.strokes), committed=True)
        return first.apply(self.create(context), ink, context)

    def read_shapes(self, shapes: Shapes) -> State:
        """Return a state from meshes and curves of another program or another modeler.

        The manifest names it among the abilities, so that it is offered where a person looks for
        a use of a shape.

        Raises
        ------
        UserError
            If they are of no use.
        """
        raise UserError(READS_NO_SHAPES)

    def add_picture(self, state: State, picture: Picture, context: Context) -> State:
        """Return the state with one more picture, such as a sketch or a photograph to work on.

        The manifest names it among the abilities. While a model of such a modeler is selected,
        pictures that are dropped, pasted or opened come to it, and not under the sheet. Keep the
        picture in the state: documents can store it.

        Raises
        ------
        UserError
            If it is of no use, with what to do instead.
        """
        raise UserError(TAKES_NO_PICTURES)

    def add_drawing(self, state: State, drawing: Drawing, context: Context) -> State:
        """Return the state with a drawing of another file in it, such as a logo on a surface.

        The manifest names it among the abilities, so that it is offered for models of this
        modeler. Keep what is needed of the strokes in the state.

        Raises
        ------
        UserError
            If it is of no use, with what to do instead.
        """
        raise UserError(TAKES_NO_DRAWINGS)

    # -- links to other models --

    def follow(self, sources: Mapping[str, Shapes]) -> State:
        """Return a state that is made from other models, and follows them when they change.

        The manifest names it among the abilities; write `sources` and `with_sources` with it. It
        is called when a person uses objects as input, instead of `read_shapes`.

        Parameters
        ----------
        sources : mapping of str to Shapes
            What these models hand over now, by their ids, in the order in which they were chosen;
            mm, in the world, where a new model stands. Keep the ids, not the shapes.

        Raises
        ------
        UserError
            If they are of no use.
        """
        raise UserError(READS_NO_SHAPES)

    def sources(self, state: State) -> Sequence[str]:
        """Return the ids of the models that this one is made from; see `Job.sources`.

        Asked whenever the state is exchanged: quick.
        """
        return ()

    def with_sources(self, state: State, sources: Sequence[str]) -> State:
        """Return the state with other sources, as many as `sources` gives and in that order.

        Asked when a model is duplicated together with what it follows.
        """
        return state

    # -- what a person can do --

    def tools(self) -> Sequence[Tool[State]]:
        """Return the tools, most used first.

        The first one is active at the start, and is taken when a picture comes to a model.
        """
        return ()

    def commands(self) -> Sequence[Command]:
        """Return all commands, in the order in which they are listed."""
        return ()

    def next_step(self, state: State, tool: Tool[State]) -> NextStep:
        """Return what to do next, as the model is now, with a tool in the hand.

        Asked in a worker after every change and whenever a tool is taken; by default the tool
        says it.
        """
        return tool.next_step(state)

    # -- what was recorded --

    def recorded(self, state: State) -> Sequence[float]:
        """Return the times at which a state has recorded how it moved, s; empty where it has not.

        They grow. Films show such a recording, and GLB files hold it as an animation; write
        `replayed` with it. Asked where a person may choose it: quick.
        """
        return ()

    def replayed(self, state: State, seconds: float) -> State:
        """Return the state as it was at a time of its recording, from the first to the last.

        Between two times that were recorded it is between both.
        """
        return state

    # -- the view --

    def view_advice(self, state: State, camera: Camera, job: Job) -> ViewAdvice | None:
        """Return advice on a view; None where it does not matter from where one draws.

        Asked up to ten times a second while the view turns. Call ``job.checkpoint`` before what
        may be slow, such as a solve that the advice rests on.
        """
        return None

    def advice_on_result(
        self, state: State, result: Result, camera: Camera, seen: Sequence[Result]
    ) -> ViewAdvice | None:
        """Return advice on a view that follows from a solved model, at whatever quality.

        A modeler that overrides it is asked this, instead of `view_advice` and `view_after`, where
        a result is known: while a value is dragged only previews are known, and to solve for the
        advice would take longer than to show.

        Parameters
        ----------
        state : State
            The model.
        result : Result
            What `solve` made of it, as a preview or finally.
        camera : Camera
            The view now.
        seen : sequence of Result
            Results to which the view was pinned a moment ago, or which it showed as they were
            drawn (`ViewAdvice.as_drawn`), newest first. Where what the view showed of one has
            another camera now, the advice is on the view through that one, which is
            `ViewAdvice.better`, and says `ViewAdvice.follow`.
        """
        return None

    def view_after(self, seen: State, state: State, camera: Camera) -> Camera | None:
        """Return the view that shows of a state what another view showed of an earlier one.

        Asked while a view is pinned (`ViewAdvice.pinned`) and the model has changed since.

        Parameters
        ----------
        seen : State
            As the model was when the view was pinned to it.
        state : State
            As it is now.
        camera : Camera
            The view now.

        Returns
        -------
        Camera or None
            Where the view goes at once; None where it may stay.
        """
        return None
