"""``bozzetto build``: from drawings to shapes, documents and reports."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bozzetto.cli.handover import handover_of
from bozzetto.cli.output import (
    EXIT_ERROR,
    EXIT_FAULT,
    check_ending,
    complain,
    fault_message,
    open_document,
    refuse_overwriting,
    warn,
    workbench,
    write_by_command,
    write_outputs,
    write_report,
    writing_command,
)
from bozzetto.errors import UserError

if TYPE_CHECKING:
    from bozzetto.document.model import Document, Model, Underlay
    from bozzetto.exchange.reading import MeshFile
    from bozzetto.images.stored_picture import Picture
    from bozzetto.ink.drawing import Drawing
    from bozzetto.workbench.workbench import Workbench

MAX_PLACES = 3
"""Places of a mistake that an error line names."""


def build(options: argparse.Namespace) -> int:
    """Build every input; the exit code."""
    from bozzetto.plugin.guard.guard import PluginFault

    bench = workbench()
    modeler_id = bench.registry.resolve(options.modeler)
    values = _settings(bench, modeler_id, options.set)
    inputs = [Path(name) for name in options.inputs]
    targets = _targets(inputs, options.output, options.format)
    files = [file for row in targets for file in row]
    for file in files:
        if not options.command_id:
            _check_ending(bench, modeler_id, file)
    if options.command_id and len(files) > len(targets):
        raise UserError("A command writes one file. Give -o once.")
    refuse_overwriting(inputs, files, options.report)
    handover_of(options)  # a wrong switch is told before the first input is read
    reports: list[dict[str, Any]] = []
    code = 0
    for number, (source, row) in enumerate(zip(inputs, targets, strict=True), 1):
        if len(inputs) > 1:
            print(f"[{number}/{len(inputs)}] {source.name} → {row[0]}", file=sys.stderr)
        try:
            report, written = _build_one(bench, modeler_id, source, row, values, options)
        except (UserError, PluginFault) as problem:
            if len(inputs) == 1:
                raise
            fault = isinstance(problem, PluginFault)
            words = fault_message(problem) if fault else str(problem)
            complain(f"{source.name}: {words}")
            code = max(code, EXIT_FAULT if fault else EXIT_ERROR)
            continue
        told = {"input": str(source), "output": str(row[0]), "report": report}
        reports.append(told | written)
    if options.report and reports:
        single = reports[0]["report"] | {k: v for k, v in reports[0].items() if k == "written"}
        write_report(options.report, single if len(inputs) == 1 else {"files": reports})
    return code


def _check_ending(bench: Any, modeler_id: str, target: Path) -> None:
    """Refuse a file that can be no output; name the command that writes such files."""
    try:
        check_ending(target)
    except UserError:
        command = writing_command(bench, modeler_id, target)
        if not command:
            raise
        raise UserError(
            f"“{target.suffix.lower()}” is written by a command: add --command {command}."
        ) from None


@dataclass(frozen=True)
class _Source:
    """What an input holds: a picture, a mesh or a drawing, one of them.

    Attributes
    ----------
    picture : Picture, optional
    mesh : MeshFile, optional
    drawing : Drawing, optional
    underlays : tuple of Underlay
        Those of a document.
    """

    picture: Picture | None = None
    mesh: MeshFile | None = None
    drawing: Drawing | None = None
    underlays: tuple[Underlay, ...] = ()


def _build_one(
    bench: Workbench,
    modeler_id: str,
    source: Path,
    targets: Sequence[Path],
    values: dict[str, object],
    options: argparse.Namespace,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Build one input, solved once; its report where one is wanted, and what was written of it."""
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.export_document import links_of

    there, on = _drawn_on(bench, options.on)
    read = _read(bench, modeler_id, source, values, trusted=options.trust_file)
    drawing = read.drawing
    warn(() if drawing is None else drawing.left_out)
    report: dict[str, Any] = {}
    try:
        if on and drawing is None:
            raise UserError("--on takes ink to draw on an object. Give a drawing.")
        model = _model_of(bench, modeler_id, read, source.stem, values, there, on)
        warn(bench.parts.idle(model, values))
        if options.report:
            report = bench.report(model, Job()) | links_of(model)
        if options.command_id:
            write_by_command(bench, model, options.command_id, targets[0])
            _warn_of_shape(bench, model)
            return report, {}
        camera = None if drawing is None else drawing.camera
        underlays = (*there.underlays, *read.underlays)
        document = replace(there, camera=camera, underlays=underlays)
        written = _write(bench, document, model, targets, report, options)
    except UserError as problem:
        raise UserError(problem.message + _places(problem, drawing)) from problem
    told = [one for one in written if one is not None]
    if not told:
        return report, {}
    return report, {"written": told[0] if len(targets) == 1 else told}


