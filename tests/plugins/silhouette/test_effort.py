"""Ink beyond all measure: a solid or a sentence, in time."""

from __future__ import annotations

import time
from contextlib import suppress

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Ink, Job
from bozzetto.view import Camera
from bozzetto_silhouette.ink.rings_from_strokes import MOST_SAMPLES, rings_from_strokes
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.outline.outline import outline_from_rings
from tests.plugins.silhouette import outlines as o

MODELER = Silhouette()
FRONT = Camera("orthographic", (0.0, -500.0, 0.0), (0.0, 0.0, 0.0), height=300.0)
LONGEST = 5.0
"""Seconds of processor time for a gesture, and for a solid."""


def star(count: int, noise: float) -> np.ndarray:
    """A closed line with five arms and jitter, a share of its radius; around (600, 450), px."""
    random = np.random.default_rng(1)
    angle = np.linspace(0.0, 2.0 * np.pi, count)
    radius = 300.0 * (1.0 + 0.2 * np.cos(5.0 * angle) + noise * random.standard_normal(count))
    return [600.0, 450.0] + radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])


def drawn(*lines: np.ndarray) -> SilhouetteState:
    state = MODELER.create(Context())
    for line in lines:
        ink = Ink((Stroke(*line.T, FRONT),), True)
        state = MODELER.tools()[0].apply(state, ink, Context())
    return state


@pytest.mark.parametrize("noise", [0.0, 5e-4, 3e-3])
def test_a_line_of_very_many_samples_is_read_as_one_of_few(noise: float) -> None:
    (ring,) = rings_from_strokes([star(60_000, noise)])
    (plain,) = rings_from_strokes([star(2_000, 0.0)])
    assert len(ring) <= MOST_SAMPLES
    assert o.iou(outline_from_rings([ring]), outline_from_rings([plain])) > 0.99


def test_a_ragged_outline_of_thousands_of_corners_gives_a_solid() -> None:
    result = MODELER.solve(drawn(star(20_000, 5e-4)), Job("preview"))
    (solid,) = result.solids.values()
    assert solid.soundness.ok


@pytest.mark.quiet
@pytest.mark.parametrize("kind", ["in", "out", "smooth", "ragged", "rough", "wild"])
def test_no_ink_takes_longer_than_a_person_waits(kind: str) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    circles = [
        [600.0, 450.0] + radius * np.column_stack([np.cos(angle), np.sin(angle)])
        for radius in np.linspace(20.0, 420.0, 30)
    ]
    lines = {
        "in": circles[::-1],
        "out": circles,
        "smooth": [star(200_000, 0.0)],
        "ragged": [star(200_000, 5e-4)],
        "rough": [star(200_000, 0.01)],
        "wild": [star(200_000, 0.1)],
    }[kind]
    steps = [time.process_time()]
    with suppress(UserError):
        state = drawn(*lines)
        for quality in ("preview", "final"):
            steps.append(time.process_time())
            MODELER.solve(state, Job(quality))
    steps.append(time.process_time())
    assert np.diff(steps).max() < LONGEST
