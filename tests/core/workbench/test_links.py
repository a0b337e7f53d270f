"""Followers are solved from what they follow, remembered, and say why they cannot be."""

from __future__ import annotations

import itertools
import json
import operator
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.cli.file_facts import facts_of
from bozzetto.document import edit
from bozzetto.document.links import resolved
from bozzetto.document.model import Document, Model, OpaqueState
from bozzetto.document.storage.bozz_file import decode_document, encode_document, write_document
from bozzetto.errors import UserError
from bozzetto.geometry import Curve, Mesh, Placement
from bozzetto.plugin import Job
from bozzetto.plugin.guard import guard
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing import Shell, same
from bozzetto.testing.abilities import check_follow
from bozzetto.testing.subject import Broken, Subject
from bozzetto.workbench.export_document import chosen_models, links_of, object_shapes
from bozzetto.workbench.links import with_sources, with_state
from tests.linked_boxes import CORNERS, FACES, MODELER, BoxState

PREVIEW = Job(quality="preview")


def box(bench, name, *sources, edge=0.0, growth=2.0, **more):
    state = BoxState(edge, growth, more.pop("wrong", False), sources)
    made = replace(bench.new_model(MODELER, state, name.upper()), id=name)
    return replace(made, **more)


def chain(bench, edge=10.0):
    """C follows b, which follows the cube a; each grows what it follows to twice its size."""
    return Document((box(bench, "c", "b"), box(bench, "b", "a"), box(bench, "a", edge=edge)))


def sizes(bench, document, name, job=None):
    shapes = bench.own_shapes(resolved(document)[name], job or Job())
    return [tuple(float(v) for v in np.ptp(part.mesh.vertices, axis=0)) for part in shapes.solids]


def cube(edge):
    return [(edge, edge, edge)]


def test_a_follower_of_a_follower_is_solved_with_all_before_it(bench, boxes):
    document = chain(bench)
    assert sizes(bench, document, "c") == cube(40.0)
    assert [len(state.sources) for state, _ in boxes.solved] == [0, 1, 1]
    assert sizes(bench, document, "b") == cube(20.0)  # solved on the way
    assert len(boxes.solved) == 3


def test_only_what_changed_and_its_followers_are_solved_again(bench, boxes):
    document = chain(bench).with_model(box(bench, "d", edge=3.0))
    for name in "abcd":
        sizes(bench, document, name)
    boxes.solved.clear()
    renamed = edit.rename_model(document, "a", "Other").document
    hidden = edit.show_model(renamed, "a", False).document
    grey = edit.color_model(hidden, "a", (9, 9, 9)).document
    moved_follower = edit.move_model(grey, "b", 0).document
    assert [sizes(bench, moved_follower, n) for n in "abcd"] == [
        sizes(bench, document, n) for n in "abcd"
    ]
    assert boxes.solved == []
    changed = document.with_model(box(bench, "b", "a", growth=3.0))
    assert sizes(bench, changed, "c") == cube(60.0)
    assert [state.growth for state, _ in boxes.solved] == [3.0, 2.0]
    assert sizes(bench, document, "c") == cube(40.0)  # taken back: nothing is solved
    assert len(boxes.solved) == 2


def test_the_order_of_asking_does_not_matter(bench, boxes):
    document = chain(bench)
    answers = []
    for order in itertools.permutations("abc"):
        bench.forget_results()
        answers.append({name: sizes(bench, document, name) for name in order})
    assert all(answer == answers[0] for answer in answers)
    assert len(boxes.solved) == 6 * 3


def test_what_is_seen_of_a_source_is_where_it_stands(bench):
    turned = Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 2.0, (0.0, 0.0, 7.0))
    document = Document((box(bench, "a", edge=10.0), box(bench, "b", "a", growth=1.0)))
    moved = edit.place_model(document, "a", turned).document
    (solid,) = bench.own_shapes(resolved(moved)["b"], Job()).solids
    np.testing.assert_allclose(solid.mesh.bounds, [[-20, 0, 7], [0, 20, 27]], atol=1e-4)
    both = edit.place_model(moved, "b", turned).document  # in its own frame, nothing has moved
    assert sizes(bench, both, "b") == cube(10.0)
    world = bench.shapes([resolved(both)["b"]], Job())
    np.testing.assert_allclose(world.solids[0].mesh.bounds, solid.mesh.bounds, atol=1e-4)


def test_previews_are_made_of_previews_until_the_final_result_is_known(bench, boxes):
    document = chain(bench)
    sizes(bench, document, "c", PREVIEW)
    assert [quality for _, quality in boxes.solved] == ["preview"] * 3
    sizes(bench, document, "a")
    sizes(bench, document, "c")
    boxes.solved.clear()
    assert sizes(bench, document, "b", PREVIEW) == cube(20.0)
    found = resolved(document)
    assert bench.best_result(found["c"]) is bench.result(found["c"], "final")


