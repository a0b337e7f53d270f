"""How often answers are right, on seeds that nothing was fitted to.

``python -m tests.plugins.polyhedron.figures_answers [drawings]`` prints Markdown tables; the number
is that of the drawings behind each figure, 100 unless given.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bozzetto.view import Camera
from bozzetto_polyhedron.reconstruction.answers import answers_of
from bozzetto_polyhedron.reconstruction.axis_systems import axis_systems
from tests.plugins.polyhedron.objects import (
    CAMERA,
    MAKERS,
    Polyhedron,
    graph_of,
    in_eye_frame,
    is_right,
    made,
    perspective_camera,
    view,
)

FIRST_SEED = 20_000
NOISES = (0.0, 0.005, 0.01, 0.02)
SLANTED = ("slanted prism", "slanted step", "tapered", "chamfered")
UPRIGHT = ("rectilinear prism", "stairs", "letter prism", "boxes", "notched box")


@dataclass(frozen=True)
class Outcome:
    """What came of one drawing."""

    first: bool
    third: bool
    faces: bool
    side: bool
    seconds: float
    lines: int


def outcome(
    solid: Polyhedron,
    seed: int,
    noise: float,
    marks: float | None = None,
    distance: float | None = None,
    known: bool = False,
) -> Outcome | None:
    """Draw a solid and judge the answers; None where it has no view in general position."""
    seen = view(solid, seed, distance)
    if seen is None:
        return None
    camera: Camera = perspective_camera(seen) if known else CAMERA
    graph, _ = graph_of(seen, noise, seed, marks)
    start = time.process_time()
    answers = answers_of(graph, camera)
    seconds = time.process_time() - start
    shapes = [in_eye_frame(each.vertices, camera) for each in answers]
    right = [is_right(seen, shape, noise) for shape in shapes]
    faces = {frozenset(frozenset(ring) for ring in face) for face in answers[0].faces}
    return Outcome(
        right[0],
        any(right[:3]),
        faces == solid.face_sets(),
        is_right(seen, shapes[0], noise, mirrored=False),
        seconds,
        len(solid.edges),
    )


def outcomes(
    count: int,
    kinds: tuple[str, ...],
    wanted: Callable[[Polyhedron], bool],
    judge: Callable[[Polyhedron, int], Outcome | None],
) -> list[Outcome]:
    """Judge as many drawings of solids of some kinds."""
    found: list[Outcome] = []
    seed = FIRST_SEED
    while len(found) < count:
        solid = made(seed, kinds)
        if wanted(solid) and (each := judge(solid, seed)) is not None:
            found.append(each)
        seed += 1
    return found


def share(values: list[bool]) -> float:
    return 100.0 * float(np.mean(values))


def row(
    name: str, measured: float, asked: float | None, unit: str = "%", least: bool = True
) -> str:
    if asked is None:
        return f"| {name} | {measured:.1f} {unit} | – | – |"
    kept = measured >= asked if least else measured <= asked
    sign = "≥" if least else "≤"
    verdict = "yes" if kept else "no"
    return f"| {name} | {measured:.1f} {unit} | {sign} {asked:g} {unit} | {verdict} |"


def head(title: str) -> None:
    print(f"\n**{title}**\n\n| figure | measured | asked | kept |\n| --- | --- | --- | --- |")


def shapes(count: int) -> list[Outcome]:
    """Print how often shapes are right, all lines drawn alike, and return what was judged."""
    head(f"Shapes, {count} drawings each, all lines drawn alike")
    every: list[Outcome] = []
    asked = {
        ("orthogonal", 0.01): (96.0, None),
        ("orthogonal", 0.02): (85.0, None),
        ("oblique", 0.01): (76.0, 88.0),
    }
    for name, kinds in (("orthogonal", UPRIGHT), ("oblique", SLANTED)):
        for noise in NOISES:
            found = outcomes(
                count,
                kinds,
                lambda solid, name=name: solid.orthogonal == (name == "orthogonal"),
                lambda solid, seed, noise=noise: outcome(solid, seed, noise),
            )
            every += found
            first, third = asked.get((name, noise), (None, None))
            label = f"{name}, {100 * noise:g} %"
            print(row(f"{label}: first right", share([each.first for each in found]), first))
            print(row(f"{label}: first three", share([each.third for each in found]), third))
            faces = 96.0 if noise == 0.01 else None
            print(row(f"{label}: faces exact", share([each.faces for each in found]), faces))
    return every


def loops(count: int) -> None:
    """Print how often pockets, bosses and holes are right."""
    head(f"Pockets, bosses and holes at 1 %, {count} drawings each")
    for label, marks, asked in (
        ("hidden lines light", 0.0, 92.0),
        ("hidden lines light, 10 % of them wrong", 0.1, 92.0),
        ("all lines alike", None, None),
    ):
        found = outcomes(
            count,
            ("looped",),
            lambda solid: solid.parts > 1,
            lambda solid, seed, marks=marks: outcome(solid, seed, 0.01, marks),
        )
        right = share([each.first and each.faces for each in found])
        print(row(f"{label}: shape and faces", right, asked))
        side = 100.0 if marks is not None else None
        print(row(f"{label}: near side of shapes", _side(found), side))
    found = outcomes(
        count,
        tuple(MAKERS),
        lambda solid: True,
        lambda solid, seed: outcome(solid, seed, 0.01, 0.1),
    )
    print(row("any solid, 10 % of the marks wrong: near side of right shapes", _side(found), 100.0))


def _side(found: list[Outcome]) -> float:
    """Return the share of right shapes that are on the right side."""
    return share([each.side for each in found if each.first])


def perspective(count: int) -> None:
    """Print how often drawings in perspective are right."""
    head(f"Perspective at 1 %, hidden lines light, {count} drawings each")
    for name, kinds in (("orthogonal", UPRIGHT), ("oblique", SLANTED)):

        def rate(distance: float | None, known: bool, name: str = name, kinds=kinds) -> float:
            found = outcomes(
                count,
                kinds,
                lambda solid: solid.orthogonal == (name == "orthogonal"),
                lambda solid, seed: outcome(solid, seed, 0.01, 0.1, distance, known),
            )
            return share([each.first for each in found])

        parallel = rate(None, False)
        print(row(f"{name}, parallel", parallel, None))
        for distance in (1.2, 2.0, 5.0):
            for known, label in ((True, "of the camera"), (False, "by feel")):
                measured = rate(distance, known)
                print(row(f"{name}, eye at {distance:g} sizes, {label}", measured, parallel))


def speed(every: list[Outcome], count: int) -> None:
    """Print how long answers take."""
    head("Time on this machine")
    some = [1e3 * each.seconds for each in every if 24 <= each.lines <= 36]
    print(row("answers, 24 to 36 lines, median", float(np.median(some)), 300.0, "ms", least=False))
    taken = []
    for seed in range(FIRST_SEED, FIRST_SEED + count):
        solid = made(seed, UPRIGHT)
        seen = view(solid, seed)
        if seen is not None and len(solid.edges) >= 24:
            graph, _ = graph_of(seen, 0.01, seed)
            start = time.process_time()
            axis_systems(graph)
            taken.append(1e3 * (time.process_time() - start))
    median = float(np.median(taken))
    print(row("axis systems, 24 lines and more, median", median, 50.0, "ms", least=False))


def main(count: int) -> None:
    plain = shapes(count)
    loops(count)
    speed(plain, count)
    perspective(count // 2)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100)
