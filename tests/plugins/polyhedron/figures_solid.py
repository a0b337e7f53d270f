"""Exact planes and what is drawn on them, measured.

    python -m tests.plugins.polyhedron.figures_solid [--count 120] [--first 60000]

Solids that nothing was tuned on are drawn with noise, answered, and made exact. An answer counts
where it has the faces of the solid; whether its shape is right is not this room's to say.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field

import numpy as np

from bozzetto.errors import UserError
from bozzetto_polyhedron.drawing_on.push import pushed
from bozzetto_polyhedron.model.state import Dimension
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.solid.exact import exact_body
from bozzetto_polyhedron.solid.face_rings import area_vector, edges_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import face_triangles, volume_of
from bozzetto_polyhedron.solid.unfolding import nets
from bozzetto_polyhedron.solid.visibility import visible_pieces
from tests.plugins.polyhedron.objects import CAMERA, SPAN, graph_of, made, view
from tests.plugins.polyhedron.true_bodies import face_areas, polygon_area

NOISES = (0.005, 0.01, 0.02)


@dataclass
class Tally:
    """What was measured of all drawings of one kind with one noise."""

    asked: int = 0
    refused: int = 0
    off: list[float] = field(default_factory=list)
    shortest: list[float] = field(default_factory=list)
    framed: list[bool] = field(default_factory=list)
    moved: list[float] = field(default_factory=list)
    typed: list[float] = field(default_factory=list)
    typed_refused: int = 0
    seconds: list[float] = field(default_factory=list)


def off_planes(body: PlanarBody) -> float:
    """Largest distance of a corner from a plane of its faces, mm."""
    return max(
        float(np.abs(body.vertices[[v for ring in face for v in ring]] @ normal - offset).max())
        for face, normal, offset in zip(body.faces, body.normals, body.offsets, strict=True)
    )


def answer_of(seed: int, noise: float) -> tuple[Answer, float, bool] | None:
    """Return an answer with the right faces, the noise in mm, and whether it is orthogonal."""
    solid = made(seed)
    seen = view(solid, seed)
    if seen is None:
        return None
    graph, _ = graph_of(seen, noise, seed, marks=0.0)
    for answer in answers_of(graph, CAMERA):
        rings = {frozenset(frozenset(ring) for ring in face) for face in answer.faces}
        if rings == solid.face_sets():
            return answer, graph.noise / CAMERA.pixels_per_mm, solid.orthogonal
    return None


def measure(answer: Answer, noise: float, tally: Tally) -> PlanarBody | None:
    """Make an answer exact, type a length, and note how that went."""
    tally.asked += 1
    began = time.perf_counter()
    try:
        body = exact_body(answer, noise=noise, camera=CAMERA)
    except UserError:
        tally.refused += 1
        return None
    tally.seconds.append(time.perf_counter() - began)
    tally.off.append(off_planes(body))
    edges = edges_of(body.faces)
    before, after = (np.diff(v[edges], axis=1)[:, 0] for v in (answer.vertices, body.vertices))
    lengths = np.linalg.norm(after, axis=1) / np.linalg.norm(before, axis=1)
    tally.shortest.append(float(lengths.min()))
    tally.framed.append(any(said == "All angles were made right." for said in body.told))
    pixels = [CAMERA.project(v)[0] for v in (answer.vertices, body.vertices)]
    tally.moved.append(float(np.linalg.norm(pixels[1] - pixels[0], axis=1).max()) / SPAN)
    _type_length(answer, noise, body, tally)
    return body


def _type_length(answer: Answer, noise: float, body: PlanarBody, tally: Tally) -> None:
    """Set the distance of two parallel faces to the next whole millimetre."""
    cosines = body.normals @ body.normals.T
    pairs = np.argwhere(np.triu(cosines < -1 + 1e-12, 1))
    if not len(pairs):
        return
    one, two = (int(k) for k in pairs[0])
    length = float(np.ceil(abs(body.offsets[one] + body.offsets[two])))
    try:
        typed = exact_body(
            answer, noise=noise, camera=CAMERA, dimensions=[Dimension((one, two), length)]
        )
    except UserError:
        tally.typed_refused += 1
        return
    corner = typed.vertices[typed.faces[one][0][0]]
    found = abs(float(typed.normals[two] @ corner - typed.offsets[two]))
    tally.typed.append(abs(found / length - 1.0))
    tally.off.append(off_planes(typed))


@dataclass
class Drawn:
    """What was measured of things drawn on bodies, and of bodies handed over."""

    pushes: int = 0
    right: int = 0
    off: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    hidden: list[tuple[int, float]] = field(default_factory=list)
    pieces: list[int] = field(default_factory=list)
    area: list[float] = field(default_factory=list)


def draw_on(body: PlanarBody, found: Drawn) -> None:
    """Push a loop in, out and through a face; unfold; look for hidden lines."""
    for face in (0, len(body.faces) // 2):
        triangles = face_triangles(body.vertices, body.faces[face], body.normals[face])
        sizes = [np.linalg.norm(area_vector(body.vertices[t])) for t in triangles]
        corners = body.vertices[triangles[int(np.argmax(sizes))]]
        loop = corners.mean(axis=0) + 0.5 * (corners - corners.mean(axis=0))
        area = float(np.linalg.norm(area_vector(loop)))
        for depth in (3.0, -1.0, -np.inf):
            found.pushes += 1
            began = time.perf_counter()
            try:
                after = pushed(body, face, loop, depth)
            except UserError:
                continue
            found.seconds.append(time.perf_counter() - began)
            found.off.append(off_planes(after))
            change = volume_of(after) - volume_of(body)
            most = area * depth * (1 + 1e-9) if np.isfinite(depth) else np.inf
            right = 0 < change <= most if depth > 0 else change < 0
            found.right += bool(right and found.off[-1] < 1e-9)
    times = []
    for _ in range(5):
        began = time.perf_counter()
        visible_pieces(body, CAMERA)
        times.append(time.perf_counter() - began)
    found.hidden.append((len(edges_of(body.faces)), min(times)))
    unfolded = nets(body, 4.0)
    found.pieces.append(len(unfolded))
    flat = sum(polygon_area(ring) for net in unfolded for face in net.rings for ring in face)
    found.area.append(abs(flat / face_areas(body).sum() - 1.0))


def row(what: str, found: str, asked: str, kept: bool | None) -> None:
    print(f"| {what} | {found} | {asked} | {'' if kept is None else 'yes' if kept else 'no'} |")


def show(name: str, noise: float, tally: Tally) -> None:
    label = f"{name}, {100 * noise:g} %"
    done = tally.asked - tally.refused
    row(f"{label}: made exact", f"{done} of {tally.asked}", "all", tally.refused == 0)
    if not done:
        return
    row(f"{label}: corners off planes, worst", f"{max(tally.off):.1e} mm", "< 1e-9 mm",
        max(tally.off) < 1e-9)  # fmt: skip
    row(f"{label}: shortest edge, after over before", f"{min(tally.shortest):.2f}", "> 0, no fused",
        min(tally.shortest) > 0)  # fmt: skip
    row(f"{label}: all faces on one frame", f"{sum(tally.framed)} of {done}", "", None)
    half, most = np.percentile(tally.moved, (50, 90))
    row(f"{label}: moved on the sheet, median / 90 %", f"{100 * half:.1f} / {100 * most:.1f} %",
        "", None)  # fmt: skip
    if tally.typed:
        row(f"{label}: typed length, worst of {len(tally.typed)}", f"{max(tally.typed):.1e}",
            "< 1e-12", max(tally.typed) < 1e-12)  # fmt: skip
        row(f"{label}: typed length refused", f"{tally.typed_refused}", "0",
            tally.typed_refused == 0)  # fmt: skip
    row(f"{label}: time, median", f"{1000 * np.median(tally.seconds):.0f} ms", "", None)


def show_drawn(found: Drawn) -> None:
    row("loops pushed in, out, through", f"{found.right} of {found.pushes} right", "all",
        found.right == found.pushes)  # fmt: skip
    row("corners off planes after that, worst", f"{max(found.off):.1e} mm", "< 1e-9 mm",
        max(found.off) < 1e-9)  # fmt: skip
    row("time of a push, median", f"{1000 * np.median(found.seconds):.0f} ms", "", None)
    near = [1000 * t * 36 / edges for edges, t in found.hidden if edges >= 24]
    row("hidden lines, scaled to 36 edges, median", f"{np.median(near):.2f} ms", "≤ 4 ms",
        float(np.median(near)) <= 4.0)  # fmt: skip
    one = sum(count == 1 for count in found.pieces)
    row("nets in one piece", f"{one} of {len(found.pieces)}", "", None)
    row("area of nets over that of faces, worst", f"{max(found.area):.1e}", "< 1e-12",
        max(found.area) < 1e-12)  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=120)
    parser.add_argument("--first", type=int, default=60_000)
    asked = parser.parse_args()
    tallies = {(kind, noise): Tally() for noise in NOISES for kind in (True, False)}
    drawn = Drawn()
    for seed in range(asked.first, asked.first + asked.count):
        for noise in NOISES:
            found = answer_of(seed, noise)
            if found is None:
                continue
            answer, deviation, orthogonal = found
            body = measure(answer, deviation, tallies[orthogonal, noise])
            if body is not None and noise == NOISES[1] and body.closed:
                draw_on(body, drawn)
    print("| what | measured | asked | kept |")
    print("| --- | --- | --- | --- |")
    for noise in NOISES:
        for name, kind in (("orthogonal", True), ("oblique", False)):
            show(name, noise, tallies[kind, noise])
    show_drawn(drawn)


if __name__ == "__main__":
    main()
