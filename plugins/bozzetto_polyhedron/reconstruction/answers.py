"""Ranked answers to what a drawing shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.view import Camera
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.graph.planar_embedding import components, neighbors_of
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.reconstruction.cautions import (
    BY_LOOKS,
    LOOSE,
    PERSPECTIVE,
    SIDE,
    cautions,
)
from bozzetto_polyhedron.reconstruction.drawing import Drawing, drawing_of
from bozzetto_polyhedron.reconstruction.orientation import open_lines, oriented
from bozzetto_polyhedron.reconstruction.parallel_classes import ParallelClasses, parallel_classes
from bozzetto_polyhedron.reconstruction.perspective import ParallelView, parallel_view
from bozzetto_polyhedron.reconstruction.placement import placed, residual
from bozzetto_polyhedron.reconstruction.ranking import (
    FEATURES,
    HANGING,
    Evidence,
    confidences,
    traits_of,
)
from bozzetto_polyhedron.reconstruction.readings import (
    Reading,
    lead_over_others,
    readings,
    seen_from_above,
)
from bozzetto_polyhedron.reconstruction.visibility import is_marked

Checkpoint = Callable[[float, str], None]
"""Called with the share done and the name of the step; raises where nobody waits any more."""


LEAST_LINES: Final = 3
"""Lines below which a drawing shows nothing in space."""

FROM_ABOVE: Final = 0.98
"""Share of unmarked drawings that show their solid from above: an assumption, not measured."""

CLOSE: Final = 3.0
"""Difference of scores up to which it is told that a slope is taken from looks: one in twenty."""

LATEST_MIRRORED: Final = 3
"""Place, from 0, at which the mirrored first answer stands at the latest."""


def ignore(fraction: float, step: str) -> None:
    """Do nothing: the checkpoint of those who have none."""


def answers_of(
    graph: LineGraph, camera: Camera, *, checkpoint: Checkpoint = ignore, most: int = 8
) -> tuple[Answer, ...]:
    """Read a drawing as a solid or sheet in space.

    Parameters
    ----------
    graph : LineGraph
        Corners and lines, hidden ones too.
    camera : Camera
        Through which it was drawn.
    checkpoint : callable
        Called between the steps.
    most : int
        Largest number of answers.

    Returns
    -------
    tuple of Answer
        At least one, the likeliest first. Where nothing can be said, a flat sheet with the
        confidence 0 and a warning.
    """
    drawing = drawing_of(graph)
    if len(drawing.lines) < LEAST_LINES:
        return (_flat(drawing, graph, camera),)
    view, found = ranked_readings(drawing, camera, checkpoint)
    checkpoint(0.9, "answers")
    if not found or most < 1:
        return (_flat(drawing, graph, camera),)
    marked = is_marked(drawing)
    traits = traits_of(found[0].features, drawing.lines, drawing.noise)
    values = np.array([each.score for each in found])
    apart = lead_over_others(view.drawing, found)
    shares = confidences(values, evidence_of(drawing), traits, apart)
    shares = graph.certainty * shares
    ranked: list[tuple[Reading, float]] = list(zip(found, shares.tolist(), strict=True))
    doubted = _by_looks(found)
    if doubted is not None and doubted >= most > 1:
        ranked[most - 1] = ranked[doubted]
    ranked = ranked[:most]
    if not marked and not view.certain:
        ranked = _both_sides(view.drawing, ranked)
    told: tuple[str, ...] = ()
    if view.perspective > 0.0 and camera.kind != "perspective":
        told += (PERSPECTIVE,)
    if not marked and not view.certain:
        told += (SIDE,)
    if doubted is not None and found[0].score - found[doubted].score < CLOSE:
        told += (BY_LOOKS,)
    classes = parallel_classes(view.drawing)
    return tuple(_answer(view, classes, graph, camera, *each, told) for each in ranked[:most])


def ranked_readings(
    drawing: Drawing, camera: Camera, checkpoint: Checkpoint = ignore
) -> tuple[ParallelView, list[Reading]]:
    """Return how a drawing is seen, and its readings, best first, on the near side if that is told.

    Parameters
    ----------
    drawing : Drawing
        Of at least `LEAST_LINES` lines.
    camera : Camera
        Through which it was drawn.
    checkpoint : callable
        Called between the steps.
    """
    view = parallel_view(drawing, camera)
    checkpoint(0.2, "readings")
    found = readings(view.drawing, checkpoint)
    judged = [replace(each, score=each.score - view.doubt(each.depths)) for each in found]
    judged.sort(key=lambda each: -each.score)
    return view, _near_sides(view, judged, is_marked(drawing))


def evidence_of(drawing: Drawing) -> Evidence:
    """Return what a drawing has beside its lines to tell readings apart."""
    if is_marked(drawing):
        return "marked"
    return "loose" if len(components(neighbors_of(drawing.lines))) > 1 else "plain"


def _by_looks(found: Sequence[Reading]) -> int | None:
    """Return the place of the best reading that takes slopes by looks where the first does not.

    Or the other way round; None where no depth of the first one hangs on looks.
    """
    if found[0].by_looks is None:
        return None
    others = (k for k, each in enumerate(found) if each.by_looks is (not found[0].by_looks))
    return next(others, None)


def _near_sides(view: ParallelView, found: list[Reading], marked: bool) -> list[Reading]:
    """Return readings whose near side is the one that perspective tells."""
    if marked:
        return [each for each in found if view.agrees(each.depths)] or found
    return [
        each if view.agrees(each.depths) else replace(each, depths=-each.depths) for each in found
    ]


def _both_sides(
    drawing: Drawing, ranked: list[tuple[Reading, float]]
) -> list[tuple[Reading, float]]:
    """Return readings as seen from above, the first one mirrored too, in falling order."""
    upper = [(seen_from_above(drawing, each), share) for each, share in ranked]
    first, share = upper[0]
    upper[0] = first, FROM_ABOVE * share
    below = replace(first, depths=-first.depths), (1.0 - FROM_ABOVE) * share
    place = sum(each[1] >= below[1] for each in upper)
    place = min(max(1, place), LATEST_MIRRORED)
    return [*upper[:place], below, *upper[place:]]


def _answer(
    view: ParallelView,
    classes: ParallelClasses,
    graph: LineGraph,
    camera: Camera,
    reading: Reading,
    confidence: float,
    told: tuple[str, ...],
) -> Answer:
    """Return a reading in the world."""
    vertices = placed(view.drawing, view.shape(reading.depths), camera)
    doubts = cautions(view.drawing, classes, reading.depths, reading.faces)
    if reading.features[FEATURES.index(HANGING)] > 0.0:
        doubts += (LOOSE,)
    return Answer(
        vertices,
        oriented(vertices, reading.faces),
        confidence,
        residual(vertices, np.asarray(graph.places, float), camera),
        open_lines(reading.faces, view.drawing.lines) == 0,
        doubts + told,
    )


def _flat(drawing: Drawing, graph: LineGraph, camera: Camera) -> Answer:
    """Return the drawing as it lies on the sheet."""
    shape = np.column_stack((drawing.points, np.zeros(len(drawing.points))))
    vertices = placed(drawing, shape, camera)
    places = np.asarray(graph.places, float).reshape(-1, 2)
    warning = "The lines do not make a solid. Draw all edges, hidden ones too, so that they meet."
    return Answer(vertices, (), 0.0, residual(vertices, places, camera), False, (warning,))
