"""Small pictures are made in a worker, which leaves Qt's picture decoders alone."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from PySide6.QtGui import QImage

from bozzetto.document.model import Document
from bozzetto.document.storage.bozz_file import write_document
from bozzetto.images.png import png_bytes
from bozzetto.plugin.host.registry import Registry
from bozzetto_app.dialogs.thumbnails import thumbnail_of

LOADED = """
import sys
from pathlib import Path
from PySide6.QtWidgets import QApplication
from bozzetto_app.dialogs.thumbnails import thumbnail_of
application = QApplication([])
shown = [thumbnail_of(Path(name)) for name in sys.argv[1:]]
assert all(image is not None and not image.isNull() for image in shown)
print("imageformats" in Path("/proc/self/maps").read_text())
"""


@pytest.fixture
def document(tmp_path):
    """A document with a small picture: red at its left, half transparent at its right."""
    pixels = np.zeros((20, 30, 4), np.uint8)
    pixels[:, :15] = 200, 30, 40, 255
    pixels[:, 15:] = 10, 20, 250, 100
    path = tmp_path / "kept.bozz"
    write_document(Document(), path, thumbnail=png_bytes(pixels))
    return path


def test_a_document_shows_the_picture_that_it_keeps(document):
    image = thumbnail_of(document).convertToFormat(QImage.Format.Format_RGBA8888)
    assert (image.width(), image.height()) == (30, 20)
    assert image.pixelColor(3, 3).getRgb() == (200, 30, 40, 255)
    assert image.pixelColor(25, 15).getRgb() == (10, 20, 250, 100)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="asks /proc what is loaded")
def test_qt_loads_no_decoder_for_them(document):
    """It makes objects then, under a lock that the window's thread may hold: neither goes on."""
    (car,) = (info for info in Registry().modelers() if info.id == "bozzetto.car")
    process = subprocess.run(
        [sys.executable, "-c", LOADED, str(document), str(car.samples[0])],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert process.stdout.strip() == "False", process.stdout + process.stderr
