"""The command line: build, trace, export, render, info, samples and plugins, without a window.

Bad input ends with exit code 2, one line ``error: …`` that says what to do, and nothing
written; a plugin that fails ends with exit code 1.
"""

from __future__ import annotations

import argparse
import json
import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from bozzetto import __version__
from bozzetto.cli import SWITCHES
from bozzetto.cli.build import build as run_build
from bozzetto.cli.export import export as run_export
from bozzetto.cli.handover import add_handover
from bozzetto.cli.output import (
    EXIT_ERROR,
    EXIT_FAULT,
    complain,
    fault_message,
    make_folder,
    open_document,
    picture_size,
    warn,
    workbench,
    write_output,
)
from bozzetto.cli.placing import add_place, placed
from bozzetto.cli.plugins import ACTIONS
from bozzetto.cli.plugins import plugins as run_plugins
from bozzetto.cli.simulate import add_simulate
from bozzetto.cli.trace import add_trace
from bozzetto.errors import UserError

EXIT_INTERRUPTED = 130
EXIT_UNREAD = 141
"""As of programs that are ended because nobody reads on, such as behind ``| head``."""

VIEW_HELP = "front, right, top, three-quarter …; by default the document's own if all lies in it"


class _Once(argparse.Action):
    """Keeps a value; a second one, which would drop the first without a word, is refused."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: object,
        option_string: str | None = None,
    ) -> None:
        given = namespace.__dict__.setdefault("given", set())
        if option_string is not None and self.dest in given:
            raise argparse.ArgumentError(self, "it is given twice, and can be only once")
        given.add(self.dest)
        setattr(namespace, self.dest, values)


class _Parser(argparse.ArgumentParser):
    """Says its errors the way everything else does, and takes what stands for one value once."""

    def __init__(self, **how: Any) -> None:
        super().__init__(**how)
        self.register("action", None, _Once)

    def error(self, message: str) -> NoReturn:
        command = self.prog
        self.exit(EXIT_ERROR, f"error: {message}. See “{command} --help”.\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : sequence of str, optional
        Default: the arguments of the process.

    Returns
    -------
    int
        0, or 1 for a plugin's fault, 2 for a mistake in the input, 130 for Ctrl+C, 141 if what is
        printed is not read to its end.
    """
    try:
        code = _run(argv)
        if sys.stdout is not None:
            sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        complain("stopped. Nothing was left half-written.")
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        # Else it is tried again at the end of the process, with a traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_UNREAD


