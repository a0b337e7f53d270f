"""The car: solved and dragged, traced and styled; its surfaces, dimensions, files and skin."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import count

import numpy as np

from bozzetto.exchange.cad.step import write_shapes
from bozzetto.geometry.patches.coons import coons_nets
from bozzetto.geometry.patches.patch import bernstein, extent, grid, grid_normals
from bozzetto.geometry.wrap.shrink_wrap import shrink_wrap
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag, Ink
from bozzetto_car.body.build import body_of
from bozzetto_car.body.dimension_map import Reshaping, fit_reshaping
from bozzetto_car.body.trace_edges import trace
from bozzetto_car.camera.marked_view import MarkedView
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.export import shapes_of
from bozzetto_car.solver.bundle_adjustment import JointSolution, solve
from bozzetto_car.solver.pipeline import solve_car
from bozzetto_car.solver.prior import Cost, Prior
from bozzetto_car.solver.quadratic_program import constrained_minimum
from bozzetto_car.solver.uncertainty import certainty, further_views
from bozzetto_car.state import CarState, Mark, Sketch
from bozzetto_car.styling.curve import project_stroke
from bozzetto_car.styling.live_preview import Growing
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network, edge_called
from bozzetto_car.template.shape_constraints import Soundness
from bozzetto_car.tools.mark_points import MarkPoints
from bozzetto_car.tools.trace_edges import TraceEdges
from bozzetto_car.view.mark_items import MARK
from bozzetto_car.view.scene import scene_of
from bozzetto_car.view.surface_colors import curvature_colors
from tests.benchmarks.timing import Row, in_turn, processor_ms
from tests.plugins.car.marked_car import another, pen
from tests.plugins.car.sketched import (
    FRONT,
    FRONT_QUARTER,
    PICTURE,
    REAR_QUARTER,
    SIDE,
    Sketched,
    sketched,
    styled,
)
from tests.plugins.car.traced_car import SEEN
from tests.plugins.car.traced_car import view as seen_from
from tests.previews import preview_of

VIEWS = (FRONT_QUARTER, REAR_QUARTER, SIDE, FRONT)


class Dragging:
    """One mark goes to and fro by some pixels; each frame starts from the one before."""

    def __init__(
        self, template: Template, joint: JointSolution, cost: Cost, soundness: Soundness
    ) -> None:
        self.template, self.joint, self.cost, self.soundness = template, joint, cost, soundness
        self.frames = 0

    def frame(self) -> None:
        view, *others = self.joint.views
        marks = view.marks.copy()
        marks[5] += 4.0 * np.array([1.0, -0.7]) * (1.0 if self.frames % 20 < 10 else -1.0)
        self.frames += 1
        moved = MarkedView(view.camera, view.nodes, marks)
        self.joint = solve(
            self.template,
            [moved, *others],
            self.cost,
            self.soundness,
            start=self.joint.variables,
        )


def quadratic(template: Template, soundness: Soundness) -> tuple[np.ndarray, ...]:
    """One step of a solve in which some inequalities bind."""
    rng = np.random.default_rng(0)
    form = Prior(template, Cost.balanced()).form(template.variables)
    slope = -form @ rng.normal(0.0, 120.0, len(form))
    rows = soundness.jacobian(template.variables)
    return form, slope, rows, -soundness.slacks(template.variables)


def slsqp(form: np.ndarray, slope: np.ndarray, rows: np.ndarray, least: np.ndarray) -> object:
    """The same step by SciPy's solver for general problems."""
    from scipy.optimize import minimize

    return minimize(
        lambda x: (0.5 * x @ form @ x + slope @ x, form @ x + slope),
        np.zeros(len(form)),
        jac=True,
        method="SLSQP",
        constraints={"type": "ineq", "fun": lambda x: rows @ x - least, "jac": lambda x: rows},
        options={"ftol": 1e-10, "maxiter": 300},
    )