def _read(
    bench: Workbench, modeler_id: str, path: Path, values: dict[str, object], *, trusted: bool
) -> _Source:
    """Read an input, whatever it is; a mesh that the modeler takes as ink becomes a drawing."""
    from bozzetto.exchange.formats import find, readers
    from bozzetto.exchange.import_file import (
        is_mesh,
        is_picture,
        read_drawing,
        read_mesh_file,
        read_picture,
    )

    if path.suffix.lower() == ".bozz":
        document = open_document(bench, path)
        drawing = replace(bench.readings.drawing_of_document(document), name=path.stem)
        return _Source(drawing=drawing, underlays=document.underlays)
    if is_picture(path):
        return _Source(picture=read_picture(path, trusted=trusted))
    if not path.is_dir() and is_mesh(path):
        mesh = read_mesh_file(path, trusted=trusted)
        warn(mesh.told(values))
        ink = bench.sources.ink_of_file(modeler_id, mesh, path.stem)
        return _Source(mesh=mesh) if ink is None else _Source(drawing=ink)
    if not path.is_dir():
        find(path, readers())
    return _Source(drawing=read_drawing(path, trusted=trusted))


def _model_of(
    bench: Workbench,
    modeler_id: str,
    read: _Source,
    name: str,
    values: dict[str, object],
    there: Document,
    on: tuple[Model, ...],
) -> Model:
    """Return the model that the modeler makes of an input, in a document that is there."""
    from bozzetto.plugin.context import Context
    from bozzetto.plugin.job import Job

    if read.picture is not None:
        return bench.sources.from_picture(modeler_id, read.picture, values)
    if read.mesh is not None:
        return bench.sources.from_mesh_file(modeler_id, read.mesh, name, values)
    assert read.drawing is not None
    context = Context(camera=read.drawing.camera, scene=bench.scene(there, Job()))
    return bench.sources.from_drawing(modeler_id, read.drawing, values, context, on=on)


def _write(
    bench: Workbench,
    there: Document,
    model: Model,
    targets: Sequence[Path],
    report: dict[str, Any],
    options: argparse.Namespace,
) -> list[dict[str, Any] | None]:
    """Write the outputs of a model, and tell what its modeler has to say of the shape.

    Where they are refused the report is written all the same.
    """
    from bozzetto.document import edit
    from bozzetto.plugin.guard.guard import PluginFault

    document = edit.add_model(there, model).document
    is_document = targets[0].suffix.lower() == ".bozz"
    try:
        written = write_outputs(
            bench,
            document,
            targets,
            None if is_document or len(document) == 1 else [document.models[-1].name],
            view=options.view,
            refuse_baseless=not options.allow_template,
            handover=handover_of(options),
        )
    except UserError:
        # Why there is nothing to write stands in what the modeler says, if it can say it.
        with contextlib.suppress(UserError, PluginFault):
            _warn_of_shape(bench, model)
        if options.report and len(options.inputs) == 1:
            write_report(options.report, report)
        raise
    if written == [None]:
        _warn_of_shape(bench, model)
    return written


def _warn_of_shape(bench: Workbench, model: Model) -> None:
    """Print what a modeler cautions about a shape."""
    from bozzetto.plugin.job import Job

    warn(caution.message for caution in bench.cautions(model, Job()))


