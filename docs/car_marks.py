"""Marks and strokes on the drawn cars, as a person would set them, for the marks files."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from car_details import (
    door_lines,
    edge_points,
    from_side,
    front_lines,
    lamp_lines,
    polygon,
    side_windows,
    styling,
)
from car_seen import Car, Seen
from numpy.typing import NDArray
from scipy.ndimage import binary_erosion

Array = NDArray[np.float64]

HAND: Final = 2.0
"""Standard deviation of a mark, px per coordinate."""

TREMOR: Final = 0.6
"""The same of the slowest wave in a stroke, px."""

STEP: Final = 4.0
"""Way from point to point of a stroke, px."""

WHOLE: Final = 0.97
"""Share of an edge that must be seen for a person to trace it."""

APART: Final = 6.0
"""Distance of mirror images in a picture from which on both can be told apart, px."""

WITHIN: Final = 6
"""Distance from the outline at which a styling line ends, px: beyond it there is no body."""

SHORTEST: Final = 60.0
"""Length of the shortest stroke that is worth while, px."""


def marks_of(seen: Seen, rng: np.random.Generator) -> dict[str, list[float]]:
    """Where nodes that the drawing shows are, with a hand's error, by name."""
    template = seen.car.network.template
    positions = seen.car.network.positions
    shown = seen.shows(positions)
    places = seen.camera.project(positions)[0]
    for number, node in enumerate(template.wheels.ravel()):
        column, row = np.floor(places[node]).astype(int)
        shown[node] = seen.wheel[row, column] == number
    shown &= ~covered(seen, places)
    marked = places + rng.normal(0.0, HAND, places.shape)
    near = "R" if seen.camera.eye[1] > 0.0 else "L"
    return {
        template.names[node]: np.round(marked[node], 1).tolist()
        for node in template.asked(near)
        if shown[node]
    }


def covered(seen: Seen, places: Array) -> NDArray[np.bool_]:
    """Nodes that their mirror images, in front of them, are drawn upon."""
    template = seen.car.network.template
    image = template.mirrored
    depth = seen.camera.view_space(seen.car.network.positions)[:, 2]
    near = np.linalg.norm(places - places[image], axis=1) < APART
    return np.asarray(near & (depth > depth[image]))


def strokes_of(seen: Seen, rng: np.random.Generator) -> dict[str, list[list[float]]]:
    """Edges that are drawn and seen from end to end, each in one stroke, by name."""
    found = {}
    template = seen.car.network.template
    for name in drawn_edges(seen):
        points = edge_points(seen.car, *name.split("-"))
        twin_points = points * (1.0, -1.0, 1.0)
        both = seen.camera.project(points)[0], seen.camera.project(twin_points)[0]
        off = np.linalg.norm(both[0] - both[1], axis=1)
        behind = seen.camera.view_space(points)[:, 2] > seen.camera.view_space(twin_points)[:, 2]
        if (off[behind] < APART).sum() > 0.5 * len(points):
            continue
        if shown_share(seen, points) >= WHOLE:
            path = seen.camera.project(points)[0]
            if length(path) >= SHORTEST:
                found[name] = stroke(path, rng)
    return dict(sorted(found.items(), key=lambda item: template.edge_names.index(item[0])))


def drawn_edges(seen: Seen) -> list[str]:
    """Names of the edges that are lines in the drawings: all chains, and the middle."""
    template = seen.car.network.template
    edges = {max(edge, ~edge) for chain in template.chains for edge in chain.edges}
    middle = set(template.centre.tolist())
    lone = ("C4",)  # nothing is drawn across the roof at the B-pillar
    return [
        name
        for edge, name in enumerate(template.edge_names)
        if (edge in edges and name.split("-")[0] not in lone) or set(template.edges[edge]) <= middle
    ]


def styling_of(seen: Seen, view: int, rng: np.random.Generator) -> list[dict[str, Any]]:
    """Lines on the body in one view: the longest run of each that nothing hides."""
    found = []
    side = 1.0 if seen.camera.eye[1] > 0.0 else -1.0
    inner = binary_erosion(seen.patch >= 0, iterations=WITHIN)
    for name, line in on_body(seen.car).items():
        runs = [
            part
            for path in gone_round(seen.drawn(line * (1.0, side, 1.0)))
            for part in np.split(path, 1 + np.flatnonzero(np.diff(within(inner, path).astype(int))))
            if within(inner, part[:1])[0]
        ]
        if runs:
            path = max(runs, key=length)
            if length(path) >= SHORTEST:
                found.append({"view": view, "name": name, "points": stroke(path, rng)})
    return found


def gone_round(runs: list[Array]) -> list[Array]:
    """Runs of a line; of a closed one, the last and the first are one if they meet."""
    if len(runs) < 2 or np.linalg.norm(runs[-1][-1] - runs[0][0]) > STEP:
        return runs
    return [np.concatenate((runs[-1], runs[0][1:])), *runs[1:-1]]


def best_drawn(drawn: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Each line in the view that shows most of it, in the order of the names."""
    best: dict[str, dict[str, Any]] = {}
    for line in drawn:
        known = best.setdefault(line["name"], line)
        if length(np.array(line["points"])) > length(np.array(known["points"])):
            best[line["name"]] = line
    return list(best.values())


def on_body(car: Car) -> dict[str, Array]:
    """Lines on the right side of the body that no template has, by name, (k, 3) mm."""
    found = styling(car)
    panes = sorted(side_windows(car), key=lambda pane: float(pane[:, 0].mean()))
    for number, pane in enumerate(panes):
        found[f"side window {number + 1}"] = from_side(car, polygon(pane, 260))
    gaps = (line.points for line in door_lines(car) if line.role == "cut")
    found |= zip(("front door", "door gap", "rear door"), gaps, strict=True)
    lamps = (line.points for line in lamp_lines(car) if line.role == "lamp")
    found |= zip(("headlamp", "tail lamp"), lamps, strict=True)
    intakes = (line.points for line in front_lines(car) if line.role == "lamp")
    for name, outline in zip(("grille", "intake"), intakes, strict=True):
        found[name] = outline[: len(outline) // 2]
    return found


def within(mask: NDArray[np.bool_], path: Array) -> NDArray[np.bool_]:
    """Which places of a path (k, 2) are in a mask."""
    column, row = np.floor(path).astype(int).T
    return np.asarray(mask[row, column])


def shown_share(seen: Seen, points: Array) -> float:
    return float((seen.shows(points) & ~seen.car.in_arch(points)).mean())


def length(path: Array) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def stroke(path: Array, rng: np.random.Generator) -> list[list[float]]:
    """A path gone along once by a hand that trembles slowly, px."""
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))))
    even = np.linspace(0.0, along[-1], max(8, int(along[-1] / STEP)))
    share = even[:, None] / along[-1]
    waves = np.arange(1, 5)
    made = np.column_stack([np.interp(even, along, path[:, axis]) for axis in (0, 1)])
    made += np.sin(np.pi * share * waves + rng.uniform(0.0, 6.3, 4)) @ (
        rng.normal(0.0, TREMOR, (4, 2)) / waves[:, None]
    )
    return np.round(made, 1).tolist()
