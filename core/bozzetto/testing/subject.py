"""Subject of the tests: one modeler, and a way to draw something with it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from bozzetto.errors import UserError
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.gesture import Drag, Gesture, Ink, Tap
from bozzetto.plugin.guard.guard import Guard
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.tool import Tool
from bozzetto.testing.headless_shell import Shell
from bozzetto.testing.synthetic_pen import Pen
from bozzetto.view.camera import Camera

TAPS = ((450.0, 350.0), (750.0, 400.0), (600.0, 600.0))
"""Taps of a plain sketch on the sheet, pixels."""

Sketch = Callable[[Shell, Pen], None]


class Broken(AssertionError):
    """The contract is not kept; the message says how."""


def ensure(condition: bool, message: str) -> None:
    """Raise `Broken` unless a condition holds."""
    if not condition:
        raise Broken(message)


def _nobody(_: Guard) -> None:
    pass


@dataclass(frozen=True)
class Subject:
    """A modeler under test.

    Parameters
    ----------
    modeler : str
        Its id.
    packages : tuple of str
        Packages that are not installed but importable.
    sketch : callable
        Draws something that has a solution: ``sketch(shell, pen)``. Pens of different
        seeds must give different states.
    opened : callable
        Told the guard of every program that is opened for a test.
    """

    modeler: str
    packages: tuple[str, ...] = ()
    sketch: Sketch | None = None
    opened: Callable[[Guard], None] = _nobody

    @contextmanager
    def shell(self) -> Iterator[Shell]:
        """Open a fresh program with an empty model of the modeler in it."""
        registry = Registry(extra=self.packages)
        with tempfile.TemporaryDirectory() as folder:
            self.opened(registry.guard)
            shell = Shell(registry, Path(folder))
            shell.open(self.modeler)
            yield shell

    @contextmanager
    def drawn(self, seed: int = 0) -> Iterator[Shell]:
        """Open a fresh program in which something has been drawn."""
        with self.shell() as shell:
            (self.sketch or plain_sketch)(shell, Pen(tremor=0.4, seed=seed))
            yield shell


def plain_sketch(shell: Shell, pen: Pen) -> None:
    """Draw a circle with the first tool for ink, else open the first sample, else tap thrice.

    Where a circle is refused and there is no sample, a line is drawn, and then a line with an arc
    beside it: an edge, a bar, an axis and its profile. If all of them are refused in the front
    view, they are drawn in the view that the modeler calls better. A modeler that takes neither
    ink nor taps and has no sample stays empty.
    """
    info = shell.registry.info(shell.model.modeler)
    takes_ink = any(tool.gesture == "ink" for tool in shell.tools())
    if takes_ink:
        refused: UserError | None = None
        for seen in (pen,) if info.samples else _views(shell, pen):
            shell.camera = seen.camera
            for strokes in plain_drawings(seen)[: 1 if info.samples else None]:
                try:
                    shell.draw(*strokes)
                    return
                except UserError as error:
                    refused = refused or error
        if refused is not None and not info.samples:
            raise refused
    if info.samples:
        from bozzetto.exchange.import_file import read_drawing

        drawing = read_drawing(info.samples[0], trusted=True)
        shell.put(shell.workbench.sources.from_drawing(info.id, drawing, {}).state)
    elif any(tool.gesture == "tap" for tool in shell.tools()):
        for x, y in TAPS:
            touch = pen.along([(x, y), (x + 1.0, y)])
            shell.tap(float(touch.x[0]), float(touch.y[0]))


def _views(shell: Shell, pen: Pen) -> Iterator[Pen]:
    """Yield the pen, and then one that draws in the view which the modeler calls better."""
    yield pen
    advice = shell.advice(pen.camera)
    if advice is not None and advice.better is not None:
        yield pen.but(camera=advice.better.with_viewport(*pen.camera.viewport))


def plain_drawings(pen: Pen) -> tuple[tuple[Stroke, ...], ...]:
    """Return a circle, a line, and a line with an arc beside it."""
    line = pen.along([(600.0, 250.0), (600.0, 650.0)])
    arc = pen.along([(620.0, 260.0), (720.0, 350.0), (740.0, 450.0), (640.0, 640.0)])
    return (pen.circle(),), (line,), (line, arc)


def odd_gestures(shell: Shell, tool: Tool[object]) -> Iterator[tuple[str, Gesture]]:
    """Yield gestures of a tool's kind that no one would make on purpose, each with a name."""
    if tool.gesture == "ink":
        for name, stroke in _odd_strokes():
            yield name, Ink((stroke,), committed=True)
            yield f"{name}, not committed", Ink((stroke,))
        pen = Pen()
        many = tuple(pen.dot(x, x) for x in range(100, 800, 10))
        yield "seventy dots", Ink(many, committed=True)
        yield (
            "two circles, one in the other",
            Ink((pen.circle(radius=300), pen.circle(radius=100)), committed=True),
        )
    elif tool.gesture == "tap":
        for camera in odd_cameras():
            for x, y in ((600.0, 450.0), (0.0, 0.0), (-1e6, 1e6), (1e-9, 1e7)):
                yield f"a tap at {x:g}, {y:g} ({camera.kind})", Tap(x, y, camera)
    else:
        for x, y in ((600.0, 450.0), (-1e6, 1e6)):
            yield f"a tap at {x:g}, {y:g}", Tap(x, y, Camera())
        handles = [handle.id for handle in shell.handles()][:3]
        for handle in [*handles, "", "no such handle"]:
            for name, stroke in _odd_strokes():
                yield f"{name} with the handle {handle!r}", Drag(handle, stroke)


def odd_cameras() -> tuple[Camera, ...]:
    """Return views from which nobody would draw everything, and the usual one."""
    return (
        Camera(),
        Camera("orthographic", eye=(0.0, 0.0, 800.0), up=(0.0, 0.0, 1.0)),
        Camera(eye=(300.0, 400.0, -200.0), target=(10.0, -20.0, 30.0), fov_y=120.0),
    )


def _odd_strokes() -> Iterator[tuple[str, Stroke]]:
    pen = Pen()
    yield "one point", pen.dot()
    camera = pen.camera
    yield "two points", Stroke([500, 700], [400, 500], camera)
    yield "all points equal", Stroke([600] * 50, [450] * 50, camera)
    yield "a tiny circle", pen.circle(radius=1e-3)
    yield "a huge circle", Pen(speed=1e8).circle(radius=1e6)
    yield "a straight line", pen.along([(200, 450), (1000, 450)])
    yield "forth and back", pen.along([(200, 450), (1000, 450), (200, 450)])
    yield "a figure of eight", pen.polygon((300, 300), (900, 600), (900, 300), (300, 600))
    yield "outside the canvas", pen.circle(-5000.0, -5000.0)
    yield "no pressure at all", pen.but(pressure=0.0).circle()
    yield "the eraser", pen.but(tool="eraser").along([(300, 300), (900, 600)])
    yield "a shaking hand", pen.but(tremor=60.0).circle()
    for odd in odd_cameras()[1:]:
        yield f"a circle in another view ({odd.kind})", Pen(odd).circle()
    far = Camera("orthographic", eye=(0.0, -1e11, 0.0), height=1e10)
    yield "a circle in a view of everything", Pen(far).circle()