def _drawn_on(bench: Workbench, told: str | None) -> tuple[Document, tuple[Model, ...]]:
    """Return the document of ``--on``, and those of its objects that are drawn on."""
    from bozzetto.document.model import Document
    from bozzetto.workbench.export_document import chosen_models

    if told is None:
        return Document(), ()
    whole = os.path.exists(told) or ":" not in told
    path, _, name = (told, "", "") if whole else told.rpartition(":")
    document = open_document(bench, Path(path))
    models, _ = chosen_models(document, [name] if name else None)
    if not models:
        raise UserError(f"Nothing is visible in {path}. Name the object: {path}:NAME.")
    return document, tuple(models)


def _places(problem: UserError, drawing: Any) -> str:
    """Return where a mistake lies, in the coordinates of the drawing's file."""
    if not problem.places or drawing is None:
        return ""
    import numpy as np

    from bozzetto.exchange.page_layout import Sheet

    points = problem.places[:MAX_PLACES]
    sheet = Sheet.of_front_view(drawing.camera)
    if sheet is not None and all(stroke.tool == "imported" for stroke in drawing.strokes):
        points = tuple(map(tuple, sheet.to_units(np.asarray(points), drawing.camera).tolist()))
    said = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in points)
    return f" It is at {said}{' …' if len(problem.places) > MAX_PLACES else ''}."


def _settings(bench: Workbench, modeler_id: str, assignments: Sequence[str]) -> dict[str, object]:
    """Return the values of ``--set``: of the modeler, of all its parts, or of a named part."""
    from bozzetto.parameters import parameter_fields, parse_parameter
    from bozzetto.plugin.parts import PartsModeler

    modeler, title = bench.registry.modeler(modeler_id), bench.registry.info(modeler_id).title
    parts = modeler.part_types if isinstance(modeler, PartsModeler) else ()
    of_parts = {field.name: field for kind in parts for field in parameter_fields(kind)}
    fields = of_parts | {field.name: field for field in parameter_fields(modeler.state_type)}
    values: dict[str, object] = {}
    for assignment in assignments:
        name, sign, text = assignment.partition("=")
        if not sign:
            raise UserError(f"--set takes NAME=VALUE, not {assignment!r}.")
        part, _, plain = name.rpartition(".")
        known = of_parts if part else fields
        if plain not in known:
            owner = f"a part of {title}" if part else title
            words = ", ".join(known) or "none"
            raise UserError(f"There is no parameter {plain!r}; {owner} has: {words}.")
        values[name] = parse_parameter(known[plain], text)
    return values


def _targets(
    inputs: Sequence[Path], outputs: Sequence[str], ending: str | None
) -> list[tuple[Path, ...]]:
    """Return the files to write of each input."""
    if len(outputs) > 1:
        if len(inputs) > 1 or ending is not None:
            raise UserError("Several outputs are of one input. Name a folder and --format instead.")
        if not all(outputs):
            raise UserError("The output has no name. Say where to write it.")
        if any(one.endswith(("/", "\\")) or os.path.isdir(one) for one in outputs):
            raise UserError("One of several outputs is a folder. Name a file each time.")
        if len(set(outputs)) < len(outputs):
            raise UserError("Two outputs have the same name. Name each once.")
        return [tuple(map(Path, outputs))]
    return [(target,) for target in _single_targets(inputs, outputs[0], ending)]


def _single_targets(inputs: Sequence[Path], output: str, ending: str | None) -> list[Path]:
    if not output:
        raise UserError("The output has no name. Say where to write it.")
    folder = len(inputs) > 1 or output.endswith(("/", "\\")) or os.path.isdir(output)
    if not folder:
        if ending is not None:
            raise UserError("--format goes with a folder. Name the folder with a / at its end.")
        return [Path(output)]
    if ending is None:
        raise UserError("Several inputs, or a folder as output, need --format (for example stl).")
    if os.path.isfile(output):
        raise UserError(f"{output} is a file. Several inputs need a folder as output.")
    suffix = f".{ending.lstrip('.').lower()}"
    targets = [Path(output) / f"{source.stem}{suffix}" for source in inputs]
    if len(set(targets)) < len(targets):
        raise UserError("Two inputs have the same name, so their outputs would too. Rename one.")
    return targets
