"""Requests of a reader beyond the bytes of its file, and its notes besides the shapes."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.frame_guess import FrameGuess
from bozzetto.exchange.limits import MAX_MESH_BYTES
from bozzetto.exchange.linked_pictures import place_beside
from bozzetto.exchange.read_files import read_bytes
from bozzetto.geometry.shapes import Shapes

MOST_BESIDE: Final = 64
"""Files that one file may name: a scene in pieces has fewer buffers and libraries."""


@dataclass
class Reading:
    """The folder of a file that is read, and what was not understood of it.

    Parameters
    ----------
    folder : Path, optional
        Where the file lies; without it there is nothing beside it.
    """

    folder: Path | None = None
    _told: dict[str, int] = field(default_factory=dict)
    _asked: int = 0

    @property
    def left_out(self) -> tuple[str, ...]:
        """Sentences about what is not read, each with what to do."""
        return tuple(self._told)

    def tell(self, sentence: str) -> None:
        """Note what is left out; what was told before is told once."""
        self._told[sentence] = 1

    def tell_of_unused_places(self, kind: str) -> None:
        """Note that a file of a kind, such as "OBJ", has texture coordinates without a picture."""
        self.tell(
            f"Left out of the {kind} file: texture coordinates that no picture uses (the export "
            "makes new ones)."
        )

    def beside(self, name: str, kind: str) -> bytes:
        """Read a file that lies beside the one that is read, or below.

        Parameters
        ----------
        name : str
            As it stands in the file, with slashes.
        kind : str
            For messages, such as "buffer".

        Raises
        ------
        UserError
            If it is missing or cannot be read.
        FormatError
            If the name leads out of the folder, or too many are asked for.
        """
        self._asked += 1
        if self._asked > MOST_BESIDE:
            raise FormatError(f"It names more than {MOST_BESIDE} other files. Save it as one.")
        if self.folder is None:
            raise UserError(f"The {kind} “{name[:80]}” is not there. Put it beside the file.")
        return read_bytes(place_beside(name, self.folder, kind), MAX_MESH_BYTES)


@dataclass(frozen=True)
class MeshFile:
    """Content of a file of meshes.

    Parameters
    ----------
    shapes : Shapes
        In millimetres and with Z up where the file says its frame; else in that of the file.
    guess : FrameGuess, optional
        The frame that the file seems to be in, where it does not say it.
    left_out : tuple of str
        Sentences about what it holds besides.
    """

    shapes: Shapes
    guess: FrameGuess | None = None
    left_out: tuple[str, ...] = ()

    @property
    def upright(self) -> Shapes:
        """The shapes in millimetres and with Z up, as far as is known."""
        if self.guess is None:
            return self.shapes
        return self.shapes.placed(self.guess.frame.placement.inverse())

    def told(self, chosen: Collection[str] = ()) -> tuple[str, ...]:
        """Return what a person is told: what is missing, and how it is read.

        Parameters
        ----------
        chosen : collection of str
            Of *up* and *unit* those that the person chose.
        """
        known = self.guess is None or {"up", "unit"} <= set(chosen)
        return (*self.left_out, *(() if known or not self.guess else (self.guess.sentence(),)))
