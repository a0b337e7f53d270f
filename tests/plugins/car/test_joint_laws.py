"""Cameras and shape together: laws of the solve, from exact marks to wild ones."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.view import Camera
from bozzetto_car.camera.marked_view import MarkedView
from bozzetto_car.solver.bundle_adjustment import solve
from bozzetto_car.solver.prior import Cost
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.shape_constraints import Soundness, soundness_names
from tests.plugins.car.sketched import (
    FRONT,
    FRONT_QUARTER,
    PICTURE,
    REAR_QUARTER,
    SIDE,
    View,
    apart,
    looking,
    rms,
    sketched,
    styled,
)
from tests.plugins.car.solved import joint_of


def test_exact_marks_of_the_template_change_nothing(template: Template) -> None:
    rng = np.random.default_rng(0)
    camera = looking(template.positions, FRONT_QUARTER, rng)
    nodes = np.arange(len(template.names))
    view = MarkedView(camera, nodes, camera.project(template.positions)[0])
    joint = solve(template, [view], Cost.balanced(), Soundness.of(template))
    assert template.whole(joint.variables) == pytest.approx(template.positions, abs=1e-6)
    assert joint.residuals[0].max() < 1e-6


@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_exact_marks_of_four_views_give_the_car(template: Template, kind: str) -> None:
    """Without a hand's noise and with next to no prior the car is determined but for its place."""
    car = styled(template, 3)
    sketch = sketched(
        template, car, (FRONT_QUARTER, REAR_QUARTER, SIDE, FRONT), 3, hand=0.0, kind=kind
    )
    joint = joint_of(template, sketch, Cost.balanced(1.0))
    assert rms(apart(template.whole(joint.variables), car)) < 3.0
    assert max(rms(missed) for missed in joint.residuals) < 0.2


def test_a_sketch_of_the_other_side_is_the_same_car() -> None:
    """Left and right exchanged: the same cost, and the same car."""
    template = bundled("sedan")
    sketch = sketched(template, styled(template, 1), (FRONT_QUARTER,), 1)
    (view,) = sketch.views
    camera = view.camera
    x, y, z = camera.eye
    tx, ty, tz = camera.target
    ux, uy, uz = camera.up
    other = Camera(
        camera.kind, (x, -y, z), (tx, -ty, tz), (ux, -uy, uz), camera.fov_y, camera.height, PICTURE
    )
    flipped = view.marks * [-1.0, 1.0] + [PICTURE[0], 0.0]
    mirrored = MarkedView(other, template.mirrored[view.nodes], flipped)
    one = joint_of(template, sketch)
    two = solve(template, [mirrored], Cost.balanced(), Soundness.of(template))
    assert two.cost == pytest.approx(one.cost, rel=1e-4)
    assert two.variables == pytest.approx(one.variables, abs=1.0)


def test_the_slider_goes_from_the_template_to_the_marks() -> None:
    template = bundled("hatchback")
    sketch = sketched(template, styled(template, 2), (FRONT_QUARTER,), 2)
    missed, moved = [], []
    for trace in (0.0, 0.3, 0.6, 1.0):
        joint = joint_of(template, sketch, Cost.balanced(trace))
        missed.append(rms(joint.residuals[0]))
        moved.append(rms(template.whole(joint.variables) - template.positions))
    assert (np.diff(missed) < 0.0).all()
    assert moved[0] < moved[1] < moved[3]


def test_warm_and_cold_lead_to_the_same_car() -> None:
    template = bundled("sedan")
    sketch = sketched(template, styled(template, 5), (FRONT_QUARTER, REAR_QUARTER), 5)
    joint = joint_of(template, sketch)
    views = list(joint.views)
    for _ in range(10):  # one mark is dragged
        marks = views[0].marks.copy()
        marks[4] += [4.0, -3.0]
        views[0] = MarkedView(views[0].camera, views[0].nodes, marks)
        joint = solve(
            template, views, Cost.balanced(), Soundness.of(template), start=joint.variables
        )
        views = list(joint.views)
    first = MarkedView(sketch.views[0].camera, views[0].nodes, views[0].marks)
    cold = solve(template, [first, sketch.views[1]], Cost.balanced(), Soundness.of(template))
    assert joint.cost == pytest.approx(cold.cost, rel=1e-3)
    assert joint.variables == pytest.approx(cold.variables, abs=3.0)


def test_solved_again_it_stays(template: Template) -> None:
    sketch = sketched(template, styled(template, 6), (FRONT_QUARTER, REAR_QUARTER), 6)
    once = joint_of(template, sketch)
    cost, sound = Cost.balanced(), Soundness.of(template)
    again = solve(template, once.views, cost, sound, start=once.variables)
    assert again.variables == pytest.approx(once.variables, abs=1.0)
    assert again.cost <= once.cost * (1.0 + 1e-9)


