"""``bozzetto trace``: from a picture of a drawing on paper to ink."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from bozzetto.cli.output import make_folder, refuse_overwriting
from bozzetto.errors import UserError


def trace(options: argparse.Namespace) -> int:
    """Trace a picture; the exit code."""
    from bozzetto.exchange.export import write_drawing
    from bozzetto.exchange.formats import find, writers
    from bozzetto.exchange.import_file import is_picture, read_image
    from bozzetto.ink.trace import trace as tracing
    from bozzetto.ink.trace.placed_ink import page_drawing

    refuse_overwriting([options.picture], [options.output], None)
    find(options.output, writers("ink"))
    if not is_picture(options.picture):
        raise UserError(
            f"“{options.picture.name}” is no picture. Trace a PNG or JPEG, for example."
        )
    if not 0.0 <= options.sensitivity <= 1.0:
        raise UserError(
            "--sensitivity is a number from 0 (only dark lines) to 1 (faint ones, too)."
        )
    pixels = read_image(options.picture, trusted=options.trust_file)
    sheet = tracing.sheet_of(pixels, page=not options.whole)
    lines = tracing.trace(sheet, options.sensitivity)
    make_folder(options.output)
    write_drawing(page_drawing(lines, sheet.size, options.picture.stem), options.output)
    outlines = sum(line.is_closed for line in lines)
    page = "" if sheet.corners is None else "; the page was found and straightened"
    print(f"{len(lines)} strokes, {outlines} of them closed{page}", file=sys.stderr)
    return 0


def add_trace(commands: Any) -> None:
    """Add the command to the others."""
    command = commands.add_parser("trace", help="turn a scanned or photographed sketch into ink")
    command.add_argument("picture", type=Path, help="PNG, JPEG, TIFF, WebP or BMP")
    command.add_argument("-o", "--output", type=Path, required=True, help="ink JSON, SVG or InkML")
    command.add_argument(
        "--sensitivity",
        type=float,
        default=0.5,
        metavar="S",
        help="how faint a line may be: 0 … 1; default 0.5",
    )
    command.add_argument(
        "--whole", action="store_true", help="take the whole picture; look for no page in it"
    )
    command.add_argument(
        "--trust-file",
        action="store_true",
        help="read the picture however much time and memory it takes",
    )
    command.set_defaults(run=trace)
