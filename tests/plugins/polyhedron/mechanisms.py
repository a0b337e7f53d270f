"""Known mechanisms: a chain of plates, a four-bar linkage, trusses. SI units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto_polyhedron.mechanism.analysis import balance_of, weights
from bozzetto_polyhedron.mechanism.assembly import (
    GROUND,
    Assembly,
    Ground,
    Motion,
    hinge,
    link,
    no_joints,
    spherical,
)
from bozzetto_polyhedron.mechanism.rotations import rotations_by

LENGTH, WIDTH, MASS = 0.1, 0.06, 0.05


def plates(count: int) -> tuple[Assembly, Motion]:
    """Plates in a row along x, hinged at the edges that they share, the first on the ground."""
    places = np.zeros((count, 3))
    places[:, 0] = (np.arange(count) + 0.5) * LENGTH
    motion = Motion.at_rest(places)
    square = np.array([WIDTH**2, LENGTH**2, LENGTH**2 + WIDTH**2]) / 12.0
    joints = no_joints()
    for k in range(count):
        begin = np.array([k * LENGTH, -WIDTH / 2, 0.0])
        end = np.array([k * LENGTH, WIDTH / 2, 0.0])
        joints += hinge(motion, k, k - 1 if k else GROUND, begin, end)
    return Assembly(
        np.full(count, MASS), np.tile(MASS * np.diag(square), (count, 1, 1)), joints
    ), motion


CRANK, COUPLER, ROCKER, BASE = 0.05, 0.12, 0.10, 0.13
POINT = np.array([0.07, 0.04])
"""Of the coupler: along it and square to it, m."""


def four_bar(turn: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return both ends of the coupler and its point in closed form, in the plane y = 0."""
    first = np.array([CRANK * np.cos(turn), 0.0, CRANK * np.sin(turn)])
    across = np.array([BASE, 0.0, 0.0]) - first
    length = float(np.linalg.norm(across))
    inner = np.arccos((COUPLER**2 + length**2 - ROCKER**2) / (2 * COUPLER * length))
    angle = np.arctan2(across[2], across[0]) + inner
    along = np.array([np.cos(angle), 0.0, np.sin(angle)])
    aside = np.array([-np.sin(angle), 0.0, np.cos(angle)])
    return first, first + COUPLER * along, first + POINT[0] * along + POINT[1] * aside


def linkage(turn: float) -> tuple[Assembly, Motion]:
    """Return the same as three rods: crank, coupler, rocker."""
    base = np.array([BASE, 0.0, 0.0])
    first, second, _ = four_bar(turn)
    ends = ((np.zeros(3), first), (first, second), (second, base))
    motion = Motion.at_rest(np.array([(a + b) / 2 for a, b in ends]))
    lengths = np.array([CRANK, COUPLER, ROCKER])
    inertias = np.eye(3) * (lengths**2 / 12)[:, None, None]
    joints = (
        spherical(motion, 0, GROUND, np.zeros(3))
        + spherical(motion, 0, 1, first)
        + spherical(motion, 1, 2, second)
        + spherical(motion, 2, GROUND, base)
    )
    planar = np.array([0.0, 1.0, 0.0])
    return Assembly(np.ones(3), inertias, joints, gravity=np.zeros(3), planar=planar), motion


def bars(
    places: np.ndarray, pairs: list[tuple[int, int]], fixed: set[int], mass: float = 0.0
) -> tuple[Assembly, Motion, list[int]]:
    """Return massless bars between point masses; fixed places are the ground's."""
    free = [k for k in range(len(places)) if k not in fixed]
    number = {k: i for i, k in enumerate(free)}
    motion = Motion.at_rest(places[free])
    joints = no_joints()
    for a, b in pairs:
        first, second = (a, b) if a in number else (b, a)
        joints += link(
            motion, number[first], number.get(second, GROUND), places[first], places[second]
        )
    count = len(free)
    gravity = np.array([0.0, 0.0, -9.81 if mass else 0.0])
    made = Assembly(np.full(count, mass or 1.0), np.zeros((count, 3, 3)), joints, gravity=gravity)
    return made, motion, free


def tensions(assembly: Assembly, motion: Motion, loads: np.ndarray) -> np.ndarray:
    """Return how much each massless bar is pulled by its weight and by forces (n, 3), N."""
    every = weights(assembly)
    every[:, :3] += loads
    return -balance_of(assembly, motion, every).rows


def box_on_ground(
    *, height: float, turn: tuple[float, float, float] = (0.0, 0.0, 0.0), friction: float = 0.5
) -> tuple[Assembly, Motion]:
    """Return a box of 100 × 60 × 40 mm and 0.2 kg whose middle is over the level ground."""
    size, mass = np.array([0.1, 0.06, 0.04]), 0.2
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    inertia = mass / 12.0 * np.diag((size**2).sum() - size**2)
    ground = Ground(np.zeros(8, np.intp), 0.5 * size * signs, 0.0)
    motion = Motion.at_rest(np.array([[0.0, 0.0, height]]))
    turned = replace(motion, turns=rotations_by(np.array([turn], float)))
    return Assembly(np.array([mass]), inertia[None], ground=ground, friction=friction), turned
