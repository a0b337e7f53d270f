"""A template: a car as nodes, cubic edges and four-sided patches, with rules and prompts.

Kara & Shimada (2008) start every car from a template: a symmetric network of curves whose
nodes are *fiducial* points, which a person can find again in a sketch. A `Template` is such a
network as data: `loader` reads it, `validation` finds its faults, `shape_constraints` turns its
rules into inequalities.

World: x rearward from the nose, y to the right, z up from the ground, mm; the plane of
symmetry is y = 0.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, Literal

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry import frozen
from bozzetto.plugin import cached_property

MIRROR: Final = np.array([1.0, -1.0, 1.0])
"""The reflection in the plane of symmetry, as factors of the coordinates."""

SOUNDS_OPEN: Final = "aeioAEIOFHLMNRSX"
"""First letters of nouns that are spoken with a vowel: words in lower case, and abbreviations."""

AXES: Final = "xyz"
"""Letters of the coordinates, in order."""


def noun_of(title: str) -> str:
    """Return the title of a template within a sentence: “minivan”, but “SUV”."""
    return title if title.isupper() else title.lower()


def article_of(noun: str) -> str:
    """Return the article of a noun: “an” where it is spoken with a vowel, as “SUV” is."""
    return "an" if noun[:1] in SOUNDS_OPEN else "a"


def twin(name: str) -> str:
    """Return the name of the mirror image of a node, patch or chain: ``S1.R`` and ``S1.L``."""
    if name.endswith(".R"):
        return name[:-2] + ".L"
    return name[:-2] + ".R" if name.endswith(".L") else name


@dataclass(frozen=True)
class ViewHint:
    """The direction from which a node is seen best on the small car of the guide panel.

    Attributes
    ----------
    azimuth : float
        Degrees: 0 looks at the nose, 90 at the right side, 180 at the tail, -90 at the left.
    elevation : float
        Degrees above the horizon.
    patches : tuple of str
        Names of the patches to tint: the part of the body that the prompt speaks of.
    """

    azimuth: float
    elevation: float
    patches: tuple[str, ...] = ()

    @property
    def toward_eye(self) -> Array:
        """The unit vector from the car to the eye, (3,)."""
        turn, rise = np.radians(self.azimuth), np.radians(self.elevation)
        flat = np.cos(rise)
        return np.array([-flat * np.cos(turn), flat * np.sin(turn), np.sin(rise)])


@dataclass(frozen=True)
class Patch:
    """A four-sided part of the body; seen from outside its nodes run anticlockwise.

    Attributes
    ----------
    name : str
    edges : (int, int, int, int)
        Edges around the patch; ``~edge`` where one runs against the direction around it.
    nodes : (int, int, int, int)
        The edge ``edges[i]`` leads from ``nodes[i]`` to the next. With u from ``nodes[0]``
        to ``nodes[1]`` and v from ``nodes[0]`` to ``nodes[3]``, x_u × x_v points outward.
    glass : bool
        Whether it is the frame of a window.
    """

    name: str
    edges: tuple[int, int, int, int]
    nodes: tuple[int, int, int, int]
    glass: bool = False


InsetKind = Literal["headlamp", "tail lamp", "grille"]
"""What is let into the body beside windows."""


@dataclass(frozen=True)
class Inset:
    """A lamp or a grille of the right half; of one over the middle of the car, its right half.

    Attributes
    ----------
    name : str
    patch : str
        Name of the patch that it is let into.
    kind : {"headlamp", "tail lamp", "grille"}
    box : ((float, float), (float, float))
        Lowest and highest u, lowest and highest v.
    """

    name: str
    patch: str
    kind: InsetKind
    box: tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Chain:
    """Edges that follow each other and make one smooth line.

    Attributes
    ----------
    name : str
    nodes : tuple of int
    edges : tuple of int
        ``edges[i]`` leads from ``nodes[i]`` to ``nodes[i + 1]``; ``~edge`` for the other sense.
    smooth : tuple of int
        The nodes, none of them an end, at which the line has one tangent direction (G1).
    """

    name: str
    nodes: tuple[int, ...]
    edges: tuple[int, ...]
    smooth: tuple[int, ...]


@dataclass(frozen=True)
class Rule:
    """A linear inequality that a sound car keeps: the sum of all terms is not below 0, mm.

    Attributes
    ----------
    name : str
        Name in a designer's words; the rule is switched off and reported by it.
    text : str
        Text of the rule in the file, for example ``C3.x >= C2.x + 50``.
    terms : tuple of (node, axis, factor)
    constant : float
    """

    name: str
    text: str
    terms: tuple[tuple[int, int, float], ...]
    constant: float


@dataclass(frozen=True, eq=False)
class Template:
    """The network of a car before any sketch has shaped it.

    Attributes
    ----------
    id, title, about : str
        Identifier in files; name for people; a description in a sentence or two.
    names : tuple of str, length n
        Names of the nodes: ``C2`` on the plane of symmetry, ``S1.R`` and ``S1.L`` off it.
    positions : (n, 3) float
        Places of the nodes, mm.
    pairs : (p, 2) int
        Nodes off the plane: right, left. The wheels are among them.
    centre : (c,) int
        Nodes on the plane of symmetry.
    wheels : (2, 2) int
        Centres of the wheels: front and rear, each right and left. No edge ends in them.
    edges : (m, 2) int
        Start and end of each edge. Right half and centre first, then the mirror images.
    tangents : (m, 2, 3) float
        Derivatives of the cubic edge by its parameter 0 … 1 at its start and its end, mm.
    patches : tuple of Patch
    chains : tuple of Chain
    rules : tuple of Rule
    order : tuple of str
        Order in which marks are asked for. Of a pair, ``S1.near`` is the node on the side that
        the sketch shows, ``S1.far`` the other; `asked` gives the nodes.
    titles, prompts : mapping of str to str
        By name of the node: its title, and how to ask for it.
    pictures : mapping of str to ViewHint
    insets : tuple of Inset
        Lamps and grilles of the right half.
    shut_lines : tuple of int
        Edges of the right half along which doors and lids end.
    creases : frozenset of int
        Character creases, of both halves: inner edges over which the surface may break. It is
        smooth over all others.
    """

    id: str
    title: str
    about: str
    names: tuple[str, ...]
    positions: Array
    pairs: Index
    centre: Index
    wheels: Index
    edges: Index
    tangents: Array
    patches: tuple[Patch, ...]
    chains: tuple[Chain, ...]
    rules: tuple[Rule, ...]
    order: tuple[str, ...]
    titles: Mapping[str, str]
    prompts: Mapping[str, str]
    pictures: Mapping[str, ViewHint]
    insets: tuple[Inset, ...] = ()
    shut_lines: tuple[int, ...] = ()
    creases: frozenset[int] = frozenset()

    def __post_init__(self) -> None:
        for name, columns in (("positions", 3), ("pairs", 2), ("wheels", 2), ("edges", 2)):
            kind = np.float64 if name == "positions" else np.intp
            object.__setattr__(self, name, frozen(getattr(self, name), kind, columns))
        object.__setattr__(self, "centre", frozen(self.centre, np.intp))
        object.__setattr__(self, "tangents", frozen(self.tangents, np.float64))
        for name in ("titles", "prompts", "pictures"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))

    # -- names ---------------------------------------------------------------------------------

    @property
    def noun(self) -> str:
        """The title within a sentence; see `noun_of`."""
        return noun_of(self.title)

    @property
    def article(self) -> str:
        """The article of the noun; see `article_of`."""
        return article_of(self.noun)

    @cached_property
    def node(self) -> Mapping[str, int]:
        """The index of each node by its name."""
        return MappingProxyType({name: number for number, name in enumerate(self.names)})

    @cached_property
    def edge_names(self) -> tuple[str, ...]:
        """The names of both ends of each edge, for example ``C1-S1.R``."""
        return tuple(f"{self.names[a]}-{self.names[b]}" for a, b in self.edges)

    def asked(self, near: str = "R") -> tuple[int, ...]:
        """Return the nodes in the order in which their marks are asked for.

        Parameters
        ----------
        near : {"R", "L"}
            The side that the sketch shows.
        """
        sides = {"near": near, "far": "L" if near == "R" else "R"}
        found = []
        for word in self.order:
            name, _, side = word.partition(".")
            found.append(self.node[f"{name}.{sides[side]}" if side else name])
        return tuple(found)

    # -- the network ---------------------------------------------------------------------------

    @cached_property
    def mirrored(self) -> Index:
        """The mirror image of each node, (n,): itself on the plane of symmetry."""
        image = np.arange(len(self.names))
        image[self.pairs[:, 0]], image[self.pairs[:, 1]] = self.pairs[:, 1], self.pairs[:, 0]
        return image

    @cached_property
    def edge_between(self) -> Mapping[tuple[int, int], int]:
        """The edge that leads from one node to another; ``~edge`` for the opposite direction."""
        found: dict[tuple[int, int], int] = {}
        for number, (start, end) in enumerate(self.edges.tolist()):
            found[start, end], found[end, start] = number, ~number
        return MappingProxyType(found)

    @cached_property
    def sides(self) -> Index:
        """The edges around each patch, (k, 4); ``~edge`` where one is run through backwards."""
        return np.array([patch.edges for patch in self.patches], np.intp)

    def edge_of(self, patch: int, side: int) -> int:
        """Return the edge along a side of a patch, whichever way it runs."""
        signed = self.patches[patch].edges[side]
        return max(signed, ~signed)

    @cached_property
    def rim(self) -> frozenset[int]:
        """The edges of one patch: those along the sill."""
        numbers, counts = np.unique(np.maximum(self.sides, ~self.sides), return_counts=True)
        return frozenset(numbers[counts == 1].tolist())

    @cached_property
    def smooth_edges(self) -> Flags:
        """Which edges the surface is smooth over, (m,): those of two patches that are no crease."""
        flags = np.ones(len(self.edges), bool)
        flags[[*self.rim, *self.creases]] = False
        return flags

    @cached_property
    def mirrored_edges(self) -> Index:
        """The mirror image of each edge, (m,); ``~edge`` where it runs the other way.

        An edge on the plane of symmetry is its own image.

        Raises
        ------
        KeyError
            If an edge has no image; `validation.check` reports that in words.
        """
        image = self.mirrored
        return np.array([self.edge_between[image[a], image[b]] for a, b in self.edges], np.intp)

    @cached_property
    def control_points(self) -> Array:
        """The edges as cubic Bezier curves, (m, 4, 3) mm."""
        start, end = self.positions[self.edges[:, 0]], self.positions[self.edges[:, 1]]
        first, last = start + self.tangents[:, 0] / 3.0, end - self.tangents[:, 1] / 3.0
        return np.stack((start, first, last, end), axis=1)

    @cached_property
    def basis(self) -> Array:
        """Symmetric cars as a linear space: positions = basis @ variables, (3 n, q).

        The variables are x and z of every node on the plane and x, y, z of every right node
        off it, mm, in the order of the nodes; the left nodes follow exactly, because the
        rows hold only 0, 1 and -1. These are the reduced variables of the deformation: 63 for
        the sedan.
        """
        columns = []
        image = self.mirrored
        right = set(self.pairs[:, 0].tolist())
        middle = set(self.centre.tolist())
        for number in range(len(self.names)):
            for axis in range(3):
                if number in right or (number in middle and axis != 1):
                    column = np.zeros((len(self.names), 3))
                    column[image[number], axis] = MIRROR[axis]
                    column[number, axis] = 1.0
                    columns.append(column.ravel())
        return np.stack(columns, axis=1)

    @cached_property
    def variables(self) -> Array:
        """The template's own variables, (q,): ``basis @ variables`` are its positions."""
        return self.reduced(self.positions)

    def reduced(self, positions: Array) -> Array:
        """Return the variables (q,) of a symmetric car with the given positions (n, 3), mm."""
        return np.asarray(np.ravel(positions)[np.argmax(self.basis == 1.0, axis=0)])

    def whole(self, variables: Array) -> Array:
        """Return the positions (n, 3), mm, of the car with the given variables (q,)."""
        return np.asarray((self.basis @ variables).reshape(-1, 3))
