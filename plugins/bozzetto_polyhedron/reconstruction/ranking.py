"""Which reading is likely the right one: a log-linear model, and how far it can be trusted.

The score of a reading is a weighted sum of its measures; its share among all readings is the
softmax of the scores. The weights are data in `ranking_weights`, and the tables that turn shares
into probabilities in `confidence_tables`.
"""

from __future__ import annotations

from typing import Final, Literal, TypeAlias

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.reconstruction.confidence_tables import CONFIDENCES, SHARES
from bozzetto_polyhedron.reconstruction.ranking_weights import WEIGHTS
from bozzetto_polyhedron.reconstruction.regularity import MEASURES

Evidence: TypeAlias = Literal["plain", "loose", "marked"]
"""What a drawing tells: lines alike; lines alike in parts that no line joins, where a pocket looks
like a boss; hidden lines drawn lightly."""

SURE: Final = 0.5
"""Confidence below which the program asks whether this is the solid that was meant."""

HANGING: Final = "parts that hang nowhere"
"""Name of the measure that counts them."""

EVIDENCE: Final = (
    "planarity beyond the noise",
    "depth residual",
    "strict classes",
    "open lines",
    "through-holes",
    "parts that stand out",
    "misfit of loose parts",
    HANGING,
    "marks of hidden lines",
)
"""Measures of a reading beside its regularity, in the order of their columns."""

FEATURES: Final = (*MEASURES, *EVIDENCE)
"""Names of all measures in the order of the weights."""

RANKING_WEIGHTS: Final = np.array([WEIGHTS[name] for name in FEATURES])
"""Weights in the order of `FEATURES`."""


def scores(features: Array) -> Array:
    """Return the score of each reading, (k,), from its features, (k, len(FEATURES))."""
    return np.asarray(features @ RANKING_WEIGHTS)


def confidences(values: Array, evidence: Evidence) -> Array:
    """Return the probability that each of the readings is the right one.

    Parameters
    ----------
    values : (k,) array
        Scores, best first.
    evidence : {"plain", "loose", "marked"}
        See `Evidence`.

    Returns
    -------
    (k,) array
        In falling order; their sum is at most 1.
    """
    if not len(values):
        return np.zeros(0)
    shares = np.exp(values - values.max())
    shares /= shares.sum()
    first = float(np.interp(shares[0], SHARES, CONFIDENCES[evidence]))
    rest = shares[1:] / max(1e-12, float(shares[1:].sum())) * (1.0 - first)
    limit = np.minimum(rest * (shares[1:] > 0), first)
    return np.minimum.accumulate(np.concatenate(([first], limit)))
