"""Links in documents: what follows what, what stays frozen, and what files keep of it."""

from __future__ import annotations

import io
import json
import random
import zipfile
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from bozzetto.document import edit
from bozzetto.document.links import (
    LinkedModels,
    followers,
    in_order,
    is_same_recipe,
    resolved,
    with_frozen,
)
from bozzetto.document.model import LONGEST_CHAIN, Document, Model, OpaqueState
from bozzetto.document.recovery.journal_records import ChangeWriter, Replay
from bozzetto.document.storage.bozz_file import decode_document, encode_document, open_document
from bozzetto.document.storage.bozz_reader import parse_document
from bozzetto.errors import DocumentError, UserError
from bozzetto.geometry import Placement
from bozzetto.ink import Strokes
from tests.document_kit import FakeRegistry, same_document, stroke

TURNED = Placement((0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0), 2.0, (5.0, 6.0, 7.0))


@dataclass(frozen=True)
class Linked:
    """A state with ink, so that files keep strokes of frozen models too."""

    sources: tuple[str, ...] = ()
    strokes: Strokes = Strokes()


class Registry(FakeRegistry):
    def __init__(self) -> None:
        super().__init__(linked=(Linked, 1))

    def sources(self, modeler_id: str, state: Any) -> tuple[str, ...]:
        return state.sources


def linked(name: str, *sources: str, **more: Any) -> Model:
    ink = Strokes([stroke(ord(name[0]))])
    return Model(name, name.upper(), "linked", Linked(sources, ink), sources=sources, **more)


def chain(*more: Model) -> Document:
    """C follows b, which follows a."""
    return Document((linked("c", "b"), linked("b", "a"), linked("a"), *more))


def relinked(model: Model, sources: tuple[str, ...]) -> Model:
    return model.with_state(replace(model.state, sources=sources), sources)


# -- order and circles -----------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_models_come_behind_what_they_follow_in_any_order_of_the_list(seed):
    models = [linked("a"), linked("b", "a"), linked("c", "a", "b"), linked("d", "c"), linked("e")]
    random.Random(seed).shuffle(models)
    order = [model.id for model in in_order(models)]
    assert sorted(order) == list("abcde")
    for model in models:
        assert all(order.index(source) < order.index(model.id) for source in model.sources)


def test_a_model_cannot_follow_itself_nor_what_follows_it():
    document = chain()
    for source in "abc":
        with pytest.raises(UserError, match=r"“A” cannot follow"):
            document.with_model(relinked(document.model("a"), (source,)))
    assert document.with_model(relinked(document.model("c"), ("a", "b"))).model("c").sources


def test_a_chain_has_a_greatest_length():
    document = Document((linked("m0"),))
    for number in range(1, LONGEST_CHAIN + 1):
        document = document.with_model(linked(f"m{number}", f"m{number - 1}"))
    assert len(tuple(in_order(document))) == LONGEST_CHAIN + 1
    with pytest.raises(UserError, match="would follow one another"):
        document.with_model(linked("last", f"m{LONGEST_CHAIN}"))


def test_circles_from_a_file_are_opened_and_left_out_of_the_order():
    document = Document((linked("a", "c"), linked("b", "a"), linked("c", "b"), linked("d", "c")))
    assert tuple(in_order(document)) == ()
    again, _ = decode_document(encode_document(document), Registry())
    assert same_document(again, document)
    found = resolved(again)
    assert [found[name].linked for name in "abcd"] == [()] * 4


# -- models ready to be solved ---------------------------------------------------------------------


def test_a_follower_holds_what_it_follows_in_its_own_frame():
    moved = replace(linked("b", "a"), placement=TURNED)
    found = resolved(Document((linked("a", placement=Placement(offset=(5.0, 8.0, 9.0))), moved)))
    (source,) = found["b"].linked
    place = source.placement.points([[0.0, 0.0, 0.0]])
    np.testing.assert_allclose(TURNED.points(place), [[5.0, 8.0, 9.0]], atol=1e-12)
    assert source.placement.scale == 0.5


