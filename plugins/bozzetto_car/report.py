"""The report of a car as plain values, mm and px, and cautions in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any, Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Caution, Figure, Job
from bozzetto.view.calibration import Parts, direct_linear_transform
from bozzetto_car.body.body import Body
from bozzetto_car.body.edit_list import Edits
from bozzetto_car.body.stroke_distances import stroke_distances
from bozzetto_car.body.wheels import RIM, WIDTH, Proportions, on_tyres
from bozzetto_car.camera.rational_projection import camera_matrix
from bozzetto_car.camera.sketch_camera import SketchCamera
from bozzetto_car.marking.next_mark import NO_CAR
from bozzetto_car.solver.contradictions import contradiction_of
from bozzetto_car.solver.initial_cameras import Placed, counted_marks
from bozzetto_car.solver.template_ranking import likelier_template
from bozzetto_car.solver.uncertainty import certainty, further_views
from bozzetto_car.template.crease_sides import turning_creases

TURNING: Final = (
    "The body bulges at one end and is hollow at the other along {}. CAD may not be able to offset "
    "it there: trace an edge beside these, or switch “Fair lines” on."
)

CONTRADICTS: Final = (
    "{} contradicts the other sketches: all marks together are missed by {:.0f} px, and without it "
    "by {:.0f} px. Look at its marks {}, or hide it."
)

FIGURES: Final[Mapping[str, Figure]] = {
    "residual": Figure(
        "Off the marks",
        "Distance of the marks from where their points are seen",
        "px",
        digits=1,
        spread=True,
    ),
    "leave_one_out": Figure(
        "Without its say",
        "Distance of each mark from where all the others have it",
        "px",
        digits=1,
        spread=True,
    ),
    "stroke": Figure(
        "Strokes", "Distance of each traced edge from its stroke", "px", digits=1, spread=True
    ),
    "crease": Figure(
        "Creases", "Angles at which surfaces meet along their edges", "°", digits=1, spread=True
    ),
    "camera": Figure(""),
    "LN": Figure("Length", "From nose to tail", "mm", digits=0),
    "WD": Figure("Width", "Without mirrors", "mm", digits=0),
    "HG": Figure("Height", "From the ground to the roof", "mm", digits=0),
    "FO": Figure("Front overhang", "Nose to front wheel", "mm", digits=0),
    "diameter": Figure("Wheel", "Diameter of the tyre", "mm", digits=0),
    "rim": Figure("Rim", "Diameter of the rim", "mm", digits=0),
    "width": Figure("Tyre", "Width of the tyre", "mm", digits=0),
    "WB": Figure("Wheelbase", "Front wheel to rear wheel", "mm", digits=0),
}
"""The words of the report; `Modeler.figures`."""


def report_of(body: Body, edits: Edits, job: Job, tyre: str = "") -> dict[str, Any]:
    """Report nodes, cameras, residuals, constraints, creases and dimensions.

    Parameters
    ----------
    body : Body
        The body.
    edits : tuple of edits
        Those that it was made with; their strokes are compared with it.
    job : Job
        Looked at before each sketch.
    tyre : str
        Size of its tyres, "" for wheels as drawn.

    Returns
    -------
    dict
        ``"template"``; ``"nodes"``: ``{name: [x, y, z]}``, mm; ``"views"``: for every sketch
        ``"name"``, ``"solved"``, ``"camera"`` (`_camera`), ``"residual_px"`` and
        ``"leave_one_out_px"`` by node, ``"disagreeing"``, and ``"stroke_px"`` by edge;
        ``"constraints"``: the least slack of each soundness constraint that is switched on, mm;
        ``"crease_deg"`` by edge; ``"dimensions"``: ``LN``, ``WD``, ``HG``, ``FO``, ``WB``, mm;
        ``"wheels"``: ``"front"`` and ``"rear"``, each with ``"diameter"``, ``"width"`` and
        ``"rim"``, mm;
        ``"contradiction"``, only where a sketch contradicts the others: ``"view"``, its name,
        ``"together_px"``, ``"without_px"`` and ``"nodes"`` (`contradiction_of`);
        ``"known"``: by node ``"seen"``, ``"mirrored"`` or ``"guessed"``; ``"next_view"``: the
        further sketch that would tell most; ``"warnings"``.
    """
    template, solved = body.template, body.solved
    positions = body.network.positions
    variables = template.reduced(positions)
    angles = zip(template.edge_names, body.creases, strict=True)
    report: dict[str, Any] = {
        "template": template.id,
        "nodes": dict(zip(template.names, positions.tolist(), strict=True)),
        "views": [
            _view(placed, body.sketch_cameras[key], body, job)
            | {"stroke_px": dict(stroke_distances(body, edits, key))}
            for key, placed in solved.placed.items()
        ],
        "constraints": solved.soundness.least(variables),
        "crease_deg": {name: float(angle) for name, angle in angles if np.isfinite(angle)},
        "dimensions": _dimensions(body),
        "wheels": _wheels(body, tyre),
        "unit": "mm",
    }
    if solved.joint is not None:
        job.checkpoint(1.0, template.id)
        known = certainty(template, solved.cost, solved.joint)
        report["known"] = dict(zip(template.names, known.sources, strict=True))
        views = further_views(template, solved.cost, solved.joint)
        if views:
            report["next_view"] = {"view": views[0].name, "now_mm": views[0].before,
                                 "after_mm": views[0].after}  # fmt: skip
    contradiction = contradiction_of(solved)
    if contradiction is not None:
        report["contradiction"] = {
            "view": solved.placed[contradiction.sketch].sketch.name,
            "together_px": contradiction.together,
            "without_px": contradiction.without,
            "nodes": list(contradiction.nodes),
        }
    report["warnings"] = [caution.message for caution in cautions_of(body)]
    return report


def _wheels(body: Body, tyre: str) -> dict[str, dict[str, float]]:
    """Return the sizes of the wheels, mm: as they are written on their tyres, or as drawn."""
    network, sizes = on_tyres(body.network, tyre), Proportions.of(tyre)
    radii = network.positions[network.template.wheels[:, 0], 2].tolist()
    return {
        where: {
            "diameter": 2.0 * radius,
            "width": WIDTH * sizes.width * radius,
            "rim": 2.0 * RIM * sizes.rim * radius,
        }
        for where, radius in zip(("front", "rear"), radii, strict=True)
    }


UNSOUND: Final = 1e-9
"""Negative slack of a constraint, mm, that counts as a violation and not as rounding."""

BENT: Final = (
    "The drawing seems bent by the hand. Raise “Follow the marks” to trace it all the same."
)

NO_CAMERA: Final = "No sketch has a camera yet, so the car is the bare template."

SHORT = {
    "length": "LN",
    "width": "WD",
    "height": "HG",
    "front_overhang": "FO",
    "wheelbase": "WB",
}
"""The names of the dimensions in files."""


def _dimensions(body: Body) -> dict[str, float]:
    return {SHORT[name]: value for name, value in asdict(body.dimensions).items()}


def _view(placed: Placed, sketch_camera: SketchCamera, body: Body, job: Job) -> dict[str, Any]:
    job.checkpoint(0.5, placed.sketch.name)
    nodes, marks = counted_marks(placed, body.template)
    report: dict[str, Any] = {
        "name": placed.sketch.name,
        "solved": placed.is_known,
        "marks": len(placed.sketch.marks),
    }
    if not placed.is_known:
        return report | {"camera": None, "residual_px": {}, "leave_one_out_px": {},
                       "problem": placed.problem}  # fmt: skip
    every = [(m.node, (m.u, m.v)) for m in placed.sketch.marks if m.node in body.template.node]
    at = sketch_camera.pixels(
        body.network.positions[[body.template.node[name] for name, _ in every]]
    )
    off = np.linalg.norm(at - [place for _, place in every], axis=1)
    report |= {
        "camera": _camera(sketch_camera),
        "residual_px": {name: float(px) for (name, _), px in zip(every, off, strict=True)},
        "leave_one_out_px": dict(placed.left_out or {}),
        "disagreeing": list(placed.disagreeing),
    }
    try:
        direct = direct_linear_transform(body.template.positions[nodes], marks)
    except UserError:
        return report
    return report | {
        "direct_linear_transform": direct.matrix.tolist(),
        "direct_linear_transform_parts": _parts(direct.parts),
    }


def _parts(parts: Parts) -> dict[str, Any]:
    """Return the parts that the slides take from the direct linear transform, for comparison."""
    return {
        "focal_px": list(parts.focal),
        "skew_deg": float(np.degrees(parts.skew)),
        "principal_point_px": list(parts.principal),
        "rotation": parts.turn.tolist(),
        "translation_mm": parts.shift.tolist(),
        "eye": parts.eye.tolist(),
    }


def _camera(sketch_camera: SketchCamera) -> dict[str, Any]:
    """Return a camera as in ink files, and the 3 × 4 matrix from mm to pixels of the picture."""
    camera = sketch_camera.camera
    report: dict[str, Any] = {
        "kind": camera.kind,
        "eye": list(camera.eye),
        "target": list(camera.target),
        "up": list(camera.up),
        "canvas": list(camera.viewport),
        "shift": list(sketch_camera.shift),
        "matrix": _matrix(sketch_camera),
    }
    if camera.kind == "perspective":
        return report | {"fov_y": camera.fov_y}
    return report | {"height": camera.height}


def _matrix(sketch_camera: SketchCamera) -> list[list[float]]:
    """Return M (3, 4) with (u w, v w, w) = M (x, y, z, 1) in pixels of the picture."""
    matrix = camera_matrix(sketch_camera.camera).copy()
    matrix[:2] += np.outer(sketch_camera.shift, matrix[2])
    rows: list[list[float]] = matrix.tolist()
    return rows


def cautions_of(body: Body) -> tuple[Caution, ...]:
    """Return what was set aside, left out or violated, and whether any sketch shapes the car."""
    cautions = [*_input_not_used(body), *_edits_left_out(body)]
    if body.dimensions_problem:
        cautions.append(Caution(f"The dimensions were not set: {body.dimensions_problem}"))
    variables = body.template.reduced(body.network.positions)
    for name, slack in body.solved.soundness.least(variables).items():
        if slack < -UNSOUND:
            cautions.append(Caution(f"The car violates “{name}” by {-slack:.1f} mm."))
    names = [body.template.edge_names[edge] for edge in turning_creases(body.network)]
    if names:
        cautions.append(Caution(TURNING.format(", ".join(names))))
    return tuple(cautions)


def _edits_left_out(body: Body) -> Iterator[Caution]:
    """Yield one sentence for all edits that were left out for the same reason."""
    numbers: dict[str, list[str]] = {}
    for trouble in body.troubles:
        numbers.setdefault(trouble.message, []).append(str(trouble.number + 1))
    for message, row in numbers.items():
        if len(row) == 1:
            yield Caution(f"Edit {row[0]} was left out: {message}")
        else:
            yield Caution(f"Edits {', '.join(row[:-1])} and {row[-1]} were left out: {message}")


def _input_not_used(body: Body) -> Iterator[Caution]:
    solved = body.solved
    likelier = likelier_template(solved)
    if likelier is not None:
        own = body.template
        other = f"not like {own.article} {own.noun}"
        words = f"This looks like {likelier.article} {likelier.noun}, {other}."
        yield Caution(f"{words} Choose that template.")
    if solved.mesh is not None:
        marked = len(solved.mesh.points)
        yield Caution(f"The car has the shape of a mesh, by {marked} marked points.")
    elif not solved.placed:
        yield Caution("There is no sketch. The car is the template as it stands.")
    elif not solved.solid:
        problems = (f"{p.sketch.name}: {p.problem}" for p in solved.placed.values() if p.problem)
        why = next(problems, "Mark more nodes of a sketch.")
        yield Caution(f"{NO_CAMERA} {why}", baseless=True)
    odd = contradiction_of(solved)
    if odd is not None:
        name, nodes = solved.placed[odd.sketch].sketch.name, ", ".join(odd.nodes)
        yield Caution(CONTRADICTS.format(name, odd.together, odd.without, nodes))
    for placed in solved.placed.values():
        name = placed.sketch.name
        if placed.problem and solved.solid:
            yield Caution(f"{name}: {placed.problem}")
        if placed.exchanged:
            words = "left and right seem to be exchanged. Exchange them and look again."
            yield Caution(f"{name}: {words}")
        for node in placed.disagreeing:
            off = (placed.left_out or {}).get(node, 0.0)
            words = f"the mark {node} disagrees by {off:.0f} px and was set aside."
            yield Caution(f"{name}: {words}")
        if placed.misfit is not None:
            yield Caution(f"{name}: {NO_CAR.format(placed.misfit)}")
        if placed.is_known and solved.cost.bend > 0.0:
            far = f"{placed.mean_miss or 0.0:.0f} px"
            words = f"no car has the marks as they are; they are missed by {far}."
            yield Caution(f"{name}: {words} {BENT}")
        unknown = [m.node for m in placed.sketch.marks if m.node not in body.template.node]
        if unknown:
            yield Caution(f"{name}: the template has no node {', '.join(unknown)}.")
