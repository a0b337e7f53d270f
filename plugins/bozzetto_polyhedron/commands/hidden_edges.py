"""Command that guesses the hidden edges of a drawing of visible ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.errors import UserError
from bozzetto.ink import Strokes
from bozzetto.plugin import Context
from bozzetto_polyhedron.commands.answers import chosen_body
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.reconstruction.hidden_lines import hidden_lines
from bozzetto_polyhedron.solve.completion import light_strokes
from bozzetto_polyhedron.solve.pipeline import graph_of_visible_ink, never


def draw_hidden_edges(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with hidden edges of the chosen body drawn lightly.

    They are ink like any other, to be erased or drawn over. Once more, the next guess takes their
    place.

    Raises
    ------
    UserError
        If nothing can be guessed.
    """
    body = chosen_body(state)
    drawn = without_guessed(body)
    guesses = hidden_lines(graph_of_visible_ink(drawn, never), drawn[0].camera) if drawn else ()
    if not guesses:
        raise UserError(
            "The hidden edges cannot be told from these lines. Draw one face of the solid whole, "
            "and an edge that leaves it; or draw the hidden edges lightly yourself."
        )
    again = len(drawn) < len(body.strokes)
    number = (body.guess + 1) % len(guesses) if again else 0
    guessed = light_strokes(tuple(drawn), guesses[number])
    return state.with_node(
        replace(
            body,
            strokes=Strokes([*drawn, *guessed]),
            guessed=Strokes(guessed),
            guess=number,
            choice=None,
            answer=1,
        )
    )


def without_guessed(body: Body) -> Strokes:
    """Return the strokes of a body without guessed ones, if these are still the last as they were.

    Where a person erased some of them or drew on, they are what that person means, and stay.
    """
    count = len(body.guessed)
    last = tuple(body.strokes)[len(body.strokes) - count :] if count else ()
    alike = [
        np.array_equal(one.points, other.points)
        for one, other in zip(last, body.guessed, strict=False)
    ]
    if count and len(alike) == count and all(alike):
        return Strokes(tuple(body.strokes)[:-count])
    return body.strokes
