"""The mark that is asked for next, its title, and where the sketch will show it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto_car.camera.visibility import facing, on_their_side
from bozzetto_car.marking.edit_marks import near_wheels
from bozzetto_car.marking.mark_prediction import expected
from bozzetto_car.marking.view_guess import likely_on_their_side, likely_shown
from bozzetto_car.solver.initial_cameras import FEWEST, Placed
from bozzetto_car.solver.pipeline import Solved
from bozzetto_car.solver.prior import extent
from bozzetto_car.solver.template_ranking import likelier_template
from bozzetto_car.state import CarState, Sketch
from bozzetto_car.template.model import Template

HIDDEN: Final = "This sketch is hidden. Show it to mark it."

ALL_MARKED: Final = "All points are marked. Drag a mark to move it, or add another sketch."

EXCHANGED: Final = (
    "Left and right seem to be exchanged. The command “Exchange left and right” puts it right."
)
"""Message for marks that fit a mirrored car."""

NO_CAR: Final = (
    "No car has these marks: they are missed by {:.0f} px. Some may be on other points; drag them "
    "to their own."
)
"""Message for marks that no camera sees on any car."""

BESIDE: Final = 0.12
"""Distance of nodes beside each other, in diagonals of the car: less than 60 cm."""

SIDES: Final = {"L": "left", "R": "right"}


@dataclass(frozen=True, eq=False)
class Asked:
    """The node that is to be marked.

    Attributes
    ----------
    node : str
    place : (2,) float or None
        Expected place in the picture, px; None while the camera is not known.
    ellipse : (2, 2) float or None
        Half axes, px, as rows, of the region that holds the place with a probability of 90 %.
    hidden : bool
        Whether the node is on a side of the car that this sketch does not show.
    """

    node: str
    place: Array | None = None
    ellipse: Array | None = None
    hidden: bool = False


def in_work(state: CarState, solved: Solved) -> Placed | None:
    """Return the solved sketch in work, with all that the person has set on it.

    A solve is remembered by the marks, so that its sketches may come from a state with other
    skipped nodes or another side shown.
    """
    sketch = state.sketch
    placed = None if sketch is None else solved.placed.get(sketch.id)
    return None if sketch is None or placed is None else replace(placed, sketch=sketch)


def asked_of(state: CarState, solved: Solved) -> Asked | None:
    """Return the node to mark next in the sketch in work; None if it has all.

    It is the node that the person chose, or the next one of `open_nodes`.
    """
    placed = in_work(state, solved)
    if placed is None:
        return None
    template = solved.template
    shown = shown_nodes(placed, solved)
    if state.asked in template.node:
        return _described(template.node[state.asked], placed, solved, shown)
    rest = open_nodes(placed, solved)
    return _described(rest[0], placed, solved, shown) if rest else None


def open_nodes(placed: Placed, solved: Solved) -> tuple[int, ...]:
    """Return the nodes that are neither marked nor noted as not visible, in the order of asking.

    The order is the template's. It continues from the newest mark and wraps around, so that
    skipped nodes come again, but not at once. Nodes on a side of the car that the sketch does not
    show come last, and before them those that it shows from where nobody can tell them. Before
    its camera is known these are the likely ones, and a node in the middle of the car beside one
    that is marked waits, for it tells next to nothing of the camera.
    """
    template, sketch = solved.template, placed.sketch
    order = _order_after_newest(sketch, template)
    done = {mark.node for mark in sketch.marks} | {*sketch.skipped}
    rest = [node for node in order if template.names[node] not in done]
    shown = shown_nodes(placed, solved)
    if shown is None:
        shown, near = likely_shown(template, sketch), likely_on_their_side(template, sketch)
        near &= ~_beside_a_mark(sketch, template)
    else:
        near = on_their_side(template, solved.positions, placed.sketch_camera.camera)
    return tuple(sorted(rest, key=lambda node: (not shown[node], not near[node])))


def _beside_a_mark(sketch: Sketch, template: Template) -> Flags:
    """Which nodes in the middle of the car are beside a marked one there, (n,)."""
    beside = np.zeros(len(template.names), bool)
    middle = template.centre
    marked = [node for node in middle.tolist() if sketch.mark_of(template.names[node])]
    away = template.positions[middle][:, None] - template.positions[marked]
    close = np.linalg.norm(away, axis=2) < BESIDE * extent(template)
    beside[middle] = close.any(axis=1)
    return beside


def neighbour_of(asked: str, step: int, placed: Placed, solved: Solved) -> str:
    """Return the node one step before (-1) or after (1) another in the template's order.

    Forward leads only to open nodes, backward to all, so that a mark can be set again.
    """
    template, sketch = solved.template, placed.sketch
    order = [template.names[node] for node in template.asked(sketch.shows)]
    if asked not in order:
        return order[0]
    if step > 0:
        left = {template.names[node] for node in open_nodes(placed, solved)}
        begin = order.index(asked) + 1
        later = (name for name in (*order[begin:], *order[:begin]) if name in left)
        return next(later, asked)
    return order[order.index(asked) - 1]


def _order_after_newest(sketch: Sketch, template: Template) -> tuple[int, ...]:
    order = template.asked(sketch.shows)
    newest = sketch.marks[-1].node if sketch.marks else ""
    if newest not in template.node:
        return order
    begin = order.index(template.node[newest]) + 1
    return (*order[begin:], *order[:begin])


def shown_nodes(placed: Placed, solved: Solved) -> Flags | None:
    """Which nodes a sketch shows, (n,); None while that is not known."""
    if not placed.is_known:
        return None
    return facing(solved.template, solved.positions, placed.sketch_camera.camera)


def _described(node: int, placed: Placed, solved: Solved, shown: Flags | None) -> Asked:
    name = solved.template.names[node]
    if shown is None:
        return Asked(name)
    places = expected(solved, placed.sketch.id, node)
    if places is None:
        return Asked(name, hidden=True)
    return Asked(name, places.pixels[0], places.ellipses()[0], hidden=not bool(shown[node]))


# -- in words --------------------------------------------------------------------------------------


def side_of(node: str, sketch: Sketch) -> str:
    """Return ``near side`` or ``far side`` for a sketch; "" for a node in the middle."""
    _, _, side = node.partition(".")
    if not side:
        return ""
    return "near side" if side == sketch.shows else "far side"


def node_title(node: str, sketch: Sketch, template: Template) -> str:
    """Return the title of a node in a sketch: ``Front wheel, near side``."""
    title = template.titles.get(node, node)
    side = side_of(node, sketch)
    return f"{title}, {side}" if side else title


def problem_of(placed: Placed) -> str:
    """Return what is wrong with the camera that the marks give; "" while there are too few."""
    if placed.problem and len(placed.sketch.marks) >= FEWEST:
        return placed.problem
    if placed.exchanged:
        return EXCHANGED
    return "" if placed.misfit is None else NO_CAR.format(placed.misfit)


def next_mark_in_words(state: CarState, solved: Solved) -> str:
    """Return which mark is next, what it will bring, and what is wrong with those there are."""
    placed = in_work(state, solved)
    if placed is None:
        return HIDDEN if state.sketch is not None else "Drop a sketch of a car on the sheet."
    asked = asked_of(state, solved)
    words = (ALL_MARKED,) if asked is None else tuple(_sentences(asked, placed, solved))
    return " ".join(filter(None, (*words, problem_of(placed), *doubts(placed, solved))))


def doubts(placed: Placed, solved: Solved) -> Iterator[str]:
    """Yield which marks of a sketch are set aside, and which template would suit it better."""
    for node in placed.disagreeing:
        title = node_title(node, placed.sketch, solved.template)
        off = (placed.left_out or {}).get(node)
        far = "" if off is None else f" by {off:.0f} px"
        yield f"The mark “{title}” disagrees with the others{far} and is left aside: drag it."
    likelier = likelier_template(solved) if placed.is_known else None
    if likelier is not None:
        yield f"This looks like {likelier.article} {likelier.noun}: choose that template."


def _sentences(asked: Asked, placed: Placed, solved: Solved) -> Iterator[str]:
    template, sketch = solved.template, placed.sketch
    prompt = template.prompts.get(asked.node, template.titles.get(asked.node, asked.node))
    side = side_of(asked.node, sketch)
    yield f"Touch: {prompt}{f', on the {side}' if side else ''}."
    front, rear = near_wheels(sketch, template)
    newest = sketch.marks[-1].node if sketch.marks else ""
    if newest in (front, rear) and sketch.mark_of(front) and sketch.mark_of(rear):
        yield f"This is the {SIDES[sketch.shows]} side of the car."
    if asked.hidden:
        yield "It is not seen from here: skip it, unless the drawing shows it."
    missing = FEWEST - len(sketch.marks)
    if missing > 0:
        yield f"The camera is found with {missing} more {'mark' if missing == 1 else 'marks'}."
