"""The recipe of a silhouette model: a tree of outlines on sheets, and how each swells.

The nodes stand in one row, in the order in which they are put together: each is combined by
its operation with everything before it in the same group. Ink is never replaced by what was
made of it, so any old stroke can be drawn again.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray

from bozzetto.geometry import Placement, frozen
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Group as PlainGroup
from bozzetto.plugin import Parameter, PartsState
from bozzetto.plugin import Part as PlainPart
from bozzetto_silhouette.model.paint_stroke import Color, PaintStroke
from bozzetto_silhouette.model.sketch_plane import Point, Sheet

Operation = Literal["add", "merge", "carve", "intersect"]
Surface = Literal["convolution", "variational", "inflation", "straight"]
Kernel = Literal["scalis", "cauchy", "inverse-cubic", "inverse-quartic", "quartic", "sextic"]

DEEPEST = 1e4
"""Depth of a tool at most, mm; what reaches behind a shape goes through it."""


@dataclass(frozen=True)
class Oversketch:
    """A stroke drawn over a ring of the outline: the nearest stretch of it is replaced.

    Parameters
    ----------
    stroke : Stroke
        As seen when the part was drawn, wherever it has been moved since.
    ring : int
        Which of the rings that the ink describes, in the order drawn.
    """

    stroke: Stroke
    ring: int = 0


@dataclass(frozen=True)
class Smoothing:
    """A stroke rubbed along a ring of the outline: the stretch under it is smoothed.

    `stroke` and `ring` are those of `Oversketch`.
    """

    stroke: Stroke
    ring: int = 0


@dataclass(frozen=True)
class Removal:
    """A ring that was taken out of the outline again: a hole that is filled."""

    ring: int = 0


Edit = Oversketch | Smoothing | Removal


@dataclass(frozen=True)
class Node(PlainPart):
    """Properties that parts and groups share.

    Parameters
    ----------
    pose : Placement
        Where it was moved since it was drawn, in the model's frame.
    """

    pose: Placement = Placement()
    operation: Annotated[
        Operation,
        Parameter(
            "Operation",
            help="How it is combined with what comes before it.",
            choices=(
                ("add", "Add"),
                ("merge", "Merge"),
                ("carve", "Carve"),
                ("intersect", "Intersect"),
            ),
        ),
    ] = "add"
    blend: Annotated[
        float,
        Parameter(
            "Blend radius",
            0.0,
            2.0,
            step=0.05,
            help="How softly it joins, as a share of the thinner part; 0 is a sharp crease.",
        ),
    ] = 0.5


@dataclass(frozen=True)
class Group(Node, PlainGroup):
    """Several nodes that act as one."""


@dataclass(frozen=True)
class Part(Node):
    """One outline with its holes.

    Parameters
    ----------
    strokes : Strokes
        Raw ink: the outer outline and the outlines of holes, in the order drawn.
    sheet : Sheet
        Where they lie.
    edits : tuple of Edit
        What was drawn over the outline since, in order.
    profile : Strokes
        Drawn from another view: how thick it is along its main axis.
    paint_strokes : tuple of PaintStroke
        What was painted on its surface.
    color : (r, g, b), optional
        sRGB; else the colour of its ink, else clay.
    """

    strokes: Strokes = Strokes()
    sheet: Sheet = Sheet()
    edits: tuple[Edit, ...] = ()
    profile: Strokes = Strokes()
    paint_strokes: tuple[PaintStroke, ...] = ()
    color: Annotated[Color | None, Parameter("Colour", help="Of this part.")] = None
    surface: Annotated[
        Surface,
        Parameter(
            "Surface",
            help="How the shape gets its depth: round limbs; one smooth surface exactly through "
            "the outline; blown up like a balloon; or straight through.",
            choices=(
                ("convolution", "Round"),
                ("variational", "Interpolate exactly"),
                ("inflation", "Inflate"),
                ("straight", "Straight through"),
            ),
        ),
    ] = "convolution"
    inflation: Annotated[
        float,
        Parameter(
            "Inflation",
            0.2,
            3.0,
            step=0.05,
            help="How deep the shape swells; 1 is round, the silhouette stays as drawn.",
        ),
    ] = 1.0
    depth: Annotated[
        float,
        Parameter(
            "Depth",
            0.0,
            DEEPEST,
            step=0.5,
            unit="mm",
            zero="through",
            help="How deep what goes straight through and carves or intersects reaches behind its "
            "outline.",
            idle_while=(("surface", ("convolution", "variational", "inflation")),),
        ),
    ] = 0.0
    softness: Annotated[
        float,
        Parameter(
            "Limb softness",
            1.25,
            2.0,
            step=0.05,
            help="How softly limbs flow into the body.",
            idle_while=(("surface", ("variational", "inflation", "straight")),),
        ),
    ] = 1.4
    pressure: Annotated[
        float,
        Parameter(
            "Pen pressure",
            0.0,
            1.0,
            step=0.05,
            help="How much thicker the shape gets where the pen was pressed harder.",
        ),
    ] = 0.0
    kernel: Annotated[
        Kernel,
        Parameter(
            "Kernel",
            advanced=True,
            help="The function that makes limbs round; the default keeps thin ones thin. The "
            "compact ones are SketchCo's: limbs crumple, as in the paper.",
            idle_while=(("surface", ("variational", "inflation", "straight")),),
            choices=(
                ("scalis", "Scale-invariant (default)"),
                ("cauchy", "Cauchy"),
                ("inverse-cubic", "1 / r³"),
                ("inverse-quartic", "1 / r⁴"),
                ("quartic", "Compact quartic, as in SketchCo"),
                ("sextic", "Compact sextic, as in SketchCo"),
            ),
        ),
    ] = "scalis"
    skeleton: Annotated[
        Literal["exact", "paper"],
        Parameter(
            "Skeleton",
            advanced=True,
            help="How the skeleton is taken from the triangles of the outline.",
            idle_while=(("surface", ("inflation", "straight")),),
            choices=(("exact", "On the medial axis"), ("paper", "As in SketchCo")),
        ),
    ] = "exact"

    @property
    def placement(self) -> Placement:
        """The placement from the part's object frame to the frame of its group."""
        return self.pose.after(self.sheet.placement)

    @property
    def recipe(self) -> Part:
        """All that its shape in the object frame depends on; equal recipes have equal shapes."""
        plain = Part()
        return replace(
            self,
            id="",
            name="",
            visible=True,
            within="",
            pose=plain.pose,
            operation=plain.operation,
            blend=plain.blend,
            paint_strokes=(),
            color=None,
        )


