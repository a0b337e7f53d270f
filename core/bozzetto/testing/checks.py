"""The contract, check by check: used by `ModelerContract` and by ``bozzetto plugins check``.

Each check takes a `Subject` and raises where the modeler breaks its contract: `Broken`, or
the `PluginFault` that the guard raised. None needs pytest.
"""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from bozzetto.document.model import Model
from bozzetto.document.storage.state_codec import decode_state, encode_state, state_digest
from bozzetto.errors import Unfinished, UserError
from bozzetto.exchange.mesh.manifold_check import bounds_volume, no_volume_because
from bozzetto.geometry.brep.tessellation import brep_mesh
from bozzetto.geometry.shapes import Shapes
from bozzetto.parameters import Field, parameter_fields
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.guard.watchdog import Watchdog
from bozzetto.plugin.job import Job
from bozzetto.plugin.part_tree import PartTree
from bozzetto.plugin.parts import PartsModeler
from bozzetto.testing.abilities import ABILITIES
from bozzetto.testing.deep_equal import difference, fingerprint, same
from bozzetto.testing.headless_shell import Shell
from bozzetto.testing.job_checks import check_stopping, stop_at
from bozzetto.testing.memory_checks import check_forgetting, check_fresh_process
from bozzetto.testing.motion_checks import check_steps
from bozzetto.testing.spelling import check_spelling
from bozzetto.testing.subject import Broken, Subject, ensure, odd_gestures

PREVIEW_TIME = 20.0
"""Seconds that a preview's solve of one plain drawing may take; it should take some
hundredths, but the machine that runs the tests may be slow."""

CANCELLATIONS = (1, 2, 4)
"""At which question whether anyone still waits the answer becomes no."""


def check_announced(subject: Subject) -> None:
    """Check that the modeler is as its manifest announces, and that its files exist."""
    with subject.shell() as shell:
        info = shell.registry.info(subject.modeler)
        icons = [info.icon] + [info.folder / tool.icon for tool in shell.tools() if tool.icon]
        for path in icons:
            ensure(path.is_file(), f"the file {path.relative_to(info.folder)} is missing")
        for tool in shell.tools():
            ensure(bool(tool.title and tool.hint), f"the tool {tool.id} lacks a title or a hint")
        known = {tool.id for tool in shell.tools()}
        modeler = shell.registry.modeler(subject.modeler)
        for kind in (modeler.state_type, *getattr(modeler, "part_types", ())):
            for field in parameter_fields(kind):
                for name in field.parameter.tools:
                    ensure(
                        name in known,
                        f"{kind.__name__}.{field.name}: tools names {name!r}, and there is no tool "
                        "of that id: no form would ever show it",
                    )


def check_empty(subject: Subject) -> None:
    """Check that an empty state can be stored, solved, shown and exported."""
    with subject.shell() as shell:
        bench = shell.workbench
        bench.model_scene(shell.model, None)
        for quality in ("preview", "final"):
            result = bench.solve(shell.model, _job(quality))
            bench.model_scene(shell.model, result)
        ensure(not shell.shapes(), "an empty state must hand over nothing")


def check_drawing(subject: Subject) -> None:
    """Check that a drawing can be solved in both qualities, shown and exported."""
    with subject.drawn() as shell:
        bench = shell.workbench
        bench.model_scene(shell.model, None)
        for quality in ("preview", "final"):
            bench.model_scene(shell.model, bench.solve(shell.model, _job(quality)))
        bench.report(shell.model, Job())
        with subject.shell() as untouched:
            drawn = not same(shell.state, untouched.state)
        shapes = shell.shapes()
        if drawn and not shapes:
            told = bench.cautions(shell.model, Job())
            ensure(bool(told), "a drawing must hand something over, or its cautions say why not")
        _check_solids(shapes)


def _check_solids(shapes: Shapes) -> None:
    for solid in shapes.solids:
        why = no_volume_because(solid.mesh)
        ensure(
            not why,
            f"the solid {solid.name!r} is {why}; no program would take it: hand over a closed "
            "mesh, or a Surface",
        )
    for brep in shapes.breps:
        ensure(
            not brep.is_closed or bounds_volume(brep_mesh(brep)),
            f"the closed brep {brep.name!r} is inside out or flat; turn it over",
        )


