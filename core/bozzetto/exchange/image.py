"""Pictures to lay under a drawing: PNG, JPEG, TIFF, WebP, BMP."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError, words_of
from bozzetto.exchange.limits import MAX_PIXELS, at_most

if TYPE_CHECKING:
    from PIL import Image

__all__ = ["read_pixels"]

DECODERS: Final = ("PNG", "JPEG", "TIFF", "WEBP", "BMP")


def read_pixels(data: bytes) -> NDArray[np.uint8]:
    """Decode a picture; the first one where there are several.

    Returns
    -------
    (h, w, 4) uint8
        RGBA, turned the way the camera was held. Sixteen bits are reduced to eight.

    Raises
    ------
    FormatError
        If it is damaged, of another format, or has more than `MAX_PIXELS` pixels.
    """
    from PIL import Image, ImageOps

    try:
        with Image.open(io.BytesIO(data), formats=DECODERS) as picture:
            # The size stands in the header: a bomb is refused before it is unpacked.
            at_most(picture.width * picture.height, MAX_PIXELS, "pixels")
            upright = ImageOps.exif_transpose(_eight_bits(picture))
            return np.array(upright.convert("RGBA"), np.uint8)
    except FormatError:
        raise
    except Image.DecompressionBombError:
        raise FormatError(
            f"This picture has more than the {MAX_PIXELS:,} pixels that can be read. "
            "Make it smaller first."
        ) from None
    except Exception as error:
        # Decoders leak all kinds of exceptions on damaged files; there is no list of them.
        raise FormatError(f"This picture cannot be read: {words_of(error)}.") from error


def _eight_bits(picture: Image.Image) -> Image.Image:
    """Grey of more than eight bits, which Pillow would clip instead of scaling."""
    from PIL import Image

    if not picture.mode.startswith(("I", "F")):
        return picture
    values = np.nan_to_num(np.asarray(picture, np.float64))
    top = 65535.0 if picture.mode.startswith("I") else max(float(values.max(initial=0)), 1e-300)
    grey = Image.fromarray(np.clip(255.0 / top * values, 0, 255).astype(np.uint8))
    grey.info = dict(picture.info)
    grey.getexif().update(picture.getexif())
    return grey
