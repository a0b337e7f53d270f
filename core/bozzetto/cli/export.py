"""``bozzetto export``: a document's objects to files of other programs, and a report of them."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from bozzetto.cli.handover import handover_of
from bozzetto.cli.output import (
    check_ending,
    open_document,
    refuse_overwriting,
    workbench,
    write_by_command,
    write_outputs,
    write_report,
    writing_command,
)
from bozzetto.cli.placing import placed
from bozzetto.errors import UserError


def export(options: argparse.Namespace) -> int:
    """Export a document; the exit code."""
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.export_document import chosen_models, links_of, unusable

    outputs = options.output
    for output in () if options.command_id else outputs:
        try:
            check_ending(output)
        except UserError as problem:
            raise _named_command(options, output) or problem from None
    refuse_overwriting([options.document], outputs, options.report)
    handover = handover_of(options)
    bench = workbench()
    document = placed(open_document(bench, options.document), options.place)
    if options.command_id:
        models, _ = chosen_models(document, options.object)
        able = [one for one in models if _has_command(bench, one, options.command_id)]
        if not able:
            raise UserError(_no_command(bench, models, options.command_id))
        if len(able) != 1 or len(outputs) != 1:
            raise UserError(
                f"{options.command_id} writes one file of one object; {len(able)} have it. Name "
                "one with --object, and one output."
            )
        write_by_command(bench, able[0], options.command_id, outputs[0])
        return 0
    made = write_outputs(
        bench, document, outputs, options.object, view=options.view, handover=handover
    )
    if options.report:
        models, _ = chosen_models(document, options.object)
        said: dict[str, Any] = {
            "input": str(options.document),
            "output": str(outputs[0]),
            "objects": [
                {
                    "name": model.name,
                    "modeler": model.modeler,
                    **links_of(model),
                    "report": {} if unusable(bench, model) else bench.report(model, Job()),
                }
                for model in models
            ],
        }
        if made[0] is not None:
            said["written"] = made[0]
        if len(outputs) > 1:
            said["outputs"] = [
                {"output": str(path), "written": file}
                for path, file in zip(outputs, made, strict=True)
            ]
        write_report(options.report, said)
    return 0


def _named_command(options: argparse.Namespace, output: Path) -> UserError | None:
    """Return what names the command of an object that alone writes an ending, if there is one."""
    from bozzetto.workbench.export_document import chosen_models, unusable

    bench = workbench()
    try:
        models, _ = chosen_models(open_document(bench, options.document), options.object)
    except UserError:
        return None
    for model in models:
        if unusable(bench, model) is not None:
            continue
        command = writing_command(bench, model.modeler, output)
        if command:
            return UserError(
                f"“{output.suffix.lower()}” is written by a command of “{model.name}”: add "
                f"--command {command}."
            )
    return None


def _no_command(bench: Any, models: Any, command_id: str) -> str:
    """Return that no object has a command, and which of theirs write files."""
    from bozzetto.workbench.export_document import unusable

    writers = sorted(
        {
            command.id
            for model in models
            if unusable(bench, model) is None
            for command in bench.commands.of(model.modeler)
            if command.writes
        }
    )
    known = f"files are written by: {', '.join(writers)}" if writers else "none writes a file"
    return f"No object has a command {command_id!r}; {known}."


def _has_command(bench: Any, model: Any, command_id: str) -> bool:
    from bozzetto.workbench.export_document import unusable

    if unusable(bench, model) is not None:
        return False
    return any(command.id == command_id for command in bench.commands.of(model.modeler))
