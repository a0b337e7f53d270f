"""Pictures: every mode to RGBA, upright; bombs and damage refused."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest
from PIL import Image

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.import_file import read_image

PIXELS = np.arange(6 * 4 * 3, dtype=np.uint8).reshape(6, 4, 3) * 3


@pytest.mark.parametrize("ending", ["png", "tif", "tiff", "webp", "bmp"])
def test_lossless_formats(tmp_path, ending):
    path = tmp_path / f"a.{ending}"
    Image.fromarray(PIXELS).save(path, **({"lossless": True} if ending == "webp" else {}))
    read = read_image(path)
    assert read.dtype == np.uint8
    np.testing.assert_array_equal(read[..., :3], PIXELS)
    assert (read[..., 3] == 255).all()


def test_alpha_is_straight_and_kept(tmp_path):
    rgba = np.dstack((PIXELS, np.full((6, 4), 77, np.uint8)))
    Image.fromarray(rgba).save(tmp_path / "a.png")
    np.testing.assert_array_equal(read_image(tmp_path / "a.png"), rgba)


@pytest.mark.parametrize("mode", ["L", "1", "P", "LA", "CMYK", "YCbCr"])
def test_other_modes_become_rgba(tmp_path, mode):
    path = tmp_path / ("a.tif" if mode in ("CMYK", "YCbCr") else "a.png")
    Image.fromarray(PIXELS).convert(mode).save(path)
    assert read_image(path).shape == (6, 4, 4)


def test_sixteen_bits_are_scaled_not_clipped(tmp_path):
    grey = np.linspace(0, 65535, 256).astype(np.uint16).reshape(16, 16)
    for ending in ("png", "tif"):
        Image.fromarray(grey).save(tmp_path / f"a.{ending}")
        read = read_image(tmp_path / f"a.{ending}")
        np.testing.assert_allclose(read[..., 0].ravel(), np.arange(256), atol=1)


def test_a_photograph_is_turned_as_it_was_taken(tmp_path):
    picture = Image.new("RGB", (40, 20), (200, 0, 0))
    picture.paste((0, 0, 200), (0, 0, 20, 20))  # blue on the left
    exif = picture.getexif()
    exif[0x0112] = 6  # turn by a quarter clockwise
    picture.save(tmp_path / "a.jpg", exif=exif, quality=95)
    read = read_image(tmp_path / "a.jpg")
    assert read.shape == (40, 20, 4)
    assert read[5, 10, 2] > 150 > read[35, 10, 2]  # blue on top


def bomb(width, height):
    chunk = lambda kind, data: (  # noqa: E731
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    )
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"\0" * 99))


@pytest.mark.parametrize("side", [9_000, 9_400, 60_000, 2**31 - 1])
@pytest.mark.filterwarnings("ignore::PIL.Image.DecompressionBombWarning")
def test_bombs_are_refused_by_their_header(tmp_path, side):
    path = tmp_path / "a.png"
    path.write_bytes(bomb(side, side))
    with pytest.raises(FormatError, match=r"a\.png.*pixels"):
        read_image(path)


def test_damaged_and_foreign_files(tmp_path):
    path = tmp_path / "a.png"
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (99, 99, 3), np.uint8)).save(path)
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(FormatError, match="cannot be read"):
        read_image(path)
    Image.fromarray(PIXELS).save(tmp_path / "b.gif")
    (tmp_path / "b.gif").rename(tmp_path / "b.png")
    with pytest.raises(FormatError):
        read_image(tmp_path / "b.png")
    with pytest.raises(UserError, match=r"\.png"):
        read_image(tmp_path / "a.psd")
