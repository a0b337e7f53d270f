"""Moving pictures as MP4 (H.264), made by the program ``ffmpeg`` where it is installed.

Encoders of H.264 are under the GPL or need a licence of their patents: the program stays outside.
"""

from __future__ import annotations

import itertools
import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import UserError

PROGRAM: Final = "ffmpeg"

WAY: Final = (
    "-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags", "+faststart",
    "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white",
)  # fmt: skip
"""What every player can show: colours at half the resolution, and even numbers of pixels."""

PATIENCE: Final = 60.0
"""Seconds for the end of a film, once all its pictures are handed over."""


def mp4_of_pictures(pictures: Iterable[NDArray[np.uint8]], rate: float) -> bytes:
    """Return an MP4 of pictures.

    Parameters
    ----------
    pictures : iterable of (h, w, 4) uint8
        RGBA without transparency, at least one, all of one size.
    rate : float
        Pictures a second.

    Raises
    ------
    UserError
        If the program is not installed or fails, or there is no picture.
    """
    program = shutil.which(PROGRAM)
    if program is None:
        raise UserError(
            "An MP4 is made by the program ffmpeg, which is not installed. Install it, or choose "
            "a .gif or a row of .png files."
        )
    rows = iter(pictures)
    first = next(rows, None)
    if first is None:
        raise UserError("A moving picture needs one picture at least.")
    height, width = first.shape[:2]
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "film.mp4"
        taken = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}")
        words = [program, "-nostdin", "-loglevel", "error", *taken, "-r", f"{rate:.6f}"]
        words += ["-i", "pipe:0", *WAY, str(target)]
        with open(Path(folder) / "said", "w+b") as said:
            made = subprocess.Popen(
                words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=said
            )
            try:
                assert made.stdin is not None
                for pixels in itertools.chain([first], rows):
                    made.stdin.write(np.ascontiguousarray(pixels[..., :3]).tobytes())
                made.stdin.close()
                code = made.wait(PATIENCE)
            except (BrokenPipeError, subprocess.TimeoutExpired):
                code = -1
            finally:
                if made.poll() is None:
                    made.kill()
                    made.wait()
            if code != 0 or not target.is_file():
                said.seek(0)
                lines = said.read().decode("utf-8", "replace").strip().splitlines()
                why = f": {lines[-1][:200]}" if lines else ""
                raise UserError(f"The program ffmpeg made no MP4{why}. Choose a .gif instead.")
        return target.read_bytes()
