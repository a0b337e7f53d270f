"""What the commands share: how they say what went wrong, and how they write what they made."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bozzetto.errors import UserError

__all__ = [
    "EXIT_ERROR",
    "EXIT_FAULT",
    "complain",
    "hand_over",
    "keep_apart",
    "make_folder",
    "words_of_fault",
    "workbench",
]

EXIT_FAULT = 1
EXIT_ERROR = 2


def complain(message: str) -> None:
    """Say in one line what went wrong."""
    print(f"error: {' '.join(message.split())}", file=sys.stderr)


def words_of_fault(fault: Exception) -> str:
    """A plugin's fault in one line."""
    return f"{fault} Its author can find the place with “bozzetto -v …”."


def workbench() -> Any:
    """A workbench with all plugins."""
    from bozzetto.plugin.registry import Registry
    from bozzetto.workbench import Workbench

    return Workbench(Registry())


def keep_apart(inputs: Sequence[Path], targets: Sequence[Path], report: Path | None) -> None:
    """Refuse to write one file over another of the same command."""
    read = {os.path.realpath(path) for path in inputs}
    written = [os.path.realpath(path) for path in (*targets, *([report] if report else []))]
    if read.intersection(written):
        raise UserError("An output would replace an input. Choose another name or folder for it.")
    if len(set(written)) < len(written):
        raise UserError("The report would replace an output. Give it a name of its own.")
    if report is not None and report.is_dir():
        raise UserError(f"{report} is a folder. The report needs a file name.")


def hand_over(bench: Any, document: Any, target: Path, names: Sequence[str] | None = None) -> None:
    """Write a document's shapes, or the document itself."""
    from bozzetto.plugin.job import Job

    models = [model for model in document if names is None or model.name in names]
    missing = set(names or ()) - {model.name for model in models}
    if missing:
        known = ", ".join(model.name for model in document)
        raise UserError(f"There is no object {', '.join(sorted(missing))}; there are: {known}.")
    if target.suffix.lower() == ".bozz":
        if names is not None:
            raise UserError("A document keeps all its objects. Leave --object out.")
        from bozzetto.document.file import write_document

        make_folder(target)
        write_document(document, target)
        return
    from bozzetto.exchange.export import encoded
    from bozzetto.storage import write_bytes

    if document.waiting:
        print(
            f"note: ink waits in this document (strokes: {len(document.waiting)}). It is no part "
            "of the shapes; open the document to finish it.",
            file=sys.stderr,
        )
    data = encoded(bench.shapes(models, Job()), target, camera=document.camera)
    make_folder(target)
    write_bytes(target, data)


def make_folder(target: Path) -> None:
    """Make the folder in which a file shall lie."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise UserError(
            f"The folder {target.parent} cannot be made: {problem.strerror}. Choose another."
        ) from None
