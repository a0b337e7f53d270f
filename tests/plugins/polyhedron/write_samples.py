"""Write the sample drawings of the plugin: ``python -m tests.plugins.polyhedron.write_samples``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from manifold3d import Manifold

from bozzetto.ink import Stroke
from bozzetto.view import Camera, triple
from tests.plugins.polyhedron.drawn_bodies import fitted
from tests.plugins.polyhedron.hand import SIZE, Hand, strokes_of
from tests.plugins.polyhedron.objects import (
    Face,
    Polyhedron,
    View,
    box,
    edges_of,
    hidden_shares,
    polyhedron_of,
    prism,
)

FOLDER = Path(__file__).parents[3] / "plugins" / "bozzetto_polyhedron" / "samples"

SHEET = Camera(
    kind="orthographic",
    eye=(300.0, -430.0, 330.0),
    target=(0.0, 0.0, 45.0),
    height=190.0,
    viewport=(1600.0, 1000.0),
)

GABLE = replace(SHEET, eye=(220.0, -480.0, 300.0))
"""Seen from here no corner of the house lies on a line of it."""

HAND = Hand(jitter=0.007, wobble=0.005, tremble=0.0006, in_order=True)
"""An unhurried hand that draws hidden edges in dashes."""


def from_side(azimuth: float, elevation: float) -> Camera:
    """Return the sheet seen from so many degrees to the right of the front and above."""
    round_, up = np.radians((azimuth - 90.0, elevation))
    toward = np.array((np.cos(up) * np.cos(round_), np.cos(up) * np.sin(round_), np.sin(up)))
    return replace(SHEET, eye=triple((SHEET.target + 600.0 * toward).round(3)))


def house() -> Polyhedron:
    """A house with a gable roof."""
    gable = ((0, 0), (2.0, 0), (2.0, 1.3), (1.0, 2.1), (0, 1.3))
    flat = prism(gable, 2.8, "house")
    return Polyhedron(flat.vertices[:, [2, 0, 1]], flat.edges, flat.faces, "house")


def bracket() -> Polyhedron:
    """An angle bracket with a square hole in its foot and one in its back."""
    made: Manifold = box((3.2, 2.0, 0.6)) + box((0.6, 2.0, 2.6))
    made -= box((0.9, 0.8, 2.0), (1.5, 0.6, -1)) + box((2.0, 0.8, 0.8), (-1, 0.6, 1.2))
    found = polyhedron_of(made, "bracket")
    if found is None:
        raise ValueError("the bracket is too thin")
    return found


def stairs() -> Polyhedron:
    """Three steps."""
    steps = ((0, 0), (3, 0), (3, 0.8), (2, 0.8), (2, 1.6), (1, 1.6), (1, 2.4), (0, 2.4))
    flat = prism(steps, 2.0, "stairs")
    return Polyhedron(flat.vertices[:, [0, 2, 1]], flat.edges, flat.faces, "stairs")


def chair() -> Polyhedron:
    """A chair with sides of one board and a back that leans."""
    legs = ((0, 0), (0.5, 0), (0.5, 1.6), (1.9, 1.6), (1.9, 0), (2.4, 0), (2.4, 2.1))
    side = (*legs, (0.5, 2.1), (0.35, 4.2), (0, 4.2))
    flat = prism(side, 2.2, "chair")
    return Polyhedron(flat.vertices[:, [0, 2, 1]], flat.edges, flat.faces, "chair")


def tower() -> Polyhedron:
    """A tower with a gabled roof, on a broad foot."""
    rings = [square(0.0, 3.0, 0.0), square(0.0, 3.0, 1.1), square(0.7, 2.3, 1.1)]
    ridge = [(0.7, 1.5, 5.0), (2.3, 1.5, 5.0)]
    corners = np.array([*rings[0], *rings[1], *rings[2], *square(0.7, 2.3, 3.9), *ridge])
    foot = [(k, (k + 1) % 4) for k in range(4)]
    faces: tuple[Face, ...] = (
        ((3, 2, 1, 0),),
        *(((a, b, b + 4, a + 4),) for a, b in foot),
        ((4, 5, 6, 7), (11, 10, 9, 8)),
        ((8, 9, 13, 12),),
        ((9, 10, 14, 17, 13),),
        ((10, 11, 15, 14),),
        ((11, 8, 12, 16, 15),),
        ((12, 13, 17, 16),),
        ((14, 15, 16, 17),),
    )
    pairs = {
        (min(a, b), max(a, b))
        for face in faces
        for each in face
        for a, b in zip(each, each[1:] + each[:1], strict=True)
    }
    return Polyhedron(corners, np.array(sorted(pairs)), faces, "tower")


def folding_screen() -> Polyhedron:
    """Four panels that stand in a zigzag, hinged at the edges that they share."""
    plan = [(float(k), 0.55 * (k % 2)) for k in range(5)]
    corners = np.array([(x, y, z) for z in (0.0, 1.9) for x, y in plan])
    faces: tuple[Face, ...] = tuple(((k, k + 1, k + 6, k + 5),) for k in range(4))
    return Polyhedron(corners, edges_of(faces), faces, "folding-screen")


def folding_box(
    size: Sequence[float] = (1.9, 1.4, 1.1),
    flap: float = 0.6,
    lean: float = 60.0,
    sides: Sequence[int] = (0, 1, 2, 3),
) -> Polyhedron:
    """An open box with flaps at its rim, so many degrees above level; from the front round."""
    wide, deep, high = size
    rings = [[(0.0, 0.0), (wide, 0.0), (wide, deep), (0.0, deep)]] * 2
    corners = [(x, y, z) for ring, z in zip(rings, (0.0, high), strict=True) for x, y in ring]
    faces: list[Face] = [
        ((3, 2, 1, 0),),
        *(((k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4),) for k in range(4)),
    ]
    aside, up = flap * np.cos(np.radians(lean)), flap * np.sin(np.radians(lean))
    for side in sides:
        one, other = 4 + side, 4 + (side + 1) % 4
        x, y = ((0, -1), (1, 0), (0, 1), (-1, 0))[side]
        faces.append(((one, other, len(corners), len(corners) + 1),))
        corners += [
            (corners[k][0] + x * aside, corners[k][1] + y * aside, high + up) for k in (other, one)
        ]
    return Polyhedron(np.array(corners), edges_of(faces), tuple(faces), "folding-box")


def folded(solid: Polyhedron, camera: Camera, strokes: list[Stroke]) -> list[dict[str, object]]:
    """Return the steps after which a box is held and motors open and shut its flaps."""
    places = camera.project(fitted(solid, 110.0, (0.0, 0.0, 45.0)))[0].round(1)
    drive = {"drive": "swing", "angle": -65.0, "period": 4.0}
    steps: list[dict[str, object]] = [
        {"tool": "draw", "strokes": list(range(len(strokes)))},
        {"tool": "turn", "tap": places[0].tolist()},
        {"set": {"moves": "plates"}},
        *({"tool": "move", "tap": places[corner].tolist()} for corner in (0, 1, 2)),
    ]
    for side in range(4):
        steps += [{"tool": "hinge", "strokes": [len(strokes)]}, {"set": drive}]
        way = np.linspace(places[4 + side], places[4 + (side + 1) % 4], 30)
        strokes.append(
            Stroke(way[:, 0], way[:, 1], camera, pressure=np.ones(30), t=way[:, 0] * 0.0)
        )
    return steps


def swung(solid: Polyhedron, camera: Camera, count: int) -> list[dict[str, object]]:
    """Return the steps after which the first panel of a screen is held and the others swing."""
    places = camera.project(fitted(solid, 110.0, (0.0, 0.0, 45.0)))[0].round(1).tolist()
    return [
        {"tool": "draw", "strokes": list(range(count))},
        {"tool": "turn", "tap": places[0]},
        {"set": {"moves": "plates"}},
        *({"tool": "move", "tap": places[corner]} for corner in (0, 1, 5)),
        {"command": "swing"},
    ]


def square(low: float, high: float, z: float) -> list[tuple[float, float, float]]:
    """Corners of a level square, counter-clockwise from above."""
    return [(low, low, z), (high, low, z), (high, high, z), (low, high, z)]


def by_hand(solid: Polyhedron, camera: Camera, seed: int) -> list[Stroke]:
    """Draw the edges of a solid as a person does."""
    vertices = fitted(solid, 110.0, (0.0, 0.0, 45.0))
    places = (camera.project(vertices)[0] - 200.0) / SIZE
    edges = [(int(a), int(b)) for a, b in solid.edges]
    strokes = strokes_of(places, edges, HAND, seed, hidden_edges(solid, vertices, camera))
    return [Stroke(s.x, s.y, camera, pressure=swell(s.pressure), t=s.t) for s in strokes]


def swell(pressure: np.ndarray) -> np.ndarray:
    """Let the pressure of a stroke rise and fall."""
    along = np.linspace(0.0, np.pi, len(pressure))
    return pressure * (0.7 + 0.3 * np.sqrt(np.sin(along)))


def drawing(
    strokes: Sequence[Stroke], camera: Camera, steps: Sequence[dict[str, object]] = ()
) -> str:
    """Return ink JSON, one stroke or step a line."""
    width, height = camera.viewport
    head = {
        "format": "bozzetto-ink/1",
        "canvas": {"width": width, "height": height},
        "camera": {
            "kind": camera.kind,
            "eye": list(camera.eye),
            "target": list(camera.target),
            "up": list(camera.up),
            "height": camera.height,
        },
    }
    lines = [json.dumps(_row(stroke)) for stroke in strokes]
    done = ",\n".join(map(json.dumps, steps))
    used = f', "steps": [\n{done}\n]' if steps else ""
    return json.dumps(head)[:-1] + ', "strokes": [\n' + ",\n".join(lines) + f"\n]{used}}}\n"


def _row(stroke: Stroke) -> dict[str, list[float]]:
    every = slice(None, None, 2)
    columns = {"x": stroke.x, "y": stroke.y, "pressure": stroke.pressure, "t": stroke.t}
    digits = {"x": 1, "y": 1, "pressure": 2, "t": 3}
    return {
        name: [round(float(value), digits[name]) for value in (*values[:-1][every], values[-1])]
        for name, values in columns.items()
    }


def hidden_edges(solid: Polyhedron, vertices: np.ndarray, camera: Camera) -> list[int]:
    """Return the edges that lie behind faces for the most part."""
    space = camera.view_space(vertices)
    space = (space - space.mean(axis=0)) / float(np.linalg.norm(np.ptp(space, axis=0)))
    return np.flatnonzero(hidden_shares(View(solid, space, space[:, :2])) > 0.5).tolist()


def main() -> None:
    """Write all samples."""
    FOLDER.mkdir(exist_ok=True)
    made = (
        (house(), GABLE),
        (bracket(), from_side(58.0, 22.0)),
        (stairs(), SHEET),
        (chair(), from_side(62.0, 24.0)),
        (tower(), from_side(34.0, 30.0)),
    )
    for seed, (solid, camera) in enumerate(made):
        strokes = by_hand(solid, camera, seed)
        (FOLDER / f"{solid.name}.json").write_text(drawing(strokes, camera), encoding="utf-8")
        print(f"wrote {solid.name}.json with {len(strokes)} strokes")
    screen, camera = folding_screen(), from_side(20.0, 35.0)
    strokes = by_hand(screen, camera, len(made))
    text = drawing(strokes, camera, swung(screen, camera, len(strokes)))
    (FOLDER / f"{screen.name}.json").write_text(text, encoding="utf-8")
    print(f"wrote {screen.name}.json with {len(strokes)} strokes")
    package, camera = folding_box(), from_side(40.0, 20.0)
    strokes = by_hand(package, camera, len(made) + 1)
    steps = folded(package, camera, strokes)
    (FOLDER / f"{package.name}.json").write_text(drawing(strokes, camera, steps), encoding="utf-8")
    print(f"wrote {package.name}.json with {len(strokes)} strokes")


if __name__ == "__main__":
    main()
