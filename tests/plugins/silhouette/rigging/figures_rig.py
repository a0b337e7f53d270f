"""How rigs stretch: ``python -m tests.plugins.silhouette.rigging.figures_rig``.

The shared outlines that no test uses, and people of seeds that none uses.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from bozzetto.plugin import Job
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.outline.mirror_symmetry import mirrored_coordinate
from bozzetto_silhouette.outline.normalized import frame_of
from tests.plugins.silhouette.outlines import COMMITTED, SHARED, svg_rings
from tests.plugins.silhouette.rigging.characters import (
    dense,
    fitted,
    man,
    state_of_rings,
    stretches,
)

CHARACTERS = (
    "bacterium crow dove drumstick-bite frog hand-spock horse-head pastafarianism piggy-bank "
    "shirt tree virus-covid"
).split()
"""Those of the shared outlines that somebody might animate."""

FIRST_SEED = 820_000
PEOPLE = 12


def people() -> Iterator[Any]:
    """Yield people with measures and arms of their own."""
    for seed in range(FIRST_SEED, FIRST_SEED + PEOPLE):
        arms = np.random.default_rng(seed).uniform(-35.0, 45.0)
        yield state_of_rings([man(float(arms), seed=seed)])


def shared(*, characters: bool) -> Iterator[Any]:
    """Yield the shared outlines, characters or all others."""
    known = {path.stem for path in COMMITTED.glob("*.svg")}
    for path in sorted(SHARED.glob("*.svg")):
        if path.stem not in known and (path.stem in CHARACTERS) == characters:
            yield state_of_rings(fitted(svg_rings(path)))


def row(name: str, states: Iterator[Any]) -> str:
    """Return a row of the table."""
    modeler = Silhouette()
    worst, bones, weightless, symmetric, mirrored = [], 0, 0, 0, 0
    for state in states:
        result = modeler.solve(state, Job("final"))
        solid = modeler.shapes(state, result).solids[0]
        if solid.skin is None or len(solid.skin.rig.joints) < 2:
            continue
        worst.append(stretches(solid.mesh, solid.skin).max())
        bones += len(solid.skin.rig.joints)
        weightless += int((dense(solid.skin).sum(axis=0) <= 0.0).sum())
        frame = frame_of(outline_of(state.nodes[0]))
        coordinate = mirrored_coordinate(frame.inner.rings)
        if coordinate is None:
            continue
        symmetric += 1
        axis = (0, 2)[coordinate]
        whole = modeler.solve(replace(state, posing=True), Job("final")).skin.rig.joints
        mirrored += _mirrors(solid.mesh.vertices, axis, solid.mesh.vertices) and _mirrors(
            whole, axis, solid.mesh.vertices
        )
    torn = sum(one > 1.8 for one in worst)
    return (
        f"| {name} | {len(worst)} | {np.median(worst):.2f} / {max(worst):.2f} | {torn} | "
        f"{weightless} of {bones} | {mirrored} of {symmetric} |"
    )


def _mirrors(points: Any, axis: int, shape: Any) -> bool:
    """Whether every point has its mirror image in the middle of a shape, within 0.1 µm a mm."""
    image = np.array(points, float)
    middle = 0.5 * (float(shape[:, axis].min()) + float(shape[:, axis].max()))
    image[:, axis] = 2.0 * middle - image[:, axis]
    return bool(cKDTree(np.asarray(points, float)).query(image)[0].max() < 1e-3)


def main() -> None:
    """Print the table."""
    print("| Outlines | How many | Stretch, median / worst | Above 1.8 | Bones without weights "
          "| Symmetric ones mirrored whole |")  # fmt: skip
    print("| --- | --- | --- | --- | --- | --- |")
    print(row("people", people()))
    print(row("animals, hands, plants", shared(characters=True)))
    print(row("signs and things", shared(characters=False)))


if __name__ == "__main__":
    main()
