"""Checks of optional abilities of modelers.

Commands, view advice, curves, shapes and pictures taken, taps that are aimed: each check passes
where the modeler does not do it; see `checks` for the others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from difflib import get_close_matches
from typing import Any, Final

import numpy as np

from bozzetto.document.storage.state_codec import state_digest
from bozzetto.errors import Unfinished, UserError
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.shapes import Curve, Shapes, Skeleton, Solid
from bozzetto.images.stored_picture import Picture
from bozzetto.plugin.context import Context
from bozzetto.plugin.figures import UNITS, figure_of, without_unit
from bozzetto.plugin.gesture import Ink, Tap
from bozzetto.plugin.guard.guard import PluginFault
from bozzetto.plugin.guard.guarded_modeler import GuardedModeler
from bozzetto.plugin.job import Job
from bozzetto.plugin.view_advice import ViewAdvice
from bozzetto.testing.deep_equal import same
from bozzetto.testing.headless_shell import Shell
from bozzetto.testing.subject import Broken, Subject, ensure, odd_cameras, plain_drawings
from bozzetto.testing.synthetic_pen import Pen
from bozzetto.view.camera import Camera
from bozzetto.view.navigation import pan, zoom

WORSE: Final = {"good": 0, "warn": 1, "refuse": 2}
"""The levels of advice, best first."""

ALIKE: Final = 0.8
"""How alike two keys are of which one is taken for a misspelling of the other; 1 is the same."""

PREVIEW: Final = Job(quality="preview")


def check_commands(subject: Subject) -> None:
    """Check that commands run or refuse in plain words; what they make can be stored and solved."""
    for opened in (subject.shell, subject.drawn):
        with opened() as shell:
            commands = shell.workbench.commands
            for command in shell.commands():
                ensure(bool(command.help.strip()), f"the command {command.id} needs a help")
                if not commands.can_run(shell.model, command):
                    continue
                digest = state_digest(shell.state)
                try:
                    if command.writes:
                        one, other = (
                            commands.content(shell.model, command, shell.context(), "file")
                            for _ in range(2)
                        )
                        ensure(one == other, f"{command.id} differs the second time")
                        ensure(
                            state_digest(shell.state) == digest,
                            f"{command.id} changed its argument",
                        )
                        continue
                    made = commands.run(shell.model, command, shell.context())
                    again = commands.run(shell.model, command, shell.context())
                    ensure(same(made.state, again.state), f"{command.id} differs the second time")
                    shell.workbench.solve(made, PREVIEW)
                except UserError as problem:
                    ensure(bool(problem.message.strip()), "a UserError needs words")
                except PluginFault as problem:
                    raise Broken(f"the command {command.id}: {problem}") from problem
                ensure(state_digest(shell.state) == digest, f"{command.id} changed its argument")


def check_view_advice(subject: Subject) -> None:
    """Check advice on every view: better is not worse, and pinned views stay pinned."""
    for opened in (subject.shell, subject.drawn):
        with opened() as shell:
            for camera in odd_cameras():
                advice = _advice(shell, camera)
                is_fine = advice.level == "good" and advice.better is None
                ensure(
                    is_fine or bool(advice.message.strip()),
                    "view advice needs a message where the view is not good, or not the best",
                )
                if advice.better is not None:
                    better = _advice(shell, advice.better)
                    ensure(
                        WORSE[better.level] <= WORSE[advice.level],
                        f"the view that is called better is {better.level!r}, not {advice.level!r}",
                    )
                    _check_pinned(shell, advice.better, better)
                _check_pinned(shell, camera, advice)


def _check_pinned(shell: Shell, camera: Camera, advice: ViewAdvice) -> None:
    if advice.pinned:
        for moved in (
            pan(camera, 40.0, -30.0, eye_fixed=True),
            zoom(camera, 2.0, eye_fixed=True),
        ):
            ensure(
                _advice(shell, moved).pinned,
                "a view that is pinned must stay so while it is moved and zoomed about its eye",
            )


def _advice(shell: Shell, camera: Camera) -> ViewAdvice:
    try:
        advice = shell.advice(camera)
    except UserError as problem:
        raise Broken(f"view_advice raised UserError ({problem}); say it in the advice") from problem
    return ViewAdvice("good", "") if advice is None else advice


def check_next_step(subject: Subject) -> None:
    """Check that every tool says what to do next, with an empty and a drawn state."""
    for opened in (subject.shell, subject.drawn):
        with opened() as shell:
            for tool in shell.tools():
                step = shell.workbench.next_step(shell.model, tool)
                ensure(bool(step.sentence.strip()), f"the next step with {tool.id} needs words")
                known = {"", *(other.id for other in shell.tools())}
                ensure(step.tool in known, f"the next step names {step.tool!r}, which is no tool")


def check_curves(subject: Subject) -> None:
    """Check that curves offered are sound, in both qualities; an empty state offers none."""
    with subject.shell() as shell:
        shell.workbench.curves.learn(shell.model, shell.solve())
        ensure(not shell.context().curves, "an empty state must offer no curves")
    with subject.drawn() as shell:
        for job in (PREVIEW, Job()):
            shell.workbench.curves.learn(shell.model, shell.solve(job))


def check_read_shapes(subject: Subject) -> None:
    """Check that shapes of any kind are taken, or refused in plain words."""
    with subject.shell() as shell:
        able = "read_shapes" in shell.registry.info(subject.modeler).abilities
        for shapes in _given() if able else ():
            try:
                model = shell.workbench.sources.from_shapes(subject.modeler, shapes, "Given")
                shell.workbench.solve(model, PREVIEW)
            except UserError as problem:
                ensure(bool(problem.message.strip()), "a UserError needs words")


def check_follow(subject: Subject) -> None:
    """Check that models are followed by their ids alone, solved twice the same, and exchanged."""
    with subject.shell() as shell:
        registry = shell.registry
        if "follow" not in registry.info(subject.modeler).abilities:
            return
        guarded = registry.guarded(subject.modeler)
        for shapes in _given():
            try:
                state = guarded.follow({"one": shapes, "other": shapes})
            except UserError as problem:
                ensure(bool(problem.message.strip()), "a UserError needs words")
                continue
            except PluginFault as problem:
                raise Broken(f"follow: {problem}") from problem
            digest = state_digest(state)
            for each in (state, *_drawn_on(guarded, state, shapes)):
                _check_followed(guarded, each, shapes)
            ensure(state_digest(state) == digest, "to be solved changed the state")


def _check_followed(guarded: GuardedModeler, state: Any, shapes: Shapes) -> None:
    """Check that a state is solved twice the same, and whatever the ids of its sources are."""
    sources = guarded.sources(state)
    ensure(bool(sources), "a state that follows names its sources")
    turned = guarded.with_sources(state, tuple(f"new_{each}" for each in sources))
    back = guarded.with_sources(turned, sources)
    ensure(same(back, state), "with_sources there and back gives another state")
    for quality in ("preview", "final"):
        given = Job(quality=quality, sources=dict.fromkeys(sources, shapes))
        made = [_shapes_made(guarded, state, given) for _ in range(2)]
        ensure(same(*made), "a follower has other shapes the second time")
        exchanged = replace(given, sources=dict.fromkeys(guarded.sources(turned), shapes))
        made[1] = _shapes_made(guarded, turned, exchanged)
        ensure(same(*made), "the ids of sources change the shape")


def _drawn_on(guarded: GuardedModeler, state: Any, shapes: Shapes) -> Iterator[Any]:
    """Yield the state with the first plain drawing that one of its tools takes.

    Where a model is made of sources and ink, this is the first one with a shape.
    """
    context = Context(sources=dict.fromkeys(guarded.sources(state), shapes))
    for tool in guarded.tools():
        if tool.gesture != "ink":
            continue
        for strokes in plain_drawings(Pen()):
            try:
                made = guarded.apply(tool, state, Ink(strokes, committed=True), context)
            except (UserError, Unfinished):
                continue
            if guarded.sources(made):  # a tool may choose others, and there are none here
                yield made
            return


def _shapes_made(guarded: GuardedModeler, state: object, job: Job) -> Shapes | str:
    """Return the shapes of a state, or why it has none."""
    try:
        result = guarded.solve(state, job)
        guarded.scene(state, None)
        guarded.scene(state, result)
        return guarded.shapes(state, result)
    except UserError as problem:
        return problem.message


def check_pictures(subject: Subject) -> None:
    """Check that pictures of any kind are taken and stored, or refused in plain words."""
    for opened in (subject.shell, subject.drawn):
        with opened() as shell:
            if not shell.workbench.sources.takes_pictures(subject.modeler):
                return
            for picture in _pictures():
                digest = state_digest(shell.state)
                before = shell.state
                try:
                    shell.place(picture)
                    shell.workbench.model_scene(shell.model, shell.solve(PREVIEW))
                except UserError as problem:
                    ensure(bool(problem.message.strip()), "a UserError needs words")
                ensure(state_digest(before) == digest, "add_picture changed its argument")
            digest = state_digest(shell.state)
            shell.reopen()
            ensure(state_digest(shell.state) == digest, "a state with pictures comes back another")


def _pictures() -> tuple[Picture, ...]:
    """Return a sketch, a single pixel, a strip, and a picture that is wholly transparent."""
    paper = np.full((120, 160, 4), 240, np.uint8)
    paper[..., 3] = 255
    paper[40:80, 30:130, :3] = 60
    return (
        Picture.of(paper, "sketch"),
        Picture.of(paper[:1, :1], "one pixel"),
        Picture.of(np.repeat(paper[:2], 8, axis=1), "strip"),
        Picture.of(np.zeros((9, 9, 4), np.uint8), "nothing"),
    )


def check_figures(subject: Subject) -> None:
    """Check that what `figures` says of a report's values fits what a drawing reports."""
    with subject.drawn() as shell:
        figures = shell.workbench.figures(shell.model)
        told = tuple(_told(shell.workbench.report(shell.model, Job())))
        for key, value in told:
            figure = figure_of(key, figures)
            if figure is None:
                continue
            if figure.values or figure.verdicts:
                known = value in {*figure.values, *figure.verdicts}
                ensure(
                    known or not isinstance(value, str),
                    f"the report says {key} is {value!r}, of which its Figure says nothing",
                )
            if figure.spread:
                entries = [*value.values()] if isinstance(value, dict) else value
                ensure(
                    not isinstance(entries, list)
                    or all(isinstance(entry, int | float) for entry in entries),
                    f"{key} is to be summed up (Figure.spread), and is no list of numbers",
                )
        unsaid = {without_unit(key)[0] for key, _ in told if figure_of(key, figures) is None}
        used = {key for told_key, _ in told for key in (told_key, without_unit(told_key)[0])}
        for key in figures.keys() - used:
            ends = [one for one in sorted(unsaid) if one.startswith(f"{key}_")]
            ensure(
                not ends,
                f"figures has {key!r}, and the end of {ends and ends[0]!r} in the report is no "
                f"unit that is known, such as {', '.join(UNITS)}",
            )
            meant = get_close_matches(key, sorted(unsaid), 1, ALIKE)
            ensure(not meant, f"figures has {key!r}, and the report {meant and meant[0]!r}")


