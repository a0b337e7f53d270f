"""Write the linkages among the samples: ``python -m tests.plugins.polyhedron.write_linkages``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bozzetto.ink import Stroke
from bozzetto.view import Camera
from tests.plugins.polyhedron.known_linkages import (
    Linkage,
    four_bar,
    jansen,
    peaucellier,
    robot_arm,
    scissor,
    walker,
)
from tests.plugins.polyhedron.linkages import SHEET, on_sheet, straight
from tests.plugins.polyhedron.write_samples import FOLDER

LINKAGES = {
    "four-bar": four_bar,
    "straight-line": peaucellier,
    "walking-leg": jansen,
    "walker": walker,
    "scissor-lift": scissor,
    "robot-arm": robot_arm,
}
"""By the names of their files."""


WALKING = {"gravity": True, "ground": True, "friction": 0.8}
"""What a linkage needs that nothing holds."""


def camera_of(known: Linkage) -> Camera:
    """Return the view from the front; what nothing holds stands on the ground in it."""
    if known.held:
        return SHEET
    lowest = np.array([max(on_sheet(known).values(), key=lambda place: place[1])])
    down = float(SHEET.on_plane(lowest, SHEET.target, SHEET.axes[2])[0, 2])
    return replace(SHEET, eye=(0.0, -500.0, -down), target=(0.0, 0.0, -down))


def steps_of(known: Linkage) -> tuple[list[Stroke], list[dict[str, Any]]]:
    """Return the strokes and gestures with which a person draws a linkage."""
    corners, camera = on_sheet(known), camera_of(known)

    def between(names: str) -> Stroke:
        return straight(corners[names[0]], corners[names[1]], camera)

    def tap(tool: str, place: Sequence[float]) -> dict[str, Any]:
        return {"tool": tool, "tap": [float(value) for value in place]}

    strokes: list[Stroke] = []
    steps: list[dict[str, Any]] = []
    for bars in known.drawings():
        first = len(strokes)
        strokes += [between(bar) for bar in bars]
        steps += [{"command": "new-body"}] if steps else []
        steps.append({"tool": "draw", "strokes": list(range(first, len(strokes)))})
        steps.append({"set": {"moves": "flat"}})
    steps += [tap("move", corners[name]) for name in known.held]
    for bar in known.links:
        steps.append({"tool": "link", "strokes": [len(strokes)]})
        strokes.append(between(bar))
    for one, other in known.pins:
        middle = np.mean([corners[name] for name in one + other], axis=0)
        steps.append(tap("pin", middle))
    if known.guided:
        begin = corners[known.guided]
        steps.append({"tool": "slider", "strokes": [len(strokes)]})
        strokes.append(straight(begin, np.add(begin, (60.0, 0.0)), camera))
    steps += [{"tool": "motor", "strokes": [len(strokes)]}, {"set": known.drive}]
    strokes.append(between(known.motor))
    for bar, drive in known.more:
        steps += [{"tool": "motor", "strokes": [len(strokes)]}, {"set": drive}]
        strokes.append(between(bar))
    steps.append(tap("trace", corners[known.traced]))
    steps += [] if known.held else [{"set": WALKING}]
    return strokes, steps


def ink_of(known: Linkage) -> str:
    """Return ink JSON, one stroke or step a line."""
    strokes, steps = steps_of(known)
    camera = camera_of(known)
    width, height = camera.viewport
    head = {
        "format": "bozzetto-ink/1",
        "canvas": {"width": width, "height": height},
        "camera": {
            "kind": camera.kind,
            "eye": list(camera.eye),
            "target": list(camera.target),
            "fov_y": camera.fov_y,
        },
    }
    rows = [
        {name: [round(float(v), 4) for v in values] for name, values in (("x", s.x), ("y", s.y))}
        for s in strokes
    ]
    body = ",\n".join(map(json.dumps, rows))
    done = ",\n".join(map(json.dumps, steps))
    return f'{json.dumps(head)[:-1]}, "strokes": [\n{body}\n], "steps": [\n{done}\n]}}\n'


def main() -> None:
    """Write all linkages."""
    for name, known in LINKAGES.items():
        (FOLDER / f"{name}.json").write_text(ink_of(known()), encoding="utf-8")
        print(f"wrote {name}.json")


if __name__ == "__main__":
    main()
