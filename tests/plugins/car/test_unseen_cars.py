"""Cars that are no template's, in pictures as people draw them."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from bozzetto_car.solving import solved
from bozzetto_car.soundness import Soundness
from tests.plugins.car.marking import aside
from tests.plugins.car.sketched import apart, rms
from tests.plugins.car.unseen import KINDS, PICTURES, pictured

SEEDS = range(3)


@cache
def figures(name: str, picture: str) -> dict[str, float]:
    """Medians: hidden nodes, px, and all nodes, mm, of the template and of the solved car; and
    how many sketches lost a mark that is right."""
    found = []
    for seed in SEEDS:
        template, car, case = pictured(name, picture, seed)
        answer = solved(case.state)
        placed = answer.placed["s0"]
        assert placed.resection is not None
        hidden = np.setdiff1d(
            np.arange(len(car)), [template.node[mark.node] for mark in placed.sketch.marks]
        )
        seen = placed.resection.project(template.positions[hidden]) - case.places[0][hidden]
        slacks = Soundness.of(template).slacks(template.reduced(answer.positions))
        assert np.isfinite(answer.positions).all()
        assert slacks.min() >= -1e-9
        found.append(
            (
                rms(np.linalg.norm(seen, axis=1)),
                case.hidden(answer),
                rms(apart(template.positions, car)),
                rms(apart(answer.positions, car)),
                bool(aside(answer)),
            )
        )
    before, after, away, near, lost = np.median(found, axis=0).tolist()
    return {"before": before, "after": after, "away": away, "near": near, "lost": lost}


@pytest.mark.parametrize("picture", PICTURES)
@pytest.mark.parametrize("name", KINDS)
def test_a_solve_is_better_than_the_template(name: str, picture: str) -> None:
    of = figures(name, picture)
    assert of["after"] < of["before"]
    assert of["near"] < of["away"]