def _told(report: Any) -> Iterator[tuple[str, Any]]:
    """Yield all values of a report, of its parts, too, by their keys."""
    entries = [report] if isinstance(report, dict) else report
    for entry in entries if isinstance(entries, list) else ():
        if isinstance(entry, dict):
            for key, value in entry.items():
                yield key, value
                yield from _told(value)


def check_aims(subject: Subject) -> None:
    """Check that tools that aim take no ink, and preview a tap wherever it is."""
    for opened in (subject.shell, subject.drawn):
        with opened() as shell:
            for tool in shell.tools():
                if not tool.aims:
                    continue
                ensure(tool.gesture != "ink", f"the tool {tool.id} aims, so it cannot take ink")
                for camera in odd_cameras():
                    for x, y in ((600.0, 450.0), (-50.0, 2000.0)):
                        shell.preview(Tap(x, y, camera), tool=tool)


def _given() -> tuple[Shapes, ...]:
    """Return a solid, a straight curve, a rational circle and a skeleton, each alone."""
    corners = np.array([[0, 0, 0], [9, 0, 0], [0, 9, 0], [0, 0, 9]], np.float32)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], np.int32)
    straight = Curve(1, np.array([0.0, 0.0, 1.0, 1.0]), np.array([[0.0, 0, 0], [30.0, 5, 9]]))
    square = [[5, 0], [5, 5], [0, 5], [-5, 5], [-5, 0], [-5, -5], [0, -5], [5, -5], [5, 0]]
    around = np.column_stack([np.array(square, float), np.zeros(9)])
    quarter = np.sqrt(0.5)
    circle = Curve(
        2,
        np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], float),
        around,
        np.array([1.0, quarter] * 4 + [1.0]),
        closed=True,
    )
    bone = Skeleton(np.array([[0.0, 0, 0], [9.0, 0, 0]]), np.ones(2), np.array([[0, 1]], np.int32))
    return (
        Shapes(solids=(Solid(Mesh(corners, faces)),)),
        Shapes(curves=(straight,)),
        Shapes(curves=(circle, straight)),
        Shapes(skeletons=(bone,)),
    )


ABILITIES: Final[tuple[Callable[[Subject], None], ...]] = (
    check_commands,
    check_view_advice,
    check_next_step,
    check_curves,
    check_read_shapes,
    check_follow,
    check_pictures,
    check_figures,
    check_aims,
)
"""Further articles for `checks.CHECKS`."""
