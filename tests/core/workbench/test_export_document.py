"""Objects of a document on their way out: which of them, seen from where, and what is said."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.document.model import Document, Model, OpaqueState, new_id
from bozzetto.errors import UserError
from bozzetto.exchange.handover import Handover
from bozzetto.exchange.svg.path_data import parse_path
from bozzetto.geometry import Curve, Mesh, Shapes, Solid
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.view import Camera
from bozzetto.view.page_views import framing, page_view, shows
from bozzetto.workbench.export_document import (
    ObjectShapes,
    chosen_models,
    object_shapes,
    prepared_files,
)
from bozzetto.workbench.workbench import Workbench

TETRA = Mesh(
    [[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
)
MESH = "bozzetto.mesh"


def prepared_file(objects, path, camera, **more):
    return prepared_files(objects, [path], camera, **more)[0]


def bench_without(*plugins):
    return Workbench(Registry(disabled=plugins))


def solid_model(bench, name="Rock", **changes):
    model = bench.sources.from_shapes(MESH, Shapes(solids=(Solid(TETRA, name),)), name)
    return replace(model, **changes)


def closed(modeler, name="Stranger"):
    return Model(new_id(), name, modeler, OpaqueState(1, b"{}", (), ()))


# -- which objects -----------------------------------------------------------------------------


def test_hidden_objects_stay_behind_unless_they_are_named():
    bench = bench_without()
    document = Document((solid_model(bench), solid_model(bench, "Ghost", visible=False)))
    models, hidden = chosen_models(document, None)
    assert [model.name for model in models] == ["Rock"]
    (said,) = (part.sentence("STL file") for part in hidden)
    assert said.startswith("Left out of the STL file: “Ghost” (it is hidden);")
    named, none = chosen_models(document, ["Ghost"])
    assert [model.name for model in named] == ["Ghost"]
    assert not none
    with pytest.raises(UserError, match="no object Nobody; there are: Rock, Ghost"):
        chosen_models(document, ["Nobody"])


def test_all_objects_of_one_name_go_out():
    bench = bench_without()
    document = Document((solid_model(bench), solid_model(bench)))
    models, _ = chosen_models(document, ["Rock"])
    assert len(object_shapes(bench, models, Job()).shapes.solids) == 2


@pytest.mark.parametrize(
    ("modeler", "said"),
    [
        ("nobody.knows", "is not installed"),
        ("bozzetto.car", "bozzetto.car is switched off"),
        ("bozzetto.silhouette", "cannot read it"),
    ],
)
def test_objects_without_their_plugin_are_named_and_the_others_go(modeler, said):
    bench = bench_without("bozzetto.car")
    objects = object_shapes(bench, [solid_model(bench), closed(modeler)], Job())
    assert len(objects.shapes.solids) == 1
    (warning,) = prepared_file(objects, "a.stl", None).warnings()
    assert "“Stranger”" in warning
    assert said in warning


def test_a_plugin_that_is_switched_off_while_it_is_in_use_counts_as_off():
    bench = bench_without()
    model = solid_model(bench)
    bench.registry.set_disabled(MESH, True)
    (left_out,) = object_shapes(bench, [model], Job()).left_out
    assert "switched off" in left_out.reason


def test_where_nothing_is_left_the_reason_is_said():
    bench = bench_without("bozzetto.car")
    objects = object_shapes(bench, [closed("bozzetto.car", "My car")], Job())
    with pytest.raises(UserError, match=r"nothing to export.*“My car”.*switched off"):
        prepared_file(objects, "a.step", None)
    with pytest.raises(UserError, match="nothing to export yet"):
        prepared_file(ObjectShapes(Shapes()), "a.step", None)


# -- seen from where ---------------------------------------------------------------------------


def curve(size=50.0, at=(0.0, 0.0, 0.0)):
    points = np.array([[0, 0, 0], [1, 0, 2], [2, 1, 1], [3, 0, 0]]) * (size / 3) + at
    return Curve(3, np.repeat((0.0, 1.0), 4), points, name="line")


def drawn(data: bytes) -> np.ndarray:
    """Points on the paths of an SVG, ends of pieces among them."""
    paths = [p for d in re.findall(r'<path d="([^"]*)"', data.decode()) for p in parse_path(d)]
    assert paths
    u = np.linspace(0.0, 1.0, 33)[:, None]
    weights = np.hstack(((1 - u) ** 3, 3 * (1 - u) ** 2 * u, 3 * (1 - u) * u**2, u**3))
    return np.concatenate([weights @ cubic for path in paths for cubic in path.cubics])


@pytest.mark.parametrize("size", [9.0, 50.0, 4e3, 1e6])
@pytest.mark.parametrize("view", [None, "front", "right", "top", "three-quarter"])
def test_an_svg_shows_all_of_it_on_its_page(size, view):
    """Whatever the size, and wherever the document's own view looks."""
    objects = ObjectShapes(Shapes(curves=(curve(size, (5 * size, -size, 2 * size)),)))
    camera = Camera(eye=(0.0, -400.0, 0.0), target=(0.0, 0.0, 0.0))
    data = prepared_file(objects, "a.svg", camera, view=view).data
    x, y, width, height = map(float, re.search(rb'viewBox="([^"]*)"', data)[1].split())
    places = drawn(data)
    low, high = places.min(0), places.max(0)
    assert (low >= (x, y)).all()
    assert (high <= (x + width, y + height)).all()
    if view is not None or size > 1e3:
        assert ((high - low) / (width, height)).max() > 0.5


