"""Predict where a sketch will show a node that has no mark yet, with a covariance.

The place is uncertain because the camera and the car are. Both errors are correlated: a car that
is a little longer is seen by a camera a little farther away. So the covariance is propagated
through both, with the normal equations of the solve (Triggs et al. 2000, section 6).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import remembered
from bozzetto.view.calibration import Places
from bozzetto_car.camera.marked_view import Reprojection
from bozzetto_car.solver.bundle_adjustment import JointSolution
from bozzetto_car.solver.pipeline import Solved
from bozzetto_car.solver.prior import robust_weights

OPEN: Final = 1e-12
"""Share of the largest eigenvalue of a form below which a direction counts as undetermined."""


@remembered(limit=64)
def expected(solved: Solved, sketch: str, node: int) -> Places | None:
    """Return where a sketch is expected to show a node; remembered.

    Parameters
    ----------
    solved : Solved
        The solve.
    sketch : str
        Id of a sketch.
    node : int
        Index of the node.

    Returns
    -------
    Places or None
        One place with its covariance; None while the sketch has no camera, or where the node is
        not in front of it.
    """
    joint = solved.joint
    if joint is None or sketch not in solved.solid:
        return None
    view = joint.views[solved.solid.index(sketch)]
    sight, pose = Reprojection.of(solved.template, view, held=False)
    one = replace(sight, nodes=np.array([node]), marks=np.zeros((1, 2)))
    known, asked = (each.residuals(pose, solved.positions) for each in (sight, one))
    if known is None or asked is None:
        return None
    follow = _following(solved, joint)
    free = follow.shape[2]
    hand = solved.cost.hand
    rows = sight.rows(known, follow) / hand
    weights, _ = robust_weights(((known.missed / hand) ** 2).sum(axis=1), solved.cost.stray)
    told = (rows * np.repeat(weights, 2)[:, None]).T @ rows
    # Given the car, the marks determine the camera; `led` is how it follows the car.
    spread = np.linalg.pinv(told[free:, free:] + sight.middle(pose)[0], OPEN, True)
    led = spread @ told[free:, :free]
    by_all = one.rows(asked, follow)
    by_camera = by_all[:, free:]
    by_car = by_all[:, :free] - by_camera @ led
    car = np.linalg.pinv(joint.information, OPEN, True)
    unit = sight.extent * sight.framing.diagonal
    covariance = unit**2 * (by_car @ car @ by_car.T + by_camera @ spread @ by_camera.T)
    place = view.camera.project(solved.positions[[node]])[0] + view.shift
    return Places(np.asarray(place), covariance[None])


def _following(solved: Solved, joint: JointSolution) -> Array:
    """Return how the nodes follow the free directions of the car, (n, 3, f)."""
    span = joint.span
    return np.asarray((solved.template.basis @ span).reshape(-1, 3, span.shape[1]))
