"""A person's day before the window: ``python -m tests.reliability.soak --seconds 3600``.

Document after document: draw or bring in, correct, turn the view, drag the sliders, save, export,
close, open again. After each the process is measured; see `monkey` for what is printed.
"""

from __future__ import annotations

import argparse
import itertools
import random
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final

from tests.reliability.stage import Script, Stage, perform

PATIENCE: Final = 10.0
"""Seconds that the person waits for the shape at most."""

DRAG: Final = 12
"""Ticks of a slider that is dragged."""

EXPORTS: Final = (".stl", ".3mf", ".glb", ".obj")


class Person:
    """Works on one document after the other.

    Parameters
    ----------
    stage : Stage
    seconds : float
        How long the day is.
    """

    def __init__(self, stage: Stage, seconds: float) -> None:
        self.stage = stage
        self.chance = random.Random(1)
        self._end = time.monotonic() + seconds
        self._step = 0
        # Events hold a bare pointer to its device: it lives as long as the process.
        self._pen: Any = None

    def script(self) -> Script:
        """The day: at least two documents."""
        infos = [info for info in self.session.registry.modelers() if info.listed]
        for number, info in enumerate(itertools.cycle(infos), 1):
            if number > 2 and time.monotonic() > self._end:
                return
            yield from self._document(info, number)
            yield from self.stage.measure(number)

    @property
    def session(self) -> Any:
        """The session of the window that is open now."""
        return self.stage.window.session

    def _document(self, info: Any, number: int) -> Iterator[float]:
        """Draw one document, or bring it in, correct it, and take it with them."""
        session, window, chance = self.session, self.stage.window, self.chance
        yield self._do("new", session.files.new)
        yield self._do("modeler", lambda: session.toolbox.take_modeler(info.id))
        if info.samples and chance.random() < 0.5:
            sample = chance.choice(info.samples)
            yield self._do("import", lambda: session.files.exchange.import_file(sample))
        for _ in range(chance.randrange(2, 6)):
            yield self._do("draw", self._draw)
        yield self._do("finish", session.gestures.commit)
        yield self._do("fit", window.canvas.views.fit)
        for _ in range(3):
            yield self._do("undo", session.drawing.undo)
            yield self._do("redo", session.drawing.redo)
        yield from self._sliders()
        for view in ("front", "right", "three-quarter"):
            yield self._do("look", lambda view=view: window.canvas.views.look(view))
        yield self._do("turn", self._turn)
        yield self._do("theme", window.toggle_theme)
        saved = self.stage.folder / f"day {number % 6}.bozz"
        yield self._do("save", lambda: session.files.save(saved))
        shapes = self.stage.folder / f"shapes{chance.choice(EXPORTS)}"
        yield self._do("export", lambda: session.files.exchange.export(shapes))
        yield self._do("close", session.files.new)
        yield self._do("open", lambda: session.files.open(saved))
        if number % 5 == 0:
            yield self._do("window", self._reopen)

    def _do(self, name: str, action: Any) -> float:
        self._step += 1
        self.stage.do(self._step, name, action)
        return PATIENCE

    def _draw(self) -> None:
        """A closed outline, or a stroke over what is there, with the pen."""
        from tests.app.tablet import Stylus, circle

        canvas, chance = self.stage.window.canvas, self.chance
        if self._pen is None:
            self._pen = Stylus(canvas)
        self._pen.widget = canvas
        across, down = canvas.width() * chance.uniform(0.3, 0.7), canvas.height() * 0.5
        share, wave = chance.choice(((1.0, 0.0), (1.0, 0.2), (0.4, 0.0)))
        self._pen.draw(circle(across, down, chance.uniform(40, 160), share=share, wave=wave))

    def _reopen(self) -> None:
        """Open another window; the pen lets go of the one before, and of all that it shows."""
        self.stage.open_window()
        if self._pen is not None:
            self._pen.widget = self.stage.window.canvas

    def _sliders(self) -> Iterator[float]:
        """Drag every number of the chosen model to and fro."""
        for field, value in self.session.objects.parameters:
            if field.kind not in ("number", "integer"):
                continue
            for tick in range(DRAG):
                near = value * (1.0 + 0.02 * (tick % 6)) if value else value
                near = round(near) if field.kind == "integer" else near
                self._do(
                    field.name,
                    lambda: self.session.objects.set_parameter(field.name, near, dragging=True),  # noqa: B023
                )
                yield 0.02
            yield self._do("release", self.session.objects.end_drag)

    def _turn(self) -> None:
        """Turn the view once round."""
        from bozzetto.view.navigation import orbit

        for _ in range(30):
            self.session.view.set_camera(orbit(self.session.view.camera, 30.0, 2.0))


def main(arguments: Sequence[str] | None = None) -> int:
    """Work, and print the result; 1 if something went wrong."""
    parser = argparse.ArgumentParser(prog="python -m tests.reliability.soak")
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--log", type=Path, help="a file that names the step under way")
    options = parser.parse_args(arguments)

    def play(stage: Stage) -> dict[str, Any]:
        return stage.run(Person(stage, options.seconds).script())

    perform(play, options.log)
    return 0


if __name__ == "__main__":
    sys.exit(main())
