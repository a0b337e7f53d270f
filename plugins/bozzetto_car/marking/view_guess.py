"""Which nodes a sketch is likely to show before its camera is known.

Six marks determine a camera; fewer leave many possible. So views from all around the car, from far
and near, are laid over the marks, each as well as a place and a size in the picture allow, and the
better one fits, the more it counts (Bayes' rule over a grid). What was noted as not visible counts,
too: a sketch without the rear window was drawn from the front.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.view import Camera, triple
from bozzetto_car.camera.visibility import facing, on_their_side
from bozzetto_car.marking.edit_marks import near_wheels
from bozzetto_car.state import Sketch
from bozzetto_car.template.model import Template, ViewHint, twin

AZIMUTHS: Final = np.arange(0.0, 181.0, 6.0)
"""Directions of the possible views, degrees from the nose, on one side of the car."""

ELEVATIONS: Final = np.arange(-4.0, 45.0, 8.0)
"""Their elevations, degrees."""

DISTANCES: Final = (0.8, 1.6, 10.0)
"""Distances of their eyes from the middle of the car, in diagonals of its box: 4, 8 and 50 m."""

OFF: Final = 0.04
"""Standard deviation of a mark from its place, in diagonals of the car in the picture: that of
cars from their template, as far as the grid tells a view."""

MISTAKEN: Final = 0.1
"""Probability that a node is marked that does not face the eye, or noted as not visible though it
does."""
MAY: Final = 0.3
"""Probability from which a sketch may be one from the side of a node: few marks tell little of the
view, and those of one side of the car alone would leave the camera open."""


@lru_cache(maxsize=8)
def _views(template: Template) -> tuple[Array, Flags, Flags]:
    """Return where possible views of the left side show each node, (v, n, 2), and which face them.

    The third are those that are seen best from about there.

    Places are about their middle, in diagonals of the box of all nodes in the picture.
    """
    positions = template.positions
    middle = 0.5 * (positions.min(axis=0) + positions.max(axis=0))
    size = float(np.linalg.norm(np.ptp(positions, axis=0)))
    places, shown, told = [], [], []
    for away in DISTANCES:
        for azimuth in AZIMUTHS:
            for elevation in ELEVATIONS:
                toward = ViewHint(-float(azimuth), float(elevation)).toward_eye
                eye = triple(middle + away * size * toward)
                camera = Camera("perspective", eye, triple(middle), fov_y=60.0)
                seen = camera.project(positions)[0]
                places.append((seen - seen.mean(axis=0)) / np.linalg.norm(np.ptp(seen, axis=0)))
                shown.append(facing(template, positions, camera))
                told.append(on_their_side(template, positions, camera))
    return np.array(places), np.array(shown), np.array(told)


def likely_shown(template: Template, sketch: Sketch) -> Flags:
    """Which nodes a sketch more likely shows than not, (n,), as far as its marks tell.

    Parameters
    ----------
    template : Template
        The template of the car.
    sketch : Sketch
        The sketch. Until both of its near wheels are marked it may be one of the other side, whose
        marks will then change their names.
    """
    return _likely(template, sketch, _views(template)[1], 0.5)


def likely_on_their_side(template: Template, sketch: Sketch) -> Flags:
    """Which nodes may be seen best from about there, (n,), as `likely_shown`."""
    return _likely(template, sketch, _views(template)[2], MAY)


def _likely(template: Template, sketch: Sketch, which: Flags, share: float) -> Flags:
    """Return the nodes of which that is so, by view (v, n), in a share of the likely views."""
    places, shown, _ = _views(template)
    to_left = sketch.shows == "L"

    def node_of(name: str) -> int | None:
        return template.node.get(name if to_left else twin(name))

    marks = [(node_of(mark.node), mark.u, mark.v) for mark in sketch.marks]
    known = [(node, u, v) for node, u, v in marks if node is not None]
    nodes = np.array([node for node, _, _ in known], np.intp)
    at = np.array([(u, v) for _, u, v in known], float).reshape(-1, 2)
    skipped = [node for node in map(node_of, sketch.skipped) if node is not None]
    sides = [1.0 if to_left else -1.0]
    if not all(sketch.mark_of(wheel) for wheel in near_wheels(sketch, template)):
        sides = [1.0, -1.0]
    logs = np.log(MISTAKEN) * ((~shown[:, nodes]).sum(axis=1) + shown[:, skipped].sum(axis=1))
    fits = np.array([_log_fit(places[:, nodes], at * [side, 1.0]) for side in sides])
    logs = logs + np.logaddexp.reduce(fits, axis=0)
    weights = np.exp(logs - logs.max())
    likely = weights @ which / weights.sum() >= share
    return np.asarray(likely if to_left else likely[template.mirrored])


def _log_fit(places: Array, marks: Array) -> Array:
    """Return how well each view (v, k, 2) lies over the marks (k, 2), as logarithms."""
    count = len(marks)
    if count < 2:
        return np.zeros(len(places))
    marks = marks - marks.mean(axis=0)
    places = places - places.mean(axis=1, keepdims=True)
    spread = float((marks**2).sum())
    if spread <= 0.0:
        return np.zeros(len(places))
    # What is left of the places when the marks, brought to their size, are taken from them.
    along = np.maximum((places * marks).sum(axis=(1, 2)), 0.0)
    left = (places**2).sum(axis=(1, 2)) - along**2 / spread
    return np.asarray(-0.5 * left / OFF**2)
