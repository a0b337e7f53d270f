"""Tools of the pen: one gesture makes one new state."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, Generic, Literal, TypeVar, final

from bozzetto.errors import UserError
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.plugin.next_step import NextStep
from bozzetto.plugin.overrides import overrides
from bozzetto.scene.display_list import Scene

if TYPE_CHECKING:
    from bozzetto.plugin.context import Context

State = TypeVar("State")

NOTHING_TO_ERASE: Final = "This tool has nothing that the eraser takes away. Draw with the pen."


def method_for(gesture: Gesture) -> Literal["draw", "erase", "tap", "drag"]:
    """Return the name of the method of a tool that takes a gesture of this kind."""
    if isinstance(gesture, Tap):
        return "tap"
    if isinstance(gesture, Drag):
        return "drag"
    return "erase" if gesture.erases else "draw"


class Preview(Generic[State]):
    """The preview of one gesture; the host makes it when the pen goes down and drops it after.

    What is worked out once for a gesture, or grows with it, belongs into a class derived from
    this one, which `Tool.begin` returns. All calls come from one thread, one after the other.

    Parameters
    ----------
    tool : Tool
        Whose gesture it is.
    state : State
        The model as it is while the gesture goes on.
    context : Context
        The world around.
    """

    def __init__(self, tool: Tool[State], state: State, context: Context) -> None:
        self.tool = tool
        self.state = state
        self.context = context

    def update(self, gesture: Gesture) -> Scene:
        """Return what to show of the gesture so far: cheap, 60 times a second.

        A layer stands in for the layer of that name in the modeler's own scene, until the new
        state is solved; layers of other names are shown besides. Where it raises `UserError` or
        `Unfinished` nothing is shown: odd ink may still become something.

        As it is here it asks `Tool.preview`, and shows nothing of the eraser's path.
        """
        if isinstance(gesture, Ink) and gesture.erases:
            return Scene()
        return self.tool.preview(self.state, gesture, self.context)


class Tool(Generic[State]):
    """Tool of the pen.

    A tool overrides the gestures that it takes: `draw`, `erase`, `tap`, `drag`. The others are
    refused with its `hint`.

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
        The expected gesture, in plain words: the next step unless `next_step` says another one,
        and the reason where a gesture is refused.
    gesture : {"ink", "tap", "drag"}
        The kind of gesture it takes first. Drags of handles always reach a tool whose `gesture`
        is "drag": the active one, or else the first. Such a tool gets a `Tap` where a
        person touches the sheet beside all handles.
    aims : bool
        Whether places have to be met exactly. Beside all handles, the pen may then go down
        anywhere and take its time: the place is where it lifts, and a loupe shows what is under
        it until then. The preview gets the `Tap` as it would be now. The loupe is there, too,
        while a handle is dragged.
    grabs : bool
        Whether a drag may begin anywhere; beside all handles, its `Drag.handle` is "".
    plays : bool
        Whether its `step` goes on while nobody holds it, once a person has started it, until they
        stop it.
    hovers : bool
        Whether the preview gets the `Tap` that a pen near the sheet would make.
    group : str
        Name of its group: tools of one group share a button of the tool rail, which shows the one
        used last, and opens to the others. "" for a button of its own.
    """

    id: str
    title: str
    icon: str = ""
    hint: str
    gesture: Literal["ink", "tap", "drag"] = "ink"
    aims: bool = False
    grabs: bool = False
    plays: bool = False
    hovers: bool = False
    group: str = ""

    # -- what a gesture makes of a state --

    def draw(self, state: State, ink: Ink, context: Context) -> State:
        """Return the state with what was drawn.

        Raises
        ------
        Unfinished
            If ink that is not yet committed needs further strokes.
        UserError
            If the ink cannot be understood; the message says what to do instead.
        """
        raise UserError(self.hint)

    def erase(self, state: State, ink: Ink, context: Context) -> State:
        """Return the state without what the eraser's path lies over.

        Raises
        ------
        UserError
            If there is nothing under it.
        """
        raise UserError(NOTHING_TO_ERASE)

    def tap(self, state: State, tap: Tap, context: Context) -> State:
        """Return the state after a touch.

        Raises
        ------
        UserError
            If there is nothing to touch there.
        """
        raise UserError(self.hint)

    def drag(self, state: State, drag: Drag, context: Context) -> State:
        """Return the state with a handle at another place.

        As it is here a tool of drags that overrides `step` takes the path in steps, as under the
        hand: so do ink files and tests.

        Raises
        ------
        UserError
            If it cannot go there.
        """
        if self.gesture != "drag" or not overrides(self, "step"):
            raise UserError(self.hint)
        from bozzetto.plugin.drag_steps import drag_steps

        for held, seconds in drag_steps(drag):
            state = self.step(state, held, seconds, context)
        return state

    @final
    def apply(self, state: State, gesture: Gesture, context: Context) -> State:
        """Return the state after a gesture: the method that takes gestures of its kind is asked.

        Raises
        ------
        Unfinished, UserError
            As that method says.
        """
        methods: dict[str, Callable[[State, Any, Context], State]] = {
            "tap": self.tap,
            "drag": self.drag,
            "erase": self.erase,
            "draw": self.draw,
        }
        return methods[method_for(gesture)](state, gesture, context)

    # -- time --

    def step(self, state: State, held: Drag | None, seconds: float, context: Context) -> State:
        """Return the state a moment later.

        A tool that overrides it moves what is held: it is called up to 60 times a second, in a
        worker, from the touch to the lift of a drag, in the place of `preview` and `drag`, and
        while the tool `plays`. All of that is one step of the history.

        Parameters
        ----------
        state : State
            The model as the last step left it.
        held : Drag, optional
            The drag so far; None while nobody holds anything.
        seconds : float
            Time since the last step, at most 0.05: where steps take longer, time runs slower.
        context : Context
            The world around.

        Raises
        ------
        UserError
            If it cannot go on; everything stays where it is.
        """
        return state

    # -- while the pen is down --

    def preview(self, state: State, gesture: Gesture, context: Context) -> Scene:
        """Return what to show while the pen is down; see `Preview.update`.

        Never asked for the eraser's path: a tool that shows what would go returns a `Preview` of
        its own from `begin`. Refusals of `draw` or `drag` may pass: nothing is shown then.

        Raises
        ------
        UserError
            If there is nothing to show of the gesture so far.
        """
        return Scene()

    def begin(self, state: State, context: Context) -> Preview[State]:
        """Return the preview of a gesture that begins; by default one that asks `preview`."""
        return Preview(self, state, context)

    # -- in words --

    def next_step(self, state: State) -> NextStep:
        """Return what to do next with this tool; see `Modeler.next_step`."""
        return NextStep(self.hint)
