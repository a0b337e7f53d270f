"""How well nodes are known: against chance, against what more sketches really give."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_car.dimensions import Dimensions
from bozzetto_car.solver.bundle_adjustment import solve
from bozzetto_car.solver.prior import Cost, Prior
from bozzetto_car.solver.uncertainty import FURTHER_VIEWS, certainty, further_views
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.shape_constraints import Soundness
from tests.plugins.car.sketched import (
    FRONT,
    FRONT_QUARTER,
    REAR_QUARTER,
    SIDE,
    Sketched,
    View,
    apart,
    rms,
    rubbery,
    sketched,
    styled,
)

COST = Cost.balanced()


def one(template: Template, *views: View, seed: int = 0) -> Sketched:
    return sketched(template, styled(template, seed), views, seed)


def test_sources_are_seen_mirrored_or_guessed(template: Template) -> None:
    sketch = one(template, FRONT_QUARTER)
    joint = solve(template, sketch.views, COST, Soundness.of(template))
    known = certainty(template, COST, joint)
    marked = set(sketch.views[0].nodes.tolist())
    for node, source in enumerate(known.sources):
        image = int(template.mirrored[node])
        expected = "seen" if node in marked else "mirrored" if image in marked else "guessed"
        assert source == expected
    assert {"seen", "mirrored", "guessed"} == set(known.sources)


def test_seen_and_mirrored_are_surer_than_guessed(template: Template) -> None:
    joint = solve(template, one(template, FRONT_QUARTER).views, COST, Soundness.of(template))
    known = certainty(template, COST, joint)
    sources = np.array(known.sources)
    seen, mirrored, guessed = (
        known.deviations[sources == source].mean() for source in ("seen", "mirrored", "guessed")
    )
    assert max(seen, mirrored) < guessed
    assert (known.shares > 0.0).all()
    assert (known.shares <= 1.0).all()


def test_a_node_and_its_image_are_known_alike(template: Template) -> None:
    joint = solve(template, one(template, FRONT_QUARTER).views, COST, Soundness.of(template))
    known = certainty(template, COST, joint)
    assert known.deviations[template.mirrored] == pytest.approx(known.deviations, rel=1e-6)


def test_more_sketches_make_surer(template: Template) -> None:
    views = one(template, FRONT_QUARTER, REAR_QUARTER, SIDE).views
    deviations = [
        rms(
            certainty(
                template, COST, solve(template, views[:count], COST, Soundness.of(template))
            ).deviations
        )
        for count in (1, 2, 3)
    ]
    assert deviations[0] > 1.5 * deviations[1]
    assert deviations[1] > deviations[2]


@pytest.mark.parametrize(
    ("views", "count"),
    [
        ((FRONT_QUARTER,), 25),
        pytest.param((FRONT_QUARTER, REAR_QUARTER), 160, marks=pytest.mark.slow),
    ],
)
def test_deviations_are_those_of_cars_drawn_from_the_prior(
    views: tuple[View, ...], count: int
) -> None:
    """Monte Carlo: cars by chance as the cost believes in them, sketched and solved again.

    After two sketches all nodes are known nearly alike, so it takes more cars to tell their order.
    """
    template = bundled("sedan")
    rng = np.random.default_rng(0)
    chance = np.linalg.cholesky(np.linalg.inv(Prior(template, COST).form(template.variables)))
    errors, told = [], []
    sound = Soundness.of(template)
    while len(errors) < count:
        variables = template.variables + 0.7 * chance @ rng.normal(size=len(chance))
        if sound.slacks(variables).min() < 0.0:
            continue
        car = template.whole(variables)
        sketch = sketched(template, car, views, len(errors))
        joint = solve(template, sketch.views, COST, sound)
        errors.append(apart(template.whole(joint.variables), car))
        told.append(certainty(template, COST, joint).deviations)
    actual = np.sqrt(np.mean(np.square(errors), axis=0))
    expected = np.sqrt(np.mean(np.square(told), axis=0))
    assert 0.6 < np.median(actual / expected) < 1.5
    order = np.corrcoef(np.argsort(np.argsort(actual)), np.argsort(np.argsort(expected)))[0, 1]
    assert order > 0.6


def test_place_size_and_tilt_do_not_count() -> None:
    """What no sketch tells, but a locked length does, makes the nodes no less known."""
    template = bundled("hatchback")
    sketch = one(template, FRONT_QUARTER, REAR_QUARTER)
    sound = Soundness.of(template)
    free = solve(template, sketch.views, COST, sound)
    length = float(np.ptp(template.whole(free.variables)[:, 0]))
    locked = solve(template, sketch.views, COST, sound, locked=Dimensions(length=length))
    with_, without = (rms(certainty(template, COST, joint).deviations) for joint in (locked, free))
    assert with_ <= 1.001 * without
    assert with_ >= 0.8 * without


def test_further_views_are_ranked_by_what_they_leave_open(template: Template) -> None:
    joint = solve(template, one(template, FRONT_QUARTER).views, COST, Soundness.of(template))
    views = further_views(template, COST, joint)
    assert {view.name for view in views} == set(FURTHER_VIEWS)
    after = [view.after for view in views]
    assert after == sorted(after)
    assert all(view.after < view.before for view in views)
    assert len({view.before for view in views}) == 1
    known = certainty(template, COST, joint)
    assert views[0].before == pytest.approx(rms(known.deviations))


def test_after_the_front_the_rear_is_asked_for_and_the_other_way_round(template: Template) -> None:
    for drawn, wanted in ((FRONT_QUARTER, "rear"), (REAR_QUARTER, "front")):
        joint = solve(template, one(template, drawn).views, COST, Soundness.of(template))
        best = further_views(template, COST, joint)[0]
        assert best.name == f"{wanted} three-quarter"


def test_what_is_promised_is_about_what_comes() -> None:
    """A sketch of the rear or one of the nose: the one that promises more keeps it, too."""
    template = bundled("sedan")
    sound = Soundness.of(template)
    kinds = {"rear three-quarter": REAR_QUARTER, "front": FRONT}
    promised: dict[str, list[float]] = {name: [] for name in kinds}
    came: dict[str, list[float]] = {name: [] for name in kinds}
    for seed in range(8):
        sketch = sketched(template, rubbery(template, seed), (FRONT_QUARTER, *kinds.values()), seed)
        joint = solve(template, sketch.views[:1], COST, sound)
        found = {view.name: view for view in further_views(template, COST, joint)}
        for name, view in zip(kinds, sketch.views[1:], strict=True):
            promised[name].append(found[name].after)
            both = solve(template, [sketch.views[0], view], COST, sound)
            came[name].append(rms(apart(template.whole(both.variables), sketch.car)))
    rear, front = ((np.median(promised[name]), np.median(came[name])) for name in kinds)
    assert rear[0] < 0.7 * front[0]
    assert rear[1] < 0.7 * front[1]
    for expected, actual in (rear, front):
        assert 0.4 < actual / expected < 2.0
