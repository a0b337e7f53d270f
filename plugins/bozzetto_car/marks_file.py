"""Marks or a template from a file: what `bozzetto build car` reads (`docs/car.md`).

A file is not trusted: every number and name is checked, and every refusal names the key.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

from bozzetto.errors import UserError
from bozzetto.ink import PIXELS, Stroke, Strokes, a_list, a_number, a_point, an_object, point_rows
from bozzetto.plugin import Job, TemplateFile
from bozzetto.scene import Picture
from bozzetto_car.body.build import body_of
from bozzetto_car.camera.sketch_camera import upright_camera
from bozzetto_car.listening import listening
from bozzetto_car.report import SHORT
from bozzetto_car.state import CarState, Mark, Sketch, StylingCurve, TracedEdges
from bozzetto_car.styling.curve import project_stroke
from bozzetto_car.template.kept_templates import plugin_template
from bozzetto_car.template.loader import TEMPLATES, read_template

MOST_SKETCHES: Final = 8
"""Most views of one file."""

MOST_NAMES: Final = 400
"""Most marks or strokes of one view."""

LARGEST: Final = PIXELS[1]
"""Largest number of a picture's pixels along a side, and of a dimension in mm."""

KINDS: Final = ("auto", "perspective", "orthographic")

VIEW_KEYS: Final = {"kind", "marks", "strokes", "image", "name", "cropped"}


def is_car_file(facts: Mapping[str, Any]) -> bool:
    """Whether the facts of a file are marks of a car."""
    return "views" in facts


def is_template_file(facts: Mapping[str, Any]) -> bool:
    """Whether the facts of a file are a template."""
    return "soundness" in facts


def car_of_template(facts: Mapping[str, Any]) -> CarState:
    """Return a car without sketches that begins with the template of a file.

    Raises
    ------
    FormatError
        If the template cannot be used; the message says why.
    """
    source = json.dumps(facts)
    read_template(source.encode())
    return CarState(own=source, template="own")


def car_from_facts(
    facts: Mapping[str, Any],
    pictures: Mapping[str, Picture],
    job: Job | None = None,
    brought: Sequence[TemplateFile] = (),
) -> CarState:
    """Return the car of a file.

    Parameters
    ----------
    facts : mapping
        ``"template"``: one of `TEMPLATES`, such as ``"sedan"``, the name of one that a plugin
        brings, or a template of one's own (an object);
        ``"views"``: a list of objects with ``"marks"``: ``{node: [u, v]}``, ``"kind"``,
        ``"cropped"``, ``"strokes"``: ``{edge: [[u, v], …]}``, ``"image"``,
        ``"name"``; ``"image"``: ``{"width", "height", "file"}`` for views that have none;
        ``"dimensions"``: ``{"LN", "WD", "HG", "FO", "WB"}``, mm; ``"styling"``: a list of
        ``{"view", "points", "name"}``.
    pictures : mapping of str to Picture
        Pictures by the names of their files.
    job : Job, optional
        Asked before each styling curve and while the car is solved, which is for the first one.
    brought : sequence of TemplateFile
        Templates of plugins.

    Raises
    ------
    UserError
        If something is missing, or of the wrong kind or size; the message names the key.
    """
    views = a_list(facts.get("views"), "views", MOST_SKETCHES)
    if not views:
        raise UserError("“views” is empty. Give at least one view with its marks.")
    state = _of_template(facts.get("template", "sedan"), brought)
    edits: list[TracedEdges] = []
    for number, value in enumerate(views):
        where = f"views[{number}]"
        view = an_object(value, where)
        unknown = sorted(set(view) - VIEW_KEYS)
        if unknown:
            raise UserError(f"{where} has a key “{unknown[0]}”. Known are {_row(VIEW_KEYS)}.")
        sketch = _sketch(view, facts.get("image"), where, number, pictures)
        state = state.with_node(replace(sketch, id=state.unused_id()))
        edits += _strokes(view.get("strokes", {}), state.sketches[-1], f"{where}.strokes")
    state = replace(state, edits=tuple(edits), selected=state.sketches[0].id)
    state = _dimensioned(state, facts.get("dimensions", {}))
    job = job or Job()
    curves = a_list(facts.get("styling", []), "styling", MOST_NAMES)
    for number, value in enumerate(curves):
        with listening(job, number / len(curves), "Styling curves"):
            state = _styled(state, an_object(value, f"styling[{number}]"), f"styling[{number}]")
    return state


def _of_template(value: object, brought: Sequence[TemplateFile]) -> CarState:
    if isinstance(value, Mapping):
        return CarState(own=json.dumps(value), template="own")
    known = next((name for name in TEMPLATES if name == value), None)
    if known is not None:
        return CarState(template=known)
    file = next((file for file in brought if file.name == value), None)
    if file is not None:
        return CarState(own=plugin_template(file).source, template="own")
    names = ", ".join((*TEMPLATES, *(file.name for file in brought)))
    raise UserError(f"“template” is one of {names}, or a template itself.")


