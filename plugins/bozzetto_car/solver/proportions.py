"""How cars differ as a whole: their outer dimensions, their size, and toward other templates.

Length, width, wheelbase and height of cars that were built vary together, so a car that is seen to
be long for its height is believed to be a large one. `car_sizes.json` holds the covariance of
their logarithms; the means are the template's. No sketch tells how large a car is, and therefore
its size is estimated apart from its shape (`believable_size`).

What lies between (screens, pillars, tail) differs among the bundled templates; those
differences, at equal outer dimensions, are directions in which other cars may differ, too.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache, lru_cache
from importlib.resources import files
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import Template

OUTER: Final = ("length", "width", "wheelbase", "height")
"""Outer dimensions, in the order of the covariance."""

BY_ITSELF: Final = 0.04
"""Standard deviation by which each dimension differs besides, as a share: the tabled cars are of
1990 to 1993, and a template is no mean of its kind."""

OVERHANG_SHARE: Final = 0.03
"""Standard deviation of the share that the front has of both overhangs: that of the templates."""

SHARED_NODES: Final = 0.8
"""Least share of the nodes of a template that another one must have to be a kin of it."""

WAYS: Final = 2.0
"""Number of ways toward other templates whose variance all of them have together."""

KNOWN: Final = 16
"""Number of templates whose directions are remembered."""


@cache
def size_covariance() -> Array:
    """Return the covariance (4, 4) of the logarithms of outer dimensions about a template's."""
    text = files("bozzetto_car").joinpath("solver/car_sizes.json").read_text("utf-8")
    return np.asarray(json.loads(text)["covariance"], float) + BY_ITSELF**2 * np.eye(len(OUTER))


def outer_dimensions(template: Template, positions: Array) -> Array:
    """Return length, width, wheelbase and height of the nodes (n, 3) of a car, mm, (4,)."""
    body = np.delete(positions, template.wheels.ravel(), axis=0)
    front, rear = positions[template.wheels[:, 0], 0]
    length, width = np.ptp(body[:, :2], axis=0)
    return np.array([length, width, rear - front, body[:, 2].max()])


def believable_size(template: Template, positions: Array) -> float:
    """Return the factor by which a car is to be scaled so that its size is most probable.

    With d the logarithms of its outer dimensions relative to the template's, and C their
    covariance, the factor exp(s) has the s for which d + s is least in the norm of C⁻¹.

    Parameters
    ----------
    template : Template
        The template of the car, whose outer dimensions are the mean.
    positions : (n, 3) float
        Nodes of the car, of any size, mm.
    """
    was = outer_dimensions(template, template.positions)
    found = np.log(outer_dimensions(template, positions) / was)
    return float(np.exp(-_common(found, size_covariance())))


def size_of_known(ratios: Mapping[str, float]) -> float | None:
    """Return the factor of size that known outer dimensions suggest; None if none is known.

    Parameters
    ----------
    ratios : mapping of str to float
        By name (`OUTER`), the dimension relative to the template's; other names do not count.
    """
    known = [number for number, name in enumerate(OUTER) if name in ratios]
    if not known:
        return None
    logs = np.log([ratios[OUTER[number]] for number in known])
    return float(np.exp(_common(logs, size_covariance()[np.ix_(known, known)])))


def _common(logs: Array, covariance: Array) -> float:
    """Return the generalised least squares estimate of what several numbers have in common."""
    weights = np.linalg.solve(covariance, np.ones(len(logs)))
    return float(weights @ logs / weights.sum())


@lru_cache(maxsize=KNOWN)
def outer_directions(template: Template) -> tuple[Array, Array]:
    """Return the directions (q, 5) in which outer dimensions change, and their covariance (5, 5).

    Each dimension changes in the ratio e, to first order; where the length does and the wheelbase
    does not, both overhangs follow. The last direction moves the wheels along the body, which
    changes the share of the front overhang.
    """
    places = template.positions
    body = np.delete(places, template.wheels.ravel(), axis=0)
    front, rear = places[template.wheels[:, 0], 0]
    low, high = float(body[:, 0].min()), float(body[:, 0].max())
    length, _, wheelbase, _ = outer_dimensions(template, places)
    share = (front - low) / (length - wheelbase)
    knots = [low, front, rear, high]
    half, rest = 0.5 * wheelbase, length - wheelbase
    found = np.zeros((5, *places.shape))
    ends = np.array([-share, 0.0, 0.0, 1.0 - share])
    found[0, :, 0] = np.interp(places[:, 0], knots, length * ends)
    found[1, :, 1] = places[:, 1]
    axles = np.array([-half, -half, half, half])
    found[2, :, 0] = np.interp(places[:, 0], knots, axles - wheelbase * ends)
    found[3, :, 2] = places[:, 2]
    found[4, template.wheels.ravel(), 0] = rest
    covariance = np.zeros((5, 5))
    covariance[:4, :4] = size_covariance()
    covariance[4, 4] = OVERHANG_SHARE**2
    return np.stack([template.reduced(one) for one in found], axis=1), covariance


@lru_cache(maxsize=KNOWN)
def kin_directions(template: Template) -> Array:
    """Return the ways from a template to the other bundled ones, outer dimensions equal, (q, k).

    However many there are, they vary together as much as two ways that are whole (`WAYS`). A node
    that the other has not goes with the nearest one that both have. Templates that have too few
    nodes in common (`SHARED_NODES`) are no kin.
    """
    found = []
    for name in TEMPLATES:
        other = bundled(name)
        shared = [node for node in template.names if node in other.node]
        if other is template or len(shared) < SHARED_NODES * len(template.names):
            continue
        own = np.array([template.node[node] for node in shared])
        goal = _of_outer_dimensions(other, outer_dimensions(template, template.positions))
        start = _of_outer_dimensions(template, outer_dimensions(template, template.positions))
        way = goal[[other.node[node] for node in shared]] - start[own]
        away = ((template.positions[:, None] - template.positions[own]) ** 2).sum(axis=2)
        # A node and its image must choose alike, so the side counts.
        side = np.sign(template.positions[:, 1])
        away = np.where(side[:, None] == side[own], away, np.inf)
        whole = way[away.argmin(axis=1)]
        if np.abs(whole).max() > 0.0:
            found.append(template.reduced(whole))
    if not found:
        return np.zeros((len(template.variables), 0))
    return np.asarray(np.stack(found, axis=1) * np.sqrt(WAYS / len(found)), float)


def _of_outer_dimensions(template: Template, wanted: Array) -> Array:
    """Return the nodes of a template brought to outer dimensions, the middle of the axles at 0."""
    length, width, wheelbase, height = wanted
    was = outer_dimensions(template, template.positions)
    places = template.positions.copy()
    body = np.delete(places, template.wheels.ravel(), axis=0)
    front, rear = places[template.wheels[:, 0], 0]
    low, high = body[:, 0].min(), body[:, 0].max()
    share = (front - low) / (was[0] - was[2])
    overhangs, half = length - wheelbase, 0.5 * wheelbase
    knots = [-half - share * overhangs, -half, half, half + (1.0 - share) * overhangs]
    places[:, 0] = np.interp(places[:, 0], [low, front, rear, high], knots)
    return np.asarray(places * [1.0, width / was[1], height / was[3]])
