"""Pictures as a modeler's state keeps them: packed, with the size of the file they came from."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.cached_properties import cached_property
from bozzetto.errors import FormatError, UserError
from bozzetto.images.png import decode_picture, png_bytes

LONGEST_SIDE: Final = 4096
"""Longest side of the pixels that are kept, and beyond what a sheet shows."""

LARGEST_SIDE: Final = 1_000_000
"""Longest side of a picture's file, pixels."""

MAX_BYTES: Final = 64 << 20
"""Largest packed picture: 4096 × 4096 pixels of noise as PNG."""

FORMATS: Final = ("PNG", "JPEG")

LONGEST_NAME: Final = 200
"""Characters of a name."""

JPEG_QUALITY: Final = 92
"""Quality of photographs that had to be packed again; no eye sees a difference."""

PNG_EFFORT: Final = 3
"""zlib level: line drawings pack as well as at 6, in half the time."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture that belongs to a model, such as a sketch that is to be marked.

    Parameters
    ----------
    name : str
        For people: that of the file, without folder and ending.
    encoded : (n,) uint8
        The content of a PNG or JPEG file; read-only.
    width, height : int
        Size of the file that was imported, pixels. Places in the picture are told in these;
        `pixels` may be fewer, with the same proportions.

    Raises
    ------
    ValueError
        If something is out of its range. Whether the bytes are a picture shows in `pixels`.
    """

    name: str
    encoded: NDArray[np.uint8]
    width: int
    height: int

    def __post_init__(self) -> None:
        object.__setattr__(self, "encoded", frozen(self.encoded, np.uint8))
        if self.encoded.ndim != 1 or not 0 < self.encoded.size <= MAX_BYTES:
            raise ValueError(f"a picture has one row of at most {MAX_BYTES} bytes")
        if not 0 < min(self.width, self.height) <= max(self.width, self.height) <= LARGEST_SIDE:
            raise ValueError(f"a picture of {self.width} × {self.height} pixels")
        if len(self.name) > LONGEST_NAME:
            raise ValueError(f"a picture's name has at most {LONGEST_NAME} characters")

    @classmethod
    def of(cls, pixels: NDArray[np.uint8], name: str) -> Picture:
        """Pack pixels.

        Parameters
        ----------
        pixels : (h, w, 4) uint8
            RGBA, straight alpha; kept with 4096 pixels on the longer side at most.
        name : str
            For people; usually the file's name without its ending.

        Raises
        ------
        UserError
            If they are too large for a document.
        ValueError
            If the array is not a picture.
        """
        if pixels.ndim != 3 or pixels.shape[2] != 4 or pixels.dtype != np.uint8 or not pixels.size:
            raise ValueError("a picture needs the shape (height, width, 4), bytes, and pixels")
        height, width = pixels.shape[:2]
        return cls._checked(packed(pixels), name, width, height)

    @classmethod
    def of_file(cls, content: bytes, pixels: NDArray[np.uint8], name: str) -> Picture:
        """Keep the content of a PNG or JPEG file as it is, where it is small enough.

        Parameters
        ----------
        content : bytes
            The PNG or JPEG file.
        pixels : (h, w, 4) uint8
            What was read from it. Where the file says that it was held another way, these
            are upright and the content is not; then, too, it is packed again.
        name : str
            For people; usually the file's name without its ending.

        Raises
        ------
        UserError, ValueError
            As `of`.
        """
        from PIL import Image

        height, width = pixels.shape[:2]
        with Image.open(io.BytesIO(content)) as image:
            photograph = image.format == "JPEG"
            plain = image.format in FORMATS and image.mode in ("L", "LA", "P", "RGB", "RGBA")
            upright = image.size == (width, height) and image.getexif().get(0x0112, 1) == 1
        if not (plain and upright and max(width, height) <= LONGEST_SIDE):
            content = packed(pixels, photograph=photograph)
        return cls._checked(content, name, width, height)

    @classmethod
    def _checked(cls, content: bytes, name: str, width: int, height: int) -> Picture:
        if len(content) > MAX_BYTES or max(width, height) > LARGEST_SIDE:
            raise UserError("This picture is too large to be kept. Make it smaller first.")
        encoded = np.frombuffer(content, np.uint8)
        return cls(name[:LONGEST_NAME], encoded, width, height)

    @cached_property
    def pixels(self) -> NDArray[np.uint8]:
        """Pixels, (h, w, 4) RGBA, straight alpha; unpacked once and read-only.

        Raises
        ------
        FormatError
            If the bytes are no picture, or of a size that belongs to another file.
        """
        pixels = frozen(decode_picture(self.encoded.tobytes(), FORMATS), np.uint8)
        height, width = pixels.shape[:2]
        # A scaled side is rounded to whole pixels.
        if abs(width * self.height - height * self.width) > max(self.width, self.height):
            raise FormatError(f"The picture “{self.name}” is damaged. Place it again.")
        return pixels


def packed(pixels: NDArray[np.uint8], *, photograph: bool = False) -> bytes:
    """Encode pixels as a file that a document keeps, with 4096 on the longer side at most.

    Parameters
    ----------
    pixels : (h, w, 4) uint8
        RGBA, straight alpha.
    photograph : bool
        As JPEG, without alpha; otherwise as PNG.
    """
    from PIL import Image

    image = Image.fromarray(np.ascontiguousarray(pixels), "RGBA")
    image.thumbnail((LONGEST_SIDE, LONGEST_SIDE), Image.Resampling.LANCZOS)
    if not photograph:
        return png_bytes(np.asarray(image), PNG_EFFORT)
    stream = io.BytesIO()
    image.convert("RGB").save(stream, "JPEG", quality=JPEG_QUALITY)
    return stream.getvalue()
