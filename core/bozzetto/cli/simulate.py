"""``bozzetto simulate``: lets a document's mechanisms go for a while, and writes what they do."""

from __future__ import annotations

import argparse
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from bozzetto.cli.output import (
    make_folder,
    open_document,
    picture_size,
    refuse_overwriting,
    warn,
    workbench,
    write_output,
)
from bozzetto.errors import UserError

LONGEST: Final = 0.05
"""Longest step of a tool, s; see `Tool.step`."""

MOST_FRAMES: Final = 3600
"""Frames of a film: a minute at 60 a second."""


def simulate(options: argparse.Namespace) -> int:
    """Move what moves by itself; the exit code."""
    refuse_overwriting([options.document], [options.output], None)
    ending = options.output.suffix.lower()
    if not 0.0 < options.seconds * options.rate <= MOST_FRAMES:
        raise UserError(f"A film has 1 to {MOST_FRAMES} frames. Change --seconds or --rate.")
    bench = workbench()
    document = open_document(bench, options.document)
    films = frames(bench, document, options.seconds, options.rate)
    if ending == ".glb":
        _write_glb(bench, films, options)
    elif ending == ".gif":
        _write_gif(bench, films, options)
    else:
        for document in films:  # noqa: B007 - the last one is written
            pass
        write_output(bench, document, options.output)
    return 0


def frames(bench: Any, document: Any, seconds: float, rate: float) -> Iterator[Any]:
    """Yield a document as it is at the beginning and after each frame.

    Raises
    ------
    UserError
        If nothing in it moves by itself.
    """
    from bozzetto.plugin.context import Context

    players = {model.id: tool for model in document if (tool := _player(bench, model)) is not None}
    if not players:
        raise UserError("Nothing in this document moves by itself.")
    yield document
    context = Context(camera=document.camera)
    steps = max(1, -int(-1.0 / rate // LONGEST))
    for _ in range(round(seconds * rate)):
        for model in [model for model in document if model.id in players]:
            for _ in range(steps):
                model = bench.step(model, players[model.id], None, 1.0 / rate / steps, context)
            document = document.with_model(model)
        yield document


def _player(bench: Any, model: Any) -> Any:
    """Return the tool of a model that goes on by itself, if there is one."""
    from bozzetto.workbench.export_document import unusable

    if not model.visible or unusable(bench, model) is not None:
        return None
    return next((tool for tool in bench.tools(model.modeler) if tool.plays), None)


def _write_glb(bench: Any, films: Iterator[Any], options: argparse.Namespace) -> None:
    from bozzetto.atomic_files import write_bytes
    from bozzetto.exchange.mesh.glb import write_motion
    from bozzetto.geometry import meshed
    from bozzetto.plugin.job import Job
    from bozzetto.workbench.export_document import chosen_models, object_shapes

    shapes: list[Any] = []
    for document in films:
        models, _ = chosen_models(document, options.object)
        objects = object_shapes(bench, models, Job())
        if not shapes:
            warn(objects.warnings())
        shapes.append(meshed(objects.shapes))
    if not any(shapes[0].meshes()):
        raise UserError("There is no shape to write. Turn a drawing into a solid first.")
    data = write_motion(shapes, [number / options.rate for number in range(len(shapes))])
    make_folder(options.output)
    write_bytes(options.output, data)


def _write_gif(bench: Any, films: Iterator[Any], options: argparse.Namespace) -> None:
    from PIL import Image

    from bozzetto.atomic_files import write_bytes
    from bozzetto.plugin.job import Job
    from bozzetto.scene.snapshot import framed, own_or_framed, picture

    size = picture_size(options.size)
    camera, images = None, []
    for document in films:
        scene = bench.scene(document, Job())
        if camera is None and options.view is None:
            camera = own_or_framed(scene, document.camera, size)
        elif camera is None:
            camera = framed(scene, options.view, size)
        pixels = picture(scene, camera=camera, size=size)
        images.append(
            Image.fromarray(pixels).convert("RGB").quantize(128, dither=Image.Dither.NONE)
        )
    data = io.BytesIO()
    images[0].save(
        data,
        "GIF",
        save_all=True,
        append_images=images[1:],
        duration=max(20, round(1000.0 / options.rate)),
        loop=0,
    )
    make_folder(options.output)
    write_bytes(options.output, data.getvalue())


def add_simulate(commands: Any) -> None:
    """Add the command to the others."""
    command = commands.add_parser("simulate", help="let mechanisms go, and write what they do")
    command.add_argument("document", type=Path)
    command.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        help="a film: .glb with an animation, or .gif; or as it is in the end: .bozz, .step …",
    )
    command.add_argument("--seconds", type=float, default=4.0)
    command.add_argument("--rate", type=float, default=25.0, help="frames a second; default 25")
    command.add_argument("--object", action="append", metavar="NAME", help="only these objects")
    command.add_argument("--view", metavar="NAME", help="of a GIF: front, right, top …")
    command.add_argument("--size", default="600x450", metavar="WxH", help="of a GIF, pixels")
    command.set_defaults(run=simulate)
