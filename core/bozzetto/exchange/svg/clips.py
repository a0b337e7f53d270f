"""Clips and masks of SVG: which lines they hide altogether, and which they may cut."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from bozzetto.arrays import Array
from bozzetto.cached_properties import cached_property
from bozzetto.exchange.safe_xml import Element
from bozzetto.exchange.svg.clip_regions import Region, Rule
from bozzetto.exchange.svg.outlined_elements import LONGEST_LENGTH, outline
from bozzetto.exchange.svg.path_data import Subpath, flatten
from bozzetto.exchange.svg.style import Properties

REFERENCE: Final = re.compile(r"\s*+url\(\s*+[\"']?#([^\"')\s]+)")

MAX_SHAPES: Final = 1_000
"""Shapes of one clip that are looked at."""

MAX_NESTED: Final = 8
"""Clips of clips that are looked at."""

KNOWN: Final = frozenset(("path", "rect", "circle", "ellipse", "line", "polyline", "polygon"))
"""Elements whose outline is known; letters and what is repeated may let through anything."""

PASSED_OVER: Final = frozenset(("title", "desc", "metadata"))

FINENESS: Final = 1e-4
"""Greatest distance of a chord from the border of a clip, as a share of its diagonal."""

ROUNDED: Final = 1e-6
"""Distance of a corner from the box around a clip, as a share of it, that comes from rounding."""

Box = tuple[float, float, float, float]
"""Least x and y, largest x and y."""


def named_clip(text: str) -> str:
    """Return the id that the value of a ``clip-path`` or ``mask`` names, or ""."""
    found = REFERENCE.match(text) if len(text) <= LONGEST_LENGTH else None
    return found[1] if found else ""


def box_of(path: Subpath) -> Box | None:
    """Return a box around the control points of a path; None if it has none."""
    points = path.cubics.reshape(-1, 2)
    if not len(points):
        return None
    (left, top), (right, bottom) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return left, top, right, bottom


class Own(Protocol):
    """Attributes that an element gives itself."""

    @property
    def properties(self) -> Properties:
        """Properties of its look."""

    @property
    def matrix(self) -> Array | None:
        """Its transform (3, 3), if it has one."""


@dataclass(frozen=True, eq=False)
class Clip:
    """Measured clip: once, however many parts of a drawing it cuts.

    Parameters
    ----------
    corners : (4, 2) float or None
        Of a box around it, in the user units of what is clipped, one after another; None where it
        is not known what it lets through, as that of a mask.
    is_rectangle : bool
        Whether it lets through all of that box.
    shapes : tuple of (tuple of (n, 2) arrays, rule)
        The rings of what it lets through, and what counts as their inside.
    within : Clip, optional
        What clips it in turn.
    """

    corners: Array | None
    is_rectangle: bool = False
    shapes: tuple[tuple[tuple[Array, ...], Rule], ...] = ()
    within: Clip | None = None

    @classmethod
    def of(
        cls,
        target: Element,
        own_of: Callable[[Element], Own],
        named: Mapping[str, Element],
        page: tuple[float, float] | None,
        depth: int = 0,
    ) -> Clip:
        """Measure a ``clipPath`` or ``mask``.

        Parameters
        ----------
        target : Element
            It.
        own_of : callable
            Gives what an element says of itself.
        named : mapping of str to Element
            Elements by their ids.
        page : (width, height), optional
            What percentages are of, user units.
        depth : int
            How many clips it clips in turn.
        """
        children = [child for child in target.children if child.tag not in PASSED_OVER]
        plain = target.attributes.get("clipPathUnits", "userSpaceOnUse") == "userSpaceOnUse"
        if target.tag == "mask" or not plain or len(children) > MAX_SHAPES or depth > MAX_NESTED:
            return cls(None)
        outer = own_of(target)
        within = None
        if named_clip(outer.properties.get("clip-path", "")):
            other = named.get(named_clip(outer.properties.get("clip-path", "")))
            within = None if other is None else cls.of(other, own_of, named, page, depth + 1)
            if within is not None and within.corners is None:
                return cls(None)
        paths: list[tuple[list[Subpath], Rule]] = []
        for child in children:
            own = own_of(child)
            if own.properties.get("display") == "none":
                continue
            if child.tag not in KNOWN or named_clip(own.properties.get("clip-path", "")):
                return cls(None)
            turn = np.eye(3)
            for matrix in (outer.matrix, own.matrix):
                turn = turn if matrix is None else turn @ matrix
            said = own.properties.get("clip-rule", outer.properties.get("clip-rule", ""))
            rule: Rule = "evenodd" if said.strip() == "evenodd" else "nonzero"
            paths.append((
                [Subpath(path.cubics @ turn[:2, :2].T + turn[:2, 2], path.closed)
                 for path in outline(child, page) if len(path.cubics)],
                rule,
            ))  # fmt: skip
        places = [path.cubics.reshape(-1, 2) for own_paths, _ in paths for path in own_paths]
        if not places:
            return cls(np.full((4, 2), np.nan))  # what lets nothing through
        low, high = (end(np.concatenate(places), axis=0) for end in (np.min, np.max))
        fine = max(FINENESS * float(np.linalg.norm(high - low)), 1e-300)
        shapes = tuple(
            (tuple(flatten(path, fine) for path in own_paths), rule) for own_paths, rule in paths
        )
        corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
        alone = len(places) == 1 and within is None and children[0].tag == "rect"
        return cls(corners, alone and _on_sides(places[0], low, high), shapes, within)

    @cached_property
    def size(self) -> int:
        """How many corners it has, with those of what clips it."""
        own = sum(len(ring) for rings, _ in self.shapes for ring in rings)
        return own + (0 if self.within is None else self.within.size)

    def region(self, matrix: Array) -> Region:
        """Return what it lets through under a transform (3, 3).

        Raises
        ------
        TooManyPairs
            If its borders are a tangle.
        """
        shapes = [
            ([ring @ matrix[:2, :2].T + matrix[:2, 2] for ring in rings], rule)
            for rings, rule in self.shapes
        ]
        within = None if self.within is None else self.within.region(matrix)
        return Region.of(shapes, within)

    def look(self, matrix: Array) -> tuple[Box, bool] | None:
        """Return the box around it under a transform (3, 3), and whether that is all of it."""
        if self.corners is None:
            return None
        if np.isnan(self.corners).any():
            return (np.inf, np.inf, -np.inf, -np.inf), False
        places = self.corners @ matrix[:2, :2].T + matrix[:2, 2]
        low, high = places.min(axis=0), places.max(axis=0)
        (left, top), (right, bottom) = low.tolist(), high.tolist()
        exact = self.is_rectangle and _on_sides(places, low, high)
        return (left, top, right, bottom), exact


def lies_apart(one: Box, other: Box) -> bool:
    """Whether two boxes have nothing in common."""
    return one[0] > other[2] or one[2] < other[0] or one[1] > other[3] or one[3] < other[1]


def lies_within(one: Box, other: Box) -> bool:
    """Whether a box lies in another one, but for rounding."""
    slack = ROUNDED * max(other[2] - other[0], other[3] - other[1])
    starts = one[0] >= other[0] - slack and one[1] >= other[1] - slack
    return starts and one[2] <= other[2] + slack and one[3] <= other[3] + slack


def _on_sides(places: Array, low: Array, high: Array) -> bool:
    """Whether places lie on the sides of the box around them, as the corners of it do."""
    off = np.minimum(np.abs(places - low), np.abs(places - high))
    return bool((off.min(axis=1) <= ROUNDED * float(np.max(high - low))).all())