def joint_rows(template: Template, sketch: Sketched) -> Iterator[Row]:
    """JointSolution solves of one to four sketches, then what is asked about a solved car."""
    sound, cost = Soundness.of(template), Cost.balanced()
    for number in (1, 2, 4):
        given = sketch.views[:number]
        cold = processor_ms(lambda given=given: solve(template, given, cost, sound), repeats=15)
        yield Row("car", f"joint solve, cold, sketches: {number}", cold, "ms", "< 100 ms")
        dragging = Dragging(template, solve(template, given, cost, sound), cost, sound)
        frame = processor_ms(dragging.frame, repeats=30)
        yield Row("car", f"joint solve, drag frame, sketches: {number}", frame, "ms", "< 30 ms")
    exact = Cost.balanced(1.0)
    one = sketch.views[:1]
    cold = processor_ms(lambda: solve(template, one, exact, sound), repeats=15)
    yield Row("car", "joint solve, cold, traced exactly", cold, "ms", "< 100 ms")
    paper = Cost.paper(template)
    held = processor_ms(lambda: solve(template, one, paper, sound, hold_cameras=True), repeats=15)
    yield Row("car", "the paper's cost, camera held", held, "ms", "< 100 ms")
    step = quadratic(template, sound)
    ours, other = in_turn(lambda: constrained_minimum(*step), lambda: slsqp(*step), repeats=15)
    yield Row("car", "one step under 130 inequalities", ours, "ms", "", "SLSQP", other)
    joint = solve(template, one, cost, sound)
    yield Row("car", "certainty", processor_ms(lambda: certainty(template, cost, joint)))
    yield Row("car", "further views", processor_ms(lambda: further_views(template, cost, joint)))


# -- as a person has it --


def marked(template: Template, sketch: Sketched, number: int) -> CarState:
    """A car of so many sketches with all of their marks."""
    sketches = []
    for view in sketch.views[:number]:
        names = [template.names[node] for node in view.nodes.tolist()]
        places = zip(names, view.marks.tolist(), strict=True)
        marks = tuple(Mark(name, u, v) for name, (u, v) in places)
        key = f"sketch-{len(sketches)}"
        sketches.append(Sketch(key, key, width=PICTURE[0], height=PICTURE[1], marks=marks))
    return CarState(nodes=tuple(sketches), selected=sketches[0].id)


def never_seen(state: CarState) -> Callable[[], CarState]:
    """The same car at each call, but for a trillionth of a pixel: nothing of it is remembered."""
    numbers = count()
    sketch = state.sketches[0]
    mark = sketch.marks[0]

    def car() -> CarState:
        moved = replace(mark, u=mark.u + 1e-12 * next(numbers) * abs(mark.u))
        return state.with_node(replace(sketch, marks=(moved, *sketch.marks[1:])))

    return car


def dragging(state: CarState) -> Callable[[], object]:
    """A mark under the pen: all that the Mark tool does for one frame."""
    body = body_of(state)
    sketch = state.sketches[0]
    sketch_camera, mark = body.sketch_cameras[sketch.id], sketch.marks[5]
    camera = sketch_camera.view(PICTURE)
    tool, numbers = MarkPoints(), count()

    def frame() -> object:
        turn = 0.1 * next(numbers)
        there = mark.u + 6.0 * np.sin(turn), mark.v + 4.0 * np.cos(turn)
        way = sketch_camera.lifted([(mark.u, mark.v), there])
        x, y = camera.project(way)[0].T
        return preview_of(tool, state, Drag(MARK + mark.node, Stroke(x, y, camera)), Context())

    return frame


def working_rows(template: Template, sketch: Sketched) -> Iterator[Row]:
    """From marks to what is seen, and what is done to the body."""
    for number in (1, 2, 4):
        state = marked(template, sketch, number)
        car = never_seen(state)
        cold = processor_ms(lambda car=car: solve_car(car()), repeats=15)
        yield Row("car", f"marks to solved car, cold, sketches: {number}", cold, "ms", "≤ 100 ms")
        frame = processor_ms(dragging(state), repeats=30)
        yield Row("car", f"a mark dragged, frame, sketches: {number}", frame, "ms", "≤ 30 ms")
    state = marked(template, sketch, 1)
    base, car = body_of(state), never_seen(state)
    skin = replace(state, shading="zebra")
    whole = processor_ms(lambda: scene_of(skin, body_of(car())), repeats=15)
    yield Row("car", "marks to body and scene, cold", whole)
    camera = base.sketch_cameras[state.sketches[0].id].camera
    edge = base.network.control_points[edge_called(template, "C1-C2")]
    places = camera.project(bernstein(np.linspace(0.02, 0.98, 60)) @ edge)[0]
    stroke = places + 6.0 * np.sin(np.linspace(0.0, np.pi, 60))[:, None] * (0.0, -1.0)
    traced = processor_ms(lambda: trace(base.network, stroke, camera), repeats=15)
    yield Row("car", "an edge traced by a stroke", traced)
    low, high = (camera.project(base.network.positions[[template.node[name] for name in names]])[0]
                 for names in (("S2.R", "S4.R"), ("B2.R", "B4.R")))  # fmt: skip
    ends = 0.5 * (low + high)
    line = ends[0] + np.linspace(0.0, 1.0, 200)[:, None] * (ends[1] - ends[0])
    lay = processor_ms(lambda: project_stroke(base, line, camera), repeats=15)
    yield Row("car", "a styling curve of 200 samples laid on the body", lay)
    growing, ends_at = Growing(base.nets, camera), count(2, 6)
    move = processor_ms(lambda: growing.lines(line[: next(ends_at)]), repeats=32)
    yield Row("car", "a move of the pen while it is drawn", move, "ms", "≤ 10 ms")
    shapes = shapes_of(state, base)
    yield Row("car", "STEP of the body, written", processor_ms(lambda: write_shapes(shapes)))