@pytest.mark.parametrize("views", [(FRONT_QUARTER,), (FRONT_QUARTER, REAR_QUARTER)])
def test_one_wild_mark_is_named(template: Template, views: tuple[View, ...]) -> None:
    """A mark that is 120 px off; the shape may give way to it, but the others tell."""
    for seed in range(4):
        sketch = sketched(template, styled(template, seed), views, seed)
        view = sketch.views[0]
        wild = 3 * seed % len(view.nodes)
        marks = view.marks.copy()
        marks[wild] += 120.0 * np.array([np.cos(seed), np.sin(seed)])
        given = [MarkedView(view.camera, view.nodes, marks), *sketch.views[1:]]
        joint = solve(template, given, Cost.balanced(), Soundness.of(template))
        assert np.argmax(joint.left_out[0].surprise) == wild
        assert joint.left_out[0].surprise[wild] > 5.0
        assert joint.left_out[0].missed[wild] > 60.0


def test_left_out_is_what_a_solve_without_the_mark_says() -> None:
    """Against solving again without each mark, for a car near the template."""
    template = bundled("sedan")
    car = template.positions + 0.3 * (styled(template, 2) - template.positions)
    sketch = sketched(template, car, (FRONT_QUARTER, REAR_QUARTER), 2)
    joint = joint_of(template, sketch, Cost.balanced(0.3))
    view = sketch.views[0]
    found, expected = [], []
    for number in range(0, len(view.nodes), 3):
        rest = np.delete(np.arange(len(view.nodes)), number)
        fewer = MarkedView(view.camera, view.nodes[rest], view.marks[rest])
        other = solve(
            template,
            [fewer, sketch.views[1]],
            Cost.balanced(0.3),
            Soundness.of(template),
            start=joint.variables,
        )
        node = template.whole(other.variables)[view.nodes[[number]]]
        place = other.views[0].camera.project(node)[0][0]
        expected.append(np.linalg.norm(place - view.marks[number]))
        found.append(joint.left_out[0].missed[number])
    assert np.abs(np.subtract(found, expected)).max() < 0.5 + 0.1 * max(expected)


def test_with_everything_switched_off_the_marks_have_their_way(template: Template) -> None:
    """Marks that turn the roof's order round: sound as far as it goes, or traced."""
    sketch = sketched(template, styled(template, 1), (FRONT_QUARTER,), 1)
    (view,) = sketch.views
    here = {int(node): row for row, node in enumerate(view.nodes)}
    first, second = here[template.node["C2"]], here[template.node["C3"]]
    marks = view.marks.copy()
    marks[[first, second]] = marks[[second, first]]
    given = [MarkedView(view.camera, view.nodes, marks)]
    sound, nothing = Soundness.of(template), Soundness.of(template, soundness_names(template))
    assert nothing.names == ()
    exact = Cost.balanced(1.0)
    kept, free = (solve(template, given, exact, rules) for rules in (sound, nothing))
    assert sound.slacks(kept.variables).min() >= -1e-9
    assert sound.slacks(free.variables).min() < -10.0
    assert free.cost < kept.cost


def test_the_papers_way_holds_the_camera_and_moves_less() -> None:
    template = bundled("sedan")
    sketch = sketched(template, styled(template, 4), (FRONT_QUARTER,), 4)
    cost, sound = Cost.paper(template), Soundness.of(template)
    joint = solve(template, sketch.views, cost, sound, hold_cameras=True)
    before = sketch.views[0].camera
    after = joint.views[0].camera
    points = template.positions
    assert after.project(points)[0] == pytest.approx(before.project(points)[0], abs=1e-6)
    assert rms(joint.residuals[0]) > 2.0  # the balance that the paper strikes
    marked = sketch.views[0].nodes
    moved = np.linalg.norm(template.whole(joint.variables) - points, axis=1)
    untouched = np.setdiff1d(np.arange(len(points)), np.append(marked, template.mirrored[marked]))
    assert moved[marked].max() > 20.0
    # Unmarked nodes stay, but where the inequalities push them.
    assert np.median(moved[untouched]) < 1.0


def test_a_cropped_sketch_finds_where_it_was_cut() -> None:
    template = bundled("sedan")
    sketch = sketched(template, styled(template, 7), (FRONT_QUARTER, REAR_QUARTER), 7, hand=0.5)
    cut = np.array([60.0, -35.0])
    views = [
        MarkedView(view.camera, view.nodes, view.marks + cut, cropped=True) for view in sketch.views
    ]
    joint = solve(template, views, Cost.balanced(), Soundness.of(template))
    ignorant = solve(
        template,
        [MarkedView(view.camera, view.nodes, view.marks) for view in views],
        Cost.balanced(),
        Soundness.of(template),
    )
    assert rms(joint.residuals[0]) < 1.5
    assert joint.cost < ignorant.cost
