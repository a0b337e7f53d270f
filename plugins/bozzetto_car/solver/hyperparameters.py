"""Estimate how a car differs from its template, how its hand errs, and which marks are wrong.

The cost of `prior` assumes how much cars differ from the template. With it alone, a car that *is*
the template follows the noise of the hand, and a wrong mark distorts the shape. The evidence of the
marks tells both apart (MacKay, *Bayesian interpolation*, 1992).

Cars are no single cloud about their template: some differ in dimensions and by chance only, some
toward other templates, some belong with another one; some differ smoothly, and some in every place
by itself; and some hands bend a drawing. So a car is
drawn from a mixture (`MIXTURE`). The shares of its parts follow from the marks, and the covariance
that is solved with is that of the mixture, each part as wide as the marks have it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.plugin import cached_property
from bozzetto_car.camera.marked_view import MarkedView
from bozzetto_car.listening import look
from bozzetto_car.solver.evidence import (
    Evidence,
    Factored,
    Independent,
    LinearSketch,
    MarkEvidence,
    independent,
    linear_sketch,
    log_of_sum,
    of_all_kinds,
)
from bozzetto_car.solver.prior import DEVIATION, KINSHIP, Cost
from bozzetto_car.template.model import Template

KINSHIPS: Final = (0.1, 1.0, 2.5)
"""Ways toward other templates, in deviations (`KINSHIP`): hardly, a part of the way, most of it."""

ROUGH: Final = (0.2, 1.0)
"""By how much nodes differ by themselves, in deviations (`DEVIATION`). What a car differs by
smoothly would otherwise be taken for a bend of the hand, for its nodes show no scatter."""

BENDS: Final = (0.0, 4.0, 10.0)
"""By how much more a hand bends a drawing than it trembles, standard deviations."""

BENT: Final = 6.0
"""Price of a hand that bends at all, as a natural logarithm."""

GENEROUS: Final = 1.4
"""Factor on the estimated spread: marks are met as closely as the hand allows, and of cars that
are near their template little is lost."""

OUTWARD: Final = 0.35
"""Share of the spread with which outer dimensions vary against each other in the solve. A single
camera stretches a car as its dimensions do, and what marks say of both is easily too much."""

MISTAKE: Final = 16.0
"""Price of setting a mark aside, as a natural logarithm: a mark at a random place in the picture
costs 12, and one mark in fifty is such a mistake."""

MISTAKE_PER_MARK: Final = 0.2
"""Addition to this price for every mark of the sketch. Cars differ in single places more than the
cost expects, such as a pillar 15 cm farther back, and many marks show many places."""

RETURN_DISCOUNT: Final = 6.0
"""Discount for a mark that was aside already while marks are dragged, so that no mark comes and
goes with the noise of the hand."""

FEWEST_LEFT: Final = 6
"""Number of marks of a sketch that always count: so few marks fit any car."""

MOST_ASIDE: Final = 0.25
"""Largest share of the marks of a sketch that is set aside: beyond it, nothing tells which marks
are right."""


@dataclass(frozen=True)
class Part:
    """A part of the mixture of cars and hands.

    Attributes
    ----------
    cost : Cost
        How cars of this part differ from the template.
    bend : float
        By how much more their hands bend than they tremble.
    """

    cost: Cost
    bend: float

    @property
    def price(self) -> float:
        """Cost of believing in this part, as a natural logarithm."""
        return BENT if self.bend > 0.0 else 0.0


MIXTURE: Final = tuple(
    Part(replace(Cost.balanced(), kinship=kinship * KINSHIP, deviation=rough * DEVIATION), bend)
    for kinship in KINSHIPS
    for rough in ROUGH
    for bend in BENDS
)
"""Kinds of cars and hands, equally likely but for the price of a bend."""

NO_CHANGE: Final = (0.0, 0, 0)
"""Gain, sketch and mark where none can be set aside or taken back."""


@dataclass(frozen=True, eq=False)
class Weighed:
    """Verdict of the marks on the car and the hand, and which marks count.

    Attributes
    ----------
    spread : float
        How far the car is from the template, as a share of the deviations that the cost expects.
    hand : float
        How much less steady the hand is than the cost assumes, as a factor; 1 at least.
    cost : Cost
        The weights for such a car, and by how much the hand bends; it trembles as usual.
    counted : tuple of (k,) bool
        Which marks of each sketch count; the others are set aside.
    """

    spread: float
    hand: float
    cost: Cost
    counted: tuple[Flags, ...]


class Weights:
    """The marks of all sketches with the mixture.

    Parameters
    ----------
    template : Template
        The template of the car.
    sketches : sequence of LinearSketch
        The sketches.
    counted : sequence of (k,) bool
        Which of their marks count.
    """

    def __init__(
        self, template: Template, sketches: Sequence[LinearSketch], counted: Sequence[Flags]
    ) -> None:
        self._template, self._sketches = template, sketches
        self._counted = [flags.copy() for flags in counted]
        self._known: dict[float, tuple[Array, Array]] = {}

    def of(self, part: Part) -> MarkEvidence:
        """Return the evidence of a part of the mixture, for one hand as usual."""
        ready = self._independent(part.bend)
        return MarkEvidence(Factored.of(self._template, part.cost, ready, part.bend), anyone=False)

    @property
    def likeliest_straight(self) -> Part:
        """The likeliest part of the mixture whose hands do not bend, each hand as usual."""
        straight = self._of_bend(0.0, anyone=False)
        return max(straight, key=lambda part: straight[part].total)

    @cached_property
    def parts(self) -> tuple[Evidence, ...]:
        """The evidence of each part."""
        found: dict[Part, Evidence] = {}
        for bend in BENDS:
            found |= self._of_bend(bend, anyone=True)
        return tuple(found[part] for part in MIXTURE)

    @cached_property
    def logs(self) -> Array:
        """Logarithms of the probabilities of the parts together with the marks."""
        return np.array([e.total - p.price for e, p in zip(self.parts, MIXTURE, strict=True)])

    @property
    def total(self) -> float:
        """Logarithm of the probability of the marks, up to a constant of their number."""
        return float(log_of_sum(self.logs))

    def _of_bend(self, bend: float, *, anyone: bool) -> dict[Part, Evidence]:
        """Return the evidence of all parts whose hands bend a drawing so."""
        parts = [part for part in MIXTURE if part.bend == bend]
        ready = self._independent(bend)
        if bend not in self._known:
            costs = tuple(part.cost for part in parts)
            self._known[bend] = of_all_kinds(self._template, costs, ready)
        pairs = zip(*self._known[bend], strict=True)
        each = [Evidence(ready, bend, size, misfit, anyone) for size, misfit in pairs]
        return dict(zip(parts, each, strict=True))

    def _independent(self, bend: float) -> list[Independent]:
        pairs = zip(self._sketches, self._counted, strict=True)
        return [independent(sketch, bend, flags) for sketch, flags in pairs]


def judge_marks(
    template: Template, views: Sequence[MarkedView], aside: Sequence[Flags] | None = None
) -> Weighed:
    """Weigh the marks of all sketches of a car against the template and each other.

    Parameters
    ----------
    template : Template
        The template of the car.
    views : sequence of MarkedView
        The sketches with all marks, and with cameras near enough for first derivatives, such as
        those from the template. All marked nodes are in front of the cameras.
    aside : sequence of (k,) bool, optional
        For each sketch the marks that were aside before one of them was dragged.

    Notes
    -----
    Marks are set aside one at a time, always the one that raises the probability of all most, until
    none does, and then taken back in the same way. The probability grows each time, so this ends.
    """
    sketches = [linear_sketch(template, view, Cost.balanced().hand) for view in views]
    before = [np.zeros(len(view.nodes), bool) for view in views] if aside is None else aside
    counted = [~flags for flags in before]
    prices = [
        np.where(flags, -RETURN_DISCOUNT, 0.0) + MISTAKE + MISTAKE_PER_MARK * len(flags)
        for flags in before
    ]
    weights = Weights(template, sketches, counted)
    part = weights.likeliest_straight
    while True:
        look()
        best = max(_losses(weights.of(part), counted, prices), default=NO_CHANGE)
        if best[0] <= 0.0:
            best = max(_returns(template, sketches, part, counted, prices), default=NO_CHANGE)
        gain, sketch, mark = best
        if gain <= 0.0:
            break
        counted[sketch][mark] = not counted[sketch][mark]
        weights = Weights(template, sketches, counted)
    return _weighed(weights, tuple(counted))


def _weighed(weights: Weights, counted: tuple[Flags, ...]) -> Weighed:
    shares = np.exp(weights.logs - weights.total)
    bends = np.array([part.bend for part in MIXTURE])
    # Marks are to be met, unless it is likelier than not that the hand has bent them.
    believed = (bends > 0.0) == (shares[bends > 0.0].sum() > 0.5)
    shares = np.where(believed, shares, 0.0) / shares[believed].sum()
    spreads, hands = (
        np.exp([getattr(part, name) for part in weights.parts])
        for name in ("log_spread", "log_hand")
    )
    spread, hand = (float(np.exp(shares @ np.log(found))) for found in (spreads, hands))
    hand = max(hand, 1.0)
    usual = Cost.balanced()
    wider = GENEROUS * spreads
    # Whether nodes scatter tells a smooth car from a bend; marks are to be met all the same, so the
    # nodes vary as usual in proportion to the rest.
    share = min(float(np.sqrt(shares @ wider**2)), 1.0)
    # How far marks pull along a direction is a sigmoid of the logarithm of its variance. The parts
    # differ in kinship by far, so the mean of the pulls is that at the mean of the logarithms.
    kinships = np.array([part.cost.kinship for part in MIXTURE]) * wider
    cost = replace(
        usual,
        deviation=share * usual.deviation,
        smooth=share * usual.smooth,
        proportion=OUTWARD * share * usual.proportion,
        kinship=float(np.exp(shares @ np.log(kinships))),
        bend=usual.hand * float(np.sqrt(shares @ (bends * hands) ** 2)),
    )
    return Weighed(spread, hand, cost, counted)


def evidence_of(template: Template, view: MarkedView) -> MarkEvidence:
    """Return how probable the marks of one sketch are, all of them together.

    Parameters
    ----------
    template : Template
        The template of the car.
    view : MarkedView
        The sketch, as for `judge_marks`.
    """
    sketch = linear_sketch(template, view, Cost.balanced().hand)
    every = np.ones(len(view.nodes), bool)
    ready = [independent(sketch, 0.0, every)]
    return MarkEvidence(Factored.of(template, Cost.balanced(), ready, 0.0), anyone=False)


def _losses(
    now: MarkEvidence, counted: list[Flags], prices: list[Array]
) -> Iterator[tuple[float, int, int]]:
    """Return the gain of setting the best mark of each sketch aside, the sketch, and the mark."""
    for number, (flags, price) in enumerate(zip(counted, prices, strict=True)):
        most = min(len(flags) - FEWEST_LEFT, int(MOST_ASIDE * len(flags)))
        if len(flags) - flags.sum() < most:
            there = np.flatnonzero(flags)
            gains = now.improbable[number] - price[there]
            yield float(gains.max()), number, int(there[gains.argmax()])


def _returns(
    template: Template,
    sketches: list[LinearSketch],
    part: Part,
    counted: list[Flags],
    prices: list[Array],
) -> Iterator[tuple[float, int, int]]:
    """Return the gain of taking each mark back that is aside, the sketch, and the mark."""
    for number, flags in enumerate(counted):
        for mark in np.flatnonzero(~flags).tolist():
            more = flags.copy()
            more[mark] = True
            every = [*counted[:number], more, *counted[number + 1 :]]
            with_it = Weights(template, sketches, every).of(part)
            rank = int(more[:mark].sum())
            yield float(prices[number][mark] - with_it.improbable[number][rank]), number, mark
