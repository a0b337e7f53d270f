"""Depth before drawing: the plane and the dot agree with the part; what floats is pulled on."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.document.storage.bozz_file import read_document
from bozzetto.errors import UserError
from bozzetto.exchange.ink.ink_json import write_drawing
from bozzetto.geometry import Placement
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.ink.steps import CommandStep, DrawStep, Step
from bozzetto.plugin import Context, Ink, Job, Tap
from bozzetto.plugin.host.registry import Registry
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto.scene.display_list import Points
from bozzetto.testing import Pen
from bozzetto.view.standard_views import standard_view
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.solids.evaluate import tree_body
from bozzetto_silhouette.tools import DrawOutline, attachment
from bozzetto_silhouette.tools.attachment import attach, floating_part
from bozzetto_silhouette.tools.hole_filling import fill
from tests.plugins.silhouette import bodies as b

PEN, TOOL, MODELER = Pen(), DrawOutline(), Silhouette()
BODY = TOOL.apply(SilhouetteState(), Ink((PEN.circle(600, 450, 200),), True), Context())


def context_of(state: SilhouetteState, camera) -> Context:
    result = MODELER.solve(state, Job(quality="preview"))
    return Context(
        camera=camera, scene=Scene((Layer("shape", (Shaded(result.shown),), owner="x"),))
    )


@pytest.mark.parametrize("view", ["right", "top", "three-quarter"])
def test_the_dot_lies_where_the_part_will_begin(view: str) -> None:
    camera = standard_view(PEN.camera, view)
    context = context_of(BODY, camera)
    for x, y in ((600.0, 450.0), (640.0, 400.0), (60.0, 60.0)):
        tap = Tap(x, y, camera)
        scene = TOOL.preview(BODY, tap, context)
        (dot,) = (item for item in scene.layers[0].items if isinstance(item, Points))
        seen, _ = camera.project(dot.points)
        assert seen[0] == pytest.approx((x, y), abs=0.5)
        hit = context.surface_hit(camera.rays([(x, y)]))
        assert (dot.opacity == 1.0) == bool(hit.hit[0])
        if hit.hit[0]:
            assert dot.points[0] == pytest.approx(hit.points[0], abs=1e-3)
        limb = Pen(camera).circle(x, y, 20.0)
        drawn = TOOL.apply(BODY, Ink((limb,), True), context).parts[-1]
        begin = context.surface_hit(camera.rays([(limb.x[0], limb.y[0])]))
        if begin.hit[0]:
            away = (begin.points[0] - drawn.sheet.origin) @ drawn.sheet.normal
            assert away == pytest.approx(0.0, abs=1e-6)


def floating(offset: tuple[float, float, float], view: str = "front") -> SilhouetteState:
    camera = standard_view(PEN.camera, view)
    state = TOOL.apply(BODY, Ink((Pen(camera).circle(600, 450, 40),), True), Context(camera=camera))
    if len(state.parts) == 1:  # a hole: it was drawn on the same sheet
        state = TOOL.apply(BODY, Ink((PEN.circle(600, 80, 40),), True), Context())
    part = state.parts[-1]
    return state.with_node(type(part)(**{**vars(part), "pose": Placement(offset=offset)}))


@pytest.mark.parametrize(
    ("offset", "view"), [((0, 0, 60), "front"), ((150, 0, 0), "right"), ((0, -200, 9), "right")]
)
def test_what_floats_is_offered_to_be_pulled_on_and_then_touches(offset, view) -> None:
    state = floating(offset, view)
    before = tree_body(state, 48)
    assert before is not None
    assert len(as_pieces(before)) == 2
    assert "touches nothing" in MODELER.next_step(state, TOOL).sentence
    whole = attach(state, Context())
    assert "touches nothing" not in MODELER.next_step(whole, TOOL).sentence
    after = tree_body(whole, 48)
    assert after is not None
    b.assert_sound(after)
    assert len(as_pieces(after)) == 1
    assert b.volume(after) > 0.85 * b.volume(before)  # it sits on the shape, and not inside
    with pytest.raises(UserError, match="touches"):
        attach(whole, Context())


def as_pieces(body) -> list:
    return body.manifold.decompose()


def test_alone_nothing_floats() -> None:
    assert "touches nothing" not in MODELER.next_step(BODY, TOOL).sentence
    with pytest.raises(UserError, match="touches"):
        attach(BODY, Context())


def test_a_tap_beyond_the_plane_shows_nothing() -> None:
    assert TOOL.preview(BODY, Tap(np.nan, 4.0, PEN.camera), Context()).layers == ()


def test_what_overlaps_is_known_without_uniting_the_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is asked after every stroke, and uniting many parts takes seconds."""
    side = standard_view(PEN.camera, "right")
    state = TOOL.apply(BODY, Ink((Pen(side).circle(640, 450, 60),), True), context_of(BODY, side))
    assert len(state.parts) == 2

    def united(*_: object) -> None:
        raise AssertionError("the rest was united")

    monkeypatch.setattr(attachment, "shape_seen", united)
    assert floating_part(state) is None
    swallowed = state.with_node(replace(state.parts[1], pose=Placement(scale=0.5)))
    assert floating_part(swallowed) is None


