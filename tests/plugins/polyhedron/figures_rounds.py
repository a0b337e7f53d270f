"""Line drawings with ellipses and arcs, from strokes to exact cylinders.

    python -m tests.plugins.polyhedron.figures_rounds [--count 20] [--first 5000]

Parts of `round_parts.py`, of random dimensions and seen from random sides, are drawn with 1 and
2 % of jitter; hidden straight edges are light and dashed, what is hidden of rims and sides is so in
every other drawing, and left out in the others (of pockets in none). What comes out is right if it
has as many planes and whole cylinders, hollow and not, and as many holes as the part, if all
cylinders are exact, its triangles bound one volume, and that volume and that of the part have at
least `ALIKE` of their union in common, where both are seen.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, replace

import numpy as np
from manifold3d import Manifold, Mesh

from bozzetto.errors import UserError
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import Solid
from bozzetto.ink import Strokes
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.cylinders import brep_with_cylinders, walls_of
from bozzetto_polyhedron.model.state import Body, Choice, PolyhedronState
from bozzetto_polyhedron.solid.triangulation import genus_of
from bozzetto_polyhedron.solve.pipeline import Solved, solved
from tests.plugins.polyhedron.hand import CLEAN, SIZE, Hand
from tests.plugins.polyhedron.objects import TO_CANVAS
from tests.plugins.polyhedron.round_parts import PARTS, RoundView, round_view, strokes_of

CAMERA = Camera(kind="orthographic")

ALIKE = {0.01: 0.75, 0.02: 0.65}
"""Least share of the union of both volumes that they have in common, by jitter."""


TOLD_BY_HIDDEN = ("round pocket",)
"""What hidden rims alone tell: a pocket of which no floor is seen is drawn like a hole."""


@dataclass
class Outcome:
    """How the drawing of one part went: which of the first answers are right, and why not."""

    right: list[bool]
    why: str
    healthy: bool
    seconds: float


def fault_of(found: Solved, seen: RoundView, alike: float) -> str:
    """Return what is wrong about a body; "" where it is right."""
    if found.changed is None or found.body is None or found.mesh is None:
        return f"no body: {found.problem}"
    made = found.changed
    if made.told:
        return f"told: {made.told[0]}"
    if not made.body.closed:
        return "open"
    walls, cut = walls_of(made.body, made.circles)
    if cut or len(walls) != len(seen.cylinders):
        return f"{len(walls)} cylinders and {cut} cut, of {len(seen.cylinders)}"
    brep = brep_with_cylinders(made.body, made.circles)
    planes = sum(face.surface.is_plane for face in brep.faces)
    if planes != seen.part.planes:
        return f"{planes} planes of {seen.part.planes}"
    if genus_of(made.body) != seen.part.genus:
        return f"genus {genus_of(made.body)}"
    try:
        check_solid(Solid(found.mesh))
    except UserError as problem:
        return str(problem)
    common = overlap(found, seen)
    return "" if common >= alike else f"{common:.2f} in common"


def overlap(found: Solved, seen: RoundView) -> float:
    """Return the share of the union of a body and a part that is in both, as they are seen."""
    camera = CAMERA
    assert found.mesh is not None
    points = camera.view_space(found.mesh.vertices.astype(float))
    flat = camera.project(found.mesh.vertices.astype(float))[0]
    flat = (flat - 600.0) / SIZE * TO_CANVAS
    depth = points[:, 2] * camera.pixels_per_mm / SIZE
    space = np.column_stack((flat, depth))
    faces = found.mesh.faces.astype(np.uint32)
    best = 0.0
    truth = np.asarray(seen.solid.to_mesh().vert_properties)[:, 2]
    shifts = (
        truth.mean() - depth.mean(), truth.min() - depth.min(), truth.max() - depth.max(),
        0.5 * (truth.min() + truth.max() - depth.min() - depth.max()),
    )  # fmt: skip
    for shift in shifts:
        moved = (space + np.array((0.0, 0.0, shift))).astype(np.float32)
        made = Manifold(Mesh(moved, faces))
        if made.volume() < 0:
            made = Manifold(Mesh(moved, faces[:, ::-1]))
        both = (made ^ seen.solid).volume()
        best = max(best, both / (made + seen.solid).volume())
    return best


def outcome_of(name: str, seed: int, hand: Hand, hidden_rims: bool) -> Outcome | None:
    seen = round_view(name, seed)
    if seen is None:
        return None
    camera = CAMERA
    strokes = [
        type(s)(s.x, s.y, camera, pressure=s.pressure, t=s.t)
        for s in strokes_of(seen, hand, seed, hidden_rims=hidden_rims)
    ]
    body = Body(id="b", name="b", strokes=Strokes(strokes), choice=Choice())
    state = PolyhedronState(nodes=(body,))
    alike = min(ALIKE.values()) if hand.jitter > 0.015 else max(ALIKE.values())
    began = time.process_time()
    found = solved(body, state)
    seconds = time.process_time() - began
    faults = [fault_of(found, seen, alike)]
    for answer in range(2, min(3, len(found.answers)) + 1):
        faults.append(fault_of(solved(replace(body, answer=answer), state), seen, alike))
    return Outcome([not f for f in faults], faults[0], not found.graph.health, seconds)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--first", type=int, default=5000)
    parser.add_argument("--jitter", type=float, nargs="*", default=[0.01, 0.02])
    parser.add_argument("--kinds", nargs="*", default=list(PARTS))
    parser.add_argument("--why", action="store_true")
    asked = parser.parse_args()
    print("| drawn | jitter | right, first answer | among three | time, median |")
    print("| --- | --- | --- | --- | --- |")
    for name in asked.kinds:
        for jitter in asked.jitter:
            hand = replace(CLEAN, jitter=jitter, retraced=0.15, split=0.10)
            found = [
                (seed, each)
                for seed in range(asked.first, asked.first + asked.count)
                if (each := outcome_of(name, seed, hand, seed % 2 == 0 or name in TOLD_BY_HIDDEN))
                is not None
            ]
            if not found:
                continue
            first = 100.0 * np.mean([each.right[0] for _, each in found])
            three = 100.0 * np.mean([any(each.right) for _, each in found])
            seconds = np.median([each.seconds for _, each in found])
            print(
                f"| {name} | {100 * jitter:.0f} % | {first:.0f} % of {len(found)} "
                f"| {three:.0f} % | {seconds:.2f} s |",
                flush=True,
            )
            if asked.why:
                for seed, each in found:
                    if not each.right[0]:
                        print("   ", seed, each.why, "" if each.healthy else "(told)")


if __name__ == "__main__":
    main()
