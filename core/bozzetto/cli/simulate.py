"""``bozzetto simulate``: films of a document's mechanisms, let go or as they were moved."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, Final

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
from bozzetto.errors import UserError

RATE: Final = 25.0
"""Frames a second."""


def simulate(options: argparse.Namespace) -> int:
    """Move what moves by itself, or as it was recorded; the exit code."""
    from bozzetto.atomic_files import write_bytes
    from bozzetto.workbench.films import ANIMATIONS, ENDINGS, animation_of, pace_of

    refuse_overwriting([options.document], [options.output], None)
    check_ending(options.output, ENDINGS)
    ending = options.output.suffix.lower()
    bench = workbench()
    document = open_document(bench, options.document)
    films, seconds = _films(bench, document, options, ending)
    rate = pace_of(seconds, RATE if options.rate is None else options.rate)
    if ending in ENDINGS:
        if ending in ANIMATIONS:
            data = animation_of(bench, films, seconds, ending, options.object, warn)
        else:
            data = _pictures(bench, films, options, rate)
        make_folder(options.output)
        write_bytes(options.output, data)
    else:
        for document in films:  # noqa: B007 - the last one is written
            pass
        write_output(bench, document, options.output)
    return 0


def _films(bench: Any, document: Any, options: argparse.Namespace, ending: str) -> Any:
    """Return the documents of a film, and their times."""
    from bozzetto.workbench import films

    rate = RATE if options.rate is None else options.rate
    if not options.recorded:
        seconds = films.frames(bench, document, options.seconds, rate)
        return seconds, films.frame_times(options.seconds, rate)
    if ending not in films.ENDINGS:
        raise UserError(
            "What was recorded leaves as a film: .glb, .usdz, .gif or .mp4. Choose one of these."
        )
    kept = films.recordings(bench, document)
    times = films.recorded_times(kept, options.rate if ending in films.ANIMATIONS else rate)
    return films.replayed(bench, document, kept, times), times


def _pictures(bench: Any, films: Any, options: argparse.Namespace, rate: float) -> bytes:
    from bozzetto.scene.snapshot import framed
    from bozzetto.workbench.films import picture_film_of

    size, ending = picture_size(options.size), options.output.suffix.lower()
    if options.view is None:
        return picture_film_of(bench, films, rate, size, ending=ending)
    return picture_film_of(
        bench, films, rate, size, lambda scene, _: framed(scene, options.view, size), ending
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
        help="a film: .glb or .usdz (animations), .gif, .mp4; or as it is in the end: .bozz, …",
    )
    kind = command.add_mutually_exclusive_group()
    kind.add_argument("--seconds", type=float, default=4.0, help="how long it goes on; default 4")
    kind.add_argument(
        "--recorded", action="store_true", help="a film of what was recorded, as by the pen"
    )
    command.add_argument(
        "--rate",
        type=float,
        help="frames a second; default 25, in animations of a recording all that was recorded",
    )
    command.add_argument("--object", action="append", metavar="NAME", help="only these objects")
    command.add_argument("--view", metavar="NAME", help="of pictures: front, right, top …")
    command.add_argument("--size", default="600x450", metavar="WxH", help="of pictures, pixels")
    command.set_defaults(run=simulate)
