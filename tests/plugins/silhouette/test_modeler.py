"""The modeler: what it solves, remembers and hands over."""

from __future__ import annotations

from dataclasses import replace

import manifold3d
import numpy as np
import pytest

from bozzetto.errors import Cancelled, UserError
from bozzetto.geometry import Mesh, Placement
from bozzetto.ink import Drawing, Strokes
from bozzetto.plugin import Context, Ink, Job
from bozzetto.plugin.cache import Memory, forget_all
from bozzetto.scene import Scene
from bozzetto.testing import Pen
from bozzetto_silhouette.inflation.solidify import solidify
from bozzetto_silhouette.model.state import Group, SilhouetteState
from bozzetto_silhouette.modeler import PREVIEW_RESOLUTION, Silhouette
from bozzetto_silhouette.solids import part_solid as leaf

PEN, MODELER = Pen(), Silhouette()


def drawn(*circles: tuple[float, float, float], **parameters: object) -> SilhouetteState:
    state = SilhouetteState(**parameters)
    tool = MODELER.tools()[0]
    for circle in circles:
        state = tool.apply(state, Ink((PEN.circle(*circle),), True), Context())
    return state


@pytest.fixture
def forgetful() -> None:
    """Nothing is remembered from other tests."""
    forget_all()


def body(mesh: Mesh) -> manifold3d.Manifold:
    given = manifold3d.Mesh(
        np.array(mesh.vertices, np.float32), np.array(mesh.faces, dtype=np.uint32)
    )
    return manifold3d.Manifold(given)


def test_the_preview_is_coarser_and_the_final_as_asked(
    monkeypatch: pytest.MonkeyPatch, forgetful: None
) -> None:
    asked: list[int] = []

    def counting(*given, resolution: int, **more):
        asked.append(resolution)
        return solidify(*given, resolution=32, **more)

    monkeypatch.setattr(leaf, "solidify", counting)
    for resolution in (32, 160):
        for quality in ("preview", "final"):
            MODELER.solve(drawn((500, 400, 120), resolution=resolution), Job(quality))
    assert asked == [32, PREVIEW_RESOLUTION, 160]  # 32 cells serve as preview and as final
    assert PREVIEW_RESOLUTION <= 64


def test_only_parts_that_changed_are_solved_again(
    monkeypatch: pytest.MonkeyPatch, forgetful: None
) -> None:
    solved: list[object] = []

    def counting(outline, **more):
        solved.append(outline)
        return solidify(outline, **more)

    monkeypatch.setattr(leaf, "solidify", counting)
    one = drawn((300, 400, 90), resolution=32)
    first = MODELER.solve(one, Job())
    tool = MODELER.tools()[0]
    two = tool.apply(one, Ink((PEN.circle(800, 400, 90),), True), Context())
    assert MODELER.solve(two, Job()).solids["n1"] is first.solids["n1"]
    assert len(solved) == 2


def test_cancelling_at_any_step_leaves_nothing_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    state = drawn((300, 400, 90), (700, 400, 110), resolution=32)
    forget_all()
    steps: list[tuple[float, str]] = []
    whole = MODELER.solve(state, Job(progress=lambda *step: steps.append(step)))
    fractions = [fraction for fraction, _ in steps]
    assert fractions == sorted(fractions)
    assert 0.0 <= fractions[0] <= fractions[-1] <= 1.0
    for number in range(len(steps)):
        forget_all()
        passed = 0

        def cancelled(number: int = number) -> bool:
            nonlocal passed
            passed += 1
            return passed > number

        with pytest.raises(Cancelled):
            MODELER.solve(state, Job(cancelled=cancelled))
        again = MODELER.solve(state, Job())
        assert np.array_equal(again.mesh.vertices, whole.mesh.vertices)
        assert np.array_equal(again.mesh.faces, whole.mesh.faces)


def test_memory_forgets_the_oldest_and_keeps_no_failure() -> None:
    memory: Memory[int] = Memory(limit=2)
    calls: list[str] = []

    def ask(name: str) -> int:
        return memory.recall(name, lambda: calls.append(name) or len(calls))

    assert [ask(n) for n in ("a", "b", "a", "c", "a", "b")] == [1, 2, 1, 3, 1, 4]

    def failing() -> int:
        raise Cancelled("step")

    with pytest.raises(Cancelled):
        memory.recall("d", failing)
    assert memory.recall("d", lambda: 7) == 7


def alone(state: SilhouetteState, number: int) -> manifold3d.Manifold:
    """One part of a state by itself."""
    return body(MODELER.solve(replace(state, nodes=state.nodes[number : number + 1]), Job()).mesh)


def test_shapes_of_overlapping_parts_are_one_solid() -> None:
    state = drawn((500, 400, 150), (680, 400, 150), resolution=48)
    state = state.with_node(replace(state.nodes[1], blend=0.0))
    (solid,) = MODELER.shapes(state, MODELER.solve(state, Job())).solids
    one, other = alone(state, 0), alone(state, 1)
    whole = body(solid.mesh)
    assert whole.status().name == "NoError"
    assert len(whole.decompose()) == 1
    expected = one.volume() + other.volume() - (one ^ other).volume()
    assert (one ^ other).volume() > 0.05 * one.volume()
    assert whole.volume() == pytest.approx(expected, rel=1e-4)


