"""How well each node is known, and which further sketch would tell most.

The inverse of the normal matrix is the covariance of the car, given the marks, the hand and the
template. No sketch can tell where the car stands, how large it is and how it is tilted; these
four numbers would hide everything else, so the covariance is that of the car after the best
alignment with the true one (the S-transformation of geodesy: Baarda 1973; Triggs et al. 2000,
section 9). As an error bar it trusts the template too much, for real cars do not differ from it
by chance. Compared with the covariance before any mark, it separates the places that were seen
from those that were guessed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from bozzetto.arrays import Array
from bozzetto.view import Camera, triple
from bozzetto_car.camera.marked_view import MarkedView, Reprojection
from bozzetto_car.camera.visibility import facing
from bozzetto_car.solver.bundle_adjustment import JointSolution, without_cameras
from bozzetto_car.solver.prior import Cost, Prior, extent
from bozzetto_car.template.model import Template, ViewHint

Source = Literal["seen", "mirrored", "guessed"]

FURTHER_VIEWS: Final = {
    "front": (0.0, 5.0),
    "front three-quarter": (40.0, 12.0),
    "side": (90.0, 5.0),
    "rear three-quarter": (140.0, 12.0),
    "rear": (180.0, 5.0),
    "above": (90.0, 80.0),
}
"""Sketches that can be asked for: azimuth from the nose and elevation, degrees."""

AWAY: Final = 1.8
"""Distance of the camera of such a sketch from the car, in diagonals of its box."""

FILLED: Final = 0.75
"""Part of the width or height of the picture that the car fills in such a sketch."""


@dataclass(frozen=True, eq=False)
class Certainty:
    """How well the nodes of a car are known.

    Attributes
    ----------
    sources : tuple of {"seen", "mirrored", "guessed"}, length n
        Whether a node has a mark in a sketch, or only its mirror image has one, or neither.
    deviations : (n,) float
        Standard deviation, root of the sum over the axes, mm.
    shares : (n,) float
        The deviation relative to that of the template alone: 0 is known, 1 is a guess.
    """

    sources: tuple[Source, ...]
    deviations: Array
    shares: Array


@dataclass(frozen=True)
class FurtherView:
    """A sketch that could be added.

    Attributes
    ----------
    name : str
        A key of `FURTHER_VIEWS`.
    before, after : float
        Root mean square standard deviation of a node without and with it, mm.
    """

    name: str
    before: float
    after: float


def certainty(template: Template, cost: Cost, joint: JointSolution) -> Certainty:
    """Return how well each node is known after a solve.

    Parameters
    ----------
    template : Template
        The template of the car.
    cost : Cost
        The cost that the solve used.
    joint : JointSolution
        The result of the solve.
    """
    marked = np.zeros(len(template.names), bool)
    for view in joint.views:
        marked[view.nodes] = True
    imaged = marked[template.mirrored]
    sources: list[Source] = [
        "seen" if own else "mirrored" if other else "guessed"
        for own, other in zip(marked.tolist(), imaged.tolist(), strict=True)
    ]
    before = joint.span.T @ Prior(template, cost).form(joint.variables) @ joint.span
    known = _variances(template, joint, joint.information)
    unknown = _variances(template, joint, before)
    shares = np.sqrt(np.minimum(known / unknown, 1.0))
    return Certainty(tuple(sources), np.sqrt(known), shares)


def further_views(template: Template, cost: Cost, joint: JointSolution) -> tuple[FurtherView, ...]:
    """Return sketches that could be added, the most telling first.

    The benefit of a sketch depends only on the nodes that it shows, not on the places of their
    marks, so that it is known beforehand (A-optimal design). Its camera counts as unknown.

    Parameters
    ----------
    template : Template
        The template of the car.
    cost : Cost
        The cost that the solve used.
    joint : JointSolution
        The result of the solve.
    """
    positions = template.whole(joint.variables)
    follow = (template.basis @ joint.span).reshape(-1, 3, joint.span.shape[1])
    now = float(np.sqrt(_variances(template, joint, joint.information).mean()))
    found = []
    for name, (azimuth, elevation) in FURTHER_VIEWS.items():
        camera = _camera(template, positions, azimuth, elevation, joint.views[0].camera.viewport)
        nodes = np.flatnonzero(facing(template, positions, camera))
        view = MarkedView(camera, nodes, camera.project(positions[nodes])[0])
        sight, pose = Reprojection.of(template, view, held=False)
        seen = sight.residuals(pose, positions)
        if seen is None:
            continue
        rows = sight.rows(seen, follow) / cost.hand
        information = without_cameras(rows.T @ rows, follow.shape[2])
        after = np.sqrt(_variances(template, joint, joint.information + information).mean())
        found.append(FurtherView(name, now, float(after)))
    return tuple(sorted(found, key=lambda view: view.after))


def _variances(template: Template, joint: JointSolution, information: Array) -> Array:
    """Return the variance of each node, summed over its axes, mm², (n,)."""
    spread = template.basis @ joint.span
    positions = template.whole(joint.variables)
    middle = positions - positions.mean(axis=0)
    # Rearward, upward, larger, and nose down: the motions that keep the car symmetric.
    tilted = np.stack((middle[:, 2], 0.0 * middle[:, 1], -middle[:, 0]), axis=1)
    ahead, up = (np.broadcast_to(axis, positions.shape) for axis in np.eye(3)[[0, 2]])
    motions = np.stack([np.ravel(part) for part in (ahead, up, middle, tilted)], axis=1)
    base, _ = np.linalg.qr(motions)
    spread = spread - base @ (base.T @ spread)
    covered = spread @ np.linalg.inv(information)
    return np.asarray((covered * spread).sum(axis=1).reshape(-1, 3).sum(axis=1))


def _camera(
    template: Template,
    positions: Array,
    azimuth: float,
    elevation: float,
    viewport: tuple[float, float],
) -> Camera:
    """Return a camera of a sketch that shows the whole car from a side."""
    middle = 0.5 * (positions.min(axis=0) + positions.max(axis=0))
    eye = middle + AWAY * extent(template) * ViewHint(azimuth, elevation).toward_eye
    wide = Camera("perspective", triple(eye), triple(middle), fov_y=60.0, viewport=viewport)
    places = wide.project(positions)[0]
    size = np.abs(places - 0.5 * np.array(viewport)).max(axis=0) / (0.5 * np.array(viewport))
    half = np.tan(np.radians(30.0)) * size.max() / FILLED
    return replace(wide, fov_y=float(np.degrees(2.0 * np.arctan(half))))
