"""How long a large document takes: saving, opening, editing, journalling.

Two named alternatives are measured in the same run: numpy's ``savez`` of the same arrays, and
JSON of the same samples; for an edit, a deep copy of changeable ink as an undo step.
"""

from __future__ import annotations

import copy
import os
import statistics
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from bozzetto.document.edit import change_state
from bozzetto.document.history import History
from bozzetto.document.model import Document, Model
from bozzetto.document.recovery.recovery import RecoveryStore
from bozzetto.document.storage.bozz_file import read_document, write_document
from bozzetto.geometry.mesh import Mesh
from bozzetto.ink.stroke import COLUMNS, Stroke, Strokes
from bozzetto.view.camera import Camera
from tests.benchmarks.timing import Row

STROKES, SAMPLES = 5_000, 200
MESHES, VERTICES, FACES = 20, 25_000, 50_000
REPEATS = 15


@dataclass(frozen=True)
class Sketch:
    """A state of ink."""

    strokes: Strokes = Strokes()


@dataclass(frozen=True)
class Template:
    """A state of a mesh."""

    mesh: Mesh


class States:
    """The two modelers of the benchmark."""

    def state_type(self, modeler_id: str) -> tuple[type[Any], int] | None:
        return {"bench.sketch": (Sketch, 1), "bench.template": (Template, 1)}[modeler_id]

    def upgrade(self, modeler_id: str, state: dict[str, Any], version: int) -> dict[str, Any]:
        return state

    def sources(self, modeler_id: str, state: Any) -> tuple[str, ...]:
        return ()


def stroke(rng: np.random.Generator, camera: Camera) -> Stroke:
    """A random walk with pressure, time and one tilt: five columns."""
    walk = np.cumsum(rng.normal(0, 1.2, (2, SAMPLES)), axis=1) + rng.uniform(0, 900, (2, 1))
    return Stroke(
        *walk,
        camera,
        pressure=rng.uniform(0.2, 0.9, SAMPLES),
        t=np.cumsum(rng.uniform(0.004, 0.006, SAMPLES)),
        tilt_x=rng.normal(45, 5, SAMPLES),
    )


def large_document(seed: int = 0) -> Document:
    """5,000 strokes of 200 samples, and 20 meshes of 25,000 vertices and 50,000 triangles."""
    rng = np.random.default_rng(seed)
    camera = Camera()
    ink = Sketch(Strokes(stroke(rng, camera) for _ in range(STROKES)))
    models = [Model("ink", "Ink", "bench.sketch", ink)]
    for number in range(MESHES):
        mesh = Mesh(
            rng.normal(0, 100, (VERTICES, 3)).astype(np.float32),
            rng.integers(0, VERTICES, (FACES, 3)).astype(np.int32),
            colors=rng.integers(0, 256, (VERTICES, 4)).astype(np.uint8),
        )
        models.append(Model(f"mesh{number}", f"Mesh {number}", "bench.template", Template(mesh)))
    return Document(models, camera=camera)


