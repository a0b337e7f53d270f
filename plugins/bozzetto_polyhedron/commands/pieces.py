"""Commands on the bodies of other objects: they come apart in their pieces, and together again."""

from __future__ import annotations

from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto.plugin import Context, NextStep
from bozzetto_polyhedron.model.fittings import Fitting
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.followed import MOST_BODIES, Sources, divided_of, siblings_of
from bozzetto_polyhedron.solve.spots import hung_on


def take_apart(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with every piece of the chosen body a body of its own.

    What was the whole keeps the largest piece.
    """
    body = _chosen(state)
    whole = divided_of(body, context.sources)
    if whole is None or len(whole.names) < 2:
        raise _one_piece(body)
    if len(whole.names) > MOST_BODIES:
        raise UserError(
            f"“{body.name}” has {len(whole.names)} pieces. Touch those that are to move with the "
            "tool “Free a piece”."
        )
    kept = whole.names[whole.largest]
    for name in whole.names:
        if name != kept and _freed(state, body, name) is None:
            state = freed(state, body, name)
    return replace(at_rest_again(state), selected=body.id)


def put_together(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with the chosen body and all that was taken off it one body again."""
    body = _chosen(state)
    pieces = [each for each in siblings_of(body, state) if each.piece]
    if not pieces:
        raise UserError(f"“{body.name}” is together. Take it apart first.")
    whole = next((each for each in siblings_of(body, state) if not each.piece), None)
    if whole is None:
        raise UserError(f"What “{body.name}” was taken off is no longer there. Undo, or delete it.")
    for piece in pieces:
        state = returned(state, piece)
    return replace(state, selected=whole.id)


def has_followed(state: PolyhedronState) -> bool:
    """Return whether there are bodies of other objects."""
    return bool(state.of_kind(Followed))


def step_of_followed(state: PolyhedronState) -> NextStep:
    """Return how bodies of other objects become a mechanism: free, hinged, pulled."""
    if len(state.shown(Followed)) < 2:
        return NextStep(
            "Free what is to move: with “Free a piece” touch a limb, a door or a lid.", tool="free"
        )
    if not state.of_kind(Fitting):
        return NextStep(
            "Draw a “Hinge” along its axis, or right across a limb, where a piece is to turn.",
            tool="hinge",
        )
    return NextStep("Pull a piece with “Move”, or press P to play.", tool="move")


def touched_piece(
    state: PolyhedronState, sources: Sources, body: Followed, name: str
) -> PolyhedronState:
    """Return the state with a piece free, or part of the whole again if it was free.

    Raises
    ------
    UserError
        If it is all that is left of its body.
    """
    known = _freed(state, body, name)
    if known is not None:
        return returned(state, known)
    whole = divided_of(body, sources)
    if whole is None or len(whole.names) < 2:
        raise _one_piece(body)
    free = {each.piece for each in siblings_of(body, state)} | {name}
    if free.issuperset(whole.names):
        raise UserError("Nothing else is left of this body. Touch another piece of it.")
    return at_rest_again(freed(state, body, name))


def freed(state: PolyhedronState, body: Followed, name: str) -> PolyhedronState:
    """Return the state with a piece of a body as one of its own, chosen."""
    called = name if all(node.name != name for node in state.nodes) else state.unused_name(name)
    piece = replace(body, id=state.unused_id(), name=called, piece=name, anchors=())
    return state.with_node(piece)


def returned(state: PolyhedronState, piece: Followed) -> PolyhedronState:
    """Return the state without a free piece, and without what was joined to it."""
    gone = [each.id for each in hung_on(piece.id, state)]
    return at_rest_again(state.without_nodes(piece.id, *gone))


def at_rest_again(state: PolyhedronState) -> PolyhedronState:
    """Return the state at rest: what moved had other bodies."""
    return replace(state, moved=None, grab=None, recorded=None)


def _one_piece(body: Followed) -> UserError:
    return UserError(
        f"“{body.name}” is one piece. Draw it in several parts where it is made, or let it be one "
        "body."
    )


def _freed(state: PolyhedronState, body: Followed, name: str) -> Followed | None:
    return next((each for each in siblings_of(body, state) if each.piece == name), None)


def _chosen(state: PolyhedronState) -> Followed:
    """Return the chosen body of another object, or the only one."""
    bodies = state.of_kind(Followed)
    chosen = state.chosen_of(Followed)
    if chosen is None and len(bodies) == 1:
        chosen = bodies[0]
    if chosen is None:
        raise UserError("Choose a body of another object in the list first.")
    return chosen