def test_a_model_stays_the_same_object_until_something_in_it_changes():
    known, document = LinkedModels(), chain()
    before = known.resolved(document)
    assert all(known.resolved(document)[name] is before[name] for name in "abc")
    other = document.with_model(linked("e"))
    assert all(known.resolved(other)[name] is before[name] for name in "abc")
    renamed = document.with_model(replace(document.model("a"), name="New"))
    after = known.resolved(renamed)
    assert after["c"] is not before["c"]
    assert is_same_recipe(after["c"], before["c"])
    moved = document.with_model(replace(document.model("a"), placement=TURNED))
    assert not is_same_recipe(known.resolved(moved)["c"], before["c"])
    changed = document.with_model(linked("a"))
    assert not is_same_recipe(known.resolved(changed)["c"], before["c"])


# -- frozen sources --------------------------------------------------------------------------------


def test_deleting_a_source_freezes_it_with_all_that_it_follows():
    document = chain()
    after = edit.delete_models(document, ["b"]).document
    c = after.model("c")
    assert c.followed == ()
    (b,) = c.frozen
    (a,) = b.frozen
    assert (b.state, a.state) == (document.model("b").state, document.model("a").state)
    changed = after.with_model(linked("a"))  # the living one no longer matters
    assert is_same_recipe(resolved(changed)["c"], resolved(after)["c"])
    assert followers(after, "a") == ()


def test_deleting_follower_and_source_leaves_nothing():
    assert len(edit.delete_models(chain(), ["a", "b", "c"]).document) == 0


def test_a_locked_follower_keeps_what_is_deleted():
    document = chain(linked("d", "a", locked=True))
    after = edit.delete_models(document, ["a"]).document
    assert [source.id for source in after.model("d").frozen] == ["a"]
    with pytest.raises(UserError, match="locked"):
        edit.unlink_model(document, "d")


def test_unlinked_models_keep_their_shape_and_can_be_linked_again():
    document = chain()
    after = edit.unlink_model(document, "b").document
    assert [m.id for m in after.model("b").frozen] == ["a"]
    assert [m.id for m in resolved(after)["c"].linked] == ["b"]
    with pytest.raises(UserError, match="follows no other"):
        edit.unlink_model(after, "b")
    again = edit.link_model(after, "b").document
    assert again.model("b").followed == ("a",)
    gone = edit.delete_models(after, ["a"]).document
    with pytest.raises(UserError, match="no longer in the document"):
        edit.link_model(gone, "b")


def test_linking_again_makes_no_circle():
    document = edit.unlink_model(Document((linked("a"), linked("b", "a"))), "b").document
    document = document.with_model(relinked(document.model("a"), ("b",)))
    with pytest.raises(UserError, match="cannot follow"):
        edit.link_model(document, "b")


def test_frozen_sources_move_with_their_follower():
    document = Document((linked("a"), linked("b", "a")))
    frozen = edit.unlink_model(document, "b").document
    moved = edit.place_model(frozen, "b", TURNED).document
    assert moved.model("b").frozen == frozen.model("b").frozen
    follows = edit.place_model(document, "b", TURNED).document
    assert with_frozen(follows, follows.model("b"), ["a"]).frozen[0].placement == TURNED.inverse()


def test_a_duplicated_pair_follows_its_copy_and_a_single_one_the_same_source():
    document = Document((linked("b", "a"), linked("a")))
    pair = edit.duplicate_models(document, ["b", "a"], relinked).document
    b, b_copy, a, a_copy = pair.models
    assert (b.sources, b_copy.sources, a.id) == (("a",), (a_copy.id,), "a")
    assert len({model.name for model in pair}) == 4
    single = edit.duplicate_model(document, "b").document
    assert single.models[1].sources == ("a",)
    frozen = edit.unlink_model(document, "b").document
    pair = edit.duplicate_models(frozen, ["b", "a"], relinked).document
    assert pair.models[1].frozen == frozen.model("b").frozen


def test_a_source_that_is_no_longer_named_is_not_kept():
    frozen = edit.delete_models(chain(), ["b"]).document.model("c")
    assert relinked(frozen, ("a",)).frozen == ()
    assert relinked(frozen, ("a", "b")).frozen == frozen.frozen


