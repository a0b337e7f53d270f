"""Write the linkages among the samples: ``python -m tests.plugins.polyhedron.write_linkages``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np

from bozzetto.ink import Stroke
from tests.plugins.polyhedron.known_linkages import (
    Linkage,
    four_bar,
    jansen,
    peaucellier,
    robot_arm,
    scissor,
)
from tests.plugins.polyhedron.linkages import SHEET, on_sheet, straight
from tests.plugins.polyhedron.write_samples import FOLDER

LINKAGES = {
    "four-bar": four_bar,
    "straight-line": peaucellier,
    "walking-leg": jansen,
    "scissor-lift": scissor,
    "robot-arm": robot_arm,
}
"""By the names of their files."""


def steps_of(known: Linkage) -> tuple[list[Stroke], list[dict[str, Any]]]:
    """Return the strokes and gestures with which a person draws a linkage."""
    corners = on_sheet(known)

    def between(names: str) -> Stroke:
        return straight(corners[names[0]], corners[names[1]])

    def tap(tool: str, place: Sequence[float]) -> dict[str, Any]:
        return {"tool": tool, "tap": [float(value) for value in place]}

    strokes = [between(bar) for bar in known.bars]
    steps: list[dict[str, Any]] = [
        {"tool": "draw", "strokes": list(range(len(strokes)))},
        {"set": {"moves": "flat"}},
        *(tap("move", corners[name]) for name in known.held),
    ]
    for one, other in known.pins:
        middle = np.mean([corners[name] for name in one + other], axis=0)
        steps.append(tap("pin", middle))
    if known.guided:
        begin = corners[known.guided]
        steps.append({"tool": "slider", "strokes": [len(strokes)]})
        strokes.append(straight(begin, np.add(begin, (60.0, 0.0))))
    steps += [{"tool": "motor", "strokes": [len(strokes)]}, {"set": known.drive}]
    strokes.append(between(known.motor))
    for bar, drive in known.more:
        steps += [{"tool": "motor", "strokes": [len(strokes)]}, {"set": drive}]
        strokes.append(between(bar))
    steps.append(tap("trace", corners[known.traced]))
    return strokes, steps


def ink_of(known: Linkage) -> str:
    """Return ink JSON, one stroke or step a line."""
    strokes, steps = steps_of(known)
    width, height = SHEET.viewport
    head = {
        "format": "bozzetto-ink/1",
        "canvas": {"width": width, "height": height},
        "camera": {
            "kind": SHEET.kind,
            "eye": list(SHEET.eye),
            "target": list(SHEET.target),
            "fov_y": SHEET.fov_y,
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
