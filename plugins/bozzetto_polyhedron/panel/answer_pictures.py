"""Small pictures of the solids that a drawing could mean, from a side that tells them apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index
from bozzetto.errors import UserError
from bozzetto.geometry import Mesh
from bozzetto.scene import Item, Layer, Palette, Scene, Shaded, render
from bozzetto.view import Camera, fit_points, triple
from bozzetto_polyhedron.commands.answers import chosen_body, has_body
from bozzetto_polyhedron.commands.pieces import has_followed, step_of_followed
from bozzetto_polyhedron.mechanism.rotations import rotations_by
from bozzetto_polyhedron.model.same_view import camera_of
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.reconstruction.ranking import SURE
from bozzetto_polyhedron.rounds.straightened import straightened
from bozzetto_polyhedron.solid.face_rings import area_vectors
from bozzetto_polyhedron.solid.hand_over import mesh_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import face_triangles
from bozzetto_polyhedron.solve.choice import mirrored_number
from bozzetto_polyhedron.solve.pipeline import answered, solved
from bozzetto_polyhedron.solve.standing import foot_of
from bozzetto_polyhedron.view.drawing_layers import segments
from bozzetto_polyhedron.view.solid_layers import crisp_edges, faceted

MOST: Final = 6
"""Answers that are shown: the right one is hardly ever further behind."""

ASIDE: Final = np.radians(38.0)
"""Angle (radians) by which the pictures look from further round than the drawing: in the drawing's
own view all answers look alike."""

CERTAIN, LIKELY, DOUBTFUL = 0.95, 0.8, 0.1
"""Confidences from which on the words change."""

UPRIGHT: Final = 0.7
"""Cosine of the angle from the way up of the sheet within which a body stands on a face."""

EDGE_WIDTH: Final = 1.1
"""px."""


@dataclass(frozen=True, eq=False)
class AnswerPicture:
    """One answer as a person sees it.

    Parameters
    ----------
    number : int
        Of the answer, counted from 0.
    words : str
        How likely it is, or that it is the likeliest one turned inside out.
    share : float
        Confidence, 0 … 1.
    pixels : (h, w, 4) uint8
        RGBA, transparent around the solid.
    """

    number: int
    words: str
    share: float
    pixels: NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Gallery:
    """The answers of the chosen body.

    Parameters
    ----------
    body : str
        Its id; "" where there is none.
    sentence : str
        What to do, for a person.
    chosen : int
        The answer that is shown, counted from 0; -1 while the drawing is not turned yet.
    pictures : tuple of AnswerPicture
        The likeliest first.
    """

    body: str
    sentence: str
    chosen: int = -1
    pictures: tuple[AnswerPicture, ...] = ()


def words_of(confidence: float) -> str:
    """Return a confidence, 0 … 1, in words."""
    steps = (
        (CERTAIN, "Almost certain"),
        (LIKELY, "Likely"),
        (SURE, "Perhaps"),
        (DOUBTFUL, "Doubtful"),
    )
    return next((words for least, words in steps if confidence >= least), "Unlikely")


def gallery_of(
    state: PolyhedronState, palette: Palette, size: tuple[int, int], scale: float = 1.0
) -> Gallery:
    """Return the answers of the chosen body with their pictures.

    Parameters
    ----------
    state : PolyhedronState
        The bodies.
    palette : Palette
        The colours of the window.
    size : (width, height)
        Of a picture, px.
    scale : float
        Pixels of the picture per px.
    """
    try:
        body = chosen_body(state)
    except UserError as problem:
        of_others = has_followed(state) and not has_body(state)
        return Gallery("", step_of_followed(state).sentence if of_others else str(problem))
    found = solved(body, state)
    if not found.answers:
        waiting = "What the drawing could mean is shown here once its lines close."
        return Gallery(body.id, found.problem or waiting)
    camera = camera_of(body)
    chosen = found.number if body.choice is not None else -1
    turned, mirrored = (
        mirrored_number(found.answers, number, camera.axes[2]) for number in (0, found.number)
    )
    is_round = straightened(body.strokes, body.evidence).reading is not None
    shown = [k for k in range(len(found.answers)) if k < MOST or k in (chosen, mirrored)]
    pictures = []
    for number in shown:
        answer = found.answers[number]
        words = words_of(answer.confidence)
        if number == turned:
            words = "Inside out"
        made = answered(body, state, number) if is_round else None
        edges = (answer.vertices, found.graph.lines, _mesh(answer))
        up = camera.axes[1]
        if made is not None:
            edges = (made.body.vertices, crisp_edges(made), mesh_of(made.body))
            up = _upwards(made.body, up)
        pixels = picture_of(*edges, _from_aside(camera, up, size), palette, size, scale)
        pictures.append(AnswerPicture(number, words, answer.confidence, pixels))
    return Gallery(body.id, _sentence(found.answers, chosen), chosen, tuple(pictures))


def picture_of(
    vertices: Array,
    edges: Index,
    mesh: Mesh | None,
    camera: Camera,
    palette: Palette,
    size: tuple[int, int],
    scale: float = 1.0,
) -> NDArray[np.uint8]:
    """Draw a solid, (h, w, 4) RGBA.

    Parameters
    ----------
    vertices : (n, 3) float64
        mm.
    edges : (m, 2) intp
        That are drawn.
    mesh : Mesh, optional
        Its faces.
    camera : Camera
        From the side from which it is shown.
    palette, size, scale
        As for `gallery_of`.
    """
    items: list[Item] = [] if mesh is None else [Shaded(faceted(mesh))]
    items.append(segments(vertices[edges], "ink", EDGE_WIDTH, hidden="faint"))
    view = fit_points(camera, vertices)
    scene = Scene((Layer("answer", tuple(items)),))
    return render(scene, view, palette, size=size, scale=scale, background=False)


def _mesh(answer: Answer) -> Mesh | None:
    """Return triangles of an answer's faces; None where they have none."""
    made = []
    for face, area in zip(answer.faces, area_vectors(answer.vertices, answer.faces), strict=True):
        length = float(np.linalg.norm(area))
        if length == 0.0:
            continue
        try:
            made.append(face_triangles(answer.vertices, face, area / length))
        except UserError:
            continue
    if not made:
        return None
    return Mesh(answer.vertices.astype(np.float32), np.concatenate(made).astype(np.int32))


def _upwards(body: PlanarBody, up: Array) -> Array:
    """Return the way up of a body that stands on a face that looks down; otherwise that given."""
    foot = foot_of(body)
    if foot is None or float(body.normals[foot] @ up) > -UPRIGHT:
        return up
    return np.asarray(-body.normals[foot])


def _from_aside(camera: Camera, up: Array, size: tuple[int, int]) -> Camera:
    """Return the camera turned about its target to the right, about a way up (3,)."""
    turn = rotations_by(ASIDE * up[None])[0]
    eye = np.asarray(camera.target) - camera.distance * (turn @ camera.axes[2])
    return replace(camera, eye=triple(eye), up=triple(turn @ camera.axes[1]), viewport=size)


def _sentence(answers: Sequence[Answer], chosen: int) -> str:
    if len(answers) == 1:
        return "The drawing means this solid."
    sure = max(answer.confidence for answer in answers) >= SURE
    if chosen < 0:
        return "Touch a picture to turn the drawing into that solid."
    return "Touch another picture if you meant that." if sure else "Which of these did you mean?"
