"""Networks of curves by the points that they run through, with the surfaces that are meant."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Joint, Meeting
from bozzetto_product.model.planes import Plane
from bozzetto_product.network.cutting import net_of
from bozzetto_product.network.net import Loop, Net

PLANE = Plane((0.0, 0.0, 0.0), (0.0, 1.0, 0.0))

Place = str | tuple[float, float, float]


@dataclass
class Sketch:
    """Curves through named nodes, and the surfaces between them.

    Names of nodes with a ' are their mirror images. A face is written "a b c", each name that of
    a node; "b(k)" says that b is come to along the curve k.
    """

    mirror: bool = False
    nodes: dict[str, Array] = field(default_factory=dict)
    curves: dict[str, tuple[tuple[str | Array, ...], bool, bool]] = field(default_factory=dict)
    faces: list[str] = field(default_factory=list)

    def node(self, **places: ArrayLike) -> None:
        for name, place in places.items():
            self.nodes[name] = np.asarray(place, float)

    def curve(
        self, *through: str | ArrayLike, name: str = "", closed: bool = False, across: bool = False
    ) -> None:
        """Add a curve through nodes and places; a string of names stands for several."""
        places: list[str | Array] = []
        for each in through:
            if isinstance(each, str):
                places += each.split()
            else:
                places.append(np.asarray(each, float))
        name = name or f"c{len(self.curves)}"
        flat = all(abs(self.place(each)[1]) < 1e-12 for each in places)
        mirrored = self.mirror and not across and not flat
        self.curves[name] = (tuple(places), closed, mirrored)

    def face(self, *faces: str) -> None:
        self.faces += faces

    def place(self, place: str | Array) -> Array:
        if not isinstance(place, str):
            return place
        name = place.removesuffix("'")
        return self.nodes[name] * ([1, -1, 1] if place.endswith("'") else 1)

    def built(self) -> tuple[list[Curve], list[Joint]]:
        """Return the curves and joints of a product."""
        curves, meetings = [], {name: [] for name in self.nodes}
        for name, (places, closed, mirrored) in self.curves.items():
            points = np.array([self.place(each) for each in places])
            spline, at = interpolated(points, closed)
            curves.append(Curve(id=name, spline=spline, mirrored=mirrored))
            for place, share in zip(places, at, strict=True):
                if isinstance(place, str) and (not place.endswith("'") or mirrored):
                    flipped = place.endswith("'")
                    meetings[place.removesuffix("'")].append(Meeting(name, share, flipped))
        joints = [
            Joint(name, tuple(met), self.mirror and abs(self.nodes[name][1]) < 1e-12)
            for name, met in meetings.items()
            if met
        ]
        return curves, joints

    def net(self) -> Net:
        return net_of(*self.built(), PLANE)

    def truth(self, net: Net, strict: bool = True) -> list[frozenset[int]]:
        """Return the edges of each face that is meant, mirror images included.

        If not strict, a face that the net cannot close, as a joint is missing, is an empty set.
        """
        found: dict[frozenset[int], None] = {}
        lost = 0
        for face in self.faces:
            for mirrored in (False, True) if self.mirror else (False,):
                edges = self._edges(net, face, mirrored)
                assert edges or not strict, face
                lost += not edges
                if edges:
                    found.setdefault(edges)
        return [*found, *[frozenset()] * lost]

    def _edges(self, net: Net, face: str, mirrored: bool) -> frozenset[int]:
        """Return the edges of a face; none if one is not there."""
        names = {joint: node for node, joint in enumerate(net.joints)}
        steps = [re.fullmatch(r"([^()]+)(?:\((.+)\))?", each).groups() for each in face.split()]
        nodes = []
        for name, _ in steps:
            flipped = name.endswith("'") != mirrored
            bare = name.removesuffix("'")
            nodes.append(names.get((bare, flipped), names.get((bare, False))))
        edges = set()
        for number, (_, curve) in enumerate(steps):
            ends = {nodes[number - 1], nodes[number]}
            fits = [
                i
                for i, edge in enumerate(net.edges)
                if {edge.start, edge.end} == ends
                and (curve is None or edge.curve == curve)
                and not (curve and len(steps) == 1 and edge.mirrored != mirrored)
            ]
            if len(fits) > 1:
                fits = [i for i in fits if net.edges[i].mirrored == mirrored] or fits
            assert len(fits) <= 1, f"{face}: {len(fits)} edges to {steps[number]}"
            if not fits:
                return frozenset()
            edges.add(fits[0])
        return frozenset(edges)


def interpolated(points: Array, closed: bool = False) -> tuple[Spline, Array]:
    """Return a cubic curve through points, and the share of its range at each of them."""
    around = np.vstack((points, points[:1])) if closed else points
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(around, axis=0), axis=1))))
    along /= along[-1]
    if closed:
        made = make_interp_spline(along, around, k=3, bc_type="periodic")
        return Spline(made.t, made.c, closed=True), along[:-1]
    at, through = along, around
    if len(points) < 4:
        at = np.linspace(0.0, 1.0, 4)
        through = make_interp_spline(along, around, k=len(points) - 1)(at)
    made = make_interp_spline(at, through, k=3)
    return Spline(made.t, made.c), along


def edge_set(loop: Loop) -> frozenset[int]:
    return frozenset(edge for edge, _ in loop)


@dataclass(frozen=True)
class Score:
    """How loops that were found agree with those that are meant.

    An extra whose edges all had room beside what is meant is an opening that nobody closed.
    """

    right: int
    meant: int
    wrong: int
    openings: int

    @classmethod
    def of(cls, found: Iterable[frozenset[int]], meant: Sequence[frozenset[int]]) -> Score:
        found = set(found)
        use: dict[int, int] = {}
        meant = list(meant)
        for each in meant:
            for edge in each:
                use[edge] = use.get(edge, 0) + 1
        extras = [each for each in found if each not in set(meant)]
        openings = [each for each in extras if all(use.get(edge, 0) < 2 for edge in each)]
        return cls(len(found & set(meant)), len(meant), len(extras) - len(openings), len(openings))

    @property
    def recall(self) -> float:
        return self.right / max(1, self.meant)

    @property
    def precision(self) -> float:
        return self.right / max(1, self.right + self.wrong)

    @property
    def f1(self) -> float:
        both = self.precision + self.recall
        return 2 * self.precision * self.recall / both if both else 0.0
