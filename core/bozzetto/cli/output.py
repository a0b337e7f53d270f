"""Messages and files of the commands."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from bozzetto.errors import UserError

ASK_FOR_IT = "To write it all the same, say --allow-template."

EXIT_FAULT = 1
EXIT_ERROR = 2


def complain(message: str) -> None:
    """Say in one line what went wrong."""
    print(f"error: {' '.join(message.split())}", file=sys.stderr)


def warn(messages: Iterable[str]) -> None:
    """Say what a person must know of what was written, a line each."""
    for message in messages:
        print(f"warning: {' '.join(message.split())}", file=sys.stderr)


def say_on_screen(step: str) -> None:
    """Say what long work does now, a line each, to a person: not where the output is kept."""
    if sys.stderr.isatty():
        print(f"{step} …", file=sys.stderr, flush=True)


def fault_message(fault: Exception) -> str:
    """Return a plugin's fault in one line."""
    return f"{fault} Its author can find the place with “bozzetto -v …”."


def workbench() -> Any:
    """Return a workbench with all plugins but those that the person switched off."""
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.plugin.host.switched_off import switched_off
    from bozzetto.workbench.workbench import Workbench

    registry = Registry(disabled=switched_off() or ())
    if sys.stderr is not None and sys.stderr.isatty():
        from bozzetto.cli.slow_calls import tell_slow_calls

        tell_slow_calls(registry.guard, lambda words: print(words, file=sys.stderr))
    return Workbench(registry)


def open_document(bench: Any, path: Path) -> Any:
    """Read a document, and say what of it stays closed."""
    from bozzetto.document.storage.bozz_file import read_document
    from bozzetto.exchange.formats import readers

    ending = path.suffix.lower()
    if any(ending in one.endings for one in readers("ink")):
        raise UserError(
            f"{path.name} is a drawing and no document. Turn it into shapes with “bozzetto build "
            f"MODELER {path.name} -o …”."
        )
    if any(ending in one.endings for one in readers("mesh")):
        raise UserError(
            f"{path.name} is a mesh and no document. “bozzetto build mesh {path.name} -o …” writes "
            "it in other formats."
        )
    document, report = read_document(path, bench.registry)
    for warning in report.warnings:
        print(f"note: {warning}", file=sys.stderr)
    return document


def refuse_overwriting(
    inputs: Sequence[Path], targets: Sequence[Path], report: Path | None
) -> None:
    """Refuse to write one file over another of the same command."""
    read = {os.path.realpath(path) for path in inputs}
    written = [os.path.realpath(path) for path in (*targets, *([report] if report else []))]
    if read.intersection(written):
        raise UserError("An output would replace an input. Choose another name or folder for it.")
    if len(set(written)) < len(written):
        raise UserError("The report would replace an output. Give it a name of its own.")
    if report is not None and report.is_dir():
        raise UserError(f"{report} is a folder. The report needs a file name.")


def check_ending(target: Path, others: Iterable[str] = ()) -> None:
    """Refuse a file that can be no output, before anything is read or solved.

    Parameters
    ----------
    target : Path
        Of the file to write.
    others : iterable of str
        Endings of what the command writes besides documents and shapes.
    """
    from bozzetto.exchange.formats import find, writers

    own = (".bozz", *others)
    if target.suffix.lower() not in own:
        find(target, writers("mesh", "surfaces", "curves"), own)


def writing_command(bench: Any, modeler_id: str, target: Path) -> str:
    """Return the id of the command of a modeler that writes files like this one, "" for none."""
    ending = target.suffix.lower()
    ids = [each.id for each in bench.commands.of(modeler_id) if ending and each.writes == ending]
    return ids[0] if ids else ""


def write_output(
    bench: Any,
    document: Any,
    target: Path,
    names: Sequence[str] | None = None,
    *,
    view: str | None = None,
    refuse_baseless: bool = False,
    handover: Any = None,
) -> dict[str, Any] | None:
    """Write one file; see `write_outputs`.

    Parameters
    ----------
    bench, document, names, view, refuse_baseless, handover
        As in `write_outputs`.
    target : Path
        The file to write; its ending names the format.

    Returns
    -------
    dict or None
        What was written and left out, as plain JSON values; None of a document.
    """
    return write_outputs(
        bench,
        document,
        [target],
        names,
        view=view,
        refuse_baseless=refuse_baseless,
        handover=handover,
    )[0]