def test_a_persons_own_view_is_kept_where_all_lies_in_it():
    objects = ObjectShapes(Shapes(curves=(curve(),)))
    camera = Camera(eye=(120.0, -400.0, 90.0), target=(20.0, 0.0, 10.0), viewport=(800, 600))
    data = prepared_file(objects, "a.svg", camera).data
    assert b'viewBox="0 0 800 600"' in data
    exact = camera.project([objects.shapes.curves[0].control_points[0]])[0][0]
    assert np.abs(drawn(data) - exact).max(1).min() < 1e-6


def test_in_the_window_some_of_it_is_enough():
    long = curve(4000.0)
    camera = Camera(eye=(0.0, -400.0, 0.0), target=(0.0, 0.0, 0.0), viewport=(800, 600))
    objects = ObjectShapes(Shapes(curves=(long,)))
    part = prepared_file(objects, "a.svg", camera, whole=False).data
    places = drawn(part)
    assert b'viewBox="0 0 800 600"' in part
    assert (places > -1e-6).all()
    assert (places < np.add((800, 600), 1e-6)).all()
    whole = prepared_file(objects, "a.svg", camera).data
    assert np.ptp(drawn(whole), axis=0).max() > 300


def test_only_flat_files_take_a_view_into_account():
    bench = bench_without()
    objects = object_shapes(bench, [solid_model(bench)], Job())
    assert prepared_file(objects, "a.stl", None).data == prepared_file(
        objects, "a.stl", Camera(eye=(1.0, 2.0, 3.0))
    ).data  # fmt: skip
    with pytest.raises(UserError, match="no view called 'nowhere'"):
        prepared_file(ObjectShapes(Shapes(curves=(curve(),))), "a.svg", None, view="nowhere")
    with pytest.raises(UserError, match="nowhere"):
        prepared_file(ObjectShapes(Shapes(curves=(curve(),))), "a.step", None, view="nowhere")


def test_a_view_that_changes_nothing_is_told():
    objects = ObjectShapes(Shapes(curves=(curve(),)))
    plain = prepared_file(objects, "a.step", None)
    seen = prepared_file(objects, "a.step", None, view="top")
    assert len(seen.notes) == len(plain.notes) + 1


def test_that_a_file_is_no_drawing_is_not_told_beside_a_drawing():
    """Who asks for a blueprint and a STEP file in one export wants both."""
    objects = ObjectShapes(Shapes(curves=(curve(),)))
    blueprint = Handover(lines="blueprint")
    alone = prepared_file(objects, "a.step", None, handover=blueprint)
    step, drawing = prepared_files(objects, ["a.step", "a.svg"], None, handover=blueprint)
    assert any("hold a blueprint" in note for note in alone.notes)
    assert step.notes == drawing.notes == ()


def test_views_of_a_page():
    points = np.random.default_rng(1).normal(size=(50, 3)) * 900
    own = Camera(eye=(0.0, -400.0, 0.0), target=(0.0, 0.0, 0.0))
    assert not shows(own, points)
    assert shows(page_view(points, own), points)
    assert page_view(points, own).viewport == own.viewport
    wide = replace(own, eye=(0.0, -9000.0, 0.0))
    assert page_view(points, wide) == wide
    assert page_view(points, wide, (400.0, 100.0)).viewport == (400.0, 100.0)
    assert page_view(np.zeros((0, 3)), own) == own
    assert framing(points, "top", plans=True).kind == "orthographic"
    assert shows(framing(points, "top", plans=True), points)
    behind = np.array([[0.0, -500.0, 0.0]])
    assert not shows(own, behind)
