"""The display list: what to show, without saying how it is drawn.

Modelers return a `Scene`; viewports and the software renderer draw it. Colours are roles
of the theme ("ink", "accent", "second" …) or (r, g, b). Sizes on the sheet are pixels,
positions are mm in the model's own frame.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.cached_properties import cached_property
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.texture import Texture
from bozzetto.scene.palette import ROLES, Color

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement

Paint = str | Color
"""A role of the theme, such as "ink" or "accent", or a colour of its own."""

Finish = Literal["clay", "zebra", "gloss", "rubber", "metal"]
Hidden = Literal["hide", "faint", "dashed", "show"]
"""How parts of lines and dots behind surfaces appear."""

MOST_FRAMED = 30_000
"""Points that are looked at when a scene is framed; a mesh of more has edges so short that
what thinning it out leaves over the margin cannot be seen."""

_revisions = count(1)


def _check_paint(paint: Paint) -> None:
    if isinstance(paint, str):
        if paint not in ROLES:
            raise ValueError(f"no colour role {paint!r}; there are {', '.join(ROLES)}")
    elif len(paint) != 3 or not all(0 <= part <= 255 for part in paint):
        raise ValueError(f"a colour needs three parts from 0 to 255, not {paint!r}")


@dataclass(frozen=True, eq=False)
class Shaded:
    """A triangle mesh under the viewport's light.

    Parameters
    ----------
    mesh : Mesh
        Its vertex colours, where present, take the place of `color`, as far as they cover it.
    opacity : float
        0 … 1; below 1 the inside shows through (see-through boxes).
    pickable : bool
        Whether ink can be laid on it.
    finish : {"clay", "zebra", "gloss", "rubber", "metal"}
        Matte; polished so that it mirrors rings of light, whose stripes break where the surface
        has a crease and have a kink where its curvature jumps; or a material that mirrors a lamp.
        The mesh should bring exact normals. A view that shades all surfaces in its own way takes
        no notice.
    texture : Texture, optional
        A picture on it, over these colours, with a place for every corner of every face. A view
        of curvature or draft takes no notice.
    """

    mesh: Mesh
    color: Paint = "clay"
    opacity: float = 1.0
    pickable: bool = True
    finish: Finish = "clay"
    texture: Texture | None = None

    def __post_init__(self) -> None:
        _check_paint(self.color)
        if self.texture is not None and len(self.texture.corners) != len(self.mesh.faces):
            raise ValueError("a texture needs a place for every corner of every face")
        if self.finish not in get_args(Finish):
            raise ValueError(f"no finish {self.finish!r}; there are {', '.join(get_args(Finish))}")

    def placed(self, placement: Placement) -> Shaded:
        """Return it moved by a placement, with its texture."""
        mesh, texture = self.mesh.placed(placement), self.texture
        if texture is not None and placement.mirrors:
            texture = texture.turned_over()
        return replace(self, mesh=mesh, texture=texture)


@dataclass(frozen=True, eq=False)
class Lines:
    """One or several polylines.

    Parameters
    ----------
    points : (n, 3) float32
        All points, one polyline after the other.
    starts : (k,) int32, optional
        Index of each polyline's first point; default one polyline.
    width : float or (n,) float32
        Pixels; one value per point makes ink of varying width.
    hidden : {"hide", "faint", "dashed", "show"}
        How parts behind surfaces appear.
    """

    points: NDArray[np.float32]
    starts: NDArray[np.int32] | None = None
    color: Paint = "ink"
    width: float | NDArray[np.float32] = 1.5
    opacity: float = 1.0
    hidden: Hidden = "faint"

    def __post_init__(self) -> None:
        _check_paint(self.color)
        object.__setattr__(self, "points", frozen(self.points, np.float32, 3))
        if self.starts is not None:
            object.__setattr__(self, "starts", frozen(self.starts, np.int32))
        if not isinstance(self.width, int | float):
            object.__setattr__(self, "width", frozen(self.width, np.float32))
            if np.shape(self.width) != (len(self.points),):
                raise ValueError("lines need one width, or one per point")

    def pieces(self) -> Iterator[slice]:
        """Yield the index range of every polyline."""
        begins = [0] if self.starts is None else [int(i) for i in self.starts]
        ends = [*begins[1:], len(self.points)]
        for begin, end in zip(begins, ends, strict=False):  # no beginning, no polyline
            if end > begin:
                yield slice(begin, end)


@dataclass(frozen=True, eq=False)
class Points:
    """Dots of a fixed size on the sheet, shape (n, 3) mm, size in pixels (diameter)."""

    points: NDArray[np.float32]
    color: Paint = "ink"
    size: float = 6.0
    opacity: float = 1.0
    hidden: Hidden = "faint"

    def __post_init__(self) -> None:
        _check_paint(self.color)
        object.__setattr__(self, "points", frozen(self.points, np.float32, 3))


@dataclass(frozen=True)
class Label:
    """A short text beside a point (mm); `size` in pixels."""

    point: tuple[float, float, float]
    text: str
    color: Paint = "ink"
    size: float = 12.0

    def __post_init__(self) -> None:
        _check_paint(self.color)


@dataclass(frozen=True, eq=False)
class Image:
    """A picture on a rectangle in space.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA, sRGB, straight alpha; first row on top.
    corner : (x, y, z)
        World place of the top left corner, mm.
    across, down : (x, y, z)
        Edges from that corner along the first row and the first column, mm.
    """

    pixels: NDArray[np.uint8]
    corner: tuple[float, float, float]
    across: tuple[float, float, float]
    down: tuple[float, float, float]
    opacity: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "pixels", frozen(self.pixels, np.uint8))
        if self.pixels.ndim != 3 or self.pixels.shape[2] != 4:
            raise ValueError("an image needs the shape (height, width, 4)")


@dataclass(frozen=True)
class Handle:
    """A named place that can be dragged; drawn as a disc with a dark rim.

    Dragging it makes a `Drag` gesture that carries this `id`.
    """

    id: str
    point: tuple[float, float, float]
    color: Paint = "accent"
    tip: str = ""

    def __post_init__(self) -> None:
        _check_paint(self.color)


Item = Shaded | Lines | Points | Label | Image | Handle
"""Whatever a layer can hold."""


@dataclass(frozen=True, eq=False)
class Layer:
    """Items that change together.

    Parameters
    ----------
    name : str
    items : tuple of Item
    owner : str
        Id of the model that shows it; filled in by the host.
    tool : str
        Id of the tool that it belongs to: it is there only while that tool is in the hand and
        its model is selected. "" is there always.
    chosen : bool
        Whether it is there only while its model is selected, such as a picture to work on, or
        the chosen part in the accent colour: what has it is what the next key changes.
    revision : int
        Fresh for every layer made; equal revisions mean equal content, so a viewport may
        keep what it has uploaded.
    """

    name: str
    items: tuple[Item, ...] = ()
    owner: str = ""
    tool: str = ""
    chosen: bool = False
    revision: int = field(default_factory=lambda: next(_revisions))

    @cached_property
    def points(self) -> NDArray[Any]:
        """Places of it that are in view when a scene is framed, (n, 3) mm.

        The vertices of meshes, the points of lines and marks; beyond `MOST_FRAMED` thinned out.
        """
        parts = (
            item.mesh.vertices if isinstance(item, Shaded) else _extent(item)
            for item in self.items
            if not isinstance(item, Image)
        )
        return _thinned([part for part in parts if len(part)])

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """Bounding box of meshes, lines, points and images, (2, 3) mm; NaN where there are none."""
        parts = [part for part in map(_extent, self.items) if len(part)]
        if not parts:
            return np.full((2, 3), np.nan)
        ends = [(part.min(axis=0), part.max(axis=0)) for part in parts]
        low, high = zip(*ends, strict=True)
        return np.stack((np.min(low, axis=0), np.max(high, axis=0)))

    @cached_property
    def marks(self) -> tuple[Handle | Label, ...]:
        """Its handles and labels."""
        return tuple(item for item in self.items if isinstance(item, Handle | Label))

    @cached_property
    def corners(self) -> NDArray[np.float64]:
        """The corners of its images, (n, 3) mm."""
        images = [_extent(item) for item in self.items if isinstance(item, Image)]
        return np.concatenate([np.zeros((0, 3)), *images])


@dataclass(frozen=True, eq=False)
class Scene:
    """Layers, drawn in order where depth does not decide."""

    layers: tuple[Layer, ...] = field(default_factory=tuple)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """Make the layers of a scene that was put off; nothing else is ever missing."""
            make = self.__dict__.get("_make") if name == "layers" else None
            if make is None:
                raise AttributeError(name)
            layers = make().layers
            object.__setattr__(self, "layers", layers)
            return layers

    @classmethod
    def put_off(cls, make: Callable[[], Scene]) -> Scene:
        """Return a scene whose layers are made when they are first looked at, and then kept.

        Parameters
        ----------
        make : callable
            Gives the scene; what it raises reaches who looks, and who looks again asks again.
        """
        scene = cls.__new__(cls)
        scene.__dict__["_make"] = make
        return scene

    @property
    def is_made(self) -> bool:
        """Whether the layers are there; False while they are put off."""
        return "layers" in self.__dict__

    @property
    def known(self) -> Scene:
        """Items that need no wait: of a sum, whatever is not put off; else all or nothing."""
        return self if self.is_made else self.__dict__.get("_known", EMPTY)

    def __add__(self, other: Scene) -> Scene:
        if self.is_made and other.is_made:
            return Scene(self.layers + other.layers)
        both = Scene.put_off(lambda: Scene(self.layers + other.layers))
        both.__dict__["_known"] = self.known + other.known
        return both

    def under(self, live: Scene) -> Scene:
        """Show this scene with what is there only for a moment.

        A layer of `live` with an owner stands in for the layer of the same name and owner.
        """
        hidden = {(layer.owner, layer.name) for layer in live.layers if layer.owner}
        kept = (layer for layer in self.layers if (layer.owner, layer.name) not in hidden)
        return Scene((*kept, *live.layers))

    def items(self) -> Iterator[tuple[Layer, Item]]:
        """Yield every item with its layer."""
        for layer in self.layers:
            for item in layer.items:
                yield layer, item

    def owned(self, owner: str) -> Scene:
        """Return the same layers, marked as one model's."""
        return Scene(tuple(replace(layer, owner=owner) for layer in self.layers))

    def placed(self, placement: Placement) -> Scene:
        """Return the scene moved by a placement; itself where nothing moves."""
        if placement.is_identity:
            return self
        if not self.is_made:
            moved = Scene.put_off(lambda: Scene(self.layers).placed(placement))
            moved.__dict__["_known"] = self.known.placed(placement)
            return moved
        return Scene(
            tuple(
                Layer(
                    layer.name,
                    tuple(_moved(i, placement) for i in layer.items),
                    layer.owner,
                    layer.tool,
                    layer.chosen,
                )
                for layer in self.layers
            )
        )

    def bounds(self) -> NDArray[np.float64]:
        """Return the bounding box of meshes, lines, points and images, shape (2, 3), mm.

        NaN where the scene is empty.
        """
        boxes = np.array([layer.bounds for layer in self.layers if layer.items])
        boxes = boxes[np.isfinite(boxes).all(axis=(1, 2))] if len(boxes) else boxes
        if not len(boxes):
            return np.full((2, 3), np.nan)
        return np.stack((boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)))

    def of_kinds(self, *kinds: type[Item]) -> Scene:
        """Return the scene with the items of some kinds only."""
        return Scene(
            tuple(
                replace(layer, items=tuple(i for i in layer.items if isinstance(i, kinds)))
                for layer in self.layers
            )
        )

    def points(self) -> NDArray[np.float64]:
        """Return the points to be shown when the scene is framed, shape (n, 3), mm.

        The vertices of meshes, the points of lines and marks; of a scene that has neither, the
        corners of images. What belongs to a tool does not count, for it comes and goes with it.
        Beyond `MOST_FRAMED` points are thinned out evenly. They cannot be written to.
        """
        return self._framed_points

    @cached_property
    def _framed_points(self) -> NDArray[np.float64]:
        layers = [layer for layer in self.layers if not layer.tool]
        parts = [layer.points for layer in layers if len(layer.points)]
        found = np.array(_thinned(parts or [layer.corners for layer in layers]), np.float64)
        found.setflags(write=False)
        return found