@dataclass(frozen=True)
class Cut(Part):
    """One open line across what comes before it: what lies on one side of it falls away."""

    side: Annotated[
        Literal["left", "right"],
        Parameter(
            "Falls away",
            help="Which side of the line, seen along it as it was drawn.",
            choices=(("left", "Left of the line"), ("right", "Right of the line")),
        ),
    ] = "left"


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture projected on the whole shape along its own normal.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA, sRGB; read-only.
    corner, across, down : (x, y, z)
        Its rectangle, mm, in the model's frame.
    """

    pixels: NDArray[np.uint8]
    corner: Point
    across: Point
    down: Point

    def __post_init__(self) -> None:
        object.__setattr__(self, "pixels", frozen(self.pixels, np.uint8))
        if self.pixels.ndim != 3 or self.pixels.shape[2] != 4 or not self.pixels.size:
            raise ValueError("a picture needs pixels of the shape (height, width, 4)")


@dataclass(frozen=True)
class Turn:
    """A joint that was turned.

    Parameters
    ----------
    joint : (x, y, z)
        Its place at rest, mm.
    rotation : (w, x, y, z)
        Unit quaternion, about the joint.
    part : str
        Id of the part in whose object frame both are, so that they go where it goes; "" for
        the model's frame.
    """

    joint: Point
    rotation: tuple[float, float, float, float]
    part: str = ""


@dataclass(frozen=True)
class KeyPose:
    """A pose of a motion.

    Parameters
    ----------
    turns : tuple of Turn
    """

    turns: tuple[Turn, ...] = ()


@dataclass(frozen=True)
class SilhouetteState(PartsState):
    """The tree, what is chosen in it, and what holds for all of it.

    Parameters
    ----------
    nodes : tuple of Part, Cut or Group
    selected : str
        Id of the node that is chosen; "" for none.
    turns : tuple of Turn
    picture : Picture, optional
    keys : tuple of KeyPose
        A motion that goes through them, evenly in time, and from the last to the first again.
    motion : str
        Its name.
    time : float
        How far it has played, s.
    """

    nodes: tuple[Part | Cut | Group, ...] = ()
    selected: str = ""
    turns: tuple[Turn, ...] = ()
    picture: Picture | None = None
    keys: tuple[KeyPose, ...] = ()
    motion: str = "motion"
    time: float = 0.0
    resolution: Annotated[
        int,
        Parameter(
            "Resolution",
            32,
            256,
            step=16,
            unit="cells",
            advanced=True,
            help="Cells along the longest side of the largest part; those of small parts are up to "
            "twice as fine, and thin places are always refined.",
        ),
    ] = 128
    inner: Annotated[
        Literal["hole", "apart"],
        Parameter(
            "Drawn inside",
            help="Whether an outline drawn inside another one is a hole or a part of its own.",
            choices=(("hole", "A hole"), ("apart", "A part of its own")),
        ),
    ] = "hole"
    paint: Annotated[
        Color | None,
        Parameter(
            "Paint colour",
            help="What Paint gives to whole parts, and Brush to what it goes over; none takes it "
            "away.",
            tools=("paint", "brush"),
        ),
    ] = (196, 74, 54)
    brush_size: Annotated[
        float,
        Parameter(
            "Brush size",
            1.0,
            400.0,
            step=1.0,
            unit="px",
            help="Width of the brush on the sheet where the pen is pressed hard; zoom in to paint "
            "finer.",
            tools=("brush",),
        ),
    ] = 24.0
    brush_opacity: Annotated[
        float,
        Parameter(
            "Brush opacity",
            0.05,
            1.0,
            step=0.05,
            help="How much a stroke of the brush covers what lies under it.",
            tools=("brush",),
        ),
    ] = 1.0
    brush_softness: Annotated[
        float,
        Parameter(
            "Soft edge",
            0.0,
            1.0,
            step=0.02,
            help="How much of the brush's radius its edge takes to fade.",
            tools=("brush",),
        ),
    ] = 0.2
    mirrored: Annotated[
        bool,
        Parameter(
            "Mirror",
            help="What is drawn is drawn on the other side of the plane of symmetry, too; on "
            "the front sheet, left and right.",
        ),
    ] = False
    posing: Annotated[
        bool,
        Parameter("Pose", help="Show the joints; drag one and the skin follows."),
    ] = False
    beat: Annotated[
        float,
        Parameter(
            "Time between poses",
            0.05,
            5.0,
            step=0.05,
            unit="s",
            advanced=True,
            help="How long a motion takes from one key pose to the next.",
        ),
    ] = 0.25

    @property
    def parts(self) -> tuple[Part, ...]:
        """The nodes that are outlines."""
        return self.of_kind(Part)

    @property
    def unpainted(self) -> tuple[Part | Cut | Group, ...]:
        """The nodes without strokes of paint: what shape, joints and colours of parts depend on."""
        return tuple(
            replace(node, paint_strokes=()) if isinstance(node, Part) and node.paint_strokes
            else node
            for node in self.nodes
        )  # fmt: skip
