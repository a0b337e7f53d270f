"""The report on drawings: corners, vertices, faces, ranked answers and health, as plain values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import Caution, Figure, Job
from bozzetto_polyhedron.drawing_on.changed import Changed
from bozzetto_polyhedron.drawing_on.circles import SIDES
from bozzetto_polyhedron.drawing_on.cylinders import walls_of
from bozzetto_polyhedron.mechanism.analysis import mobility_of
from bozzetto_polyhedron.mechanism.pieces import METRE
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.ranking import SURE
from bozzetto_polyhedron.rounds.on_bodies import LEFT_OUT
from bozzetto_polyhedron.rounds.straightened import straightened
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solid.triangulation import genus_of
from bozzetto_polyhedron.solve.bars import OF_BARS
from bozzetto_polyhedron.solve.followed import Sources, followed_bodies
from bozzetto_polyhedron.solve.forces import forces_of
from bozzetto_polyhedron.solve.moving import NOTHING, is_mechanism, moving
from bozzetto_polyhedron.solve.pipeline import Solved
from bozzetto_polyhedron.solve.recording import MOST_POSES

FIGURES: Final[Mapping[str, Figure]] = {
    "closed": Figure("Closed", "Whether the faces bound a volume", good=True, bad=False),
    "genus": Figure("Tunnels", "Holes that go through the solid (its genus)"),
    "confidence": Figure(
        "Confidence",
        "Probability that this is the solid that was meant",
        "%",
        factor=100.0,
        digits=0,
        good=0.8,
        bad=SURE,
    ),
    "residual": Figure(
        "Off the drawing", "Distance of the vertices from the corners drawn (RMS)", "px", digits=2
    ),
    "noise": Figure("Hand", "Estimated standard deviation of a corner drawn", "px", digits=2),
    "pieces": Figure("Pieces", "Rigid pieces, and corners that bars meet in"),
    "freedoms": Figure("Freedoms", "Independent ways in which it can move (its mobility)"),
    "redundant": Figure("Held twice", "Constraints of joints that others say already"),
    "joint_gap": Figure("Joint gap", "Largest opening of a joint", "mm", digits=6),
    "answer": Figure("Answer", "Which of the ranked answers is shown"),
}
"""The words of the report; `Modeler.figures`."""

OF_SOLIDS: Final = ("closed", "genus", "answers", "answer", "confidence", "residual_px")
"""What the report does not say of bars that lie flat: nobody meant them as a solid."""


def report_of(
    state: PolyhedronState, results: Mapping[str, Solved], sources: Sources, job: Job
) -> dict[str, Any]:
    """Return the report.

    Returns
    -------
    dict
        Of the first body: ``"places"`` ([u, v], px, for each corner), ``"vertices"`` ([x, y, z],
        mm, in the frame of the model), ``"edges"`` ([i, j], numbers of vertices), ``"faces"`` (for
        each the outer ring, then its holes), ``"closed"``, ``"genus"``, ``"answers"`` (the
        likeliest first: ``"confidence"`` and ``"vertices"``), ``"answer"`` (which of them is
        shown, counted from 1; 0 for none), ``"confidence"``, ``"residual_px"``, ``"noise_px"``,
        ``"health"`` (``"place"``, ``"what"`` and ``"sentence"``), ``"told"``;
        ``"round"`` (``"ellipses"`` and ``"arcs"`` that were read so, ``"cylinders"`` of the solid,
        those drawn on it later among them, and ``"left_out"``); of bars that lie flat
        without `OF_SOLIDS` and findings `OF_BARS`. The same of all bodies in ``"bodies"``, each
        with its ``"id"`` and ``"name"``. Where something moves, ``"mechanism"``: ``"pieces"``,
        ``"freedoms"``, ``"redundant"`` and ``"joint_gap_mm"``.
    """
    bodies = [body for body in state.of_kind(Body) if body.id in results]
    entries = []
    for number, body in enumerate(bodies):
        job.checkpoint(number / len(bodies), body.name)
        entries.append(_entry(body, results[body.id]))
    first = dict(entries[0]) if entries else {}
    first.pop("id", None)
    first.pop("name", None)
    if is_mechanism(state):
        job.checkpoint(1.0, "")
        first["mechanism"] = _mechanism(state, sources)
    return {**first, "bodies": entries, "unit": "mm"}


def cautions_of(
    state: PolyhedronState, results: Mapping[str, Solved], sources: Sources = NOTHING
) -> tuple[Caution, ...]:
    """Return cautions about drawings that make no solid, look wrong, or could mean another one."""
    cautions = []
    for body in state.shown(Body):
        found = results.get(body.id)
        if found is not None and body.moves != "flat":
            cautions += [Caution(f"“{body.name}”: {text}") for text in _doubts(body, found)]
    there = followed_bodies(state, sources)
    gone = [part.name for part in state.shown(Followed) if part.id not in there]
    cautions += [
        Caution(f"“{name}” is no part of what it follows any more. Delete it here, or undo.")
        for name in gone
    ]
    if state.recorded is not None and len(state.recorded.seconds) >= MOST_POSES:
        cautions.append(
            Caution("The recording is full. Choose “Forget the recording” to begin a new one.")
        )
    return (*cautions, *_cautions_of_forces(state, sources))


def _cautions_of_forces(state: PolyhedronState, sources: Sources) -> list[Caution]:
    """Return what forces that are shown do not mean."""
    if not state.forces or not is_mechanism(state):
        return []
    found = forces_of(state, moving(state, sources))
    if found is None:
        return [Caution("There are too many bars to show forces. Hide some of the bodies.")]
    if not found.newtons.any():
        return [Caution("Nothing is loaded. Switch on gravity, or stretch a spring.")]
    if not found.balanced:
        return [Caution("It would not stay in this pose: hold more corners to make it a truss.")]
    return []


def _entry(body: Body, found: Solved) -> dict[str, Any]:
    graph, answer, made = found.graph, found.answer, found.body
    place = body.placement.points
    vertices: Array = np.zeros((0, 3))
    faces: tuple[Rings, ...] = ()
    edges = graph.lines
    if made is not None:
        vertices, faces = made.vertices, made.faces
        edges = graph.lines if made.faces == found.base_faces else edges_of(made.faces)
    elif answer is not None:
        vertices, faces = place(answer.vertices), answer.faces
    entry = {
        "id": body.id,
        "name": body.name,
        "places": graph.places.tolist(),
        "vertices": vertices.tolist(),
        "edges": edges.tolist(),
        "faces": [[list(ring) for ring in rings] for rings in faces],
        "closed": made is not None and made.closed,
        "genus": 0 if made is None else genus_of(made) or 0,
        "answers": [
            {"confidence": float(each.confidence), "vertices": place(each.vertices).tolist()}
            for each in found.answers
        ],
        "answer": found.number + 1,
        "confidence": 0.0 if answer is None else float(answer.confidence),
        "residual_px": 0.0 if answer is None else float(answer.residual),
        "noise_px": float(graph.noise),
        "health": [
            {"place": list(each.place), "what": each.what, "sentence": each.sentence}
            for each in graph.health
            if body.moves != "flat" or each.what not in OF_BARS
        ],
        "told": list(_told(found)),
        "round": _round(body, found),
    }
    if body.moves == "flat":
        entry = {name: value for name, value in entry.items() if name not in OF_SOLIDS}
    return entry


def _round(body: Body, found: Solved) -> dict[str, int]:
    """Return how many ellipses and arcs were read as round, and how many cylinders that makes."""
    reading = straightened(body.strokes, body.evidence).reading
    circles = 0 if found.changed is None else len(found.changed.circles)
    told = () if found.changed is None else found.changed.told
    return {
        "ellipses": 0 if reading is None else len(reading.rims),
        "arcs": 0 if reading is None else len(reading.bends),
        "cylinders": circles,
        "left_out": sum(each.startswith(LEFT_OUT) for each in told),
    }


def _mechanism(state: PolyhedronState, sources: Sources) -> dict[str, Any]:
    """Return what is free and what is held twice where everything is now, and the largest gap."""
    made = moving(state, sources)
    motion = made.motion(state.moved)
    found = mobility_of(made.machine.assembly, motion)
    return {
        "pieces": len(made.machine.rest.places),
        "freedoms": found.degrees,
        "redundant": found.redundant,
        "joint_gap_mm": made.stepper.largest_gap(motion) / METRE,
    }


def _told(found: Solved) -> tuple[str, ...]:
    warnings = () if found.answer is None else found.answer.warnings
    told = () if found.changed is None else (*found.changed.body.told, *found.changed.told)
    return (*warnings, *told, *((found.problem,) if found.problem else ()))


def _doubts(body: Body, found: Solved) -> list[str]:
    """Return what a person must know of one body, in sentences."""
    if found.body is None or found.answer is None:
        return [found.problem or "The drawing makes no solid. Draw the edges that are missing."]
    doubts = list(found.answer.warnings)
    if found.changed is not None:
        doubts += found.changed.told
        doubts += _of_what_is_left(found.changed)
    if found.graph.health:
        more = len(found.graph.health) - 1
        doubts.append(found.graph.health[0].sentence + (f" And {more} more." if more else ""))
    if not found.body.closed and body.wall == 0.0:
        meant = found.base is not None and found.base.closed
        first = "Close its faces" if meant else "Draw the edges that are missing"
        doubts.append(f"The faces are open: it is a sheet. {first}, or give it a thickness.")
    if found.answer.confidence < SURE and len(found.answers) > 1:
        doubts.append(
            f"The drawing could mean something else: {len(found.answers)} answers, this one with "
            f"{100 * found.answer.confidence:.0f} %. Choose the next answer (X) to compare."
        )
    return doubts


def _of_what_is_left(made: Changed) -> list[str]:
    """Return what is not as exact, or not as finished, as it may look."""
    doubts = []
    if len(made.lines):
        count = len(made.lines)
        lines = "1 added line bounds" if count == 1 else f"{count} added lines bound"
        doubts.append(f"{lines} no solid yet: draw on until they close, or erase them.")
    _, cut = walls_of(made.body, made.circles)
    if cut:
        holes = "1 cylinder is" if cut == 1 else f"{cut} cylinders are"
        doubts.append(
            f"{holes} cut by something else and handed over with {SIDES} flat sides a turn."
        )
    return doubts
