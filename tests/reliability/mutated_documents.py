"""Mutated files against the loader: one exception type, bounded memory.

``python -m tests.reliability.mutated_documents --count 1000000`` runs the long version; the
default test suite runs a short one. Half of the cases change bytes of the file; the other half
change bytes (or JSON values) of entries and pack them again with sound checksums, so that they
get past the container.
"""

from __future__ import annotations

import argparse
import io
import json
import random
import struct
import sys
import time
import zipfile
import zlib
from collections import Counter
from typing import Any

from bozzetto.document.model import Document, Model
from bozzetto.document.storage.bozz_file import decode_document, encode_document
from bozzetto.errors import DocumentError
from bozzetto.ink.stroke import Strokes
from tests.document_kit import FakeRegistry, Ink, rich_document, stroke

NUMBERS = (0, 1, 127, 128, 255, 65_535, 2**31 - 1, 2**31, 2**32 - 1)
VALUES = (None, True, -1, 0, 1, 2**31, 2**63, 10**30, 0.5, 1e308, "", "../x", "x" * 300, [], {})


def corpus() -> list[bytes]:
    """Small sound documents of several kinds."""
    plain = Document((Model("a", "A", "test.ink", Ink(Strokes([stroke(), stroke(1, 3)]))),))
    bare = Document(rich_document().models, foreign=(("x/y", b"z"),))
    sound = [encode_document(document) for document in (Document(), plain, bare, rich_document())]
    return [*sound, packed(entries(sound[1]), zipfile.ZIP_DEFLATED)]


def entries(content: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def packed(found: dict[str, bytes], method: int = zipfile.ZIP_STORED) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", method, compresslevel=1) as archive:
        for name, body in found.items():
            archive.writestr(name, body)
    return file.getvalue()


def mutated(content: bytes, rng: random.Random) -> bytes:
    """Some bytes flipped, set, cut, put in, copied, or the end cut off."""
    changed = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 4, 16))):
        place = rng.randrange(len(changed)) if changed else 0
        kind = rng.randrange(7)
        if not changed or kind == 0:
            changed[place:place] = rng.randbytes(rng.randrange(1, 16))
        elif kind == 1:
            changed[place] ^= 1 << rng.randrange(8)
        elif kind == 2:
            changed[place] = rng.choice(NUMBERS[:5])
        elif kind == 3:
            del changed[place : place + rng.randrange(1, 64)]
        elif kind == 4:
            source = rng.randrange(len(changed))
            changed[place : place + 16] = changed[source : source + 16]
        elif kind == 5:
            changed[place : place + 4] = struct.pack("<I", rng.choice(NUMBERS))
        else:
            del changed[place:]
    return bytes(changed)


def other_value(tree: Any, rng: random.Random) -> Any:
    """A JSON tree with one value exchanged, removed or doubled."""
    if isinstance(tree, dict) and tree and rng.random() < 0.9:
        key = rng.choice(list(tree))
        if rng.random() < 0.1:
            return {k: v for k, v in tree.items() if k != key}
        return {**tree, key: other_value(tree[key], rng)}
    if isinstance(tree, list) and tree and rng.random() < 0.9:
        place = rng.randrange(len(tree))
        if rng.random() < 0.1:
            return tree[:place] + tree[place + 1 :]
        if rng.random() < 0.1:
            return [*tree, tree[place]]
        return [*tree[:place], other_value(tree[place], rng), *tree[place + 1 :]]
    if isinstance(tree, int | float) and rng.random() < 0.5:
        return tree + rng.choice((-1, 1, 0.5))
    return rng.choice(VALUES)


def with_sound_parts(found: dict[str, bytes]) -> dict[str, bytes]:
    """The manifest's checksums brought up to date, so that lies lie deeper."""
    try:
        manifest = json.loads(found["manifest.json"])
        for part in manifest["parts"]:
            part["crc"] = zlib.crc32(found[part["name"]])
    except (ValueError, KeyError, TypeError):
        return found
    return {**found, "manifest.json": json.dumps(manifest).encode()}


def cases(count: int, seed: int):
    """Mutated files."""
    rng = random.Random(seed)
    sound = corpus()
    opened = [entries(content) for content in sound]
    for number in range(count):
        choice = rng.randrange(len(sound))
        if number % 2:
            yield mutated(sound[choice], rng)
            continue
        found = dict(opened[choice])
        name = rng.choice(list(found))
        if name.endswith(".json") and rng.random() < 0.8:
            found[name] = json.dumps(other_value(json.loads(found[name]), rng)).encode()
        else:
            found[name] = mutated(found[name], rng)
        yield packed(with_sound_parts(found) if rng.random() < 0.8 else found)


def run(count: int, seed: int = 0) -> dict[str, int]:
    """Load so many mutated files; how many opened, how many were refused.

    Any exception but `DocumentError` passes through, with the case on standard error.
    """
    registry = FakeRegistry()
    tally: Counter[str] = Counter()
    for content in cases(count, seed):
        try:
            decode_document(content, registry)
            tally["opened"] += 1
        except DocumentError:
            tally["refused"] += 1
        except BaseException:
            print("the case:", content.hex(), file=sys.stderr)
            raise
    return dict(tally)


def peak_megabytes() -> float:
    """Largest resident memory of this process so far."""
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1 << 20) if sys.platform == "darwin" else peak / 1024


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--megabytes", type=float, default=100, help="growth that is accepted")
    options = parser.parse_args()
    run(1000, options.seed + 1)  # imports and caches
    before = peak_megabytes()
    start = time.perf_counter()
    tally = run(options.count, options.seed)
    seconds = time.perf_counter() - start
    peak = peak_megabytes()
    print(
        f"{options.count} mutated files in {seconds:.0f} s: {tally.get('refused', 0)} refused, "
        f"{tally.get('opened', 0)} opened, 0 other exceptions; "
        f"peak memory {before:.0f} -> {peak:.0f} MB"
    )
    if peak - before > options.megabytes:
        sys.exit(f"memory grew by more than {options.megabytes:.0f} MB")


if __name__ == "__main__":
    main()
