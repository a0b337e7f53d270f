"""The stroke: read-only columns of samples, with the camera they were drawn through."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, Final, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.chunked import Chunked
from bozzetto.errors import UserError
from bozzetto.ink.checked_points import FARTHEST, is_on_sheet

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement
    from bozzetto.view.camera import Camera

StrokeTool = Literal["pen", "eraser", "mouse", "imported"]
Column = NDArray[np.float32]

COLUMNS: Final = ("x", "y", "pressure", "t", "tilt_x", "tilt_y", "twist")
"""Names of the sample columns, in the order in which files store them."""

MAX_SAMPLES: Final = 1_000_000
"""Longest stroke accepted (samples): an hour of a 250 Hz tablet without lifting the pen."""


MAX_GROUP: Final = 1000
"""Longest name of a group, characters."""


def frozen_column(values: ArrayLike) -> Column:
    """Copy values into a float32 column that nobody can make writable again.

    The copy is backed by an immutable ``bytes`` object, so a plugin cannot change ink
    behind the document's back even on purpose.
    """
    return np.frombuffer(np.ascontiguousarray(values, np.float32).tobytes(), np.float32)


class Stroke:
    """One pen-down to pen-up, raw, as the device gave it.

    Parameters
    ----------
    x, y : (n,) array_like
        Canvas pixels, y down. ``n >= 1``.
    camera : Camera
        The camera through which the sheet was seen; its viewport is the canvas.
    pressure : (n,) array_like, optional
        0 … 1. Where absent the stroke says so (`has_pressure`) and the column holds 0.5.
    t : (n,) array_like, optional
        Seconds since the first sample, not decreasing. Absent: zeros, `has_time` false.
    tilt_x, tilt_y, twist : (n,) array_like, optional
        Degrees; zeros where absent.
    tool : {"pen", "eraser", "mouse", "imported"}
    color : (r, g, b), optional
        0 … 255; None means the theme's ink.
    group : str
        Which curve this stroke belongs to, where a drawing says so; else "".

    Raises
    ------
    UserError
        If columns differ in length, are empty, too long or not finite; if a place is farther
        away than `FARTHEST`; or if the tool, the colour or the group is none that a document
        could keep.
    """

    __slots__ = (
        "_digest",
        "camera",
        "color",
        "group",
        "has_pressure",
        "has_time",
        "pressure",
        "t",
        "tilt_x",
        "tilt_y",
        "tool",
        "twist",
        "x",
        "y",
    )

    x: Column
    y: Column
    pressure: Column
    t: Column
    tilt_x: Column
    tilt_y: Column
    twist: Column
    camera: Camera
    tool: StrokeTool
    color: tuple[int, int, int] | None
    group: str
    has_pressure: bool
    has_time: bool
    _digest: bytes

    def __init__(
        self,
        x: ArrayLike,
        y: ArrayLike,
        camera: Camera,
        *,
        pressure: ArrayLike | None = None,
        t: ArrayLike | None = None,
        tilt_x: ArrayLike | None = None,
        tilt_y: ArrayLike | None = None,
        twist: ArrayLike | None = None,
        tool: StrokeTool = "pen",
        color: tuple[int, int, int] | None = None,
        group: str = "",
    ) -> None:
        given = {
            "x": x,
            "y": y,
            "pressure": pressure,
            "t": t,
            "tilt_x": tilt_x,
            "tilt_y": tilt_y,
            "twist": twist,
        }
        count = len(np.atleast_1d(np.asarray(x)))
        if not 1 <= count <= MAX_SAMPLES:
            raise UserError(
                f"A stroke needs between 1 and {MAX_SAMPLES} samples; this one has {count}."
            )
        for name, values in given.items():
            if values is None:
                fill = 0.5 if name == "pressure" else 0.0
                column = frozen_column(np.full(count, fill, np.float32))
            else:
                column = frozen_column(np.atleast_1d(np.asarray(values)))
            if column.shape != (count,):
                raise UserError(
                    f"The columns of a stroke must be of one length; "
                    f"{name} has {column.size} samples and x has {count}."
                )
            if not np.isfinite(column).all():
                raise UserError(f"A stroke's {name} holds a value that is not a finite number.")
            object.__setattr__(self, name, column)
        if not is_on_sheet((self.x, self.y)):
            raise UserError(
                f"A stroke holds a place more than {FARTHEST:,.0f} pixels away. Scale the drawing "
                "down in the program that made it."
            )
        if tool not in get_args(StrokeTool):
            raise UserError(f"A stroke is drawn by {', '.join(get_args(StrokeTool))}; not {tool}.")
        if color is not None and not (len(color) == 3 and all(0 <= c <= 255 for c in color)):
            raise UserError(f"A stroke's colour has three parts from 0 to 255, not {color}.")
        if len(group) > MAX_GROUP or any("\ud800" <= letter <= "\udfff" for letter in group):
            raise UserError(f"A stroke's group is a text of at most {MAX_GROUP} characters.")
        object.__setattr__(self, "camera", camera)
        object.__setattr__(self, "tool", tool)
        object.__setattr__(self, "color", color)
        object.__setattr__(self, "group", group)
        object.__setattr__(self, "has_pressure", pressure is not None)
        object.__setattr__(self, "has_time", t is not None)

    @classmethod
    def from_columns(
        cls,
        columns: Iterable[Column],
        camera: Camera,
        tool: StrokeTool,
        color: tuple[int, int, int] | None,
        group: str,
        has_pressure: bool,
        has_time: bool,
    ) -> Stroke:
        """Make a stroke of columns already checked: one length, finite, backed by ``bytes``.

        For readers of files that hold thousands of strokes in common columns and have
        checked these as a whole; everyone else calls the class.

        Parameters
        ----------
        columns : iterable of (n,) float32
            In the order of `COLUMNS`.
        camera, tool, color, group
            As in the class.
        has_pressure, has_time : bool
            Whether the device told pressure and time.
        """
        made = cls.__new__(cls)
        keep = object.__setattr__
        for name, column in zip(COLUMNS, columns, strict=True):
            keep(made, name, column)
        keep(made, "camera", camera)
        keep(made, "tool", tool)
        keep(made, "color", color)
        keep(made, "group", group)
        keep(made, "has_pressure", has_pressure)
        keep(made, "has_time", has_time)
        return made

    def moved(self, placement: Placement) -> Stroke:
        """Return the stroke as drawn through its camera carried along by a placement.

        The rays of the ink move with the world. A mirrored world is seen as in a mirror:
        the ink's x is flipped within the canvas, and so are tilt and twist.

        Raises
        ------
        UserError
            If the camera would stand beyond all bounds.
        """
        columns = {name: getattr(self, name) for name in COLUMNS}
        if placement.mirrors:
            columns["x"] = frozen_column(np.float32(self.camera.viewport[0]) - self.x)
            columns |= {name: frozen_column(-columns[name]) for name in ("tilt_x", "twist")}
        return Stroke.from_columns(
            columns.values(),
            self.camera.moved(placement),
            self.tool,
            self.color,
            self.group,
            self.has_pressure,
            self.has_time,
        )

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a stroke is read-only: {name}")

    def __copy__(self) -> Stroke:
        return self

    def __deepcopy__(self, memo: dict[int, object]) -> Stroke:
        return self

    def __len__(self) -> int:
        return int(self.x.size)

    def __repr__(self) -> str:
        return f"Stroke({len(self)} samples, {self.tool})"

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if not isinstance(other, Stroke):
            return NotImplemented
        return self._facts() == other._facts() and all(
            np.array_equal(getattr(self, name), getattr(other, name)) for name in COLUMNS
        )

    def __hash__(self) -> int:
        return hash(self.digest)

    def _facts(self) -> tuple[object, ...]:
        return (
            self.camera,
            self.tool,
            self.color,
            self.group,
            self.has_pressure,
            self.has_time,
        )

    @property
    def points(self) -> NDArray[np.float64]:
        """Canvas positions, shape (n, 2), pixels, y down."""
        return np.column_stack((self.x, self.y)).astype(np.float64)

    @property
    def nbytes(self) -> int:
        """Size of the columns in bytes."""
        return sum(getattr(self, name).nbytes for name in COLUMNS)

    @property
    def digest(self) -> bytes:
        """16 bytes that name this stroke's content; worked out once."""
        with suppress(AttributeError):
            return self._digest
        import hashlib

        state = hashlib.blake2b(repr(self._facts()).encode(), digest_size=16)
        for name in COLUMNS:
            state.update(getattr(self, name).tobytes())
        object.__setattr__(self, "_digest", state.digest())
        return self._digest


class Strokes(Chunked[Stroke]):
    """An immutable sequence of strokes that is cheap to extend.

    Parameters
    ----------
    strokes : iterable of Stroke
    """

    __slots__ = ()
