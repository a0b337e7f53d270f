"""Commands on the answers of a drawing: the next one, and the one turned inside out."""

from __future__ import annotations

from dataclasses import replace

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import Context
from bozzetto_polyhedron.model.assign_stroke import parted
from bozzetto_polyhedron.model.same_view import camera_of
from bozzetto_polyhedron.model.state import Body, Choice, PolyhedronState
from bozzetto_polyhedron.solve.choice import choice_of, mirrored_number
from bozzetto_polyhedron.solve.pipeline import Solved, solved
from bozzetto_polyhedron.solve.standing import stood


def chosen_body(state: PolyhedronState) -> Body:
    """Return the body that is chosen, or the one that what is chosen belongs to.

    Raises
    ------
    UserError
        If there is none.
    """
    wanted = state.body_of_chosen()
    bodies = [body for body in state.of_kind(Body) if len(body.strokes)]
    for body in bodies:
        if body.id == wanted:
            return body
    if len(bodies) == 1:
        return bodies[0]
    raise UserError("No body is chosen. Choose one in the list.")


def has_body(state: PolyhedronState) -> bool:
    """Return whether there is a body that a command could mean."""
    return any(len(body.strokes) for body in state.of_kind(Body))


def with_answer(
    state: PolyhedronState, body: Body, number: int, *, alone: bool = False
) -> PolyhedronState:
    """Return the state with another answer of a body, counted from 0 and round.

    Where nothing else is visible (`alone`) its sheet stands on the ground then; see `stood`.

    Raises
    ------
    UserError
        If the drawing has no answer.
    """
    found = _answered(body, state)
    number %= len(found.answers)
    choice = choice_of(found.answers, number)
    made = state.with_node(replace(body, choice=choice, answer=number + 1))
    return stood(state, made, body.id) if alone else made


def first_answer(
    state: PolyhedronState, body: Body, place: Array | None = None, *, alone: bool = False
) -> PolyhedronState:
    """Return the state with a drawing turned into a solid, and others beside it in their bodies.

    Parameters
    ----------
    state : PolyhedronState
        With the body in it.
    body : Body
        Which nobody turned yet.
    place : (2,) array, optional
        Of its drawing, px: which one is turned where several lie beside one another.
    alone : bool
        See `with_answer`.

    Raises
    ------
    UserError
        If the drawing has no answer.
    """
    state, body = parted(state, body, place)
    return with_answer(state, body, max(_answered(body, state).number, 0), alone=alone)


def next_answer(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with the next answer of the chosen body; a drawing is turned first."""
    body = chosen_body(state)
    if body.choice is None:
        return first_answer(state, body, alone=context.alone)
    found = _answered(body, state)
    if len(found.answers) == 1:
        raise UserError("This drawing has only this answer. Draw the hidden edges lightly.")
    return with_answer(state, body, found.number + 1, alone=context.alone)


def mirrored_answer(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with the answer in which near and far are exchanged."""
    body = chosen_body(state)
    found = _answered(body, state)
    other = mirrored_number(found.answers, found.number, camera_of(body).axes[2])
    if other is None:
        raise UserError(
            "No answer has near and far exchanged: the light lines say which side is which. "
            "Set hidden edges to “Drawn like the others” to have both."
        )
    return with_answer(state, body, other, alone=context.alone)


def _answered(body: Body, state: PolyhedronState) -> Solved:
    found = solved(replace(body, choice=body.choice or Choice()), state)
    if not found.answers:
        raise UserError(found.problem or "These lines make no shape yet. Draw on.")
    return found