def test_a_source_that_fails_says_why_at_each_follower_and_is_not_tried_again(bench, boxes):
    document = chain(bench).with_model(box(bench, "a", wrong=True))
    for _ in range(2):
        with pytest.raises(UserError, match=r"“C” follows “B”\. “B” follows “A”\. This box is wr"):
            sizes(bench, document, "c")
    assert len(boxes.solved) == 1
    assert sizes(bench, chain(bench), "c") == cube(40.0)


def test_a_fault_of_a_source_is_counted_once(bench, boxes):
    boxes.fails = True
    document = chain(bench).with_model(box(bench, "a", wrong=True))
    with pytest.raises(PluginFault):
        sizes(bench, document, "a")
    for name in "bcbc":
        with pytest.raises(UserError, match=r"there the plugin linked\.plugin failed|follows “B”"):
            sizes(bench, document, name)
    assert bench.registry.guard.faults("linked.plugin") == 1


def test_missing_sources_and_circles_are_told(bench):
    document = Document((box(bench, "b", "a"),))
    with pytest.raises(UserError, match="“B” was made from an object that is not here"):
        sizes(bench, document, "b")
    circle = Document((box(bench, "a", "b"), box(bench, "b", "a"), box(bench, "c", "b")))
    for name in "abc":
        with pytest.raises(UserError, match="not here, or that follows"):
            sizes(bench, circle, name)


def test_a_source_whose_plugin_is_absent_is_told(bench):
    foreign = Model("a", "A", "absent.modeler", OpaqueState(1, b"{}"))
    document = Document((foreign, box(bench, "b", "a")))
    with pytest.raises(UserError, match=r"“B” follows “A”.*absent.modeler"):
        sizes(bench, document, "b")
    copy = with_sources(bench.registry, replace(foreign, sources=("x",)), ("y",))
    assert copy.sources == ("x",)


def test_frozen_sources_solve_after_save_and_open_and_a_caution_names_them(bench, tmp_path):
    document = edit.delete_models(chain(bench), ["b"]).document
    again, report = decode_document(encode_document(document), bench.registry)
    assert report.warnings == ()
    assert sizes(bench, again, "c") == cube(40.0)
    models, _ = chosen_models(again, None)
    (caution,) = object_shapes(bench, models, Job()).warnings()
    assert caution == "“C” keeps “B” as it was when it stopped following."
    assert object_shapes(bench, resolved(chain(bench)).values(), Job()).warnings() == ()
    path = tmp_path / "kept.bozz"
    write_document(edit.delete_models(chain(bench), ["a"]).document, path)
    told = {each["name"]: each for each in facts_of(path)["objects"]}
    assert told["B"]["frozen"] == ["A"]
    assert told["C"]["follows"] == ["B"]
    assert json.dumps(told)


def test_a_scene_and_an_export_show_followers_of_hidden_sources(bench):
    document = edit.show_model(chain(bench), "a", False).document
    assert {layer.owner for layer in bench.scene(document, Job()).layers} == {"b", "c"}
    models, left_out = chosen_models(document, ["C"])
    assert len(object_shapes(bench, models, Job()).shapes.solids) == 1
    assert left_out == []


def test_a_new_follower_is_made_of_what_is_chosen(bench):
    document = chain(bench)
    found = resolved(document)
    made = bench.sources.following(MODELER, [found["b"], found["a"]], Job())
    assert made.sources == ("b", "a")
    assert made.name == "Boxes"
    together = document.with_model(made)
    assert sizes(bench, together, made.id) == [(30.0,) * 3, (15.0,) * 3]
    empty = box(bench, "e")
    with pytest.raises(UserError, match="no solid"):
        bench.sources.following(MODELER, [empty], Job())
    with pytest.raises(UserError, match="cannot follow"):
        bench.sources.following("bozzetto.mesh", [found["a"]], Job())
    with pytest.raises(UserError, match="Choose the objects"):
        bench.sources.following(MODELER, [], Job())


def test_a_modeler_that_breaks_its_word_on_links_is_blamed(bench, boxes, monkeypatch):
    monkeypatch.setattr(guard, "MOST_FAULTS", 10)  # it fails six times
    guarded = bench.registry.guarded(MODELER)
    for wrong in (7, ["a", "a"], [""], [7], ["../x"]):
        monkeypatch.setattr(type(boxes), "sources", lambda self, state, wrong=wrong: wrong)
        with pytest.raises(PluginFault, match="sources gave"):
            guarded.sources(BoxState())
    monkeypatch.setattr(type(boxes), "sources", lambda self, state: state.sources)
    monkeypatch.setattr(type(boxes), "with_sources", lambda self, state, sources: state)
    with pytest.raises(PluginFault, match="with_sources gave a state with other"):
        guarded.with_sources(BoxState(sources=("a",)), ("b",))
    monkeypatch.setattr(type(boxes), "follow", lambda self, sources: BoxState(sources=("x",)))
    with pytest.raises(PluginFault, match="follow names 'x'"):
        guarded.follow({"a": bench.shapes([], Job())})


