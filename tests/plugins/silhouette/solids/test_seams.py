"""Seams: triangles at fillets are even, also where several fillets meet."""

from __future__ import annotations

import numpy as np

from bozzetto.ink import Strokes
from bozzetto.testing import Pen
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.solids.evaluate import tree_body
from tests.plugins.silhouette import bodies as b
from tests.plugins.silhouette.solids.figures_creases import sharp_edges


def crowded(turn: float) -> SilhouetteState:
    """A ball with four limbs so close beside one another that their fillets meet."""
    pen = Pen()
    circles = [pen.circle(600.0, 450.0, 150.0)]
    for k in range(4):
        angle = turn + 0.345 * k
        place = 600.0 + 153.0 * np.cos(angle), 450.0 + 153.0 * np.sin(angle)
        circles.append(pen.circle(*place, 18.0 + k % 3))
    return SilhouetteState(
        tuple(Part(id=f"n{k}", strokes=Strokes((circle,))) for k, circle in enumerate(circles))
    )


def test_where_fillets_meet_no_streaks_are_left() -> None:
    left = 0.0
    for turn in (0.7, 2.9, 5.1):
        whole = tree_body(crowded(turn), 64)
        assert whole is not None
        b.assert_sound(whole)
        left += sharp_edges(whole)[1].sum() / whole.step
    # 31 steps; 403 when vertices between two seams were only brought onto the surface.
    assert left < 120.0
