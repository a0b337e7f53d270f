"""What solved cars are judged by."""

from __future__ import annotations

import numpy as np

from bozzetto_car.dimensions import measure_dimensions
from bozzetto_car.solver.bundle_adjustment import JointSolution, solve
from bozzetto_car.solver.prior import Cost
from bozzetto_car.template.model import Template
from bozzetto_car.template.shape_constraints import Soundness
from tests.plugins.car.sketched import Sketched


def assert_allowed(template: Template, joint: JointSolution, soundness: Soundness) -> None:
    """What holds of every car that comes out, whatever went in."""
    car = template.whole(joint.variables)
    assert np.isfinite(car).all()
    assert np.array_equal(car[template.mirrored], car * [1.0, -1.0, 1.0])
    assert (car[template.centre, 1] == 0.0).all()
    assert soundness.slacks(joint.variables).min() >= -1e-9
    assert all(np.isfinite(missed).all() for missed in joint.residuals)
    assert np.isfinite(joint.information).all()
    for other in joint.left_out:
        assert np.isfinite([other.missed, other.surprise]).all()
    for view in joint.views:
        seen = view.camera.project(car[view.nodes])[0]
        assert np.isfinite(seen).all()


def joint_of(template: Template, sketch: Sketched, cost: Cost | None = None) -> JointSolution:
    return solve(template, sketch.views, cost or Cost.balanced(), Soundness.of(template))


def of_nodes(template: Template, joint: JointSolution) -> dict[str, float]:
    car = template.whole(joint.variables)
    body = np.delete(car, template.wheels.ravel(), axis=0)
    front, rear = car[template.wheels[:, 0], 0]
    return measure_dimensions(np.array([body.min(axis=0), body.max(axis=0)]), front, rear).given()