def _run(argv: Sequence[str] | None) -> int:
    options = _parser().parse_args(argv)
    from bozzetto.plugin.guard.guard import PluginFault

    logging.basicConfig(level=logging.DEBUG if options.verbose else logging.CRITICAL)
    try:
        code: int = options.run(options)
        return code
    except UserError as problem:
        complain(problem.message)
        return EXIT_ERROR
    except PluginFault as fault:
        complain(fault_message(fault))
        return EXIT_FAULT


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="bozzetto",
        description="Draw, and get 3D. Without a command, the window opens.",
        epilog="bozzetto FILE opens the window with a drawing, a mesh or a .bozz file; bozzetto "
        "--no-plugins with no plugin at all, where one of them closes the program.",
    )
    parser.add_argument("--version", action="version", version=f"bozzetto {__version__}")
    parser.add_argument(*SWITCHES, action="store_true", help="show tracebacks of faults")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    build = commands.add_parser("build", help="turn drawings into shapes")
    build.add_argument("modeler", help="for example: silhouette")
    build.add_argument(
        "inputs",
        nargs="+",
        metavar="INPUT",
        help="ink JSON, SVG, InkML, or a document whose ink is read; for some a picture or a mesh",
    )
    build.add_argument(
        "-o",
        "--output",
        required=True,
        action="append",
        help="a file, again for each format of one input; or a folder for several inputs",
    )
    build.add_argument("--format", help="file ending of the outputs, for a folder")
    build.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="set a parameter; of one part with its name before it: “Part 2.blend=0”",
    )
    build.add_argument(
        "--on",
        metavar="DOC.bozz[:OBJECT]",
        help="draw on an object of a document, or on all that are visible, linked: it follows when "
        "they change; a .bozz output then holds them, too",
    )
    _add_trust(build)
    build.add_argument("--report", type=Path, metavar="R.json", help="write how good it is")
    build.add_argument("--view", metavar="NAME", help=VIEW_HELP)
    build.add_argument(
        "--allow-template",
        action="store_true",
        help="write the bare template where nothing can be made from the input",
    )
    _add_command(build)
    add_handover(build)
    build.set_defaults(run=run_build)

    export = commands.add_parser("export", help="hand a document over to other programs")
    export.add_argument("document", type=Path)
    export.add_argument(
        "-o", "--output", type=Path, required=True, action="append", help="again for each format"
    )
    export.add_argument("--object", action="append", metavar="NAME", help="only these objects")
    export.add_argument("--view", metavar="NAME", help=VIEW_HELP)
    export.add_argument("--report", type=Path, metavar="R.json", help="write what is in the file")
    add_place(export)
    _add_command(export)
    add_handover(export)
    export.set_defaults(run=run_export)

    render = commands.add_parser("render", help="make a picture of a document or a mesh")
    render.add_argument("input", type=Path)
    render.add_argument("-o", "--output", type=Path, required=True)
    render.add_argument("--size", default="1200x900", metavar="WxH", help="pixels")
    render.add_argument("--view", metavar="NAME", help=VIEW_HELP)
    render.add_argument("--theme", choices=("light", "dark"), default="light")
    render.add_argument(
        "--shading",
        choices=("clay", "zebra", "curvature", "normals", "xray", "draft", "thickness"),
        default="clay",
    )
    render.add_argument(
        "--turntable",
        type=int,
        metavar="N",
        help="turn it once around in N pictures: a .gif, an .mp4 (by ffmpeg) or a row of .png",
    )
    render.add_argument("--seconds", type=float, default=4.0, help="of one turn; default 4")
    render.add_argument(
        "--from-sketch",
        action="store_true",
        help="the turntable begins with the sketch, which is drawn and becomes the shapes",
    )
    add_place(render)
    _add_trust(render)
    render.set_defaults(run=_render)

    add_trace(commands)
    add_simulate(commands)

    info = commands.add_parser("info", help="say what a file holds")
    info.add_argument("input", type=Path)
    info.add_argument("--json", action="store_true", help="for other programs")
    _add_trust(info)
    info.set_defaults(run=_info)

    samples = commands.add_parser("samples", help="build the sample drawings of every modeler")
    samples.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")
    samples.set_defaults(run=_samples)

    plugins = commands.add_parser(
        "plugins", help="list the plugins, switch one on or off, check one, or begin a new one"
    )
    plugins.add_argument(
        "action",
        nargs="?",
        choices=ACTIONS,
        default="list",
        help="list: what is installed, and why something cannot be used (so without an action); "
        "check: try one with everything that a plugin is asked, which takes seconds to minutes; "
        "enable, disable: the switches of the window; new: write a package to begin with into "
        "this folder",
    )
    plugins.add_argument(
        "package",
        nargs="?",
        metavar="NAME",
        help="id or package of a plugin; to check, also a file of a plugin's own kind; for a new "
        "one its id, such as author.thing",
    )
    plugins.add_argument(
        "--license", default="MIT", metavar="NAME", help="of a new plugin: MIT or none"
    )
    plugins.set_defaults(run=run_plugins)
    return parser


def _add_command(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--command",
        dest="command_id",
        metavar="ID",
        help="write the file of a modeler's command instead, such as save-template of a car",
    )


def _add_trust(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--trust-file",
        action="store_true",
        help="read the input however much time and memory it takes; only if you know who made it",
    )


# -- documents --


def _render(options: argparse.Namespace) -> int:
    from bozzetto.images.png import write_png
    from bozzetto.scene import DARK, LIGHT
    from bozzetto.workbench.export_document import unusable
    from bozzetto.workbench.turntables import write_turntable

    if options.output.suffix.lower() != ".png" and options.turntable is None:
        raise UserError("A picture is written as PNG. Let its name end in .png.")
    width, height = picture_size(options.size)
    bench = workbench()
    document = placed(_document_of(bench, options.input, options.trust_file), options.place)
    unseen = (unusable(bench, model) for model in document if model.visible)
    warn(problem.sentence("picture") for problem in unseen if problem is not None)
    palette = DARK if options.theme == "dark" else LIGHT
    if options.from_sketch and (options.turntable is None or options.view):
        raise UserError("--from-sketch is for --turntable, and has a view of its own: no --view.")
    if options.turntable is not None:
        make_folder(options.output)
        write_turntable(
            bench, document, options.output, options.turntable, options.seconds,
            view=options.view or "three-quarter", size=(width, height), palette=palette,
            shading=options.shading, from_sketch=options.from_sketch,
        )  # fmt: skip
        return 0
    image, walls = _picture_of(
        bench, document, options.view, (width, height), palette=palette, shading=options.shading
    )
    make_folder(options.output)
    write_png(options.output, image)
    if options.shading == "thickness":
        print(_thinnest_wall(walls))
    return 0


