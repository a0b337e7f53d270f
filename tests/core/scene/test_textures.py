"""Pictures made smaller: means, and a memory with a bound."""

from __future__ import annotations

import gc
import threading

import numpy as np
import pytest

from bozzetto.scene.renderer.mipmaps import LevelCache, level, rung


def noise(height, width, *, clear=False):
    pixels = np.random.default_rng(height * width).integers(0, 256, (height, width, 4), np.uint8)
    if not clear:
        pixels[..., 3] = 255
    return pixels


def shown(pixels):
    """Colours multiplied by opacity, and opacity; 0 … 255."""
    result = pixels.astype(float)
    result[..., :3] *= result[..., 3:] / 255
    return result


@pytest.mark.parametrize("clear", [False, True])
@pytest.mark.parametrize(("across", "down"), [(1, 1), (2, 2), (3, 1), (6, 4), (12, 8), (4, 24)])
def test_a_level_is_the_mean_of_what_shows(across, down, clear):
    pixels = noise(48, 72, clear=clear)
    blocks = shown(pixels).reshape(48 // down, down, 72 // across, across, 4)
    # one rounding to whole numbers for each step, and one for the opacity
    np.testing.assert_allclose(level(pixels, across, down), blocks.mean((1, 3)), atol=1.6)


@pytest.mark.parametrize("size", [(1, 1), (1, 97), (31, 41), (64, 96)])
@pytest.mark.parametrize("factors", [(2, 2), (3, 4), (48, 48), (1, 8)])
def test_a_level_is_all_of_the_picture_and_nothing_else(size, factors):
    pixels = noise(*size, clear=True)
    small = level(pixels, *factors)
    assert small.shape[0] == max(1, round(size[0] / factors[1]))
    assert small.shape[1] == max(1, round(size[1] / factors[0]))
    np.testing.assert_allclose(small.mean((0, 1)), shown(pixels).mean((0, 1)), atol=1.6)


def test_an_opaque_picture_is_its_own_first_level():
    pixels = noise(5, 6)
    assert level(pixels, 1, 1) is pixels
    assert level(pixels, 2, 2) is level(pixels, 2, 2), "and others are made once"


@pytest.mark.parametrize("size", [1, 2, 3, 50, 4096])
def test_rungs_are_near_and_within_the_picture(size):
    for footprint in np.geomspace(1e-3, 1e5, 200):
        found = rung(footprint, size)
        assert 1 <= found <= size
        wanted = min(max(footprint, 1.0), size)
        assert max(found / wanted, wanted / found) <= 1.5


def test_the_memory_keeps_to_its_bound_and_forgets_the_oldest():
    kept = LevelCache(1000)
    pictures = [noise(2, 2) for _ in range(6)]
    for picture in pictures:
        kept.get(picture, "a", lambda: np.zeros(300, np.uint8))
        assert kept.held <= 1000
    made = []
    for picture in pictures:
        kept.get(picture, "a", lambda: made.append(1) or np.zeros(300, np.uint8))
    assert len(made) == 6, "each was gone when it was asked for again, the oldest first"
    last = kept.get(pictures[-1], "a", lambda: np.ones(1, np.uint8))
    assert len(last) == 300
    assert not last.flags.writeable


def test_what_is_too_large_is_made_but_not_kept():
    kept = LevelCache(10)
    assert len(kept.get(noise(1, 1), "a", lambda: np.zeros(11, np.uint8))) == 11
    assert kept.held == 0


def test_the_memory_does_not_outlive_its_pictures():
    kept = LevelCache(10**6)
    picture, other = noise(2, 2), noise(2, 3)
    kept.get(picture, "a", lambda: np.zeros(500, np.uint8))
    kept.get(other, "a", lambda: np.zeros(7, np.uint8))
    del picture
    gc.collect()
    assert kept.held == 7, "at once, and not when another picture is looked at"
    assert len(kept.get(other, "a", lambda: np.zeros(9, np.uint8))) == 7


def test_pictures_that_come_and_go_in_threads_leave_nothing():
    kept = LevelCache(2000)

    def look(seed: int) -> None:
        random = np.random.default_rng(seed)
        for _ in range(300):
            picture = noise(2, 2)
            for name in random.permutation(4).tolist():
                kept.get(picture, name, lambda: np.zeros(int(random.integers(900)), np.uint8))

    threads = [threading.Thread(target=look, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    gc.collect()
    assert kept.held == 0
