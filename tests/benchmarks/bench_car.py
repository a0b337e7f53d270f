"""The car: cameras and shape solved together, cold and while a mark is dragged."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from bozzetto.geometry.coons import coons_nets
from bozzetto.geometry.patch import extent
from bozzetto_car.certainty import certainty, further_views
from bozzetto_car.deformation import Cost, Prior
from bozzetto_car.dimensions import Dimensions
from bozzetto_car.joint import Joint, solve
from bozzetto_car.marked_view import MarkedView
from bozzetto_car.quadratic import constrained_minimum
from bozzetto_car.reshaping import Reshaping, reshaped
from bozzetto_car.soundness import Soundness
from bozzetto_car.template import Template
from bozzetto_car.template_file import bundled
from tests.benchmarks.timing import Row, in_turn, processor_ms
from tests.plugins.car.sketched import FRONT, FRONT_QUARTER, REAR_QUARTER, SIDE, sketched, styled

VIEWS = (FRONT_QUARTER, REAR_QUARTER, SIDE, FRONT)


class Dragging:
    """One mark goes to and fro by some pixels; each frame starts from the one before."""

    def __init__(self, template: Template, joint: Joint, cost: Cost, soundness: Soundness) -> None:
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


def rows() -> Iterator[Row]:
    """Solves of one to four sketches, then what is asked about a solved car."""
    template = bundled("sedan")
    sound, cost = Soundness.of(template), Cost.balanced()
    sketch = sketched(template, styled(template, 3), VIEWS, 3)
    for count in (1, 2, 4):
        given = sketch.views[:count]
        cold = processor_ms(lambda given=given: solve(template, given, cost, sound), repeats=15)
        yield Row("car", f"joint solve, cold, sketches: {count}", cold, "ms", "< 100 ms")
        dragging = Dragging(template, solve(template, given, cost, sound), cost, sound)
        frame = processor_ms(dragging.frame, repeats=30)
        yield Row("car", f"joint solve, drag frame, sketches: {count}", frame, "ms", "< 30 ms")
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
    sides = np.array([patch.edges for patch in template.patches])
    edges = template.control_points
    box = extent(coons_nets(edges, sides))
    wheels = template.positions[template.wheels[:, 0], 0]

    def measure(map_: Reshaping) -> np.ndarray:
        return extent(coons_nets(map_.points(edges), sides))

    wanted = Dimensions(wheelbase=2880.0, width=1850.0)
    yield Row("car", "dimensions", processor_ms(lambda: reshaped(wanted, box, wheels, measure)))
