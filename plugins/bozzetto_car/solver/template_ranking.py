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
from bozzetto_car.solver.initial_cameras import FEWEST, Placed, marks_of, seen_as
from bozzetto_car.solver.pipeline import Solved
from bozzetto_car.solver.prior import Cost
from bozzetto_car.solver.proportions import SHARED_NODES
from bozzetto_car.template.loader import PAPER_TEMPLATES, TEMPLATES, bundled
from bozzetto_car.template.model import Template

LIKELIER: Final = 7.0
"""Gain in probability with another template, as a natural logarithm, from which it is proposed."""

RARER: Final = 3.0
"""Logarithm of how much seldomer a kind of car is sketched that is no sedan, hatchback or minivan:
of two kinds that a sketch does not tell apart the usual one is proposed."""

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
    known = tuple(placed for placed in solved.placed.values() if placed.is_known)
    question = (own.id, *((placed.sketch.id, *marks_of(placed.sketch)) for placed in known))
    return _likelier(question, own, known)


@remembered(limit=ANSWERS, key=lambda question, own, known: question)
def _likelier(question: Hashable, own: Template, known: tuple[Placed, ...]) -> Template | None:
    gains: dict[str, float] = {}
    its: dict[tuple[int, ...], float] = {}
    for name in TEMPLATES:
        other = bundled(name)
        common = [_of_both(placed, own, other) for placed in known if other is not own]
        if common and all(map(_tells, common, known)):
            counts = tuple(len(placed.sketch.marks) for placed in common)
            if counts not in its:  # templates with the same nodes have the same marks in common
                its[counts] = _probability(own, common)
            rarer = 0.0 if name in PAPER_TEMPLATES else RARER
            gains[name] = _probability(other, common) - its[counts] - rarer
    best = max(gains, key=lambda name: gains[name], default="")
    return bundled(best) if best and gains[best] > LIKELIER else None


def _of_both(placed: Placed, own: Template, other: Template) -> Placed:
    """Return a sketch with the marks of points that both templates have."""
    both = own.node.keys() & other.node.keys()
    marks = tuple(mark for mark in placed.sketch.marks if mark.node in both)
    return replace(placed, sketch=replace(placed.sketch, marks=marks), disagreeing=())


def _tells(common: Placed, whole: Placed) -> bool:
    """Whether the marks of points that two templates share are enough to compare them."""
    return len(common.sketch.marks) >= max(FEWEST, SHARED_NODES * len(whole.sketch.marks))


def _probability(template: Template, known: Sequence[Placed]) -> float:
    """Return the logarithm of the probability of the marks; `IMPOSSIBLE` without a camera."""
    linear, counted = [], []
    for placed in known:
        view = seen_as(template, placed)
        if view is None:
            return IMPOSSIBLE
        linear.append(linear_sketch(template, view, Cost.balanced().hand))
        counted.append(np.ones(len(view.nodes), bool))
    return Weights(template, linear, counted).total
