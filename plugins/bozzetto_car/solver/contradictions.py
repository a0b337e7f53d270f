"""Sketches that contradict each other: two cars are likelier than one.

Where one sketch shows another roof than the others, say, the car lies between and none of them is
met. Whether that is so is a comparison of models: all sketches show one car, or one of them shows
a car of its own. The evidence of marks (`hyperparameters`) tells how likely each is, with hands
that tremble or bend as they may; so sketches of an unsteady hand contradict nobody.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import remembered
from bozzetto_car.solver.bundle_adjustment import JointSolution, solve
from bozzetto_car.solver.evidence import linear_sketch
from bozzetto_car.solver.hyperparameters import Weights
from bozzetto_car.solver.pipeline import Solved
from bozzetto_car.solver.prior import Cost

MISSED: Final = 0.002
"""Distance of marks, rms, in diagonals of their pictures, up to which a car is met by its sketches,
and nothing else is looked at: two to three pixels."""

RARE: Final = math.log(100.0)
"""How much likelier two cars must be than one, as a logarithm: few people mix them up."""

MOST_NAMED: Final = 3
"""Number of marks that are named."""

REMEMBERED: Final = 8
"""Number of cars whose contradictions are remembered."""


@dataclass(frozen=True)
class Contradiction:
    """A sketch that contradicts the others.

    Attributes
    ----------
    sketch : str
        Its id.
    together, without : float
        How far all marks are from their nodes, and those of the other sketches are in the car
        without it, rms, px.
    nodes : tuple of str
        Nodes whose marks on it are missed most, the worst first.
    """

    sketch: str
    together: float
    without: float
    nodes: tuple[str, ...]


@remembered(limit=REMEMBERED)
def contradiction_of(solved: Solved) -> Contradiction | None:
    """Return the sketch that contradicts the others; None if none does, or there is but one.

    Of two it is the one without which the other is met best. What dimensions are kept does not
    matter here.

    Parameters
    ----------
    solved : Solved
        The car.
    """
    joint, count = solved.joint, len(solved.solid)
    if joint is None or count < 2:
        return None
    sizes = [math.hypot(*solved.placed[key].sketch.size) for key in solved.solid]
    if _missed(joint, sizes) <= MISSED:
        return None
    others = [[k for k in range(count) if k != number] for number in range(count)]
    hand = Cost.balanced().hand
    sketches = [linear_sketch(solved.template, view, hand) for view in joint.views]

    def evidence(numbers: Sequence[int]) -> float:
        counted = [np.ones(len(joint.views[number].nodes), bool) for number in numbers]
        own = [sketches[number] for number in numbers]
        return Weights(solved.template, own, counted).total

    parted = [evidence(rest) + evidence([number]) for number, rest in enumerate(others)]
    if max(parted) - evidence(range(count)) <= RARE:
        return None

    def without(number: int) -> JointSolution:
        views = [joint.views[k] for k in others[number]]
        return solve(solved.template, views, Cost.balanced(), solved.soundness)

    if count == 2:  # either parting is the same
        rest = [without(number) for number in range(count)]
        worst = min(range(count), key=lambda k: _missed(rest[k], [sizes[1 - k]]))
        left = rest[worst]
    else:
        worst = int(np.argmax(parted))
        left = without(worst)
    order = np.argsort(-joint.residuals[worst])[:MOST_NAMED]
    names = [solved.template.names[node] for node in joint.views[worst].nodes[order].tolist()]
    together, alone = (_rms(np.concatenate(one.residuals)) for one in (joint, left))
    return Contradiction(solved.solid[worst], together, alone, tuple(names))


def _missed(joint: JointSolution, sizes: list[float]) -> float:
    """Return how far marks are missed, rms, in diagonals of their pictures."""
    pairs = zip(joint.residuals, sizes, strict=True)
    return _rms(np.concatenate([px / size for px, size in pairs]))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
