"""Turntables: what turns stays in the picture, and turns the right way."""

from __future__ import annotations

import json
import shutil
import subprocess

import numpy as np
import pytest
from PIL import Image

from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.scene import LIGHT, Layer, Scene, Shaded
from bozzetto.scene import Image as Picture
from bozzetto.scene.turntable import (
    MOST_PICTURES,
    pictures_from_sketch,
    turned,
    turned_pictures,
)
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


# -- from the sketch ------------------------------------------------------------------------------

VIEW = Camera(eye=(120.0, -480.0, 90.0), viewport=(1200.0, 900.0))
ABOVE = Camera(eye=(0.0, -1.0, 500.0), viewport=(1200.0, 900.0))


def stroke(begin, end, camera=VIEW):
    """A straight stroke of fifty samples, px."""
    places = np.linspace(begin, end, 50)
    return Stroke(places[:, 0], places[:, 1], camera)


LOW, HIGH = stroke((300, 600), (900, 600)), stroke((300, 300), (900, 300))


def film_of(strokes, camera=VIEW, scene=None, count=8, lead=10):
    return list(
        pictures_from_sketch(
            scene_of() if scene is None else scene, strokes, camera, count, lead, size=SIZE
        )
    )


def test_ink_comes_in_its_order_and_never_goes_while_it_is_drawn():
    pictures = [inked(one) for one in film_of((LOW, HIGH))[:6]]
    amount = [int(one.sum()) for one in pictures]
    assert amount == sorted(amount)
    assert amount[0] > 0
    for later, earlier in zip(pictures[1:], pictures, strict=False):
        assert not (earlier & ~later).any()
    below = pictures[2]
    assert below[:45].sum() == 0, "the stroke that was drawn last is not there yet"
    assert pictures[-1][:45].any()


def test_the_shape_takes_the_place_of_its_ink_in_the_same_view():
    """Where ink was drawn around a box there is the box, and the film has all of its pictures."""
    from bozzetto.scene import render

    whole = film_of((LOW,), lead=20)
    assert len(whole) == 28
    seen = VIEW.with_viewport(*map(float, SIZE))
    still = inked(render(scene_of(), seen, LIGHT, size=SIZE))
    first = inked(whole[20])
    assert (still != first).mean() < 0.01
    shares = [np.abs(one.astype(int) - whole[20]).mean() for one in whole[12:20]]
    assert shares == sorted(shares, reverse=True)


def test_all_that_turns_comes_into_the_picture():
    near = Camera(eye=(60.0, -140.0, 20.0), viewport=(1200.0, 900.0))
    whole = film_of((stroke((300, 600), (900, 600), near),), near)
    for pixels in whole[10 + 2 :]:
        seen = inked(pixels)
        assert seen.any()
        assert not np.concatenate([seen[0], seen[-1], seen[:, 0], seen[:, -1]]).any()


def test_what_was_drawn_from_above_is_seen_from_the_side_when_it_turns():
    whole = film_of((stroke((300, 600), (900, 600), ABOVE),), None)
    top, side = inked(whole[10]), inked(whole[10 + 4])
    assert top.any(axis=1).sum() < 0.6 * side.any(axis=1).sum(), "30 mm high, and 10 mm deep"


def test_the_view_is_the_persons_own_if_something_was_drawn_there_or_else_the_fullest():
    other = Camera(eye=(-400.0, -300.0, 200.0), viewport=(1200.0, 900.0))
    strokes = (LOW, stroke((300, 300), (900, 300), other), stroke((300, 500), (900, 500), other))
    own, fullest = film_of(strokes, VIEW), film_of(strokes, None)
    np.testing.assert_array_equal(own[5], film_of((LOW,), VIEW)[5])
    np.testing.assert_array_equal(fullest[5], film_of(strokes[1:], None)[5])
    np.testing.assert_array_equal(fullest[5], film_of(strokes, ABOVE)[5])


def test_a_picture_is_a_sketch_too_and_goes():
    picture = Picture(
        np.full((4, 4, 4), (200, 30, 30, 255), np.uint8),
        (-100.0, 0.0, 80.0), (200.0, 0.0, 0.0), (0.0, 0.0, -160.0),
    )  # fmt: skip
    scene = scene_of() + Scene((Layer("sketch", (picture,)),))
    whole = film_of((), scene=scene)
    reddish = [(one[..., 0].astype(int) - one[..., 1] > 60).sum() for one in whole]
    assert reddish[0] > 1000
    assert not any(reddish[10:])


@pytest.mark.parametrize("turn", [0.0, 0.7, 2.5])
def test_a_picture_alone_begins_the_turn_seen_from_its_front(turn):
    """Nobody has drawn or looked at it: all of it is seen, upright, its left half left."""
    pixels = np.full((8, 8, 4), (30, 200, 30, 255), np.uint8)
    pixels[:4, :4] = 200, 30, 30, 255
    way = np.array((np.cos(turn), np.sin(turn), 0.0))
    corner = (-100.0 * way + (0.0, 0.0, 80.0)).tolist()
    picture = Picture(pixels, tuple(corner), tuple((200.0 * way).tolist()), (0.0, 0.0, -160.0))
    first = film_of((), None, scene=scene_of() + Scene((Layer("sketch", (picture,)),)))[0]
    red = np.argwhere(first[..., 0].astype(int) - first[..., 1] > 60)
    green = np.argwhere(first[..., 1].astype(int) - first[..., 0] > 60)
    assert len(red) > 1000
    assert len(green) == pytest.approx(3 * len(red), rel=0.1)
    assert (red.mean(axis=0) < green.mean(axis=0)).all()
    both = np.concatenate([red, green])
    assert (both.min(axis=0) > 0).all()
    assert (both.max(axis=0) < np.subtract(first.shape[:2], 1)).all()


def test_without_a_sketch_it_says_so():
    with pytest.raises(UserError, match="no sketch"):
        film_of(())
    with pytest.raises(UserError, match="pictures"):
        film_of((LOW,), lead=1)