def write_outputs(
    bench: Any,
    document: Any,
    targets: Sequence[Path],
    names: Sequence[str] | None = None,
    *,
    view: str | None = None,
    refuse_baseless: bool = False,
    handover: Any = None,
) -> list[dict[str, Any] | None]:
    """Write a document's shapes, or the document itself, and warn of what is not in it.

    Everything is solved once, whatever the number of files.

    Parameters
    ----------
    bench : Workbench
        Runs the modelers.
    document : Document
        What to write.
    targets : sequence of Path
        The files to write; their endings name the formats.
    names : sequence of str, optional
        Names of the objects wanted; by default all that are visible.
    view : str, optional
        The standard view of a flat file; see `prepared_files`.
    refuse_baseless : bool
        Whether shapes that are not made from the input are an error; see `Caution`.
    handover : Handover, optional
        Unit, axes, size and number of triangles.

    Returns
    -------
    list of dict or None
        What was written and left out, as plain JSON values; None of a document.

    Raises
    ------
    UserError
        If there is no object of a name, nothing to write, or it cannot be written.
    """
    from bozzetto.document.storage.bozz_file import write_document
    from bozzetto.exchange.handover import AS_USUAL
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.export_document import chosen_models, object_shapes, prepared_files
    from bozzetto.workbench.films import with_recording

    models, hidden = chosen_models(document, names)
    wanted = AS_USUAL if handover is None else handover
    if any(target.suffix.lower() == ".bozz" for target in targets):
        if names is not None:
            raise UserError("A document keeps all its objects. Leave --object out.")
        if view is not None:
            raise UserError("A document keeps its own view. Leave --view out.")
        if wanted != AS_USUAL or len(targets) > 1:
            raise UserError("A document is written alone and as it is. Leave the switches out.")
        make_folder(targets[0])
        write_document(document, targets[0])
        return [None]
    objects = object_shapes(bench, models, Job())
    objects = replace(objects, left_out=(*hidden, *objects.left_out))
    baseless = objects.warnings(baseless_only=True)
    if refuse_baseless and baseless:
        raise UserError(f"{' '.join(baseless)} {ASK_FOR_IT}")
    objects = with_recording(bench, document, objects, names, targets, Job())
    made = prepared_files(objects, targets, document.camera, view=view, handover=wanted)
    for target, file in zip(targets, made, strict=True):
        make_folder(target)
        file.write(target)
    lost = dict.fromkeys(warning for file in made for warning in file.warnings())
    warn((*_waiting_ink(document), *objects.warnings(), *lost))
    return [file.as_values() | {"warnings": list(objects.warnings())} for file in made]


def write_by_command(bench: Any, model: Any, command_id: str, target: Path) -> None:
    """Write the file of a modeler's command, as the window does.

    Raises
    ------
    UserError
        If the modeler has no such command, or as `ModelCommands.write` does.
    """
    from bozzetto.plugin.context import Context

    command = bench.commands.find(model.modeler, command_id)
    make_folder(target)
    bench.commands.write(model, command, Context(), target)


def _waiting_ink(document: Any) -> tuple[str, ...]:
    """Return a warning of ink that no modeler has taken."""
    if not document.waiting:
        return ()
    strokes = len(document.waiting)
    return (
        f"Ink waits in this document (strokes: {strokes}). It is no part of the shapes; open the "
        "document to finish it.",
    )


def write_report(path: Path, said: dict[str, Any]) -> None:
    """Write a report as JSON."""
    from bozzetto.atomic_files import write_bytes

    make_folder(path)
    write_bytes(path, (json.dumps(said, indent=2, ensure_ascii=False) + "\n").encode())


def make_folder(target: Path) -> None:
    """Make the folder in which a file shall lie."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise UserError(
            f"The folder {target.parent} cannot be made: {problem.strerror}. Choose another."
        ) from None


def picture_size(text: str) -> tuple[int, int]:
    """Return width and height, px, of a size such as 1200x900."""
    try:
        width, height = (int(part) for part in text.lower().replace("×", "x").split("x"))
    except ValueError:
        raise UserError(
            f"A size is WIDTHxHEIGHT in pixels, such as 1200x900; not {text!r}."
        ) from None
    return width, height
