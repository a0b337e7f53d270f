"""Commands on a car: what each of them leaves, and when it is offered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.plugin import Command, Context, Ink
from bozzetto_car.body.build import body_of
from bozzetto_car.commands import all_commands
from bozzetto_car.state import CarState, MovedNode, Treatment
from bozzetto_car.tools.trace_edges import TraceEdges
from tests.plugins.car.marked_car import another, locked_creases, marked, pen
from tests.plugins.car.traced_car import view


def command(id_: str) -> Command:
    (found,) = (one for one in all_commands() if one.id == id_)
    return found


def run(id_: str, state: CarState) -> CarState:
    made = command(id_).run(state, Context())
    assert isinstance(made, CarState)
    return made


def worked_on(seed: int = 0) -> CarState:
    """A marked car with three edges traced and a node moved."""
    state, camera = marked(seed), view(50.0, 10.0)
    for number, name in enumerate(("S3.R-S2.R", "C1-C2", "S3.R-B3.R")):
        stroke = pen(camera, another(body_of(state), name, number, 0.1))
        state = TraceEdges().apply(state, Ink((stroke,)), Context())
    return replace(state, edits=(*state.edits, MovedNode(node="R2.R", by=(20.0, 5.0, 9.0))))


def longest_handles(state: CarState) -> np.ndarray:
    """Length of the longer handle of each edge per chord."""
    points = body_of(state).network.control_points
    chords = np.linalg.norm(points[:, 3] - points[:, 0], axis=1)
    legs = np.linalg.norm(points[:, [1, 2]] - points[:, [0, 3]], axis=2)
    return legs.max(axis=1) / chords


def test_ids_are_told_once() -> None:
    ids = [one.id for one in all_commands()]
    assert len({*ids}) == len(ids)


@pytest.mark.parametrize(("id_", "kind"), [("anneal", "anneal"), ("reduce", "reduce"),
                                           ("pull-out", "pull out")])  # fmt: skip
def test_treatments_move_no_node_and_leave_surfaces_smooth(id_: str, kind: str) -> None:
    for seed in range(3):
        state = replace(worked_on(seed), length=4700.0)
        made = run(id_, state)
        assert made.edits[:-1] == state.edits
        assert made.edits[-1] == Treatment(state.dimensions, kind, kept=False)  # type: ignore[arg-type]
        before, after = body_of(replace(state, length=0.0)), body_of(replace(made, length=0.0))
        assert np.array_equal(before.network.positions, after.network.positions)
        assert not after.troubles
        assert locked_creases(body_of(made)).max() <= 0.1
        assert locked_creases(after).max() <= 0.1


def test_reduced_tangents_are_no_longer_than_a_third_of_the_chord() -> None:
    state = replace(worked_on(), smooth=False)
    assert longest_handles(state).max() > 0.34
    assert longest_handles(run("reduce", state)).max() < 1.0 / 3.0 + 1e-9
    # The lock that makes surfaces smooth again may take back a little of that.
    assert longest_handles(run("reduce", replace(state, smooth=True))).max() < 0.42


def test_annealed_lines_bend_least() -> None:
    """The natural spline is found again by SciPy, along the waistline, from its own knots."""
    from scipy.interpolate import CubicSpline

    state = run("anneal", worked_on())
    network = body_of(state).network
    template = network.template
    for chain in template.chains:
        if not chain.name.startswith("sill"):
            continue
        places = network.positions[list(chain.nodes)]
        points = [
            network.control_points[edge] if edge >= 0 else network.control_points[~edge][::-1]
            for edge in chain.edges
        ]
        speeds = np.array([np.linalg.norm(3 * (p[1] - p[0])) for p in points])
        steps = [1.0]
        for number in range(1, len(points)):
            end = np.linalg.norm(points[number - 1][3] - points[number - 1][2])
            begin = np.linalg.norm(points[number][1] - points[number][0])
            steps.append(steps[-1] * begin / end)
        knots = np.concatenate(([0.0], np.cumsum(steps)))
        spline = CubicSpline(knots, places, bc_type="natural")
        for number, own in enumerate(points):
            found = spline(knots[number : number + 2], 1) * steps[number]
            assert np.abs(3 * (own[1] - own[0]) - found[0]).max() < 1e-6 * speeds.max()
            assert np.abs(3 * (own[3] - own[2]) - found[1]).max() < 1e-6 * speeds.max()


def test_panels_pulled_out_are_so_once() -> None:
    state = replace(marked(), default_shape=False)
    once = run("pull-out", state)
    twice = run("pull-out", once)
    plain, one, two = (body_of(s).network.control_points for s in (state, once, twice))
    assert np.abs(one - plain).max() > 10.0
    assert np.abs(two - one).max() < 0.01 * np.abs(one - plain).max()


def test_all_edits_are_taken_back() -> None:
    state = worked_on()
    assert not command("undo-edits").enabled(marked())
    assert command("undo-edits").enabled(state)
    made = run("undo-edits", state)
    assert made == replace(state, edits=())


def test_sides_are_exchanged_and_exchanged_again() -> None:
    state = marked()
    made = run("exchange-sides", state)
    nodes = [mark.node for mark in state.sketches[0].marks]
    other = [mark.node for mark in made.sketches[0].marks]
    swapped = [n.replace(".R", ".x").replace(".L", ".R").replace(".x", ".L") for n in nodes]
    assert other == swapped
    assert run("exchange-sides", made) == state
    assert not command("exchange-sides").enabled(CarState())
    with pytest.raises(UserError, match="no marks"):
        run("exchange-sides", CarState())
