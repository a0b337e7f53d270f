"""Bodies put together: sharp, blended, and as a smooth maximum on a full grid; and trees."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import count

import numpy as np

from bozzetto.geometry import Placement
from bozzetto.ink import Strokes
from bozzetto.plugin import Job
from bozzetto.testing import Pen
from bozzetto_silhouette.implicit.composite import Composite
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.modeler import PREVIEW_RESOLUTION, Silhouette
from bozzetto_silhouette.rigging.armature import armature_of
from bozzetto_silhouette.rigging.posing import turns_of
from bozzetto_silhouette.solids.body import Body
from bozzetto_silhouette.solids.boolean import combined
from bozzetto_silhouette.solids.draft import draft_of
from bozzetto_silhouette.solids.evaluate import tree_body
from tests.benchmarks.timing import Row, processor_ms
from tests.plugins.silhouette import bodies as b

BLEND = 0.5
CELLS = 48
LIMBS = 29
MODELER = Silhouette()

_HAIRS = count(1)


def rows() -> Iterator[Row]:
    """Two balls that overlap, drafts while a part is dragged, and a tree of thirty parts."""
    for cells, sharp, blended in (
        (64, "", "≤ 150 ms"),
        (128, "", "≤ 100 ms"),
        (165, "≤ 100 ms", ""),
    ):
        one, other = b.ball(0.0, 50.0, cells), b.ball(70.0, 50.0, cells, "b")
        grid = processor_ms(partial(_on_a_grid, one, other), repeats=2)
        for words, blend, budget in (("sharp", 0.0, sharp), ("blended", BLEND, blended)):
            yield Row(
                "blends", f"two parts of {len(one.faces):,} triangles, {words}, processor time",
                processor_ms(partial(_anew, one, other, blend), repeats=5),
                budget=budget, alternative="smooth maximum on a full grid, marching cubes",
                other=grid,
            )  # fmt: skip
    for parts in (2, 6):
        yield Row(
            "blends", f"a part dragged over {parts - 1} more, processor time",
            processor_ms(partial(_dragged, _wreath(parts - 1)), repeats=10), budget="≤ 100 ms",
        )  # fmt: skip
    yield from _tree()


def _anew(one: Body, other: Body, blend: float) -> object:
    """What was combined before is remembered; a hair more blend is another question."""
    return combined(one, other, "add", blend and blend + 1e-9 * next(_HAIRS))


def _wreath(limbs: int) -> SilhouetteState:
    """A body with limbs around it."""
    pen = Pen()
    nodes = [Part(id="n0", name="Body", strokes=Strokes((pen.circle(600.0, 450.0, 250.0),)))]
    for k in range(limbs):
        turn = 2.0 * np.pi * k / limbs
        place = 600.0 + 255.0 * np.cos(turn), 450.0 + 255.0 * np.sin(turn)
        circle = pen.circle(*place, 18.0 + k % 5)
        nodes.append(Part(id=f"n{k + 1}", name=f"Limb {k + 1}", strokes=Strokes((circle,))))
    return SilhouetteState(tuple(nodes))


def _dragged(state: SilhouetteState, place: int = -1) -> object:
    """One event of the pen that drags a part, the last one by default."""
    node = state.nodes[place]
    away = Placement(offset=(0.01 * next(_HAIRS), 0.0, 0.0))
    moved = replace(state.with_node(replace(node, pose=away)), selected=node.id)
    return draft_of(moved, PREVIEW_RESOLUTION)


def _slid(state: SilhouetteState, place: int) -> object:
    """One value of a slider of a part: what is solved and shown of it."""
    node = state.nodes[place]
    inflated = state.with_node(replace(node, inflation=1.1 + 1e-6 * next(_HAIRS)))
    return MODELER.scene(inflated, MODELER.solve(inflated, Job("preview")))


def _posed(state: SilhouetteState) -> SilhouetteState:
    """The state with every fifth joint turned by 30°."""
    armature = armature_of(state)
    assert armature is not None
    quaternions = np.tile([0.0, 0.0, 0.0, 1.0], (len(armature.rig.joints), 1))
    quaternions[4::5] = 0.0, np.sin(np.pi / 12.0), 0.0, np.cos(np.pi / 12.0)
    return replace(state, turns=turns_of(armature, quaternions))


def _tree() -> Iterator[Row]:
    """All of a tree, then one limb of it edited; every figure is of one run."""

    def spent(state: SilhouetteState) -> float:
        begun = time.process_time()
        tree_body(state, CELLS)
        return 1000.0 * (time.process_time() - begun)

    state = _wreath(LIMBS)
    whole = spent(state)
    yield Row("blends", f"a tree of {LIMBS + 1} parts, processor time", whole, budget="≤ 3000 ms")
    places = (
        ("last limb", LIMBS), ("middle limb", LIMBS // 2 + 1), ("first limb", 1), ("trunk", 0)
    )  # fmt: skip
    for words, place in places:
        state = state.with_node(replace(state.nodes[place], inflation=1.2))
        yield Row(
            "blends", f"a tree of {LIMBS + 1} parts, its {words} edited, processor time",
            spent(state), budget="≤ 1000 ms", alternative="the whole tree", other=whole,
        )  # fmt: skip
    for words, place in places:
        yield Row(
            "blends", f"a tree of {LIMBS + 1} parts, {words}, frame of a slider, processor time",
            processor_ms(partial(_slid, state, place), repeats=7), budget="≤ 100 ms",
        )  # fmt: skip
    turned = _posed(state)
    for words, place in places:
        yield Row(
            "blends",
            f"a posed tree of {LIMBS + 1} parts, {words}, frame of a slider, processor time",
            processor_ms(partial(_slid, turned, place), repeats=7), budget="≤ 250 ms",
        )  # fmt: skip
    yield Row(
        "blends", f"a part dragged over {LIMBS} more, processor time",
        processor_ms(partial(_dragged, state), repeats=5), budget="≤ 100 ms",
    )  # fmt: skip
    yield Row(
        "blends", f"the trunk dragged under {LIMBS} more, processor time",
        processor_ms(partial(_dragged, state, 0), repeats=5), budget="≤ 100 ms",
    )  # fmt: skip


def _on_a_grid(one: Body, other: Body) -> object:
    """What most programs do: every node of the grid, at the same spacing."""
    from skimage.measure import marching_cubes

    solid = Composite(
        one.implicit, other.implicit, "add", BLEND, BLEND * min(one.radius, other.radius)
    )
    low, high = solid.bounds
    axes = [
        np.arange(a - one.step, c + 2.0 * one.step, one.step)
        for a, c in zip(low, high, strict=True)
    ]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    values = solid.value(nodes.reshape(-1, 3)).reshape(nodes.shape[:3])
    return marching_cubes(values, 0.0)
