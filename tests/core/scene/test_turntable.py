"""Turntables: what turns stays in the picture, and turns the right way."""

from __future__ import annotations

import json
import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image

from bozzetto.errors import UserError
from bozzetto.scene import LIGHT, Layer, Scene, Shaded
from bozzetto.scene.turntable import MOST_PICTURES, turned, turned_pictures
from bozzetto.view import Camera
from tests.core.scene.shapes import box

SIZE = (120, 90)


def scene_of(size=(80.0, 10.0, 30.0)):
    return Scene((Layer("a", (Shaded(box(size)),)),))


def inked(pixels):
    """Which pixels are not paper."""
    paper = np.array(LIGHT.paper[:3], int)
    return np.abs(pixels[..., :3].astype(int) - paper).max(axis=2) > 12


def test_all_of_it_lies_in_every_picture():
    for pixels in turned_pictures(scene_of(), 8, size=SIZE):
        seen = inked(pixels)
        assert seen.any()
        rim = np.concatenate([seen[0], seen[-1], seen[:, 0], seen[:, -1]])
        assert not rim.any()


def test_half_a_turn_shows_a_box_as_before_and_a_quarter_does_not():
    whole = list(turned_pictures(scene_of(), 4, size=SIZE, view="front"))
    front, side, back, other = (inked(pixels) for pixels in whole)
    assert (front != back).mean() < 0.01
    assert (side != other).mean() < 0.01
    assert front.any(axis=0).sum() > 3 * side.any(axis=0).sum()


def test_a_camera_comes_back_and_keeps_its_distance():
    camera, middle = Camera(eye=(10.0, -500.0, 80.0)), np.array([5.0, 7.0, 9.0])
    row = [turned(camera, angle, middle) for angle in np.linspace(0.0, 2.0 * np.pi, 7)]
    away = [np.linalg.norm(np.subtract(one.eye, middle)) for one in row]
    assert away == pytest.approx([away[0]] * 7)
    assert row[-1].eye == pytest.approx(camera.eye)
    quarter = turned(Camera(eye=(0.0, -500.0, 0.0)), 0.5 * np.pi, np.zeros(3))
    assert quarter.eye == pytest.approx((500.0, 0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("count", [0, -3, MOST_PICTURES + 1])
def test_numbers_out_of_range_are_refused(count):
    with pytest.raises(UserError, match="pictures"):
        next(turned_pictures(scene_of(), count))


def test_an_empty_scene_is_paper():
    (pixels,) = turned_pictures(Scene(()), 1, size=SIZE)
    assert not inked(pixels).any()


def moving(path, count, seconds, size=(64, 48)):
    """A turntable of a box in a file."""
    from bozzetto.images.gif import gif_of_pictures
    from bozzetto.images.mp4 import mp4_of_pictures

    film_of = gif_of_pictures if path.suffix == ".gif" else mp4_of_pictures
    pictures = list(turned_pictures(scene_of(), count, size=size))
    path.write_bytes(film_of(iter(pictures), count / seconds))
    return pictures


@pytest.mark.parametrize(("count", "seconds"), [(24, 2.0), (7, 1.0), (50, 3.0), (12, 4.0)])
def test_a_gif_lasts_as_long_as_it_should_and_has_no_jump(tmp_path, count, seconds):
    pictures = moving(tmp_path / "a.gif", count, seconds)
    with Image.open(tmp_path / "a.gif") as film:
        assert film.info["loop"] == 0
        assert film.size == (64, 48)
        times, frames = [], []
        for number in range(film.n_frames):
            film.seek(number)
            times.append(film.info["duration"])
            frames.append(np.array(film.convert("RGB"), int))
    assert sum(times) == pytest.approx(1000.0 * seconds, abs=10)
    assert max(times) - min(times) <= 10
    for found, picture in zip(frames, pictures, strict=True):
        assert np.abs(found - picture[..., :3]).mean() < 2.0
    steps = [np.abs(frames[k] - frames[k - 1]).mean() for k in range(count)]
    assert 0.0 < steps[0] <= 1.5 * max(steps[1:])  # from the last one to the first


@pytest.mark.interop
@pytest.mark.parametrize("size", [(64, 48), (65, 47)])
def test_an_mp4_has_all_pictures_at_their_times(tmp_path, size):
    if shutil.which("ffprobe") is None:
        pytest.skip("ffmpeg is not installed")
    moving(tmp_path / "a.mp4", 24, 2.0, size)
    words = (
        "-count_frames",
        "-show_entries",
        "stream=codec_name,width,height,nb_read_frames,duration",
    )
    done = subprocess.run(
        ["ffprobe", "-loglevel", "error", *words, "-of", "json", str(tmp_path / "a.mp4")],
        capture_output=True, check=True, timeout=60,
    )  # fmt: skip
    (stream,) = json.loads(done.stdout)["streams"]
    assert stream["codec_name"] == "h264"
    assert (stream["width"], stream["height"]) == (size[0] + size[0] % 2, size[1] + size[1] % 2)
    assert int(stream["nb_read_frames"]) == 24
    assert float(stream["duration"]) == pytest.approx(2.0, abs=0.01)


def test_without_the_program_an_mp4_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(UserError, match="ffmpeg"):
        moving(tmp_path / "a.mp4", 2, 1.0)


def test_where_the_program_fails_its_last_words_are_told(tmp_path, monkeypatch):
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\necho no such thing >&2\nexit 3\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/bin:/usr/bin")
    with pytest.raises(UserError, match="no such thing"):
        moving(tmp_path / "a.mp4", 2, 1.0)
