"""``bozzetto export``: a document's objects to files of other programs, and a report of them."""

from __future__ import annotations

import argparse
from typing import Any

from bozzetto.cli.output import (
    open_document,
    refuse_overwriting,
    workbench,
    write_output,
    write_report,
)


def export(options: argparse.Namespace) -> int:
    """Export a document; the exit code."""
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.export_document import chosen_models, links_of, unusable

    refuse_overwriting([options.document], [options.output], options.report)
    bench = workbench()
    document = open_document(bench, options.document)
    made = write_output(bench, document, options.output, options.object, view=options.view)
    if options.report:
        models, _ = chosen_models(document, options.object)
        said: dict[str, Any] = {
            "input": str(options.document),
            "output": str(options.output),
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
        write_report(options.report, said if made is None else said | {"written": made})
    return 0