def _thinned(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Return points (n, 3) together, some of each; `MOST_FRAMED` and one of each at most."""
    step = 1 + sum(map(len, parts)) // MOST_FRAMED
    if len(parts) == 1:
        return parts[0][::step]
    return np.concatenate([part[::step] for part in parts]) if parts else np.zeros((0, 3))


EMPTY: Final = Scene()


def _extent(item: Item) -> NDArray[np.float64]:
    if isinstance(item, Shaded):
        return item.mesh.bounds if len(item.mesh.vertices) else np.zeros((0, 3))
    if isinstance(item, Lines | Points):
        return np.asarray(item.points, np.float64)
    if isinstance(item, Image):
        corner, across, down = (np.asarray(v) for v in (item.corner, item.across, item.down))
        return np.array([corner, corner + across, corner + down, corner + across + down])
    return np.zeros((0, 3))


def _triple(values: NDArray[np.float64]) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in np.ravel(values))
    return x, y, z


def _moved(item: Item, placement: Placement) -> Item:
    if isinstance(item, Shaded):
        return item.placed(placement)
    if isinstance(item, Lines | Points):
        return replace(item, points=placement.points(item.points).astype(np.float32))
    if isinstance(item, Image):
        return replace(
            item,
            corner=_triple(placement.points(item.corner)),
            across=_triple(placement.scale * placement.directions(item.across)),
            down=_triple(placement.scale * placement.directions(item.down)),
        )
    return replace(item, point=_triple(placement.points(item.point)))