def check_samples(subject: Subject) -> None:
    """Check that every sample drawing becomes a shape that can be shown."""
    from bozzetto.exchange.import_file import read_drawing

    with subject.shell() as shell:
        bench = shell.workbench
        for path in shell.registry.info(subject.modeler).samples:
            try:
                model = bench.sources.from_drawing(
                    subject.modeler, read_drawing(path, trusted=True), {}
                )
                bench.model_scene(model, bench.solve(model, _job("preview")))
            except UserError as problem:
                raise Broken(f"{path.name}: {problem.message}") from problem


def check_storage(subject: Subject) -> None:
    """Check that a state comes back from a file as it was, and gives the same shapes."""
    with subject.drawn() as shell:
        shapes = shell.shapes()
        _check_reopened(shell)
        ensure(same(shell.shapes(), shapes), "a saved state gives other shapes when it is reopened")
        for field in parameter_fields(type(shell.state)):
            others = [value for value in _allowed(field) if value != field.default]
            if others:
                with suppress(UserError):  # what may be refused is for `check_parameters`
                    shell.set(**{field.name: others[0]})
        _check_reopened(shell)


def _check_reopened(shell: Shell) -> None:
    before = shell.state
    shell.reopen()
    ensure(state_digest(shell.state) == state_digest(before), "a saved state comes back another")
    found = difference(before, shell.state, "state")
    ensure(not found, f"a saved state comes back with other types or values ({found})")
    try:
        bool(shell.state == before)
    except ValueError:
        raise Broken(
            "two states cannot be compared: a dataclass that holds an array needs "
            "@dataclass(frozen=True, eq=False)"
        ) from None


def check_history(subject: Subject) -> None:
    """Undo and redo go back and forth between states that did not change meanwhile."""
    with subject.drawn() as shell:
        after, digest = shell.state, state_digest(shell.state)
        shell.solve()
        while shell.document.models and not _is_empty(subject, shell):
            ensure(shell.undo(), "undo does not lead back to the empty model")
        while shell.redo():
            pass
        ensure(shell.state is after, "redo does not lead to the same state")
        ensure(state_digest(after) == digest, "a state changed after it was made")


def _is_empty(subject: Subject, shell: Shell) -> bool:
    with subject.shell() as fresh:
        return same(fresh.state, shell.state)


def check_cancelling(subject: Subject) -> None:
    """Check that a cancelled solve ends with `Cancelled` and leaves nothing behind."""
    for seed, question in enumerate(CANCELLATIONS, 1):
        # Every time another drawing: a modeler may remember what it solved.
        with subject.drawn(seed) as shell:
            stop_at(question, "solve", partial(shell.workbench.solve, shell.model))
            after = shell.shapes()
            with subject.drawn(seed) as other:
                ensure(same(other.shapes(), after), "a cancelled solve changed the next one")


def check_odd_previews(subject: Subject) -> None:
    """Check that a preview copes with every gesture of its kind, on an empty and a drawn model."""

    def look(shell: Shell, tool: Any, gesture: Any) -> None:
        shell.preview(gesture, tool=tool)

    _with_odd_gestures(subject, look)


def check_odd_gestures(subject: Subject) -> None:
    """Check that `apply` refuses in plain words what it cannot use; what it takes can be solved."""

    def use(shell: Shell, tool: Any, gesture: Any) -> None:
        try:
            model = shell.workbench.apply(shell.model, tool, gesture, shell.context())
            shell.workbench.solve(model, _job("preview"))
        except UserError as problem:
            ensure(bool(problem.message.strip()), "a UserError needs words")
        except Unfinished as problem:
            ensure(bool(problem.hint.strip()), "Unfinished needs a hint")
            ensure(not getattr(gesture, "committed", True), "Unfinished, but the ink is committed")

    _with_odd_gestures(subject, use)


def _with_odd_gestures(subject: Subject, act: Callable[[Shell, Any, Any], None]) -> None:
    for opened in (subject.shell, subject.drawn):
        with opened() as shell:
            for tool in shell.tools():
                for name, gesture in odd_gestures(shell, tool):
                    try:
                        act(shell, tool, gesture)
                    except (Broken, PluginFault, UserError, Unfinished) as problem:
                        raise Broken(f"tool {tool.id}, {name}: {problem}") from problem


