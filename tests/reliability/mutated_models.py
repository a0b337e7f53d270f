"""Mutated documents of the bundled modelers: what loads can be solved, shown and handed over."""

from __future__ import annotations

import json
import random
import zlib
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from bozzetto.document.model import Document
from bozzetto.document.storage.bozz_file import decode_document, encode_document
from bozzetto.errors import UserError
from bozzetto.exchange.import_file import read_drawing
from bozzetto.geometry import Curve, Mesh, Shapes, Surface
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.workbench.workbench import Workbench
from tests.reliability.mutated_documents import entries, other_value, packed

SMALLEST_FIRST = 3
"""Samples of each modeler that are mutated: the small ones solve quickly."""

NUMBERS = (0.0, -1.0, 1e-30, 1e9, -1e20, 1e300, 3e38, 2.0**31, 7.0)


@cache
def bench() -> Workbench:
    """One workbench for all; what it remembers is thrown away as it fills."""
    return Workbench(Registry())


@cache
def corpus() -> list[bytes]:
    """A few documents of every bundled modeler."""
    made: list[bytes] = []
    for info in bench().registry.modelers():
        samples = sorted(info.samples, key=lambda path: path.stat().st_size)[:SMALLEST_FIRST]
        for sample in samples:
            model = bench().sources.from_drawing(info.id, read_drawing(sample, trusted=True), {})
            made.append(encode_document(Document((model,))))
    corners = [[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]]
    mesh = Mesh(corners, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    shapes = Shapes(surfaces=(Surface(mesh),))
    made.append(
        encode_document(Document((bench().sources.from_shapes("bozzetto.mesh", shapes, "m"),)))
    )
    curve = Curve(1, np.array([0, 0, 1, 2, 2.0]), np.array([[0, 0, 0], [50, 0, 0], [0, 50, 20.0]]))
    shapes = Shapes(curves=(curve,))
    made.append(
        encode_document(Document((bench().sources.from_shapes("bozzetto.skin", shapes, "s"),)))
    )
    return made


def mutations(content: bytes, rng: random.Random) -> bytes:
    """The document with something else in a state: a value, an array, a camera, a stroke."""
    found = entries(content)
    names = [name for name in found if name.startswith(("plugins/", "core/"))]
    names = [name for name in names if found[name]]
    for _ in range(rng.choice((1, 1, 2))):
        name = rng.choice(names)
        if name.endswith(".json"):
            found[name] = json.dumps(other_value(json.loads(found[name]), rng)).encode()
        else:
            found[name] = _other_numbers(name, found[name], rng)
    manifest = json.loads(found["manifest.json"])
    for part in manifest["parts"]:
        part["crc"] = zlib.crc32(found[part["name"]])
    return packed({**found, "manifest.json": json.dumps(manifest).encode()})


def _other_numbers(name: str, body: bytes, rng: random.Random) -> bytes:
    kind = {"f4": "<f4", "f8": "<f8", "i4": "<i4", "u4": "<u4"}.get(name.rpartition(".")[2], "u1")
    values = np.frombuffer(body, kind).copy()
    for _ in range(rng.choice((1, 1, 5))):
        number = rng.choice(NUMBERS)
        if kind[-2] in "iu":
            number = rng.choice((0, 1, 2, 7, 127))
        with np.errstate(all="ignore"):
            values[rng.randrange(len(values))] = np.array(number).astype(kind)
    return values.tobytes()


def cases(count: int, seed: int) -> Iterator[bytes]:
    """Mutated documents."""
    rng = random.Random(seed)
    for _ in range(count):
        yield mutations(rng.choice(corpus()), rng)


def use(content: bytes) -> str:
    """Open, solve, show and hand over; what became of it.

    Raises
    ------
    PluginFault, Exception
        Where a modeler, or the program, fails on a document that could be opened.
    """
    try:
        document, report = decode_document(content, bench().registry)
    except UserError:
        return "refused"
    if report.warnings:
        return "closed"
    try:
        job = Job("preview")
        bench().scene(document, job)
        bench().shapes(document, job)
    except UserError:
        return "said"
    return "used"


def fault_of(content: bytes) -> tuple[str, Any]:
    """What `use` says, or the fault; faults are not counted."""
    try:
        return use(content), None
    except PluginFault as fault:
        return "fault", fault
