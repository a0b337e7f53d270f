"""Pictures that a state keeps: what goes in comes out, and hostile bytes are refused."""

from __future__ import annotations

import io
from contextlib import suppress

import numpy as np
import pytest
from PIL import Image

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.import_file import read_picture
from bozzetto.images.stored_picture import LONGEST_SIDE
from bozzetto.scene import Picture


def noise(width, height, seed=0):
    return np.random.default_rng(seed).integers(0, 256, (height, width, 4), np.uint8)


def written(path, pixels, **how):
    image = Image.fromarray(pixels, "RGBA")
    if path.suffix == ".jpg":
        image = image.convert("RGB")
    image.save(path, **how)
    return path


def as_bytes(kind, pixels, mode="RGBA"):
    stream = io.BytesIO()
    Image.fromarray(pixels, "RGBA").convert(mode).save(stream, kind)
    return np.frombuffer(stream.getvalue(), np.uint8)


def test_pixels_come_back_to_the_bit():
    pixels = noise(31, 17)
    picture = Picture.of(pixels, "sketch")
    assert (picture.name, picture.width, picture.height) == ("sketch", 31, 17)
    np.testing.assert_array_equal(picture.pixels, pixels)
    assert picture.pixels is picture.pixels
    for array in (picture.pixels, picture.encoded):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_files_of_a_usual_size_are_kept_byte_for_byte(tmp_path):
    for name in ("a.png", "b.jpg"):
        path = written(tmp_path / name, noise(40, 30))
        picture = read_picture(path)
        assert picture.encoded.tobytes() == path.read_bytes()
        assert picture.name == path.stem
        with Image.open(path) as image:
            np.testing.assert_array_equal(picture.pixels, np.asarray(image.convert("RGBA")))


@pytest.mark.parametrize("name", ["a.tif", "b.webp", "c.bmp"])
def test_other_formats_are_packed_anew(tmp_path, name):
    pixels = noise(12, 9)
    pixels[..., 3] = 255
    how = {"lossless": True} if name == "b.webp" else {}
    picture = read_picture(written(tmp_path / name, pixels, **how))
    assert bytes(picture.encoded[1:4]) == b"PNG"
    np.testing.assert_array_equal(picture.pixels, pixels)


@pytest.mark.parametrize("name", ["wide.png", "wide.jpg"])
def test_large_pictures_are_scaled_down_and_know_their_size(tmp_path, name):
    across = np.linspace(0, 255, 6000).astype(np.uint8)
    pixels = np.full((1000, 6000, 4), 255, np.uint8)
    pixels[..., :3] = across[None, :, None]
    picture = read_picture(written(tmp_path / name, pixels))
    assert (picture.width, picture.height) == (6000, 1000)
    assert picture.pixels.shape == (683, LONGEST_SIDE, 4)
    # Places in the file and in the pixels are in proportion.
    for share in (0.1, 0.5, 0.9):
        here = picture.pixels[300, int(share * LONGEST_SIDE), 0]
        assert abs(int(here) - int(across[int(share * 6000)])) <= 3


def test_a_turned_photograph_is_upright(tmp_path):
    pixels = np.zeros((20, 40, 4), np.uint8)
    pixels[:, :20] = (250, 250, 250, 255)
    exif = Image.Exif()
    exif[0x0112] = 6  # turned a quarter: the left side is the top
    picture = read_picture(written(tmp_path / "a.jpg", pixels, exif=exif, quality=95))
    assert (picture.width, picture.height) == (20, 40)
    assert picture.pixels.shape[:2] == (40, 20)
    assert picture.pixels[5, 10, 0] > 240
    assert picture.pixels[35, 10, 0] < 10


def test_sixteen_bits_and_palettes_are_read(tmp_path):
    Image.fromarray(np.full((5, 6), 40_000, np.uint16)).save(tmp_path / "deep.png")
    assert abs(int(read_picture(tmp_path / "deep.png").pixels[0, 0, 0]) - 156) <= 1
    Image.fromarray(noise(8, 8), "RGBA").convert("P").save(tmp_path / "few.png")
    assert read_picture(tmp_path / "few.png").pixels.shape == (8, 8, 4)


def test_thin_strips_keep_a_row():
    picture = Picture.of(noise(9000, 1), "strip")
    assert picture.pixels.shape == (1, LONGEST_SIDE, 4)


PNG = as_bytes("PNG", noise(16, 16))


@pytest.mark.parametrize(
    "encoded",
    [
        np.zeros(100, np.uint8),
        PNG[: PNG.size // 2],
        as_bytes("GIF", noise(16, 16), "P"),
        as_bytes("BMP", noise(16, 16)),
    ],
    ids=["zeros", "half a file", "gif", "bmp"],
)
def test_bytes_that_are_no_picture_are_refused(encoded):
    with pytest.raises(FormatError, match="damaged"):
        _ = Picture("x", encoded, 16, 16).pixels


def test_a_size_that_is_not_the_pictures_is_refused():
    assert Picture("x", PNG, 1600, 1600).pixels.shape == (16, 16, 4)
    with pytest.raises(FormatError, match="damaged"):
        _ = Picture("x", PNG, 1600, 900).pixels


def test_a_bomb_is_refused_before_it_is_unpacked():
    stream = io.BytesIO()
    Image.new("L", (9000, 9000)).save(stream, "PNG")
    bomb = Picture("x", np.frombuffer(stream.getvalue(), np.uint8), 9000, 9000)
    with pytest.raises(UserError, match="too large"):
        _ = bomb.pixels


def test_damaged_bytes_never_do_worse_than_be_refused():
    rng = np.random.default_rng(5)
    for number in range(300):
        encoded = (PNG if number % 2 else as_bytes("JPEG", noise(16, 16), "RGB")).copy()
        where = rng.integers(0, encoded.size, rng.integers(1, 6))
        encoded[where] = rng.integers(0, 256, where.size)
        with suppress(UserError):
            assert Picture("x", encoded, 16, 16).pixels.shape[2] == 4


@pytest.mark.parametrize(
    ("encoded", "width", "height", "name"),
    [
        (PNG, 0, 16, "x"),
        (PNG, 16, -1, "x"),
        (PNG, 2_000_000, 16, "x"),
        (np.zeros(0, np.uint8), 16, 16, "x"),
        (np.zeros((4, 4), np.uint8), 16, 16, "x"),
        (PNG, 16, 16, "x" * 201),
    ],
)
def test_what_makes_no_picture_is_refused_at_once(encoded, width, height, name):
    with pytest.raises(ValueError, match="picture"):
        Picture(name, encoded, width, height)


@pytest.mark.parametrize("shape", [(4, 4), (4, 4, 3), (0, 4, 4)])
def test_only_pixels_are_packed(shape):
    with pytest.raises(ValueError, match="shape"):
        Picture.of(np.zeros(shape, np.uint8), "x")
