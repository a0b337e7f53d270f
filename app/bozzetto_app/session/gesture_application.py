"""The ink that a tool tries, and a gesture applied to a model: pure functions for workers."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from bozzetto.document.waiting_ink import Waiting, strokes_of
from bozzetto.errors import Unfinished, UserError
from bozzetto.plugin.gesture import Ink
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto_app.i18n import tr
from bozzetto_app.session.selection import target_of, why_locked

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.ink.stroke import Stroke
    from bozzetto.plugin.context import Context
    from bozzetto.plugin.gesture import Gesture
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.workbench import Workbench

__all__ = ["Attempt", "NotTaken", "Outcome", "apply_first", "ink_to_try"]


class Attempt(NamedTuple):
    """Gestures to be tried one after the other, until a tool takes one.

    Attributes
    ----------
    gestures : tuple of Gesture
    selected : Model, optional
        The selected model when the attempt begins.
    modeler, tool : str
        "" is the first tool of the modeler: the person was quicker than its import.
    context : Context
    """

    gestures: tuple[Gesture, ...]
    selected: Model | None
    modeler: str
    tool: str
    context: Context


class Outcome(NamedTuple):
    """The result of a gesture: `model` replaces `base`, or is new if there is none.

    Attributes
    ----------
    gesture : Gesture
    base : Model, optional
    model : Model
    label : str
        Name of the step of the history.
    tool : str
        Id of the tool that took the gesture.
    only_chosen : bool
        Whether only the choice of a part differs.
    changed : bool
        Whether anything differs at all.
    """

    gesture: Gesture
    base: Model | None
    model: Model
    label: str
    tool: str
    only_chosen: bool
    changed: bool


class NotTaken(Exception):
    """Ink that a tool did not take.

    Attributes
    ----------
    problem : UserError, Unfinished or PluginFault
        Why not.
    tool : str
    strokes : tuple of Stroke
        The strokes that it concerns.
    """

    def __init__(self, problem: BaseException, tool: str, strokes: tuple[Stroke, ...]) -> None:
        super().__init__(str(problem))
        self.problem, self.tool, self.strokes = problem, tool, strokes


def apply_first(bench: Workbench, attempt: Attempt, job: Job) -> Outcome:
    """Apply the first gesture that the tool takes.

    Raises
    ------
    NotTaken
        If the tool takes none; it carries the fault of a plugin, or else what is still
        missing, or else why the last gesture was refused.
    UserError, Unfinished, PluginFault
        The same for a gesture that is not kept, such as a tap or an eraser's path.
    """
    answers: list[NotTaken] = []
    for gesture in attempt.gestures:
        try:
            return _applied(bench, gesture, attempt, job)
        except (UserError, Unfinished, PluginFault) as problem:
            if not isinstance(gesture, Ink) or gesture.strokes[-1].tool == "eraser":
                raise
            answers.append(NotTaken(problem, attempt.tool, gesture.strokes))
            if isinstance(problem, PluginFault):
                break
    faults = [answer for answer in answers if isinstance(answer.problem, PluginFault)]
    unfinished = [answer for answer in answers if isinstance(answer.problem, Unfinished)]
    raise (faults or unfinished or answers)[-1]


def _applied(bench: Workbench, gesture: Gesture, attempt: Attempt, job: Job) -> Outcome:
    modeler, context = attempt.modeler, attempt.context
    base = target_of(attempt.selected, modeler)
    if base is None and not isinstance(gesture, Ink):
        _refuse_closed(attempt.selected, modeler)
    model = base or bench.create(modeler, context)
    if attempt.tool:
        tool = bench.tool(modeler, attempt.tool)
    else:
        tools = bench.tools(modeler)
        if not tools:
            title = bench.registry.info(modeler).title
            said = tr("Session", "{title} takes no ink. Choose another modeler.", title=title)
            raise UserError(said)
        tool = tools[0]
    job.checkpoint(0.0, tool.title)
    made = bench.apply(model, tool, gesture, context)
    only_chosen = base is not None and bench.parts.only_choice_differs(base, made)
    changed = base is None or bench.differs(base, made, only_chosen=only_chosen)
    return Outcome(gesture, base, made, tool.title, tool.id, only_chosen, changed)


def _refuse_closed(model: Model | None, modeler_id: str) -> None:
    """Refuse taps and drags while the model that they are meant for is locked or hidden.

    Raises
    ------
    UserError
        Ink may still start a new object; a tap can only mean the selected one.
    """
    if model is None or model.modeler != modeler_id:
        return
    if model.locked:
        raise UserError(why_locked())
    if not model.visible:
        raise UserError(tr("Session", "This object is hidden. Show it to change it."))


def ink_to_try(
    waiting: Waiting, until: Stroke, modeler: str, tool: str, *, committed: bool
) -> tuple[tuple[Stroke, ...], ...]:
    """Return the waiting ink that goes to a tool, and what is tried if it is not taken.

    Ink waits for the tool that it was drawn for; only Enter hands it to another tool, if the
    active one has no ink of its own. A stroke is tried together with refused ink, which it
    may mend, and without, for refused ink must not block other ink. Ink that a plugin failed
    over is tried again at Enter only, by itself.

    Parameters
    ----------
    waiting : tuple of WaitingStroke
        All ink that waits, oldest first.
    until : Stroke
        The newest one to be tried.
    modeler, tool : str
        The modeler and the tool that get it.
    committed : bool
        Whether the person said that this is all.

    Returns
    -------
    tuple of tuple of Stroke
        Empty if `until` no longer waits.
    """
    places = [place for place, one in enumerate(waiting, 1) if one.stroke is until]
    if not places:
        return ()
    drawn = waiting[: places[0]]
    own = tuple(one for one in drawn if one.is_for(modeler, tool))
    if committed:
        own = own or drawn
        own = tuple(one for one in own if one.status != "failed") or own
    else:
        own = tuple(one for one in own if one.status != "failed" or one.stroke is until)
    good = tuple(one for one in own if not one.is_marked)
    tries = [own, good] if good and len(good) < len(own) else [own]
    return tuple(map(strokes_of, tries)) if own else ()