def stroked(state: CarState, number_of: int) -> CarState:
    """A car with so many strokes along its edges, every third one in a view of its own."""
    tool = TraceEdges()
    for number in range(number_of):
        body = body_of(state)
        aim = another(body, SEEN[number % len(SEEN)], number, 0.04)
        through = body.sketch_cameras[state.sketches[0].id].view((1700.0, 700.0))
        camera = through if number % 3 else seen_from(50.0, 10.0)
        state = tool.apply(state, Ink((pen(camera, aim),)), Context())
    return state


def edit_rows(template: Template, sketch: Sketched) -> Iterator[Row]:
    """All strokes made again, because what they were drawn on has changed."""
    plain = marked(template, sketch, 2)
    car = never_seen(stroked(plain, 10))
    ten = processor_ms(lambda: body_of(car()), repeats=15)
    yield Row("car", "exact body after a mark has changed, 10 strokes", ten, "ms", "≤ 40 ms")
    many, lengths = stroked(plain, 51), count(4700, 1)
    typed = processor_ms(
        lambda: body_of(replace(many, lock=True, length=float(next(lengths)))), repeats=15
    )
    yield Row("car", "a kept dimension typed, 51 strokes", typed, "ms", "≤ 100 ms")


# -- surfaces --


def spline_by_spline(nets: np.ndarray, places: np.ndarray) -> list[np.ndarray]:
    """The same places of patches by SciPy's tensor product splines."""
    from scipy.interpolate import NdBSpline

    knots = np.repeat((0.0, 1.0), 4)
    return [NdBSpline((knots, knots), net, k=3)(places) for net in nets]


def surface_rows(template: Template) -> Iterator[Row]:
    """Patches from edges, dimensions, and a skin over the edges."""
    edges, sides = Network.of(template).control_points, template.sides
    steps = np.linspace(0.0, 1.0, 13)
    square = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1)
    nets = coons_nets(edges, sides)
    ours, other = in_turn(
        lambda: grid(coons_nets(edges, sides), steps, steps),
        lambda: spline_by_spline(nets, square),
        repeats=51,
    )
    yield Row("car", "28 patches from their edges, 13 × 13 places", ours, "ms", "≤ 0.5 ms",
              "SciPy's NdBSpline, without making the patches", other)  # fmt: skip
    network = Network.of(template)
    fair, plain = in_turn(lambda: fair_nets(network), lambda: coons_nets(edges, sides), repeats=51)
    yield Row("car", "patches of a car of least variation", fair, "ms", "≤ 1 ms",
              "the same with twists of 0", plain)  # fmt: skip
    for what, work, budget in (
        ("their normals", lambda: grid_normals(nets, steps, steps), "≤ 0.5 ms"),
        ("the colours of their curvature", lambda: curvature_colors(nets), "≤ 3 ms"),
    ):
        yield Row("car", what, processor_ms(work, repeats=51), "ms", budget)
    box = extent(nets)
    wheels = template.positions[template.wheels[:, 0], 0]

    def measure(map_: Reshaping) -> np.ndarray:
        return extent(coons_nets(map_.points(edges), sides))

    wanted = Dimensions(wheelbase=2880.0, width=1850.0)
    yield Row(
        "car", "dimensions", processor_ms(lambda: fit_reshaping(wanted, box, wheels, measure))
    )
    lines = bernstein(np.linspace(0.0, 1.0, 25)) @ edges
    skin = processor_ms(lambda: shrink_wrap(lines), repeats=3)
    yield Row("car", "rough skin over 62 edges, 10,242 vertices", skin)


def rows() -> Iterator[Row]:
    """One car from four sides."""
    template = bundled("sedan")
    sketch = sketched(template, styled(template, 3), VIEWS, 3)
    yield from joint_rows(template, sketch)
    yield from working_rows(template, sketch)
    yield from edit_rows(template, sketch)
    yield from surface_rows(template)
