"""The five dimensions of a car: as measured, and as locked while a sketch is solved.

Length, width and height are those of the box about the body, the height from the ground. The
front overhang leads from the foremost point of the body to the centre of the front wheel, the
wheelbase from there to the centre of the rear wheel. In a symmetric car all five are linear in the
variables once the outermost nodes are known. So a dimension can be locked while the shape is
solved: as an equation, and one inequality for every node that must not pass the outermost one.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.errors import UserError
from bozzetto_car.template.model import Template

WORDS: Final = {
    "length": "length",
    "width": "width",
    "height": "height",
    "front_overhang": "front overhang",
    "wheelbase": "wheelbase",
}
"""The names of the dimensions in messages."""

SHORTEST: Final = 100.0
"""Least dimension, mm: a smaller number was probably meant in other units."""

LONGEST: Final = 50_000.0
"""Greatest dimension, mm."""

TIED: Final = 1e-6
"""Distance, mm, at which a node counts as far out as the outermost one."""


@dataclass(frozen=True)
class Dimensions:
    """Dimensions of a car, mm; None where a dimension is not given."""

    length: float | None = None
    width: float | None = None
    height: float | None = None
    front_overhang: float | None = None
    wheelbase: float | None = None

    def given(self) -> dict[str, float]:
        """Return the dimensions that are given, by name."""
        values = ((field.name, getattr(self, field.name)) for field in fields(self))
        return {name: float(value) for name, value in values if value is not None}

    def wanted(self) -> dict[str, float]:
        """Return the dimensions that are given, checked.

        Raises
        ------
        UserError
            If one is not a length that a car can have.
        """
        given = self.given()
        for name, value in given.items():
            if not SHORTEST <= value <= LONGEST:
                raise UserError(
                    f"A car cannot have a {WORDS[name]} of {value:g} mm. Give one from "
                    f"{SHORTEST:g} to {LONGEST:g} mm."
                )
        return given


def measure_dimensions(box: Array, front: float, rear: float) -> Dimensions:
    """Return the dimensions of a body.

    Parameters
    ----------
    box : (2, 3) float
        Least and greatest coordinates of its surface, mm.
    front, rear : float
        x of the centres of the wheels, mm.
    """
    (x, y, _), (end, side, top) = box.tolist()
    return Dimensions(end - x, side - y, top, float(front) - x, float(rear - front))


@dataclass(frozen=True)
class Overlap:
    """Distances by which the surface bulges out beyond the outermost nodes, mm."""

    front: float = 0.0
    rear: float = 0.0
    side: float = 0.0
    top: float = 0.0

    @classmethod
    def of(cls, template: Template, positions: Array, box: Array) -> Overlap:
        """Return by how much the box (2, 3) of a surface exceeds its nodes (n, 3), mm."""
        body = positions[_body(template)]
        low, high = box - (body.min(axis=0), body.max(axis=0))
        return cls(-float(low[0]), float(high[0]), float(high[1]), float(high[2]))


NONE_BEYOND: Final = Overlap()
"""No bulge: the dimensions are those of the nodes."""


@dataclass(frozen=True, eq=False)
class Locks:
    """Known dimensions over the variables of a symmetric car.

    Attributes
    ----------
    rows : (k, q) float
    values : (k,) float
        ``rows @ variables == values``, mm.
    bounds : (m, q) float
        ``bounds @ variables >= 0``: no node lies beyond the outermost ones.
    outermost : (4,) int
        The foremost, rearmost, widest and highest node.
    """

    rows: Array
    values: Array
    bounds: Array
    outermost: tuple[int, int, int, int]

    @classmethod
    def of(
        cls,
        template: Template,
        wanted: Dimensions,
        variables: Array,
        overlap: Overlap = NONE_BEYOND,
        instead: tuple[int, int, int, int] | None = None,
    ) -> Locks:
        """Lock dimensions.

        Parameters
        ----------
        template : Template
            The template of the car.
        wanted : Dimensions
            The dimensions to lock.
        variables : (q,) float
            A car of about that shape: it says which nodes are outermost.
        overlap : Overlap
            By which the dimensions of the surface exceed those of the nodes.
        instead : (int, int, int, int), optional
            The outermost nodes, where they are known already.

        Raises
        ------
        UserError
            If a dimension is not a length that a car can have.
        """
        body = _body(template)
        outermost = instead or _outermost(template.whole(variables), body)
        foremost, rearmost, widest, highest = outermost
        (front, _), (rear, _) = template.wheels.tolist()

        def coordinate(node: int, axis: int) -> Array:
            return np.asarray(template.basis[3 * node + axis])

        given = wanted.wanted()
        across = [
            ("length", rearmost, foremost, 0, overlap.front + overlap.rear),
            ("front_overhang", front, foremost, 0, overlap.front),
            ("wheelbase", rear, front, 0, 0.0),
        ]
        rows, values = [], []
        for name, ahead, behind, axis, more in across:
            if name in given:
                rows.append(coordinate(ahead, axis) - coordinate(behind, axis))
                values.append(given[name] - more)
        for name, node, axis, factor, more in (
            ("width", widest, 1, 2.0, 2.0 * overlap.side),
            ("height", highest, 2, 1.0, overlap.top),
        ):
            if name in given:
                rows.append(factor * coordinate(node, axis))
                values.append(given[name] - more)
        bounds = []
        for names, node, axis, sign in (
            (("length", "front_overhang"), foremost, 0, 1.0),
            (("length",), rearmost, 0, -1.0),
            (("width",), widest, 1, -1.0),
            (("height",), highest, 2, -1.0),
        ):
            if given.keys() & set(names):
                others = [number for number in body.tolist() if number != node]
                bounds += [sign * (coordinate(i, axis) - coordinate(node, axis)) for i in others]
        count = len(template.variables)
        # A node and its image, and nodes at y = 0, give zero rows or equal rows.
        told = np.unique(np.reshape(bounds, (-1, count)), axis=0)
        return cls(
            np.reshape(rows, (-1, count)),
            np.array(values),
            told[told.any(axis=1)],
            outermost,
        )

    def tied(self, template: Template, variables: Array) -> tuple[int, int, int, int] | None:
        """Other outermost nodes that a car has as well; None if there are no others."""
        positions = template.whole(variables)
        body = _body(template)
        found = list(self.outermost)
        for place, (axis, sign) in enumerate(((0, -1.0), (0, 1.0), (1, 1.0), (2, 1.0))):
            reach = sign * positions[body, axis]
            twins = {self.outermost[place], int(template.mirrored[self.outermost[place]])}
            if axis == 1:
                twins = {self.outermost[place]}
            level = body[reach >= sign * positions[self.outermost[place], axis] - TIED]
            others = [number for number in level.tolist() if number not in twins]
            if others:
                found[place] = others[0]
        made = found[0], found[1], found[2], found[3]
        return made if made != self.outermost else None


def _body(template: Template) -> Index:
    """Nodes of the body: all but the centres of the wheels."""
    return np.setdiff1d(np.arange(len(template.names)), template.wheels)


def _outermost(positions: Array, body: Index) -> tuple[int, int, int, int]:
    places = positions[body]
    first, last = int(places[:, 0].argmin()), int(places[:, 0].argmax())
    widest, highest = int(places[:, 1].argmax()), int(places[:, 2].argmax())
    found = body[[first, last, widest, highest]].tolist()
    return found[0], found[1], found[2], found[3]
