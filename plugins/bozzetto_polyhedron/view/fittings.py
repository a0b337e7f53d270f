"""Links, springs, axes, guides, motors and traces where their motion has taken them."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.scene import Hidden, Item, Label, Lines, Points
from bozzetto_polyhedron.mechanism.assembly import GROUND, Motion
from bozzetto_polyhedron.model.fittings import (
    Coil,
    Crank,
    Fitting,
    Hinge,
    Link,
    Pin,
    Slider,
    Trace,
    Turning,
)
from bozzetto_polyhedron.model.limits import is_near
from bozzetto_polyhedron.model.motor_curves import typed_keys
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.forces import forces_of
from bozzetto_polyhedron.solve.moving import Moving
from bozzetto_polyhedron.solve.paths import path_of
from bozzetto_polyhedron.solve.spots import place_of

WIDTH, CHOSEN_WIDTH = 2.0, 3.0
"""Of fittings, px; of the one that is chosen."""

COILS: Final = 7
"""Turns of a spring that are drawn."""

WIDE: Final = 0.06
"""Width of a spring and of the arrow of a motor, in its length."""

ROUND: Final = 0.06
"""Largest radius of the arrow of a motor, in the extent of what it moves."""

OUTSIDE: Final = 1.6
"""Distance of what is written of a motor from its axis, in radii of its arrow."""

THICK: Final = 7.0
"""Width of the bar that carries most, px."""

LOADED: Final = 0.02
"""Share of the largest force below which a bar counts as carrying nothing."""

MOST_LABELS: Final = 40
"""Bars whose forces are written beside them."""

END: Final = 7.0
"""Diameter of the ends of fittings, px."""


def fitting_items(
    state: PolyhedronState, made: Moving, motion: Motion, *, chosen: bool = False
) -> list[Item]:
    """Return all fittings that are shown; or the chosen one alone, as it lies over them."""
    items: list[Item] = []
    radius = ROUND * made.extent
    for fitting in state.fittings():
        if chosen and fitting.id != state.selected:
            continue
        ends = _ends(state, made, motion, fitting)
        if ends is not None and is_near((*ends.ravel(), radius)):
            items += _items(fitting, ends, _side(made, fitting), radius, chosen)
    return items


def force_items(state: PolyhedronState, made: Moving) -> list[Item]:
    """Return bars as wide as they are loaded: in one colour pulled, in another one pressed."""
    found = forces_of(state, made)
    if found is None or not len(found.newtons):
        return []
    largest = float(np.abs(found.newtons).max())
    items: list[Item] = []
    for ends, force in zip(found.ends, found.newtons, strict=True):
        share = abs(force) / largest if largest > 0.0 else 0.0
        color = "second" if force > 0.0 else "accent"
        if share < LOADED:
            color = "ghost"
        width = WIDTH + (THICK - WIDTH) * share
        items.append(Lines(ends.astype(np.float32), color=color, width=width, hidden="show"))
        if len(found.newtons) <= MOST_LABELS and share >= LOADED:
            x, y, z = (float(value) for value in ends.mean(axis=0))
            items.append(Label((x, y, z), f"{force:+.2g} N", color=color))
    return items


def trace_items(state: PolyhedronState, made: Moving) -> list[Item]:
    """Return the paths of corners, as far as they were recorded."""
    items: list[Item] = []
    for trace in state.shown(Trace):
        path = path_of(trace, state, made)
        if len(path) > 1:
            width = CHOSEN_WIDTH if trace.id == state.selected else WIDTH
            items.append(Lines(path.astype(np.float32), color="accent", width=width, hidden="show"))
    return items


def seen_ends(state: PolyhedronState, made: Moving, fitting: Fitting) -> Array | None:
    """Return both ends of a fitting where they are now, (2, 3) mm; None where its body is gone."""
    return _ends(state, made, made.motion(state.moved), fitting)


def _ends(state: PolyhedronState, made: Moving, motion: Motion, fitting: Fitting) -> Array | None:
    rest = np.stack((place_of(fitting.begin, state), place_of(fitting.end, state)))
    bodies = [fitting.begin.body, fitting.end.body]
    if isinstance(fitting, Hinge | Crank):
        bodies[1] = bodies[0]
    if isinstance(fitting, Slider):
        bodies = ["", ""]
    if fitting.begin.body and made.number_of(fitting.begin.body) is None:
        return None
    ends = []
    for body, place in zip(bodies, rest, strict=True):
        number = made.number_of(body) if body else GROUND
        if number is None:
            return None
        ends.append(made.moved_place(number, place, motion))
    return np.stack(ends)


def _items(fitting: Fitting, ends: Array, side: Array, radius: float, chosen: bool) -> list[Item]:
    width = CHOSEN_WIDTH if chosen else WIDTH
    color = "accent" if chosen else "second"
    points = ends
    hidden: Hidden = "dashed" if isinstance(fitting, Slider) else "faint"
    if isinstance(fitting, Pin):
        return [Points(ends[:1].astype(np.float32), color=color, size=END + 2.0)]
    if isinstance(fitting, Coil):
        points = _zigzag(ends, side)
    elif isinstance(fitting, Hinge):
        points = ends + 0.15 * np.array([[-1.0], [1.0]]) * (ends[1] - ends[0])
    elif isinstance(fitting, Crank):
        points = _arc(ends, side, radius)
    if not is_near(points):  # both ends are at one place, or too far away to be seen
        return []
    items: list[Item] = [
        Lines(points.astype(np.float32), color=color, width=width, hidden=hidden),
    ]
    if isinstance(fitting, Link | Coil | Slider):
        items.append(
            Points(
                ends[: 1 if isinstance(fitting, Slider) else 2].astype(np.float32),
                color=color,
                size=END,
            )
        )
    if isinstance(fitting, Turning | Slider) and fitting.drive != "no":
        # Of a motor outside its arc, on the side on which its bar is not.
        is_motor = isinstance(fitting, Crank)
        place = ends[0] - OUTSIDE * _arm(ends, radius) if is_motor else points[-1]
        x, y, z = (float(value) for value in place)
        items.append(Label((x, y, z), _drive(fitting), color=color))
    return items


def _drive(fitting: Turning | Slider) -> str:
    if isinstance(fitting, Turning) and fitting.drive == "steady":
        return f"{fitting.speed:.4g} °/s"
    size, unit = (fitting.travel, " mm") if isinstance(fitting, Slider) else (fitting.angle, "°")
    if fitting.drive == "swing":
        return f"±{abs(size):.4g}{unit} in {fitting.period:.4g} s"
    keys = typed_keys(fitting.curve)
    values = [value for _, value in keys]
    length = keys[-1][0] - keys[0][0]
    return f"{min(values):.4g} to {max(values):.4g}{unit} in {length:.4g} s"


def _side(made: Moving, fitting: Fitting) -> Array:
    """Return the direction to which coils and arcs are wide: in the plane of a flat drawing."""
    number = made.number_of(fitting.begin.body)
    normal = None if number is None else made.machine.shapes[number].normal
    return np.array([0.0, 1.0, 0.0] if normal is None else normal)


def _zigzag(ends: Array, normal: Array) -> Array:
    along = ends[1] - ends[0]
    aside = _across(along, normal) * np.linalg.norm(along)
    share = np.concatenate(([0.0, 0.15], np.linspace(0.2, 0.8, 2 * COILS), [0.85, 1.0]))
    wave = np.concatenate(([0.0, 0.0], WIDE * np.resize([1.0, -1.0], 2 * COILS), [0.0, 0.0]))
    return np.asarray(ends[0] + share[:, None] * along + wave[:, None] * aside)


def _arc(ends: Array, normal: Array, radius: float) -> Array:
    """Return three quarters of a circle about the axis of a crank, with an arrow's head."""
    along = _arm(ends, radius)
    aside = _across(along, normal) * np.linalg.norm(along)
    angles = np.radians(np.linspace(20.0, 290.0, 40))[:, None]
    ring = ends[0] + np.cos(angles) * along + np.sin(angles) * aside
    back = np.radians(265.0)
    head = [ends[0] + size * (np.cos(back) * along + np.sin(back) * aside) for size in (1.2, 0.8)]
    return np.concatenate((ring, head[:1], ring[-1:], head[1:], ring[-1:]))


def _arm(ends: Array, radius: float) -> Array:
    """Return the way from the axis of a crank to the circle about it, along the crank, (3,)."""
    along = ends[1] - ends[0]
    return np.asarray(along * min(0.35, radius / max(float(np.linalg.norm(along)), 1e-300)))


def _across(along: Array, normal: Array) -> Array:
    """Return the unit vector square to a direction and to a normal."""
    aside = np.cross(normal, along)
    length = float(np.linalg.norm(aside))
    if length < 1e-9 * float(np.linalg.norm(along)):
        aside = np.cross(np.eye(3)[int(np.argmin(np.abs(along)))], along)
        length = float(np.linalg.norm(aside))
    return np.asarray(aside / length)
