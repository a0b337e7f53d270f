"""Free ends of curves: where each is by its own ink, and how far off it may be."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.plugin import remembered
from bozzetto.view import Camera
from bozzetto_symmetry.editing.end_snaps import drawn_end
from bozzetto_symmetry.editing.snap import end_direction
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.operations.snap_candidates import DEPTH_SIGMAS, Reach
from bozzetto_symmetry.solve.curve_solver import Trace, trace_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import image_slopes

TWICE: Final = 2.0
"""How much worse a hand ends along its way than it keeps on it, as for flat curves."""

HELD: Final = 1e3
"""Weight of the centre plane for a curve that lies in it, per mm."""

LEAST: Final = 1e-3
"""Weight of the place of an end where its ink knows nothing of it, per mm."""


@dataclass(frozen=True, eq=False)
class Free:
    """A curve as its ink says it, whose ends may settle.

    Attributes
    ----------
    node : Curve
        Without snaps of its ends.
    trace : Trace
    curve : SpaceCurve
    camera : Camera
        Of its last stroke, in the model's frame.
    """

    node: Curve
    trace: Trace
    curve: SpaceCurve
    camera: Camera

    @property
    def ends(self) -> tuple[int, ...]:
        """Its free ends."""
        return (1,) if self.curve.reading == "self" else (0, 1)


@dataclass(frozen=True, eq=False)
class FreeEnd:
    """A free end, on that side of the centre plane where y is not negative.

    Attributes
    ----------
    owner : str
        Id of the curve.
    number : {0, 1}
    side : (3,) float
        Factors that lead from the side of the curve to this one.
    place : (3,) float
        In the frame of the plane, mm.
    reach : Reach
        How far it may go, there.
    sigma : float
        mm.
    leaving : (3,) float
        Unit direction in which the curve leaves it.
    known : (3, 3) float
        Information of the ink about the place, per mm².
    """

    owner: str
    number: int
    side: Array
    place: Array
    reach: Reach
    sigma: float
    leaving: Array
    known: Array

    @property
    def room(self) -> float:
        """The farthest that it may go, mm."""
        return self.reach.across + DEPTH_SIGMAS * self.sigma

    def away(self, place: Array, sigma: float | None = None) -> float:
        """Return how far a place (3,) is from it, in its reaches, for its own or another sigma."""
        way = (place - self.place)[None]
        return float(self.reach.ratios(way, self.sigma if sigma is None else sigma)[0])


def free_curves(state: SymmetryState, without: str) -> tuple[dict[str, Free], list[SpaceCurve]]:
    """Return the curves whose ends may settle, by id, and those that stay as they are.

    Parameters
    ----------
    state : SymmetryState
        Its curves, and the plane.
    without : str
        Id of a curve that does not count.
    """
    free: dict[str, Free] = {}
    others: list[SpaceCurve] = []
    for node in state.shown_curves:
        if node.id == without:
            continue
        bare = replace(node, end_snaps=(), axis=-1)
        may = node.settles and node.canvas is None and not node.edits
        try:
            trace = trace_of(bare if may else node, state)
        except UserError:
            continue
        if trace.curve is None:
            continue
        if may and not trace.curve.closed:
            free[node.id] = Free(
                replace(node, end_snaps=()), trace, trace.curve, node.strokes[-1].camera
            )
        else:
            others.append(trace.curve)
    return free, others


# A trace says all that its ink does; those of other curves are the same from stroke to stroke.
@remembered(limit=512, key=lambda each, state: (each.node.id, each.trace, state.plane))
def ends_of(each: Free, state: SymmetryState) -> tuple[FreeEnd, ...]:
    """Return the free ends of a curve."""
    return tuple(_ends_of(each, state))


def _ends_of(each: Free, state: SymmetryState) -> Iterator[FreeEnd]:
    curve, camera = each.curve, Stereo.of(each.camera, state.plane).camera
    for number in each.ends:
        place = curve.spline.value(curve.spline.range[number : number + 1])[0]
        leaving = end_direction(curve.spline if number else curve.spline.reversed())
        reach = Reach.of(place, camera)
        if reach is None:
            continue
        side = MIRROR if place[1] < 0.0 else np.ones(3)
        sigma = float(each.trace.sigma[-number])
        known = side[:, None] * _information(each, number, place, leaving, state) * side
        yield FreeEnd(each.node.id, number, side, place * side, reach.reflected(side), sigma,
                   leaving * side, known)  # fmt: skip


def _information(
    each: Free, number: int, place: Array, leaving: Array, state: SymmetryState
) -> Array:
    """Return what the ink says about an end, (3, 3) per mm²: 1 px across its way, 2 px along it."""
    made = np.eye(3) * LEAST**2
    if each.curve.reading == "plane":
        made[1, 1] += HELD**2
    for stroke in each.node.strokes:
        for end in (0, 1):
            shown = drawn_end(each.curve, stroke, end, state)
            if shown is None or shown.end != number:
                continue
            side = MIRROR if shown.mirrored else np.ones(3)
            stereo = Stereo.of(stroke.camera, state.plane)
            slopes = image_slopes(stereo, place * side)[0] * side
            way = slopes @ leaving
            way = way / max(float(np.linalg.norm(way)), 1e-300)
            rows = np.stack((way @ slopes / TWICE, np.array((-way[1], way[0])) @ slopes))
            made += rows.T @ rows
    return made
