"""The commands in the order of the menu."""

from __future__ import annotations

from collections.abc import Sequence

from bozzetto.plugin import Command
from bozzetto_polyhedron.commands.answers import has_body, mirrored_answer, next_answer
from bozzetto_polyhedron.commands.bodies import (
    begin_body,
    equal_lengths,
    on_the_ground,
    right_angles,
    sheet,
    unfolded,
)
from bozzetto_polyhedron.commands.hidden_edges import draw_hidden_edges
from bozzetto_polyhedron.commands.motion import at_rest, forget, has_moved, is_recorded, swing
from bozzetto_polyhedron.commands.pieces import has_followed, put_together, take_apart


def all_commands() -> Sequence[Command]:
    """Return the commands, most used first."""
    return (
        Command(
            "next-answer",
            "Next answer",
            "Show the next solid that the drawing could mean, the likeliest first.",
            next_answer,
            key="X",
            enabled=has_body,
        ),
        Command(
            "mirrored-answer",
            "Exchange near and far",
            "Turn the solid inside out in depth: the drawing means both (Necker's cube).",
            mirrored_answer,
            key="C",
            enabled=has_body,
        ),
        Command(
            "hidden-edges",
            "Draw hidden edges",
            "Guess the hidden edges and draw them lightly. Once more: another guess.",
            draw_hidden_edges,
            enabled=has_body,
        ),
        Command(
            "new-body",
            "Begin a new body",
            "The next stroke that is not on a drawing begins a body of its own.",
            begin_body,
            enabled=has_body,
        ),
        Command(
            "ground",
            "Stand on the ground",
            "Turn the chosen body upright and put it down on the ground.",
            on_the_ground,
            key="Shift+G",
            enabled=has_body,
        ),
        Command(
            "swing",
            "Swing what is free",
            "Push a mechanism into the next way in which it can move; play to see it.",
            swing,
            enabled=has_body,
        ),
        Command(
            "rest",
            "Back to rest",
            "Put everything that was moved back to where it was drawn.",
            at_rest,
            enabled=has_moved,
        ),
        Command(
            "forget",
            "Forget the recording",
            "Throw away how things moved, with the traces; they stay where they are.",
            forget,
            enabled=is_recorded,
        ),
        Command(
            "take-apart",
            "Take apart",
            "Make each limb, door or panel of the chosen body of another object move by itself.",
            take_apart,
            enabled=has_followed,
        ),
        Command(
            "put-together",
            "Put together",
            "Make the chosen body of another object one piece again.",
            put_together,
            enabled=has_followed,
        ),
        Command(
            "right-angles",
            "Right angles on or off",
            "Make angles that are nearly right exactly right, or leave them as drawn.",
            right_angles,
        ),
        Command(
            "equal-lengths",
            "Equal lengths on or off",
            "Make lengths that are nearly equal exactly equal, or leave them as drawn.",
            equal_lengths,
        ),
        Command(
            "sheet",
            "Sheet or solid",
            "Make the faces of the chosen body sheets with a thickness, or all of it solid again.",
            sheet,
            enabled=has_body,
        ),
        Command(
            "unfold",
            "Unfold or solid",
            "Give files the faces laid flat at true size, to cut and fold, or the solids again.",
            unfolded,
            enabled=has_body,
        ),
    )
