"""Whatever is done to linked models, they have the shapes that a fresh start gives them."""

from __future__ import annotations

import hashlib
import json
import os
import random
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from bozzetto.document import edit
from bozzetto.document.history import History
from bozzetto.document.links import LinkedModels, in_order
from bozzetto.document.model import Document
from bozzetto.document.storage.bozz_file import decode_document, encode_document, write_document
from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.plugin import Job
from bozzetto.workbench.links import with_sources, with_state
from bozzetto.workbench.workbench import Workbench
from tests.linked_boxes import MODELER, BoxState

MODELS = 5
STEPS = 30
MOST_MODELS = 12

QUARTERS = (
    (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
    (0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0),
    (1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0),
)


def outcomes(bench, models, names):
    """For each model the digest of its shapes, or why it has none."""
    told = {}
    for name in names:
        try:
            shapes = bench.shapes([models[name]], Job())
        except UserError as problem:
            told[name] = problem.message
            continue
        digest = hashlib.sha256()
        for solid in shapes.solids:
            digest.update(solid.name.encode() + solid.mesh.vertices.tobytes())
            digest.update(solid.mesh.faces.tobytes())
        told[name] = digest.hexdigest()
    return told


def from_scratch(document, registry):
    bench = Workbench(registry)
    return outcomes(bench, LinkedModels().resolved(document), [m.id for m in document])


class Life:
    """A document that somebody edits at random, solved again after every edit."""

    def __init__(self, bench, seed):
        self.bench, self.random = bench, random.Random(seed)
        self.linked, self.done = LinkedModels(), Counter()
        document = Document()
        for number in range(MODELS):
            sources = (f"m{number - 1}",) if number else ()
            state = BoxState(10.0 if not number else float(number % 2), 1.5, False, sources)
            made = replace(bench.new_model(MODELER, state, f"M{number}"), id=f"m{number}")
            document = document.with_model(made)
        self.history = History(document)

    @property
    def document(self):
        return self.history.document

    def shapes(self):
        """All models, asked in any order, some at preview quality first."""
        models = self.linked.resolved(self.document)
        names = [model.id for model in self.document]
        self.random.shuffle(names)
        for name in names[::3]:
            try:
                self.bench.solve(models[name], Job(quality="preview"))
            except UserError:
                pass
        return outcomes(self.bench, models, names)

    def step(self):
        actions = (
            self.add, self.change, self.change, self.link, self.link, self.unlink, self.again,
            self.move, self.hide, self.delete, self.duplicate, self.undo, self.redo, self.jump,
            self.reopen, self.lock, self.break_or_mend,
        )  # fmt: skip
        action = self.random.choice(actions)
        before = self.document
        try:
            after = action()
        except UserError:
            self.done["refused"] += 1
            return
        if after is not None and after is not before:
            self.history.apply(action.__name__, after)
        self.done[action.__name__] += 1

    def any_model(self, fits=lambda model: True):
        models = [model for model in self.document if fits(model)]
        if not models:
            raise UserError("There is none.")
        return self.random.choice(models)

    def with_values(self, **values):
        model = self.any_model()
        if model.locked:
            raise UserError("It is locked.")
        return self.document.with_model(self.bench.set_parameters(model, values))

    def add(self):
        if len(self.document) >= MOST_MODELS:
            raise UserError("There are enough.")
        state = BoxState(float(self.random.randrange(1, 9)))
        return edit.add_model(self.document, self.bench.new_model(MODELER, state, "New")).document

    def change(self):
        return self.with_values(growth=self.random.choice((0.5, 1.0, 1.5, 2.0)))

    def break_or_mend(self):
        return self.with_values(wrong=self.random.random() < 0.2)

    def link(self):
        model, ids = self.any_model(), [other.id for other in self.document]
        sources = tuple(self.random.sample(ids, min(len(ids), self.random.randrange(3))))
        state = replace(model.state, sources=sources)
        return self.document.with_model(with_state(self.bench.registry, model, state))

    def unlink(self):
        return edit.unlink_model(self.document, self.any_model(lambda m: m.followed).id).document

    def again(self):
        return edit.link_model(self.document, self.any_model(lambda m: m.frozen).id).document

    def move(self):
        offset = tuple(float(self.random.randrange(-9, 9)) for _ in range(3))
        placement = Placement(self.random.choice(QUARTERS), 1.25, offset)
        return edit.place_model(self.document, self.any_model().id, placement).document

    def hide(self):
        model = self.any_model()
        return edit.show_model(self.document, model.id, not model.visible).document

    def lock(self):
        model = self.any_model()
        return edit.lock_model(self.document, model.id, not model.locked).document

    def delete(self):
        ids = {self.any_model().id for _ in range(self.random.choice((1, 1, 1, 2)))}
        return edit.delete_models(self.document, ids).document

    def duplicate(self):
        if len(self.document) >= MOST_MODELS:
            raise UserError("There are enough.")
        ids = [m.id for m in self.document if self.random.random() < 0.3]
        registry = self.bench.registry
        return edit.duplicate_models(
            self.document, ids, lambda model, sources: with_sources(registry, model, sources)
        ).document

    def undo(self):
        self.history.undo()

    def redo(self):
        self.history.redo()

    def jump(self):
        self.history.go_to(self.random.randrange(len(self.history.entries)))

    def reopen(self):
        content = encode_document(self.document)
        document, report = decode_document(content, self.bench.registry)
        assert report.warnings == ()
        assert encode_document(document) == content
        self.bench.forget_results()
        return document


def lived(bench, seed, *, every_step):
    life = Life(bench, seed)
    for _ in range(STEPS):
        life.step()
        told = life.shapes()
        assert len(list(in_order(life.document))) == len(life.document), "a circle was made"
        if every_step:
            assert told == from_scratch(life.document, bench.registry)
    assert life.shapes() == told  # twice
    return life, told


@pytest.mark.parametrize("seed", range(6))
def test_after_every_edit_shapes_are_those_of_a_fresh_start(bench, seed):
    lived(bench, seed, every_step=True)


CHILD = """
import json, sys
from pathlib import Path
from bozzetto.document.storage.bozz_file import read_document
from bozzetto.plugin.host.registry import Registry
from tests.core.workbench.test_links_law import from_scratch
registry = Registry(extra=[sys.argv[1]])
print(json.dumps({
    path.name: from_scratch(read_document(path, registry)[0], registry)
    for path in map(Path, sys.argv[2:])
}))
"""


@pytest.mark.slow
def test_200_lives_end_with_the_shapes_that_another_process_gives(bench, boxes, tmp_path):
    expected, done = {}, Counter()
    for seed in range(200):
        life, told = lived(bench, 1000 + seed, every_step=False)
        bench.forget_results()
        path = tmp_path / f"{seed}.bozz"
        write_document(life.document, path)
        expected[path.name] = told
        done += life.done
    assert min(done.values()) > 50, done  # everything was done, and refused
    root = Path(__file__).parents[3]
    search = os.pathsep.join((str(root), str(tmp_path / "packages")))
    answer = subprocess.run(
        [sys.executable, "-c", CHILD, boxes.package, *map(str, sorted(tmp_path.glob("*.bozz")))],
        env={**os.environ, "PYTHONPATH": search},
        capture_output=True,
        check=True,
        timeout=300,
    )
    assert json.loads(answer.stdout) == expected
    digests = {digest for told in expected.values() for digest in told.values()}
    assert len(digests) > 200
