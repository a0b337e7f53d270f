"""``bozzetto build``: from drawings to shapes, documents and reports."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bozzetto.cli_output import (
    EXIT_ERROR,
    EXIT_FAULT,
    complain,
    hand_over,
    keep_apart,
    make_folder,
    words_of_fault,
    workbench,
)
from bozzetto.errors import UserError

__all__ = ["build"]

MAX_PLACES = 3
"""Places of a mistake that an error line names."""


def build(options: argparse.Namespace) -> int:
    """Build every input; the exit code."""
    from bozzetto.exchange.formats import find, writers
    from bozzetto.plugin.guard import PluginFault

    bench = workbench()
    modeler_id = bench.registry.resolve(options.modeler)
    values = _settings(bench.registry.modeler(modeler_id), options.set)
    inputs = [Path(name) for name in options.inputs]
    targets = _targets(inputs, options.output, options.format)
    for target in targets:
        if target.suffix.lower() != ".bozz":
            find(target, writers("mesh", "surfaces", "curves"))
    keep_apart(inputs, targets, options.report)
    reports: list[dict[str, Any]] = []
    code = 0
    for number, (source, target) in enumerate(zip(inputs, targets, strict=True), 1):
        if len(inputs) > 1:
            print(f"[{number}/{len(inputs)}] {source.name} → {target}", file=sys.stderr)
        try:
            report = _build_one(
                bench, modeler_id, source, target, values, bool(options.report), options.trust_file
            )
        except (UserError, PluginFault) as problem:
            if len(inputs) == 1:
                raise
            fault = isinstance(problem, PluginFault)
            words = words_of_fault(problem) if fault else str(problem)
            complain(f"{source.name}: {words}")
            code = max(code, EXIT_FAULT if fault else EXIT_ERROR)
            continue
        reports.append({"input": str(source), "output": str(target), "report": report})
    if options.report and reports:
        said = reports[0]["report"] if len(inputs) == 1 else {"files": reports}
        _write_text(options.report, json.dumps(said, indent=2, ensure_ascii=False) + "\n")
    return code


def _build_one(
    bench: Any,
    modeler_id: str,
    source: Path,
    target: Path,
    values: dict[str, object],
    wants_report: bool,
    trusted: bool,
) -> dict[str, Any]:
    from bozzetto.document.model import Document
    from bozzetto.exchange.importing import is_picture, read_drawing, read_picture
    from bozzetto.plugin.job import Job

    picture = read_picture(source, trusted=trusted) if is_picture(source) else None
    drawing = read_drawing(source, trusted=trusted) if picture is None else None
    try:
        if picture is not None:
            model = bench.from_picture(modeler_id, picture, values)
        else:
            model = bench.from_drawing(modeler_id, drawing, values)
        report: dict[str, Any] = bench.report(model, Job()) if wants_report else {}
        camera = None if drawing is None else drawing.camera
        hand_over(bench, Document((model,), camera=camera), target)
    except UserError as problem:
        raise UserError(problem.message + _places(problem, drawing)) from problem
    return report


def _places(problem: UserError, drawing: Any) -> str:
    """Where a mistake lies, in the coordinates of the drawing's file: nothing lights up here."""
    if not problem.places or drawing is None:
        return ""
    import numpy as np

    from bozzetto.exchange.sheet import Sheet

    points = problem.places[:MAX_PLACES]
    sheet = Sheet.of_front_view(drawing.camera)
    if sheet is not None and all(stroke.tool == "imported" for stroke in drawing.strokes):
        points = tuple(map(tuple, sheet.to_units(np.asarray(points), drawing.camera).tolist()))
    said = ", ".join(f"({x:.6g}, {y:.6g})" for x, y in points)
    return f" It is at {said}{' …' if len(problem.places) > MAX_PLACES else ''}."


def _settings(modeler: Any, assignments: Sequence[str]) -> dict[str, object]:
    """What ``--set`` says: parameters of the modeler, of its parts, and of one part by name."""
    from bozzetto.plugin.parameters import parameter_fields, parse_parameter
    from bozzetto.plugin.parts import HasParts

    parts = modeler.part_types if isinstance(modeler, HasParts) else ()
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
            owner = f"a part of {modeler.title}" if part else modeler.title
            words = ", ".join(known) or "none"
            raise UserError(f"There is no parameter {plain!r}; {owner} has: {words}.")
        values[name] = parse_parameter(known[plain], text)
    return values


def _targets(inputs: Sequence[Path], output: str, ending: str | None) -> list[Path]:
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


def _write_text(path: Path, text: str) -> None:
    from bozzetto.storage import write_bytes

    make_folder(path)
    write_bytes(path, text.encode())
