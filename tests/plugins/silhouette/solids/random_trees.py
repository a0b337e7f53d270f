"""Random trees: a ball with balls of many sizes on it and about it."""

from __future__ import annotations

import numpy as np

from bozzetto.geometry import Placement
from bozzetto.ink import Strokes
from bozzetto.testing import Pen
from bozzetto_silhouette.model.state import Part, SilhouetteState


def random_tree(seed: int, parts: int) -> SilhouetteState:
    """A tree of balls: most of them on the rim of the first, some before it, many of them meet."""
    random, pen = np.random.default_rng(seed), Pen()
    nodes = [Part(id="n0", strokes=Strokes((pen.circle(600.0, 450.0, 250.0),)))]
    for k in range(1, parts):
        turn, radius = random.uniform(0.0, 2.0 * np.pi), random.uniform(10.0, 70.0)
        away = 250.0 + random.uniform(-0.5, 0.7) * radius
        depth = 0.0
        if random.random() < 0.25:
            away, depth = random.uniform(0.0, 180.0), random.uniform(60.0, 90.0)
        place = 600.0 + away * np.cos(turn), 450.0 + away * np.sin(turn)
        nodes.append(
            Part(
                id=f"n{k}",
                strokes=Strokes((pen.circle(*place, radius),)),
                blend=float(random.choice([0.2, 0.5, 1.0])),
                pose=Placement(offset=(0.0, 0.0, depth)),
            )
        )
    return SilhouetteState(tuple(nodes))
