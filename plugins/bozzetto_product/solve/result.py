"""The solved product."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from bozzetto.geometry import Mesh
from bozzetto.plugin import cached_property
from bozzetto_product.details.bodies import DetailedBodies
from bozzetto_product.details.shell import Owner
from bozzetto_product.fill.fill import Fill
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.paper.paper_surface import PaperSurface
from bozzetto_product.shaping.wall import Wall
from bozzetto_product.solve.canvas import Canvas
from bozzetto_product.solve.gaps import Gap


@dataclass(frozen=True, eq=False)
class SolvedPatch:
    """A patch of the recipe, or its mirror image, with its surface.

    Parameters
    ----------
    patch : Patch
    mirrored : bool
        It is the mirror image.
    loop : Loop
        In the net, counter-clockwise seen from outside.
    surface : Fill or PaperSurface, optional
        None where there is no sound surface.
    problem : str
        Why there is none, for a person.
    limited : bool
        It holds less than its pressure asks for, or it would come off its smooth edges.
    pull_problem : str
        Why it does not follow a stroke that pulls it, for a person.
    asked_smooth : tuple of bool
        For each half edge, whether the network asks for a smooth joint there.
    """

    patch: Patch
    mirrored: bool
    loop: Loop
    surface: Fill | PaperSurface | None
    problem: str = ""
    limited: bool = False
    pull_problem: str = ""
    asked_smooth: tuple[bool, ...] = ()

    @property
    def fill(self) -> Fill | None:
        """The surface if it is exact; None where there is none, or it is of triangles only."""
        return self.surface if isinstance(self.surface, Fill) else None

    @property
    def mesh(self) -> Mesh | None:
        """Triangles of the surface; None where there is none."""
        return None if self.surface is None else self.surface.mesh

    def is_smooth_at(self, half_edge: int) -> bool:
        """Whether the surface is to be smooth at a half edge of the loop."""
        if self.fill is None:
            return self.asked_smooth[half_edge]
        return bool(np.isfinite(self.fill.g1_degrees[half_edge]))

    @property
    def creased(self) -> tuple[int, ...]:
        """Half edges at which it has a crease, because it would fold if it were smooth as asked."""
        if self.fill is None:
            return ()
        held = {
            piece.half_edge
            for side in self.fill.sides
            for half in side.halves
            for piece in half.pieces
            if piece.field is not None
        }
        return tuple(k for k, asked in enumerate(self.asked_smooth) if asked and k not in held)

    @property
    def name(self) -> str:
        """Name for people and files."""
        return f"{self.patch.name} mirrored" if self.mirrored else self.patch.name


@dataclass(frozen=True, eq=False)
class WalledBody:
    """Patches that hang together, and the body of walls that they make.

    Parameters
    ----------
    patches : tuple of SolvedPatch
    wall : Wall, optional
        None where the wall is too thick.
    owners : tuple of Owner
        What the surfaces belong to that `Wall.groups` counts; patches are numbers of
        `ProductResult.filled`, details those of `ProductResult.detailed`.
    left_out : bool
        Cuts do not go through walls that grow outward: they are left out.
    """

    patches: tuple[SolvedPatch, ...]
    wall: Wall | None
    owners: tuple[Owner, ...] = ()
    left_out: bool = False

    @property
    def opened(self) -> frozenset[int]:
        """Numbers of the details that go through the walls."""
        if self.wall is None:
            return frozenset()
        own = {number for number, own, _ in self.wall.groups if own}
        return frozenset(self.owners[k].detail for k in own if self.owners[k].made)


@dataclass(frozen=True, eq=False)
class ProductResult:
    """Curves cut at their joints, and the surfaces between them.

    Parameters
    ----------
    curves : tuple of Curve
        Where they are now, for they may follow other models.
    canvases : tuple of Canvas
        What is drawn on.
    net : Net
    patches : tuple of SolvedPatch
        Those that are shown, in the order of the parts; a mirror image after its patch.
    lost : tuple of Patch
        Of which curves or joints are gone, or do not close.
    walls : tuple of WalledBody
        One for each part that hangs together; none where no walls are asked for, or in a preview.
    let_go : frozenset of str
        Ids of curves that gave way to a fair surface; they were drawn elsewhere.
    kept : tuple of str
        Names of groups of which the curves could not, or not all, be let go.
    detailed : DetailedBodies
        The surfaces with details; its grounds are `filled`, in that order. No shells where there
        are no details.
    gaps : tuple of Gap
        Ends of curves that nearly meet something, narrowest first; none in a preview.
    """

    curves: tuple[Curve, ...]
    canvases: tuple[Canvas, ...]
    net: Net
    patches: tuple[SolvedPatch, ...]
    lost: tuple[Patch, ...] = ()
    walls: tuple[WalledBody, ...] = ()
    let_go: frozenset[str] = frozenset()
    kept: tuple[str, ...] = ()
    detailed: DetailedBodies = DetailedBodies()
    gaps: tuple[Gap, ...] = ()

    @property
    def filled(self) -> tuple[SolvedPatch, ...]:
        """The patches that have a surface."""
        return tuple(one for one in self.patches if one.surface is not None)

    @property
    def is_exact(self) -> bool:
        """Whether the surfaces have exact patches: those as in the paper are triangles only."""
        return not any(isinstance(one.surface, PaperSurface) for one in self.patches)

    @cached_property
    def uses(self) -> tuple[int, ...]:
        """How many surfaces each edge of the net has."""
        counts = np.zeros(len(self.net.edges), int)
        for one in self.filled:
            for edge, _ in one.loop:
                counts[edge] += 1
        return tuple(counts.tolist())

    @property
    def open_edges(self) -> tuple[int, ...]:
        """Edges with one surface only."""
        return tuple(number for number, count in enumerate(self.uses) if count == 1)

    @property
    def is_closed(self) -> bool:
        """Whether the surfaces enclose a volume: every edge of them has two, one each way."""
        whole = bool(self.filled) and all(count in (0, 2) for count in self.uses)
        return whole and not self.one_sided

    @cached_property
    def one_sided(self) -> bool:
        """Whether surfaces cannot be turned alike, as those of a Möbius strip."""
        runs = Counter(run for one in self.filled for run in one.loop)
        return any(self.uses[edge] == 2 and count == 2 for (edge, _), count in runs.items())

    @property
    def size(self) -> float:
        """Diagonal of the box around the curves, mm; 1 where there are none."""
        points = [c.spline.control_points for c in self.curves if c.spline is not None]
        if not points:
            return 1.0
        return float(np.linalg.norm(np.ptp(np.vstack(points), axis=0))) or 1.0
