"""The display list: what of it is looked at when a scene is framed."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.scene import Image, Layer, Lines, Points, Scene
from bozzetto.scene.display_list import MOST_FRAMED


def test_a_picture_behind_things_is_not_framed_with_them():
    pixels = np.zeros((2, 2, 4), np.uint8)
    image = Image(pixels, (-900.0, 500.0, 900.0), (1800.0, 0.0, 0.0), (0.0, 0.0, -1800.0))
    line = Lines(np.array([[0, 0, 0], [10, 0, 5]], np.float32))
    handle = Points(np.array([[400, 0, 0]], np.float32))
    alone = Scene((Layer("underlay", (image,)),))
    assert np.ptp(alone.points(), axis=0).tolist() == [1800.0, 0.0, 1800.0]
    both = alone + Scene((Layer("curve", (line,)), Layer("marks", (handle,), tool="mark")))
    assert np.ptp(both.points(), axis=0).tolist() == [10.0, 0.0, 5.0]


def test_lines_may_be_none_at_all():
    """As a modeler makes them that has nothing to show: no points, and no beginnings."""
    nothing = Lines(np.zeros((0, 3), np.float32), np.zeros(0, np.int32))
    assert list(nothing.pieces()) == []
    assert list(Lines(np.zeros((0, 3), np.float32)).pieces()) == []


def test_a_scene_that_is_put_off_is_made_once_and_only_if_it_is_looked_at():
    made = []

    def make():
        made.append(len(made))
        if len(made) == 1:
            raise UserError("Not yet.")
        return Scene((Layer("ink", (Lines(np.array([[0, 0, 0], [10, 0, 5]], np.float32)),)),))

    scene = Scene.put_off(make)
    moved = scene.placed(Placement(offset=(5.0, 0.0, 0.0)))
    assert not made
    assert not scene.is_made
    with pytest.raises(UserError):
        scene.items().__next__()
    assert moved.bounds()[:, 0].tolist() == [5.0, 15.0]
    assert scene.is_made
    assert scene.bounds()[:, 0].tolist() == [0.0, 10.0]
    assert [layer.name for layer in (scene + moved).layers] == ["ink", "ink"]
    assert len(made) == 2, "once in vain, and once"
    with pytest.raises(AttributeError):
        scene.nothing  # noqa: B018


def test_of_a_sum_is_known_what_is_not_put_off():
    line = Lines(np.array([[0, 0, 0], [10, 0, 5]], np.float32))
    rest = Scene((Layer("rest", (line,)),))
    made = []

    def make():
        made.append(1)
        return Scene((Layer("own", (line,)),))

    both = rest + Scene.put_off(make)
    moved = both.placed(Placement(offset=(5.0, 0.0, 0.0)))
    assert [layer.name for layer in both.known.layers] == ["rest"]
    assert moved.known.bounds()[:, 0].tolist() == [5.0, 15.0]
    assert not Scene.put_off(make).known.layers
    assert not made
    assert [layer.name for layer in moved.layers] == ["rest", "own"]
    assert [layer.name for layer in both.known.layers] == ["rest", "own"]
    assert made == [1]


def _cloud(count, seed, owner=""):
    points = np.random.default_rng(seed).normal(size=(count, 3)).astype(np.float32)
    return Layer(f"cloud {seed}", (Points(points), Lines(points + 5.0)), owner)


def test_all_points_of_a_small_scene_are_framed():
    layers = (_cloud(10, 1), _cloud(7, 2), Layer("nothing"))
    wanted = np.concatenate([item.points for layer in layers for item in layer.items])
    assert np.array_equal(Scene(layers).points(), wanted.astype(float))


@pytest.mark.parametrize("sizes", [(200_000,), (1,) * 50_000, (100_000, 3, 40_000, 1)])
def test_of_a_large_scene_some_points_of_everything_are_framed(sizes):
    layers = tuple(
        Layer(str(k), (Points(np.full((size, 3), k, np.float32)),)) for k, size in enumerate(sizes)
    )
    found = Scene(layers).points()
    assert len(found) <= MOST_FRAMED + len(sizes)
    assert set(found[:, 0].astype(int)) == set(range(len(sizes)))


def test_points_of_a_layer_are_put_together_once():
    """A window with hundreds of objects looks at all of them whenever one is chosen."""
    layer = _cloud(10, 1)
    assert layer.points is layer.points
    assert np.array_equal(Scene((layer,)).points(), Scene((layer, Layer("nothing"))).points())


def test_bounds_are_those_of_everything_that_has_a_place():
    layers = (_cloud(10, 1), _cloud(7, 2), Layer("nothing"))
    everything = np.concatenate([item.points for layer in layers for item in layer.items])
    wanted = [everything.min(axis=0), everything.max(axis=0)]
    assert np.array_equal(Scene(layers).bounds(), wanted)
    for empty in (Scene(), Scene((Layer("nothing"), Layer("none", (Lines(np.zeros((0, 3))),))))):
        assert np.isnan(empty.bounds()).all()
        assert empty.bounds().shape == (2, 3)
