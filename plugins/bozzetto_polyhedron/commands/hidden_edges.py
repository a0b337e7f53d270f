"""Command that guesses the hidden edges of a drawing of visible ones."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.ink import Strokes
from bozzetto.plugin import Context
from bozzetto_polyhedron.commands.answers import chosen_body
from bozzetto_polyhedron.graph.line_graph import FindingKind, LineGraph
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.reconstruction.hidden_lines import hidden_lines
from bozzetto_polyhedron.solve.completion import light_strokes
from bozzetto_polyhedron.solve.pipeline import graph_of_visible_ink, never

FEWEST_LINES: Final = 5
"""Visible lines of a tetrahedron; no solid shows fewer."""

_YOURSELF: Final = "or draw the hidden edges lightly yourself."

_TOO_FEW: Final = (
    "The hidden edges cannot be told from so few lines. Draw one face of the solid whole, "
    f"and an edge that leaves it; {_YOURSELF}"
)

_NOTHING_FITS: Final = (
    "No solid was found of which just these lines are seen, so nothing is guessed. Draw the "
    f"outline all round, and each edge as far as it is seen; {_YOURSELF}"
)

_REASONS: Final[tuple[tuple[FindingKind, str], ...]] = (
    (
        "curved stroke",
        "Hidden edges are guessed of solids with straight edges, and the stroke that is marked is "
        f"curved. Erase it and draw it straight; {_YOURSELF}",
    ),
    (
        "loose end",
        "Hidden edges cannot be guessed while a line ends alone, as marked. Draw it as far as it "
        f"is seen: to a corner, or to the edge behind which it goes; {_YOURSELF}",
    ),
    (
        "gap",
        "Hidden edges cannot be guessed while there is a gap, as marked. Draw the line across it; "
        f"{_YOURSELF}",
    ),
)
"""What a finding of a kind says of a drawing for which there is no guess."""


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
    drawn = body.drawn
    if not drawn:
        raise UserError(_TOO_FEW)
    graph = graph_of_visible_ink(drawn, body.evidence, never)
    guesses = hidden_lines(graph, drawn[0].camera)
    if not guesses:
        raise UserError(_why_none(graph))
    again = len(drawn) < len(body.strokes)
    number = (body.guess + 1) % len(guesses) if again else 0
    guessed = light_strokes(tuple(drawn), guesses[number])
    return state.with_node(
        replace(
            body,
            strokes=Strokes([*drawn, *guessed]),
            guessed=Strokes(guessed),
            guess=number,
            guess_certainty=guesses[number].certainty,
            choice=None,
            answer=1,
        )
    )


def _why_none(graph: LineGraph) -> str:
    """Return what a person can do where no solid was found."""
    degrees = np.bincount(graph.lines.ravel(), minlength=len(graph.places))
    if len(graph.lines) < FEWEST_LINES:
        return _TOO_FEW
    if (degrees >= 3).all():
        return "No edge is missing: three lines or more meet at every corner."
    found = {each.what for each in graph.health}
    for what, sentence in _REASONS:
        if what in found:
            return sentence
    return _NOTHING_FITS
