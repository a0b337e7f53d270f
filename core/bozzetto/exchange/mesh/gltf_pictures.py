"""Pictures of glTF materials, read: unpacked once each, and laid on the corners of triangles."""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass, field
from urllib.parse import unquote

import msgspec
import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Bytes
from bozzetto.errors import FormatError, UserError, words_of
from bozzetto.exchange.color import linear_to_srgb, srgb_to_linear
from bozzetto.exchange.image import read_pixels
from bozzetto.exchange.limits import MAX_PIXELS, at_most
from bozzetto.exchange.mesh.gltf_scene import (
    Gltf,
    ImageRecord,
    Material,
    Primitive,
    TextureLink,
    TextureRecord,
    TextureTransform,
    item,
)
from bozzetto.exchange.mesh.gltf_values import Blobs, values_of, view_bytes
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.texture import Texture
from bozzetto.typed_data import decode_json

ROUNDING = 1e-4
"""Share of a picture by which a place may lie outside of it: at its border."""

Tint = tuple[float, float, float]


@dataclass
class Pictures:
    """The pictures of a file, those that were asked for so far.

    Parameters
    ----------
    gltf, blobs
        The file.
    reading : Reading
        Where pictures lie beside it, and what is told.
    """

    gltf: Gltf
    blobs: Blobs
    reading: Reading
    _known: dict[tuple[int, bool, Tint], Bytes | None] = field(default_factory=dict)
    _size: int = 0

    def texture(
        self, primitive: Primitive, material: Material, corners: NDArray[np.int64]
    ) -> Texture | None:
        """Return the picture of a material on triangles; None where there is none, or it is told.

        Parameters
        ----------
        primitive, material
            What the triangles are of.
        corners : (f, 3) int
            Their vertices in the file.
        """
        link = material.pbr_metallic_roughness.base_color_texture
        if link is None:
            return None
        try:
            moved = _transform_of(link)
            name = _places_named(link, moved)
            if name not in primitive.attributes:
                raise FormatError("Its places on the surface are not in the file.")
            places = _moved(values_of(self.gltf, self.blobs, primitive.attributes[name], 2), moved)
            if not np.isfinite(places).all() or np.abs(places).max(initial=0.0) > 1e6:
                raise FormatError("Its places on the surface are not finite.")
            source = item(self.gltf.textures, link.index, "texture")
            factor = material.pbr_metallic_roughness.base_color_factor or (1.0, 1.0, 1.0, 1.0)
            opaque = material.alpha_mode == "OPAQUE"
            pixels = self._pixels(source, opaque, factor[:3])
        except UserError as error:
            self.reading.tell(
                f"Left out of the glTF file: the picture of a material. {error.message}"
            )
            return None
        return Texture(pixels, self._within(places[corners]).astype(np.float32))

    def _within(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return places (f, 3, 2) in the picture itself, where those of a triangle lie in one."""
        inner = places - np.floor(places.min(axis=1, keepdims=True) + ROUNDING)
        if inner.max(initial=0.0) > 1.0 + ROUNDING:
            self.reading.tell(
                "Left out of the glTF file: that pictures repeat within a triangle. Bake them in "
                "the program that made it."
            )
        return np.where((places < -ROUNDING) | (places > 1.0 + ROUNDING), inner, places)

    def _pixels(self, texture: TextureRecord, opaque: bool, tint: Tint) -> Bytes:
        """Return the pixels of a picture in the colour of its material."""
        if texture.source is None:
            raise FormatError("It is of a kind that cannot be read. Save it as PNG or JPEG.")
        key = (texture.source, opaque, tint)
        if key not in self._known:
            self._known[key] = None
            pixels = np.array(read_pixels(self._file(item(self.gltf.images, key[0], "picture"))))
            self._size += pixels.shape[0] * pixels.shape[1]
            at_most(self._size, MAX_PIXELS, "pixels in pictures")
            if opaque:
                pixels[..., 3] = 255
            if tint != (1.0, 1.0, 1.0):
                table = linear_to_srgb(srgb_to_linear(np.arange(256))[:, None] * tint)
                for channel in range(3):
                    pixels[..., channel] = table[pixels[..., channel], channel]
            self._known[key] = pixels
        found = self._known[key]
        if found is None:
            raise FormatError("It is damaged.")
        return found

    def _file(self, image: ImageRecord) -> bytes:
        if image.buffer_view is not None:
            return view_bytes(self.gltf, self.blobs, image.buffer_view)
        if image.uri is None:
            raise FormatError("It is not in the file.")
        return linked_bytes(image.uri, self.reading, "picture")


def has_unused_places(gltf: Gltf, primitive: Primitive) -> bool:
    """Whether triangles have places in pictures besides those of the picture that is kept."""
    there = {name for name in primitive.attributes if name.startswith("TEXCOORD_")}
    link: TextureLink | None = None
    if primitive.material is not None:
        material = item(gltf.materials, primitive.material, "material")
        link = material.pbr_metallic_roughness.base_color_texture
    if link is None:
        return bool(there)
    try:
        return bool(there - {_places_named(link, _transform_of(link))})
    except FormatError:  # which is told where the picture is laid
        return False


def _places_named(link: TextureLink, moved: TextureTransform) -> str:
    """Return the name of the attribute that says where a picture lies."""
    return f"TEXCOORD_{link.tex_coord if moved.tex_coord is None else moved.tex_coord}"


def _transform_of(link: TextureLink) -> TextureTransform:
    raw = link.extensions.get("KHR_texture_transform")
    if raw is None:
        return TextureTransform()
    try:
        transform: TextureTransform = decode_json(raw, TextureTransform)
        return transform
    except msgspec.MsgspecError as error:
        raise FormatError(
            f"How it lies on the surface cannot be understood: {words_of(error)}."
        ) from None


def _moved(places: NDArray[np.float64], by: TextureTransform) -> NDArray[np.float64]:
    """Return places (n, 2) as they lie in the picture.

    They are turned as the Khronos sample viewer and three.js do, for both of which v points down.
    """
    cos, sin = np.cos(by.rotation), np.sin(by.rotation)
    with np.errstate(over="ignore", invalid="ignore"):
        turned: NDArray[np.float64] = (places * by.scale) @ np.array([(cos, -sin), (sin, cos)])
        return turned + by.offset


def linked_bytes(uri: str, reading: Reading, kind: str) -> bytes:
    """Return the bytes of a link: those that it holds, or those of a file beside.

    Parameters
    ----------
    uri : str
        The link.
    reading : Reading
        Where other files lie.
    kind : str
        For messages, such as "buffer".

    Raises
    ------
    UserError, FormatError
        As `Reading.beside`, and if it is damaged.
    """
    if not uri.startswith("data:"):
        return reading.beside(unquote(uri), kind)
    head, comma, text = uri.partition(",")
    if not comma or not head.endswith(";base64"):
        raise FormatError(f"A {kind} in its description is not in base64. Export it again.")
    try:
        return base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        raise FormatError(f"A {kind} in its description is damaged.") from None
