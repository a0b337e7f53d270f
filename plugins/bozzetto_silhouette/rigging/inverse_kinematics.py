"""Joints that are dragged: which ones move, and where they go.

A free end draws its whole limb along. The places are found by going back and forth along the
limb, keeping the lengths of its bones (FABRIK: Aristidou and Lasenby, 2011).
"""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Faces

ROUNDS = 30
"""Passes over a limb, back and forth."""

BEND = 1e-3
"""Sideways share of a straight limb's length that lets it fold."""

STRAIGHT = 1e-12
"""Sine of an angle that is none."""


def limb_of(parents: Faces, number: int) -> list[int]:
    """Return the joints that move with a dragged one, from the fixed one to the dragged one."""
    children = np.bincount(parents[parents >= 0], minlength=len(parents))
    row = [int(parents[number]), number]
    while children[number] == 0 and parents[row[0]] >= 0:
        above = int(parents[row[0]])
        if children[above] > 1 or parents[above] < 0:
            break
        row.insert(0, above)
    return row


def reached(row: Array, target: Array, sideways: Array) -> Array:
    """Place a row of joints whose first stays and whose last is at the target, or towards it."""
    lengths = np.linalg.norm(np.diff(row, axis=0), axis=1)
    first = row[0].copy()
    towards = target - first
    reach = float(lengths.sum())
    away = float(np.linalg.norm(towards))
    if len(row) == 2 or away >= reach:
        along = towards / away if away > 0.0 else np.zeros(3)
        return np.asarray(first + np.concatenate([[0.0], np.cumsum(lengths)])[:, None] * along)
    # A straight limb pushed along itself would not know where to fold.
    places = row + BEND * reach * np.sin(np.linspace(0.0, np.pi, len(row)))[:, None] * sideways
    for _ in range(ROUNDS):
        places[-1] = target
        for k in range(len(lengths) - 1, -1, -1):
            places[k] = _at_length(places[k + 1], places[k], lengths[k])
        places[0] = first
        for k, length in enumerate(lengths):
            places[k + 1] = _at_length(places[k], places[k + 1], length)
    return places


def _at_length(start: Array, towards: Array, length: float) -> Array:
    """Return the place at a distance from one place towards another."""
    away = towards - start
    size = float(np.linalg.norm(away))
    return np.asarray(start + away * (length / size)) if size > 0.0 else start


def least_turn(old: Array, new: Array, spare: Array) -> Array:
    """Return the rotation by the least angle from one direction to another, (3, 3).

    Half a turn is about `spare`; directions without length turn nothing.
    """
    sizes = np.linalg.norm(old) * np.linalg.norm(new)
    if not sizes > 0.0:
        return np.eye(3)
    axis = np.cross(old, new) / sizes
    sine, cosine = float(np.linalg.norm(axis)), float(old @ new / sizes)
    if sine < STRAIGHT:
        return np.eye(3) if cosine > 0.0 else _matrix(np.pi * spare)
    return _matrix(axis / sine * np.arctan2(sine, cosine))


def _matrix(vector: Array) -> Array:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(vector).as_matrix())
