"""Ink to rings: what is refused before any work is done."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto_silhouette.ink import rings_from_strokes as inking
from bozzetto_silhouette.outline.outline import outline_from_strokes


def test_more_strokes_than_can_be_nested_are_refused_at_once():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]])
    many = [square + np.array([3.0 * i, 0.0]) for i in range(inking.MOST_STROKES + 1)]
    with pytest.raises(UserError, match="one by one"):
        outline_from_strokes(many)
