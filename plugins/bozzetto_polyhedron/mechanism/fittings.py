"""Fittings that join pieces of a machine besides their corners: links, springs, axes, motors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.mechanism.assembly import (
    GROUND,
    Joints,
    Motion,
    Springs,
    directed,
    hinge,
    link,
    motor,
    no_joints,
    pusher,
    slider,
    square_to,
)
from bozzetto_polyhedron.mechanism.drives import Drive
from bozzetto_polyhedron.mechanism.pieces import METRE, Machine

FittingKind = Literal["link", "spring", "hinge", "slider", "crank", "pin"]


@dataclass(frozen=True, eq=False)
class Fastening:
    """One fitting between two shapes, as a machine needs it.

    Parameters
    ----------
    kind : {"link", "spring", "hinge", "slider", "crank", "pin"}
    first, second : int
        Numbers of shapes, or the ground.
    begin, end : (3,) float64
        At rest, mm: the ends of a link or a spring, the first on the first shape; or two places
        on an axis; or both ends of a bar that is turned.
    length : float
        Of a link or a spring, mm.
    stiffness : float
        Of a spring, N/m.
    drive : Drive, optional
        Of what has a motor; rad, or m along the line of a slider.
    turns : bool
        Whether what slides may turn.
    """

    kind: FittingKind
    first: int
    second: int
    begin: Array
    end: Array
    length: float = 0.0
    stiffness: float = 0.0
    drive: Drive | None = None
    turns: bool = True


def fastened(machine: Machine, fastenings: Sequence[Fastening]) -> Machine:
    """Return a machine with fittings; those between a piece and itself do nothing.

    A hinge of a shape with itself drives two plates at the edge that they are hinged at.
    """
    joints, springs = machine.assembly.joints, [machine.assembly.springs]
    turned = [
        machine.bar_between(each.first, each.begin, each.end)
        for each in fastenings
        if each.kind == "crank"
    ]
    driven = frozenset(piece for piece in turned if piece is not None)
    for each in fastenings:
        if each.kind == "spring":
            springs.append(_spring(machine, each))
        else:
            joints += _joints(machine, each, driven)
    every = Springs(
        *(np.concatenate(columns) for columns in zip(*map(_columns, springs), strict=True))
    )
    return replace(machine, assembly=replace(machine.assembly, joints=joints, springs=every))


def frame_of(
    machine: Machine, number: int, begin: Array, end: Array, driven: frozenset[int]
) -> int | None:
    """Return what the bar between two places of a flat shape, mm, is turned against.

    That is the ground where the first corner is held, else the longest other bar there that no
    motor turns; None where there is none.
    """
    shape, bar = machine.shapes[number], machine.bar_between(number, begin, end)
    corner = int(np.argmin(np.linalg.norm(shape.vertices - begin, axis=1)))
    if corner in shape.anchors:
        return GROUND
    others = [
        (float(np.linalg.norm(shape.vertices[edge[0]] - shape.vertices[edge[1]])), int(piece))
        for edge, piece in zip(shape.edges, machine.bars[number], strict=True)
        if corner in edge and piece != bar and piece not in driven
    ]
    return max(others)[1] if others else None


def _joints(machine: Machine, each: Fastening, driven: frozenset[int]) -> Joints:
    rest = machine.rest
    begin, end = each.begin * METRE, each.end * METRE
    if each.kind == "crank":
        return _crank(machine, each, driven)
    if each.kind == "pin":
        return _pin(machine, each)
    if each.kind == "hinge" and each.first == each.second:
        folded = machine.fold_between(each.first, each.begin, each.end)
        return no_joints() if folded is None else _driven(rest, *folded, end - begin, each.drive)
    first = machine.piece_at(each.first, each.begin)
    at_second = each.end if each.kind == "link" else each.begin
    second = machine.piece_at(each.second, at_second)
    if each.kind == "link":
        if first == GROUND:
            first, second, begin, end = second, first, end, begin
        if first == second:
            return no_joints()
        made = link(rest, first, second, begin, end)
        return replace(made, target=np.array([each.length * METRE]))
    if first == GROUND:
        first, second = second, first
    if first == second or np.linalg.norm(end - begin) == 0.0:
        return no_joints()
    if each.kind == "slider":
        made = slider(rest, first, second, begin, end, turns=each.turns)
        if each.drive is None:
            return made
        return made + pusher(rest, first, second, begin, end, each.drive)
    made = hinge(rest, first, second, begin, end)
    return made + _driven(rest, first, second, end - begin, each.drive)


def _crank(machine: Machine, each: Fastening, driven: frozenset[int]) -> Joints:
    """Return the motor of the bar of a flat shape that lies between two places."""
    piece = machine.bar_between(each.first, each.begin, each.end)
    normal = machine.shapes[each.first].normal
    if piece is None or normal is None:
        return no_joints()
    frame = frame_of(machine, each.first, each.begin, each.end, driven)
    if frame is None:
        return no_joints()
    return _driven(machine.rest, piece, frame, normal, each.drive)


def _pin(machine: Machine, each: Fastening) -> Joints:
    """Return what keeps all bars of a flat shape together that cross at a place."""
    shape, made = machine.shapes[each.first], no_joints()
    if shape.normal is None:
        return made
    aside = np.stack(square_to(shape.normal))
    bars = machine.bars_at(each.first, each.begin)
    for bar in bars[1:]:
        places = np.tile(each.begin * METRE, (2, 1))
        made += directed(machine.rest, bar, bars[0], places, aside)
    return made


def _driven(rest: Motion, first: int, second: int, axis: Array, drive: Drive | None) -> Joints:
    if drive is None:
        return no_joints()
    return motor(rest, first, second, axis, drive)


def _spring(machine: Machine, each: Fastening) -> Springs:
    first = machine.piece_at(each.first, each.begin)
    second = machine.piece_at(each.second, each.end)
    begin, end = each.begin * METRE, each.end * METRE
    if first == GROUND:
        first, second, begin, end = second, first, end, begin
    if first == GROUND:
        return machine.assembly.springs.none()
    places = machine.rest.places
    return Springs(
        np.array([first]),
        np.array([second]),
        (begin - places[first])[None],
        (end if second == GROUND else end - places[second])[None],
        np.array([each.length * METRE]),
        np.array([each.stiffness]),
    )


def _columns(springs: Springs) -> tuple[Array, ...]:
    return tuple(getattr(springs, name) for name in springs.__dataclass_fields__)
