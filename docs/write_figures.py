"""Write the tables of pages that name their commands.

``python docs/write_figures.py [PAGE.md …] [figures_NAME …]``: with names of modules only the tables
that these make.

A table stands between the command that makes it and an end mark:

    <!-- figures: python -m tests.plugins.polyhedron.figures_solid -->
    …
    <!-- /figures -->

The commands run one after another and take minutes each, for they draw hundreds of drawings;
nothing else should run meanwhile, or their times say nothing.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGES = (
    "car.md",
    "paper-to-ink.md",
    "polyhedron.md",
    "product.md",
    "product-paper.md",
    "quads.md",
    "silhouette.md",
    "symmetry.md",
    "texture-coordinates.md",
)
BLOCK = re.compile(
    r"(<!-- figures: python (?P<command>[^\n]*?) -->\n).*?(<!-- /figures -->)", re.DOTALL
)


def output_of(command: str) -> str:
    """Return what a command of this Python prints."""
    done = subprocess.run(
        [sys.executable, *shlex.split(command)],
        cwd=ROOT,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def written(page: str, names: Sequence[str] = ()) -> str:
    """Return a page with its figures made anew: those of the modules named, or else all."""

    def made(found: re.Match[str]) -> str:
        if names and found["command"].split()[1].rpartition(".")[2] not in names:
            return found[0]
        return f"{found[1]}\n{output_of(found['command'])}\n\n{found[3]}"

    return BLOCK.sub(made, page)


if __name__ == "__main__":
    wanted = [name for name in sys.argv[1:] if not name.endswith(".md")]
    for name in [name for name in sys.argv[1:] if name.endswith(".md")] or PAGES:
        path = ROOT / "docs" / name
        path.write_text(written(path.read_text(encoding="utf-8"), wanted), encoding="utf-8")
