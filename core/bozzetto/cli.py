"""The command line: build, export, render, info, samples and plugins, without a window.

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
from bozzetto.errors import UserError

__all__ = ["COMMANDS", "SWITCHES", "main"]

COMMANDS = ("build", "export", "render", "info", "samples", "plugins")
"""Words after which no window opens."""

SWITCHES = ("-v", "--verbose")
"""Words that may stand before a command."""

EXIT_FAULT = 1
EXIT_ERROR = 2
EXIT_INTERRUPTED = 130

MAX_PLACES = 3
"""Places of a mistake that an error line names."""


class _Parser(argparse.ArgumentParser):
    """Says its errors the way everything else does."""

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
        0, or 1 for a plugin's fault, 2 for a mistake in the input, 130 for Ctrl+C.
    """
    try:
        return _run(argv)
    except KeyboardInterrupt:
        _complain("stopped. Nothing was left half-written.")
        return EXIT_INTERRUPTED


def _run(argv: Sequence[str] | None) -> int:
    options = _parser().parse_args(argv)
    from bozzetto.plugin.guard import PluginFault

    logging.basicConfig(level=logging.DEBUG if options.verbose else logging.CRITICAL)
    try:
        code: int = options.run(options)
        return code
    except UserError as problem:
        _complain(problem.message)
        return EXIT_ERROR
    except PluginFault as fault:
        _complain(_words_of_fault(fault))
        return EXIT_FAULT


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="bozzetto", description="Draw, and get 3D. Without a command, the window opens."
    )
    parser.add_argument("--version", action="version", version=f"bozzetto {__version__}")
    parser.add_argument(*SWITCHES, action="store_true", help="show tracebacks of faults")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    build = commands.add_parser("build", help="turn drawings into shapes")
    build.add_argument("modeler", help="for example: silhouette")
    build.add_argument("inputs", nargs="+", metavar="INPUT", help="ink JSON, SVG or InkML")
    build.add_argument("-o", "--output", required=True, help="a file, or a folder for several")
    build.add_argument("--format", help="file ending of the outputs, for a folder")
    build.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="set a parameter"
    )
    build.add_argument("--report", type=Path, metavar="R.json", help="write how good it is")
    build.set_defaults(run=_build)

    export = commands.add_parser("export", help="hand a document over to other programs")
    export.add_argument("document", type=Path)
    export.add_argument("-o", "--output", type=Path, required=True)
    export.add_argument("--object", action="append", metavar="NAME", help="only these objects")
    export.set_defaults(run=_export)

    render = commands.add_parser("render", help="make a picture of a document or a mesh")
    render.add_argument("input", type=Path)
    render.add_argument("-o", "--output", type=Path, required=True)
    render.add_argument("--size", default="1200x900", metavar="WxH", help="pixels")
    render.add_argument("--view", default="three-quarter", help="front, right, top …")
    render.add_argument("--theme", choices=("light", "dark"), default="light")
    render.add_argument(
        "--shading",
        choices=("clay", "zebra", "curvature", "normals", "xray"),
        default="clay",
    )
    render.set_defaults(run=_render)

    info = commands.add_parser("info", help="say what a file holds")
    info.add_argument("input", type=Path)
    info.add_argument("--json", action="store_true", help="for other programs")
    info.set_defaults(run=_info)

    samples = commands.add_parser("samples", help="build the sample drawings of every modeler")
    samples.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")
    samples.set_defaults(run=_samples)

    plugins = commands.add_parser("plugins", help="list the plugins, or check one")
    plugins.add_argument("action", nargs="?", choices=("list", "check"), default="list")
    plugins.add_argument("package", nargs="?", help="import name of the package to check")
    plugins.set_defaults(run=_plugins)
    return parser


def _complain(message: str) -> None:
    print(f"error: {' '.join(message.split())}", file=sys.stderr)


def _words_of_fault(fault: Exception) -> str:
    return f"{fault} Its author can find the place with “bozzetto -v …”."


def _workbench() -> Any:
    from bozzetto.plugin.registry import Registry
    from bozzetto.workbench import Workbench

    return Workbench(Registry())


