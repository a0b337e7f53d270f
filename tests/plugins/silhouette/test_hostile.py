"""Outlines that nobody has seen: a solid or words, never another exception, never inside out."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.ink.checked_points import FARTHEST
from bozzetto.plugin import Job
from bozzetto.view import Camera
from bozzetto_silhouette.model.state import Oversketch, Part, SilhouetteState, Smoothing
from bozzetto_silhouette.modeler import Silhouette

pytestmark = pytest.mark.slow

MODELER = Silhouette()

FRONT = Camera("orthographic", (0.0, -500.0, 0.0), (0.0, 0.0, 0.0), height=300.0)
SURFACES = ("convolution", "variational", "inflation", "straight")
OPERATIONS = ("add", "merge", "carve", "intersect")
FEW, MANY = 30, 200


def blob(random: np.random.Generator, count: int) -> np.ndarray:
    """A random smooth closed line around (600, 450), px."""
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    radius = np.full(count, 1.0)
    for wave in range(2, 9):
        radius += random.normal(0.0, 0.35 / wave) * np.cos(wave * angle + random.uniform(0, 6.3))
    radius = np.maximum(radius, random.uniform(0.05, 0.3)) * random.uniform(20.0, 350.0)
    stretch = random.uniform(0.15, 1.0)
    return [600.0, 450.0] + radius[:, None] * np.column_stack(
        [np.cos(angle), stretch * np.sin(angle)]
    )


def plain(random):
    return [blob(random, int(random.integers(40, 400)))]


def with_holes(random):
    outer = blob(random, 300)
    middle = outer.mean(axis=0)
    holes = [
        middle + random.uniform(0.05, 0.3) * (blob(random, 90) - middle)
        + random.normal(0.0, 40.0, 2) * (number > 0)
        for number in range(int(random.integers(1, 4)))
    ]  # fmt: skip
    return [outer, *holes]


def hooked(random):
    line = blob(random, 300)
    over = int(random.integers(3, 30))
    hook = line[0] + random.normal(0.0, 8.0, (4, 2)).cumsum(axis=0)
    return [np.vstack([hook[::-1], line, line[:over] + random.normal(0.0, 3.0, 2)])]


def gapped(random):
    line = blob(random, 300)
    return [line[: int(300 * random.uniform(0.6, 0.98))]]


def in_pieces(random):
    line = blob(random, 240)
    pieces = [p + random.normal(0.0, 3.0, 2) for p in np.array_split(line, random.integers(2, 6))]
    return [pieces[k][:: random.choice([-1, 1])] for k in random.permutation(len(pieces))]


def trembling(random):
    line = blob(random, 600)
    return [line + random.normal(0.0, random.uniform(0.2, 6.0), line.shape)]


def clockwise(random):
    return [line[::-1] for line in with_holes(random)]


def three_points(random):
    return [random.uniform(0.0, 900.0, (3, 2))]


def many_points(random):
    line = blob(random, 20_000)
    return [line + random.normal(0.0, 0.3, line.shape)]


def without_area(random):
    line = np.linspace(0.0, 1.0, 50)[:, None] * random.normal(0.0, 300.0, 2) + 500.0
    return [np.vstack([line, line[::-1] + random.choice([0.0, 1e-4, 0.05])])]


def far_away(random):
    return [line + random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(4, 7) for line in
            with_holes(random)]  # fmt: skip


def tiny_or_huge(random):
    return [600.0 + 10.0 ** random.uniform(-5, 9) * (line - 600.0) for line in plain(random)]


def scribble(random):
    return [random.normal(0.0, 30.0, (int(random.integers(3, 120)), 2)).cumsum(axis=0) + 500.0]


def needles(random):
    angle = np.linspace(0.0, 2.0 * np.pi, 2 * int(random.integers(5, 24)), endpoint=False)
    radius = np.where(np.arange(len(angle)) % 2, random.uniform(10.0, 90.0), 300.0)
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    return [[600.0, 450.0] + radius[:, None] * ray]


def repeated(random):
    return [np.repeat(blob(random, 80), random.integers(1, 9, 80), axis=0)]


KINDS = (
    plain, with_holes, hooked, gapped, in_pieces, trembling, clockwise, three_points, many_points,
    without_area, far_away, tiny_or_huge, scribble, needles, repeated,
)  # fmt: skip


def part_from(random, kind, number: int, **more) -> Part:
    lines = (np.clip(line, -FARTHEST, FARTHEST) for line in kind(random))
    strokes = [Stroke(*line.T, FRONT) for line in lines]
    return Part(id=f"n{number}", name=f"Part {number}", strokes=Strokes(strokes), **more)


def edits_on(random, part: Part) -> Part:
    """With a piece drawn over and a stretch rubbed, wherever they fall."""
    if random.random() < 0.6:
        return part
    points = part.strokes[0].points
    first = int(random.integers(0, max(1, len(points) - 2)))
    piece = points[first : first + max(2, len(points) // 6)] + random.normal(0.0, 8.0, 2)
    stroke = Stroke(*piece.T, FRONT)
    return replace(part, edits=(Oversketch(stroke, 0), Smoothing(stroke, 0)))


def answer(state: SilhouetteState) -> str:
    """Solves, shows, hands over and reports; "a solid", "nothing", or the refusal."""
    try:
        result = MODELER.solve(state, Job())
    except UserError as refusal:
        return refusal.message
    for _, item in MODELER.scene(state, result).items():
        if hasattr(item, "points"):
            assert np.isfinite(item.points).all()
    for figures in MODELER.report(state, result, Job())["parts"]:
        assert figures["volume"] > 0.0
        assert figures["status"] == "NoError"
    if result.body is None:
        return "nothing"
    assert np.isfinite(result.body.vertices).all()
    assert np.isfinite(result.mesh.normals).all()
    manifold = result.body.manifold
    assert manifold.status().name == "NoError"
    assert manifold.volume() > 0.0
    return "a solid"


def the_case(number: int) -> SilhouetteState:
    """Kinds, surfaces and operations in all pairs, by and by."""
    random = np.random.default_rng(1000 + number)
    pairs = list(itertools.product(SURFACES, OPERATIONS))
    surface, operation = pairs[number % len(pairs)]
    kind = KINDS[number % len(KINDS)]
    first = part_from(random, plain, 1, surface=SURFACES[(number // 4) % 4])
    # Blends take a second each: they are among the slow ones.
    blend = 0.0 if number < FEW else float(random.choice([0.0, 0.3, 1.0]))
    second = part_from(random, kind, 2, surface=surface, operation=operation, blend=blend)
    nodes = (edits_on(random, second),) if number % 3 == 0 else (first, edits_on(random, second))
    return SilhouetteState(nodes=nodes, selected="n2", resolution=32)


def check(number: int) -> None:
    said = answer(the_case(number))
    assert said in ("a solid", "nothing") or said.endswith("."), said


@pytest.mark.parametrize("number", range(FEW))
def test_hostile_outlines(number: int) -> None:
    check(number)


@pytest.mark.parametrize("number", range(FEW, MANY))
def test_many_hostile_outlines(number: int) -> None:
    check(number)


def test_most_of_what_a_person_would_call_an_outline_becomes_a_solid() -> None:
    """Refusing everything would be sound, too."""
    random = np.random.default_rng(5)
    kinds = [plain, hooked, gapped, clockwise, repeated] * 2
    said = [
        answer(SilhouetteState(nodes=(part_from(random, kind, 1),), resolution=32))
        for kind in kinds
    ]
    assert said.count("a solid") >= 8, said
