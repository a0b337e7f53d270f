"""How fast normals turn about edges at corners, so that two edges agree on one surface.

At a corner both edges tell the mixed entry of the surface's second fundamental form. With e the
unit tangents that leave the corner, θ the angle between them, κ their normal curvatures and τ the
geodesic torsions (Do Carmo 1976, *Differential Geometry of Curves and Surfaces*, section 3-2), they
agree if

    τ_a + τ_b = (κ_b - κ_a) cot θ.

Where they do not, no surface with a continuous twist is tangent to both fields of normals.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.plugin import remembered
from bozzetto_product.fill.even_torsion import (
    EdgeEnd,
    OpenFan,
    even_torsions,
    middle_turn,
)
from bozzetto_product.fill.normal_field import NormalField

MOST_CHANGE: Final = 1.5
"""Most that the torsion at an end changes, in radians by the edge's length: drawn curves may be
hooked at their ends, and tell curvatures there that no one meant."""


@dataclass(frozen=True, eq=False)
class TwistCorner:
    """A corner at which two edges with normals meet.

    Parameters
    ----------
    leave, enter : EdgeEnd
        Of the edge that the loop takes on from the corner, and of the one it comes by.
    out, back : (3,) float
        Unit tangents that leave the corner along both.
    normal : (3,) float
        Unit, of the plane of both.
    """

    leave: EdgeEnd
    enter: EdgeEnd
    out: Array
    back: Array
    normal: Array

    def angle_about(self, normal: Array) -> tuple[float, float]:
        """Return cosine and sine of the angle from `out` to `back` about a normal."""
        return float(self.out @ self.back), float(cross_product(self.out, self.back) @ normal)

    def wanted(self, fields: Mapping[int, NormalField]) -> float:
        """Return the sum of both torsions that agrees with both curvatures, radians by mm."""
        cosine = float(self.out @ self.back)
        sine = float(cross_product(self.out, self.back) @ self.normal)
        bends = [
            float(fields[edge].end_curvatures[end] @ self.normal)
            for edge, end in (self.leave, self.enter)
        ]
        return (bends[1] - bends[0]) * cosine / sine


@remembered(limit=4000, key=lambda field, changes, turn=0.0: (field, changes.tobytes(), turn))
def with_torsions(field: NormalField, changes: Array, turn: float = 0.0) -> NormalField:
    """Return a field whose torsions at start and end are changed, (2,); its end normals stay.

    In between it turns about its curve by the cubic polynomial of the length of these slopes, and
    by `turn` radians more in the middle.
    """
    if not changes.any() and turn == 0.0:
        return field
    length = field.length

    def angles(share: Array) -> Array:
        rest = 1.0 - share
        cubic = length * share * rest * (changes[0] * rest - changes[1] * share)
        return np.asarray(cubic + turn * middle_turn(share))

    return field.turned(angles)


def agreeing(
    fields: Mapping[int, NormalField],
    fans: Iterable[list[TwistCorner]],
    told: Mapping[int, Array],
) -> dict[int, NormalField]:
    """Return fields of edges of which the torsions agree at corners, with least changes.

    What that leaves open is chosen by `even_torsions`.

    Parameters
    ----------
    fields : mapping of int to NormalField
        Of each edge.
    fans : iterable of list of TwistCorner
        Corners that edges with normals link; each list is solved alone.
    told : mapping of int to (17,) array
        See `even_torsions`.
    """
    torsions = {edge: field.end_torsions for edge, field in fields.items()}
    changes = {edge: np.zeros(2) for edge in fields}
    left_open = []
    for fan in fans:
        ends = sorted({end for corner in fan for end in (corner.leave, corner.enter)})
        column = {end: number for number, end in enumerate(ends)}
        rows = np.zeros((len(fan), len(ends)))
        lacks = np.empty(len(fan))
        for number, corner in enumerate(fan):
            rows[number, column[corner.leave]] += 1.0
            rows[number, column[corner.enter]] += 1.0
            held = sum(torsions[edge][end] for edge, end in (corner.leave, corner.enter))
            lacks[number] = corner.wanted(fields) - held
        for (edge, end), change in zip(ends, _inverse(rows) @ lacks, strict=True):
            changes[edge][end] = _at_most(change, fields[edge])
        left_open += [
            OpenFan(
                dict(zip(part, senses, strict=True)),
                fan[0].normal,
                [
                    (corner.leave, corner.enter, *corner.angle_about(fan[0].normal))
                    for corner in fan
                    if corner.leave in part
                ],
            )
            for part, senses in _open_senses(fan, ends)
        ]
    further = even_torsions(fields, changes, left_open, told)
    return {
        edge: with_torsions(
            field, _at_most(changes[edge] + further[edge][:2], field), float(further[edge][2])
        )
        for edge, field in fields.items()
    }


@remembered(limit=256, key=lambda rows: (rows.shape, rows.tobytes()))
def _inverse(rows: Array) -> Array:
    """Return what takes sums at corners to the least torsions: alike nodes have the same."""
    return np.asarray(np.linalg.pinv(rows, rcond=1e-9))


def _at_most(change: Array, field: NormalField) -> Array:
    most = MOST_CHANGE / max(field.length, 1e-300)
    return np.clip(change, -most, most)


def _open_senses(
    fan: list[TwistCorner], ends: list[EdgeEnd]
) -> list[tuple[list[EdgeEnd], list[float]]]:
    """Return ends that corners link, and the change of their torsions that no corner feels.

    Along a row of corners the signs take turns. Round a node with an odd number of corners there is
    no such change: three curvatures tell the torsion.
    """
    links: dict[EdgeEnd, list[EdgeEnd]] = {end: [] for end in ends}
    for corner in fan:
        links[corner.leave].append(corner.enter)
        links[corner.enter].append(corner.leave)
    made = []
    seen: set[EdgeEnd] = set()
    for start in ends:
        if start in seen:
            continue
        senses = {start: 1.0}
        waiting, is_open = [start], True
        while waiting:
            here = waiting.pop()
            for other in links[here]:
                if other not in senses:
                    senses[other] = -senses[here]
                    waiting.append(other)
                is_open &= senses[other] == -senses[here]
        seen.update(senses)
        made.append((list(senses), [sense if is_open else 0.0 for sense in senses.values()]))
    return made