def _sketch(
    view: Mapping[str, Any],
    common: object,
    where: str,
    number: int,
    pictures: Mapping[str, Picture],
) -> Sketch:
    given = view.get("image", common)
    image = an_object(given, f"{where}.image" if "image" in view else "image")
    width, height = (
        a_number(image.get(key), f"image.{key}", 1.0, LARGEST) for key in ("width", "height")
    )
    kind = view.get("kind", "auto")
    if kind not in KINDS:
        raise UserError(f"{where}.kind is one of {', '.join(KINDS)}.")
    cropped = view.get("cropped", False)
    if not isinstance(cropped, bool):
        raise UserError(f"{where}.cropped is true or false.")
    name = view.get("name", f"Sketch {number + 1}")
    if not isinstance(name, str) or not 1 <= len(name) <= 200:
        raise UserError(f"{where}.name is a text of 1 to 200 characters.")
    marks = _marks(view.get("marks"), f"{where}.marks")
    picture = pictures.get(str(image.get("file", "")))
    sketch = Sketch(
        name=name, picture=picture, width=width, height=height, marks=marks, kind=kind,
        cropped=cropped,
    )  # fmt: skip
    rights = sum(mark.node.endswith(".R") for mark in marks)
    lefts = sum(mark.node.endswith(".L") for mark in marks)
    return replace(sketch, shows="R" if rights > lefts else "L")


def _marks(value: object, where: str) -> tuple[Mark, ...]:
    marks = an_object(value, where)
    if len(marks) > MOST_NAMES:
        raise UserError(f"{where} has more than {MOST_NAMES} marks.")
    made = []
    for node, place in marks.items():
        if not isinstance(node, str) or not 1 <= len(node) <= 40:
            raise UserError(f"{where} has a mark without the name of a node, such as C1.")
        u, v = a_point(place, f"{where}.{node}", PIXELS).tolist()
        made.append(Mark(node, u, v))
    return tuple(made)


def _strokes(value: object, sketch: Sketch, where: str) -> list[TracedEdges]:
    """Return strokes along edges, as if they had been drawn on the sketch."""
    strokes = an_object(value, where)
    if len(strokes) > MOST_NAMES:
        raise UserError(f"{where} has more than {MOST_NAMES} strokes.")
    camera = upright_camera(sketch.size).camera
    made = []
    for edge, places in strokes.items():
        points = point_rows(places, f"{where}.{edge}", PIXELS)
        stroke = Stroke(points[:, 0], points[:, 1], camera, tool="imported")
        # The drawn line tells the end of the edge better than a mark beside it.
        made.append(
            TracedEdges(
                strokes=Strokes((stroke,)), sketch=sketch.id, edges=(str(edge),), nodes_follow=True
            )
        )
    return made


def _dimensioned(state: CarState, given: object) -> CarState:
    long = {short: name for name, short in SHORT.items()}
    values: dict[str, float] = {}
    for key, value in an_object(given, "dimensions").items():
        if key not in long:
            raise UserError(f"There is no dimension “{str(key)[:40]}”. Give {_row(long)}.")
        values[long[key]] = a_number(value, f"dimensions.{key}", 1.0, LARGEST)
    # A car solved with its dimensions fits its sketches better than one stretched afterwards.
    return replace(
        state,
        lock=bool(values),
        length=values.get("length", 0.0),
        width=values.get("width", 0.0),
        height=values.get("height", 0.0),
        front_overhang=values.get("front_overhang", 0.0),
        wheelbase=values.get("wheelbase", 0.0),
    )


def _styled(state: CarState, value: Mapping[str, Any], where: str) -> CarState:
    """Return the state with a styling curve drawn on one of the sketches."""
    view = value.get("view", 0)
    sketches = state.sketches
    if isinstance(view, bool) or not isinstance(view, int) or not 0 <= view < len(sketches):
        raise UserError(f"{where}.view is the number of a view, from 0 to {len(sketches) - 1}.")
    name = value.get("name", state.unused_name("Styling curve"))
    if not isinstance(name, str) or not 1 <= len(name) <= 200:
        raise UserError(f"{where}.name is a text of 1 to 200 characters.")
    points = point_rows(value.get("points"), f"{where}.points", PIXELS)
    body = body_of(state)
    sketch_camera = body.sketch_cameras[sketches[view].id]
    patches, on, places = project_stroke(body, points - sketch_camera.shift, sketch_camera.camera)
    curve = StylingCurve(id=state.unused_id(), name=name, patches=patches, on=on, places=places)
    return replace(state, nodes=(*state.nodes, curve))


# -- plain values ----------------------------------------------------------------------------------


def _row(words: Iterable[str]) -> str:
    return ", ".join(sorted(words))
