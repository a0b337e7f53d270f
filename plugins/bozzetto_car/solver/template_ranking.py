"""Which template a sketched car is nearest to, by the evidence of its marks.

Templates are compared on the marks of points that both have, each with cameras of its own and the
whole mixture of cars and hands (`hyperparameters`), so that a car far from its template is not
another one already.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.plugin import remembered
from bozzetto_car.solver.evidence import linear_sketch
from bozzetto_car.solver.hyperparameters import Weights
from bozzetto_car.solver.initial_cameras import FEWEST, marks_of, place_sketch, view_of
from bozzetto_car.solver.pipeline import Solved
from bozzetto_car.solver.prior import Cost
from bozzetto_car.solver.proportions import SHARED_NODES
from bozzetto_car.state import Sketch
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import Template

LIKELIER: Final = 7.0
"""Gain in probability with another template, as a natural logarithm, from which it is proposed."""

IMPOSSIBLE: Final = -1e9
"""Logarithm of a probability where no camera has the car before it as it is marked."""

ANSWERS: Final = 16
"""Number of answers that are remembered."""


def likelier_template(solved: Solved) -> Template | None:
    """Return the bundled template that the marks of a car are far likelier with; None if none is.

    Parameters
    ----------
    solved : Solved
        The car. One that brings a template of its own is asked for no other.
    """
    own = solved.template
    if own.id not in TEMPLATES or bundled(own.id) is not own:
        return None
    sketches = tuple(placed.sketch for placed in solved.placed.values() if placed.is_known)
    question = (own.id, *((sketch.id, *marks_of(sketch)) for sketch in sketches))
    return _likelier(question, own, sketches)


@remembered(limit=ANSWERS, key=lambda question, own, sketches: question)
def _likelier(question: Hashable, own: Template, sketches: tuple[Sketch, ...]) -> Template | None:
    gains: dict[str, float] = {}
    for name in TEMPLATES:
        other = bundled(name)
        common = [_of_both(sketch, own, other) for sketch in sketches if other is not own]
        if common and all(map(_tells, common, sketches)):
            gains[name] = _probability(other, common) - _probability(own, common)
    best = max(gains, key=lambda name: gains[name], default="")
    return bundled(best) if best and gains[best] > LIKELIER else None


def _of_both(sketch: Sketch, own: Template, other: Template) -> Sketch:
    """Return a sketch with the marks of points that both templates have."""
    both = own.node.keys() & other.node.keys()
    return replace(sketch, marks=tuple(mark for mark in sketch.marks if mark.node in both))


def _tells(common: Sketch, whole: Sketch) -> bool:
    """Whether the marks of points that two templates share are enough to compare them."""
    return len(common.marks) >= max(FEWEST, SHARED_NODES * len(whole.marks))


def _probability(template: Template, sketches: Sequence[Sketch]) -> float:
    """Return the logarithm of the probability of the marks; `IMPOSSIBLE` without a camera."""
    linear, counted = [], []
    for sketch in sketches:
        placed = place_sketch(template, sketch)
        if not placed.is_known or placed.disagreeing:
            return IMPOSSIBLE
        view = view_of(placed, template)
        linear.append(linear_sketch(template, view, Cost.balanced().hand))
        counted.append(np.ones(len(view.nodes), bool))
    return Weights(template, linear, counted).total
