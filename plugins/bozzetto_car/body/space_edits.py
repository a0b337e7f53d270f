"""How a car that is solved for other dimensions has moved since an edit was made in space."""

from __future__ import annotations

from dataclasses import dataclass, replace

from bozzetto.errors import UserError
from bozzetto.plugin import remembered
from bozzetto_car.body.body import FEW_REMEMBERED, Body
from bozzetto_car.body.deformed import right_after
from bozzetto_car.body.dimension_map import Reshaping
from bozzetto_car.body.edit_list import Edit
from bozzetto_car.body.reshaped import brought_to
from bozzetto_car.body.stretch import reshaping_of, stretch
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.solver.pipeline import Solved, solve_car
from bozzetto_car.state import CarState, TracedEdges


@dataclass(frozen=True, eq=False)
class Moved:
    """How a car that is solved for other dimensions has moved since an edit was made in space.

    Attributes
    ----------
    back : Reshaping or None
        To about the car that it was then; None if it has these dimensions.
    along : float
        How much farther along x it then stands, mm.
    """

    back: Reshaping | None
    along: float


def car_then(edit: Edit, state: CarState) -> CarState | None:
    """Return a car that is solved for what it was solved for when an edit was made in space.

    None where it still is. A stroke on a sketch stays on its line, which the car goes to, and is
    not of space.
    """
    if isinstance(edit, TracedEdges) and edit.sketch:
        return None
    was, is_kept = edit.dimensions, state.lock and bool(state.dimensions.given())
    was_kept = bool(was.given()) and (is_kept if edit.kept is None else edit.kept)
    if was_kept == is_kept and (not is_kept or was == state.dimensions):
        return None
    return replace(
        state, lock=was_kept, length=was.length or 0.0, width=was.width or 0.0,
        height=was.height or 0.0, front_overhang=was.front_overhang or 0.0,
        wheelbase=was.wheelbase or 0.0,
    )  # fmt: skip


def moved_for(edit: Edit, body: Body, state: CarState) -> Moved | None:
    """Return how the car has moved since an edit was made in space; None where it has not."""
    then = car_then(edit, state)
    return None if then is None else _moved_since(body.solved, state, then)


def _moved_since(now: Solved, state: CarState, then: CarState) -> Moved | None:
    """Return how a solved car has moved since it was solved for other dimensions, or for none."""
    if now.joint is None:  # nothing is solved, whatever is kept
        return None
    try:
        return _moved(now, solve_car(then), state, then.dimensions)
    except UserError:  # it cannot have had them, or cannot be stretched to them any more
        return None


@remembered(
    limit=FEW_REMEMBERED,
    key=lambda now, then, state, wanted: (
        (now, then, wanted, state.default_shape, state.annealed, state.smooth, state.joints)
    ),
)
def _moved(now: Solved, then: Solved, state: CarState, wanted: Dimensions) -> Moved:
    own, other = right_after(now, state), right_after(then, state)
    was = brought_to(other, wanted) if wanted.given() else other
    back = reshaping_of(own.network, was.dimensions)
    there = own.network if back is None else stretch(own.network, back)
    return Moved(back, float((there.positions - was.network.positions)[:, 0].mean()))
