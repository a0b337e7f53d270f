"""``bozzetto simulate``: lets a document's mechanisms go for a while, and writes what they do."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from bozzetto.cli.output import (
    check_ending,
    make_folder,
    open_document,
    picture_size,
    refuse_overwriting,
    warn,
    workbench,
    write_output,
)


def simulate(options: argparse.Namespace) -> int:
    """Move what moves by itself; the exit code."""
    from bozzetto.atomic_files import write_bytes
    from bozzetto.workbench.films import ENDINGS, animation_of, frames

    refuse_overwriting([options.document], [options.output], None)
    check_ending(options.output, ENDINGS)
    ending = options.output.suffix.lower()
    bench = workbench()
    document = open_document(bench, options.document)
    films = frames(bench, document, options.seconds, options.rate)
    if ending in ENDINGS:
        if ending == ".gif":
            data = _gif(bench, films, options)
        else:
            data = animation_of(bench, films, options.rate, ending, options.object, warn)
        make_folder(options.output)
        write_bytes(options.output, data)
    else:
        for document in films:  # noqa: B007 - the last one is written
            pass
        write_output(bench, document, options.output)
    return 0


def _gif(bench: Any, films: Any, options: argparse.Namespace) -> bytes:
    from bozzetto.scene.snapshot import framed
    from bozzetto.workbench.films import gif_of

    size = picture_size(options.size)
    if options.view is None:
        return gif_of(bench, films, options.rate, size)
    return gif_of(
        bench, films, options.rate, size, lambda scene, _: framed(scene, options.view, size)
    )


def add_simulate(commands: Any) -> None:
    """Add the command to the others."""
    command = commands.add_parser("simulate", help="let mechanisms go, and write what they do")
    command.add_argument("document", type=Path)
    command.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        help="a film: .glb or .usdz (animations), .gif; or as it is in the end: .bozz, .step …",
    )
    command.add_argument("--seconds", type=float, default=4.0)
    command.add_argument("--rate", type=float, default=25.0, help="frames a second; default 25")
    command.add_argument("--object", action="append", metavar="NAME", help="only these objects")
    command.add_argument("--view", metavar="NAME", help="of a GIF: front, right, top …")
    command.add_argument("--size", default="600x450", metavar="WxH", help="of a GIF, pixels")
    command.set_defaults(run=simulate)
