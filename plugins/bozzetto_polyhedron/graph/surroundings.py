"""The corners of a draft and which ones are close, as they are before a round of changes."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto_polyhedron.graph.draft import Draft, Joined
from bozzetto_polyhedron.graph.likelihood import Line

REACH: Final = 0.08
"""Shares of the diagonal within which other corners are looked at."""

MOST_NEAR: Final = 5
"""Corners that are looked at beside one place, at most."""


class Surroundings:
    """Corners of a draft and which ones are close, as they are before a round of changes."""

    def __init__(self, draft: Draft) -> None:
        self.draft = draft
        self.corners = sorted(draft.sums)
        found = draft.places()
        self._x, self._y = np.array([found[k] for k in self.corners]).reshape(-1, 2).T.copy()
        self.place = found
        self.keys = sorted(draft.lines)
        self._near: dict[tuple[float, float], list[tuple[int, float]]] = {}

    def near(self, place: tuple[float, float], most: int, reach: float = REACH) -> list[int]:
        """Return corners within reach of a place, `MOST_NEAR` at most, the nearest first."""
        found = self._near.get(place)
        if found is None:
            away = np.hypot(self._x - place[0], self._y - place[1])
            order = np.argsort(away, kind="stable")[:MOST_NEAR].tolist()
            found = self._near[place] = [(self.corners[k], float(away[k])) for k in order]
        return [corner for corner, distance in found[:most] if distance < reach]


def placed(around: Surroundings, line: Line, one: int, two: int) -> Joined:
    """Put a line between two corners, in the order in which it passes them."""
    a, b = around.place[one], around.place[two]
    dx, dy = line.stop[0] - line.start[0], line.stop[1] - line.start[1]
    forward = (b[0] - a[0]) * dx + (b[1] - a[1]) * dy >= 0
    return Joined(line, one, two) if forward else Joined(line, two, one)
