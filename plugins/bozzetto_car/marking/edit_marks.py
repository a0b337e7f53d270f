"""What marking does to a sketch: marks set, moved and taken away, nodes passed over, sides.

Nobody should have to think of left and right. A sketch is taken to show the left side until
both wheels of that side are marked; if the nose points the other way then, every mark changes
sides.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto_car.state import CarState, Mark, Sketch
from bozzetto_car.template.model import Template, twin


def sketch_in_work(state: CarState) -> Sketch:
    """The sketch that is marked.

    Raises
    ------
    UserError
        If there is none.
    """
    sketch = state.sketch
    if sketch is None:
        raise UserError("There is no sketch to mark. Drop a picture on the sheet first.")
    return sketch


def set_mark(
    state: CarState, node: str, place: tuple[float, float], template: Template
) -> CarState:
    """With a node of the sketch in work marked, or its mark moved.

    Parameters
    ----------
    state : CarState
    node : str
    place : (u, v)
        Pixels of the picture; beside it is good, too.
    template : Template
        That of the car: it knows the wheels, by which the sides are told.
    """
    sketch = sketch_in_work(state)
    mark = Mark(node, float(place[0]), float(place[1]))
    marks = tuple(mark if old.node == node else old for old in sketch.marks)
    if sketch.mark_of(node) is None:
        marks = (*marks, mark)
    skipped = tuple(name for name in sketch.skipped if name != node)
    made = replace(sketch, marks=marks, skipped=skipped)
    if node in near_wheels(made, template) and _nose_points_the_other_way(made, template):
        made = with_sides_exchanged(made)
    return replace(state.with_node(made), asked="")


def near_wheels(sketch: Sketch, template: Template) -> tuple[str, str]:
    """The front and the rear wheel on the side that a sketch shows."""
    column = 0 if sketch.shows == "R" else 1
    front, rear = template.wheels[:, column].tolist()
    return template.names[front], template.names[rear]


def _nose_points_the_other_way(sketch: Sketch, template: Template) -> bool:
    """Whether the near wheels stand in the order that only the other side shows.

    A line along the car on the side that is seen runs to the right from the nose where that is
    the left side, from whatever height and however far ahead or behind it is seen.
    """
    front, rear = (sketch.mark_of(name) for name in near_wheels(sketch, template))
    if front is None or rear is None:
        return False
    return front.u > rear.u if sketch.shows == "L" else front.u < rear.u


def with_sides_exchanged(sketch: Sketch) -> Sketch:
    """With all marks, and what was passed over, on the other side of the car."""
    return replace(
        sketch,
        marks=tuple(replace(mark, node=twin(mark.node)) for mark in sketch.marks),
        skipped=tuple(twin(node) for node in sketch.skipped),
        shows="R" if sketch.shows == "L" else "L",
    )


def without_marks(state: CarState, nodes: Collection[str]) -> CarState:
    """With some marks of the sketch in work taken away."""
    sketch = sketch_in_work(state)
    left = tuple(mark for mark in sketch.marks if mark.node not in nodes)
    return state.with_node(replace(sketch, marks=left))


def without_last_mark(state: CarState) -> CarState:
    """With the newest mark of the sketch in work taken away; its node is asked for again.

    Raises
    ------
    UserError
        If there is no mark.
    """
    sketch = sketch_in_work(state)
    if not sketch.marks:
        raise UserError("There is no mark to remove. Touch the point that is asked for first.")
    last = sketch.marks[-1].node
    return replace(without_marks(state, {last}), asked=last)


def with_skipped(state: CarState, nodes: Collection[str]) -> CarState:
    """With nodes noted as not to be seen in the sketch in work; marks that are set stay."""
    sketch = sketch_in_work(state)
    known = {*sketch.skipped, *(mark.node for mark in sketch.marks)}
    more = tuple(node for node in nodes if node not in known)
    return replace(state.with_node(replace(sketch, skipped=(*sketch.skipped, *more))), asked="")


def with_all_asked(state: CarState) -> CarState:
    """With nothing noted as not to be seen in the sketch in work: all is asked for again."""
    return state.with_node(replace(sketch_in_work(state), skipped=()))


def with_asked(state: CarState, node: str) -> CarState:
    """With a node asked for next in the sketch in work, which is chosen."""
    sketch = sketch_in_work(state)
    return replace(state, asked=node, selected=sketch.id)
