"""Which of the answers a person meant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.model.state import Choice
from bozzetto_polyhedron.reconstruction.answer import Answer

MIRRORED: Final = -0.9
"""Correlation of depths below which one answer is the other one turned inside out."""


def chosen_number(answers: Sequence[Answer], choice: Choice | None, asked: int) -> int:
    """Return which answer is meant, counted from 0.

    Parameters
    ----------
    answers : sequence of Answer
        At least one.
    choice : Choice, optional
        Counts as long as its number is the one that is asked for: a number that was typed since
        means what it says.
    asked : int
        `Body.answer`, counted from 1; the last answer where there are not so many.
    """
    asked = min(asked, len(answers))
    if choice is None or not choice.vertices or choice.number != asked:
        return asked - 1
    wanted = np.asarray(choice.vertices)
    distances = [_distance(answer.vertices, wanted) for answer in answers]
    return int(np.argmin(distances))


def choice_of(answers: Sequence[Answer], number: int) -> Choice:
    """Return the choice of an answer, counted from 0, as a document keeps it."""
    rows = answers[number].vertices.tolist()
    return Choice(number + 1, tuple((float(x), float(y), float(z)) for x, y, z in rows))


def mirrored_number(answers: Sequence[Answer], number: int, depth: Array) -> int | None:
    """Return the answer that is another one turned inside out in depth (Necker's cube).

    Parameters
    ----------
    answers : sequence of Answer
        At least one.
    number : int
        Of the answer, counted from 0.
    depth : (3,) float64
        Direction of sight.
    """
    depths = [_centred(answer.vertices @ depth) for answer in answers]
    own = depths[number]
    alike = [float(own @ other) for other in depths]
    best = int(np.argmin(alike))
    return best if alike[best] < MIRRORED else None


def _centred(values: Array) -> Array:
    """Return values about their mean, of length 1; zeros where they are all alike."""
    centred = values - values.mean()
    length = float(np.linalg.norm(centred))
    return np.asarray(centred / length) if length > 0.0 else centred


def _distance(vertices: Array, wanted: Array) -> float:
    """Return the root mean square distance of two clouds of vertices, each to the nearest.

    Strokes may have been added or taken away since: numbers of vertices mean nothing.
    """
    away = np.linalg.norm(vertices[:, None] - wanted[None], axis=2)
    return float(np.sqrt(np.mean(away.min(axis=0) ** 2) + np.mean(away.min(axis=1) ** 2)))