def _thinnest_wall(walls: Any) -> str:
    """Return a line on the thinnest wall of a document, and on the colours of its picture."""
    from bozzetto.scene.thickness_view import THICK, THIN, written_thickness

    if walls is None:
        return "Nothing here is closed, so no wall can be measured."
    place = ", ".join(f"{value:.4g}" for value in walls.place)
    return (
        f"thinnest wall: {written_thickness(walls.thinnest)} at ({place}); colours from "
        f"{written_thickness(THIN)} (red) to {written_thickness(THICK)} (blue)"
    )


def _picture_of(
    bench: Any, document: Any, view: str | None, size: tuple[int, int] = (1200, 900), **style: Any
) -> Any:
    """Return a document as the window shows it, and its walls; `style` as in `scene.picture`.

    Without a name of a view it is the document's own if all lies in it, else the three-quarter
    view.
    """
    from bozzetto.plugin.job import Job
    from bozzetto.scene.snapshot import framed, own_or_framed, picture_and_walls

    scene = bench.scene(document, Job())
    if view is None:
        camera = own_or_framed(scene, document.camera, size)
    else:
        camera = framed(scene, view, size)
    shown = scene.under(bench.advice_scene(document, camera))
    return picture_and_walls(shown, camera=camera, size=size, **style)


def _document_of(bench: Any, path: Path, trusted: bool) -> Any:
    """Return a document, or one made from a mesh file."""
    from bozzetto.document.model import Document
    from bozzetto.exchange.import_file import read_mesh_file

    if path.suffix.lower() == ".bozz":
        return open_document(bench, path)
    mesh = read_mesh_file(path, trusted=trusted)
    warn(mesh.told())
    return Document((bench.sources.from_mesh_file("bozzetto.mesh", mesh, path.stem),))


def _info(options: argparse.Namespace) -> int:
    from bozzetto.cli.file_facts import facts_of

    facts = facts_of(options.input, trusted=options.trust_file)
    if options.json:
        print(json.dumps(facts, indent=2, ensure_ascii=False))
    else:
        for key, value in facts.items():
            shown = value
            if isinstance(value, list) and not any(isinstance(v, dict | str) for v in value):
                shown = " ".join(map(str, value)) or "none"
            elif isinstance(value, list):
                shown = "".join(f"\n  {_line(entry)}" for entry in value) or "none"
            elif isinstance(value, dict):
                shown = _line(value)
            print(f"{key}: {shown}")
    return 0


def _line(entry: Any) -> str:
    if isinstance(entry, dict):
        return ", ".join(f"{key} {value}" for key, value in entry.items())
    return str(entry)


# -- samples --

SAMPLE_FORMATS = ("stl", "3mf", "glb", "step")
"""Exports of a sample, as far as they have a place for what it is."""


def _samples(options: argparse.Namespace) -> int:
    """Build every modeler's sample drawings: a picture, a document and exports of each."""
    from bozzetto.document import edit
    from bozzetto.document.model import Document
    from bozzetto.exchange.export import has_room
    from bozzetto.exchange.import_file import read_drawing
    from bozzetto.images.png import write_png
    from bozzetto.plugin.job import Job

    bench = workbench()
    for info in bench.registry.modelers():
        for sample in info.samples:
            drawing = read_drawing(sample, trusted=True)  # it came with its plugin
            model = bench.sources.from_drawing(info.id, drawing, {})
            document = edit.add_model(Document(), model).document
            shapes = bench.shapes(document, Job())
            stem = options.output / f"{info.id.rpartition('.')[2]}-{drawing.name}"
            targets = [stem.with_name(f"{stem.name}.{ending}") for ending in SAMPLE_FORMATS]
            targets = [target for target in targets if has_room(target, shapes)]
            for target in (*targets, stem.with_name(f"{stem.name}.bozz")):
                write_output(bench, document, target)
                print(f"wrote {target}")
            picture = stem.with_name(f"{stem.name}.png")
            write_png(picture, _picture_of(bench, document, "three-quarter")[0])
            print(f"wrote {picture}")
    print(f"Everything is in {options.output}. To draw, run “bozzetto” where there is a screen.")
    return 0


if __name__ == "__main__":
    sys.exit(main())