# -- build --


def _build(options: argparse.Namespace) -> int:
    from bozzetto.exchange.formats import find, writers
    from bozzetto.plugin.guard import PluginFault

    bench = _workbench()
    modeler_id = bench.registry.resolve(options.modeler)
    values = _settings(bench.registry.modeler(modeler_id), options.set)
    inputs = [Path(name) for name in options.inputs]
    targets = _targets(inputs, options.output, options.format)
    for target in targets:
        if target.suffix.lower() != ".bozz":
            find(target, writers("mesh", "curves"))
    _keep_apart(inputs, targets, options.report)
    reports: list[dict[str, Any]] = []
    code = 0
    for number, (source, target) in enumerate(zip(inputs, targets, strict=True), 1):
        if len(inputs) > 1:
            print(f"[{number}/{len(inputs)}] {source.name} → {target}", file=sys.stderr)
        try:
            report = _build_one(bench, modeler_id, source, target, values, bool(options.report))
        except (UserError, PluginFault) as problem:
            if len(inputs) == 1:
                raise
            fault = isinstance(problem, PluginFault)
            words = _words_of_fault(problem) if fault else str(problem)
            _complain(f"{source.name}: {words}")
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
) -> dict[str, Any]:
    from bozzetto.document.model import Document
    from bozzetto.exchange.importing import read_drawing
    from bozzetto.plugin.job import Job

    drawing = read_drawing(source)
    try:
        model = bench.from_drawing(modeler_id, drawing, values)
        report: dict[str, Any] = bench.report(model, Job()) if wants_report else {}
        _hand_over(bench, Document((model,), camera=drawing.camera), target)
    except UserError as problem:
        raise UserError(problem.message + _places(problem, drawing)) from problem
    return report


def _places(problem: UserError, drawing: Any) -> str:
    """Where a mistake lies, in the coordinates of the drawing's file: nothing lights up here."""
    if not problem.places:
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
    from bozzetto.plugin.parameters import parameter_fields, parse_parameter

    fields = {field.name: field for field in parameter_fields(modeler.state_type)}
    values: dict[str, object] = {}
    for assignment in assignments:
        name, sign, text = assignment.partition("=")
        if not sign:
            raise UserError(f"--set takes NAME=VALUE, not {assignment!r}.")
        if name not in fields:
            known = ", ".join(fields) or "none"
            raise UserError(f"There is no parameter {name!r}; {modeler.title} has: {known}.")
        values[name] = parse_parameter(fields[name], text)
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


def _keep_apart(inputs: Sequence[Path], targets: Sequence[Path], report: Path | None) -> None:
    """Refuse to write one file over another of the same command."""
    read = {os.path.realpath(path) for path in inputs}
    written = [os.path.realpath(path) for path in (*targets, *([report] if report else []))]
    if read.intersection(written):
        raise UserError("An output would replace an input. Choose another name or folder for it.")
    if len(set(written)) < len(written):
        raise UserError("The report would replace an output. Give it a name of its own.")
    if report is not None and report.is_dir():
        raise UserError(f"{report} is a folder. The report needs a file name.")


def _hand_over(bench: Any, document: Any, target: Path, names: Sequence[str] | None = None) -> None:
    """Write a document's shapes, or the document itself."""
    from bozzetto.plugin.job import Job

    models = [model for model in document if names is None or model.name in names]
    missing = set(names or ()) - {model.name for model in models}
    if missing:
        known = ", ".join(model.name for model in document)
        raise UserError(f"There is no object {', '.join(sorted(missing))}; there are: {known}.")
    if target.suffix.lower() == ".bozz":
        if names is not None:
            raise UserError("A document keeps all its objects. Leave --object out.")
        from bozzetto.document.file import write_document

        _make_folder(target)
        write_document(document, target)
        return
    from bozzetto.exchange.export import encoded
    from bozzetto.storage import write_bytes

    data = encoded(bench.shapes(models, Job()), target, camera=document.camera)
    _make_folder(target)
    write_bytes(target, data)


