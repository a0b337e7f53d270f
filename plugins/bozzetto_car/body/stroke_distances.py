"""How far the strokes of a sketch are from the edges of the finished body.

A stroke is followed when it is made; what comes after it (a neighbour that is traced, a smooth
joint, dimensions) may move its edge.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_car.body.body import Body
from bozzetto_car.body.edge_runs import find_run
from bozzetto_car.body.edit_list import Edits
from bozzetto_car.body.traced import Traced
from bozzetto_car.state import TracedEdges
from bozzetto_car.template.network import edge_called


@dataclass(frozen=True, eq=False)
class Miss:
    """A stroke along an edge, and how far the body is from it at most.

    Attributes
    ----------
    edge : str
        Name of the edge.
    px : float
    place : (2,) float
        Where that is, px of the sketch's camera.
    points : (k, 2) float
        The part of the stroke along this edge, px of the sketch's camera.
    """

    edge: str
    px: float
    place: Array
    points: Array


def misses_of(body: Body, edits: Edits, sketch: str) -> tuple[Miss, ...]:
    """Return the strokes of a sketch along the edges of a body; see `stroke_distances`."""
    through = body.sketch_cameras.get(sketch)
    left_out = {trouble.number for trouble in body.troubles}
    found: dict[str, Miss] = {}
    for number, edit in enumerate(edits):
        if not isinstance(edit, TracedEdges) or edit.sketch != sketch or number in left_out:
            continue
        if through is None:
            break
        try:
            meant = tuple(edge_called(body.template, name) for name in edit.edges)
            points = edit.strokes[0].points - through.shift
            run = find_run(body.network, points, through.camera, meant)
        except UserError:  # nothing of it is seen any more
            continue
        far = Traced(body.network, run, through.camera).farthest
        for edge, part, (px, place) in zip(run.edges, run.parts, far, strict=True):
            name = body.template.edge_names[max(edge, ~edge)]
            found[name] = Miss(name, px, place, part)
    return tuple(found.values())


def stroke_distances(body: Body, edits: Edits, sketch: str) -> Mapping[str, float]:
    """Return how far each edge that a sketch traces is from its stroke, px, by its name.

    Parameters
    ----------
    body : Body
        The body as it is handed over.
    edits : tuple of edits
        The edits that it was made with. Of several strokes along an edge the last one counts;
        those that were left out do not.
    sketch : str
        Id of the sketch.

    Returns
    -------
    mapping of str to float
        The largest distance on the sketch, on the stretch that the stroke runs beside.
    """
    return {miss.edge: miss.px for miss in misses_of(body, edits, sketch)}
