"""Outcomes of drawings, kept on disk: a drawing is read once, whatever is fitted to it.

Where ``BOZZETTO_OUTCOMES`` names a folder, what came of a drawing is a line of JSON in it: the
traits, not what the confidence says of them. Lines of other code than that which reads now are not
used, for files are named by a digest of it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import bozzetto_polyhedron

ROOMS = (
    "graph/*.py",
    "reconstruction/*.py",
    "solve/line_readings.py",
    "solve/corner_order.py",
)
"""What reads drawings, in the folder of the plugin."""

NUMBERS = ("confidence_tables.py", "confidence_weights.py", "guess_numbers.py")
"""Of that, what is fitted to outcomes."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """The first reading of one drawing: its leads and traits, and whether it is right.

    The certainty is that of the lines: 1 where they are given. Apart is the lead over readings of
    other shapes, which this fit leaves out.
    """

    evidence: str
    lead: float
    traits: np.ndarray
    right: bool
    apart: float = 0.0
    certainty: float = 1.0


def digest() -> str:
    """Return a name for the code that reads drawings."""
    folder = Path(bozzetto_polyhedron.__file__).parent
    files = sorted(path for room in ROOMS for path in folder.glob(room))
    code = b"".join(path.read_bytes() for path in files if path.name not in NUMBERS)
    return hashlib.sha256(code).hexdigest()[:12]


def kept(
    name: str, seeds: Iterable[int], outcome: Callable[[int], Outcome | None]
) -> dict[int, Outcome]:
    """Return what came of the drawings of some seeds, those without a reading left out.

    Parameters
    ----------
    name : str
        Of the kind of drawings.
    seeds : iterable of int
    outcome : callable
        Reads the drawing of a seed.
    """
    folder = os.environ.get("BOZZETTO_OUTCOMES")
    known: dict[int, Outcome | None] = {}
    path = Path(folder or ".") / f"{name}-{digest()}.jsonl"
    if folder and path.exists():
        lines = (json.loads(line) for line in path.read_text(encoding="utf-8").splitlines())
        known = {line["seed"]: read_from(line["outcome"]) for line in lines}
    found = {}
    for seed in seeds:
        if seed not in known:
            known[seed] = outcome(seed)
            if folder:
                with path.open("a", encoding="utf-8") as file:
                    line = {"seed": seed, "outcome": written(known[seed])}
                    file.write(json.dumps(line) + "\n")
        each = known[seed]
        if each is not None:
            found[seed] = each
    return found


def written(each: Outcome | None) -> dict | None:
    """Return an outcome as JSON keeps it, to the last digit."""
    if each is None:
        return None
    return {
        "evidence": each.evidence,
        "lead": float(each.lead),
        "traits": [float(value) for value in each.traits],
        "right": bool(each.right),
        "apart": float(each.apart),
        "certainty": float(each.certainty),
    }


def read_from(line: dict | None) -> Outcome | None:
    """Return the outcome that a line keeps."""
    return None if line is None else Outcome(**{**line, "traits": np.array(line["traits"])})