def _make_folder(target: Path) -> None:
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise UserError(
            f"The folder {target.parent} cannot be made: {problem.strerror}. Choose another."
        ) from None


def _write_text(path: Path, text: str) -> None:
    from bozzetto.storage import write_bytes

    _make_folder(path)
    write_bytes(path, text.encode())


# -- documents --


def _open_document(bench: Any, path: Path) -> Any:
    from bozzetto.document.file import read_document

    document, report = read_document(path, bench.registry)
    for warning in report.warnings:
        print(f"note: {warning}", file=sys.stderr)
    return document


def _export(options: argparse.Namespace) -> int:
    _keep_apart([options.document], [options.output], None)
    bench = _workbench()
    _hand_over(bench, _open_document(bench, options.document), options.output, options.object)
    return 0


def _render(options: argparse.Namespace) -> int:
    from bozzetto.plugin.job import Job
    from bozzetto.scene import DARK, LIGHT
    from bozzetto.scene.picture import picture
    from bozzetto.scene.png import write_png

    if options.output.suffix.lower() != ".png":
        raise UserError("A picture is written as PNG. Let its name end in .png.")
    width, height = _size(options.size)
    bench = _workbench()
    document = _document_of(bench, options.input)
    image = picture(
        bench.scene(document, Job()),
        view=options.view,
        palette=DARK if options.theme == "dark" else LIGHT,
        size=(width, height),
        shading=options.shading,
    )
    _make_folder(options.output)
    write_png(options.output, image)
    return 0


def _document_of(bench: Any, path: Path) -> Any:
    """A document, or one made from a mesh file."""
    from bozzetto.document.model import Document
    from bozzetto.exchange.importing import read_mesh

    if path.suffix.lower() == ".bozz":
        return _open_document(bench, path)
    return Document((bench.from_shapes("bozzetto.mesh", read_mesh(path), path.stem),))


def _size(text: str) -> tuple[int, int]:
    try:
        width, height = (int(part) for part in text.lower().replace("×", "x").split("x"))
    except ValueError:
        raise UserError(
            f"A size is WIDTHxHEIGHT in pixels, such as 1200x900; not {text!r}."
        ) from None
    return width, height


def _info(options: argparse.Namespace) -> int:
    from bozzetto.exchange.facts import facts_of

    facts = facts_of(options.input)
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


# -- samples and plugins --

SAMPLE_FORMATS = ("stl", "3mf", "glb", "bozz", "png")


def _samples(options: argparse.Namespace) -> int:
    """Build every modeler's sample drawings: a picture and exports of each."""
    from bozzetto.document.model import Document
    from bozzetto.exchange.importing import read_drawing
    from bozzetto.plugin.job import Job
    from bozzetto.scene.picture import picture
    from bozzetto.scene.png import write_png

    bench = _workbench()
    for info in bench.registry.modelers():
        for sample in info.samples:
            drawing = read_drawing(sample)
            document = Document((bench.from_drawing(info.id, drawing, {}),))
            stem = options.output / f"{info.id.rpartition('.')[2]}-{drawing.name}"
            for ending in SAMPLE_FORMATS:
                target = stem.with_name(f"{stem.name}.{ending}")
                if ending == "png":
                    _make_folder(target)
                    write_png(target, picture(bench.scene(document, Job())))
                else:
                    _hand_over(bench, document, target)
                print(f"wrote {target}")
    print(f"Everything is in {options.output}. To draw, run “bozzetto” where there is a screen.")
    return 0


def _plugins(options: argparse.Namespace) -> int:
    if options.action == "check":
        if options.package is None:
            raise UserError("Say which package to check: bozzetto plugins check NAME.")
        from bozzetto.plugin.check import check_package

        findings = check_package(options.package)
        for finding in findings:
            print(finding)
        if not findings:
            print(f"{options.package}: manifest, icons, import and contract are in order.")
        return EXIT_ERROR if any(finding.serious for finding in findings) else 0
    from bozzetto.plugin.registry import Registry

    for plugin in Registry().plugins():
        print(f"{plugin.id}  {plugin.version}  {plugin.status}  {plugin.summary}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
