"""How far rigid pieces were taken from rest, as placements."""

from __future__ import annotations

import numpy as np

from bozzetto.geometry import Placement, Solid, Surface
from bozzetto_polyhedron.mechanism.assembly import Motion
from bozzetto_polyhedron.mechanism.pieces import METRE
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.solve.moving import Moving


def taken_by(made: Moving, number: int, motion: Motion) -> Placement:
    """Return where a body that moves as one piece has been taken."""
    pieces = made.machine.holders[number]
    return placement_of(made, int(pieces[0]), motion) if len(pieces) else Placement()


def followed_part(part: Followed, made: Moving, motion: Motion) -> Solid | Surface:
    """Return a body of another object where its motion has taken it, in its colours."""
    number = made.numbers[part.id]
    groups = made.groups[part.id]
    colors = {group.color for group in groups}
    kind = Solid if made.machine.shapes[number].solid else Surface
    mesh = made.meshes[part.id].placed(taken_by(made, number, motion))
    if len(colors) == 1:  # what is painted shows it where the paint does not cover
        return kind(mesh, part.name, colors.pop())
    return kind(mesh, part.name, groups=groups)


def placement_of(made: Moving, piece: int, motion: Motion) -> Placement:
    """Return where a piece has been taken."""
    turn = motion.turns[piece]
    offset = (motion.places[piece] - turn @ made.machine.rest.places[piece]) / METRE
    if np.array_equal(turn, np.eye(3)) and not offset.any():
        return Placement()
    x, y, z = (float(value) for value in offset)
    return Placement(tuple(float(value) for value in turn.ravel()), 1.0, (x, y, z))
