"""PNG files: what goes in comes out, and nothing half-written stays."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.images.png import write_png

PICTURE = np.random.default_rng(0).integers(0, 256, (5, 7, 4), dtype=np.uint8)


def read_by_hand(data):
    """A reader of its own: chunks with their checksums, and the five row filters."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, body, header = 8, b"", None
    while at < len(data):
        (size,) = struct.unpack(">I", data[at : at + 4])
        kind, content = data[at + 4 : at + 8], data[at + 8 : at + 8 + size]
        (check,) = struct.unpack(">I", data[at + 8 + size : at + 12 + size])
        assert check == zlib.crc32(kind + content)
        header = content if kind == b"IHDR" else header
        body += content if kind == b"IDAT" else b""
        at += 12 + size
    width, height, depth, color = struct.unpack(">IIBB", header[:10])
    assert (depth, color) == (8, 6)
    raw = np.frombuffer(zlib.decompress(body), np.uint8).reshape(height, 1 + 4 * width)
    rows = np.zeros((height + 1, 4 * width + 4), int)
    for y, (kind, *line) in enumerate(raw.astype(int), 1):
        for x, value in enumerate(line, 4):
            left, up, corner = rows[y, x - 4], rows[y - 1, x], rows[y - 1, x - 4]
            nearest = min((left, up, corner), key=lambda p, s=left + up - corner: abs(s - p))
            guess = (0, left, up, (left + up) // 2, nearest)[kind]
            rows[y, x] = (value + guess) % 256
    return rows[1:, 4:].reshape(height, width, 4)


def test_a_picture_comes_back(tmp_path):
    path = tmp_path / "a.png"
    path.write_bytes(b"old")
    write_png(path, PICTURE)
    np.testing.assert_array_equal(read_by_hand(path.read_bytes()), PICTURE)
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


def test_a_failure_leaves_the_old_file_and_no_litter(tmp_path, monkeypatch):
    path = tmp_path / "a.png"
    path.write_bytes(b"old")

    def full_disk(_):
        raise OSError(28, "no space left")

    monkeypatch.setattr("os.fsync", full_disk)
    with pytest.raises(UserError):
        write_png(path, PICTURE)
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


@pytest.mark.parametrize("bad", [PICTURE[..., :3], PICTURE[0], PICTURE.astype(float), PICTURE[:0]])
def test_what_is_not_a_picture_is_refused(tmp_path, bad):
    with pytest.raises(ValueError, match="picture"):
        write_png(tmp_path / "a.png", bad)
    assert not list(tmp_path.iterdir())


def test_a_missing_folder_is_an_error(tmp_path):
    with pytest.raises(UserError, match="folder"):
        write_png(tmp_path / "none" / "a.png", PICTURE)