def check_determinism(subject: Subject) -> None:
    """Check that equal states give equal shapes and scenes, in whatever thread they are solved."""
    with subject.drawn() as shell:
        state_type = type(shell.state)
        shapes, scene = shell.shapes(), shell.scene()
        copied = decode_state(state_type, encode_state(shell.state))
    with subject.shell() as other:
        other.put(copied)
        found: list[Any] = []

        def work() -> None:
            try:
                found.extend((other.shapes(), other.scene()))
            except Exception as problem:
                found.append(problem)

        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
        if isinstance(found[-1], Exception):
            raise found[-1]
        ensure(same(found[0], shapes), "the same state gave other shapes the second time")
        owners = {layer.owner for layer in (*scene.layers, *found[1].layers)}
        ensure(len(owners) <= 2, "the layers of a scene belong to several owners")
        ensure(same(found[1].owned(""), scene.owned("")), "the same state gave another scene")


def check_parameters(subject: Subject) -> None:
    """Check that every number can be solved at the ends of its range, and at its default."""
    with subject.drawn() as shell:
        start = shell.model
        for field in _all_parameters(shell):
            _check_default(field)
            for value in _allowed(field):
                try:
                    model = shell.workbench.set_parameters(start, {field.name: value})
                    result = shell.workbench.solve(model, _job("preview"))
                    shell.workbench.model_scene(model, result)
                except (UserError, PluginFault) as problem:
                    refused = isinstance(problem, UserError) and bool(problem.message.strip())
                    if refused and field.kind in ("choice", "text") and value != field.default:
                        continue  # a choice, or a text, need not make sense for every drawing
                    raise Broken(f"{field.name} = {value!r}: {problem}") from problem


def check_ranges(subject: Subject) -> None:
    """Check that solids are sound at both ends of every number's range, and with every choice."""
    with subject.drawn() as shell:
        start = shell.model
        for field in _all_parameters(shell):
            for value in _allowed(field):
                try:
                    model = shell.workbench.set_parameters(start, {field.name: value})
                    shapes = shell.workbench.shapes([model], Job())
                except UserError:
                    continue  # what may be refused, and how, is for `check_parameters`
                try:
                    _check_solids(shapes)
                except Broken as problem:
                    raise Broken(f"{field.name} = {value!r}: {problem}") from None


def _all_parameters(shell: Shell) -> tuple[Field, ...]:
    """Return the parameters of the state, and those of its parts."""
    tree = shell.workbench.parts.of(shell.model)
    parts = () if tree is None else tree.parts
    kinds = dict.fromkeys([type(shell.state), *map(type, parts)])
    return tuple(field for kind in kinds for field in parameter_fields(kind))


def _check_default(field: Field) -> None:
    try:
        same_again = field.check(field.default)
    except UserError as problem:
        raise Broken(f"the default of {field.name} is not allowed: {problem.message}") from None
    ensure(same_again == field.default, f"the default of {field.name} is of another kind")
    low, high = field.parameter.minimum, field.parameter.maximum
    ensure(low is None or high is None or low < high, f"the range of {field.name} is empty")
    ensure(bool(field.parameter.label), f"{field.name} needs a label")


def _allowed(field: Field) -> list[object]:
    """Return the ends of a parameter's range and its default, or all its values."""
    if field.kind == "switch":
        return [False, True]
    if field.kind == "choice":
        return list(field.values)
    if field.kind == "color":
        return [None, (0, 128, 255)]
    if field.kind == "text":
        return ["", "Ähre 木 \N{GRINNING FACE}", field.default]
    ends = (field.parameter.minimum, field.parameter.maximum)
    return [value for value in ends if value is not None] + [field.default]


def check_parts(subject: Subject) -> None:
    """Check that parts can be put back as they were read, and edited as the object list does."""
    with subject.drawn() as shell:
        modeler = shell.registry.modeler(subject.modeler)
        edits, model = shell.workbench.parts, shell.model
        if not isinstance(modeler, PartsModeler):
            return
        tree = edits.of(model)
        if tree is None or not tree.parts:
            raise Broken("a drawing must be made of parts")
        for part in tree.parts:
            ensure(
                isinstance(part, modeler.part_types),
                f"{type(part).__name__} is not among its part_types",
            )
        back = modeler.with_parts(model.state, tree.parts, tree.selected)
        ensure(same(back, model.state), "parts put back as they were read give another state")
        first = tree.parts[0].id
        edited = edits.rename(model, first, "Another name").model
        _check_kept(edits.of(edited), tree.renamed(first, "Another name"))
        edited = edits.show(edited, first, False).model
        edited = edits.duplicate(edits.show(edited, first, True).model, first).model
        _check_kept(edits.of(edits.select(edited, "")), tree.renamed(first, "Another name")
                    .doubled(first).chosen(""))  # fmt: skip
        if modeler.new_group(model.state) is not None:
            edited = edits.group(edited, [part.id for part in tree.parts]).model
        _solve_or_refuse(shell, edited)
        while (left := edits.of(edited)) is not None and left.parts:
            edited = edits.delete(edited, left.parts[0].id).model
        _solve_or_refuse(shell, edited)