def test_only_sources_are_frozen_each_once():
    one = linked("a")
    for sources, frozen in (((), (one,)), (("a",), (one, one))):
        with pytest.raises(ValueError, match="frozen"):
            Model("b", "B", "linked", Linked(), sources=sources, frozen=frozen)


# -- files -----------------------------------------------------------------------------------------


def frozen_document() -> Document:
    """A frozen source within a frozen source, two in one model, and a closed follower."""
    document = chain(linked("d", "b", "a"), linked("f"))
    return edit.delete_models(document.with_model(opaque_of("e", "b", "f")), ["b", "a"]).document


def opaque_of(name: str, *sources: str) -> Model:
    opaque = OpaqueState(3, b'{"odd":1}', (stroke(3),))
    return Model(name, name.upper(), "absent.modeler", opaque, state_version=3, sources=sources)


def test_a_file_keeps_what_is_frozen():
    document = frozen_document()
    again, report = decode_document(encode_document(document), Registry())
    assert same_document(again, document)
    assert [source.id for source in again.model("e").frozen] == ["b"]
    assert again.model("e").followed == ("f",)
    assert len(report.warnings) == 1
    loose = edit.delete_models(Document((linked("a"), opaque_of("b", "a"))), ["a"]).document
    with zipfile.ZipFile(io.BytesIO(encode_document(loose))) as archive:
        requires = json.loads(archive.read("manifest.json"))["requires"]
    assert requires == ["absent.modeler", "linked"]
    assert encode_document(again) == encode_document(document)


def test_a_journal_keeps_what_is_frozen():
    steps = [chain(), edit.unlink_model(chain(), "c").document, frozen_document(), Document()]
    steps += [frozen_document(), edit.delete_models(frozen_document(), ["d"]).document]
    for first in (0, 2):
        base = steps[first]
        writer, replay = ChangeWriter(base), Replay(parse_document(encode_document(base)))
        for document in steps[first + 1 :]:
            record = writer.record(document, (), 1.0)
            assert record is not None
            replay.feed(record)
            again, _ = open_document(replay.stored, Registry())
            assert same_document(again, document)


@pytest.mark.parametrize(
    "change",
    [
        lambda rows: rows[0].update(within=[]),
        lambda rows: rows[0].update(within=["nobody"]),
        lambda rows: rows[1].update(within=["c", "nobody"]),
        lambda rows: rows.reverse(),
        lambda rows: rows.append(rows[0]),
        lambda rows: rows[0].update(strokes=[1, 1]),
        lambda rows: rows[0].update(strokes=[0, -1]),
        lambda rows: rows[0]["header"].update(id="../x"),
        lambda rows: rows[0].update(arrays=["plugins/linked/c/0.f4"]),
        lambda rows: rows.pop(),
        lambda rows: rows.__setitem__(0, 7),
    ],
)
def test_a_wrong_list_of_frozen_models_is_refused(change):
    from tests.core.document.storage.test_bozz_file import edited

    content = encode_document(frozen_document())
    with pytest.raises(DocumentError):
        decode_document(edited(content, "core/frozen.json", change), Registry())


def test_a_modeler_that_cannot_say_its_sources_keeps_its_model_closed():
    class Broken(Registry):
        def sources(self, modeler_id, state):
            raise DocumentError("no")

    content = encode_document(frozen_document())
    document, report = decode_document(content, Broken())
    assert all(isinstance(model.state, OpaqueState) for model in document)
    assert len(report.warnings) == len(document)
    assert json.dumps(sorted(report.warnings))
    again, _ = decode_document(encode_document(document), Registry())
    assert same_document(again, frozen_document())


def test_a_copied_follower_keeps_what_is_not_copied_with_it():
    document = Document((linked("b", "a"), linked("a")))
    both = edit.copied_models(document, ["a", "b"])
    assert both.model("b").followed == ("a",)
    pasted = edit.paste_models(Document(), both, relinked).document
    follower, source = pasted
    assert follower.followed == (source.id,)
    alone = edit.copied_models(document, ["b"])
    (copy,) = edit.paste_models(document, alone, relinked).document.models[len(document.models) :]
    assert (copy.followed, [model.id for model in copy.frozen]) == ((), ["a"])
    with pytest.raises(UserError):
        edit.copied_models(document, [])
