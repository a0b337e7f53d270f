"""The modeler's contract, in the spirit of model, update, view.

A modeler is a set of pure functions over its state. The state is a frozen dataclass made
of numbers, texts, tuples, `Strokes`, `Camera`, read-only arrays and further frozen
dataclasses: the *recipe* of a shape. The host keeps it, saves it, undoes it, and calls the
functions in a worker; the modeler owns nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Protocol, TypeVar, runtime_checkable

from bozzetto.geometry.shapes import Curve, Shapes
from bozzetto.images.stored_picture import Picture
from bozzetto.ink.drawing import Drawing
from bozzetto.plugin.context import Context
from bozzetto.plugin.gesture import Gesture
from bozzetto.plugin.job import Job
from bozzetto.scene.display_list import Scene

State = TypeVar("State")
Result = TypeVar("Result")


class Tool(Protocol[State]):
    """Tool of the pen: one gesture makes one new state.

    Attributes
    ----------
    id : str
        Unique within the modeler; part of shortcuts and scripts.
    title : str
        Name on hover.
    icon : str
        File name of an SVG in the plugin's package (20 px grid, 1.5 px strokes,
        ``currentColor``), or "" for a letter.
    hint : str
        The next expected gesture, in plain words, for the status line.
    gesture : {"ink", "tap", "drag"}
        The kind of gesture it takes. Drags of handles always reach a tool whose `gesture`
        is "drag": the active one, or else the first. Such a tool gets a `Tap` where a
        person touches the sheet beside all handles.
    """

    id: str
    title: str
    icon: str
    hint: str
    gesture: Literal["ink", "tap", "drag"]

    def preview(self, state: State, gesture: Gesture, context: Context) -> Scene:
        """Return what to show while the pen is down: cheap, and never fails on odd ink.

        A layer stands in for the layer of that name in the modeler's own scene, until the
        new state is solved; layers of other names are shown besides.
        """
        ...

    def apply(self, state: State, gesture: Gesture, context: Context) -> State:
        """Return the new state, on release.

        Raises
        ------
        Unfinished
            If an `Ink` gesture that is not yet committed needs further strokes.
        UserError
            If the gesture cannot be understood; the message says what to do instead.
        """
        ...


class Modeler(Protocol[State, Result]):
    """A way to turn ink into shape.

    Attributes
    ----------
    id : str
        Unique; "author.name".
    title : str
    state_type : type
        The frozen dataclass of its states; documents are read through it.
    state_version : int
        Raised when stored states change shape; see `upgrade`.
    """

    id: str
    title: str
    state_type: type[State]
    state_version: int

    def create(self, context: Context) -> State:
        """Return a new, empty model."""
        ...

    def tools(self) -> Sequence[Tool[State]]:
        """Return the tools, most used first.

        The first one is active at the start, and is taken when a picture comes to a model:
        see `TakesPictures`.
        """
        ...

    def solve(self, state: State, job: Job) -> Result:
        """Solve the model; may be slow.

        Call ``job.checkpoint`` between steps. An empty state must give an empty result.

        Raises
        ------
        UserError
            If this recipe has no solution; the message says what to change.
        """
        ...

    def scene(self, state: State, result: Result | None) -> Scene:
        """Return what to show; `result` is None while the first solve is still running."""
        ...

    def shapes(self, state: State, result: Result) -> Shapes:
        """Return what to hand over to other programs, mm, in the model's own frame."""
        ...

    def upgrade(self, state: dict[str, Any], version: int) -> dict[str, Any]:
        """Turn the stored form of an older version's state into today's."""
        ...


@runtime_checkable
class TellsNext(Protocol):
    """A tool for which the next gesture depends on what is there already."""

    def next_hint(self, state: Any) -> str:
        """Say in plain words what to do next and what to look at; replaces `Tool.hint`.

        Asked in a worker after every change and whenever the tool is taken.
        """
        ...


@runtime_checkable
class Aims(Protocol):
    """A tool with which places have to be met exactly.

    Beside all handles, the pen may go down anywhere and take its time: the place is where it
    lifts, and a loupe shows what is under it until then. `Tool.preview` is asked with the
    `Tap` as it would be now. The loupe is there, too, while a handle is dragged.

    Attributes
    ----------
    aims : bool
        False is as good as not having it.
    """

    aims: bool


@runtime_checkable
class ReadsDrawings(Protocol):
    """A modeler that knows better than "apply my first tool to all the ink"."""

    def read_drawing(self, drawing: Drawing, context: Context) -> Any:
        """Return a state from a whole drawing; used by the command line and by drag and drop."""
        ...


@runtime_checkable
class ReadsShapes(Protocol):
    """A modeler that can start from what another program or another modeler made.

    Its manifest says ``reads_shapes = true``, so that it is offered where a person looks for a
    use of a shape.
    """

    def read_shapes(self, shapes: Shapes) -> Any:
        """Return a state from meshes and curves; raise `UserError` where they are of no use."""
        ...


@runtime_checkable
class TakesPictures(Protocol):
    """A modeler that works on pictures, such as sketches and photographs.

    While a model of it is selected, pictures that are dropped, pasted or opened come to it,
    and not under the sheet.
    """

    def with_picture(self, state: Any, picture: Picture, context: Context) -> Any:
        """Return the state with one more picture; keep it in the state, which documents can store.

        Raises
        ------
        UserError
            If it is of no use, with what to do instead.
        """
        ...


@runtime_checkable
class OffersCurves(Protocol):
    """A modeler whose curves others may want to snap to, or to start from."""

    def curves(self, state: Any, result: Any) -> Sequence[Curve]:
        """Return the curves of a result, mm, in the model's own frame: see `Context.curves`.

        Asked after every solve, in both qualities: quick.
        """
        ...


@runtime_checkable
class Reports(Protocol):
    """A modeler that can say how good its result is."""

    def report(self, state: Any, result: Any) -> Mapping[str, Any]:
        """Return JSON values with readable keys; shown in a panel and written by ``--report``."""
        ...
