"""What a sketch shows is guessed from few marks: by cars and views that no grid has."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from bozzetto_car.camera.visibility import facing
from bozzetto_car.marking.edit_marks import set_mark, with_sides_exchanged, with_skipped
from bozzetto_car.marking.view_guess import likely_shown
from bozzetto_car.state import CarState, Mark, Sketch
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import Template, twin
from tests.plugins.car.penned import blank
from tests.plugins.car.sketched import looking, styled

ELEVATIONS, DISTANCES = (3.0, 20.0), (4.5, 10.0)


def sketch_with(names: list[str], places, **told: object) -> Sketch:
    marks = tuple(Mark(name, *map(float, place)) for name, place in zip(names, places, strict=True))
    return replace(Sketch(id="s0", width=1200.0, height=800.0, marks=marks), **told)


def marked_as_asked(template: Template, azimuth: float, seed: int) -> Iterator[bool]:
    """Mark six nodes of a car as they are asked for; yield whether each was seen."""
    rng = np.random.default_rng(seed)
    car = styled(template, seed)
    camera = looking(car, ((azimuth, azimuth), ELEVATIONS, DISTANCES), rng)
    shown, places = facing(template, car, camera), camera.project(car)[0]
    near = "R" if azimuth > 0.0 else "L"
    state = replace(CarState(), template=template.id).with_node(blank().sketch)
    while len(state.sketch.marks) < 6:
        sketch = state.sketch
        likely = likely_shown(template, sketch)
        done = {mark.node for mark in sketch.marks} | {*sketch.skipped}
        rest = [node for node in template.asked(sketch.shows) if template.names[node] not in done]
        name = template.names[min(rest, key=lambda node: not likely[node])]
        meant = name if not name.endswith((".L", ".R")) or sketch.shows == near else twin(name)
        node = template.node[meant]
        yield bool(shown[node])
        if shown[node]:
            state = set_mark(state, name, tuple(places[node] + rng.normal(0.0, 3.0, 2)), template)
        else:
            state = with_skipped(state, [name])


@pytest.mark.parametrize("name", TEMPLATES)
@pytest.mark.parametrize(
    ("azimuth", "most"),
    [(-45.0, 1), (-20.0, 1), (30.0, 1), (60.0, 1), (90.0, 1), (120.0, 2), (150.0, 2), (176.0, 6)],
)
def test_few_points_are_asked_for_that_the_sketch_does_not_show(name, azimuth, most):
    """In the template's order 1 to 3 are in three-quarter views, and 9 from right behind."""
    unseen = [sum(not s for s in marked_as_asked(bundled(name), azimuth, n)) for n in range(4)]
    assert np.mean(unseen) <= most


@pytest.mark.parametrize("name", TEMPLATES)
def test_without_marks_nothing_is_held_back_that_some_view_shows_at_once(name):
    template = bundled(name)
    likely = likely_shown(template, sketch_with([], []))
    near = [template.node[node] for node in ("WF.L", "WR.L", "C2", "S2.L", "R1.L")]
    assert likely[near].all()


def test_a_mirrored_sketch_shows_the_mirrored_nodes():
    template = bundled("sedan")
    car = styled(template, 5)
    camera = looking(car, ((-60.0, -60.0), (8.0, 8.0), (7.0, 7.0)), np.random.default_rng(0))
    names = ["WF.L", "WR.L", "C1", "C3"]
    places = camera.project(car)[0][[template.node[name] for name in names]]
    sketch = sketch_with(names, places, shows="L", skipped=("C6",))
    image = with_sides_exchanged(sketch_with(names, places * [-1.0, 1.0], skipped=("C6",)))
    left, right = likely_shown(template, sketch), likely_shown(template, image)
    assert image.shows == "R"
    assert (left[template.mirrored] == right).all()
    assert not (left == right).all()


def test_neither_place_nor_size_in_the_picture_counts():
    template = bundled("hatchback")
    car = styled(template, 6)
    camera = looking(car, ((140.0, 140.0), (9.0, 9.0), (6.0, 6.0)), np.random.default_rng(0))
    names = ["WF.R", "WR.R", "C6", "C7"]
    places = camera.project(car)[0][[template.node[name] for name in names]]
    one = likely_shown(template, sketch_with(names, places, shows="R"))
    for factor, shift in ((0.3, 40.0), (8.0, -2000.0)):
        other = sketch_with(names, factor * places + shift, shows="R")
        assert (likely_shown(template, other) == one).all()


def test_a_nose_that_is_not_seen_and_a_tail_that_is_tell_a_view_from_behind():
    template = bundled("sedan")
    likely = likely_shown(template, sketch_with([], [], skipped=("C1", "C0")))
    assert likely[template.node["C7"]]
    assert not likely[template.node["C1"]]


@pytest.mark.parametrize("place", [(1e30, 5.0), (0.0, 0.0)])
def test_marks_in_one_place_or_far_off_are_no_error(place):
    template = bundled("minivan")
    sketch = sketch_with(["WF.L", "WR.L", "nobody"], [place, place, (3.0, 4.0)])
    assert likely_shown(template, sketch).dtype == bool
