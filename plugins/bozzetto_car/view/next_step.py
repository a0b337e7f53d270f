"""Next step of a car: the mark that is asked for, and where the sketch expects it."""

from __future__ import annotations

import numpy as np

from bozzetto.plugin import NextStep
from bozzetto.view import triple
from bozzetto_car.body.build import sketch_cameras_of
from bozzetto_car.marking.mark_mesh import next_point
from bozzetto_car.marking.next_mark import asked_of, in_work, next_mark_in_words
from bozzetto_car.solver.nodes_on_mesh import FEWEST
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.state import CarState


def needs_marks(state: CarState) -> bool:
    """Whether sketch or mesh in work have too few marks: nothing else can be done before."""
    if state.mesh is not None:
        return len(state.mesh.points) < FEWEST
    placed = in_work(state, solve_car(state))
    return placed is not None and not placed.is_known


def next_mark_step(state: CarState) -> NextStep:
    """Return the next mark; the panel, which shows the point on a car, comes with the first."""
    if state.mesh is not None:
        return next_point(state)
    solved = solve_car(state)
    placed, asked = in_work(state, solved), asked_of(state, solved)
    place = None
    if placed is not None and asked is not None and asked.place is not None and not asked.hidden:
        at = sketch_cameras_of(state)[placed.sketch.id].lifted(asked.place[None])
        place = triple(at) if np.isfinite(at).all() else None
    is_first = placed is not None and not placed.sketch.marks
    words = next_mark_in_words(state, solved)
    return NextStep(words, place, panel=is_first, on_picture=place is not None)