def test_curves_of_a_follower_are_those_of_its_newest_result(bench, boxes, monkeypatch):
    def edges(self, state, result):
        return [Curve(1, np.array([0.0, 0, 1, 1]), mesh.bounds) for mesh in result]

    monkeypatch.setattr(type(boxes), "curves", edges)
    for edge in (10.0, 20.0, 10.0):
        document = chain(bench, edge)
        for name in "ab":
            sizes(bench, document, name)
        (first, *_) = bench.curves.of([document.model("b")])
        assert np.ptp(first.control_points, axis=0).max() == 2 * edge
    follower = document.model("b")
    assert bench.curves.of([replace(follower, id="copy")]) == ()  # it may follow another
    changed = with_state(bench.registry, follower, BoxState())
    assert changed.sources == ()
    assert same(changed.frozen, ())


def test_curves_of_copies_are_placed_once_for_each(bench, boxes, monkeypatch):
    def edges(self, state, result):
        return [Curve(1, np.array([0.0, 0, 1, 1]), mesh.bounds) for mesh in result]

    monkeypatch.setattr(type(boxes), "curves", edges)
    one = box(bench, "a", edge=10.0)
    bench.curves.learn(one, bench.solve(one, Job()))
    copies = [
        replace(one, id=f"copy{at}", placement=Placement(offset=(100.0 * at, 0.0, 0.0)))
        for at in range(1, 4)
    ]
    curves = bench.curves.of([one, *copies])
    low = [curve.control_points[:, 0].min() for curve in curves]
    assert np.allclose(np.diff(low), 100.0)
    assert all(map(operator.is_, bench.curves.of([one, *copies]), curves))
    copies[1] = replace(copies[1], placement=Placement(offset=(0.0, 7.0, 0.0)))
    moved = bench.curves.of([one, *copies])
    assert [now is before for now, before in zip(moved, curves, strict=True)] == [
        *(True, True, False, True)
    ]


@pytest.mark.parametrize(
    ("name", "broken", "said"),
    [
        ("with_sources", lambda self, s, ids: BoxState(1.0, 1.0, False, tuple(ids)), "there and"),
        ("sources", lambda self, state: (), "names its sources"),
        (
            "solve",
            lambda self, state, job: (
                self.solved.append(1) or (Mesh(CORNERS * np.float32(len(self.solved)), FACES),)
            ),
            "the second time",
        ),
    ],
)
def test_the_contract_suite_finds_what_is_wrong_with_links(boxes, monkeypatch, name, broken, said):
    subject = Subject(MODELER, (boxes.package,), lambda shell, pen: None)
    check_follow(subject)
    monkeypatch.setattr(type(boxes), name, broken)
    with pytest.raises((Broken, PluginFault), match=said):
        check_follow(subject)


def test_sources_follow_and_with_sources_are_written_together(boxes, monkeypatch):
    monkeypatch.delattr(type(boxes), "with_sources")
    with pytest.raises(UserError, match="Boxes has sources and not with_sources"):
        Registry(extra=[boxes.package]).modeler(MODELER)


def test_a_headless_shell_follows_what_is_used(boxes, tmp_path):
    shell = Shell(Registry(extra=[boxes.package]), tmp_path)
    shell.open(MODELER)
    shell.set(edge=10.0)
    source = shell.model
    follower = shell.use(MODELER)
    assert follower.followed == (source.id,)
    assert [solid.mesh.bounds[1, 0] for solid in shell.shapes().solids] == [12.5]
    assert all(not model.linked for model in shell.document)
    shell.put(replace(shell.state, growth=3.0))
    shell.reopen()
    assert [solid.mesh.bounds[1, 0] for solid in shell.shapes().solids] == [20.0]
    assert len(shell.workbench.shapes(shell.document, Job()).solids) == 2


def test_reports_name_what_is_followed_and_what_is_frozen(bench):
    assert links_of(resolved(chain(bench))["c"]) == {"follows": ["B"]}
    kept = edit.delete_models(chain(bench), ["b"]).document
    assert links_of(resolved(kept)["c"]) == {"frozen": ["B"]}
    assert links_of(resolved(kept)["a"]) == {}
