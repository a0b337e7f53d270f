"""Which reading is likely the right one: a log-linear model, and how far it can be trusted.

The score of a reading is a weighted sum of its measures; its share among all readings is the
softmax of the scores. The weights are data in `ranking_weights`. How likely the first reading is
right depends on its share, and on what it and the drawing are like: a logistic regression on random
solids, whose numbers are in `confidence_tables`, and another one on what that says of drawings of
five families, whose numbers are in `confidence_weights`.
"""

from __future__ import annotations

from typing import Final, Literal, TypeAlias

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.reconstruction.confidence_tables import LEADS, LOG_ODDS, TRAITS
from bozzetto_polyhedron.reconstruction.confidence_weights import BIAS, CORRECTIONS
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
    "gaps of loose parts",
    "marks of hidden lines",
)
"""Measures of a reading beside its regularity, in the order of their columns."""

FEATURES: Final = (*MEASURES, *EVIDENCE)
"""Names of all measures in the order of the weights."""

OPEN: Final = np.array([name == "open lines" for name in FEATURES])
"""Which measure is the share of lines that are not between two faces."""

RANKING_WEIGHTS: Final = np.array([WEIGHTS[name] for name in FEATURES])
"""Weights in the order of `FEATURES`."""


def scores(features: Array) -> Array:
    """Return the score of each reading, (k,), from its features, (k, len(FEATURES))."""
    return np.asarray(features @ RANKING_WEIGHTS)


DRAWN: Final = ("logarithm of the number of lines", "noise, diagonals")
"""Traits of a drawing, behind the measures of its first reading."""

CORRECTED: Final = (
    "log odds by random solids",
    "lead over other shapes",
    "whether it is open",
    "whether a part hangs nowhere",
    "logarithm of the number of lines",
    "frame coverage",
)
"""What corrects the confidence, in the order of its numbers."""

LEAST, MOST = 0.02, 0.995
"""No first reading is said to be less or more certain."""


def traits_of(features: Array, lines: Index, noise: float) -> Array:
    """Return what tells how certain a reading is beside its share, (len(TRAITS),).

    Parameters
    ----------
    features : (len(FEATURES),) array
        Measures of the reading.
    lines : (m, 2) array of int
        Of the drawing. Where corners have two, it is a sheet, and may be open.
    noise : float
        Of its corners, diagonals.
    """
    degrees = np.bincount(lines.ravel())
    is_sheet = bool(((degrees > 0) & (degrees < 3)).any())
    measures = np.where(OPEN & is_sheet, 0.0, features)
    return np.concatenate((measures, (np.log(max(1, len(lines))), noise)))


def confidences(values: Array, evidence: Evidence, traits: Array, apart: float) -> Array:
    """Return the probability that each of the readings is the right one.

    Parameters
    ----------
    values : (k,) array
        Scores, best first.
    evidence : {"plain", "loose", "marked"}
        See `Evidence`.
    traits : (len(TRAITS),) array
        Of the first reading; see `traits_of`.
    apart : float
        Its lead over readings of other shapes; see `readings.lead_over_others`.

    Returns
    -------
    (k,) array
        In falling order; their sum is at most 1.
    """
    if not len(values):
        return np.zeros(0)
    shares = np.exp(values - values.max())
    shares /= shares.sum()
    first = confidence_of_first(lead_of(values), evidence, traits, apart)
    rest = shares[1:] / max(1e-12, float(shares[1:].sum())) * (1.0 - first)
    limit = np.minimum(rest * (shares[1:] > 0), first)
    return np.minimum.accumulate(np.concatenate(([first], limit)))


def lead_of(values: Array) -> float:
    """Return the log odds of the first of some scores, (k,), against all others."""
    return lead_of_shares(1.0, float(np.exp(values[1:] - values[0]).sum()))


def lead_of_shares(own: float, others: float) -> float:
    """Return the log odds of a share above 0 against that of all others."""
    return float(np.clip(np.log(own) - np.log(max(others, 1e-300)), LEADS[0], LEADS[-1]))


def confidence_of_first(lead: float, evidence: Evidence, traits: Array, apart: float) -> float:
    """Return the probability that the first reading is right, by its leads and its traits."""
    corrected = corrected_traits(lead, evidence, traits, apart)
    low, high, weights = np.array(list(CORRECTIONS.values())).T
    odds = BIAS + float(weights @ np.clip(corrected, low, high))
    return float(np.clip(1.0 / (1.0 + np.exp(-odds)), LEAST, MOST))


def corrected_traits(lead: float, evidence: Evidence, traits: Array, apart: float) -> Array:
    """Return what corrects the confidence, (len(CORRECTED),), in the order of `CORRECTED`."""
    low, high, weights = np.array(list(TRAITS.values())).T
    odds = float(np.interp(lead, LEADS, LOG_ODDS[evidence]))
    odds += float(weights @ np.clip(traits, low, high))
    named = dict(zip(TRAITS, traits.tolist(), strict=True))
    return np.array(
        (
            odds,
            apart,
            float(named["open lines"] > 0.0),
            float(named[HANGING] > 0.0),
            named["logarithm of the number of lines"],
            named["frame coverage"],
        )
    )
