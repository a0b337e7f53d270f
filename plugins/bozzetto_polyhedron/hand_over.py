"""Shapes for other programs: exact planes and cylinders, where their motion has taken them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Brep, Curve, Placement, Shapes, Solid, cylinder, plane_face, sewn
from bozzetto_polyhedron.drawing_on.cylinders import brep_with_cylinders
from bozzetto_polyhedron.flat_pages import page_curves
from bozzetto_polyhedron.mechanism.assembly import Motion
from bozzetto_polyhedron.mechanism.pieces import METRE
from bozzetto_polyhedron.model.fittings import Trace
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solid.hand_over import brep_of
from bozzetto_polyhedron.solid.pieces import pieces_of
from bozzetto_polyhedron.solve.followed import Sources
from bozzetto_polyhedron.solve.moving import NOTHING, Moving, moving
from bozzetto_polyhedron.solve.paths import path_of
from bozzetto_polyhedron.solve.pipeline import Solved, joined_bodies
from bozzetto_polyhedron.solve.placing import followed_part, placement_of, taken_by


def shapes_of(
    state: PolyhedronState, results: Mapping[str, Solved], sources: Sources = NOTHING
) -> Shapes:
    """Return every body that is shown and has faces, in the frame of the model; or their pages.

    One that moves as bars is a rod for each, one that moves as plates a face for each, and one that
    folds at hinges its parts between them, as soon as they have moved; names stay the same then,
    and a rod, a face or a part keeps its shape.
    """
    if state.files != "solids":
        return Shapes(curves=page_curves(state, results))
    solids: list[Solid] = []
    breps: list[Brep] = []
    flat = any(body.moves == "flat" for body in state.shown(Body))
    followed = bool(state.shown(Followed))
    moves = flat or followed or state.moved is not None
    machine = moving(state, sources) if moves else None
    joined = joined_bodies(results)
    for body in state.shown(Body):
        found = results.get(body.id)
        if found is None or body.id in joined:
            continue
        placement = Placement()
        if machine is not None and body.id in machine.numbers:
            motion, number = machine.motion(state.moved), machine.numbers[body.id]
            stays = machine.machine.shapes[number].moves
            if stays == "flat" or (state.moved is not None and stays != "whole"):
                breps += _pieces(body, machine, motion)
                continue
            placement = taken_by(machine, number, motion)
        if found.changed is None:
            continue
        made = found.changed
        if body.wall > 0.0 and found.mesh is not None:
            solids.append(Solid(found.mesh.placed(placement), body.name, body.color))
        else:
            exact = [
                brep_with_cylinders(piece, made.circles, body.name, body.color)
                for piece in pieces_of(made.body)
            ]
            breps += [brep.placed(placement) for brep in exact]
        if made.sheet is not None:
            sheet = brep_of(made.sheet, f"{body.name}, added faces", body.color)
            breps.append(sheet.placed(placement))
    drawn = Shapes(solids=tuple(solids), breps=tuple(breps), curves=traced_curves(state, sources))
    return drawn if machine is None else drawn + _followed(state, machine)


def traced_curves(state: PolyhedronState, sources: Sources = NOTHING) -> tuple[Curve, ...]:
    """Return the path of every corner that is traced, as a polyline, in the frame of the model."""
    if state.recorded is None or not state.shown(Trace):
        return ()
    made = moving(state, sources)
    paths = ((trace.name, path_of(trace, state, made)) for trace in state.shown(Trace))
    return tuple(_polyline(path, name) for name, path in paths if len(path) > 1)


def _pieces(body: Body, made: Moving, motion: Motion) -> list[Brep]:
    """Return the bars, the faces or the parts of a body, each with its number in its name."""
    number = made.numbers[body.id]
    shape, plates = made.machine.shapes[number], made.machine.plates[number]
    if shape.moves == "plates" and len(plates):
        faces = [
            plane_face(
                [shape.vertices[list(ring)] for ring in rings],
                name=f"{body.name} face {k + 1}",
                color=body.color,
            )
            for k, rings in enumerate(shape.faces)
        ]
        if shape.folds is not None:
            pieces = np.unique(plates)
            own = ([faces[k] for k in np.flatnonzero(plates == piece)] for piece in pieces)
            faces = [
                sewn(each, f"{body.name} part {k + 1}", body.color) for k, each in enumerate(own)
            ]
            plates = pieces
        return [
            face.placed(placement_of(made, int(piece), motion))
            for face, piece in zip(faces, plates, strict=True)
        ]
    vertices = made.machine.moved(number, motion)
    radius = shape.wall / METRE / np.sqrt(np.pi)
    return [
        cylinder(
            vertices[first],
            vertices[second],
            radius,
            name=f"{body.name} bar {k + 1}",
            color=body.color,
        )
        for k, (first, second) in enumerate(shape.edges)
    ]


def _followed(state: PolyhedronState, made: Moving) -> Shapes:
    """Return the bodies of other objects where their motion has taken them."""
    solids, surfaces = [], []
    for part in state.shown(Followed):
        if part.id not in made.meshes:
            continue
        moved = followed_part(part, made, made.motion(state.moved))
        if isinstance(moved, Solid):
            solids.append(moved)
        else:
            surfaces.append(moved)
    return Shapes(solids=tuple(solids), surfaces=tuple(surfaces))


def _polyline(points: Array, name: str) -> Curve:
    knots = np.concatenate(([0.0], np.linspace(0.0, 1.0, len(points)), [1.0]))
    return Curve(1, knots, points, name=name)
