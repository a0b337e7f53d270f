"""Modelers that work on pictures, aim and pin views, without a window."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace

import numpy as np
import pytest

from bozzetto.cli import build as cli_build
from bozzetto.cli import main as cli
from bozzetto.cli.main import main
from bozzetto.document.model import Document
from bozzetto.document.storage.bozz_file import read_document
from bozzetto.errors import UserError
from bozzetto.exchange.import_file import read_drawing, read_image
from bozzetto.geometry import Placement
from bozzetto.images.png import write_png
from bozzetto.parameters import parameter_fields
from bozzetto.plugin import Context, Parameter, Tap, ViewAdvice
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene import Image, Layer, Picture, Points, Scene
from bozzetto.testing import Shell
from bozzetto.testing.checks import CHECKS
from bozzetto.testing.subject import Broken, Subject
from bozzetto.view import Camera
from bozzetto.view.navigation import pan
from bozzetto.workbench.workbench import Workbench
from tests import plugin_package, tracer
from tests.tracer import MODELER, STAND, Tracing

PICTURE = Picture.of(np.full((60, 90, 4), 200, np.uint8), "page")

sketches = plugin_package.fixture_of("tests.tracer", "Sketches")


@pytest.fixture
def registry(sketches):
    return Registry(extra=[sketches.package])


@pytest.fixture
def shell(registry, tmp_path):
    made = Shell(registry, tmp_path)
    made.open(MODELER)
    return made


# -- pictures ---------------------------------------------------------------------------------


def test_a_picture_comes_to_the_model_and_is_kept_with_the_document(shell):
    shell.place(PICTURE)
    assert shell.state.pictures == (PICTURE,)
    shell.reopen()
    (back,) = shell.state.pictures
    np.testing.assert_array_equal(back.pixels, PICTURE.pixels)
    shell.undo()


def test_a_refusal_is_the_modelers(shell):
    for _ in range(3):
        shell.place(PICTURE)
    with pytest.raises(UserError, match="Three sketches are enough"):
        shell.place(PICTURE)


def test_modelers_without_pictures_refuse_in_words(registry):
    bench = Workbench(registry)
    model = bench.create("bozzetto.silhouette", Context())
    with pytest.raises(UserError, match="Silhouette takes no pictures"):
        bench.sources.with_picture(model, PICTURE, Context())
    assert not bench.sources.takes_pictures("bozzetto.silhouette")
    assert bench.sources.takes_pictures(MODELER)


def test_damaged_bytes_are_the_files_fault_and_not_the_plugins(shell):
    damaged = Picture("x", np.frombuffer(b"rubbish", np.uint8), 4, 4)
    with pytest.raises(UserError, match="damaged"):
        shell.place(damaged)
    assert shell.registry.guard.faults("tracer.plugin") == 0


@pytest.mark.parametrize("wrong", [None, 3, PICTURE, Tracing(pictures=[PICTURE])])
def test_a_wrong_answer_is_a_fault(shell, sketches, wrong):
    sketches.take = lambda state, picture: wrong
    with pytest.raises(PluginFault, match="add_picture gave what cannot be used"):
        shell.place(PICTURE)


def test_the_context_comes_in_the_models_frame(shell, sketches):
    seen = []
    turned = Placement(offset=(100.0, 0.0, 0.0))
    sketches.add_picture = lambda state, picture, context: seen.append(context) or state
    model = replace(shell.model, placement=turned)
    shell.workbench.sources.with_picture(model, PICTURE, Context(camera=STAND))
    assert seen[0].camera.eye == pytest.approx((STAND.eye[0] - 100.0, *STAND.eye[1:]))


# -- facts ------------------------------------------------------------------------------------


@pytest.fixture
def marks(tmp_path):
    write_png(tmp_path / "a.png", np.full((6, 8, 4), 77, np.uint8))
    path = tmp_path / "marks.json"
    path.write_text(json.dumps({"template": "sedan", "image": {"file": "a.png"}}))
    return path


def test_facts_and_pictures_of_a_file_reach_the_modeler(registry, marks):
    model = Workbench(registry).sources.from_drawing(
        MODELER, read_drawing(marks), {"length": 4200.0}
    )
    assert model.state.template == "sedan"
    assert model.state.pictures[0].pixels[0, 0, 0] == 77
    assert (model.name, model.state.length) == ("marks", 4200.0)


def test_a_file_is_told_by_its_key(registry, make_package):
    assert registry.info(MODELER).facts == ("template",)
    assert registry.told_by({"template": "sedan", "x": 1}) == MODELER
    assert registry.told_by({"x": 1}) == ""
    other = tracer.MANIFEST.replace("tracer.", "second.")
    twice = Registry(extra=[*_packages(registry), make_package("", other)])
    assert twice.told_by({"template": "sedan"}) == ""


def _packages(registry):
    return [info.package for info in registry.plugins() if info.id == "tracer.plugin"]


def test_modelers_without_a_use_for_facts_say_so(registry, marks):
    with pytest.raises(UserError, match="no strokes"):
        Workbench(registry).sources.from_drawing("bozzetto.silhouette", read_drawing(marks), {})


@pytest.fixture
def bozzetto(registry, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(cli_build, "workbench", lambda: Workbench(registry))
    monkeypatch.chdir(tmp_path)

    def run(*words):
        return main(list(words)), capsys.readouterr().err

    return run


def test_a_sketch_can_be_built_from(bozzetto, registry, tmp_path):
    write_png(tmp_path / "page.png", np.full((60, 90, 4), 200, np.uint8))
    code, _ = bozzetto("build", "sketches", "page.png", "-o", "x.bozz", "--set", "length=0")
    assert code == 0
    document, _ = read_document(tmp_path / "x.bozz", registry)
    (model,) = document
    assert (model.name, model.state.pictures[0].width) == ("page", 90)
    code, said = bozzetto("build", "silhouette", "page.png", "-o", "y.bozz")
    assert code == 2
    assert "takes no pictures" in said
    assert not (tmp_path / "y.bozz").exists()


def test_marks_can_be_built_from(bozzetto, marks, tmp_path):
    assert bozzetto("build", "sketches", "marks.json", "-o", "x.obj")[0] == 0
    assert (tmp_path / "x.obj").exists()
    (tmp_path / "a.png").unlink()
    code, said = bozzetto("build", "sketches", "marks.json", "-o", "z.obj")
    assert code == 2
    assert "“a.png” is not there" in said


# -- what hangs on a view ----------------------------------------------------------------------


def test_pictures_of_a_document_show_what_hangs_on_the_view(shell):
    shell.place(PICTURE)
    bench, document = shell.workbench, shell.document
    shown = bench.advice_scene(document, STAND.with_viewport(300, 200))
    assert [item.pixels is PICTURE.pixels for _, item in shown.items() if isinstance(item, Image)]
    assert {layer.owner for layer in shown.layers} == {shell.model.id}
    assert bench.advice_scene(document, Camera()).layers == ()
    hidden = Document((replace(shell.model, visible=False),))
    assert bench.advice_scene(hidden, STAND).layers == ()


def test_a_rendered_document_looks_as_in_the_window(
    bozzetto, registry, sketches, monkeypatch, tmp_path
):
    monkeypatch.setattr(cli, "workbench", lambda: Workbench(registry))
    write_png(tmp_path / "page.png", np.full((60, 90, 4), 200, np.uint8))
    bozzetto("build", "sketches", "page.png", "-o", "x.bozz", "--set", "length=5")
    size = ("--size", "120x90", "--view", "front")
    assert bozzetto("render", "x.bozz", "-o", "plain.png", *size)[0] == 0
    seen = []

    def advise(state, camera):
        seen.append(camera)
        place = camera.on_plane([(60.0, 45.0)], camera.target, camera.axes[2])
        dot = Points(place.astype(np.float32), color=(0, 0, 255), size=20.0, hidden="show")
        return ViewAdvice("good", "x", scene=Scene((Layer("dot", (dot,)),)))

    sketches.view_advice = advise
    assert bozzetto("render", "x.bozz", "-o", "advised.png", *size)[0] == 0
    plain, advised = (read_image(tmp_path / name) for name in ("plain.png", "advised.png"))
    assert seen[0].viewport == (120.0, 90.0)
    assert tuple(advised[45, 60, :3]) == (0, 0, 255)
    changed = np.argwhere((plain != advised).any(2))
    assert len(changed) > 0
    assert np.abs(changed - (45, 60)).max() <= 11


# -- advice, aims, zero ------------------------------------------------------------------------


def test_pinned_comes_through(shell):
    shell.place(PICTURE)
    assert shell.advice(STAND).pinned
    assert shell.advice(pan(STAND, 50.0, 20.0, eye_fixed=True)).pinned
    assert not shell.advice(pan(STAND, 50.0, 20.0)).pinned


def test_pinned_is_yes_or_no(shell, sketches):
    sketches.view_advice = lambda state, camera: ViewAdvice("good", "x", pinned=1)
    with pytest.raises(PluginFault, match="pinned"):
        shell.advice(STAND)


def test_aims_is_yes_or_no(shell, monkeypatch):
    monkeypatch.setattr(tracer.Mark, "aims", "yes")
    with pytest.raises(PluginFault, match=r"Mark\.aims"):
        shell.tools()


def test_words_for_zero():
    (field,) = parameter_fields(Tracing)
    assert field.parameter.zero == "as drawn"
    for wrong in ({"minimum": 1.0}, {"maximum": -1.0}):
        with pytest.raises(TypeError, match="range"):
            Parameter("Length", zero="as drawn", **wrong)
    with pytest.raises(TypeError):
        Parameter("Length", zero=0)


# -- the suite ---------------------------------------------------------------------------------

# A process of its own knows nothing of the misdeeds.
QUICK = [check for check in CHECKS if check.name not in ("elsewhere", "fresh_process")]


def drawn(shell, pen):
    shell.place(PICTURE)
    shell.camera = STAND
    shell.tap(500.0 + pen.seed, 400.0)


@pytest.fixture
def subject(sketches):
    return Subject(MODELER, (sketches.package,), drawn)


def failing(subject):
    names = set()
    for check in QUICK:
        try:
            check.run(subject)
        except (Broken, PluginFault):
            names.add(check.name)
    return names


def test_a_good_modeler_passes(subject):
    assert failing(subject) == set()


@dataclass(frozen=True)
class Other:
    pass


@pytest.mark.parametrize(
    "take", [lambda state, picture: 1 / 0, lambda state, picture: Other()], ids=["fails", "other"]
)
def test_a_modeler_that_fails_over_pictures_is_found(subject, sketches, take):
    subject = replace(subject, sketch=lambda shell, pen: None)
    sketches.take = take
    (check,) = (check for check in CHECKS if check.name == "pictures")
    with pytest.raises((Broken, PluginFault)):
        check.run(subject)


def test_a_view_that_does_not_stay_pinned_is_found(subject, sketches):
    def advise(state, camera):
        pinned = camera == Camera()
        return ViewAdvice("good", "x", pinned=pinned)

    sketches.view_advice = advise
    assert failing(subject) == {"view_advice"}


def test_a_tool_that_aims_and_takes_ink_is_found(subject, monkeypatch):
    monkeypatch.setattr(tracer.Mark, "gesture", "ink")
    (check,) = (check for check in CHECKS if check.name == "aims")
    with pytest.raises(Broken, match="cannot take ink"):
        check.run(replace(subject, sketch=lambda shell, pen: None))


def test_a_preview_that_fails_over_a_tap_is_found(subject, monkeypatch):
    def preview(self, state, gesture, context):
        if isinstance(gesture, Tap) and gesture.y > 1000:
            raise ValueError("far out")
        return tracer.scene_of(state)

    monkeypatch.setattr(tracer.Mark, "preview", preview)
    (check,) = (check for check in CHECKS if check.name == "aims")
    with pytest.raises(PluginFault, match="far out"):
        check.run(subject)
