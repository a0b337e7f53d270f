"""Edits, undo, redo, save and load in any order, against a plain list of plain values."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from bozzetto.document import edit
from bozzetto.document.history import History
from bozzetto.document.model import Document, Model
from bozzetto.document.storage.bozz_file import decode_document, encode_document
from bozzetto.errors import UserError
from bozzetto.geometry.placement import Placement
from bozzetto.ink.stroke import Strokes
from tests.document_kit import SIDE, FakeRegistry, Ink, stroke

# The plain model: a document is a list of dicts, the history a list of such lists.
Plain = list[dict]

seeds = st.integers(0, 50)
picks = st.integers(0, 1000)


def plain(document: Document) -> Plain:
    return [
        {
            "id": model.id,
            "name": model.name,
            "visible": model.visible,
            "locked": model.locked,
            "color": model.color,
            "offset": model.placement.offset,
            "thickness": model.state.thickness,
            "strokes": [(s.x.tolist(), s.y.tolist(), s.camera.kind) for s in model.state.strokes],
        }
        for model in document
    ]


def sample(seed: int) -> tuple[list[float], list[float], str]:
    drawn = drawing(seed)
    return drawn.x.tolist(), drawn.y.tolist(), drawn.camera.kind


def drawing(seed: int):
    return stroke(seed, 3, SIDE) if seed % 2 else stroke(seed, 2)


class DocumentMachine(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.history = History(Document())
        self.past: list[Plain] = [[]]
        self.future: list[Plain] = []
        self.saved = self.past[0]
        self.dragging: str | None = None
        self.made = 0

    def step(self, change: edit.Edit, expected: Plain, key: str | None = None) -> None:
        """An edit on both sides."""
        self.history.apply(change.label, change.document, key)
        if key is not None and key == self.dragging:
            self.past[-1] = expected
        else:
            self.past.append(expected)
        self.future = []
        self.dragging = key

    def present(self) -> Plain:
        return [dict(entry) for entry in self.past[-1]]

    def pick(self, pick: int) -> tuple[str, int, Plain]:
        expected = self.present()
        place = pick % len(expected)
        return expected[place]["id"], place, expected

    has_models = precondition(lambda self: len(self.past[-1]) > 0)

    @rule(seed=seeds, at=st.none() | picks)
    def add(self, seed, at):
        self.made += 1
        expected = self.present()
        place = len(expected) if at is None else at % (len(expected) + 1)
        model = Model(f"m{self.made}", "Part", "test.ink", Ink(Strokes([drawing(seed)])))
        change = edit.add_model(self.history.document, model, at=place)
        names = {entry["name"] for entry in expected}
        wanted = ["Part", *(f"Part {n}" for n in range(2, 1000))]
        expected.insert(
            place,
            {
                "id": f"m{self.made}",
                "name": next(name for name in wanted if name not in names),
                "visible": True,
                "locked": False,
                "color": None,
                "offset": (0.0, 0.0, 0.0),
                "thickness": 1.0,
                "strokes": [sample(seed)],
            },
        )
        self.step(change, expected)

    def edit_or_refusal(self, call, place, expected, changes, key=None) -> None:
        """Locked objects refuse and stay; others change."""
        if expected[place]["locked"]:
            try:
                call()
            except UserError:
                return
            raise AssertionError("a locked object was changed")
        expected[place] |= changes
        self.step(call(), expected, key)

    @has_models
    @rule(pick=picks, seed=seeds)
    def draw(self, pick, seed):
        model_id, place, expected = self.pick(pick)
        state = self.history.document.model(model_id).state
        grown = replace(state, strokes=state.strokes.extended([drawing(seed)]))
        self.edit_or_refusal(
            lambda: edit.change_state(self.history.document, model_id, grown, "Draw"),
            place,
            expected,
            {"strokes": [*expected[place]["strokes"], sample(seed)]},
        )

    @has_models
    @rule(pick=picks)
    def erase(self, pick):
        model_id, place, expected = self.pick(pick)
        state = self.history.document.model(model_id).state
        if not len(state.strokes):
            return
        which = pick % len(state.strokes)
        less = replace(state, strokes=state.strokes.without(which))
        strokes = expected[place]["strokes"]
        self.edit_or_refusal(
            lambda: edit.change_state(self.history.document, model_id, less, "Erase"),
            place,
            expected,
            {"strokes": strokes[:which] + strokes[which + 1 :]},
        )

    @has_models
    @rule(pick=picks, thickness=st.floats(0.0, 10.0))
    def slide(self, pick, thickness):
        model_id, place, expected = self.pick(pick)
        state = replace(self.history.document.model(model_id).state, thickness=thickness)
        self.edit_or_refusal(
            lambda: edit.change_state(self.history.document, model_id, state, "Thickness"),
            place,
            expected,
            {"thickness": thickness},
            key=f"{model_id}/thickness",
        )

    @rule()
    def end_drag(self):
        self.history.end_merge()
        self.dragging = None

    @has_models
    @rule(pick=picks, name=st.sampled_from(["Rim", "Grip", " Über "]))
    def rename(self, pick, name):
        model_id, place, expected = self.pick(pick)
        self.edit_or_refusal(
            lambda: edit.rename_model(self.history.document, model_id, name),
            place,
            expected,
            {"name": name.strip()},
        )

    @has_models
    @rule(pick=picks, color=st.none() | st.tuples(*[st.integers(0, 255)] * 3))
    def color(self, pick, color):
        model_id, place, expected = self.pick(pick)
        self.edit_or_refusal(
            lambda: edit.color_model(self.history.document, model_id, color),
            place,
            expected,
            {"color": color},
        )

    @has_models
    @rule(pick=picks, x=st.floats(-1e6, 1e6))
    def place(self, pick, x):
        model_id, place, expected = self.pick(pick)
        self.edit_or_refusal(
            lambda: edit.place_model(
                self.history.document, model_id, Placement(offset=(x, 0.0, 0.0))
            ),
            place,
            expected,
            {"offset": (x, 0.0, 0.0)},
        )

    @has_models
    @rule(pick=picks, visible=st.booleans())
    def show(self, pick, visible):
        model_id, place, expected = self.pick(pick)
        expected[place]["visible"] = visible
        self.step(edit.show_model(self.history.document, model_id, visible), expected)

    @has_models
    @rule(pick=picks, locked=st.booleans())
    def lock(self, pick, locked):
        model_id, place, expected = self.pick(pick)
        expected[place]["locked"] = locked
        self.step(edit.lock_model(self.history.document, model_id, locked), expected)

    @has_models
    @rule(pick=picks, to=picks)
    def reorder(self, pick, to):
        model_id, place, expected = self.pick(pick)
        entry = expected.pop(place)
        at = to % (len(expected) + 1)
        expected.insert(at, entry)
        self.step(edit.move_model(self.history.document, model_id, at), expected)

    @has_models
    @rule(pick=picks)
    def delete(self, pick):
        model_id, place, expected = self.pick(pick)
        if expected[place]["locked"]:
            return
        del expected[place]
        self.step(edit.delete_models(self.history.document, [model_id]), expected)

    @rule()
    def undo(self):
        self.history.undo()
        if len(self.past) > 1:
            self.future.append(self.past.pop())
        self.dragging = None

    @rule()
    def redo(self):
        self.history.redo()
        if self.future:
            self.past.append(self.future.pop())
        self.dragging = None

    @rule(pick=picks)
    def jump(self, pick):
        row = self.past + self.future[::-1]
        target = pick % len(row)
        self.history.go_to(target)
        self.past, self.future = row[: target + 1], row[:target:-1]
        self.dragging = None

    @rule()
    def save_and_load(self):
        content = encode_document(self.history.document)
        self.history.mark_saved()
        self.saved = self.past[-1]
        self.dragging = None
        again, report = decode_document(content, FakeRegistry())
        assert plain(again) == self.past[-1]
        assert report.warnings == ()
        assert encode_document(again) == content

    @rule()
    def close_and_open(self):
        again, _ = decode_document(encode_document(self.history.document), FakeRegistry())
        self.history = History(again)
        self.past, self.future = [self.past[-1]], []
        self.saved, self.dragging = self.past[-1], None

    @invariant()
    def the_document_is_what_the_plain_model_says(self):
        assert plain(self.history.document) == self.past[-1]
        assert self.history.position == len(self.past) - 1
        assert len(self.history.entries) == len(self.past) + len(self.future)
        assert self.history.is_modified == (self.past[-1] is not self.saved)
        assert self.history.held_bytes >= 0


TestDocument = DocumentMachine.TestCase
TestDocument.settings = settings(max_examples=200, stateful_step_count=40, deadline=None)
