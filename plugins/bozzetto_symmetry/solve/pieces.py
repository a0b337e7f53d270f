"""Where curves may go on from one another, because the pen was lifted there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from bozzetto.errors import UserError
from bozzetto.ink import carried_places, is_one_view
from bozzetto.view import Camera
from bozzetto_symmetry.ink.continuation import Continuation, OpenLine, meeting
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.solve.curve_solver import trace_if_any, views_of

MAY_GO_ON: Final = "It may go on where “{}” ends. Press X to take both for one line."


@dataclass(frozen=True)
class Link:
    """Two strokes of two curves, of which one may go on where the other ended."""

    curves: tuple[str, str]
    strokes: tuple[int, int]
    how: Continuation


@dataclass(frozen=True, eq=False)
class _Ink:
    """One open side of a curve, the last of its strokes, and the camera that it was drawn in."""

    curve: str
    stroke: int
    camera: Camera
    line: OpenLine

    def seen(self, camera: Camera) -> OpenLine:
        """Return its line on another canvas of the same view."""
        if camera == self.camera:
            return self.line
        return OpenLine(carried_places(self.line.pixels, self.camera, camera), self.line.noise)


def open_links(curve: Curve, state: SymmetryState) -> tuple[Link, ...]:
    """Return where a curve may go on from others that it is not joined to, the smoothest first."""
    if not can_be_joined(curve):
        return ()
    others = [other for other in others_in_view(state, curve) if can_be_joined(other)]
    found = [link for link in links_between([*others, curve], state) if curve.id in link.curves]
    return _smoothest_first(found)


def may_go_on(state: SymmetryState) -> Mapping[str, str]:
    """Return what is said of curves that may go on from others and were not taken so, by ids."""
    curves = {node.id: node for node in state.shown_curves if can_be_joined(node)}
    said: dict[str, str] = {}
    for link in _smoothest_first(links_between(list(curves.values()), state)):
        both = [curves[name] for name in link.curves]
        if all(node.goes_on for node in both) and any(_lacks(node, state) for node in both):
            for node, other in (both, both[::-1]):
                said.setdefault(node.id, MAY_GO_ON.format(other.name))
    return said


def _smoothest_first(links: Sequence[Link]) -> tuple[Link, ...]:
    return tuple(sorted(links, key=lambda link: (link.how.bend, link.curves)))


def _lacks(curve: Curve, state: SymmetryState) -> bool:
    """Return whether ink of a curve waits for more, so that it matters what goes on with it."""
    trace = trace_if_any(curve, state)
    return trace is not None and (trace.reading == "half" or trace.rest > 0.0)


def can_be_joined(curve: Curve) -> bool:
    """Return whether the ink of a curve is all that it is: in the air, and not edited."""
    return curve.canvas is None and not curve.edits and len(curve.strokes) > 0


def others_in_view(state: SymmetryState, curve: Curve) -> list[Curve]:
    """Return the other curves of which all ink is in the view of a curve."""
    camera = curve.strokes[0].camera
    return [
        node for node in state.shown_curves
        if node.id != curve.id
        and all(is_one_view(camera, stroke.camera) for stroke in node.strokes)
    ]  # fmt: skip


def _open_ink(curve: Curve, state: SymmetryState) -> list[_Ink]:
    """Return the open sides of a curve that was drawn in one view."""
    try:
        (view,) = views_of(curve, state, curve.reading)
    except (UserError, ValueError):
        return []
    camera = curve.strokes[0].camera
    return [
        _Ink(curve.id, view.numbers[side.strokes[-1]], camera, OpenLine(side.pixels, side.noise))
        for side in view.sides
        if not side.closed
    ]


def links_between(curves: Sequence[Curve], state: SymmetryState) -> tuple[Link, ...]:
    """Return where some curves may go on from one another; of two in the first one's canvas."""
    ink = [each for curve in curves for each in _open_ink(curve, state)]
    found = []
    for camera in dict.fromkeys(each.camera for each in ink):
        here = [each for each in ink if is_one_view(camera, each.camera)]
        for i, j, how in meeting([each.seen(camera) for each in here]):
            one, other = here[i], here[j]
            if one.camera == camera and one.curve != other.curve:
                found.append(Link((one.curve, other.curve), (one.stroke, other.stroke), how))
    return tuple(found)