def median_ms(call: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median time of a call, ms, after one that does not count."""
    call()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        made = call()
        times.append(time.perf_counter() - start)
        del made  # outside the clock: taking the last answer apart is not part of the next
    return statistics.median(times) * 1e3


def save_and_load() -> dict[str, float]:
    """Medians in ms of saving and opening the large document, and of the alternatives.

    Ours includes checksums, the checks of a strict loader, three backups and the wait for
    the disk; ``savez`` and JSON write the bare numbers and do not wait. ``write`` is what
    the system alone takes for as many bytes, waiting for the disk as we do.
    """
    document = large_document()
    states = [model.state for model in document]
    ink = next(state.strokes for state in states if isinstance(state, Sketch))
    meshes = [state.mesh for state in states if isinstance(state, Template)]
    arrays = {name: np.concatenate([getattr(s, name) for s in ink]) for name in COLUMNS[:5]}
    for number, mesh in enumerate(meshes):
        parts = {"v": mesh.vertices, "f": mesh.faces, "c": mesh.colors}
        arrays |= {f"{name}{number}": part for name, part in parts.items()}
    with tempfile.TemporaryDirectory() as folder:
        path, npz, bare = (Path(folder, name) for name in ("large.bozz", "large.npz", "bare"))
        found = {
            "save": median_ms(lambda: write_document(document, path)),
            "load": median_ms(lambda: read_document(path, States())),
            "megabytes": path.stat().st_size / 1e6,
            "savez save": median_ms(lambda: np.savez(npz, **arrays)),
            "savez load": median_ms(lambda: dict(np.load(npz))),
        }
        content = path.read_bytes()
        found["write"] = median_ms(lambda: _bare_write(bare, content))
    samples = {name: array.tolist() for name, array in arrays.items()}
    text = msgspec.json.encode(samples)
    found["json save"] = median_ms(lambda: msgspec.json.encode(samples), 3)
    found["json load"] = median_ms(lambda: msgspec.json.decode(text), 3)
    return found


def _bare_write(path: Path, content: bytes) -> None:
    with open(path, "wb") as file:
        file.write(content)
        os.fsync(file.fileno())


def spread_document() -> Document:
    """5,000 strokes in 1,000 models."""
    rng = np.random.default_rng(1)
    camera = Camera()
    ink = [stroke(rng, camera) for _ in range(STROKES)]
    return Document(
        [Model(f"m{n}", f"{n}", "bench.sketch", Sketch(Strokes(ink[n::1000]))) for n in range(1000)]
    )


def edits(document: Document, count: int = 200) -> dict[str, float]:
    """Median time of adding a stroke as a step of the history, and bytes beyond the stroke."""
    rng = np.random.default_rng(2)
    new = [stroke(rng, Camera()) for _ in range(count)]
    places = [n for n, model in enumerate(document) if isinstance(model.state, Sketch)]

    def run() -> list[float]:
        history = History(document)
        times = []
        for number, drawn in enumerate(new):
            start = time.perf_counter()
            model = history.document.models[places[number * 7 % len(places)]]
            state = Sketch(model.state.strokes.extended([drawn]))
            edit = change_state(history.document, model.id, state, "Draw")
            history.apply(edit.label, edit.document)
            times.append(time.perf_counter() - start)
        kept.append(history)
        return times

    kept: list[History] = []
    times = run()
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    run()
    used = tracemalloc.get_traced_memory()[0] - before
    tracemalloc.stop()
    return {"edit": statistics.median(times) * 1e3, "bytes": used / count}


def as_changeable(document: Document) -> list[dict[str, Any]]:
    """The ink as lists of arrays that can be written to: an undo step has to copy them."""
    return [
        {
            "name": model.name,
            "strokes": [
                {name: np.array(getattr(stroke, name)) for name in COLUMNS[:5]}
                for stroke in model.state.strokes
            ],
        }
        for model in document
        if isinstance(model.state, Sketch)
    ]


def journal(count: int = 300) -> float:
    """Median time in ms of journalling one more stroke of the large drawing."""
    document = large_document()
    rng = np.random.default_rng(3)
    times = []
    with tempfile.TemporaryDirectory() as folder:
        session = RecoveryStore(folder).begin("Large", None, document)
        for _ in range(count):
            ink = document.models[0].state.strokes.extended([stroke(rng, Camera())])
            document = change_state(document, "ink", Sketch(ink), "Draw").document
            start = time.perf_counter()
            session.record(document)
            times.append(time.perf_counter() - start)
        session.close()
    return statistics.median(times) * 1e3


def rows() -> Iterator[Row]:
    """The table's rows about the document."""
    found = save_and_load()
    size = f"{STROKES:,} strokes and {MESHES} meshes, {found['megabytes']:.0f} MB"
    for ours, what, budget in (("save", "saved", "≤ 60 ms"), ("load", "opened", "≤ 50 ms")):
        for other, named in (("savez", "numpy.savez, unchecked"), ("json", "JSON by msgspec")):
            yield Row(
                "document", f"{size}, {what}", found[ours], budget=budget, alternative=named,
                other=found[f"{other} {ours}"],
            )  # fmt: skip
    yield Row(
        "document", f"{size}, saved", found["save"], budget="≤ 60 ms",
        alternative="writing as many bytes to the disk", other=found["write"],
    )  # fmt: skip
    for name, document in (("one model", large_document()), ("1,000 models", spread_document())):
        edit = edits(document)
        changeable = as_changeable(document)
        copied = median_ms(lambda kept=changeable: copy.deepcopy(kept), repeats=3)
        yield Row(
            "document", f"an edit, 5,000 strokes in {name}", edit["edit"], budget="≤ 1 ms",
            alternative="deep copy of the ink", other=copied,
        )  # fmt: skip
        yield Row(
            "document", f"its cost beyond its own data, {name}", edit["bytes"], "bytes",
            "≤ 8,000 bytes",
        )  # fmt: skip
    yield Row("document", "a stroke journalled, on the disk", journal())