def steps_of(*strokes: Stroke, then: tuple[Step, ...] = ()) -> bytes:
    """An ink file in which each stroke is drawn by itself, and then something is done."""
    drawn = tuple(DrawStep("draw", (k,)) for k in range(len(strokes)))
    return write_drawing(Drawing(Strokes(strokes), PEN.camera, steps=(*drawn, *then)))


def built(folder: Path, ink: bytes) -> tuple[dict[str, object], SilhouetteState]:
    """What the command line makes of an ink file: its report, and the state in the document."""
    source, document, report = (folder / name for name in ("x.json", "x.bozz", "r.json"))
    source.write_bytes(ink)
    words = ["build", "silhouette", str(source), "-o", str(document), "--report", str(report)]
    assert main([*words, "--set", "resolution=48"]) == 0
    ((model,), _) = read_document(document, Registry())
    return json.loads(report.read_text()), model.state


def test_a_file_attaches_and_fills_by_the_same_functions(tmp_path: Path) -> None:
    apart = (PEN.circle(600, 450, 150), PEN.circle(600, 180, 40))
    told, before = built(tmp_path, steps_of(*apart))
    assert told["whole"]["components"] == 2
    problems = told["print"]["problems"]
    assert any("“Part 2” touches nothing. Attach (Shift+A) pulls it on." in p for p in problems)
    told, after = built(tmp_path, steps_of(*apart, then=(CommandStep("attach"),)))
    assert told["whole"]["components"] == 1
    assert "problems" not in told["print"]
    assert after.nodes == attach(replace(before, selected="n2"), Context()).nodes
    pierced = (PEN.circle(600, 450, 60), PEN.circle(610, 455, 200))
    told, before = built(tmp_path, steps_of(*pierced))
    assert told["whole"]["genus"] == 1
    told, after = built(tmp_path, steps_of(*pierced, then=(CommandStep("fill"),)))
    assert told["whole"]["genus"] == 0
    assert after.nodes == fill(before, Context()).nodes


def test_of_many_beads_the_first_are_named_and_none_is_united(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of twenty that touch nothing the rest was united twenty times, after every stroke."""
    state = TOOL.apply(BODY, Ink((PEN.circle(600, 80, 40),), True), Context())
    bead = state.parts[-1]
    for k in range(6):
        place = Placement(offset=(200.0 * (k + 1), 0.0, 0.0))
        state = state.with_node(replace(bead, id=f"b{k}", name=f"Bead {k}", pose=place))

    def united(*_: object) -> None:
        raise AssertionError("the rest was united")

    monkeypatch.setattr(attachment, "shape_seen", united)
    told = attachment.offers_to_attach(state, Job())
    assert len(told) == attachment.MOST_NAMED + 1
    assert all("touches nothing" in sentence for sentence in told[:-1])
    assert told[-1] == f"{len(state.parts) - attachment.MOST_NAMED} parts more touch nothing."
    assert state.parts[-1].operation in ("add", "merge")