def _check_kept(tree: PartTree | None, wanted: PartTree) -> None:
    ensure(same(tree, wanted), "with_parts changes the parts that it is given")


def _solve_or_refuse(shell: Shell, model: Model) -> None:
    try:
        shell.workbench.model_scene(model, shell.workbench.solve(model, _job("preview")))
    except UserError as problem:
        ensure(bool(problem.message.strip()), "a UserError needs words")


def check_preview_time(subject: Subject) -> None:
    """Check that a solve in preview quality answers in time."""
    with subject.drawn() as shell:
        watchdog = Watchdog(shell.registry.guard, PREVIEW_TIME)
        modeler = shell.registry.modeler(subject.modeler)
        watchdog.call(subject.modeler, "solve", modeler.solve, shell.state, _job("preview"))


_ELSEWHERE = """
import sys
from bozzetto.document.storage.bozz_file import read_document
from bozzetto.plugin import Context, Job
from bozzetto.plugin.host.registry import Registry
from bozzetto.testing.memory_checks import check_forgetting
from bozzetto.testing.deep_equal import fingerprint
from bozzetto.workbench.workbench import Workbench
bench = Workbench(Registry(extra=sys.argv[3:]))
bench.create(sys.argv[1], Context())
document, _ = read_document(sys.argv[2], bench.registry)
bench.scene(document, Job())
print(fingerprint(bench.shapes(document, Job())))
print(*sorted({name.partition(".")[0] for name in sys.modules}
              & {"PySide6", "PyQt5", "PyQt6", "bozzetto_app", "pyqtgraph"}))
"""


def check_elsewhere(subject: Subject) -> None:
    """Check that a document gives the same shapes in another process, and without Qt."""
    with subject.drawn() as shell:
        path = shell.save()
        done = subprocess.run(
            [sys.executable, "-c", _ELSEWHERE, subject.modeler, path, *subject.packages],
            capture_output=True,
            text=True,
            env=_environment(),
            check=False,
        )
        told = (done.stderr.strip().splitlines() or [""])[-1].rpartition("PluginFault: ")[2]
        ensure(done.returncode == 0, f"it does not work in a process of its own: {told}")
        shapes, windows = done.stdout.split("\n")[-3:-1]
        ensure(shapes == fingerprint(shell.shapes()), "another process gives other shapes")
        ensure(not windows, f"it imports {windows}")


def _environment() -> dict[str, str]:
    """Return our environment, with our import path."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}


def _job(quality: str) -> Job:
    return Job(quality="preview" if quality == "preview" else "final")


@dataclass(frozen=True)
class Check:
    """One article of the contract.

    Attributes
    ----------
    name : str
    run : callable
    is_slow : bool
        Whether it takes many seconds: as a test it bears the mark "slow".
    """

    name: str
    run: Callable[[Subject], None]
    is_slow: bool = False

    @property
    def says(self) -> str:
        """The article in words."""
        return (self.run.__doc__ or "").strip()


SLOW: Final = (
    check_odd_previews,
    check_odd_gestures,
    check_ranges,
    check_forgetting,
    check_fresh_process,
)
"""Articles that take many seconds where a solve takes one."""

CHECKS: Final = tuple(
    Check(run.__name__.removeprefix("check_"), run, run in SLOW)
    for run in (
        check_announced,
        check_spelling,
        check_empty,
        check_drawing,
        check_samples,
        check_storage,
        check_history,
        check_cancelling,
        check_stopping,
        check_odd_previews,
        check_odd_gestures,
        check_determinism,
        check_parameters,
        check_ranges,
        check_parts,
        *ABILITIES,
        check_steps,
        check_forgetting,
        check_fresh_process,
        check_preview_time,
        check_elsewhere,
    )
)
"""All articles, quick ones first."""
