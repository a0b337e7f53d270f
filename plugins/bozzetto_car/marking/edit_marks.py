"""Edits of a sketch: marks set, moved and removed, nodes skipped, sides exchanged.

A person need not think of left and right. A sketch is taken to show the left side until both
wheels of that side are marked; if the nose then points the other way, every mark changes sides.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto_car.state import CarState, Mark, Sketch
from bozzetto_car.template.model import Template, twin


def sketch_in_work(state: CarState) -> Sketch:
    """Return the sketch that is marked.

    Raises
    ------
    UserError
        If the car has no sketch.
    """
    sketch = state.sketch
    if sketch is None:
        raise UserError("There is no sketch to mark. Drop a picture on the sheet first.")
    return sketch


def unlocked_sketch(state: CarState) -> Sketch:
    """Return the sketch that is marked, to change its marks.

    Raises
    ------
    UserError
        If the car has no sketch, or it is locked.
    """
    sketch = sketch_in_work(state)
    if sketch.locked:
        raise UserError(f"“{sketch.name}” is locked. Unlock it in the object list to mark it.")
    return sketch


def set_mark(
    state: CarState, node: str, place: tuple[float, float], template: Template
) -> CarState:
    """Return the state with a node of the sketch in work marked, or its mark moved.

    Parameters
    ----------
    state : CarState
        The car.
    node : str
        Name of the node.
    place : (u, v)
        Pixels of the picture; places beside it are allowed.
    template : Template
        The template of the car; its wheels tell the sides.

    Raises
    ------
    UserError
        If there is no sketch, or it is locked.
    """
    sketch = unlocked_sketch(state)
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
    """Return the front and the rear wheel on the side that a sketch shows."""
    column = 0 if sketch.shows == "R" else 1
    front, rear = template.wheels[:, column].tolist()
    return template.names[front], template.names[rear]


def _nose_points_the_other_way(sketch: Sketch, template: Template) -> bool:
    """Whether the near wheels stand in the order that only the other side shows.

    On the left side of a car, a line along the car runs from the nose to the right in the view,
    from any height and from any place ahead or behind.
    """
    front, rear = (sketch.mark_of(name) for name in near_wheels(sketch, template))
    if front is None or rear is None:
        return False
    return front.u > rear.u if sketch.shows == "L" else front.u < rear.u


def with_sides_exchanged(sketch: Sketch) -> Sketch:
    """Return the sketch with all marks and skipped nodes on the other side of the car."""
    return replace(
        sketch,
        marks=tuple(replace(mark, node=twin(mark.node)) for mark in sketch.marks),
        skipped=tuple(twin(node) for node in sketch.skipped),
        shows="R" if sketch.shows == "L" else "L",
    )


def without_marks(state: CarState, nodes: Collection[str]) -> CarState:
    """Return the state without some marks of the sketch in work."""
    sketch = unlocked_sketch(state)
    left = tuple(mark for mark in sketch.marks if mark.node not in nodes)
    return state.with_node(replace(sketch, marks=left))


def without_last_mark(state: CarState) -> CarState:
    """Return the state without the newest mark of the sketch in work, and ask for it again.

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
    """Return the state with nodes noted as not visible in the sketch; marks that are set stay."""
    sketch = sketch_in_work(state)
    known = {*sketch.skipped, *(mark.node for mark in sketch.marks)}
    more = tuple(node for node in nodes if node not in known)
    return replace(state.with_node(replace(sketch, skipped=(*sketch.skipped, *more))), asked="")


def with_all_asked(state: CarState) -> CarState:
    """Return the state with no node noted as not visible in the sketch in work."""
    return state.with_node(replace(sketch_in_work(state), skipped=()))


def with_asked(state: CarState, node: str) -> CarState:
    """Return the state that asks for a node next in the sketch in work, which is chosen."""
    sketch = sketch_in_work(state)
    return replace(state, asked=node, selected=sketch.id)