def test_shapes_of_separate_parts_keep_both() -> None:
    state = drawn((300, 400, 90), (800, 400, 120), resolution=48)
    shapes = MODELER.shapes(state, MODELER.solve(state, Job()))
    whole = body(shapes.solids[0].mesh)
    assert len(whole.decompose()) == 2
    total = alone(state, 0).volume() + alone(state, 1).volume()
    assert whole.volume() == pytest.approx(total, rel=1e-5)
    assert len(shapes.skeletons) == 2


def test_a_circle_is_a_ball_in_the_world_where_it_was_drawn() -> None:
    state = drawn((600, 450, 200), resolution=64)
    mesh = MODELER.solve(state, Job()).mesh
    radius = 200.0 / PEN.camera.pixels_per_mm
    away = np.linalg.norm(mesh.vertices.astype(float), axis=1)
    assert away == pytest.approx(np.full(len(away), radius), rel=0.02)
    assert body(mesh).volume() == pytest.approx(4 / 3 * np.pi * radius**3, rel=0.03)
    outward = (mesh.normals * mesh.vertices).sum(axis=1) / radius
    assert outward == pytest.approx(np.ones(len(outward)), abs=0.03)


def test_scene_shows_ink_before_and_shape_after() -> None:
    state = drawn((600, 450, 200), (600, 450, 60), resolution=32)

    def seen(scene: Scene) -> list[tuple[str, bool]]:
        """Name the layers without handles, and say which are there for the selected alone."""
        return [(layer.name, layer.chosen) for layer in scene.layers if not layer.tool]

    ink = [("ink", False), ("ink", True)]
    assert seen(MODELER.scene(state, None)) == ink
    shown = MODELER.scene(state, MODELER.solve(state, Job()))
    assert seen(shown) == [("shape", False), *ink]
    posed = replace(state, posing=True)
    shown = MODELER.scene(posed, MODELER.solve(posed, Job()))
    assert [layer.name for layer in shown.layers] == ["shape", "joints"]
    assert not MODELER.scene(SilhouetteState(), None).layers


def test_report_tells_the_truth_about_every_part() -> None:
    state = drawn((300, 400, 90), (800, 400, 120), (800, 400, 40), resolution=64)
    parts = MODELER.report(state, MODELER.solve(state, Job()), Job())["parts"]
    assert [part["genus"] for part in parts] == [0, 1]
    assert all(part["watertight"] and part["iou"] > 0.99 for part in parts)


def test_read_drawing_takes_all_strokes_as_one_part() -> None:
    strokes = Strokes((PEN.circle(600, 450, 200), PEN.circle(600, 450, 60)))
    state = MODELER.read_drawing(Drawing(strokes, PEN.camera), Context(), Job())
    assert len(state.parts) == 1
    assert len(state.parts[0].strokes) == 2
    with pytest.raises(UserError, match="no strokes"):
        MODELER.read_drawing(Drawing(Strokes(()), PEN.camera), Context(), Job())
    with pytest.raises(UserError, match="This is a dot"):
        MODELER.read_drawing(Drawing(Strokes((PEN.dot(),)), PEN.camera), Context(), Job())


def test_fifty_parts_remember_their_outlines(monkeypatch: pytest.MonkeyPatch) -> None:
    from bozzetto_silhouette.outline import from_ink as ink_to_outline

    read: list[int] = []
    real = ink_to_outline.rings_from_strokes

    def counting(strokes, **more):
        read.append(len(strokes))
        return real(strokes, **more)

    monkeypatch.setattr(ink_to_outline, "rings_from_strokes", counting)
    places = [(60.0 + 110.0 * (k % 10), 77.0 + 100.0 * (k // 10), 31.0) for k in range(50)]
    assert len(drawn(*places).parts) == 50
    assert len(read) == 50


def test_skeletons_stand_where_their_groups_were_moved() -> None:
    state = drawn((600, 450, 120), resolution=32)
    away = Placement(offset=(7.0, -20.0, 3.0))
    inside = replace(state.nodes[0], within="g")
    grouped = replace(state, nodes=(Group(id="g", pose=away), inside))
    plain, moved = (
        MODELER.shapes(each, MODELER.solve(each, Job())).skeletons[0] for each in (state, grouped)
    )
    assert moved.joints == pytest.approx(plain.joints + away.offset)


def test_what_a_hidden_group_holds_is_not_solved() -> None:
    state = drawn((600, 450, 120), resolution=32)
    inside = replace(state.nodes[0], within="g")
    hidden = replace(state, nodes=(Group(id="g", visible=False), inside))
    assert not MODELER.solve(hidden, Job()).solids


def test_what_was_moved_keeps_the_function_that_was_fitted_to_it() -> None:
    part = drawn((600, 450, 120), resolution=32).nodes[0]
    one, other = (
        leaf.body_of(replace(part, id=name, pose=Placement(offset=(far, 0.0, 0.0))), 32)
        for name, far in (("a", 1.0), ("b", 5.0))
    )
    assert one.implicit.inner is other.implicit.inner
    assert (one.sources, other.sources) == (("a",), ("b",))
